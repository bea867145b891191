// The windows of an experiment: parts of its runs, from one time to another or while a condition holds, and the metrics in them.
import { html, nothing } from '../../../../vendor/lit-html.js';
import { t } from '../../../base/words.js';
import { draft, metricAt, own, scenario, traced } from './draft.js';
import { invalid, number, sentence, valueOf } from './fields.js';
import { addPart, changePart, removePart, toggleMetric } from './kept.js';
import { columnName, columnOwner, metricName } from './names.js';
import { LENGTH, PARTS_MAX, bareOf, isWindowed, newPart, partName, windowOf } from './parts.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('./parts.js').Part} Part */

/** @param {string} path */
const rowOf = (path) => metricAt(scenario.value?.kind, path);
/** @param {string} path of a metric, without a window */
const named = (path) => metricName(path, rowOf(path)?.unit, scenario.value);
/** @param {string} column of the trace */
const columnNamed = (column) => columnName(column, scenario.value, (path) => rowOf(path)?.unit);

/** Those of whole runs that are chosen and can be taken in a window. */
const offered = () => draft.value.metrics.filter((path) => windowOf(path) === '' && isWindowed(path, rowOf(path)));

/** The second half, where mostly everything has settled. */
const half = () => {
  const fixed = draft.value.fixed.find(({ path }) => path === 'duration_s')?.value,
    whole = Number(fixed ?? own('duration_s'));
  return whole > 0 ? whole / 2 : 0;
};

/** A yes or no of the trace counts as 1 or 0. @param {string} column */
const isFlag = (column) => /_(?:connected|(?:up|down)_blackout)$/.test(column);

/** @param {Part} part @param {number} i @returns {Template} */
function condition(part, i) {
  const field = `windows.${i}`,
    bad = invalid(`${field}.while.value`, field);
  /** @type {Map<string, string[]>} */
  const groups = new Map();
  for (const column of traced.value) {
    const owner = columnOwner(column, scenario.value);
    groups.set(owner, [...(groups.get(owner) ?? []), column]);
  }
  const take = (/** @type {string} */ value) =>
    changePart(i, { value, ...(isFlag(value) && part.above === '' && part.below === '' ? { above: '0' } : {}) });
  const bound = (/** @type {'above' | 'below'} */ key) =>
    number({
      id: `window-${i}-${key}`,
      field: `${field}.while.${key}`,
      messageOf: field,
      label: t(`experiments.window.${key}`),
      value: part[key],
      hint: t('experiments.any'),
      take: (text) => changePart(i, { [key]: text }),
    });
  return html`<div class="until" role="group" aria-label=${t('experiments.window.condition', { name: part.name })}>
    <label class="field choice"><span>${t('experiments.window.value')}</span><select data-window-value=${i} aria-invalid=${bad.is}
      aria-describedby=${bad.by} @change=${(/** @type {Event} */ event) => take(valueOf(event))}>
      ${
        traced.value.includes(part.value)
          ? nothing
          : html`<option value=${part.value} selected>${part.value === '' ? t('experiments.choose') : part.value}</option>`
      }
      ${[...groups].map(
        ([owner, columns]) =>
          html`<optgroup label=${owner}>${columns.map(
            (column) => html`<option value=${column} .selected=${column === part.value}>${columnNamed(column)}</option>`,
          )}</optgroup>`,
      )}</select></label>
    ${
      traced.value.includes(part.value)
        ? html`<p class="facts">${columnOwner(part.value, scenario.value)}: ${columnNamed(part.value)}</p>`
        : nothing
    }
    <div class="numbers">${bound('above')}${bound('below')}</div></div>`;
}

/** @param {Part} part @returns {Template} */
function metricsOf(part) {
  const there = draft.value.metrics.filter((path) => windowOf(path) === part.name && part.name !== '').map(bareOf),
    all = [...new Set([...offered(), ...there.filter((path) => path !== LENGTH), LENGTH])];
  return html`<div class="windowed" role="group" aria-label=${t('experiments.window.metrics', { name: part.name })}>${all.map(
    (path) => html`<label class="toggle"><input type="checkbox" data-windowed=${`${path}@${part.name}`} .checked=${there.includes(path)}
      @change=${() => toggleMetric(`${path}@${part.name}`)}><span title=${path}>${named(path)}</span></label>`,
  )}</div>`;
}

/** @param {Part} part @param {number} i @returns {Template} */
function partPanel(part, i) {
  const field = `windows.${i}`,
    bad = invalid(`${field}.name`, field);
  const time = (/** @type {'from' | 'to'} */ key, /** @type {string} */ hint) =>
    number({
      id: `window-${i}-${key}`,
      field: `${field}.${key}_s`,
      messageOf: field,
      label: t(`experiments.window.${key}`),
      value: part[key],
      hint,
      take: (text) => changePart(i, { [key]: text }),
    });
  const rename = (/** @type {Event} */ event) => {
    const input = /** @type {HTMLInputElement} */ (event.target);
    let name = partName(input.value);
    while (draft.value.parts.some((other, k) => k !== i && other.name === name)) name += '_'; // else the metrics of both would be one's
    if (input.value !== name) input.value = name;
    changePart(i, { name });
  };
  return html`<fieldset class="axis" data-window=${i}><legend class="unseen">${t('experiments.window', { n: i + 1 })}</legend>
    <div class="head"><label class="field whole"><span>${t('experiments.window.name')}</span><input data-window-name=${i}
      autocomplete="off" autocapitalize="none" spellcheck="false" aria-invalid=${bad.is} aria-describedby=${bad.by}
      .value=${part.name} @input=${rename}></label>
      <button type="button" class="small" aria-label=${t('experiments.window.remove', { name: part.name })}
        @click=${() => removePart(i)}>${t('experiments.remove')}</button></div>
    <div class="numbers">${time('from', '0')}${time('to', t('experiments.window.end'))}</div>
    <label class="toggle"><input type="checkbox" data-window-while=${i} .checked=${part.on}
      @change=${() => changePart(i, { on: !part.on })}><span>${t('experiments.window.while')}</span></label>
    ${part.on ? condition(part, i) : nothing}
    <p class="facts">${t('experiments.window.in')}</p>${metricsOf(part)}
    ${sentence(field)}</fieldset>`;
}

/** @returns {Template} */
export function windowsPanel() {
  const { parts } = draft.value;
  return html`<fieldset class="panel server metrics" id="windows"><legend class="unseen">${t('experiments.windows')}</legend>
    <div class="head"><h2>${t('experiments.windows')}</h2><button type="button" class="small" id="add-window"
      ?disabled=${parts.length >= PARTS_MAX}
      @click=${() => addPart(newPart(parts, half()), offered())}>${t('experiments.windows.add')}</button></div>
    <p class="facts">${t('experiments.windows.tip')}</p>
    ${parts.map(partPanel)}</fieldset>`;
}
