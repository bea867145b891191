// Idempotency-Key: a repeat gets the first answer. That answer belongs to who sent the first request, as long as its session exists.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { client } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';

const S = '/api/v1/sessions',
  OPERATOR = 'operator-of-this-lab-71',
  NORTH = 'class-north-autumn',
  SOUTH = 'class-south-autumn';

const folder = mkdtempSync(path.join(tmpdir(), 'laglab-idempotency-'));
let daemon, c;
before(async () => {
  const file = (/** @type {string} */ name, /** @type {string} */ text) => {
    writeFileSync(path.join(folder, name), text);
    return path.join(folder, name);
  };
  const keys = `north ${NORTH} sessions=2\nsouth ${SOUTH} sessions=2\n`;
  const args = ['--operator-key-file', file('operator', OPERATOR), '--class-key-file', file('class', keys)];
  daemon = await startDaemon({ args });
  c = client(daemon.url);
});
after(async () => {
  c.close();
  await daemon.stop();
  rmSync(folder, { recursive: true, force: true });
});

/** @param {string} name @param {{key?: string, body?: any}} [wish] */
const post = (name, wish = {}) =>
  c.call('POST', S, {
    key: wish.key,
    body: wish.body ?? { scenario: 'race', seed: 11, paused: true },
    headers: { 'idempotency-key': name },
  });
const used = async (/** @type {string} */ name) =>
  (await c.get('/api/v1/class-keys', { key: OPERATOR })).json.class_keys.find((/** @type {any} */ key) => key.name === name).used.sessions;
const remove = async (/** @type {any} */ session) =>
  assert.equal((await c.call('DELETE', `${S}/${session.id}`, { key: session.owner_key })).status, 204);

test('another key of access with the same header and body gets a session of its own', async () => {
  const made = [];
  for (const key of [OPERATOR, NORTH, SOUTH]) made.push(await post('exercise-3', { key }));
  for (const answer of made) assert.equal(answer.status, 201, answer.text);
  for (const of of ['id', 'owner_key', 'code']) assert.equal(new Set(made.map(({ json }) => json[of])).size, 3, of);
  for (const [i, key] of [OPERATOR, NORTH, SOUTH].entries()) assert.deepEqual((await post('exercise-3', { key })).json, made[i].json);
  for (const key of [undefined, 'no-key-of-this-lab', made[0].json.owner_key])
    assert.equal((await post('exercise-3', { key })).status, key ? 403 : 401, 'who may not create gets no kept answer');
  assert.equal((await post('exercise-3', { key: NORTH, body: { scenario: 'race', seed: 12 } })).status, 422);
  for (const { json } of made) await remove(json);
});

test('a repeat does not count against a quota; one with another name does', async () => {
  assert.equal(await used('north'), 0);
  const first = (await post('a', { key: NORTH })).json;
  for (let i = 0; i < 5; i++) assert.equal((await post('a', { key: NORTH })).json.id, first.id);
  assert.equal(await used('north'), 1);
  const second = (await post('b', { key: NORTH })).json;
  assert.equal((await post('c', { key: NORTH })).status, 429);
  assert.deepEqual((await post('b', { key: NORTH })).json, second, 'a repeat is answered where the quota is used up');
  assert.equal((await post('c', { key: SOUTH })).status, 201);
  assert.deepEqual([await used('north'), await used('south')], [2, 1]);
  for (const one of [first, second]) await remove(one);
});

test('when the session is deleted, its kept answer is too: a repeat makes another, which counts', async () => {
  const first = (await post('again', { key: NORTH })).json;
  await remove(first);
  assert.equal(await used('north'), 0);
  const repeats = await Promise.all([...Array(12)].map(() => post('again', { key: NORTH })));
  const made = repeats.filter(({ status }) => status === 201).map(({ json }) => json);
  for (const { status } of repeats) assert.ok(status === 201 || status === 409, String(status));
  assert.equal(new Set(made.map(({ id }) => id)).size, 1, 'parallel repeats make one');
  assert.notEqual(made[0].id, first.id);
  assert.equal((await c.get(`${S}/${made[0].id}`)).status, 200);
  assert.deepEqual((await post('again', { key: NORTH })).json, made[0]);
  assert.equal(await used('north'), 1);
  await remove(made[0]);
  const other = await post('again', { key: NORTH, body: { scenario: 'race', seed: 13 } });
  assert.equal(other.status, 201, 'also with another body');
  await remove(other.json);
});

test('no key and an open daemon: a request with any key is another client', async () => {
  const open = await startDaemon(),
    o = client(open.url);
  const send = (/** @type {Record<string, string>} */ headers) =>
    o.call('POST', S, { body: { scenario: 'race', paused: true }, headers: { 'idempotency-key': 'lone', ...headers } });
  try {
    const [none, mine, basic] = [
      await send({}),
      await send({ authorization: 'Bearer one-of-mine' }),
      await send({ authorization: 'Basic bG9uZTo=' }),
    ];
    assert.notEqual(none.json.owner_key, mine.json.owner_key);
    assert.deepEqual(basic.json, none.json, 'only Bearer gives a key of access');
    assert.deepEqual((await send({ authorization: 'bearer  one-of-mine' })).json, mine.json);
  } finally {
    o.close();
    await open.stop();
  }
});
