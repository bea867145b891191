// Experiments as arguments.
import { LaglabError } from './errors.js';

/** An id of the library, or a whole scenario.
 * @typedef {string | import('./types/api.js').components['schemas']['Scenario'] | Record<string, any>} Scenario */
/** Of each name the values of the same paths. @typedef {Record<string, Record<string, any>>} Settings */
/** An experiment as api/openapi.yaml has it. @typedef {import('./types/api.js').components['schemas']['Experiment']} Specification */
/**
 * What is special to this client.
 * @typedef {object} Axes
 * @property {Record<string, any[] | Settings> | Record<string, any>[]} [axes]  by path its values, or by a name settings with names; or a
 * list as in the experiment's format
 */
/** An experiment's other members, each as the API has it. @typedef {Omit<Partial<Specification>, 'scenario' | 'axes'> & Axes} Wish */

const equal = (/** @type {unknown} */ a, /** @type {unknown} */ b) => JSON.stringify(a) === JSON.stringify(b);

/** @param {string} name @param {Settings} settings */
function namedAxis(name, settings) {
  const given = Object.values(settings),
    paths = Object.keys(given[0] ?? {}),
    sorted = [...paths].sort();
  if (paths.length === 0 || given.some((one) => !equal(Object.keys(one).sort(), sorted)))
    throw new LaglabError(`axes: each setting of ${name} must have values for the same paths`);
  const values = given.map((one) => paths.map((path) => one[path]));
  if (values.some((one, i) => values.slice(0, i).some((other) => equal(one, other))))
    throw new LaglabError(`axes: two settings of ${name} are equal`);
  return { zip: paths.map((path) => ({ path, values: given.map((one) => one[path]) })) };
}

/** Those of the axes whose values are settings with names. @param {Wish['axes']} axes @returns {Record<string, Settings>} */
export function namedAxes(axes) {
  if (!axes || Array.isArray(axes)) return {};
  return /** @type {Record<string, Settings>} */ (Object.fromEntries(Object.entries(axes).filter(([, given]) => !Array.isArray(given))));
}

/** An experiment as laglab reads it. @param {Scenario} scenario @param {Wish} wish @returns {Record<string, any>} */
export function specification(scenario, { axes, ...more }) {
  if (!axes) return { scenario, ...more };
  if (Array.isArray(axes)) return { scenario, axes, ...more };
  const list = Object.entries(axes).map(([path, given]) => (Array.isArray(given) ? { path, values: given } : namedAxis(path, given)));
  return { scenario, axes: list, ...more };
}

/** Rows with a column for each named axis, before the first of its paths.
 * @param {Record<string, any>[]} rows @param {Record<string, Settings>} named @returns {Record<string, any>[]} */
export function withNames(rows, named) {
  const columns = new Map(
    Object.entries(named).map(([name, settings]) => [Object.keys(Object.values(settings)[0] ?? {})[0], { name, settings }]),
  );
  if (columns.size === 0) return rows;
  const nameOf = (/** @type {Settings} */ settings, /** @type {Record<string, any>} */ row) =>
    Object.entries(settings).find(([, values]) => Object.entries(values).every(([path, value]) => equal(row[path], value)))?.[0] ?? null;
  return rows.map((row) =>
    Object.fromEntries(
      Object.entries(row).flatMap(([column, value]) => {
        const mine = columns.get(column);
        return mine
          ? [
              [mine.name, nameOf(mine.settings, row)],
              [column, value],
            ]
          : [[column, value]];
      }),
    ),
  );
}
