// What a step leaves to be used: its settings in the rail, the way to all others, and what it highlights.
import { html, nothing } from '../../vendor/lit-html.js';
import { letter } from '../base/format.js';
import { find, labelOf, valueAt } from '../base/schema.js';
import { look, lesson, params, schema } from '../session/state.js';
import { control } from '../workbench/controls.js';
import { numberIn } from '../workbench/number_field.js';
import { watch } from './moving.js';
import { CHANGE, controlsOf, opened, remake, stands, unlocked } from './steps.js';
import { word } from './words.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('./steps.js').Lesson} Lesson */

/** The setting of a name; null where it is a control of time or of the views. @param {string} name */
const rowOf = (name) => (valueAt(params.value, name) === undefined ? null : find(schema.value, name));

/** Whose setting it is, where several have one. @param {string} path @returns {string} */
function ownerOf(path) {
  const [, list = '', place = ''] = /^(\w+)\.(\d+)\./.exec(path) ?? [];
  if (list === '') return '';
  const one = valueAt(params.value, `${list}.${place}`);
  return `${list === 'methods' ? String(one?.method ?? '').replaceAll('_', ' ') : letter(Number(place))}: `;
}

/** A setting that a session takes only when it is made does not go to the session. @param {Event} event */
function onChange(event) {
  const element = event.target;
  if (!(element instanceof HTMLInputElement || element instanceof HTMLSelectElement)) return;
  const path = element.dataset.path ?? '',
    row = rowOf(path);
  /* a change would end what players are to do, as a workload says */
  if (row === null || (row.live && !opened.value?.workload && !stands(lesson.value?.step ?? 0))) return;
  event.stopPropagation();
  if (element instanceof HTMLSelectElement) remake(path, element.value);
  else if (element.type === 'checkbox') remake(path, element.checked);
  else if (element.type === 'range') remake(path, element.valueAsNumber);
  else {
    const value = numberIn(element, labelOf(params.value.kind, path), row, Number(valueAt(params.value, path)));
    if (!Number.isNaN(value)) remake(path, value);
  }
}

/** @param {string} path @returns {Template | typeof nothing} */
function setting(path) {
  const owner = ownerOf(path);
  const slider = path.endsWith('.lag_ms');
  if (owner === '') return control(path, { slider });
  return html`<div class="owned" role="group" aria-label=${owner.slice(0, -2)}><span
    class="owner" aria-hidden="true">${owner}</span>${control(path, { slider })}</div>`;
}

/** The settings of the step that is shown. @param {Lesson} of @returns {Template | typeof nothing} */
export function settings(of) {
  const list = controlsOf(of, lesson.value?.step ?? 1).filter((name) => rowOf(name) !== null);
  if (list.length === 0) return nothing;
  return html`<section class="use" aria-label=${word('use.settings')} @change=${onChange}>${list.map(setting)}</section>`;
}

/** What is locked, and the way out. @param {Template} more next to it @returns {Template} */
export function lock(more) {
  const free = unlocked.value;
  return html`<div class="lock"><p class="faint">${word(free ? 'use.free' : 'use.locked')}</p>
    <button type="button" class="link" id="unlock" @click=${() => {
      unlocked.value = !free;
    }}>${word(free ? 'use.lock' : 'use.unlock')}</button>${more}</div>`;
}

/** Names what is highlighted: colour alone does not. @returns {Template} */
export const highlighted = () => html`<p class="faint" id="highlighted"></p>`;

/** @param {Element} element of a lab @returns {boolean} whether the lesson is about it */
function isAbout(element) {
  const { shows = '', of } = /** @type {HTMLElement} */ (element).dataset,
    { at, player } = look.value ?? { at: '' };
  return at !== '' && shows.split(' ').includes(at) && (of === undefined || of === String(player ?? 'server'));
}

/** @param {Element} element of a lab @returns {boolean} whether the step highlights it */
function isLit(element) {
  const { path } = /** @type {HTMLElement} */ (element).dataset,
    step = lesson.value?.step ?? 1,
    now = opened.value;
  if (path !== undefined) return step === CHANGE && now !== null && controlsOf(now, step).includes(path);
  return step !== CHANGE && step >= 3 && isAbout(element);
}

/** The list of questions moves once it is drawn and there is time. @param {ParentNode} root */
export function liven(root) {
  if (matchMedia('(prefers-reduced-motion: reduce)').matches || root.querySelector('.card') === null) return;
  watch(root).catch(() => {}); /* the cards then stand still */
}

let shown = '';

/** After the page has been rendered: marks what the step highlights, in every lab by the same names. @param {ParentNode} root */
export function light(root) {
  if (lesson.value?.id === '') return liven(root);
  const all = [...root.querySelectorAll('[data-shows], [data-path]')],
    lit = all.filter(isLit);
  for (const element of all) {
    element.toggleAttribute('data-lit', lit.includes(element));
    element.toggleAttribute('data-about', isAbout(element));
  }
  const first = lit.find((element) => element.hasAttribute('data-shows')),
    text = root.querySelector('#highlighted'),
    name =
      first?.closest('.row')?.querySelector('.caption b')?.textContent ??
      first?.closest('[aria-label]')?.getAttribute('aria-label')?.split('. ')[0] ??
      '';
  if (text) text.textContent = name === '' ? '' : word('use.look', { name });
  const moment = `${lesson.value?.id} ${lesson.value?.step} ${first !== undefined}`;
  const box = first?.closest('.drawings, .rows, .side');
  if (moment !== shown && box instanceof HTMLElement && first instanceof HTMLElement)
    box.scrollTop += first.getBoundingClientRect().top - box.getBoundingClientRect().top - 8;
  shown = moment;
}
