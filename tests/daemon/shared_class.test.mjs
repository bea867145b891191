// Classes of daemons that share a PostgreSQL server: one of them has a class with its sessions, any of them can have it, and none is lost.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { ownPostgres } from '../lib/chaos.mjs';
import { openStream, pause, waitFor } from '../lib/client.mjs';
import { eventually, memberOf, metric } from '../lib/group.mjs';

const { missing: skip, call: postgres } = ownPostgres();
const C = '/api/v1/classes';
const WRITTEN_MS = 300; /* after an answer, until its change is stored: the daemon needs some milliseconds */

/** @type {string} */
let url;
before(() => {
  if (!skip) url = postgres('start');
});
after(() => {
  if (!skip) postgres('remove');
});

const join = (t, wish) => memberOf(t, url, wish);

const must = async (answer, status = 200) => {
  const got = await answer;
  assert.equal(got.status, status, got.text);
  return got.json;
};

/** A class with a race, a player, a member with a copy, and a vote. */
async function open({ c }) {
  const { id, code, teacher_key: key } = await must(c.call('POST', C), 201);
  const at = `${C}/${id}`;
  const board = await must(c.call('PUT', `${at}/board`, { key, body: { scenario: 'race', set: { duration_s: 600 } } }));
  await waitFor(async () => (await c.get(at)).json.state.seats.length === 2, 'the players');
  const player = await must(c.call('POST', `${at}/members`, { body: { role: 'play', player: 1 } }), 201),
    copier = await must(c.call('POST', `${at}/members`, { body: { role: 'copy' } }), 201);
  await must(c.call('PATCH', at, { key, body: { phase: 'predict', lesson: 'late_answer', step: 1, choices: 4 } }));
  await must(c.call('PUT', `${at}/vote`, { key: player.token, body: { step: 1, choice: 2 } }), 204);
  await waitFor(async () => (await c.get(board.links.self)).json.params.players[1].control === 'person', 'a person drives B');
  return { id, code, key, at, board, player, copier };
}

/** All of the class is at this daemon, for all who have a key. */
async function check({ c, url: base }, room) {
  const { answer: found } = await eventually(() => c.get(room.at));
  assert.equal(found.status, 200, found.text);
  const { state } = found.json;
  assert.deepEqual([found.json.code, state.phase, state.votes, state.board, state.copies], [room.code, 'predict', 1, room.board.id, 1]);
  const mine = await must(c.call('GET', `${room.at}/member`, { key: room.player.token }));
  assert.deepEqual([mine.role, mine.player, mine.choice], ['play', 1, 2]);
  const stream = await openStream(base, `classes/${room.id}`);
  stream.say({ auth: room.player.token });
  await waitFor(async () => (await c.get(room.at)).json.state.seats[1]?.state === 'held', 'the holder is back');
  const input = { key: room.player.token, body: { player: 1, axes: [1, 0], buttons: 0 } };
  const { answer: driven } = await eventually(() => c.call('POST', `${room.board.links.self}/input`, input));
  assert.ok(driven.status < 300, `its token drives: ${driven.text}`);
  const { answer: lag } = await eventually(() =>
    c.patch({ id: room.copier.copy, owner_key: room.copier.token }, { 'players.0.lag_ms': 9 }),
  );
  assert.equal(lag.status, 200, `and the copy obeys its member: ${lag.text}`);
  const late = await must(c.call('POST', `${C}/${room.code.toLowerCase()}/members`, { body: { role: 'copy' } }), 201);
  assert.equal(late.copy.slice(0, 10), room.id.slice(0, 10), 'what is made for it goes along');
  assert.equal((await c.call('PATCH', room.at, { key: room.player.token, body: { phase: 'locked' } })).status, 403);
  const locked = await must(c.call('PATCH', room.at, { key: room.key, body: { phase: 'locked' } }));
  assert.deepEqual(locked.tally, [0, 0, 1, 0]);
  return stream;
}

test('a class is at any daemon that is asked for it, with all its sessions', { skip }, async (t) => {
  const [a, b] = await Promise.all([join(t, { lease: 30 }), join(t, { lease: 30 })]);
  const room = await open(a);
  const first = await openStream(a.url, `classes/${room.id}`);
  // A code leads to its id, which proxies know.
  const sent = await b.c.call('POST', `${C}/${room.code}/members`, { body: {} });
  assert.deepEqual([sent.status, sent.headers.location], [308, `${room.at}/members`], sent.text);
  assert.equal((await b.c.get(`${C}/2222`)).status, 404);
  // Its session is asked for first: the class comes along.
  const { answer } = await eventually(() =>
    b.c.call('PATCH', `${room.board.links.self}/params`, { key: room.key, body: { 'players.0.lag_ms': 7 } }),
  );
  assert.equal(answer.status, 200, `the teacher's key counts: ${answer.text}`);
  await waitFor(() => first.closed, 'the end of the stream at its first daemon');
  assert.equal(first.closed.code, 1012);
  const stream = await check(b, room);
  // It stays for a while.
  const back = await a.c.get(room.at);
  assert.equal(back.status, 503, back.text);
  assert.ok(Number(back.headers['retry-after']) >= 1);
  assert.equal(stream.closed, undefined);
  assert.equal(await metric(a.c, 'classes'), 0);
  assert.equal((await b.c.call('DELETE', room.at, { key: room.key })).status, 204);
  await pause(WRITTEN_MS);
  for (const { c } of [a, b]) assert.equal((await c.get(room.at)).status, 404);
  const { answer: kept } = await eventually(() => a.c.get(room.board.links.self), 12000);
  assert.equal(kept.status, 200, 'its board stays, and goes alone');
});

test('kill -9 of the daemon that has a class: another has it with its keys, seats, votes, board and copies', { skip }, async (t) => {
  const [a, b] = await Promise.all([join(t, { lease: 30 }), join(t, { lease: 30 })]);
  const room = await open(a);
  await pause(WRITTEN_MS);
  await a.kill();
  const { answer, took } = await eventually(() => b.c.get(`${C}/${room.code}`));
  assert.equal(answer.status, 200, answer.text);
  assert.equal(answer.json.id, room.id);
  assert.ok(took < 2000, `${took} ms`);
  await check(b, room);
  const rows = postgres('sql', 'SELECT body FROM laglab_sessions.class');
  for (const secret of [room.key, room.player.token, room.copier.token]) assert.ok(!rows.includes(secret), 'keys are hashes');
});

test('a daemon that was frozen beyond its lease has lost its classes; SIGTERM hands them over', { skip }, async (t) => {
  const [a, b] = await Promise.all([join(t, { lease: 1.5 }), join(t, { lease: 1.5 })]);
  const room = await open(a);
  await pause(WRITTEN_MS);
  process.kill(a.pid, 'SIGSTOP');
  const { answer } = await eventually(() => b.c.get(room.at));
  assert.equal(answer.status, 200, answer.text);
  await must(b.c.call('PATCH', room.at, { key: room.key, body: { phase: 'locked' } }));
  process.kill(a.pid, 'SIGCONT');
  await waitFor(async () => (await a.c.get('/readyz')).status === 200, 'the old owner as a new daemon');
  const late = await a.c.call('PATCH', room.at, { key: room.key, body: { phase: 'free' } });
  assert.equal(late.status, 503, late.text);
  await pause(WRITTEN_MS);
  const ended = b.stop();
  const { answer: after } = await eventually(() => a.c.get(room.at));
  assert.equal(after.json?.state?.phase, 'locked', after.text);
  assert.equal((await ended).code, 0, b.errors());
});

test('quotas of classes hold for all daemons together', { skip }, async (t) => {
  const before = Number(postgres('sql', 'SELECT count(*) FROM laglab_sessions.class'));
  const args = ['--max-client-classes', String(before + 3)];
  const [a, b] = await Promise.all([join(t, { lease: 30, args }), join(t, { lease: 30, args })]);
  const answers = await Promise.all(Array.from({ length: 8 }, (_, i) => [a, b][i % 2].c.call('POST', C)));
  assert.deepEqual(answers.map(({ status }) => status).sort(), [201, 201, 201, 429, 429, 429, 429, 429]);
});

test('the limit of the sessions of a class holds, whichever daemon makes them', { skip }, async (t) => {
  const args = ['--max-class-sessions', '4'];
  const [a, b] = await Promise.all([join(t, { lease: 30, args }), join(t, { lease: 30, args })]);
  const room = await open(a); /* a board and a copy */
  await must(a.c.call('POST', `${room.at}/members`, { body: { role: 'copy' } }), 201);
  const { answer } = await eventually(() => b.c.get(room.at));
  assert.equal(answer.status, 200, answer.text);
  const copies = await Promise.all(
    Array.from({ length: 5 }, () => eventually(() => b.c.call('POST', `${room.at}/members`, { body: { role: 'copy' } }))),
  );
  assert.deepEqual(copies.map((one) => one.answer.status).sort(), [201, 429, 429, 429, 429]);
  assert.match(copies.find((one) => one.answer.status === 429)?.answer.text ?? '', /at most 4 of one class/);
  // One that is deleted makes room.
  assert.equal((await b.c.call('DELETE', `/api/v1/sessions/${room.copier.copy}`, { key: room.copier.copy_key })).status, 204);
  await must(b.c.call('POST', `${room.at}/members`, { body: { role: 'copy' } }), 201);
});

test('a session that was made for itself is shown as a fork that goes along', { skip }, async (t) => {
  const a = await join(t, { lease: 30 });
  const own = await a.c.make({ paused: true }),
    { id, teacher_key: key } = await must(a.c.call('POST', C), 201);
  const shown = await must(a.c.call('PUT', `${C}/${id}/board`, { key, body: { session: own.id, owner_key: own.owner_key } }));
  assert.notEqual(shown.id, own.id);
  assert.equal(shown.id.slice(0, 10), id.slice(0, 10));
  assert.equal((await a.c.patch(shown.id ? { id: shown.id, owner_key: shown.owner_key } : own, { 'players.0.lag_ms': 3 })).status, 200);
  const again = await must(a.c.call('PUT', `${C}/${id}/board`, { key, body: { session: shown.id, owner_key: shown.owner_key } }));
  assert.deepEqual([again.id, again.owner_key], [shown.id, null]);
});
