// The settings of two runs: which there are, and which differ.
import { find, livePaths, valueAt } from '../../../base/schema.js';
import { params, schema } from '../../../session/state.js';
import { secondParams } from './runs.js';

/** @typedef {{path: string, values: [any, any]}} Differing */

const FIRST = ['lag_ms', 'prediction', 'reconciliation', 'interpolation', 'update_hz', 'sync']; /* as on the panels */
const LEFT_OUT = ['control', 'name'];

/** Those that a run can have changed, by the part that they belong to. @returns {{at: string, paths: string[]}[]} */
export function settings() {
  const players = (params.value?.players ?? []).map((/** @type {any} */ _, /** @type {number} */ p) => `players.${p}`);
  const rank = (/** @type {string} */ path) =>
    (FIRST.indexOf(path.slice(path.lastIndexOf('.') + 1)) + FIRST.length + 1) % (FIRST.length + 1);
  return [...players, 'server', 'params']
    .map((at) => ({
      at,
      paths: livePaths(schema.value, at)
        .filter((path) => !LEFT_OUT.includes(path.slice(path.lastIndexOf('.') + 1)))
        .filter((path) => find(schema.value, path)?.type !== 'text' && typeof valueAt(params.value, path) !== 'object')
        .filter((path) => valueAt(params.value, path) !== undefined)
        .sort((a, b) => rank(a) - rank(b)),
    }))
    .filter(({ paths }) => paths.length > 0);
}

/** @param {any} one @param {any} other @param {string} at @returns {Differing[]} */
function below(one, other, at) {
  return Object.keys(one ?? {}).flatMap((name) => {
    const path = at === '' ? name : `${at}.${name}`,
      values = /** @type {[any, any]} */ ([one[name], other?.[name]]);
    if (typeof values[0] === 'object' && values[0] !== null) return below(values[0], values[1], path);
    return values[0] === values[1] || LEFT_OUT.includes(name) ? [] : [{ path, values }];
  });
}

/** @returns {Differing[]} */
export const differing = () => (secondParams.value === null ? [] : below(params.value, secondParams.value, ''));
