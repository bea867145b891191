// Fields of the form of an experiment: a value, a choice of parameters, and what is wrong with them.
import { html, nothing } from '../../../../vendor/lit-html.js';
import { localized, plain } from '../../../base/format.js';
import { t } from '../../../base/words.js';
import { inputName, placeOf } from './names.js';
import { draft, fieldOf, refused, ruleOf, scenario, variable, variables } from './draft.js';

/** @typedef {import('lit-html').TemplateResult} Template */

export const valueOf = (/** @type {Event} */ event) => /** @type {HTMLInputElement | HTMLSelectElement} */ (event.target).value;

// ---- errors ----

/** The sentence about a field, or about one below it. @param {string} field */
export function wrong(field) {
  for (const [at, detail] of refused.value) if (at === field || at.startsWith(`${field}.`)) return detail;
  return '';
}
export const idOf = (/** @type {string} */ field) => `wrong-${field.replaceAll('.', '-')}`;

/** @param {string} field */
export function sentence(field) {
  const detail = wrong(field);
  return detail === '' ? nothing : html`<p class="wrong" id=${idOf(field)}>${detail}</p>`;
}

/** The error message of no field of this form. */
export function elsewhere() {
  const d = draft.value;
  const places = [
    'scenario',
    'sample',
    'repeats',
    'until',
    'windows',
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

/** What a field of the specification is. @param {string} field */
export const helpOf = (field) => t(`experiments.field.${field}`);

/** One line of text whose range and help are the schema's.
 * @param {{id: string, field: string, label: string, value: string, messageOf?: string,
 *   hint?: string, take: (text: string) => void}} of  field: as the daemon names it;
 * messageOf: the field whose message is shown; hint: where empty
 * @returns {Template} */
export function number({ id, field, label, value, messageOf = field, hint = '', take }) {
  const bad = invalid(field, messageOf);
  return html`<label class="field" title=${helpOf(field)}><span>${label}</span><input id=${id} class="narrow" inputmode="decimal"
    autocomplete="off" placeholder=${hint} .value=${value} aria-invalid=${bad.is} aria-describedby=${bad.by}
    @input=${(/** @type {Event} */ event) => take(valueOf(event))}></label>`;
}

/** Allowed values of a field of the specification, from the schema. @param {string} field @returns {string} */
export function rangeOf(field) {
  const row = ruleOf(field);
  const to = row && (row.max >= 1e6 ? t('experiments.any') : localized(plain(row.max)));
  return row && to ? t('experiments.from_to', { from: localized(plain(row.min)), to }) : '';
}

/** Marks a control as wrong. @param {string} field @param {string} [messageOf] the field whose message is shown */
export const invalid = (field, messageOf = field) =>
  wrong(field) === '' ? { is: 'false', by: nothing } : { is: 'true', by: idOf(messageOf) };

// ---- parameters ----

/** @param {string} path @returns {string} */
const ownerOf = (path) => path.slice(0, Math.max(0, path.lastIndexOf('.')));

/** A choice of parameters.
 * @param {string} now
 * @param {string} name
 * @param {(path: string) => void} take
 * @param {{is: string, by: unknown}} bad */
export function parameter(now, name, take, bad) {
  /** @type {Map<string, import('./draft.js').Variable[]>} */
  const groups = new Map();
  for (const one of variables.value) groups.set(ownerOf(one.path), [...(groups.get(ownerOf(one.path)) ?? []), one]);
  return html`<select class="parameter" aria-label=${name} aria-invalid=${bad.is} aria-describedby=${bad.by}
    @change=${(/** @type {Event} */ event) => take(valueOf(event))}>
    ${variable(now) ? nothing : html`<option value=${now} selected>${now === '' ? t('experiments.choose') : now}</option>`}
    ${[...groups].map(
      ([owner, list]) => html`<optgroup
      label=${placeOf(`${owner}${owner && '.'}x`, scenario.value)}>${list.map(
        ({ path, row }) => html`<option value=${path} .selected=${path === now}>${inputName(path, row.unit, scenario.value)}</option>`,
      )}</optgroup>`,
    )}</select>`;
}
