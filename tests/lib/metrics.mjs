// Metrics of runs compared with the tables of GET /api/v1/metrics: each member is a row, with its type, null only where the row says when.
import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { promisify } from 'node:util';
import { BINARY } from './daemon.mjs';

/** @typedef {{name: string, type: string, unit?: string, signed?: boolean, rate?: boolean, rare?: boolean, help: string,
 * null?: string}} Row */
/** @typedef {{path: string, also?: string, when?: string, help: string, metrics: Row[]}} Table */

const DISTRIBUTION = ['mean', 'rms', 'p50', 'p95', 'p99', 'max', 'count'];
const PARTS = { distribution: DISTRIBUTION, latency: [...DISTRIBUTION, 'lost_ratio'], gauge: ['mean', 'min', 'max', 'count'] };
/** When a row is null for these reasons alone, as the status of its object has it. */
const REASONS = {
  'The world has diverged.': ['diverged'],
  'The fluid has diverged.': ['diverged'],
  'The method was not run.': ['off'],
  'The status of the method is not ok.': ['diverged', 'failed', 'off'],
};
/** What no scenario of the library does. */
const ARM = (/** @type {string} */ method) => ({ method, substeps: 1 });
const OTHERS = [
  // an arm that turns by half a radian a step, which one substep of XPBD does not hold; a step that is too long for one substep
  {
    kind: 'rigid',
    duration_s: 4,
    gravity: [0, 0],
    hz: 50,
    solver: ARM('avbd'),
    side_by_side: [{ solver: ARM('xpbd') }],
    bodies: [
      { type: 'static', size: [0.2, 0.2] },
      ...[1, 2].map((x) => ({ size: [0.2, 0.2], position: [x, 0], velocity: [0, 25], angular_velocity: 25 })),
    ],
    joints: [0, 1].map((a) => ({ type: 'revolute', a, b: a + 1, anchor_a: [0, 0], anchor_b: [-1, 0] })),
  },
  { kind: 'fluid', scene: 'taylor_green', params: { n: 32 }, hz: 2, duration_s: 5, side_by_side: [{ solver: { substeps: 1 } }] },
  {
    kind: 'rigid',
    duration_s: 0.5,
    compare_volumes: true,
    bodies: [
      { type: 'static', shape: 'box', size: [9, 1] },
      { type: 'dynamic', shape: 'circle', radius: 0.5, position: [0, 1.25] },
    ],
  },
];
const PARALLEL = 2;

/** Whether the names of a path fit a pattern, or are the beginning of what does. @param {string[]} path @param {string} pattern */
function fits(path, pattern) {
  const parts = pattern === '' ? [] : pattern.split('.');
  const begins = path.length <= parts.length && path.every((name, i) => parts[i] === '*' || parts[i] === name);
  return { begins, whole: begins && path.length === parts.length };
}

const number = (/** @type {any} */ value) => value === null || (typeof value === 'number' && Number.isFinite(value));
const members = (/** @type {any} */ value, /** @type {string[]} */ names) =>
  Object.keys(value).join() === names.join() && Object.values(value).every(number);

/** @type {Record<string, (value: any) => boolean>} */
const TYPES = {
  number,
  count: (value) => value === null || Number.isInteger(value),
  flag: (value) => typeof value === 'boolean',
  text: (value) => typeof value === 'string',
  numbers: (value) => Array.isArray(value) && value.every(number),
  distribution: (value) => members(value, PARTS.distribution),
  latency: (value) => members(value, PARTS.latency),
  gauge: (value) => members(value, PARTS.gauge),
  by_name: (value) => !Array.isArray(value) && members(value, Object.keys(value)),
  curve: (value) => Array.isArray(value) && value.every((pair) => pair.length === 2 && pair.every(number)),
  notices: (value) => Array.isArray(value) && value.every((text) => typeof text === 'string'),
};

const isNull = (/** @type {any} */ value) =>
  value === null || (typeof value === 'object' && Object.values(value).some((part) => part === null));

/** @param {Row} row @param {any} value @param {any} object @param {string} where */
function check(row, value, object, where) {
  assert.ok(TYPES[row.type](value), `${where} is no ${row.type}: ${JSON.stringify(value).slice(0, 120)}`);
  if (isNull(value)) {
    assert.ok(row.null, `${where} is null, and its row does not say when`);
    const status = REASONS[row.null];
    assert.ok(!status || status.includes(object.status), `${where} is null with status ${object.status}: ${row.null}`);
  } else {
    const status = REASONS[row.null];
    assert.ok(!status?.includes(object.status), `${where} is not null with status ${object.status}: ${row.null}`);
  }
}

/**
 * @param {any} value @param {string[]} path @param {Table[]} tables @param {Set<Row>} seen
 * @param {string} run
 */
function walk(value, path, tables, seen, run) {
  const places = tables.map((table) => {
    const at = [table.path, ...(table.also ? [`${table.also}${table.path ? `.${table.path}` : ''}`] : [])].map((pattern) =>
      fits(path, pattern),
    );
    return { table, begins: at.some((one) => one.begins), whole: at.some((one) => one.whole) };
  });
  assert.ok(
    places.some(({ begins }) => begins),
    `${run}: ${path.join('.')} is in no table`,
  );
  if (Array.isArray(value)) {
    value.forEach((part, i) => walk(part, [...path, String(i)], tables, seen, run));
    return;
  }
  const rows = places.filter(({ whole }) => whole).flatMap(({ table }) => table.metrics);
  for (const [name, part] of Object.entries(value)) {
    const where = `${run}: ${[...path, name].join('.')}`,
      found = rows.filter((row) => row.name === name);
    if (found.length === 0) {
      assert.ok(part !== null && typeof part === 'object', `${where} is in no table`);
      walk(part, [...path, name], tables, seen, run);
      continue;
    }
    check(/** @type {Row} */ (found[0]), part, value, where);
    found.forEach((row) => seen.add(row));
  }
}

/** Of one run, for as long as the scenario has it unless `duration_s` is given.
 * @param {string | object} scenario @param {number} [duration_s] @param {Record<string, any>} [set] */
export async function metricsOf(scenario, duration_s, set = {}) {
  const own = typeof scenario === 'object',
    settings = Object.entries(set).flatMap(([name, value]) => ['--set', `${name}=${JSON.stringify(value).replace(/^"(.*)"$/, '$1')}`]),
    args = ['run', own ? '-' : scenario, ...(duration_s === undefined ? [] : ['--duration', String(duration_s)]), ...settings],
    running = promisify(execFile)(BINARY, args, { maxBuffer: 1 << 28 });
  if (own) running.child.stdin?.end(JSON.stringify(scenario));
  return JSON.parse((await running).stdout).metrics;
}

/** Runs what no scenario does, and scenarios. Fails when a row is not among their metrics.
 * @param {{id: string, kind: string}[]} scenarios @param {{kinds: any[], common: Table[]}} rows
 * @param {boolean} [each] else no more when every row was there. @returns {Promise<number>} how many it ran */
export async function checkMetrics(scenarios, { kinds, common }, each = false) {
  const runs = [
      ...OTHERS.map((input) => ({ name: '-', kind: input.kind, input })),
      ...scenarios.map((one) => ({ name: one.id, kind: one.kind, input: undefined })),
    ],
    seen = new Set(),
    never = () =>
      [...kinds, { kind: 'any', tables: common }].flatMap((kind) =>
        kind.tables.flatMap((/** @type {Table} */ table) =>
          table.metrics.filter((row) => !seen.has(row)).map((row) => `${kind.kind} ${table.path} ${row.name}`),
        ),
      );
  let done = 0;
  const next = async () => {
    for (let run = runs.shift(); run && (each || never().length > 0); run = runs.shift()) {
      const { tables } = kinds.find((kind) => kind.kind === run.kind);
      walk(await metricsOf(run.input ?? run.name), [], [...tables, ...common], seen, run.name);
      done++;
    }
  };
  await Promise.all(Array.from({ length: PARALLEL }, next));
  assert.deepEqual(never(), []);
  return done;
}
