// The controls of the fluid lab: the scene, and each fluid with its solver.
import { html, nothing } from '../../../vendor/lit-html.js';
import { find, livePaths } from '../../base/schema.js';
import { change } from '../../session/params.js';
import { choose } from '../../session/session.js';
import { typed } from '../../base/format.js';
import { titleOf } from '../../session/scenario_words.js';
import { locked, params, scenarios, schema } from '../../session/state.js';
import { touch } from '../../draw/redraw.js';
import { control } from '../../workbench/controls.js';
import { numberIn } from '../../workbench/number_field.js';
import { mark } from '../../workbench/player_mark.js';
import { countChoice, paramsOf, pathOf } from '../../workbench/side_by_side.js';
import { drawing, fieldsOf, fluids, nameOf, others, relief, renew, shownField, words } from './fluids.js';
import { inputOf, t, unitName } from '../../base/words.js';
import { message } from '../../base/messages.js';
import { said } from '../../workbench/said.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('../../base/link.js').Value} Value */

/** Parameter of a scene: a change creates another session. @param {number} i @param {string} name
 * @returns {Template | typeof nothing} */
function sceneParameter(i, name) {
  const path = `${pathOf(i)}params.${name}`,
    row = find(schema.value, path),
    value = paramsOf(i).params?.[name],
    named = inputOf('fluid', path);
  if (!row || value === undefined) return nothing;
  const set = (/** @type {Value} */ given) => {
    const list = others();
    if (i === 0) renew({ [path]: given }, list);
    else
      renew(
        {},
        list.map((one, k) => (k === i - 1 ? { ...one, params: { ...one.params, [name]: given } } : one)),
      );
  };
  const id = i === 0 ? name : `${i}/${name}`;
  if (row.type === 'choice') {
    return html`<label class="field choice" title=${named?.tip ?? row.help}><span>${named?.label ?? words(name)}</span><select
      data-scene=${id} @change=${(/** @type {Event} */ event) => set(/** @type {HTMLSelectElement} */ (event.target).value)}>
      ${row.choices.map((one) => html`<option value=${one} .selected=${one === value}>${words(one)}</option>`)}</select></label>`;
  }
  return html`<label class="field"
    title=${named?.tip ?? row.help}><span>${named?.label ?? words(name)}</span><input class="number" inputmode="decimal"
    autocomplete="off" data-scene=${id} data-min=${row.min} data-max=${row.max} .value=${typed(Number(value))}
    @change=${(/** @type {Event} */ event) => {
      const given = numberIn(/** @type {HTMLInputElement} */ (event.target), named?.label ?? words(name), row, Number(value));
      if (!Number.isNaN(given)) set(given);
    }}><span class="unit">${unitName(row.unit)}</span></label>`;
}

/** @returns {Template} */
export function scenePanel() {
  const rows = scenarios.value.filter((row) => row.kind === 'fluid'),
    count = fluids().length;
  const set = (/** @type {number} */ wanted) => {
    const list = others();
    while (list.length < wanted - 1) list.push({ scene: params.value.scene, params: params.value.params, solver: params.value.solver });
    renew({}, list.slice(0, wanted - 1));
  };
  return html`<fieldset class="panel server" ?disabled=${locked.value !== ''}><legend class="unseen">${t('workbench.scene')}</legend>
    <label class="field choice"><span>${t('workbench.scene')}</span><select id="scene"
      @change=${(/** @type {Event} */ event) => choose(/** @type {HTMLSelectElement} */ (event.target).value)}>
      ${rows.map(
        (row) => html`<option value=${row.id}
        .selected=${row.title === params.value?.title}>${titleOf(row)}</option>`,
      )}</select></label>
    ${countChoice(count, 'fluid.count', set)}
    ${
      shownFields().length > 0
        ? html`<div
      class="toggles">${toggle('cells', t('fluid.cells'), drawing.value.cells)}${toggle('relief', t('fluid.relief'), relief(0))}</div>`
        : nothing
    }
  </fieldset>`;
}

const shownFields = () => fluids().flatMap((_, i) => shownField(i) ?? []);

/** Settings that make the largest difference; the others stand below. */
const FIRST = [
  'method',
  'advection',
  'pressure',
  'splitting',
  'tolerance',
  'sweeps',
  'iterations',
  'viscosity',
  'viscosity_scale',
  'vorticity_confinement',
  'limiter',
];

/** The scene of a further fluid. @param {number} i @returns {Template} */
function sceneChoice(i) {
  const row = find(schema.value, `${pathOf(i)}scene`),
    now = paramsOf(i).scene;
  const set = (/** @type {Event} */ event) => {
    const scene = /** @type {HTMLSelectElement} */ (event.target).value;
    renew(
      {},
      others().map((one, k) => (k === i - 1 ? { scene } : one)),
    );
  };
  return html`<label class="field choice"><span>${t('workbench.scene')}</span><select data-scene=${`${i}/scene`} @change=${set}>
    ${(row?.choices ?? []).map((one) => html`<option value=${one} .selected=${one === now}>${words(one)}</option>`)}</select></label>`;
}

/** One fluid: parameters of its scene, its field, its solver. @param {number} i @returns {Template} */
export function fluidPanel(i) {
  const at = pathOf(i),
    paths = livePaths(schema.value, `${at}solver`),
    ending = (/** @type {string} */ path) => path.slice(path.lastIndexOf('.') + 1);
  const first = paths.filter((path) => FIRST.includes(ending(path))),
    rest = paths.filter((path) => !FIRST.includes(ending(path)));
  const several = fluids().length > 1,
    name = several ? html`${mark(i)} <span>${nameOf(i)}</span>` : t('fluid.solver');
  const more = () => html`<details><summary>${t('workbench.more')}</summary>${rest.map((path) => control(path))}</details>`;
  return html`<fieldset class="panel method" data-player=${several ? i : nothing} ?disabled=${locked.value !== ''}
    title=${locked.value || nothing}>
    <legend class="unseen">${several ? t('fluid.fluid_n', { n: i + 1 }) : t('shell.tab.fluid')}</legend>
    <div class="head"><h2>${name}</h2><small>${words(fluids()[i]?.method ?? '')}</small></div>
    ${i > 0 ? sceneChoice(i) : nothing}${Object.keys(paramsOf(i).params ?? {}).map((one) => sceneParameter(i, one))}${fieldChoice(i)}
    ${first.map((path) => control(path))}${rest.length > 0 ? more() : nothing}</fieldset>`;
}

/** @param {'cells' | 'relief'} name @param {string} label @param {boolean} on @returns {Template} */
function toggle(name, label, on) {
  return html`<label class="toggle"><input type="checkbox" data-drawing=${name} .checked=${on} @change=${() => {
    drawing.value = { ...drawing.value, [name]: !on };
    touch();
  }}><span>${label}</span></label>`;
}

/** @param {number} i @returns {Template | typeof nothing} */
function fieldChoice(i) {
  const now = shownField(i);
  if (!now) return nothing;
  const show = (/** @type {Event} */ event) =>
    change({ [`${pathOf(i)}shown`]: Number(/** @type {HTMLSelectElement} */ (event.target).value) });
  return html`<label class="field choice" title=${message(now.help).text}><span>${t('fluid.field')}</span><select
      id=${i === 0 ? 'field' : `field${i}`} @change=${show}>
      ${fieldsOf(fluids()[i]).map(
        (layer, k) => html`<option value=${k}
        .selected=${layer === now}>${words(layer.name)}</option>`,
      )}</select></label>
    ${fluids().length === 1 ? html`<p class="facts">${said(now.help)}</p>` : nothing}`;
}
