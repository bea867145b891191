// What is plotted of an experiment: the axes, the series, the front.
import { computed, signal } from '../../../vendor/signals-core.js';
import { localized, plain } from '../../base/format.js';
import { t, unitName } from '../../base/words.js';
import { columnsOf, errorAndCostOf, formatValue, frontMetricsOf, frontOfAll, numberOf } from './columns.js';
import { metricAt, variablesIn } from './form/draft.js';
import { inputName, metricName, wholeName } from './form/names.js';
import { SERIES_MAX, seriesOf } from './scatter.js';
import { askedBy } from './examples.js';
import { seriesIn } from './finding.js';
import { before, finished, points, record, scenario, selected } from './shown.js';

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
  const against = record.value?.experiment.cost ? cost : '' /* else what is varied is an axis */,
    x = known(c.x) ? c.x : known(against) && varies(against) ? cost : (axes.find((column) => column.numbers)?.name ?? cost);
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

// ---- lines over what is varied ----

/** The points, and those of the run before where their own are still to come.
 * @type {import('@preact/signals-core').ReadonlySignal<import('./shown.js').Cells[]>} */
export const drawn = computed(() => {
  const there = new Set(points.value.map((row) => row.point));
  /** @type {import('./shown.js').Cells[]} */
  const old = before.value.filter((row) => !there.has(row.point ?? null)).map((row) => ({ ...row, old: true }));
  return [...points.value, ...old].sort((a, b) => Number(a.point) - Number(b.point));
});

/** What was varied as numbers, which lies across, and what is compared, of which each value has a line: by their columns. Null where the
 * points make no such lines: drawn at random, against a cost, or over more axes.
 * @type {import('@preact/signals-core').ReadonlySignal<{x: string, xPath: string, by: string, byPath: string} | null>} */
export const lined = computed(() => {
  const of = record.value?.experiment,
    rows = drawn.value;
  if (!of || of.cost || of.sample || rows.length === 0) return null;
  const groups = (of.axes ?? []).map((/** @type {any} */ axis) =>
    (axis.zip ?? [axis]).map((/** @type {any} */ one) => columns.value.find((column) => column.path === one.path)).filter(Boolean),
  );
  const count = (/** @type {string} */ name) => new Set(rows.map((row) => row[name])).size;
  const across = groups.find((/** @type {any[]} */ group) => group[0]?.numbers && count(group[0].name) > 1),
    others = groups.filter((/** @type {any[]} */ group) => group !== across);
  if (!across || others.length > 1) return null;
  const [x] = across,
    by = [...(others[0] ?? [])].sort((a, b) => count(b.name) - count(a.name))[0],
    lines = by ? count(by.name) : 1;
  if (lines > SERIES_MAX || rows.length > lines * count(x.name)) return null;
  return { x: x.name, xPath: x.path, by: by?.name ?? '', byPath: by?.path ?? '' };
});

/** The example whose question is asked, if one is. */
export const asked = computed(() => (record.value ? askedBy(finished.value, record.value.experiment) : undefined));

/** What is varied, with its unit. @param {string} path */
export function inputLabel(path) {
  const unit = units.value.get(path),
    plainly = t(`experiments.label.${path}`);
  if (plainly === '') return wholeName(path, unit, scenario.value);
  return unit && !path.endsWith('_hz') ? `${plainly}, ${unitName(unit)}` : plainly;
}
/** A value of what is varied, as a sentence has it. @param {string} path @param {number} value */
export function inputValue(path, value) {
  const unit = units.value.get(path);
  return `${localized(plain(value))}${unit ? ` ${unitName(unit)}` : ''}`;
}
/** Of what was measured. @param {string} path @returns {string} */
export const unitSaid = (path) => unitName(unitOf(path) ?? '');
/** @param {string} path of a metric: how its chart is called */
export const metricSaid = (path) => t(`experiments.metric.${path}`) || named(path);
/** A line's value, of what is compared. @param {string} name */
export const valueSaid = (name) =>
  formatValue(Number.isNaN(Number(name)) || name === '' ? name : Number(name), lined.value?.byPath ?? '', scenario.value);
/** A line's name. @param {string} name */
export function lineSaid(name) {
  const path = lined.value?.byPath ?? '';
  return path === '' ? '' : `${inputName(path, '', scenario.value)} ${valueSaid(name)}`;
}
/** What is measured, in its lines. @type {import('@preact/signals-core').ReadonlySignal<import('./finding.js').Measured[]>} */
export const measured = computed(() => {
  const of = lined.value;
  if (!of) return [];
  return record.value.experiment.metrics.map((/** @type {string} */ path) => ({
    path,
    series: seriesIn(drawn.value, of.x, of.by, path),
    name: metricSaid(path),
    unit: unitSaid(path),
  }));
});

/** All that was tried of what lies across. */
export const tried = computed(() =>
  [...new Set(drawn.value.map((row) => numberOf(row, lined.value?.x ?? '')).filter(Number.isFinite))].sort((a, b) => a - b),
);

/** The place that is marked: that of the selected point; else that of the example, or one past the middle. */
export const marked = computed(() => {
  const row = points.value[selected.value],
    own = asked.value?.at ?? Number.NaN;
  if (row && lined.value) return numberOf(row, lined.value.x);
  return tried.value.includes(own) ? own : (tried.value[Math.floor(0.6 * tried.value.length)] ?? Number.NaN);
});
/** The points there, one of each line. */
export const atMark = computed(() => points.value.filter((row) => lined.value && numberOf(row, lined.value.x) === marked.value));
/** @param {number} index */
export function select(index) {
  selected.value = index;
}
