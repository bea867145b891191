// Holds the running daemon against api/openapi.yaml, which it serves itself: every operation is called, every documented status that can
// be provoked is, and each answer must be documented, with the documented type and a body that its schema takes.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { execFileSync } from 'node:child_process';
import { client, raw, waitFor } from '../lib/client.mjs';
import { readContract } from '../lib/contract.mjs';
import { startDaemon } from '../lib/daemon.mjs';

const METHODS = ['get', 'post', 'patch', 'put', 'delete'];
const FOREIGN = { origin: 'http://elsewhere.example' };

// Statuses that say what only accidents bring about: memory runs out, all threads are busy, the daemon starts.
const ACCIDENTS = new Set(['503']);
// With the reason why nothing can bring them about here.
const UNPROVOKED = new Map([
  ['get /readyz 404', 'a store that daemons share: tests/daemon/shared.test.mjs'],
  ['get /api/v1/openapi.yaml 404', 'needs a daemon without its folders: tests/api/documents.test.mjs'],
  ['get /api/v1/asyncapi.yaml 404', 'as above'],
  ['get /api/v1/scenarios 404', 'as above'],
  ['get /api/v1/experiments/library 404', 'as above'],
  ['get /api/v1/sessions/{id} 507', 'needs a stored log that is damaged: tests/daemon'],
  ['get /api/v1/sessions/{id}/state 507', 'as above'],
  ['get /api/v1/sessions/{id}/hello 507', 'as above'],
  ['get /api/v1/sessions/{id}/frame 507', 'as above'],
  ['get /api/v1/sessions/{id}/metrics 507', 'as above'],
  ['get /api/v1/sessions/{id}/trace 507', 'as above'],
  ['get /api/v1/sessions/{id}/packets 507', 'as above'],
  ['get /api/v1/sessions/{id}/log 507', 'as above'],
  ['post /api/v1/sessions/{id}/fork 409', 'no state of a session forbids a fork today'],
  ['post /api/v1/sessions/{id}/control 409', 'needs a session that diverged'],
  ['get /api/v1/experiments/{id} 507', 'needs a damaged database'],
  ['get /api/v1/experiments 507', 'as above'],
  ['get /api/v1/experiments/{id}/results 507', 'as above'],
  ['get /api/v1/experiments/{id}/report 507', 'as above'],
  ['get /api/v1/experiments/{id}/runs/{run} 507', 'as above'],
  ['get /api/v1/experiments/{id}/runs/{run}/trace 507', 'as above'],
  ['post /api/v1/sessions 409', 'needs two requests with one key at the same instant'],
]);

let daemon, c, api, contract;
const seen = new Set();

before(async () => {
  daemon = await startDaemon();
  c = client(daemon.url);
  contract = await readContract(c);
  api = contract.api;
});
after(async () => {
  c.close();
  await daemon.stop();
});

function check(method, template, answer) {
  seen.add(contract.check(method, template, answer));
}

/** Calls an operation and holds the answer against the document. */
async function call(method, template, values, status, wish = {}, who = c) {
  const all = { player: 0, number: 1, ...values };
  const path = template.replace(/{(\w+)}/g, (_, name) => all[name]) + (wish.query ?? '');
  const answer = await who.call(method.toUpperCase(), path, wish);
  check(method, template, answer);
  assert.equal(answer.status, status, `${method} ${path}: ${answer.text.slice(0, 300)}`);
  return answer;
}

const S = '/api/v1/sessions',
  I = '/api/v1/sessions/{id}';
const NOBODY = 'a'.repeat(26),
  WRONG = 'b'.repeat(32);
/** Operations that change something: a valid body for each. @type {[string, string, any][]} */
const CHANGES = [
  ['patch', `${I}/params`, { 'players.0.lag_ms': 100 }],
  ['post', `${I}/control`, { op: 'pause' }],
  ['post', `${I}/input`, { player: 0, axes: [1, 0], buttons: 0 }],
];
/** @type {[string, string, any]} */
const DELETE = ['delete', I, undefined];
const DRIVEN = { 'players.0.control': 'person' };

test('scenarios and documents', async () => {
  const { json } = await call('get', '/api/v1/scenarios', {}, 200);
  assert.ok(json.scenarios.length > 3);
  const brief = await call('get', '/api/v1/scenarios', {}, 200, { query: '?brief=true' });
  assert.deepEqual(
    brief.json.scenarios,
    json.scenarios.map(({ text, ...rest }) => rest),
  );
  await call('get', '/api/v1/scenarios', {}, 400, { query: '?brief=perhaps' });
  for (const { id } of json.scenarios) await call('get', '/api/v1/scenarios/{id}', { id }, 200);
  await call('get', '/api/v1/scenarios/{id}', { id: 'no_such' }, 404);
  for (const id of ['../../etc/passwd', '..%2f..%2fetc%2fpasswd', 'RACE', 'race.json', 'a//b'])
    assert.equal((await c.get(`/api/v1/scenarios/${id}`)).status, 404, id);
  const all = (await call('get', '/api/v1/schema', {}, 200)).json;
  const without = (/** @type {any} */ node) =>
    JSON.parse(JSON.stringify(node, (key, value) => (key === 'description' && typeof value === 'string' ? undefined : value)));
  for (const kind of ['netgame', 'motion', 'rigid', 'fluid']) {
    const one = (await call('get', '/api/v1/schema', {}, 200, { query: `?kind=${kind}` })).json;
    assert.deepEqual(
      one.oneOf,
      all.oneOf.filter((/** @type {any} */ o) => o.properties.kind.const === kind),
    );
    for (const [name, value] of Object.entries(one.$defs)) assert.deepEqual(value, all.$defs[name], name);
    const bare = (await call('get', '/api/v1/schema', {}, 200, { query: `?kind=${kind}&brief=true` })).json;
    assert.deepEqual(bare, without(one));
  }
  await call('get', '/api/v1/schema', {}, 400, { query: '?brief=perhaps' });
  assert.match(
    (await call('get', '/api/v1/schema', {}, 400, { query: '?kind=nosuch' })).json.detail,
    /netgame, motion, rigid, fluid; got nosuch/,
  );
  await call('get', '/api/v1/openapi.yaml', {}, 200);
  await call('get', '/api/v1/asyncapi.yaml', {}, 200);
  await call('get', '/api/v1/stream/schema.json', {}, 200);
  await call('get', '/api/v1/metrics', {}, 200);
  const { $defs } = (await call('get', '/api/v1/schemas.json', {}, 200)).json;
  assert.deepEqual($defs.scenario.oneOf, all.oneOf);
  for (const path of Object.keys(api.paths).filter((path) => !path.includes('{') && api.paths[path].get?.responses['304'])) {
    const { headers } = await call('get', path, {}, 200);
    await call('get', path, {}, 304, { headers: { 'if-none-match': headers.etag } });
  }
});

test('operations of who runs it', async () => {
  await call('get', '/healthz', {}, 200);
  await call('get', '/readyz', {}, 200);
  const { text } = await call('get', '/metrics', {}, 200);
  const names = new Set();
  for (const line of text.trimEnd().split('\n')) {
    if (line.startsWith('# TYPE ')) names.add(line.split(' ')[2]);
    if (line.startsWith('#')) continue;
    assert.match(line, /^laglab_[a-z0-9_]+(\{[a-z_]+="[a-zA-Z0-9_.+]*"\})? -?[0-9.e+]+$/);
    // A histogram is three families of lines under one name.
    const name = /^\w+/.exec(line)[0];
    assert.ok(names.has(name) || names.has(name.replace(/_(?:bucket|sum|count)$/, '')), `${line} has no TYPE`);
  }
});

test('the life of a session', async () => {
  const made = await call('post', S, {}, 201, { body: { scenario: 'race', set: DRIVEN, seed: 7, paused: true, speed: 2 } });
  const { id, code, owner_key: key, player_keys: keys } = made.json;
  assert.equal(made.headers.location, `${S}/${id}`);
  assert.equal(made.json.status, 'paused');
  const { json: session } = await call('get', I, { id }, 200);
  assert.equal(session.seed, 7);
  assert.equal(session.speed, 2);
  assert.equal(session.params.players[0].control, 'person');
  assert.equal((await call('get', '/api/v1/codes/{code}', { code }, 200)).json.id, id);
  await call('get', '/api/v1/codes/{code}', { code: '2222' === code ? '3333' : '2222' }, 404);

  await call('post', `${I}/control`, { id }, 200, { key, body: { op: 'seek', tick: 100 } });
  const patched = await call('patch', `${I}/params`, { id }, 200, { key, body: { 'players.1.lag_ms': 300 } });
  assert.equal(patched.json.tick, 100);
  assert.equal(patched.json.params.players[1].lag_ms, 300);
  await call('patch', `${I}/params`, { id }, 200, { key, type: 'application/merge-patch+json', body: { players: { 0: { lag_ms: 50 } } } });
  await call('post', `${I}/input`, { id }, 200, { key, body: { player: 0, axes: [1, 0], buttons: 0 } });
  await call('post', `${I}/input`, { id }, 200, { key: keys[0], body: { player: 0, axes: [0, 0] } });
  for (const op of [
    { op: 'play' },
    { op: 'speed', speed: 0.5 },
    { op: 'pause' },
    { op: 'step' },
    { op: 'step', ticks: -3 },
    { op: 'seek', time_s: 1 },
    { op: 'restart' },
    { op: 'restart', reset: true },
    { op: 'seek', tick: 60 },
  ])
    await call('post', `${I}/control`, { id }, 200, { key, body: op });
  const state = await call('get', `${I}/state`, { id }, 200);
  assert.equal(state.json.tick, 60);
  assert.deepEqual((await call('get', `${I}/state`, { id }, 200, { query: '?tick=60' })).json, state.json);
  await call('get', `${I}/state`, { id }, 200, { query: '?tick=0' });
  assert.equal((await call('get', `${I}/hello`, { id }, 200)).json.session, id);
  await call('get', `${I}/frame`, { id }, 200, { query: '?channels=session,scene&from_event=3' });
  const { json: unknown } = await call('get', `${I}/frame`, { id }, 400, { query: '?channels=scene,smell' });
  assert.equal(unknown.errors[0].detail, 'channels: there is no channel `smell`.');
  await call('get', `${I}/metrics`, { id }, 200);
  const trace = await call('get', `${I}/trace`, { id }, 200, { query: '?from_s=0.5&to_s=0.9' });
  const rows = trace.text.trimEnd().split('\r\n');
  assert.match(rows[0], /^time_s,tick,/);
  assert.equal(rows.length, 1 + 25);
  await call('get', `${I}/packets`, { id }, 200, { query: '?from_s=0.5&to_s=0.9' });
  const log = (await call('get', `${I}/log`, { id }, 200)).text
    .trimEnd()
    .split('\n')
    .map((line) => JSON.parse(line));
  assert.equal(log[0].op, 'create');

  const fork = await call('post', `${I}/fork`, { id }, 201);
  assert.equal((await call('get', `${I}/state`, { id: fork.json.id }, 200)).json.hash, state.json.hash);
  await call('post', `${I}/fork`, { id }, 201, { body: { paused: false, speed: 10 } });
  await call('delete', I, { id: fork.json.id }, 204, { key: fork.json.owner_key });
  await call('get', I, { id: fork.json.id }, 404);
  const stream = await c.stream(made.json);
  seen.add(`get ${I}/stream 101`);
  await stream.close();
});

test("keys: none, wrong, another player's", async () => {
  const session = await c.make({ paused: true, set: DRIVEN }),
    other = await c.make({ paused: true });
  const { id } = session;
  for (const [method, path, body] of [...CHANGES, DELETE]) {
    const none = await call(method, path, { id }, 401, { body });
    assert.match(none.headers['www-authenticate'], /^Bearer/);
    for (const key of [WRONG, other.owner_key, '', 'x', session.player_keys[1], 'é'.repeat(200)])
      await call(method, path, { id }, 403, { body, headers: { authorization: `Bearer ${Buffer.from(key).toString('latin1')}` } });
    assert.equal(
      (await c.call(method.toUpperCase(), path.replace('{id}', id), { body, headers: { authorization: 'Basic eA==' } })).status,
      401,
    );
  }
  const ops = (await c.get(`${S}/${id}/log`)).text
    .trim()
    .split('\n')
    .map((line) => JSON.parse(line).op);
  assert.deepEqual(ops, ['create', 'hash', 'head'], 'nothing was changed');
});

test('sessions that are not there', async () => {
  for (const [method, path, body] of [
    ...CHANGES,
    ['delete', I, undefined],
    ['get', I, undefined],
    ['post', `${I}/fork`, undefined],
    ...['state', 'hello', 'frame', 'metrics', 'trace', 'packets', 'log'].map((part) => ['get', `${I}/${part}`, undefined]),
  ]) {
    for (const id of [NOBODY, 'x', 'A'.repeat(26), '%20', 'a'.repeat(2000)]) await call(method, path, { id }, 404, { body, key: WRONG });
  }
});

test('bodies: too large, of another type, malformed', async () => {
  const session = await c.make({ paused: true, set: DRIVEN });
  const bodies = [['post', S, { scenario: 'race' }], ['post', `${I}/fork`, {}], ...CHANGES];
  for (const [method, path, body] of bodies) {
    const key = session.owner_key,
      id = session.id;
    await call(method, path, { id }, 413, { key, body: `{"x":"${'y'.repeat(1 << 20)}"}` });
    await call(method, path, { id }, 415, { key, body, type: 'text/plain' });
    await call(method, path, { id }, 415, { key, body: JSON.stringify(body), type: null });
    const bad = await call(method, path, { id }, 400, { key, body: '{"op":\n  nonsense}' });
    assert.match(bad.json.detail, /line 2, column \d/);
    await call(method, path, { id }, 400, { key, body: { nonsense: 1 } });
  }
  await call('get', `${I}/state`, { id: session.id }, 400, { query: '?tick=99999999' });
  await call('get', `${I}/trace`, { id: session.id }, 400, { query: '?from_s=2&to_s=1' });
  await call('get', `${I}/trace`, { id: session.id }, 400, { query: '?of=nosuch' });
  await call('get', `${I}/trace`, { id: session.id }, 400, { query: '?format=xls' });
  await call('get', `${I}/trace`, { id: session.id }, 406, { headers: { accept: 'image/png' } });
  await call('get', `${I}/packets`, { id: session.id }, 400, { query: '?from_s=2&to_s=1' });
});

test('conflicts', async () => {
  const session = await c.make({ paused: true });
  await call('post', `${I}/input`, { id: session.id }, 409, { key: session.owner_key, body: { player: 0, axes: [1] } });
  await call('patch', `${I}/params`, { id: session.id }, 409, { key: session.owner_key, body: { seed: 8 } });
  await call('get', `${I}/packets`, { id: (await c.make({ scenario: 'rigid/pyramid', paused: true })).id }, 409);
  const headers = { 'idempotency-key': 'one' };
  const first = await call('post', S, {}, 201, { body: { scenario: 'race', paused: true }, headers });
  const again = await call('post', S, {}, 201, { body: { scenario: 'race', paused: true }, headers });
  assert.deepEqual(again.json, first.json);
  await call('post', S, {}, 422, { body: { scenario: 'race', paused: false }, headers });
});

const E = '/api/v1/experiments',
  X = '/api/v1/experiments/{id}';
const SMALL = {
  scenario: 'race',
  set: { duration_s: 1, warmup_s: 0 },
  axes: [{ path: 'players.0.lag_ms', values: [0, 100] }],
  metrics: ['players.0.own_lead_m.mean'],
};

test('experiments', async () => {
  await call('get', `${E}/schema`, {}, 200);
  const { experiments } = (await call('get', `${E}/library`, {}, 200)).json;
  assert.ok(experiments.length > 4);
  for (const one of experiments) assert.equal((await c.get(`/api/v1/scenarios/${one.id}`)).json.title, one.title);
  const count = await call('post', E, {}, 200, { body: SMALL, query: '?dry_run=true' });
  assert.deepEqual([count.json.points, count.json.repeats, count.json.runs], [2, 1, 2]);
  await call('post', E, {}, 400, { body: SMALL, query: '?dry_run=yes' });
  await call('post', E, {}, 400, { body: { ...SMALL, metrics: ['nosuch'] } });
  await call('post', E, {}, 413, { body: `{"x":"${'y'.repeat(1 << 20)}"}` });
  await call('post', E, {}, 415, { body: SMALL, type: 'text/plain' });
  const made = await call('post', E, {}, 202, { body: SMALL });
  const { id, owner_key: key } = made.json;
  assert.equal(made.headers.location, `${E}/${id}`);
  await waitFor(async () => (await call('get', X, { id }, 200)).json.state === 'done', 'the experiment');
  for (const type of ['text/csv', 'application/x-ndjson', 'application/json', 'application/vnd.sqlite3'])
    await call('get', `${X}/results`, { id }, 200, { headers: { accept: type } });
  await call('get', `${X}/report`, { id }, 200);
  for (const path of [`${X}/results`, `${X}/report`, `${X}/runs/{run}/trace`]) {
    const { etag } = (await call('get', path, { id, run: 1 }, 200)).headers;
    await call('get', path, { id, run: 1 }, 304, { headers: { 'if-none-match': etag } });
    await call('get', path, { id, run: 1 }, 206, { headers: { range: 'bytes=0-9' } });
    await call('get', path, { id, run: 1 }, 416, { headers: { range: 'bytes=99999999-' } });
  }
  await call('get', `${X}/results`, { id }, 400, { query: '?format=xls' });
  await call('get', `${X}/results`, { id }, 406, { headers: { accept: 'image/png' } });
  for (const type of ['text/csv', 'application/x-ndjson', 'application/json', 'application/vnd.sqlite3'])
    for (const query of ['', '?of=packets'])
      await call('get', `${X}/runs/{run}/trace`, { id, run: 1 }, 200, { headers: { accept: type }, query });
  await call('get', `${X}/runs/{run}/trace`, { id, run: 1 }, 400, { query: '?of=nosuch' });
  await call('get', `${X}/runs/{run}/trace`, { id, run: 1 }, 406, { headers: { accept: 'image/png' } });
  await call('get', `${X}/runs/{run}`, { id, run: 1 }, 200);
  await call('get', `${X}/runs/{run}`, { id, run: 2 }, 404);
  await call('get', `${X}/runs/{run}/trace`, { id, run: 1 }, 200);
  await call('get', `${X}/runs/{run}/trace`, { id, run: 2 }, 404);
  const refused = await call('post', E, {}, 202, {
    body: {
      scenario: { kind: 'motion', problem: 'kepler', duration_s: 10, methods: [{ method: 'rk4' }] },
      axes: [
        { path: 'methods.0.dt_s', values: [5] },
        { path: 'duration_s', values: [10, 1] },
      ],
      metrics: ['methods.0.e_final'],
    },
  });
  for (const path of [`${X}/runs/{run}`, `${X}/runs/{run}/trace`]) await call('get', path, { id: refused.json.id, run: 1 }, 400);
  await call('post', `${X}/control`, { id }, 409, { key, body: { op: 'pause' } });
  const long = (await call('post', E, {}, 202, { body: { ...SMALL, repeats: 50000 } })).json;
  for (const op of ['pause', 'resume', 'cancel'])
    await call('post', `${X}/control`, { id: long.id }, 200, { key: long.owner_key, body: { op } });
  for (const [method, path, body] of /** @type {[string, string, any][]} */ ([
    ['post', `${X}/control`, { op: 'pause' }],
    ['delete', X, undefined],
  ])) {
    await call(method, path, { id }, 401, { body });
    await call(method, path, { id }, 403, { body, key: WRONG });
    await call(method, path, { id: NOBODY }, 404, { body, key });
  }
  await call('post', `${X}/control`, { id }, 400, { key, body: { op: 'stop' } });
  await call('post', `${X}/control`, { id }, 413, { key, body: `{"x":"${'y'.repeat(1 << 20)}"}` });
  await call('post', `${X}/control`, { id }, 415, { key, body: { op: 'pause' }, type: 'text/plain' });
  for (const path of [X, `${X}/results`, `${X}/report`, `${X}/runs/{run}`, `${X}/runs/{run}/trace`])
    await call('get', path, { id: NOBODY, run: 0 }, 404);
  const A = '/api/v1/advise',
    question = { experiment: { ...SMALL, metrics: [...SMALL.metrics, 'players.0.bandwidth.down_bytes_per_s'] }, max_error: 100 };
  const ask = async (body) => {
    const asked = (await call('post', A, {}, 202, { body })).json;
    const found = await waitFor(async () => {
      const answer = (await call('get', `${A}/{id}`, { id: asked.id }, 200)).json;
      return answer.state !== 'running' && answer;
    }, 'advice');
    return { ...found, key: asked.owner_key };
  };
  const advised = await ask(question);
  assert.equal(advised.answer.holds, true);
  assert.equal(advised.done, advised.answer.runs);
  assert.equal((await ask({ ...question, max_error: 1e-9, runs: 2 })).answer.advice, null);
  await call('delete', `${A}/{id}`, { id: advised.id }, 401);
  await call('delete', `${A}/{id}`, { id: advised.id }, 403, { key: WRONG });
  await call('delete', `${A}/{id}`, { id: advised.id }, 204, { key: advised.key });
  await call('delete', `${A}/{id}`, { id: advised.id }, 404, { key: advised.key });
  await call('get', `${A}/{id}`, { id: advised.id }, 404);
  for (const bad of [
    { ...question, max_error: 0 },
    { ...question, runs: 0 },
    { ...question, more: 1 },
    { max_error: 1 },
    { max_error: 1, experiment: SMALL },
  ])
    await call('post', A, {}, 400, { body: bad });
  await call('post', A, {}, 413, { body: `{"x":"${'y'.repeat(1 << 20)}"}` });
  await call('post', A, {}, 415, { body: question, type: 'text/plain' });
  await call('delete', X, { id }, 204, { key });
  await call('get', X, { id }, 404);
  await call('delete', X, { id: long.id }, 204, { key: long.owner_key });
});

const K = '/api/v1/classes',
  R = '/api/v1/classes/{id}';
/** Operations of a class: a valid body for each, and whose key it needs. @type {[string, string, any, 'teacher' | 'member' | null][]} */
const OF_A_CLASS = [
  ['get', R, undefined, null],
  ['patch', R, { phase: 'lobby' }, 'teacher'],
  ['put', `${R}/board`, { scenario: 'race' }, 'teacher'],
  ['delete', `${R}/seats/{player}`, undefined, 'teacher'],
  ['get', `${R}/members`, undefined, 'teacher'],
  ['delete', `${R}/members/{number}`, undefined, 'teacher'],
  ['post', `${R}/members`, {}, null],
  ['get', `${R}/member`, undefined, 'member'],
  ['patch', `${R}/member`, { role: 'watch' }, 'member'],
  ['put', `${R}/vote`, { step: 0, choice: 0 }, 'member'],
  ['delete', `${R}/member`, undefined, 'member'],
  ['delete', R, undefined, 'teacher'],
];

test('a class', async () => {
  const made = await call('post', K, {}, 201, { body: { lesson: 'late_answer' } });
  const { id, code, teacher_key: teacher } = made.json;
  assert.equal(made.headers.location, `${K}/${id}`);
  await call('get', R, { id: code.toLowerCase() }, 200);
  await call('put', `${R}/board`, { id }, 200, { key: teacher, body: { scenario: 'race' } });
  await waitFor(async () => (await call('get', R, { id }, 200)).json.state.seats.length === 2, 'the players');
  const playing = (await call('post', `${R}/members`, { id: code }, 201, { body: { role: 'play' } })).json;
  const { token } = (await call('post', `${R}/members`, { id }, 201)).json;
  await call('post', `${R}/members`, { id }, 409, { body: { role: 'play', player: playing.player } });
  await call('patch', `${R}/member`, { id }, 409, { key: token, body: { role: 'play', player: playing.player } });
  await call('patch', `${R}/member`, { id }, 200, { key: token, body: { role: 'copy' } });
  await call('get', `${R}/member`, { id }, 200, { key: token });
  await call('put', `${R}/vote`, { id }, 409, { key: token, body: { step: 0, choice: 0 } });
  await call('patch', R, { id }, 200, { key: teacher, type: 'application/merge-patch+json', body: { phase: 'predict', choices: 2 } });
  await call('put', `${R}/vote`, { id }, 204, { key: token, body: { step: 0, choice: 1 } });
  await call('patch', R, { id }, 200, { key: teacher, body: { phase: 'locked' } });
  await call('post', `${R}/members`, { id }, 200, { key: token, body: { role: 'watch' } });
  const { members } = (await call('get', `${R}/members`, { id }, 200, { key: teacher })).json;
  assert.deepEqual(
    members.map(({ number, player }) => [number, player]),
    [
      [1, 0],
      [2, null],
    ],
  );
  await call('delete', `${R}/seats/{player}`, { id }, 204, { key: teacher });
  await call('delete', `${R}/seats/{player}`, { id, player: 63 }, 404, { key: teacher });
  await call('delete', `${R}/members/{number}`, { id }, 400, { key: teacher, query: '?and=all' });
  await call('delete', `${R}/members/{number}`, { id }, 409, { key: teacher, query: '?and=address' });
  await call('delete', `${R}/members/{number}`, { id }, 204, { key: teacher });
  await call('delete', `${R}/members/{number}`, { id }, 404, { key: teacher });
  await call('post', `${R}/members`, { id }, 403, { key: playing.token });
  const keys = { teacher, member: token };
  for (const [method, path, body, whose] of OF_A_CLASS) {
    const key = whose ? keys[whose] : undefined;
    await call(method, path, { id: NOBODY }, 404, { body, key });
    if (whose) await call(method, path, { id }, 401, { body });
    if (whose) await call(method, path, { id }, 403, { body, key: WRONG });
    if (body === undefined) continue;
    await call(method, path, { id }, 400, { body: { nonsense: 1 }, key });
    await call(method, path, { id }, 413, { body: `{"x":"${'y'.repeat(1 << 20)}"}`, key });
    await call(method, path, { id }, 415, { body, key, type: 'text/plain' });
  }
  await call('post', K, {}, 400, { body: { nonsense: 1 } });
  await call('post', K, {}, 413, { body: `{"x":"${'y'.repeat(1 << 20)}"}` });
  await call('post', K, {}, 415, { body: {}, type: 'text/plain' });
  await (await c.attend(id)).close();
  seen.add(`get ${R}/stream 101`);
  await call('delete', `${R}/member`, { id }, 204, { key: token });
  await call('delete', R, { id }, 204, { key: teacher });
});

test('speed against error', async () => {
  const T = '/api/v1/tradeoffs',
    order = { family: 'contact_solvers', methods: ['xpbd'], duration_s: 0.1 };
  await call('get', T, {}, 200);
  const { id, owner_key: key } = (await call('post', T, {}, 202, { body: order })).json;
  await waitFor(async () => (await call('get', `${T}/{id}`, { id }, 200)).json.state === 'done', 'the measurement');
  await call('post', T, {}, 400, { body: { family: 'magic' } });
  await call('post', T, {}, 413, { body: `{"x":"${'y'.repeat(1 << 20)}"}` });
  await call('post', T, {}, 415, { body: order, type: 'text/plain' });
  await call('delete', `${T}/{id}`, { id }, 401);
  await call('delete', `${T}/{id}`, { id }, 403, { key: WRONG });
  await call('delete', `${T}/{id}`, { id }, 204, { key });
  await call('delete', `${T}/{id}`, { id }, 404, { key });
  await call('get', `${T}/{id}`, { id }, 404);
  const long = { family: 'synchronisation', seeds: 100 },
    running = (await call('post', T, {}, 202, { body: long })).json;
  assert.equal((await call('post', T, {}, 200, { body: long })).json.id, running.id);
  await call('post', T, {}, 409, { body: { ...long, methods: ['free'] } });
  await call('delete', `${T}/{id}`, { id: running.id }, 204, { key: running.owner_key });
});

test('a class: codes that do not exist, and who may open one', async () => {
  const strict = await startDaemon({
    args: ['--max-code-lookups-per-min', '1', '--max-new-sessions-per-min', '3', '--trusted-proxy', '127.0.0.1'],
  });
  const headers = { 'x-forwarded-for': '192.0.2.1' }; /* not where the class was opened */
  const s = client(strict.url);
  try {
    const { code, teacher_key: teacher } = (await call('post', K, {}, 201, {}, s)).json;
    const { token } = (await call('post', `${R}/members`, { id: code }, 201, {}, s)).json;
    await call('get', R, { id: code === '2222' ? '3333' : '2222' }, 404, { headers }, s);
    for (const [method, path, body, whose] of OF_A_CLASS)
      await call(method, path, { id: code }, 429, { body, headers, key: whose === 'member' ? token : teacher }, s);
    await call('post', K, {}, 201, {}, s);
    await call('post', K, {}, 201, {}, s);
    await call('post', K, {}, 429, {}, s);
  } finally {
    s.close();
    await strict.stop();
  }
});

test('foreign hosts and origins', async () => {
  const session = await c.make({ paused: true });
  const { id, code } = session;
  for (const [template, item] of Object.entries(api.paths)) {
    for (const method of METHODS.filter((name) => item[name])) {
      const body = item[method].requestBody ? {} : undefined;
      const values = { id: template.includes('scenarios') ? 'race' : id, code };
      await call(method, template, values, 421, { body, headers: { host: 'rebound.example' } });
      if (method !== 'get') await call(method, template, values, 403, { body, key: session.owner_key, headers: FOREIGN });
    }
  }
  assert.equal((await c.get(`${S}/${id}`)).status, 200);
  await assert.rejects(c.stream(session, 'json', { origin: FOREIGN.origin }), { status: 403 });
});

test('upgrades that are none', async () => {
  const { id } = await c.make({ paused: true });
  const upgrade = {
    connection: 'Upgrade',
    upgrade: 'websocket',
    'sec-websocket-version': '13',
    'sec-websocket-key': 'MDEyMzQ1Njc4OWFiY2RlZg==',
    'sec-websocket-protocol': 'laglab.v2.json',
  };
  const path = `${I}/stream`;
  await call('get', path, { id }, 426);
  await call('get', path, { id }, 426, { headers: { ...upgrade, 'sec-websocket-version': '8' } });
  await call('get', path, { id }, 400, { headers: { ...upgrade, 'sec-websocket-protocol': 'chat' } });
  await call('get', path, { id }, 400, { headers: { ...upgrade, 'sec-websocket-key': 'short' } });
  await call('get', path, { id }, 403, { headers: { ...upgrade, ...FOREIGN } });
  await call('get', path, { id: NOBODY }, 404, { headers: upgrade });
  const made = (await c.call('POST', E, { body: SMALL })).json,
    progress = `${X}/stream`,
    at = { id: made.id };
  await (await c.progress(made.id)).close();
  seen.add(`get ${progress} 101`);
  await call('get', progress, at, 426);
  await call('get', progress, at, 400, { headers: { ...upgrade, 'sec-websocket-protocol': 'laglab.v2.bin' } });
  await call('get', progress, at, 403, { headers: { ...upgrade, ...FOREIGN } });
  await call('get', progress, { id: NOBODY }, 404, { headers: upgrade });
  await call('get', progress, { id }, 404, { headers: upgrade });
  const room = `${R}/stream`,
    open = { id: (await c.call('POST', K)).json.id };
  await call('get', room, open, 426);
  await call('get', room, open, 400, { headers: { ...upgrade, 'sec-websocket-protocol': 'laglab.v2.bin' } });
  await call('get', room, open, 403, { headers: { ...upgrade, ...FOREIGN } });
  await call('get', room, { id: NOBODY }, 404, { headers: upgrade });
});

test('who may', async () => {
  const key = 'operator-of-this-lab-72';
  const NORTH = { classes: null, sessions: 7, experiments: null, log_bytes: null, new_sessions_per_min: null };
  process.env.LAGLAB_OPERATOR_KEY = key;
  process.env.LAGLAB_CLASS_KEY = 'north class-key-of-this-lab sessions=7';
  const closed = await startDaemon({ args: ['--creation', 'operator', '--max-code-lookups-per-min', '5'] }).finally(() => {
    delete process.env.LAGLAB_OPERATOR_KEY;
    delete process.env.LAGLAB_CLASS_KEY;
  });
  const s = client(closed.url),
    body = { creation: 'operator' },
    C = '/api/v1/creation';
  try {
    const { id } = (await call('post', S, {}, 201, { body: { scenario: 'race' }, key }, s)).json;
    for (const [path, order] of /** @type {[string, any][]} */ ([
      [S, { scenario: 'race' }],
      [`${I}/fork`, {}],
      [E, SMALL],
      ['/api/v1/advise', { experiment: SMALL, max_error: 1 }],
      ['/api/v1/tradeoffs', { family: 'oceans' }],
      [K, {}],
    ]))
      await call('post', path, { id }, 401, { body: order }, s);
    await call('get', C, {}, 200, {}, s);
    await call('put', C, {}, 200, { body, key }, s);
    await call('put', C, {}, 400, { body: {}, key }, s);
    await call('put', C, {}, 401, { body }, s);
    await call('put', C, {}, 413, { body: `{"x":"${'y'.repeat(1 << 20)}"}`, key }, s);
    await call('put', C, {}, 415, { body, key, type: 'text/plain' }, s);
    assert.equal((await call('get', S, {}, 200, { key }, s)).json.sessions[0].id, id);
    await call('get', S, {}, 400, { key, query: '?limit=0' }, s);
    await call('get', E, {}, 200, { key }, s);
    const named = (await call('get', '/api/v1/class-keys', {}, 200, { key }, s)).json.class_keys;
    assert.deepEqual(named, [{ name: 'north', used: { classes: 0, sessions: 0, experiments: 0, log_bytes: 0 }, most: NORTH, refused: 0 }]);
    for (const [method, path] of [
      ['get', S],
      ['get', E],
      ['get', '/api/v1/class-keys'],
      ['put', C],
    ]) {
      await call(method, path, {}, 401, { body: method === 'put' ? body : undefined }, s);
      await call(method, path, {}, 403, { body: method === 'put' ? body : undefined, key: WRONG }, s);
    }
    const proxied = { headers: { 'x-forwarded-for': '192.0.2.1' } };
    await call('get', '/metrics', {}, 404, proxied, s);
    await call('get', '/metrics', {}, 403, { ...proxied, key: WRONG }, s);
    for (const [method, path] of [
      ['get', S],
      ['get', E],
      ['get', '/api/v1/class-keys'],
      ['put', C],
    ])
      await call(method, path, {}, 429, { body: method === 'put' ? body : undefined, key: WRONG }, s);
    await call('get', '/metrics', {}, 429, { ...proxied, key: WRONG }, s);
  } finally {
    s.close();
    await closed.stop();
  }
});

test('rates and numbers', async () => {
  const strict = await startDaemon({
    args: ['--max-sessions', '3', '--max-new-sessions-per-min', '4', '--max-code-lookups-per-min', '1', '--max-commands-per-s', '1'],
  });
  const s = client(strict.url);
  try {
    const { id, owner_key: key, code } = (await call('post', S, {}, 201, { body: { scenario: 'race', set: DRIVEN } }, s)).json;
    await call('post', `${I}/fork`, { id }, 201, {}, s);
    await call('post', S, {}, 201, { body: { scenario: 'race' } }, s);
    await call('post', S, {}, 503, { body: { scenario: 'race' } }, s);
    await call('post', S, {}, 429, { body: { scenario: 'race' } }, s);
    await call('post', `${I}/fork`, { id }, 429, {}, s);
    await call('post', E, {}, 429, { body: SMALL }, s);
    await call('post', '/api/v1/advise', {}, 429, { body: { experiment: SMALL, max_error: 1 } }, s);
    await call('post', '/api/v1/tradeoffs', {}, 429, { body: { family: 'oceans' } }, s);
    await call('get', '/api/v1/codes/{code}', { code }, 200, {}, s);
    await call('get', '/api/v1/codes/{code}', { code }, 429, {}, s);
    for (const [method, path, body] of CHANGES) {
      const statuses = [];
      while (!statuses.includes(429) && statuses.length < 5) {
        const answer = await s.call(method.toUpperCase(), path.replace('{id}', id), { key, body });
        check(method, path, answer);
        statuses.push(answer.status);
      }
      assert.ok(statuses.includes(429), `${path} ${statuses}`);
    }
  } finally {
    s.close();
    await strict.stop();
  }
});

test('a store that fails', async () => {
  const session = await c.make({ paused: true, set: DRIVEN });
  const { id, owner_key: key } = session;
  const paused = (await call('post', E, {}, 202, { body: { ...SMALL, repeats: 50000 } })).json;
  await call('post', `${X}/control`, { id: paused.id }, 200, { key: paused.owner_key, body: { op: 'pause' } });
  const room = (await c.call('POST', K)).json;
  await call('put', `${R}/board`, { id: room.id }, 200, { key: room.teacher_key, body: { session: id, owner_key: key } });
  const { token } = (await call('post', `${R}/members`, { id: room.id }, 201)).json;
  const limit = (size) => execFileSync('prlimit', ['--pid', String(daemon.pid), `--fsize=${size}:unlimited`]);
  limit(0);
  try {
    await call('patch', `${I}/params`, { id }, 507, { key, body: { 'players.0.lag_ms': 77 } });
    for (const [method, path, body] of CHANGES) await call(method, path, { id }, 507, { key, body });
    await call('post', S, {}, 507, { body: { scenario: 'race' } });
    await call('post', `${I}/fork`, { id }, 507);
    await call('delete', I, { id }, 507, { key });
    await call('put', `${R}/board`, { id: room.id }, 507, { key: room.teacher_key, body: { scenario: 'race' } });
    await call('post', `${R}/members`, { id: room.id }, 507, { body: { role: 'copy' } });
    await call('patch', `${R}/member`, { id: room.id }, 507, { key: token, body: { role: 'copy' } });
    await call('post', K, {}, 507, { body: {} });
    for (const [method, path, body, whose] of OF_A_CLASS)
      if (whose && method !== 'get')
        await call(method, path, { id: room.id }, 507, { body, key: whose === 'member' ? token : room.teacher_key });
    await call('post', E, {}, 507, { body: SMALL });
    await call('post', `${X}/control`, { id: paused.id }, 507, { key: paused.owner_key, body: { op: 'resume' } });
    await call('delete', X, { id: paused.id }, 507, { key: paused.owner_key });
    await call('get', I, { id }, 200);
  } finally {
    limit('unlimited');
  }
  await waitFor(
    async () => (await c.call('POST', `${S}/${id}/control`, { key, body: { op: 'step' } })).status === 200,
    'the store to work',
  );
});

test('draining', async () => {
  const short = await startDaemon();
  const s = client(short.url),
    session = await s.make();
  const viewers = await Promise.all(Array.from({ length: 40 }, (_, i) => s.stream(session, i % 2 ? 'json' : 'bin')));
  await s.get('/readyz');
  const stopped = short.stop();
  const ready = [],
    made = [];
  try {
    for (;;) {
      // on connections that were open before, until they are closed
      ready.push(await s.get('/readyz'));
      if (ready.at(-1).status === 503) made.push(await s.call('POST', S, { body: { scenario: 'race' } }));
    }
  } catch {
    // the end
  }
  assert.deepEqual(await stopped, { code: 0, signal: null });
  for (const answer of ready) check('get', '/readyz', answer);
  for (const answer of made) check('post', S, answer);
  assert.equal(ready.at(-1).status, 503);
  assert.ok(made.every((answer) => answer.status === 503));
  for (const viewer of viewers) {
    await waitFor(() => viewer.closed, 'the goodbye');
    assert.equal(viewer.closed.code, 1001);
    assert.equal(viewer.messages.at(-1).type, 'bye');
  }
  s.close();
});

test('every operation was called and every documented status that can be provoked was', () => {
  const missing = [];
  for (const [template, item] of Object.entries(api.paths)) {
    for (const method of METHODS.filter((name) => item[name])) {
      for (const status of Object.keys(item[method].responses)) {
        const where = `${method} ${template} ${status}`;
        if (!seen.has(where) && !ACCIDENTS.has(status) && !UNPROVOKED.has(where)) missing.push(where);
      }
    }
  }
  assert.deepEqual(missing, []);
});

test('what no operation is for', async () => {
  assert.equal((await c.get('/api/v1/nothing')).status, 404);
  const wrong = await c.call('PUT', '/api/v1/sessions', { body: {} });
  assert.equal(wrong.status, 405);
  assert.match(wrong.headers.allow, /POST/);
  const head = await c.call('HEAD', '/api/v1/scenarios');
  assert.equal(head.status, 200);
  assert.equal(head.text, '');
  assert.match((await raw(daemon.port, 'GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n')).text, /^HTTP\/1.1 200 /);
});

test('each path: 405 with the methods that it has, to every other', async () => {
  const values = { id: NOBODY, code: '2222', run: 0 };
  for (const [template, item] of Object.entries(api.paths)) {
    const path = template.replace(/{(\w+)}/g, (_, name) => values[name]);
    const has = METHODS.filter((name) => item[name]).map((name) => name.toUpperCase());
    for (const method of ['GET', 'POST', 'PUT', 'PATCH', 'DELETE', 'TRACE', 'PROPFIND'].filter((name) => !has.includes(name))) {
      const answer = await c.call(method, path);
      assert.equal(answer.status, 405, `${method} ${path}: ${answer.text}`);
      assert.equal(answer.headers['content-type'], 'application/problem+json');
      const allow = answer.headers.allow
        .split(', ')
        .filter((name) => name !== 'HEAD')
        .sort();
      assert.deepEqual(allow, [...has].sort(), `${method} ${path}`);
    }
    if (has.includes('GET') && !template.endsWith('/stream')) {
      const head = await c.call('HEAD', path),
        get = await c.get(path);
      assert.deepEqual([head.status, head.text, head.headers['content-type']], [get.status, '', get.headers['content-type']], path);
    }
  }
});
