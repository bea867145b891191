// The varied parameters of an experiment, and the sample of their values.
import { html, nothing } from '../../../../vendor/lit-html.js';
import { localized, plain } from '../../../base/format.js';
import { language, t, unitName } from '../../../base/words.js';
import { axisAround, draft, fieldOf, listed, scenario, variable, variables, write } from './draft.js';
import { openDrawer } from './drawers.js';
import { helpOf, valueOf, sentence, number, invalid, parameter } from './fields.js';
import { chosenName, wholeName } from './names.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('./draft.js').Axis} Axis */

const AXES_MAX = 20;

/** @param {number} index @param {Partial<Axis>} change */
const setAxis = (index, change) => write({ axes: draft.value.axes.map((axis, i) => (i === index ? { ...axis, ...change } : axis)) });

/** The values of a range, as far as they fit in a line. @param {Axis} axis */
function preview(axis) {
  const unit = variable(axis.path)?.row.unit ?? '',
    inUnit = unit === '' ? '' : ` ${unitName(unit)}`;
  if (axis.list) return t('experiments.values', { n: listed(axis.values).length });
  const from = Number(axis.from),
    to = Number(axis.to),
    count = draft.value.sampling === 'none' ? Number(axis.count) : 0;
  if (!(count >= 1 && Number.isFinite(from) && Number.isFinite(to)) || (axis.log && !(from > 0 && to > 0))) return '';
  const whole = variable(axis.path)?.row.type === 'integer';
  const at = (/** @type {number} */ k) => {
    const share = count > 1 ? k / (count - 1) : 0,
      value = axis.log ? from * (to / from) ** share : from + (to - from) * share;
    return localized(plain(whole ? Math.floor(value + 0.5) : Number(value.toPrecision(4))));
  };
  const shown = Array.from({ length: Math.min(count, 4) }, (_, k) => at(k));
  const all = [...shown, ...(count > 5 ? ['…'] : []), ...(count > 4 ? [at(count - 1)] : [])];
  return all.join(language.value === 'en' ? ', ' : '; ') + inUnit;
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
  return html`<div class="tried" role="group"
    aria-label=${t('experiments.axis.values', { n: i + 1 })}>${choices.map(
      (choice) => html`<label class="toggle"><input type="checkbox"
      data-choice=${`${i}.${choice}`} .checked=${on.includes(choice)}
    @change=${() => toggle(choice)}><span>${chosenName(axis.path, choice, scenario.value)}</span></label>`,
    )}</div>`;
}

/** How the values of an axis of numbers are given. @param {Axis} axis @param {number} i @returns {Template} */
function rangeOrList(axis, i) {
  const range = () => setAxis(i, { list: false }),
    list = () => setAxis(i, { list: true, values: axis.values || `${axis.from}, ${axis.to}` });
  return html`<div class="units" role="group" aria-label=${t('experiments.axis.values', { n: i + 1 })}>
      <button type="button" aria-pressed=${String(!axis.list)} @click=${range}>${t('experiments.range')}</button><button
        type="button" aria-pressed=${String(axis.list)} @click=${list}>${t('experiments.list')}</button></div>`;
}

/** @param {Axis} axis @param {number} i @returns {Template} */
function axisPanel(axis, i) {
  const field = fieldOf(i),
    row = variable(axis.path)?.row,
    sampled = draft.value.sampling !== 'none',
    n = i + 1;
  const numeric = row?.type === 'number' || row?.type === 'integer' || row === undefined;
  const choices =
    axis.joined || draft.value.axes[i + 1]?.joined
      ? []
      : row?.type === 'boolean'
        ? ['false', 'true']
        : (row?.choices ?? []); /* what goes together may be named twice */
  const input = (/** @type {'from' | 'to' | 'count' | 'levels' | 'values'} */ key, /** @type {string} */ width) => {
    const label = t(key === 'levels' ? 'experiments.axis.of.values' : `experiments.axis.of.${key}`);
    const bad = invalid(`${field}.${key === 'levels' ? 'count' : key}`, field);
    return html`<label class="field ${width}"><span>${label}</span><input data-axis=${`${i}.${key}`} autocomplete="off"
      inputmode=${key === 'values' ? 'text' : 'decimal'} placeholder=${key === 'levels' ? t('experiments.any') : ''}
      aria-label=${t('experiments.axis.field', { name: label, n })} aria-invalid=${bad.is} aria-describedby=${bad.by}
      .value=${axis[key]} @input=${(/** @type {Event} */ event) => setAxis(i, { [key]: valueOf(event) })}></label>`;
  };
  return html`<fieldset class="axis" data-axis-field=${field} data-axis-place=${i}
    tabindex="-1"><legend class="unseen">${t('experiments.axis', { n })}</legend>
    <div class="head">${parameter(
      axis.path,
      t('experiments.axis.parameter', { n }),
      (path) => setAxis(i, { ...axisAround(path), joined: axis.joined }),
      invalid(`${field}.path`, field),
    )}
      <button type="button" class="small" aria-label=${t('experiments.axis.remove', { n })}
        @click=${() => write({ axes: draft.value.axes.filter((_, k) => k !== i) })}>${t('experiments.remove')}</button></div>
    ${numeric ? rangeOrList(axis, i) : nothing}
    ${
      choices.length > 0
        ? choicesOf(axis, i, choices)
        : axis.list || !numeric
          ? input('values', 'whole')
          : html`<div class="range">${input('from', '')}${input('to', '')}${sampled ? input('levels', '') : input('count', '')}
      <label class="toggle"><input type="checkbox" .checked=${axis.log} aria-label=${t('experiments.axis.logarithmic', { n })}
        @change=${() => setAxis(i, { log: !axis.log })}><span>log</span></label></div>`
    }
    ${
      i > 0
        ? html`<label class="toggle"><input type="checkbox" .checked=${axis.joined}
      @change=${() => setAxis(i, { joined: !axis.joined })}><span>${t('experiments.axis.together')}</span></label>`
        : nothing
    }
    <p class="facts" title=${axis.path}>${wholeName(axis.path, row?.unit, scenario.value)}: ${preview(axis)}${
      row && (row.type === 'number' || row.type === 'integer')
        ? html` <small>${t('experiments.from_to', { from: localized(plain(row.min)), to: localized(plain(row.max)) })}</small>`
        : nothing
    }</p>
    ${sentence(field)}</fieldset>`;
}

/** How points are drawn, in the order of the list. */
const SAMPLINGS = ['none', 'sobol', 'lhs', 'random', 'saltelli'];

/** Axes that go together are one. */
const dimensions = () => draft.value.axes.filter((axis, i) => i === 0 || !axis.joined).length;

/** What the count makes. @returns {string} */
function sampleFacts() {
  const { sampling, points } = draft.value,
    n = Number(points),
    d = dimensions();
  if (!Number.isInteger(n) || n < 1) return '';
  const two = Number.isInteger(Math.log2(n)) ? '' : t('experiments.sample.two');
  const count = (/** @type {number} */ one) => one.toLocaleString(language.value);
  if (sampling === 'saltelli') return t('experiments.sample.saltelli', { n: d, base: count(n), points: count(n * (d + 2)) }) + two;
  if (sampling === 'lhs') return t('experiments.sample.lhs', { n, part: count(n) });
  return sampling === 'sobol' ? t('experiments.sample.sobol', { n: count(n) }) + two : t('experiments.sample.random', { n: count(n) });
}

/** @returns {Template} */
function samplePanel() {
  const d = draft.value,
    bad = invalid('sample', 'sample');
  const choice = html`<label class="field choice"><span>${t('experiments.points')}</span><select id="sampling"
    aria-invalid=${bad.is} aria-describedby=${bad.by} title=${helpOf('sample.method')}
    @change=${(/** @type {Event} */ event) => write({ sampling: valueOf(event) })}>
    ${SAMPLINGS.map(
      (value) => html`<option value=${value}
      .selected=${value === d.sampling}>${t(`experiments.sampling.${value}`)}</option>`,
    )}</select></label>`;
  if (d.sampling === 'none') return html`${choice}${sentence('sample')}`;
  return html`${choice}<div class="numbers">
      ${number({
        id: 'points',
        field: 'sample.count',
        messageOf: 'sample',
        label: t(d.sampling === 'saltelli' ? 'experiments.base_samples' : 'experiments.number_of_points'),
        value: d.points,
        take: (points) => write({ points }),
      })}
      ${number({
        id: 'sample-seed',
        field: 'sample.seed',
        messageOf: 'sample',
        label: t('experiments.seed'),
        value: d.seed,
        hint: '1',
        take: (seed) => write({ seed }),
      })}</div>
    <p class="facts" id="sample-facts">${sampleFacts()}. ${t('experiments.sample.range')}</p>
    ${sentence('sample')}`;
}

/** A number that is not varied yet. */
const free = () => variables.value.find((one) => one.row.type === 'number' && !draft.value.axes.some((axis) => axis.path === one.path));

/** Another axis, which is shown. */
export function addAxis() {
  const { axes } = draft.value,
    found = free();
  if (!found || axes.length >= AXES_MAX) return;
  write({ axes: [...axes, axisAround(found.path)] });
  openDrawer('settings', `[data-axis-place="${axes.length}"]`);
}

/** @returns {Template} */
export function axesPanel() {
  const d = draft.value;
  return html`<fieldset class="panel server"><legend class="unseen">${t('experiments.axes')}</legend>
    <div class="head"><h2>${t('experiments.varied')}</h2>
      <button type="button" class="small" id="add-axis" ?disabled=${!free() || d.axes.length >= AXES_MAX}
        @click=${addAxis}>${t('experiments.axis.add')}</button></div>
    ${d.axes.length === 0 ? html`<p class="facts">${t('experiments.axes.none')}</p>` : d.axes.map(axisPanel)}
    ${samplePanel()}</fieldset>`;
}
