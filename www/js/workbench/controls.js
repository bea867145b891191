// Controls made from the schema's rows: range, unit and help come from there, the value from the session.
import { html, nothing } from '../../vendor/lit-html.js';
import { find, labelOf, valueAt } from '../base/schema.js';
import { change, unanswered } from '../session/params.js';
import { params, schema } from '../session/state.js';
import { plain, typed } from '../base/format.js';
import { choiceOf, inputOf, t, unitName } from '../base/words.js';
import { countByArrows, numberIn } from './number_field.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {{also?: string, slider?: boolean, label?: string}} Wish  also: a second path that gets the same value */

/** @param {string} path @param {Wish} [wish] @returns {Template | typeof nothing} nothing when the scenario has no such value */
export function control(path, wish = {}) {
  const row = find(schema.value, path);
  if (!row || valueAt(params.value, path) === undefined) return nothing;
  const { kind } = params.value,
    label = wish.label ?? labelOf(kind, path),
    tip = inputOf(kind, path)?.tip ?? row.help;
  const also = wish.also ?? '';
  if (row.type === 'boolean') {
    return html`<label class="toggle" title=${tip}><input type="checkbox" data-path=${path}><span>${label}</span></label>`;
  }
  if (row.type === 'choice') {
    return html`<label class="field choice" title=${tip}><span>${label}</span><select data-path=${path}>
      ${row.choices.map((choice) => html`<option value=${choice}>${choiceOf(kind, path, choice)}</option>`)}</select></label>`;
  }
  if (row.type === 'text') return nothing;
  const number = html`<label class="field" title=${tip}><span>${label}</span><input class="number" inputmode="decimal"
    autocomplete="off" data-path=${path} data-also=${also} data-min=${row.min} data-max=${row.max}><span
    class="unit">${unitName(row.unit)}</span></label>`;
  if (!wish.slider) return number;
  return html`<div class="slider">${number}<input type="range" aria-label=${t('workbench.slider', { name: label })}
    data-path=${path} data-also=${also} min=${row.min} max=${row.max} step=${row.type === 'integer' || row.max >= 100 ? 1 : 'any'}></div>`;
}

/** @param {HTMLInputElement} element */
const isNumber = (element) => element.classList.contains('number');

/** The element that a pointer holds: its value is the person's, not the daemon's. @type {Element | null} */
let held = null;

/** Puts the session's values into the controls below `root`, but for those that were changed since. @param {ParentNode} root */
export function sync(root) {
  for (const element of root.querySelectorAll('[data-path]')) {
    const { path = '' } = /** @type {HTMLElement} */ (element).dataset,
      value = valueAt(params.value, path);
    if (value === undefined || element === held || unanswered(path)) continue;
    if (element instanceof HTMLSelectElement) {
      if (element.value !== String(value)) element.value = String(value);
    } else if (element instanceof HTMLInputElement) {
      if (element.type === 'checkbox') element.checked = value === true;
      else if (!(isNumber(element) && element === document.activeElement && element.dataset.typing)) {
        const text = isNumber(element) ? typed(Number(value)) : plain(Number(value));
        if (element.value !== text) element.value = text;
      }
    }
  }
}

/** @param {HTMLElement} element @param {import('../base/link.js').Value} value */
function submit(element, value) {
  const { path = '', also = '' } = element.dataset;
  change({ [path]: value, ...(also === '' ? {} : { [also]: value }) });
}

/** Shows a slider's value in the field next to it at once. @param {HTMLInputElement} element */
function mirror(element) {
  for (const twin of document.querySelectorAll(`[data-path="${element.dataset.path}"]`)) {
    if (twin !== element && twin instanceof HTMLInputElement) twin.value = isNumber(twin) ? typed(Number(element.value)) : element.value;
  }
}

/** @param {Event} event */
function onInput(event) {
  const element = event.target;
  if (!(element instanceof HTMLInputElement) || !element.dataset.path) return;
  if (isNumber(element)) {
    element.dataset.typing = 'yes';
  } else if (element.type === 'range') {
    mirror(element);
    submit(element, Number(element.value));
  }
}

/** @param {HTMLInputElement} element */
function onNumber(element) {
  delete element.dataset.typing;
  const { path = '' } = element.dataset;
  const value = numberIn(element, labelOf(params.value.kind, path), find(schema.value, path), Number(valueAt(params.value, path)));
  if (!Number.isNaN(value)) submit(element, value);
}

/** @param {Event} event */
function onChange(event) {
  const element = event.target;
  if (!(element instanceof HTMLElement) || !element.dataset.path) return;
  if (element instanceof HTMLSelectElement) submit(element, element.value);
  else if (element instanceof HTMLInputElement && element.type === 'checkbox') submit(element, element.checked);
  else if (element instanceof HTMLInputElement && isNumber(element)) onNumber(element);
}

/** Arrows move a slider by a hundredth of its range, with Shift by one, Page by a tenth. @param {KeyboardEvent} event */
function onKey(event) {
  const element = event.target;
  if (!(element instanceof HTMLInputElement) || element.type !== 'range' || !element.dataset.path) return;
  const low = Number(element.min),
    high = Number(element.max);
  const size = event.key.startsWith('Page') ? (high - low) / 10 : event.shiftKey ? 1 : Math.max(1, (high - low) / 100);
  const way = ['ArrowRight', 'ArrowUp', 'PageUp'].includes(event.key)
    ? 1
    : ['ArrowLeft', 'ArrowDown', 'PageDown'].includes(event.key)
      ? -1
      : 0;
  if (way === 0) return;
  event.preventDefault();
  element.value = String(Math.max(low, Math.min(high, Math.round(Number(element.value) + way * size))));
  mirror(element);
  submit(element, Number(element.value));
}

export function listen() {
  document.addEventListener('input', onInput);
  document.addEventListener('change', onChange);
  document.addEventListener('keydown', onKey);
  document.addEventListener('keydown', countByArrows);
  document.addEventListener('pointerdown', (event) => {
    if (event.target instanceof HTMLInputElement && event.target.type === 'range') held = event.target;
  });
  for (const end of ['pointerup', 'pointercancel']) {
    document.addEventListener(end, () => {
      held = null;
    });
  }
}
