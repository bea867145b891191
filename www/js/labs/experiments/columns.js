// What a table of points holds: which column is which, and which points are on the front.
import { fixed, localized } from '../../base/format.js';
import { t } from '../../base/words.js';
import { chosenName, metricName, wholeName } from './form/names.js';

/** @typedef {import('./shown.js').Cells} Cells */
/** @typedef {{name: string, path: string, label: string, kind: 'axis' | 'metric', numbers: boolean}} Column  name: of the cell */
/** Of a path: empty where there is none, or it is not known yet. @typedef {(path: string) => string | undefined} UnitOf */

/** The parameters that are varied, by path. @param {any} experiment @returns {string[]} */
const pathsOf = (experiment) =>
  (experiment.axes ?? []).flatMap((/** @type {any} */ axis) => (axis.zip ?? [axis]).map((/** @type {any} */ one) => String(one.path)));

/** A parameter's column has its unit in the name. @param {Cells} row @param {string} path */
function columnOf(row, path) {
  if (path in row) return path;
  return (
    Object.keys(row)
      .filter((name) => name.startsWith(`${path}_`))
      .sort((a, b) => a.length - b.length)[0] ?? path
  );
}

/** @param {any} experiment @param {Cells[]} rows @param {any} scenario of the experiment @param {UnitOf} inputUnit
 * @param {UnitOf} metricUnit @returns {Column[]} */
export function columnsOf(experiment, rows, scenario, inputUnit, metricUnit) {
  const [first] = rows;
  if (!first) return [];
  const numbers = (/** @type {string} */ name) => rows.some((row) => typeof row[name] === 'number');
  return [
    ...pathsOf(experiment)
      .map((path) => ({ path, name: columnOf(first, path) }))
      .map(({ path, name }) => ({
        name,
        path,
        label: wholeName(path, inputUnit(path), scenario),
        kind: /** @type {const} */ ('axis'),
        numbers: numbers(name),
      })),
    ...experiment.metrics.map((/** @type {string} */ name) => ({
      name,
      path: name,
      label: metricName(name, metricUnit(name), scenario),
      kind: /** @type {const} */ ('metric'),
      numbers: true,
    })),
  ];
}

/** @param {any} experiment @returns {{error: string, cost: string}} the metrics of error and cost; cost is empty where there is none */
export const errorAndCostOf = (experiment) => ({
  error: experiment.error || experiment.metrics[0],
  cost: experiment.cost || (experiment.metrics[1] ?? ''),
});

/** @param {Cells} row @param {string} name */
export const numberOf = (row, name) => (typeof row[name] === 'number' ? /** @type {number} */ (row[name]) : NaN);

/** The points that no other beats, by magnitude: from the cheapest on, each with less error than all before.
 * A point with a run that failed is none of them.
 * @param {Cells[]} rows @param {string} cost @param {string} error @returns {Set<number>} places */
export function frontOf(rows, cost, error) {
  const places = rows
    .map((row, i) => ({ i, cost: Math.abs(numberOf(row, cost)), error: Math.abs(numberOf(row, error)) }))
    .filter((p) => !(numberOf(/** @type {Cells} */ (rows[p.i]), 'failed') > 0))
    .filter((p) => Number.isFinite(p.cost) && Number.isFinite(p.error))
    .sort((a, b) => a.cost - b.cost || a.error - b.error);
  /** @type {Set<number>} */
  const front = new Set();
  /** @type {{cost: number, error: number} | null} */
  let last = null;
  for (const p of places) {
    if (last !== null && !(p.error < last.error || (p.error === last.error && p.cost === last.cost))) continue;
    front.add(p.i);
    last = p;
  }
  return front;
}

/** The metrics of the front: those that the experiment names, or cost and error. @param {any} experiment @returns {string[]} */
export function frontMetricsOf(experiment) {
  const { cost, error } = errorAndCostOf(experiment);
  return Array.isArray(experiment.front) ? experiment.front.map(String) : cost === '' ? [] : [cost, error];
}

/** The same of any number of metrics: no other point is as good in all and better in one.
 * @param {Cells[]} rows
 * @param {string[]} metrics
 * @returns {Set<number>} places */
export function frontOfAll(rows, metrics) {
  if (metrics.length < 2) return new Set();
  if (metrics.length === 2) return frontOf(rows, /** @type {string} */ (metrics[0]), /** @type {string} */ (metrics[1]));
  const places = rows
    .map((row, i) => ({ i, sizes: metrics.map((name) => Math.abs(numberOf(row, name))) }))
    .filter((p) => !(numberOf(/** @type {Cells} */ (rows[p.i]), 'failed') > 0) && p.sizes.every(Number.isFinite))
    .sort((a, b) => a.sizes.reduce((order, size, k) => order || size - /** @type {number} */ (b.sizes[k]), 0));
  /** @type {typeof places} */
  const front = [];
  for (const p of places) {
    const beaten = front.some(
      (q) =>
        q.sizes.every((size, k) => size <= /** @type {number} */ (p.sizes[k])) &&
        q.sizes.some((size, k) => size < /** @type {number} */ (p.sizes[k])),
    );
    if (!beaten) front.push(p);
  }
  return new Set(front.map((p) => p.i));
}

/** Three significant digits, powers of ten where the number is far from one. @param {number} value */
export function exact(value) {
  if (!Number.isFinite(value)) return '–';
  const size = Math.abs(value);
  if (value === 0) return '0';
  if (size < 1e-3 || size >= 1e6) return localized(value.toExponential(2));
  return fixed(value, size >= 1000 || Number.isInteger(value) ? 0 : size >= 100 ? 1 : size >= 1 ? 2 : 4);
}

/** A parameter as it was set. @param {string | number | boolean | null | undefined} value @param {string} [path] @param {any} [scenario] */
export const formatValue = (value, path = '', scenario = null) =>
  typeof value === 'number'
    ? localized(String(Number(value.toPrecision(6))))
    : value === null || value === undefined
      ? '–'
      : (chosenName(path, value, scenario) ?? String(value));

/** How many points' repeats all gave the same: nothing random reaches their metrics, and there is no interval. @param {Cells[]} rows */
export const identicalOf = (rows) => rows.filter((row) => row.identical === true).length;

/** Notes on the points: metrics that no run has, and points that made all replicates before `until` was reached.
 * @param {any} experiment @param {Cells[]} rows @param {(metric: string) => string} named @returns {string[]} */
export function notesOf(experiment, rows, named) {
  const made = rows.reduce((sum, row) => sum + numberOf(row, 'runs') + numberOf(row, 'failed'), 0);
  const missing =
    made === 0 ? [] : experiment.metrics.filter((/** @type {string} */ name) => !rows.some((row) => Number.isFinite(numberOf(row, name))));
  const { half_width: half = 0, relative = 0, metric = '' } = experiment.until ?? {},
    name = metric || errorAndCostOf(experiment).error;
  const wide = (/** @type {Cells} */ row) => !(numberOf(row, `${name}.ci95`) <= Math.max(half, relative * Math.abs(numberOf(row, name))));
  const all = (/** @type {Cells} */ row) => numberOf(row, 'runs') + numberOf(row, 'failed') >= (experiment.repeats ?? 1);
  const short = half > 0 || relative > 0 ? rows.filter((row) => all(row) && wide(row)).length : 0;
  return [
    ...missing.map((/** @type {string} */ path) => t('experiments.note.missing', { metric: named(path), n: made })),
    ...(short > 0
      ? [t('experiments.note.short', { n: short, points: rows.length, repeats: experiment.repeats ?? 1, metric: named(name) })]
      : []),
  ];
}

/** The bounds of a mean's 95 % interval; NaN where there is none.
 * @param {Cells} row
 * @param {string} metric
 * @returns {{low: number, high: number}} */
export const boundsOf = (row, metric) => ({ low: numberOf(row, `${metric}.ci95_low`), high: numberOf(row, `${metric}.ci95_high`) });

/** By which method the interval was made, or why there is none. @param {Cells} row @param {string} metric */
export const methodOf = (row, metric) => (typeof row[`${metric}.ci95_method`] === 'string' ? String(row[`${metric}.ci95_method`]) : '');

/** A mean with its 95 % interval, if there is one; open where one bound is not known.
 * @param {Cells} row
 * @param {string} metric */
export function meanOf(row, metric) {
  const mean = numberOf(row, metric),
    { low, high } = boundsOf(row, metric);
  if (!Number.isFinite(mean) || (!Number.isFinite(low) && !Number.isFinite(high))) return exact(mean);
  if (!Number.isFinite(high)) return t('experiments.mean.from', { mean: exact(mean), low: exact(low) });
  if (!Number.isFinite(low)) return t('experiments.mean.to', { mean: exact(mean), high: exact(high) });
  return t('experiments.mean.from_to', { mean: exact(mean), low: exact(low), high: exact(high) });
}

/** Tooltip of a mean: the method of its interval, and the spread of the runs. @param {Cells} row @param {string} metric */
export function spreadOf(row, metric) {
  const value = (/** @type {string} */ end) => exact(numberOf(row, `${metric}.${end}`)),
    method = methodOf(row, metric);
  const spread = Number.isFinite(numberOf(row, `${metric}.sd`))
    ? t('experiments.spread', { sd: value('sd'), p25: value('p25'), p50: value('p50'), p75: value('p75') })
    : '';
  const covers = row[`${metric}.ci95_covers`];
  const interval = covers ? t('experiments.interval.covers', { method, covers: String(covers) }) : t('experiments.interval', { method });
  return [method && interval, spread].filter(Boolean).join('; ');
}
