// What is plotted of an experiment: the axes, the series, the front.
import { computed, signal } from '../../../vendor/signals-core.js';
import { columnsOf, errorAndCostOf, frontMetricsOf, frontOfAll, numberOf } from './columns.js';
import { metricAt, variablesIn } from './draft.js';
import { metricName } from './names.js';
import { SERIES_MAX, seriesOf } from './scatter.js';
import { points, record, scenario, selected } from './shown.js';

/** Choices of a person; empty ones follow from the experiment.
 * @type {import('@preact/signals-core').Signal<{x: string, y: string, by: string | null, logX: boolean | null, logY: boolean | null}>} */
export const chosen = signal({ x: '', y: '', by: null, logX: null, logY: null });
const units = computed(() => new Map(variablesIn(scenario.value).map(({ path, row }) => [path, row.unit])));
const unitOf = (/** @type {string} */ path) => metricAt(scenario.value?.kind, path)?.unit;
export const columns = computed(() =>
  record.value ? columnsOf(record.value.experiment, points.value, scenario.value, (path) => units.value.get(path), unitOf) : [],
);
/** What a column is called. @param {string} name */
export const labelOf = (name) => columns.value.find((column) => column.name === name)?.label ?? name;
/** The same of a metric, also before there are points. @param {string} path */
export const named = (path) => metricName(path, unitOf(path), scenario.value);
export const trade = computed(() => (record.value ? errorAndCostOf(record.value.experiment) : { error: '', cost: '' }));

/** @param {string} name */
export const positive = (name) =>
  points.value.some((row) => numberOf(row, name) > 0) && points.value.every((row) => !(numberOf(row, name) <= 0));

/** A logarithmic axis serves where values span more than this. */
const SPAN_LOG = 20;

/** @param {string} name */
function spans(name) {
  const values = points.value.map((row) => numberOf(row, name)).filter(Number.isFinite);
  return positive(name) && Math.max(...values) / Math.min(...values) > SPAN_LOG;
}

/** @type {import('@preact/signals-core').ReadonlySignal<import('./scatter.js').Choice>} */
export const plotted = computed(() => {
  const c = chosen.value,
    { error, cost } = trade.value,
    axes = columns.value.filter((column) => column.kind === 'axis');
  const known = (/** @type {string} */ name) => columns.value.some((column) => column.name === name && column.numbers);
  const varies = (/** @type {string} */ name) => new Set(points.value.map((row) => row[name])).size > 1;
  const x = known(c.x) ? c.x : known(cost) && varies(cost) ? cost : (axes.find((column) => column.numbers)?.name ?? cost);
  const y = known(c.y) ? c.y : error;
  const several = (/** @type {string} */ name) => {
    const n = seriesOf(points.value, name).length;
    return n > 1 && n <= SERIES_MAX;
  };
  const by =
    c.by ??
    axes.find((column) => !column.numbers && several(column.name))?.name ??
    (axes.length > 1 ? axes.find((column) => column.name !== x && several(column.name))?.name : '') ??
    '';
  return { x, y, by, logX: (c.logX ?? spans(x)) && positive(x), logY: (c.logY ?? spans(y)) && positive(y) };
});
/** The front, where both sides of the trade are plotted, or tabled; that of more metrics is tabled alone. */
export const fronted = computed(() => (record.value ? frontMetricsOf(record.value.experiment) : []));
export const front = computed(() => frontOfAll(points.value, fronted.value));
export const plotsErrorAndCost = computed(() => {
  const { x, y } = plotted.value,
    { error, cost } = trade.value;
  return (
    cost !== '' &&
    fronted.value.length === 2 &&
    fronted.value.includes(cost) &&
    fronted.value.includes(error) &&
    ((x === cost && y === error) || (x === error && y === cost))
  );
});

/** @param {number} index */
export function select(index) {
  selected.value = index;
}
