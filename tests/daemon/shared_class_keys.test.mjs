// Class keys of daemons that share a PostgreSQL server: their quotas hold for all of them together.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { spawn } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { ownPostgres } from '../lib/chaos.mjs';
import { pause, waitFor } from '../lib/client.mjs';
import { eventually, memberOf } from '../lib/group.mjs';

const SCRIPT = fileURLToPath(new URL('../support/postgres', import.meta.url));
const { missing: skip, call: postgres } = ownPostgres();
const S = '/api/v1/sessions',
  E = '/api/v1/experiments',
  C = '/api/v1/classes',
  K = '/api/v1/class-keys';
const OPERATOR = 'operator-of-this-site-74',
  KEYS = ['key-of-the-north-1', 'key-of-the-south-2', 'key-of-the-east-33'],
  [NORTH = '', SOUTH = '', EAST = ''] = KEYS;
const RACE = { scenario: 'race', paused: true };
const SMALL = {
  scenario: 'race',
  set: { duration_s: 1, warmup_s: 0 },
  axes: [{ path: 'players.0.lag_ms', values: [0, 100] }],
  metrics: ['players.0.own_lead_m.mean'],
};

const folder = mkdtempSync(path.join(tmpdir(), 'laglab-class-keys-'));
const file = (/** @type {string} */ name, /** @type {string} */ text) => {
  writeFileSync(path.join(folder, name), text);
  return path.join(folder, name);
};
const args = [
  '--class-key-file',
  file('class', [`north ${NORTH} classes=2 sessions=3 experiments=2`, `south ${SOUTH} logs_mib=1`, `east ${EAST} sessions=4`].join('\n')),
  '--operator-key-file',
  file('operator', OPERATOR),
  ...['--max-client-classes', '1', '--max-client-experiments', '1'],
];

/** @type {string} */
let url;
before(() => {
  if (!skip) url = postgres('start');
});
after(() => {
  rmSync(folder, { recursive: true, force: true });
  if (!skip) postgres('remove');
});

const join = (/** @type {any} */ t, lease = 30) => memberOf(t, url, { lease, args });

/** @param {any} daemon @param {string} key @param {string} [at] @param {any} [body] */
const post = ({ c }, key, at = S, body = RACE) => c.call('POST', at, { body, key });

const must = async (/** @type {any} */ answer, status = 201) => {
  const got = await answer;
  assert.equal(got.status, status, got.text);
  return got.json;
};

const usedBy = async (/** @type {any} */ { c }, /** @type {string} */ name) =>
  (await must(c.get(K, { key: OPERATOR }), 200)).class_keys.find((/** @type {any} */ one) => one.name === name).used;

test('quotas of a key hold for all daemons together, also of requests at the same time and after kill -9', { skip }, async (t) => {
  const [a, b] = await Promise.all([join(t), join(t)]);
  const both = async (/** @type {string} */ at, /** @type {any} */ body) =>
    Promise.all(Array.from({ length: 8 }, (_, i) => post(i % 2 ? a : b, NORTH, at, body)));
  const sessions = await both(S, RACE);
  for (const [answers, most, what] of /** @type {[any[], number, RegExp][]} */ ([
    [sessions, 3, /^The class key north has as many sessions as it may have \(3\); delete some\.$/],
    [await both(C, {}), 2, /^The class key north has as many classes as it may have \(2\); delete some\.$/],
    [await both(E, SMALL), 2, /^The class key north has as many experiments as it may have \(2\); delete some\.$/],
  ])) {
    assert.equal(answers.filter(({ status }) => status < 300).length, most, String(what));
    for (const { json } of answers.filter(({ status }) => status === 429)) assert.match(json.detail, what);
    assert.equal(answers.filter(({ status }) => status === 429).length, 8 - most);
  }
  for (const daemon of [a, b]) {
    const { classes, sessions: count, experiments } = await usedBy(daemon, 'north');
    assert.deepEqual([classes, count, experiments], [2, 3, 2]);
  }
  await waitFor(async () => /class_key_sessions\{name="north"\} 3\n/.test((await a.c.get('/metrics')).text), 'the metric of all');
  await a.kill();
  for (const [at, body] of /** @type {[string, any][]} */ ([
    [S, RACE],
    [C, {}],
    [E, SMALL],
  ])) {
    const answer = await post(b, NORTH, at, body);
    assert.equal(answer.status, 429, `${at}: ${answer.text}`);
  }
  // One that is deleted at the daemon that has taken it over makes room.
  const { id, owner_key: key } = sessions.find(({ status }) => status === 201)?.json ?? {};
  const { answer: gone } = await eventually(() => b.c.call('DELETE', `${S}/${id}`, { key }));
  assert.equal(gone.status, 204, gone.text);
  await must(post(b, NORTH));
  assert.equal((await post(b, NORTH)).status, 429);
  const rows = postgres('sql', 'SELECT class_key FROM laglab_sessions.code; SELECT name FROM laglab.class_key');
  assert.ok(rows.includes('north') && !KEYS.some((one) => rows.includes(one)), 'only names are stored');
});

test('sessions of a class count for its key at any daemon; their logs count where they are and were', { skip }, async (t) => {
  const [a, b] = await Promise.all([join(t), join(t)]);
  const { id, teacher_key: teacher } = await must(post(a, EAST, C, {}));
  await must(a.c.call('PUT', `${C}/${id}/board`, { key: teacher, body: RACE }), 200);
  await must(post(b, EAST));
  await must(a.c.call('POST', `${C}/${id}/members`, { body: { role: 'copy' } }));
  const { answer: found } = await eventually(() => b.c.get(`${C}/${id}`));
  assert.equal(found.status, 200, found.text);
  const copy = () => eventually(() => b.c.call('POST', `${C}/${id}/members`, { body: { role: 'copy' } }));
  assert.equal((await copy()).answer.status, 201, 'the class is at b now, and still the key is known');
  const { answer: fifth } = await copy();
  assert.equal(fifth.status, 429, fifth.text);
  assert.match(fifth.json.detail, /class key east has as many sessions as it may have \(4\)/);

  const long = await must(post(a, SOUTH)),
    other = await must(post(b, SOUTH));
  const patch = (/** @type {any} */ daemon, /** @type {any} */ session) =>
    daemon.c.patch(session, { players: { 0: { lag_ms: 7, link: { up: { jitter_ms: 3 }, down: { jitter_ms: 4 } } } } });
  assert.equal((await patch(a, long)).status, 200);
  postgres(
    'sql',
    `UPDATE laglab_sessions.line SET body=body||repeat(' ',1100000) WHERE i=0 AND
      session=(SELECT no FROM laglab_sessions.session WHERE id='${long.id}')`,
  );
  await a.kill();
  const { answer: taken } = await eventually(() => b.c.get(`${S}/${long.id}`));
  assert.equal(taken.status, 200, taken.text);
  await waitFor(async () => (await usedBy(b, 'south')).log_bytes > 1100000, 'b counts what it has taken over');
  for (const session of [long, other]) {
    const answer = await patch(b, session);
    assert.equal(answer.status, 507, answer.text);
    assert.match(answer.json.detail, /^The logs of the class key south have 1\.\d of the 1\.0 MiB that they may have/);
  }
  assert.equal((await b.c.call('DELETE', `${S}/${long.id}`, { key: long.owner_key })).status, 204);
  await waitFor(async () => (await patch(b, other)).status === 200, 'room for the other');
});

test('a daemon starts though what its keys have cannot be counted, and counts it later', { skip }, async (t) => {
  const first = await join(t);
  first.c.close();
  await first.stop();
  const code = 'ALTER TABLE laglab_sessions.code ALTER log_bytes';
  postgres('sql', `${code} DROP DEFAULT; ${code} TYPE text`); // has no sum
  const second = await join(t);
  assert.equal((await second.c.get('/readyz')).status, 200);
  postgres('sql', `${code} TYPE bigint USING log_bytes::bigint; ${code} SET DEFAULT 0`);
  assert.ok((await usedBy(second, 'south')).sessions >= 0);
});

test('the size of a log is noted also before its row is committed, and later if its row is locked', { skip }, async (t) => {
  const a = await join(t),
    { sessions, log_bytes: bytes } = await usedBy(a, 'south');
  postgres(
    'sql',
    `CREATE FUNCTION late() RETURNS trigger LANGUAGE plpgsql AS 'BEGIN PERFORM pg_sleep(1.5); RETURN NEW; END';
      CREATE TRIGGER late BEFORE INSERT ON laglab_sessions.session FOR EACH ROW EXECUTE FUNCTION late()`,
  );
  const made = post(a, SOUTH);
  await waitFor(async () => (await usedBy(a, 'south')).sessions > sessions, 'its code is reserved');
  const stored = () => postgres('sql', 'SELECT count(*) FROM laglab_sessions.code c JOIN laglab_sessions.session s ON s.no=c.session');
  const before = stored();
  for (let i = 0; i < 5; i++) {
    await usedBy(a, 'south');
    await pause(100);
  }
  assert.equal(stored(), before, 'not committed yet');
  const session = await must(made);
  postgres('sql', 'DROP TRIGGER late ON laglab_sessions.session');
  assert.ok((await usedBy(a, 'south')).log_bytes > bytes);

  const lock = `SELECT 1 FROM laglab_sessions.code WHERE code='${session.code}' FOR UPDATE; SELECT pg_sleep(2)`;
  const holder = spawn(SCRIPT, ['sql', new URL(url.replace('postgresql://laglab@', 'http://lab')).searchParams.get('host') ?? '', lock]);
  await waitFor(async () => postgres('sql', `SELECT count(*) FROM pg_stat_activity WHERE wait_event='PgSleep'`) === '1', 'the lock');
  const { log_bytes: short } = await usedBy(a, 'south');
  assert.equal((await a.c.patch(session, { 'players.0.lag_ms': 9 })).status, 200);
  assert.equal((await usedBy(a, 'south')).log_bytes, short, 'left out');
  assert.equal(holder.exitCode, null, 'the count did not wait for the lock');
  await waitFor(async () => (await usedBy(a, 'south')).log_bytes > short, 'noted later');
});
