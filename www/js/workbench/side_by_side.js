// Simulations side by side from the same start: how many there are, and what makes each another than the first.
import { html } from '../../vendor/lit-html.js';
import { link } from '../session/opening.js';
import { again } from '../session/session.js';
import { params } from '../session/state.js';
import { t } from '../base/words.js';

/** @typedef {import('../base/link.js').Value} Value */

/** Path before a parameter of the one at index `i`. @param {number} i */
export const pathOf = (i) => (i === 0 ? '' : `side_by_side.${i - 1}.`);
/** @param {number} i @returns {any} */
export const paramsOf = (i) => (i === 0 ? params.value : params.value?.side_by_side?.[i - 1]) ?? {};

/** The values of `one` that are other than in `other`. @param {any} one @param {any} other @returns {any} */
export function difference(one, other) {
  /** @type {{[name: string]: any}} */
  const left = {};
  for (const [name, value] of Object.entries(one)) {
    if (typeof value !== 'object') {
      if (value !== other?.[name]) left[name] = value;
    } else if (Object.keys(difference(value, other?.[name])).length > 0) {
      left[name] = difference(value, other?.[name]);
    }
  }
  return left;
}

/** Creates another session: parameters of the memory layout are fixed during a run. @param {{[path: string]: Value}} set of the first
 * @param {any[]} list of the differences of each further one */
export function renew(set, list) {
  const kept = Object.entries(link.set).filter(([path]) => !path.startsWith('side_by_side'));
  const given =
    list.length > 0 || 'side_by_side' in link.set || (params.value?.side_by_side ?? []).length > 0; /* also that there is none any more */
  link.set = { ...Object.fromEntries(kept), ...set, ...(given ? { side_by_side: /** @type {any} */ (list) } : {}) };
  again();
}

const COUNTS_MAX = 3;

/** @param {number} count now @param {string} what beginning of the keys of its words @param {(wanted: number) => void} set
 * @returns {import('lit-html').TemplateResult} */
export function countChoice(count, what, set) {
  return html`<label class="field choice"><span>${t('workbench.side_by_side')}</span><select id="count"
    @change=${(/** @type {Event} */ event) => set(Number(/** @type {HTMLSelectElement} */ (event.target).value))}>${Array.from(
      { length: COUNTS_MAX },
      (_, i) => html`<option value=${i + 1} .selected=${i + 1 === count}>${t(`${what}.${i + 1}`)}</option>`,
    )}</select></label>`;
}
