// Uses every operation of the API by its types: compiled, and run against a daemon that has an operator's key.
//   node program.js URL OPERATOR_KEY
import assert from 'node:assert/strict';
import type { components } from './api.js';
import { client } from './client.js';

type Schemas = components['schemas'];
const used = new Set<string>();
const [url, operator] = process.argv.slice(2);
const call = client(url, used);

/** The answer of status `status`; any other is an error. */
function expect<A extends { status: unknown }, const S extends A['status'] & number>(answer: A, status: S): Extract<A, { status: S }> {
  assert.equal(answer.status, status, JSON.stringify(answer));
  return answer as Extract<A, { status: S }>;
}

const motion: Schemas['Scenario'] = { kind: 'motion', problem: 'kepler', params: { e: 0.3 }, duration_s: 1,
  methods: [{ method: 'velocity_verlet', dt_s: 0.01 }, { method: 'rk4', dt_s: 0.02 }] };
// @ts-expect-error a scenario has no such kind
const wrong: Schemas['Scenario'] = { kind: 'magnetism', duration_s: 1 };
// @ts-expect-error a metric's name is a text
const worse: Schemas['Experiment'] = { scenario: 'race', metrics: [1] };
assert.ok(wrong && worse);

const { scenarios } = expect(await call('get', '/api/v1/scenarios', { query: { brief: true } }), 200).body;
assert.ok(scenarios.some((s) => s.id === 'race' && s.kind === 'netgame'));
const race = expect(await call('get', '/api/v1/scenarios/{id}', { path: { id: 'race' } }), 200).body;
assert.ok(race.kind === 'netgame' && (race.players?.length ?? 0) > 1);
expect(await call('get', '/api/v1/schema', { query: { kind: 'fluid' } }), 200);
expect(await call('get', '/api/v1/schemas.json', {}), 200);
expect(await call('get', '/api/v1/experiments/schema', {}), 200);
assert.equal(expect(await call('get', '/api/v1/stream/schema.json', {}), 200).body.protocol, 'laglab.v2');
const { kinds } = expect(await call('get', '/api/v1/metrics', {}), 200).body;
assert.ok(kinds.find((one) => one.kind === 'motion')?.tables?.some((table) => table.metrics.some((metric) => metric.name === 'e_final' && metric.type === 'number')));
expect(await call('get', '/api/v1/openapi.yaml', {}), 200);
expect(await call('get', '/api/v1/asyncapi.yaml', {}), 200);
for (const path of ['/healthz', '/readyz', '/metrics'] as const) expect(await call('get', path, {}), 200);
assert.equal(expect(await call('get', '/api/v1/creation', {}), 200).body.creation, 'open');
expect(await call('put', '/api/v1/creation', { key: operator, body: { creation: 'open' } }), 200);
assert.deepEqual(expect(await call('get', '/api/v1/class-keys', { key: operator }), 200).body.class_keys, []);

const made = expect(await call('post', '/api/v1/sessions', { body: { scenario: 'race', set: { 'players.0.control': 'person' }, paused: true, seed: 5 } }), 201);
const { id, owner_key: key, code, links, player_keys } = made.body;
assert.equal(made.headers.get('location'), links.self);
const session = expect(await call('get', '/api/v1/sessions/{id}', { path: { id } }), 200).body;
assert.ok(session.params.kind === 'netgame' && session.params.players?.[0]?.control === 'person');
assert.equal(expect(await call('get', '/api/v1/codes/{code}', { path: { code } }), 200).body.id, id);
const moved = expect(await call('post', '/api/v1/sessions/{id}/control', { path: { id }, key, body: { op: 'seek', time_s: 0.5 } }), 200).body;
assert.equal(expect(await call('patch', '/api/v1/sessions/{id}/params', { path: { id }, key, body: { 'players.1.lag_ms': 80 } }), 200).body.tick, moved.tick);
expect(await call('post', '/api/v1/sessions/{id}/input', { path: { id }, key: player_keys[0], body: { player: 0, axes: [1, 0] } }), 200);
assert.equal(expect(await call('get', '/api/v1/sessions/{id}/state', { path: { id }, query: { tick: 3 } }), 200).body.tick, 3);
assert.ok(expect(await call('get', '/api/v1/sessions/{id}/hello', { path: { id } }), 200).body);
assert.ok(String(expect(await call('get', '/api/v1/sessions/{id}/frame', { path: { id }, query: { channels: 'session,scene' } }), 200).body).length > 100);
assert.match(expect(await call('get', '/api/v1/sessions/{id}/metrics', { path: { id } }), 200).body.hash, /^[0-9a-f]{16}$/);
assert.match(String(expect(await call('get', '/api/v1/sessions/{id}/trace', { path: { id }, query: { to_s: 0.1 } }), 200).body), /^time_s,tick/);
expect(await call('get', '/api/v1/sessions/{id}/trace', { path: { id }, query: { to_s: 0.1, of: 'packets', format: 'json' } }), 200);
assert.ok(expect(await call('get', '/api/v1/sessions/{id}/packets', { path: { id }, query: { to_s: 0.1 } }), 200).body.length > 1000);
assert.match(expect(await call('get', '/api/v1/sessions/{id}/log', { path: { id } }), 200).body, /"create"/);
const fork = expect(await call('post', '/api/v1/sessions/{id}/fork', { path: { id }, body: { paused: true } }), 201).body;
expect(await call('delete', '/api/v1/sessions/{id}', { path: { id: fork.id }, key: fork.owner_key }), 204);
assert.ok(expect(await call('get', '/api/v1/sessions', { query: { limit: 10 }, key: operator }), 200).body.sessions.some((s) => s.id === id));
// Streams are spoken by another client; without an upgrade they refuse.
expect(await call('get', '/api/v1/sessions/{id}/stream', { path: { id } }), 426);

const plan: Schemas['Experiment'] = { scenario: motion, axes: [{ path: 'methods.0.dt_s', values: [0.01, 0.02] }], metrics: ['methods.0.e_final', 'methods.0.evaluations'] };
assert.equal(expect(await call('post', '/api/v1/experiments', { body: plan, query: { dry_run: true } }), 200).body.runs, 2);
const order = expect(await call('post', '/api/v1/experiments', { body: plan }), 202).body, at = { path: { id: order.id } };
for (let i = 0; expect(await call('get', '/api/v1/experiments/{id}', at), 200).body.state !== 'done'; i++) {
  assert.ok(i < 200);
  await new Promise((resolve) => setTimeout(resolve, 50));
}
assert.ok(expect(await call('get', '/api/v1/experiments/library', {}), 200).body.experiments.length > 0);
assert.ok(expect(await call('get', '/api/v1/experiments', { key: operator }), 200).body.experiments.some((x) => x.id === order.id));
const rows = expect(await call('get', '/api/v1/experiments/{id}/results', { ...at, query: { format: 'json' } }), 200);
expect(await call('get', '/api/v1/experiments/{id}/results', { ...at, query: { format: 'json' }, headers: { 'if-none-match': rows.headers.get('etag') ?? '' } }), 304);
expect(await call('get', '/api/v1/experiments/{id}/report', at), 200);
const run = expect(await call('get', '/api/v1/experiments/{id}/runs/{run}', { path: { ...at.path, run: 1 } }), 200).body;
assert.ok(run.kind === 'motion' && run.methods?.[0]?.dt_s === 0.02);
expect(await call('get', '/api/v1/experiments/{id}/runs/{run}/trace', { path: { ...at.path, run: 1 } }), 200);
expect(await call('get', '/api/v1/experiments/{id}/stream', at), 426);
const question = expect(await call('post', '/api/v1/advise', { body: { experiment: plan, max_error: 1 } }), 202).body;
assert.equal(expect(await call('get', '/api/v1/advise/{id}', { path: { id: question.id } }), 200).body.id, question.id);
expect(await call('delete', '/api/v1/advise/{id}', { path: { id: question.id }, key: question.owner_key }), 204);
assert.ok(expect(await call('get', '/api/v1/tradeoffs', {}), 200).body.families.some((one) => one.costs[0]?.path === 'cpu_s'));
const measured = expect(await call('post', '/api/v1/tradeoffs', { body: { family: 'oceans', seeds: 10, check_seeds: 0 } }), 202).body;
assert.ok(expect(await call('get', '/api/v1/tradeoffs/{id}', { path: { id: measured.id } }), 200).body.steps > 0);
expect(await call('delete', '/api/v1/tradeoffs/{id}', { path: { id: measured.id }, key: measured.owner_key }), 204);
expect(await call('post', '/api/v1/experiments/{id}/control', { ...at, key: order.owner_key, body: { op: 'cancel' } }), 409);
expect(await call('delete', '/api/v1/experiments/{id}', { ...at, key: order.owner_key }), 204);
expect(await call('delete', '/api/v1/sessions/{id}', { path: { id }, key }), 204);

const room = expect(await call('post', '/api/v1/classes', { body: { lesson: 'late_answer' } }), 201).body;
const inRoom = { path: { id: room.id }, key: room.teacher_key };
assert.equal(expect(await call('get', '/api/v1/classes/{id}', { path: { id: room.code } }), 200).body.state.lesson, 'late_answer');
expect(await call('put', '/api/v1/classes/{id}/board', { ...inRoom, body: { scenario: 'race' } }), 200);
const member = expect(await call('post', '/api/v1/classes/{id}/members', { path: { id: room.code }, body: {} }), 201).body;
const own = { path: { id: room.id }, key: member.token };
expect(await call('patch', '/api/v1/classes/{id}', { ...inRoom, body: { phase: 'predict', choices: 2 } }), 200);
expect(await call('put', '/api/v1/classes/{id}/vote', { ...own, body: { step: 0, choice: 1 } }), 204);
assert.equal(expect(await call('get', '/api/v1/classes/{id}/member', own), 200).body.choice, 1);
assert.equal(expect(await call('patch', '/api/v1/classes/{id}/member', { ...own, body: { role: 'watch' } }), 200).body.role, 'watch');
const places = expect(await call('get', '/api/v1/classes/{id}/members', inRoom), 200).body.members;
assert.deepEqual(places.map((place) => place.voted), [true]);
expect(await call('delete', '/api/v1/classes/{id}/seats/{player}', { ...inRoom, path: { id: room.id, player: 0 } }), 204);
expect(await call('get', '/api/v1/classes/{id}/stream', { path: { id: room.id } }), 426);
expect(await call('delete', '/api/v1/classes/{id}/member', own), 204);
expect(await call('delete', '/api/v1/classes/{id}/members/{number}', { ...inRoom, path: { id: room.id, number: 999 } }), 404);
expect(await call('delete', '/api/v1/classes/{id}', inRoom), 204);
console.log([...used].sort().join('\n'));
