// The experiment that is being written: texts as they are typed, and the specification that they make.
import { batch, computed, effect, signal } from '../../../../vendor/signals-core.js';
import { Problem, call, constant, make } from '../../../base/api.js';
import { metricHelp, metricRow } from '../../../base/metrics.js';
import { find, open, rowOf, schemaOf, valueAt } from '../../../base/schema.js';
import { decimalPoint, t } from '../../../base/words.js';
import { labs } from '../../../session/labs.js';
import { link } from '../../../session/opening.js';
import { schemas } from '../../../session/state.js';
import { needKind } from './names.js';
import { bareOf, partJson, partOf, toNumber } from './parts.js';

/** @typedef {import('../../../base/schema.js').Row} Row */
/** @typedef {{path: string, row: Row, value: unknown}} Variable  value: the scenario's */
/** @typedef {{path: string, joined: boolean, list: boolean, values: string, from: string, to: string, count: string,
 *   levels: string, log: boolean}} Axis
 *   joined: goes together with the one above; levels: how many values a range has of which points are drawn; empty: any */
/** @typedef {{path: string, value: string}} Fixed */
/** @typedef {{on: boolean, metric: string, half: string, relative: string, least: string}} Until
 *   runs of a point until its mean is known */
/** @typedef {{scenario: string | object, fixed: Fixed[], axes: Axis[], parts: import('./parts.js').Part[], metrics: string[],
 * error: string, cost: string, front: string[], repeats: string, until: Until, sampling: string, points: string, seed: string, title:
 * string, more: object}} Draft scenario: an id, or the whole; parts: windows; front: empty for error and cost; points: of a sample; more:
 * what has no control here (text, stop, traces) */

/** @type {Until} */
const NEVER = { on: false, metric: '', half: '', relative: '0.05', least: '10' };
/** @type {Draft} */
const EMPTY = {
  scenario: link.first,
  fixed: [],
  axes: [],
  parts: [],
  metrics: [],
  error: '',
  cost: '',
  front: [],
  repeats: '1',
  until: NEVER,
  sampling: 'none',
  points: '64',
  seed: '',
  title: '',
  more: {},
};

export const draft = signal(EMPTY);
/** The JSON Schema of experiments: ranges and helps of the fields. @type {import('@preact/signals-core').Signal<any>} */
export const rules = signal(null);
/** A field of the specification, such as until.least. @param {string} path @returns {Row | undefined} */
export const ruleOf = (path) => (rules.value ? (find(rules.value, path) ?? undefined) : undefined);
/** @param {Partial<Draft>} change */
export const write = (change) => {
  draft.value = { ...draft.value, ...change };
};

/** The scenario as JSON; null until it is read. @type {import('@preact/signals-core').Signal<any>} */
export const scenario = signal(null);
/** Paths of the numbers that its runs end with. @type {import('@preact/signals-core').Signal<string[]>} */
export const metrics = signal([]);
/** Columns of its trace, which has a row per tick. @type {import('@preact/signals-core').Signal<string[]>} */
export const traced = signal([]);
/** What they are, of every kind; null until it is read.
 * @type {import('@preact/signals-core').Signal<import('../../../base/metrics.js').MetricTables | null>} */
const tables = signal(null);
/** What the metric at a path is. @param {string} kind of the scenario @param {string} path */
export const metricAt = (kind, path) => (tables.value ? metricRow(tables.value, kind, bareOf(path)) : undefined);
/** In the daemon's words. @param {string} path of the scenario */
export function helpOf(path) {
  const row = scenario.value ? metricAt(scenario.value.kind, path) : undefined;
  return row ? metricHelp(row) : '';
}
/** Why the scenario could not be read. */
export const unread = signal('');

// ---- what can be varied ----

const FIXED = new Set(['kind', 'seed', 'title', 'paper', 'text', 'game', 'problem', 'scene', 'timeline', 'expect']);
const ELEMENTS = 8; /* of an array that are offered */

/** @param {any} root @param {any} whole @returns {Variable[]} */
function variablesOf(root, whole) {
  /** @type {Variable[]} */
  const found = [];
  const walk = (/** @type {any} */ node, /** @type {any} */ value, /** @type {string} */ path) => {
    const plain = open(root, node, ''); /* not a branch, if the node has its own type */
    const at = plain?.properties || plain?.items || plain?.type || plain?.enum ? plain : open(root, node);
    if (at?.properties) {
      for (const [name, child] of Object.entries(at.properties)) {
        if (path !== '' || !FIXED.has(name)) walk(child, value?.[name], path === '' ? name : `${path}.${name}`);
      }
    } else if (at?.items) {
      if (Array.isArray(value) && open(root, at.items)?.properties)
        value.slice(0, ELEMENTS).forEach((one, i) => walk(at.items, one, `${path}.${i}`));
    } else if (at) {
      const row = rowOf(path.slice(path.lastIndexOf('.') + 1), node, at);
      if (row.type !== 'text') found.push({ path, row, value: value ?? node.default ?? at.default });
    }
  };
  walk(root, whole, '');
  return found;
}

/** @param {any} whole a scenario @returns {Variable[]} none until its schema is read */
export function variablesIn(whole) {
  const root = whole && schemaOf(schemas.value.get(whole.kind), whole);
  return root ? variablesOf(root, whole) : [];
}
export const variables = computed(() => variablesIn(scenario.value));
/** @param {string} path */
export const variable = (path) => variables.value.find((one) => one.path === path);

// ---- the specification ----

/** @param {string} text @param {Row | undefined} row @returns {string | number | boolean} */
function toValue(text, row) {
  if (text === 'true' || text === 'false') return text === 'true';
  return row?.type === 'choice' ? text : toNumber(text);
}

/** Where a comma is the decimal sign, it divides values only before a space. @param {string} text @returns {string[]} */
export const listed = (text) => text.split(decimalPoint.value === ',' ? /,?\s+|;\s*/ : /[,;\s]+/).filter((part) => part !== '');

/** @param {Axis} axis @param {boolean} sampled */
function axisJson(axis, sampled) {
  const row = variable(axis.path)?.row;
  if (axis.list) return { path: axis.path, values: listed(axis.values).map((text) => toValue(text, row)) };
  const count = sampled ? axis.levels : axis.count;
  return {
    path: axis.path,
    from: toNumber(axis.from),
    to: toNumber(axis.to),
    ...(sampled && count.trim() === '' ? {} : { count: toNumber(count) }),
    ...(axis.log ? { scale: 'log' } : {}),
  };
}

/** @param {Until} until */
const untilJson = (until) => ({
  ...(until.metric === '' ? {} : { metric: until.metric }),
  ...(until.half.trim() === '' ? {} : { half_width: toNumber(until.half) }),
  ...(until.relative.trim() === '' ? {} : { relative: toNumber(until.relative) }),
  ...(until.least.trim() === '' ? {} : { least: toNumber(until.least) }),
});

/** Axes that go together, in groups. @param {Axis[]} axes @returns {Axis[][]} */
function groupsOf(axes) {
  /** @type {Axis[][]} */
  const groups = [];
  for (const axis of axes) {
    if (axis.joined && groups.length > 0) groups[groups.length - 1]?.push(axis);
    else groups.push([axis]);
  }
  return groups;
}

/** How the daemon names an axis. @param {number} index @returns {string} */
export function fieldOf(index) {
  let before = 0;
  for (const [g, group] of groupsOf(draft.value.axes).entries()) {
    if (index < before + group.length) return group.length > 1 ? `axes.${g}.zip.${index - before}` : `axes.${g}`;
    before += group.length;
  }
  return 'axes';
}

/** What is posted. @param {Draft} d */
export function specification(d) {
  const sampled = d.sampling !== 'none';
  const set = Object.fromEntries(
    d.fixed.filter((one) => one.path !== '').map((one) => [one.path, toValue(one.value, variable(one.path)?.row)]),
  );
  return {
    ...(d.title === '' ? {} : { title: d.title }),
    ...d.more,
    scenario: d.scenario,
    ...(Object.keys(set).length === 0 ? {} : { set }),
    axes: groupsOf(d.axes).map((group) =>
      group.length > 1 ? { zip: group.map((axis) => axisJson(axis, sampled)) } : axisJson(/** @type {Axis} */ (group[0]), sampled),
    ),
    ...(sampled
      ? { sample: { method: d.sampling, count: toNumber(d.points), ...(d.seed.trim() === '' ? {} : { seed: toNumber(d.seed) }) } }
      : {}),
    repeats: toNumber(d.repeats),
    ...(d.until.on ? { until: untilJson(d.until) } : {}),
    ...(d.parts.length === 0 ? {} : { windows: d.parts.map(partJson) }),
    metrics: d.metrics,
    ...(d.error === '' ? {} : { error: d.error }),
    ...(d.cost === '' ? {} : { cost: d.cost }),
    ...(d.front.length === 0 ? {} : { front: d.front }),
  };
}

/** @param {any} json @param {boolean} joined @returns {Axis} */
const axisOf = (json, joined) => ({
  path: String(json.path ?? ''),
  joined,
  list: Array.isArray(json.values),
  values: (json.values ?? []).map(String).join(', '),
  from: String(json.from ?? ''),
  to: String(json.to ?? ''),
  count: String(json.count ?? 5),
  levels: String(json.count ?? ''),
  log: json.scale === 'log',
});

/** @param {any} json @returns {Until} */
const untilOf = (json) =>
  json === undefined
    ? NEVER
    : {
        on: true,
        metric: json.metric ?? '',
        half: String(json.half_width ?? ''),
        relative: String(json.relative ?? ''),
        least: String(json.least ?? ''),
      };

/** An experiment as it is written. @param {any} json @returns {Draft} */
export function draftOf(json) {
  const {
    scenario: of,
    set = {},
    axes = [],
    windows = [],
    metrics: kept = [],
    error = '',
    cost = '',
    front = [],
    repeats = 1,
    until,
    sample,
    title = '',
    scenario_id: id = '',
    ...more
  } = json;
  return {
    scenario: id || of,
    fixed: Object.entries(set).map(([path, value]) => ({ path, value: String(value) })),
    axes: axes.flatMap((/** @type {any} */ axis) =>
      (axis.zip ?? [axis]).map((/** @type {any} */ one, /** @type {number} */ k) => axisOf(one, k > 0)),
    ),
    parts: windows.map(partOf),
    metrics: kept,
    error,
    cost,
    front,
    repeats: String(repeats),
    until: untilOf(until),
    sampling: sample?.method ?? 'none',
    points: String(sample?.count ?? 64),
    seed: String(sample?.seed ?? ''),
    title,
    more,
  };
}

/** Values that show most, where the scenario's own says little. @type {Record<string, Partial<Axis>>} */
const USUAL = {
  'players.0.lag_ms': { list: true, values: '0, 50, 100, 200, 300, 500' },
  'methods.0.dt_s': { from: '0.001', to: '0.1', count: '8', log: true },
  'params.n': { list: true, values: '16, 24, 32, 48, 64' },
};

/** An axis around the scenario's own value. @param {string} path @returns {Axis} */
export function axisAround(path) {
  const found = variable(path),
    row = found?.row,
    value = Number(found?.value);
  const list = row?.type === 'boolean' || row?.type === 'choice';
  const clip = (/** @type {number} */ v) => String(Number(Math.min(row?.max ?? v, Math.max(row?.min ?? v, v)).toPrecision(4)));
  const span = value > 0 ? [value / 4, value * 4] : [row?.min ?? 0, Math.min(row?.max ?? 1, (row?.min ?? 0) + 200)];
  const whole = row?.type === 'integer' ? Math.round : (/** @type {number} */ v) => v;
  return {
    path,
    joined: false,
    list,
    values: row?.type === 'boolean' ? 'false, true' : row?.type === 'choice' ? row.choices.join(', ') : '',
    from: clip(whole(span[0] ?? 0)),
    to: clip(whole(span[1] ?? 1)),
    count: '5',
    levels: '',
    log: false,
    ...USUAL[path],
  };
}

// ---- the scenario ----

const USUAL_AXES = ['players.0.lag_ms', 'methods.0.dt_s', 'params.n', 'solver.substeps', 'solver.iterations'];
/** What is compared, where a first axis alone could change nothing: a car that predicts answers at once at any lag. */
const COMPARED = { 'players.0.lag_ms': 'players.0.prediction' };
export const USUAL_METRICS = [
  'players.0.input_latency_ms.mean',
  'players.0.remote_error_m.mean',
  'methods.0.e_max',
  'methods.0.evaluations',
  'drift_worst_m',
  'penetration_worst_m',
  'error_max',
  'divergence_max',
];
/** @param {string} kind @returns {import('../../../session/lab.js').Study} */
const studyOf = (kind) => labs.value.find((one) => one.kind === kind)?.study ?? { axes: [], errors: /./, more: [], repeats: '1' };

/** @param {number | undefined} seconds @returns {Fixed[]} */
const shortened = (seconds) => (seconds === undefined ? [] : [{ path: 'duration_s', value: String(seconds) }]);

/** Paths of all numbers. @param {any} at @param {string} path @returns {string[]} */
function numbersIn(at, path) {
  if (at === null || typeof at !== 'object') return at === null || typeof at === 'number' || typeof at === 'boolean' ? [path] : [];
  return Object.entries(at).flatMap(([name, value]) => numbersIn(value, path === '' ? name : `${path}.${name}`));
}

/** The numbers that a run ends with, and has at every tick, are those of a session that has not begun.
 * @param {string | object} of @returns {Promise<[string[], string[]]>} */
async function numbersOf(of) {
  const made = await make('sessions', { scenario: of, paused: true });
  const [answer, ticks] = await Promise.all([
    call('GET', `sessions/${made.id}/metrics`),
    call('GET', `sessions/${made.id}/trace?to_s=0&format=json`).catch(() => []), // it may have too many columns for this format
  ]);
  call('DELETE', `sessions/${made.id}`, { key: made.owner_key }).catch(() => {});
  return [numbersIn(answer.metrics, ''), Object.keys(ticks[0] ?? {}).filter((name) => name !== 'time_s' && name !== 'tick')];
}

/** @param {string} kind */
export async function readSchema(kind) {
  if (schemas.value.has(kind)) return;
  const answer = await constant(`schema?kind=${kind}&brief=true`);
  if (!schemas.value.has(kind)) schemas.value = new Map(schemas.value).set(kind, answer);
}

let reading = 0;

/** @param {string | object} of @param {((whole: any, paths: string[]) => void) | null} fresh gives it axes and metrics that suit it
 * @param {any} [known] the whole scenario, where it is there */
async function read(of, fresh, known) {
  const turn = ++reading;
  try {
    const whole = known ?? (typeof of === 'string' ? await call('GET', `scenarios/${of}`) : of);
    if (rules.value === null) rules.value = await constant('experiments/schema');
    if (tables.value === null) tables.value = await constant('metrics');
    await readSchema(whole.kind);
    const [[paths, columns]] = await Promise.all([numbersOf(of), needKind(whole.kind)]);
    if (turn !== reading) return;
    batch(() => {
      unread.value = '';
      scenario.value = whole;
      metrics.value = [...paths, 'cost.ns_per_sim_s']; /* measured, of every kind */
      traced.value = columns;
      fresh?.(whole, paths);
    });
  } catch (error) {
    if (turn === reading) unread.value = error instanceof Problem ? error.message : t('experiments.no_answer');
  }
}

/** @param {any} whole @param {string[]} paths */
function begin(whole, paths) {
  const usual = USUAL_METRICS.filter((path) => paths.includes(path)).slice(0, 2);
  const path = USUAL_AXES.find((one) => variable(one)) ?? variables.value.find((one) => one.row.type === 'number')?.path ?? '';
  const axes = [path, /** @type {Record<string, string>} */ (COMPARED)[path] ?? ''].filter((one) => one !== '' && variable(one));
  write({
    axes: axes.map(axisAround),
    metrics: usual.length > 0 ? usual : paths.filter((one) => one !== 't_s').slice(0, 2),
    fixed: shortened(studyOf(whole.kind).brief_s),
  });
}

// ---- speed against error ----

/** @param {any} whole @param {string[]} paths */
function beginWorkPrecision(whole, paths) {
  const { brief_s: brief, ...trade } = studyOf(whole.kind);
  const axes = trade.axes.flatMap((group) =>
    group
      .filter(([path]) => variable(path))
      .map(([path, values], k) => {
        const around = axisAround(path);
        return { ...around, joined: k > 0, list: true, values: values || around.values };
      }),
  );
  const error = paths.find((path) => trade.errors.test(path)) ?? paths[0] ?? '',
    measured = 'cost.ns_per_sim_s';
  write({
    axes,
    metrics: [error, measured, ...trade.more.filter((path) => paths.includes(path))],
    error,
    cost: measured,
    repeats: trade.repeats,
    fixed: shortened(brief),
    title: `${t('workbench.diagram')}: ${whole.title ?? whole.kind}`,
  });
}

/** Every method that the scenario can take, by its own setting: error against the processor's time. @param {any} of an id, or the whole */
export function measure(of) {
  draft.value = { ...EMPTY, scenario: of };
  read(of, beginWorkPrecision);
}

// ---- another scenario ----

/** Another scenario, with axes and metrics that suit it. @param {string} id */
export function choose(id) {
  draft.value = { ...EMPTY, scenario: id };
  read(id, begin);
}

/** An experiment as the starting point, of the library or of one's own.
 * @param {any} json @param {any} [whole] its scenario, where it is there */
export function start(json, whole) {
  draft.value = draftOf(json);
  read(draft.value.scenario, null, whole);
}

// ---- estimate of the runs ----

/** @typedef {{points: number, runs: number, run_s: number, estimated_cpu_s: number}} Estimate */
/** @type {import('@preact/signals-core').Signal<Estimate | null>} */
export const estimate = signal(null);
/** What the daemon refuses, by the field that it names; one without a field has the empty name.
 * @type {import('@preact/signals-core').Signal<Map<string, string>>} */
export const refused = signal(new Map());
export const checking = signal(false);

/** @param {unknown} error */
export function refuse(error) {
  const list = error instanceof Problem ? error.errors : [];
  const found = new Map(list.map(({ field, detail }) => [field, detail]));
  if (found.size === 0) found.set('', error instanceof Problem ? error.message : t('experiments.no_answer'));
  refused.value = found;
}

const PAUSE_MS = 400; /* after the last key */
let wanted = '';
/** @type {ReturnType<typeof setTimeout> | undefined} */
let timer;

/** Asks again until the answer is that of the newest text: one question at a time. */
async function check() {
  if (checking.value) return;
  checking.value = true;
  while (wanted !== '') {
    const body = wanted;
    try {
      const answer = await make('experiments?dry_run=true', JSON.parse(body), false);
      batch(() => {
        estimate.value = answer;
        refused.value = new Map();
      });
    } catch (error) {
      batch(() => {
        estimate.value = null;
        refuse(error);
      });
    }
    if (wanted === body) wanted = '';
  }
  checking.value = false;
}

/** Keeps the estimate up to date from now on. */
export function watch() {
  let last = '';
  return effect(() => {
    const text = scenario.value === null ? '' : JSON.stringify(specification(draft.value));
    if (text === last) return;
    last = text;
    clearTimeout(timer);
    timer = setTimeout(() => {
      wanted = text;
      check();
    }, PAUSE_MS);
  });
}

/** @param {string} path @returns {unknown} */
export const own = (path) => valueAt(scenario.value, path) ?? variable(path)?.value;
