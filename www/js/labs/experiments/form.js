// The form of an experiment: scenario, axes, fixed values, replicates, metrics; errors appear at the field that the daemon names.
import { html, nothing } from '../../../vendor/lit-html.js';
import { signal } from '../../../vendor/signals-core.js';
import { Problem, call } from '../../base/api.js';
import { plain } from '../../base/format.js';
import { labelOf } from '../../base/schema.js';
import { scenarios } from '../../session/state.js';
import {
  axisAround,
  checking,
  choose,
  draft,
  estimate,
  fieldOf,
  helpOf,
  listed,
  measure,
  metrics,
  own,
  refuse,
  refused,
  ruleOf,
  scenario,
  specification,
  start,
  unread,
  variable,
  variables,
  write,
} from './draft.js';
import { run } from './shown.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('./draft.js').Axis} Axis */

/** Experiments of the library. @type {import('@preact/signals-core').Signal<{id: string, title: string, text: string}[]>} */
export const library = signal([]);
const sought = signal('');
const beginning = signal(false);

const valueOf = (/** @type {Event} */ event) => /** @type {HTMLInputElement | HTMLSelectElement} */ (event.target).value;

// ---- errors ----

/** The sentence about a field, or about one below it. @param {string} field */
function wrong(field) {
  for (const [at, detail] of refused.value) if (at === field || at.startsWith(`${field}.`)) return detail;
  return '';
}
const idOf = (/** @type {string} */ field) => `wrong-${field.replaceAll('.', '-')}`;

/** @param {string} field */
function sentence(field) {
  const detail = wrong(field);
  return detail === '' ? nothing : html`<p class="wrong" id=${idOf(field)}>${detail}</p>`;
}

/** The error message of no field of this form. */
function elsewhere() {
  const d = draft.value;
  const places = [
    'scenario',
    'sample',
    'repeats',
    'until',
    'metrics',
    'error',
    'cost',
    'front',
    ...d.axes.map((_, i) => fieldOf(i)),
    ...d.fixed.map((one) => `set.${one.path}`),
  ];
  return [...refused.value]
    .filter(([field]) => !places.some((place) => field === place || field.startsWith(`${place}.`)))
    .map(([, detail]) => detail);
}

/** One line of text whose range and help are the schema's. @param {{id: string, field: string, label: string, value: string, messageOf?: string,
 *   hint?: string, take: (text: string) => void}} of  field: as the daemon names it;
 * messageOf: the field whose message is shown; hint: where empty
 * @returns {Template} */
function number({ id, field, label, value, messageOf = field, hint = '', take }) {
  const bad = invalid(field, messageOf),
    row = ruleOf(field);
  return html`<label class="field" title=${row?.help ?? nothing}><span>${label}</span><input id=${id} class="narrow" inputmode="decimal"
    autocomplete="off" placeholder=${hint} .value=${value} aria-invalid=${bad.is} aria-describedby=${bad.by}
    @input=${(/** @type {Event} */ event) => take(valueOf(event))}></label>`;
}

/** Allowed values of a field of the specification, from the schema. @param {string} field @returns {string} */
function rangeOf(field) {
  const row = ruleOf(field);
  return row ? `${plain(row.min)} to ${row.max >= 1e6 ? 'any' : plain(row.max)}` : '';
}

/** Marks a control as wrong. @param {string} field @param {string} [messageOf] the field whose message is shown */
const invalid = (field, messageOf = field) => (wrong(field) === '' ? { is: 'false', by: nothing } : { is: 'true', by: idOf(messageOf) });

// ---- the scenario ----

/** @returns {Template} */
function scenarioPanel() {
  const d = draft.value,
    now = typeof d.scenario === 'string' ? d.scenario : '',
    bad = invalid('scenario');
  const group = (/** @type {string} */ label, /** @type {string} */ kind) => {
    const rows = scenarios.value.filter((row) => row.kind === kind);
    return rows.length === 0
      ? nothing
      : html`<optgroup label=${label}>${rows.map(
          (row) => html`<option value=${row.id} .selected=${row.id === now}>${row.paper ? `${row.paper}: ` : ''}${row.title}</option>`,
        )}</optgroup>`;
  };
  return html`<fieldset class="panel server"><legend class="unseen">Scenario</legend><div class="head"><h2>Scenario</h2></div>
    <label class="field choice"><span>Start from</span><select id="library" @change=${async (/** @type {Event} */ event) => {
      const id = valueOf(event);
      if (id !== '') start(await call('GET', `scenarios/${id}`));
    }}><option value="">an experiment of the library</option>${library.value.map(
      (one) => html`<option
      value=${one.id}>${one.title}</option>`,
    )}</select></label>
    <label class="field choice"><span>Scenario</span><select id="of" aria-invalid=${bad.is} aria-describedby=${bad.by}
      @change=${(/** @type {Event} */ event) => choose(valueOf(event))}>
      ${now === '' ? html`<option value="" selected disabled>${scenario.value?.title || 'as the experiment has it'}</option>` : nothing}
      ${group('Games', 'netgame')}${group('Motion', 'motion')}${group('Rigid bodies', 'rigid')}${group('Fluids', 'fluid')}</select></label>
    <button type="button" id="trade"
      title="Error and processor time of every method of the scenario, over its settings"
      ?disabled=${scenario.value === null}
        @click=${() =>
          measure(typeof d.scenario === 'string' && d.scenario !== '' ? d.scenario : scenario.value)}>Work-precision diagram</button>
    ${sentence('scenario')}${unread.value === '' ? nothing : html`<p class="wrong">${unread.value}</p>`}
    ${d.title === '' ? nothing : html`<p class="facts">${d.title}</p>`}</fieldset>`;
}

// ---- parameters ----

/** @param {string} path @returns {string} */
const ownerOf = (path) => path.slice(0, Math.max(0, path.lastIndexOf('.')));

/** @param {string} owner @returns {string} */
function placeOf(owner) {
  if (owner === '') return 'Scenario';
  const words = owner
    .replace(/players\.(\d+)/, (_, p) => `player ${scenario.value?.players?.[p]?.name ?? String.fromCharCode(65 + Number(p))}`)
    .replace(/methods\.(\d+)/, (_, m) => `method ${Number(m) + 1}`)
    .replaceAll('.', ' › ')
    .replaceAll('_', ' ');
  return words.charAt(0).toUpperCase() + words.slice(1);
}

/** A choice of parameters.
 * @param {string} now
 * @param {string} name
 * @param {(path: string) => void} take
 * @param {{is: string, by: unknown}} bad */
function parameter(now, name, take, bad) {
  /** @type {Map<string, import('./draft.js').Variable[]>} */
  const groups = new Map();
  for (const one of variables.value) groups.set(ownerOf(one.path), [...(groups.get(ownerOf(one.path)) ?? []), one]);
  return html`<select class="parameter" aria-label=${name} aria-invalid=${bad.is} aria-describedby=${bad.by}
    @change=${(/** @type {Event} */ event) => take(valueOf(event))}>
    ${variable(now) ? nothing : html`<option value=${now} selected>${now === '' ? 'choose' : now}</option>`}
    ${[...groups].map(
      ([owner, list]) => html`<optgroup
      label=${placeOf(owner)}>${list.map(
        ({ path, row }) =>
          html`<option value=${path} .selected=${path === now}>${labelOf(path)}${row.unit ? ` (${row.unit})` : ''}</option>`,
      )}</optgroup>`,
    )}</select>`;
}

// ---- axes ----

const AXES_MAX = 20;

/** @param {number} index @param {Partial<Axis>} change */
const setAxis = (index, change) => write({ axes: draft.value.axes.map((axis, i) => (i === index ? { ...axis, ...change } : axis)) });

/** The values of a range, as far as they fit in a line. @param {Axis} axis */
function preview(axis) {
  const unit = variable(axis.path)?.row.unit ?? '',
    inUnit = unit === '' ? '' : ` ${unit}`;
  if (axis.list) return `${listed(axis.values).length} values${unit === '' ? '' : ` in ${unit}`}`;
  const from = Number(axis.from),
    to = Number(axis.to),
    count = draft.value.sampling === 'none' ? Number(axis.count) : 0;
  if (!(count >= 1 && Number.isFinite(from) && Number.isFinite(to)) || (axis.log && !(from > 0 && to > 0))) return '';
  const whole = variable(axis.path)?.row.type === 'integer';
  const at = (/** @type {number} */ k) => {
    const share = count > 1 ? k / (count - 1) : 0,
      value = axis.log ? from * (to / from) ** share : from + (to - from) * share;
    return plain(whole ? Math.floor(value + 0.5) : Number(value.toPrecision(4)));
  };
  const shown = Array.from({ length: Math.min(count, 4) }, (_, k) => at(k));
  return `${shown.join(', ')}${count > 5 ? ', …' : ''}${count > 4 ? `, ${at(count - 1)}` : ''}${inUnit}`;
}

/** Those of a few values that are tried. @param {Axis} axis @param {number} i @param {string[]} choices @returns {Template} */
function choicesOf(axis, i, choices) {
  const on = listed(axis.values);
  const toggle = (/** @type {string} */ choice) =>
    setAxis(i, {
      list: true,
      values: (on.includes(choice) ? on.filter((one) => one !== choice) : choices.filter((one) => one === choice || on.includes(one))).join(
        ', ',
      ),
    });
  const words = (/** @type {string} */ choice) => (choice === 'true' ? 'on' : choice === 'false' ? 'off' : choice.replaceAll('_', ' '));
  return html`<div class="tried" role="group"
    aria-label=${`Values of axis ${i + 1}`}>${choices.map(
      (choice) => html`<label class="toggle"><input type="checkbox"
      data-choice=${`${i}.${choice}`} .checked=${on.includes(choice)}
    @change=${() => toggle(choice)}><span>${words(choice)}</span></label>`,
    )}</div>`;
}

/** @param {Axis} axis @param {number} i @returns {Template} */
function axisPanel(axis, i) {
  const field = fieldOf(i),
    row = variable(axis.path)?.row,
    sampled = draft.value.sampling !== 'none',
    name = `axis ${i + 1}`;
  const numeric = row?.type === 'number' || row?.type === 'integer' || row === undefined;
  const choices =
    axis.joined || draft.value.axes[i + 1]?.joined
      ? []
      : row?.type === 'boolean'
        ? ['false', 'true']
        : (row?.choices ?? []); /* what goes together may be named twice */
  const input = (
    /** @type {'from' | 'to' | 'count' | 'levels' | 'values'} */ key,
    /** @type {string} */ label,
    /** @type {string} */ width,
  ) => {
    const bad = invalid(`${field}.${key === 'levels' ? 'count' : key}`, field);
    return html`<label class="field ${width}"><span>${label}</span><input data-axis=${`${i}.${key}`}
      inputmode=${key === 'values' ? 'text' : 'decimal'} autocomplete="off" placeholder=${key === 'levels' ? 'any' : ''} .value=${axis[key]}
      aria-label=${`${label} of ${name}`} aria-invalid=${bad.is} aria-describedby=${bad.by}
        @input=${(/** @type {Event} */ event) => setAxis(i, { [key]: valueOf(event) })}></label>`;
  };
  return html`<fieldset class="axis" data-axis-field=${field}><legend class="unseen">Axis ${i + 1}</legend>
    <div class="head">${parameter(
      axis.path,
      `Parameter of ${name}`,
      (path) => setAxis(i, { ...axisAround(path), joined: axis.joined }),
      invalid(`${field}.path`, field),
    )}
      <button type="button" class="small" aria-label=${`Remove ${name}`}
        @click=${() => write({ axes: draft.value.axes.filter((_, k) => k !== i) })}>Remove</button></div>
    ${
      numeric
        ? html`<div class="units" role="group" aria-label=${`Values of ${name}`}>
      <button type="button" aria-pressed=${String(!axis.list)} @click=${() => setAxis(i, { list: false })}>Range</button><button
        type="button" aria-pressed=${String(axis.list)}
          @click=${() => setAxis(i, { list: true, values: axis.values || `${axis.from}, ${axis.to}` })}>List</button></div>`
        : nothing
    }
    ${
      choices.length > 0
        ? choicesOf(axis, i, choices)
        : axis.list || !numeric
          ? input('values', 'Values', 'whole')
          : html`<div class="range">${input('from', 'From', '')}${input('to', 'To', '')}${
              sampled ? input('levels', 'Values', '') : input('count', 'Count', '')
            }
      <label class="toggle"><input type="checkbox" .checked=${axis.log} aria-label=${`Logarithmic steps of ${name}`}
        @change=${() => setAxis(i, { log: !axis.log })}><span>log</span></label></div>`
    }
    ${
      i > 0
        ? html`<label class="toggle"><input type="checkbox" .checked=${axis.joined}
      @change=${() => setAxis(i, { joined: !axis.joined })}><span>Together with the axis above</span></label>`
        : nothing
    }
    <p class="facts">${axis.path}: ${preview(axis)}${
      row && (row.type === 'number' || row.type === 'integer') ? html` <small>${plain(row.min)} to ${plain(row.max)}</small>` : nothing
    }</p>
    ${sentence(field)}</fieldset>`;
}

/** How points are drawn, in the order of the list. */
const SAMPLINGS = /** @type {[string, string][]} */ ([
  ['none', 'all combinations'],
  ['sobol', 'Sobol sequence'],
  ['lhs', 'Latin hypercube'],
  ['random', 'at random'],
  ['saltelli', 'for sensitivity indices (Saltelli)'],
]);

/** Axes that go together are one. */
const dimensions = () => draft.value.axes.filter((axis, i) => i === 0 || !axis.joined).length;

/** What the count makes. @returns {string} */
function sampleFacts() {
  const { sampling, points } = draft.value,
    n = Number(points),
    d = dimensions();
  if (!Number.isInteger(n) || n < 1) return '';
  const two = Number.isInteger(Math.log2(n)) ? '' : '; a power of two is more even';
  if (sampling === 'saltelli') {
    return `${n} base samples × (${d} ${d === 1 ? 'axis' : 'axes'} + 2) = ${(n * (d + 2)).toLocaleString('en')} points${two}`;
  }
  if (sampling === 'lhs') return `each ${n === 1 ? 'axis' : `${n.toLocaleString('en')}th of each axis`} has one point`;
  return sampling === 'sobol' ? `${n.toLocaleString('en')} points${two}` : `${n.toLocaleString('en')} independent points`;
}

/** @returns {Template} */
function samplePanel() {
  const d = draft.value,
    bad = invalid('sample', 'sample');
  const choice = html`<label class="field choice"><span>Points</span><select id="sampling" aria-invalid=${bad.is} aria-describedby=${bad.by}
    title=${ruleOf('sample.method')?.help ?? nothing} @change=${(/** @type {Event} */ event) => write({ sampling: valueOf(event) })}>
    ${SAMPLINGS.map(
      ([value, label]) => html`<option value=${value}
      .selected=${value === d.sampling}>${label}</option>`,
    )}</select></label>`;
  if (d.sampling === 'none') return html`${choice}${sentence('sample')}`;
  return html`${choice}<div class="numbers">
      ${number({
        id: 'points',
        field: 'sample.count',
        messageOf: 'sample',
        label: d.sampling === 'saltelli' ? 'Base samples' : 'Number of points',
        value: d.points,
        take: (points) => write({ points }),
      })}
      ${number({
        id: 'sample-seed',
        field: 'sample.seed',
        messageOf: 'sample',
        label: 'Seed',
        value: d.seed,
        hint: '1',
        take: (seed) => write({ seed }),
      })}</div>
    <p class="facts" id="sample-facts">${sampleFacts()}. A range with a number of values has these alone, each as often.</p>
    ${sentence('sample')}`;
}

/** @returns {Template} */
function axesPanel() {
  const d = draft.value,
    free = variables.value.find((one) => one.row.type === 'number' && !d.axes.some((axis) => axis.path === one.path));
  return html`<fieldset class="panel server"><legend class="unseen">Axes</legend><div class="head"><h2>Varied</h2>
      <button type="button" class="small" id="add-axis" ?disabled=${!free || d.axes.length >= AXES_MAX}
        @click=${() => {
          if (free) write({ axes: [...d.axes, axisAround(free.path)] });
        }}>Add an axis</button></div>
    ${d.axes.length === 0 ? html`<p class="facts">No axes: one point.</p>` : d.axes.map(axisPanel)}
    ${samplePanel()}</fieldset>`;
}

// ---- fixed values, replicates ----

const LIMIT = '100'; /* repeats: one run alone has no mean */

function toggleUntil() {
  const d = draft.value,
    on = !d.until.on;
  write({ until: { ...d.until, on }, repeats: on && Number(d.repeats) < Number(d.until.least) ? LIMIT : d.repeats });
}

/** Runs of a point until its mean is known. @returns {Template} */
function untilPanel() {
  const d = draft.value,
    { until } = d,
    set = (/** @type {Partial<import('./draft.js').Until>} */ change) => write({ until: { ...until, ...change } });
  const bad = invalid('until.metric', 'until');
  const toggle = html`<label class="toggle" title=${ruleOf('until')?.help ?? nothing}><input type="checkbox" id="until" .checked=${until.on}
    @change=${toggleUntil}><span>Stop when the mean is known</span></label>`;
  if (!until.on) return html`${toggle}${sentence('until')}`;
  return html`${toggle}<div class="until" role="group" aria-label="When a point has enough runs">
    <label class="field choice"><span>Mean of</span><select id="until-metric" aria-invalid=${bad.is} aria-describedby=${bad.by}
      @change=${(/** @type {Event} */ event) => set({ metric: valueOf(event) })}><option
        value="">the error: ${d.error || (d.metrics[0] ?? 'none')}</option>
      ${d.metrics.map((path) => html`<option value=${path} .selected=${path === until.metric}>${path}</option>`)}</select></label>
    ${number({
      id: 'until-relative',
      field: 'until.relative',
      messageOf: 'until',
      label: 'Half width of the 95 % interval, over the mean',
      value: until.relative,
      hint: 'no rule',
      take: (relative) => set({ relative }),
    })}
    ${number({
      id: 'until-half',
      field: 'until.half_width',
      messageOf: 'until',
      label: 'or in its own unit',
      value: until.half,
      hint: 'no rule',
      take: (half) => set({ half }),
    })}
    ${number({
      id: 'until-least',
      field: 'until.least',
      messageOf: 'until',
      label: 'Minimum of runs',
      value: until.least,
      take: (least) => set({ least }),
    })}
    <p class="facts">Checked after the minimum of runs, and after each doubling.
      <small>over the mean ${rangeOf('until.relative')}; runs ${rangeOf('until.least')}</small></p></div>${sentence('until')}`;
}

/** @returns {Template} */
function fixedPanel() {
  const d = draft.value,
    bad = invalid('repeats');
  const set = (/** @type {number} */ i, /** @type {Partial<import('./draft.js').Fixed>} */ change) =>
    write({ fixed: d.fixed.map((one, k) => (k === i ? { ...one, ...change } : one)) });
  const free = () =>
    ['duration_s', ...variables.value.map((one) => one.path)].find((path) => variable(path) && !d.fixed.some((one) => one.path === path)) ??
    '';
  return html`<fieldset class="panel server"><legend class="unseen">Fixed</legend><div class="head"><h2>Fixed</h2>
      <button type="button" class="small"
        @click=${() => {
          const path = free();
          write({ fixed: [...d.fixed, { path, value: String(own(path) ?? '') }] });
        }}>Add a value</button></div>
    ${d.fixed.map((one, i) => {
      const wrongHere = invalid(`set.${one.path}`);
      return html`<div class="fixed">${parameter(
        one.path,
        `Fixed parameter ${i + 1}`,
        (path) => set(i, { path, value: String(own(path) ?? '') }),
        wrongHere,
      )}
        <input class="narrow" autocomplete="off" aria-label=${`Value of ${labelOf(one.path)}`} aria-invalid=${wrongHere.is}
          aria-describedby=${wrongHere.by} .value=${one.value}
          @input=${(/** @type {Event} */ event) => set(i, { value: valueOf(event) })}>
        <button type="button" class="small" aria-label=${`Remove ${labelOf(one.path)}`}
          @click=${() => write({ fixed: d.fixed.filter((_, k) => k !== i) })}>Remove</button></div>${sentence(`set.${one.path}`)}`;
    })}
    <label class="field"><span>${d.until.on ? 'Maximum of replicates' : 'Replicates per point'}</span><input id="repeats"
      class="narrow" inputmode="numeric" autocomplete="off" .value=${d.repeats} aria-invalid=${bad.is} aria-describedby=${bad.by}
      @input=${(/** @type {Event} */ event) => write({ repeats: valueOf(event) })}></label>
    ${sentence('repeats')}${untilPanel()}</fieldset>`;
}

// ---- metrics ----

const SHOWN_METRICS = 40;
const FRONT = 'Two metrics or more, by magnitude; the report and the table mark their front';

/** @param {string} path */
function toggleMetric(path) {
  const d = draft.value,
    there = d.metrics.includes(path);
  const next = there ? d.metrics.filter((one) => one !== path) : [...d.metrics, path];
  const left = (/** @type {string} */ one) => (next.includes(one) ? one : '');
  write({
    metrics: next,
    error: left(d.error),
    cost: left(d.cost),
    front: d.front.filter((one) => next.includes(one)),
    until: { ...d.until, metric: left(d.until.metric) },
  });
}

/** The metrics of the front, in the order of the metrics. @param {string} path */
function toggleFront(path) {
  const d = draft.value,
    on = d.front.includes(path);
  write({ front: d.metrics.filter((one) => (one === path ? !on : d.front.includes(one))) });
}

/** @returns {Template} */
function frontPanel() {
  const d = draft.value;
  return html`<div class="frontof" role="group" aria-label="Front of"><p
    title=${FRONT}>Front of ${
      d.front.length === 0
        ? html`<small>error and cost, unless
      others are ticked</small>`
        : html`<small>${
            d.front.length === 1
              ? 'one metric: tick another'
              : `${d.front.length} metrics: no other point is as good in all and better in one`
          }</small>`
    }</p>
    ${d.metrics.map(
      (path) => html`<label class="toggle"><input type="checkbox" data-front=${path} .checked=${d.front.includes(path)}
      @change=${() => toggleFront(path)}><span>${path}</span></label>`,
    )}${sentence('front')}</div>`;
}

/** @returns {Template} */
function metricsPanel() {
  const d = draft.value,
    words = sought.value
      .toLowerCase()
      .split(/\s+/)
      .filter((word) => word !== '');
  const found = metrics.value.filter(
    (path) => !d.metrics.includes(path) && words.every((word) => `${path} ${helpOf(path)}`.toLowerCase().includes(word)),
  );
  const item = (
    /** @type {string} */ path,
    /** @type {number} */ i,
  ) => html`<label class="toggle" title=${helpOf(path) || nothing}><input type="checkbox"
    data-metric=${path} .checked=${d.metrics.includes(path)}
    aria-invalid=${invalid(`metrics.${i}`).is} @change=${() => toggleMetric(path)}><span>${path}</span></label>`;
  const trade = (
    /** @type {'error' | 'cost'} */ side,
    /** @type {string} */ label,
  ) => html`<label class="field choice"><span>${label}</span><select id=${side}
      @change=${(/** @type {Event} */ event) => write({ [side]: valueOf(event) })}>
    <option value="">${d.metrics[side === 'error' ? 0 : 1] ?? 'none'}</option>${d.metrics.slice(0).map(
      (path) => html`<option value=${path}
        .selected=${path === d[side]}>${path}</option>`,
    )}</select></label>`;
  return html`<fieldset class="panel server metrics"><legend class="unseen">Metrics</legend><div
    class="head"><h2>Metrics</h2><small>${d.metrics.length} of ${metrics.value.length}</small></div>
    <div class="chosen">${d.metrics.map(item)}</div>${sentence('metrics')}
    <label class="field"><span>Find</span><input id="find-metric" type="search" autocomplete="off" .value=${sought.value}
      @input=${(/** @type {Event} */ event) => {
        sought.value = valueOf(event);
      }}></label>
    <div class="offered" tabindex="0" role="group"
      aria-label="Metrics of the scenario">${found.slice(0, SHOWN_METRICS).map((path) => item(path, -1))}
      ${found.length > SHOWN_METRICS ? html`<p class="facts">and ${found.length - SHOWN_METRICS} more: search by name</p>` : nothing}</div>
    ${trade('error', 'Error')}${sentence('error')}${trade('cost', 'Cost')}${sentence('cost')}
    ${d.metrics.length > 1 ? frontPanel() : nothing}</fieldset>`;
}

// ---- the order ----

/** @param {number} seconds */
function duration(seconds) {
  if (seconds < 1) return 'less than a second';
  if (seconds < 120) return `${Math.round(seconds)} s`;
  return seconds < 7200 ? `${Math.round(seconds / 60)} min` : `${plain(Number((seconds / 3600).toPrecision(3)))} h`;
}

async function order() {
  beginning.value = true;
  try {
    const d = draft.value;
    await run(specification(d), d.title || scenario.value?.title || 'Experiment');
    document.querySelector('.sweeps .drawings')?.scrollIntoView({ block: 'nearest' });
  } catch (error) {
    refuse(error);
    if (!(error instanceof Problem)) throw error;
  } finally {
    beginning.value = false;
  }
}

/** @returns {Template} */
function orderPanel() {
  const e = estimate.value,
    many = (/** @type {number} */ n, /** @type {string} */ word) => `${n.toLocaleString('en')} ${word}${n === 1 ? '' : 's'}`;
  return html`<div class="order"><div
    id="estimate">${
      e
        ? html`<b>${many(e.runs, 'run')}</b> of ${many(e.points, 'point')}, about ${duration(e.estimated_cpu_s)} of one core`
        : checking.value
          ? 'counting'
          : refused.value.size > 0
            ? 'not yet complete'
            : 'counting'
    }</div>
    ${elsewhere().map((detail) => html`<p class="wrong">${detail}</p>`)}
    <button type="button" id="run" class="primary" ?disabled=${beginning.value || e === null} @click=${order}>Run</button></div>`;
}

/** @returns {Template} */
export function form() {
  return html`<form class="methods" aria-label="Runs" @submit=${(/** @type {Event} */ event) => event.preventDefault()}>
    <div class="fields" tabindex="0" role="group"
      aria-label="Specification">${scenarioPanel()}${axesPanel()}${fixedPanel()}${metricsPanel()}</div>${orderPanel()}</form>`;
}
