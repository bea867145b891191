// The fluids of the session: what they are, how they differ, and how each is drawn.
import { signal } from '../../../vendor/signals-core.js';
import { layout, params } from '../../session/state.js';
import { difference, paramsOf, renew as renewSideBySide } from '../../workbench/side_by_side.js';
import { called, inputOf, language, t } from '../../base/words.js';

/** @typedef {import('../../base/link.js').Value} Value */
/** @typedef {{name: string, help: string, shape: 'field' | 'points', columns: string[]}} Layer */
/** @typedef {{scene: string, title: string, help: string, source: string, method: string, hz: number, layers: Layer[], view: number[],
 *   numbers: string[], notices?: string[], side_by_side?: FluidLayout[]}} FluidLayout  view: left, right, bottom, top in m */

/** How a field is drawn; null: as suits it. @type {import('@preact/signals-core').Signal<{cells: boolean, relief: boolean | null}>} */
export const drawing = signal({ cells: false, relief: null });
export const fluid = () => /** @type {FluidLayout | null} */ (layout.value?.given.fluid ?? null);
/** Those side by side. @returns {FluidLayout[]} */
export const fluids = () => (fluid() ? [/** @type {FluidLayout} */ (fluid()), ...(fluid()?.side_by_side ?? [])] : []);
export const words = (/** @type {string} */ name) => called('fluid', name);
/** A setting's name within a sentence, where English has no capitals. @param {string} name @param {string} at */
const settingOf = (name, at) => (language.value === 'en' ? words(name) : (inputOf('fluid', `${at}.${name}`)?.label ?? words(name)));
/** @param {FluidLayout | undefined} of */
export const fieldsOf = (of) => of?.layers.filter((layer) => layer.shape === 'field') ?? [];
/** Of which family's speed against error is the question. @param {FluidLayout | null} of @returns {string} */
export const familyOf = (of) =>
  fieldsOf(of ?? undefined).some(({ name }) => name === 'height')
    ? 'oceans'
    : of?.layers.some(({ shape }) => shape === 'points')
      ? 'particles'
      : 'pressure_solvers';
/** @param {Layer} layer */
export const isSurface = (layer) => /surface|height/.test(layer.name);
/** The field that frames carry. @param {number} i @returns {Layer | undefined} */
export function shownField(i) {
  const fields = fieldsOf(fluids()[i]);
  return fields[Math.min(paramsOf(i).shown ?? 0, fields.length - 1)];
}
/** @param {number} i */
export function relief(i) {
  const field = shownField(i);
  return drawing.value.relief ?? (field !== undefined && isSurface(field));
}

/** How a further fluid differs from the first. @param {any} one @param {any} first */
const differencesOf = (one, first) =>
  one.scene === first.scene ? difference(one, first) : { scene: one.scene, params: one.params, solver: one.solver };

/** Name of a fluid: its scene, or the settings that differ. @param {number} i */
export function nameOf(i) {
  const own = paramsOf(i),
    all = fluids(),
    first = String(own.solver?.method ?? own.solver?.pressure ?? own.scene ?? '');
  if (all.some((one) => one.scene !== all[0]?.scene)) return all[i]?.title ?? '';
  const other = all.findIndex((_, k) => k !== i && Object.keys(differencesOf(own, paramsOf(k))).length > 0);
  const { params: sizes = {}, solver = {} } = other < 0 ? {} : differencesOf(own, paramsOf(other));
  const differ = Object.entries({ ...solver, ...sizes })
    .filter(([name]) => name !== 'method')
    .slice(0, 2);
  const setting = (/** @type {string} */ name) => settingOf(name, name in solver ? 'solver' : 'params');
  const parts = differ.map(([name, value]) =>
    value === true
      ? setting(name)
      : value === false
        ? t('fluid.without', { name: setting(name) })
        : name === 'n' || name === 'size'
          ? `${name} = ${value}`
          : /^(advection|pressure|splitting)$/.test(name)
            ? words(String(value))
            : `${setting(name)} ${words(String(value))}`,
  );
  return solver.method || parts.length === 0 ? [words(first), ...parts].join(', ') : parts.join(', ');
}

/** @param {{[path: string]: Value}} set of the first fluid @param {any[]} list of the further fluids, as wanted */
export function renew(set, list) {
  const first = structuredClone({ scene: params.value.scene, params: params.value.params, solver: params.value.solver });
  for (const [path, value] of Object.entries(set)) if (path.startsWith('params.')) first.params[path.slice(7)] = value;
  renewSideBySide(
    set,
    list.map((one) => differencesOf(one, first)),
  );
}

/** The further fluids as they are. @returns {any[]} */
export const others = () =>
  (params.value?.side_by_side ?? []).map((/** @type {any} */ one) =>
    structuredClone({ scene: one.scene, params: one.params, solver: one.solver }),
  );
