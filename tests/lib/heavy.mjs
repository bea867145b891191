// The heaviest small request of every operation of openapi.yaml: valid and invalid, and below the sizes at which the daemon reads it
// elsewhere. A new operation without a row here fails tests/daemon/stall.test.mjs.
import { client, waitFor } from './client.mjs';

/**
 * One request; `path` is the operation's, unless it says another. `made`: what its answer creates is deleted again.
 * @typedef {{path?: string, query?: string, key?: string, body?: any, type?: string, headers?: Record<string, string>}} Request
 * @typedef {Awaited<ReturnType<typeof prepare>>} Place
 */

const SHORT = 4000, // bytes of a body that threads of short requests read
  LONG = 64000;

const POOL = { kind: 'fluid', scene: 'pool', params: { size: 400 }, duration_s: 600 };
const MOTION = { kind: 'motion', problem: 'oscillator', duration_s: 1000, methods: [{ method: 'rk4', dt_s: 0.001 }] };
const PERSON = { 'players.0.control': 'person' };
const METRICS = ['players.0.remote_error_m.mean'];

// ---- shapes of bodies that are slow to read or to refuse ----

const repeated = (part, bytes) => Array.from({ length: Math.floor(bytes / (part.length + 1)) }, () => part).join();
const members = (value, bytes) => Array.from({ length: Math.floor(bytes / (value.length + 8)) }, (_, i) => `"k${i}":${value}`).join();

/** @param {number} bytes @returns {string[]} */
const shapes = (bytes) => [
  `{"a":${'['.repeat(900)}${']'.repeat(900)}}`,
  `{${'"a":{'.repeat(Math.floor(bytes / 7))}${'}'.repeat(Math.floor(bytes / 7))}}`,
  `{${members('1', bytes)}}`,
  `{${repeated('"a":1', bytes)}}`,
  `{"a":[${repeated('1e-300', bytes)}]}`,
  `{"a":[${repeated('{}', bytes)}]}`,
  `{"a":${'1'.repeat(bytes - 8)}}`,
  `{"${'\\u00e9'.repeat(Math.floor(bytes / 6) - 4)}":1}`,
  `{"a":"${'\\u0041'.repeat(Math.floor(bytes / 6) - 4)}"}`,
  ' '.repeat(bytes),
  `{"a":1${' '.repeat(bytes - 10)}`,
];
const bodies = (type = 'application/json') => [...shapes(SHORT), ...shapes(LONG)].map((body) => ({ body, type }));
const MERGE = 'application/merge-patch+json';

/** Queries that are slow to read. */
const QUERIES = [
  `?${'tick=1&'.repeat(1800)}`,
  `?${'%61'.repeat(4000)}=1`,
  `?${'a&'.repeat(6000)}`,
  `?tick=${'9'.repeat(12000)}&from_s=${'0'.repeat(2000)}`,
];
const queries = (...own) => [...QUERIES, ...own].map((query) => ({ query }));

const axis = (path, count, to = count) => ({ path, values: Array.from({ length: count }, (_, i) => (i * to) / count) });
const LAGS = axis('players.0.lag_ms', 1000),
  MORE_LAGS = axis('players.1.lag_ms', 1000);
const RANGE = { from: 0, to: 900, count: 10000 };
/** Axes: too many runs, many values, values that a rule refuses. */
const EXPERIMENTS = [
  { scenario: 'race', metrics: METRICS, axes: [LAGS, MORE_LAGS, { path: 'server.update_hz', from: 1, to: 99, count: 99 }] },
  {
    scenario: 'race',
    metrics: METRICS,
    axes: [0, 1, 2].map((i) => axis(`players.${i % 2}.link.${i < 2 ? 'up' : 'down'}.jitter_ms`, 3600, 100)),
  },
  { scenario: 'race', metrics: METRICS, axes: ['lag_ms', 'link.up.jitter_ms'].map((name) => ({ path: `players.0.${name}`, ...RANGE })) },
  {
    scenario: 'race',
    metrics: METRICS,
    set: { duration_s: 0.1 },
    axes: [{ zip: ['players.0.lag_ms', 'players.1.lag_ms'].map((path) => ({ path, ...RANGE, to: 500 })) }],
  },
  { scenario: 'race', metrics: METRICS, axes: [{ ...LAGS, values: [...LAGS.values, 'none'] }] },
  { scenario: 'crates_200', metrics: Array.from({ length: 32 }, (_, i) => `players.0.lag_ms@w${i}`), axes: [LAGS] },
  { scenario: POOL, metrics: ['kinetic_energy'] },
];
const advice = (experiment) => ({ max_error: 1e-3, runs: 2000, experiment: { repeats: 20, cost: experiment.metrics[0], ...experiment } });

/** Settings of a session, by path: each of many, and one of them again and again. */
const SETTINGS = [
  {
    players: Object.fromEntries(
      [0, 1].map((i) => [i, { lag_ms: 20, link: { up: { jitter_ms: 3 }, down: { jitter_ms: 3, loss_pct: 1 } } }]),
    ),
  },
  { 'players.0.lag_ms': 20, 'players.1.lag_ms': 30, 'server.update_hz': 30, 'players.0.link.up.jitter_ms': 2 },
];
const settings = (bytes) => [
  ...SETTINGS,
  `{${repeated('"players.0.lag_ms":9', bytes)}}`,
  `{${members('{"lag_ms":1}', bytes)}}`,
  `{"players":{${members('{"lag_ms":1}', bytes - 20)}}}`,
  `{"players.0.link.${'x.'.repeat(Math.floor(bytes / 2) - 30)}":1}`,
  `{"timeline":[${repeated('{"t_s":1,"set":{}}', bytes - 20)}]}`,
];

const race = (more = {}) => ({ scenario: 'race', paused: true, ...more });
const SESSIONS = [
  race(),
  { scenario: 'crates_200' },
  { scenario: POOL },
  race({ set: { players: 1 } }),
  race({ set: PERSON, workload: { inputs: Array.from({ length: 900 }, (_, i) => ({ tick: i, player: 0, axes: [0.5, 1] })) } }),
  ...settings(LONG).map((set) => (typeof set === 'string' ? `{"scenario":"race","set":${set}}` : race({ set }))),
];

const wrong = (place) => [{ key: place.played.owner_key.replace(/.$/, 'x') }, { key: 'k'.repeat(8000) }, {}];

/** @type {Record<string, (place: Place) => Request[]>} */
export const HEAVY = {
  listScenarios: () => queries('', '?brief=true'),
  getScenario: () =>
    queries('').flatMap((one) => ['crates_200', 'x'.repeat(4000)].map((id) => ({ ...one, path: `/api/v1/scenarios/${id}` }))),
  getSchema: () => queries('', '?brief=true', '?kind=netgame', '?kind=none'),
  getOpenapi: () => queries(''),
  getSchemas: () => queries(''),
  getStreamSchema: () => queries(''),
  getMetricTables: () => queries(''),
  getAsyncapi: () => queries(''),
  getCreation: () => queries(''),
  setCreation: () => bodies(),
  listClassKeys: (place) => [...queries(''), { key: place.played.owner_key }],
  listSessions: (place) => [...queries('', '?limit=1000'), { key: place.played.owner_key }],
  createSession: () => [...SESSIONS.map((body) => ({ body })), ...bodies()],
  getSession: (place) => [place.old, place.pool, place.motion].map(({ id }) => ({ path: `/api/v1/sessions/${id}` })),
  deleteSession: (place) => wrong(place), // sessions that are made by other rows are deleted too
  patchParams: (place) => [
    ...settings(SHORT).map((body) => ({ body, type: MERGE, key: place.played.owner_key })),
    ...settings(LONG).map((body) => ({ body, type: MERGE, key: place.played.owner_key })),
    ...bodies(MERGE).map((one) => ({ ...one, key: place.played.owner_key })),
    { path: `/api/v1/sessions/${place.pool.id}/params`, body: { solver: { substeps: 2 } }, type: MERGE, key: place.pool.owner_key },
    { path: `/api/v1/sessions/${place.motion.id}/params`, body: { params: { omega: 1.1 } }, type: MERGE, key: place.motion.owner_key },
  ],
  controlSession: (place) => [
    ...['step', 'restart', 'pause', 'play'].map((op) => ({ body: { op }, key: place.played.owner_key })),
    ...[0, 0.9].map((part) => ({
      body: { op: 'seek', tick: Math.round(part * 90000) },
      key: place.old.owner_key,
      path: `/api/v1/sessions/${place.old.id}/control`,
    })),
    { body: { op: 'step', ticks: 3000 }, key: place.played.owner_key },
    { body: { op: 'step', ticks: 10 }, key: place.pool.owner_key, path: `/api/v1/sessions/${place.pool.id}/control` },
    { body: { op: 'speed', speed: 3 }, key: place.pool.owner_key, path: `/api/v1/sessions/${place.pool.id}/control` },
    ...bodies().map((one) => ({ ...one, key: place.played.owner_key })),
  ],
  postInput: (place) => [
    { body: { player: 0, axes: [1, 0.3], buttons: 1 }, key: place.played.owner_key },
    ...bodies().map((one) => ({ ...one, key: place.played.owner_key })),
  ],
  forkSession: (place) => [{ path: `/api/v1/sessions/${place.old.id}/fork`, body: {} }, ...bodies()],
  getState: (place) => [
    ...queries(),
    ...[place.pool, place.old].map(({ id }) => ({ path: `/api/v1/sessions/${id}/state` })),
    { path: `/api/v1/sessions/${place.old.id}/state`, query: '?tick=80001' },
  ],
  getHello: (place) => [place.pool, place.old].map(({ id }) => ({ path: `/api/v1/sessions/${id}/hello` })),
  getFrame: (place) => [
    ...queries(),
    ...[place.pool, place.old].map(({ id }) => ({ path: `/api/v1/sessions/${id}/frame` })),
    { path: `/api/v1/sessions/${place.old.id}/frame`, query: `?channels=${'scene,'.repeat(1500)}scene` },
  ],
  getMetrics: (place) => [place.pool, place.old].map(({ id }) => ({ path: `/api/v1/sessions/${id}/metrics` })),
  getTrace: (place) =>
    ['?from_s=0&to_s=1500', `?of=${'entities,'.repeat(1500)}`, '?of=packets&format=sqlite&to_s=20'].map((query) => ({
      path: `/api/v1/sessions/${place.old.id}/trace`,
      query,
    })),
  getPackets: (place) => [{ path: `/api/v1/sessions/${place.old.id}/packets`, query: '?to_s=100' }, ...queries()],
  getLog: (place) => [{ path: `/api/v1/sessions/${place.logged.id}/log` }, ...queries('')],
  openStream: () => [{}],
  listExperiments: () => queries(''),
  createExperiment: () => [...EXPERIMENTS.flatMap((body) => [{ body, query: '?dry_run=true' }, { body }]), ...bodies()],
  getExperimentSchema: () => queries(''),
  listLibrary: () => queries(''),
  getExperiment: () => queries(''),
  deleteExperiment: (place) => wrong(place),
  controlExperiment: (place) => [
    { body: { op: 'pause' }, key: place.experiment.owner_key },
    ...bodies().map((one) => ({ ...one, key: place.experiment.owner_key })),
  ],
  openExperimentStream: () => [{}],
  getResults: () => queries('?format=csv', '?format=sqlite', '?points=true&compare=0', '?sensitivity=true'),
  getReport: () => queries(''),
  getRun: () => queries(''),
  getRunTrace: () => queries('', '?format=sqlite'),
  advise: () => [...EXPERIMENTS.map((experiment) => ({ body: advice(experiment) })), ...bodies()],
  getAdvice: () => queries(''),
  deleteAdvice: (place) => wrong(place),
  listTradeoffs: () => queries(''),
  measureTradeoff: () => [
    { body: { family: 'synchronisation', seeds: 100 } },
    { body: { family: 'integrators', methods: Array.from({ length: 1000 }, () => 'rk4') } },
    { body: { family: 'integrators', methods: Array.from({ length: 1000 }, (_, i) => `none${i}`) } },
    ...bodies(),
  ],
  getTradeoff: () => queries(''),
  deleteTradeoff: (place) => wrong(place),
  getCode: (place) => [place.played.code, 'ZZZZ', 'x'.repeat(4000)].map((code) => ({ path: `/api/v1/codes/${code}` })),
  openClass: () => [{ body: {} }, { body: { title: 'x'.repeat(3000) } }, ...bodies()],
  getClass: () => queries(''),
  changeClass: (place) => [
    { body: { phase: 'lobby' }, type: MERGE, key: place.class.teacher_key },
    ...bodies(MERGE).map((one) => ({ ...one, key: place.class.teacher_key })),
  ],
  endClass: (place) => wrong(place),
  setBoard: (place) => [
    ...SESSIONS.map((body) => ({ body, key: place.class.teacher_key })),
    ...bodies().map((one) => ({ ...one, key: place.class.teacher_key })),
  ],
  freeSeat: (place) => [{ key: place.class.teacher_key }, ...wrong(place)],
  listMembers: (place) => [{ key: place.class.teacher_key }, ...wrong(place)],
  joinClass: () => [{ body: { role: 'watch' } }, { body: { role: 'copy' } }, { body: { role: 'play', player: 0 } }, ...bodies()],
  removeMember: (place) => [{ key: place.class.teacher_key }, ...wrong(place)],
  getMember: (place) => [{ key: place.member.token }, ...wrong(place)],
  changeMember: (place) => [
    { body: { role: 'copy', fresh: true }, type: MERGE, key: place.member.token },
    { body: { role: 'play', player: 1 }, type: MERGE, key: place.member.token },
    ...bodies(MERGE).map((one) => ({ ...one, key: place.member.token })),
  ],
  leaveClass: (place) => wrong(place),
  vote: (place) => [{ body: { choice: 1 }, key: place.member.token }, ...bodies().map((one) => ({ ...one, key: place.member.token }))],
  openClassStream: () => [{}],
  healthz: () => queries(''),
  readyz: () => queries(''),
  prometheus: () => queries(''),
};

/** All requests of an operation, with method and path. @param {string} method @param {string} template @param {Request[]} rows */
export function requestsOf(method, template, rows, /** @type {Place} */ place) {
  const id = template.includes('/experiments/')
    ? place.experiment.id
    : template.includes('/classes/')
      ? place.class.id
      : template.includes('/advise/')
        ? place.advice.id
        : template.includes('/tradeoffs/')
          ? place.tradeoff.id
          : place.played.id;
  const path = template.replace('{id}', id).replace(/\{(?:run|player|number)\}/, '1');
  return rows.map((row) => ({ ...row, method: method.toUpperCase(), path: `${row.path ?? path}${row.query ?? ''}` }));
}

/** What the rows refer to: small, large and old sessions, an experiment, a class with a member, jobs that are over. */
export async function prepare(url, runs = 2000) {
  const c = client(url),
    long = { timeout: 300000 };
  const must = async (status, method, path, wish) => {
    const answer = await c.call(method, path, wish);
    if (answer.status !== status) throw new Error(`${method} ${path}: ${answer.status} ${answer.text.slice(0, 300)}`);
    return answer.json;
  };
  const pool = await c.make({ scenario: POOL, paused: true }),
    played = await c.make({ paused: true, set: { duration_s: 2000 } }),
    motion = await c.make({ scenario: MOTION, paused: true });
  const old = await c.make({ set: { duration_s: 2000 }, paused: true });
  const seek = async (session, tick) => {
    for (let status = 503; status !== 200; ) {
      status = (
        await c.call('POST', `/api/v1/sessions/${session.id}/control`, { key: session.owner_key, body: { op: 'seek', tick }, ...long })
      ).status;
      if (status !== 200 && status !== 503) throw new Error(`no past: ${status}`);
    }
  };
  await seek(old, 90005);
  await seek(motion, 50000);
  const logged = await c.make({
    paused: true,
    set: PERSON,
    workload: { inputs: Array.from({ length: 8000 }, (_, i) => ({ tick: i, player: 0, axes: [i % 2, 1] })) },
  });
  const experiment = await must(202, 'POST', '/api/v1/experiments', {
    body: {
      scenario: 'race',
      set: { duration_s: 0.1 },
      metrics: METRICS,
      axes: [{ path: 'players.0.lag_ms', from: 0, to: 900, count: runs }],
    },
  });
  const advice = await must(202, 'POST', '/api/v1/advise', { body: advice_of(runs) });
  const tradeoff = await must(202, 'POST', '/api/v1/tradeoffs', { body: { family: 'integrators', seeds: 10, duration_s: 0.1 } });
  const opened = await must(201, 'POST', '/api/v1/classes', { body: {} });
  const board = await must(200, 'PUT', `/api/v1/classes/${opened.id}/board`, { key: opened.teacher_key, body: { scenario: 'race' } });
  const member = await must(201, 'POST', `/api/v1/classes/${opened.id}/members`, { body: { role: 'watch' } });
  (await c.attend(opened.id)).say({ auth: member.token }); // stays a member as long as this is open: until the daemon ends
  await waitFor(async () => (await c.get(`/api/v1/experiments/${experiment.id}`)).json.state === 'done', 'the experiment', 600000);
  c.close();
  return { pool, played, motion, old, logged, experiment, advice, tradeoff, class: opened, board, member };
}

const advice_of = (count) => ({
  max_error: 1e6,
  runs: 20,
  experiment: {
    scenario: 'race',
    set: { duration_s: 0.1 },
    metrics: METRICS,
    cost: METRICS[0],
    error: METRICS[0],
    axes: [{ path: 'players.0.lag_ms', from: 0, to: 900, count }],
  },
});
