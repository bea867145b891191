// The varied parameters of an experiment, and the sample of their values.
import { html, nothing } from '../../../vendor/lit-html.js';
import { plain } from '../../base/format.js';
import { axisAround, draft, fieldOf, listed, ruleOf, variable, variables, write } from './draft.js';
import { valueOf, sentence, number, invalid, parameter } from './fields.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('./draft.js').Axis} Axis */

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
export function axesPanel() {
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
