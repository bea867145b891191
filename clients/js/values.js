// Values of a tree by their dotted paths.
import { LaglabError } from './errors.js';

/** @param {any} at */
const parts = (at) =>
  Array.isArray(at) ? `${at.length} elements` : at !== null && typeof at === 'object' ? Object.keys(at).join(', ') : 'no parts';

/** The value at a path such as `players.0.remote_error_m.mean`. Throws where there is none: the error names what is there instead.
 * @param {any} tree @param {string} path @returns {any} */
export function valueAt(tree, path) {
  let at = tree,
    reached = '';
  for (const part of path.split('.')) {
    if (at === null || typeof at !== 'object' || !Object.hasOwn(at, part))
      throw new LaglabError(`${path}: ${reached || 'the whole'} has ${parts(at)}`, { fields: { [path]: 'unknown' } });
    at = at[part];
    reached = reached === '' ? part : `${reached}.${part}`;
  }
  return at;
}

/** Every value of a tree with its path. @param {any} tree @param {string} [before] @returns {Generator<[string, any]>} */
export function* leaves(tree, before = '') {
  if (tree === null || typeof tree !== 'object') {
    yield [before, tree];
    return;
  }
  for (const [name, value] of Object.entries(tree)) yield* leaves(value, before === '' ? name : `${before}.${name}`);
}
