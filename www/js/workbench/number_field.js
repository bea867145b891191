// Fields for numbers, which are read and written in the page's language: a browser's own ones follow the browser's, and drop what they do
// not know.
import { typed, typedNumber } from '../base/format.js';
import { t, unitName } from '../base/words.js';
import { notify } from '../session/state.js';

/** @typedef {{min: number, max: number, type?: string, unit?: string}} Range  of a row of the schema */

/** The number of a field; NaN where there is none: then it is said what the field takes, and it has again what it had.
 * @param {HTMLInputElement} field @param {string} name @param {Range | null | undefined} row @param {number} now @returns {number} */
export function numberIn(field, name, row, now) {
  const value = typedNumber(field.value);
  if (value !== 'ambiguous' && Number.isFinite(value) && (!row || (value >= row.min && value <= row.max)))
    return row?.type === 'integer' ? Math.round(value) : value;
  const range = row
    ? t('workbench.number_from', { min: typed(row.min), max: typed(row.max), unit: row.unit ? ` ${unitName(row.unit)}` : '' })
    : t('workbench.any_number');
  const key = value === 'ambiguous' ? 'workbench.ambiguous' : 'workbench.not_a_number';
  notify(t(key, { name, text: field.value.trim(), range, value: typed(now) }));
  field.value = typed(now);
  return NaN;
}

/** The arrows up and down count, as in a browser's own field. @param {KeyboardEvent} event */
export function countByArrows(event) {
  const field = event.target,
    way = event.key === 'ArrowUp' ? 1 : event.key === 'ArrowDown' ? -1 : 0;
  if (way === 0 || !(field instanceof HTMLInputElement) || !field.classList.contains('number')) return;
  const value = typedNumber(field.value);
  if (value === 'ambiguous' || !Number.isFinite(value)) return;
  event.preventDefault();
  const { min = value, max = value } = field.dataset;
  field.value = typed(way > 0 ? Math.min(Number(max), value + 1) : Math.max(Number(min), value - 1));
  field.dispatchEvent(new Event('change', { bubbles: true }));
}
