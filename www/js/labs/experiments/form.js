// The form of an experiment: scenario, axes, fixed values, replicates, metrics; errors appear at the field that the daemon names.
import { html, nothing } from '../../../vendor/lit-html.js';
import { signal } from '../../../vendor/signals-core.js';
import { Problem, call } from '../../base/api.js';
import { plain } from '../../base/format.js';
import { labelOf } from '../../base/schema.js';
import { t } from '../../base/words.js';
import { labs } from '../../session/labs.js';
import { scenarios } from '../../session/state.js';
import { axesPanel } from './axes.js';
import {
  checking,
  choose,
  draft,
  estimate,
  helpOf,
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
import { valueOf, sentence, elsewhere, number, rangeOf, invalid, parameter } from './fields.js';
import { run } from './shown.js';

/** @typedef {import('lit-html').TemplateResult} Template */

/** Experiments of the library. @type {import('@preact/signals-core').Signal<{id: string, title: string, text: string}[]>} */
export const library = signal([]);
const sought = signal('');
const beginning = signal(false);

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
      ${labs.value.map((lab) => group(t(lab.group), lab.kind))}</select></label>
    <button type="button" id="trade"
      title="Error and processor time of every method of the scenario, over its settings"
      ?disabled=${scenario.value === null}
        @click=${() =>
          measure(typeof d.scenario === 'string' && d.scenario !== '' ? d.scenario : scenario.value)}>Work-precision diagram</button>
    ${sentence('scenario')}${unread.value === '' ? nothing : html`<p class="wrong">${unread.value}</p>`}
    ${d.title === '' ? nothing : html`<p class="facts">${d.title}</p>`}</fieldset>`;
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
