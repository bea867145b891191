// A class outlives the daemon: after kill -9 or SIGTERM and a start with the same folder, code, keys, seats, votes, phase and board are
// there.
import assert from 'node:assert/strict';
import { mkdtempSync, readFileSync, readdirSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { test } from 'node:test';
import { client, openStream, pause, waitFor } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';

const C = '/api/v1/classes';

/** A folder and what starts daemons on it, one after the other; all ends with the test. */
function place(t) {
  const data = mkdtempSync(path.join(tmpdir(), 'laglab-test-'));
  /** @type {any} */ let daemon = null;
  /** @type {any} */ let c = null;
  t.after(async () => {
    c?.close();
    await daemon?.kill();
    rmSync(data, { recursive: true, force: true });
  });
  return {
    data,
    start: async (args = []) => {
      c?.close();
      daemon = await startDaemon({ data, args });
      c = client(daemon.url);
      return { daemon, c };
    },
  };
}

/** A class with a race, a player, a watcher and a member with a copy; a question with two votes. */
async function open(c) {
  const made = await c.call('POST', C);
  assert.equal(made.status, 201, made.text);
  const { id, code, teacher_key: key } = made.json,
    at = `${C}/${id}`;
  const done = async (answer, status = 200) => {
    assert.equal(answer.status, status, answer.text);
    return answer.json;
  };
  await done(await c.call('PUT', `${at}/board`, { key, body: { scenario: 'race', set: { duration_s: 600 } } }));
  await waitFor(async () => (await c.get(at)).json.state.seats.length === 2, 'the players');
  const player = await done(await c.call('POST', `${at}/members`, { body: { role: 'play', player: 1 } }), 201),
    watcher = await done(await c.call('POST', `${at}/members`, { body: { role: 'watch' } }), 201),
    copier = await done(await c.call('POST', `${at}/members`, { body: { role: 'copy' } }), 201);
  await waitFor(async () => {
    const { params } = (await c.get(`/api/v1/sessions/${(await c.get(at)).json.state.board}`)).json;
    return params.players[1].control === 'person';
  }, 'a person drives B');
  await done(await c.call('PATCH', at, { key, body: { phase: 'predict', lesson: 'late_answer', step: 1, choices: 4, together: true } }));
  await done(await c.call('PUT', `${at}/vote`, { key: player.token, body: { step: 1, choice: 2 } }), 204);
  await done(await c.call('PUT', `${at}/vote`, { key: watcher.token, body: { step: 1, choice: 0 } }), 204);
  return { id, code, key, at, player, watcher, copier };
}

const SIGNALS = { kill: 'kill -9', stop: 'SIGTERM' };
for (const how of ['kill', 'stop'])
  test(`after ${SIGNALS[how]} the class goes on: code, phase, question, votes, seat, copy and keys`, async (t) => {
    const { start } = place(t);
    const first = await start(),
      room = await open(first.c),
      before = (await first.c.get(room.at)).json.state;
    await first.daemon[how]();
    const { daemon, c } = await start();
    const found = await c.get(`${C}/${room.code.toLowerCase()}`);
    assert.equal(found.status, 200, found.text);
    assert.equal(found.json.id, room.id);
    const after = found.json.state;
    for (const name of ['phase', 'lesson', 'step', 'frozen', 'together', 'stop_tick', 'question', 'votes', 'tally', 'board', 'copies'])
      assert.deepEqual(after[name], before[name], name);
    assert.equal(after.n, 0, 'no member is connected yet');
    await waitFor(async () => (await c.get(room.at)).json.state.seats.length === 2, 'the players are read again');
    assert.deepEqual(
      (await c.get(room.at)).json.state.seats.map((seat) => seat.state),
      ['free', 'away'],
      'the seat is kept',
    );
    const taken = await c.call('POST', `${room.at}/members`, { body: { role: 'play', player: 1 } });
    assert.equal(taken.status, 409, 'and no other gets it');
    const mine = await c.call('GET', `${room.at}/member`, { key: room.player.token });
    assert.deepEqual([mine.json.role, mine.json.player, mine.json.choice], ['play', 1, 2]);
    const copy = await c.call('GET', `${room.at}/member`, { key: room.copier.token });
    assert.deepEqual([copy.json.role, copy.json.copy], ['copy', room.copier.copy]);
    const stream = await openStream(daemon.url, `classes/${room.id}`);
    stream.say({ auth: room.player.token });
    await waitFor(async () => (await c.get(room.at)).json.state.seats[1].state === 'held', 'the holder is back');
    assert.equal((await c.call('PUT', `${room.at}/vote`, { key: room.watcher.token, body: { step: 1, choice: 3 } })).status, 204);
    assert.equal(
      (await c.call('PATCH', room.at, { key: room.player.token, body: { phase: 'locked' } })).status,
      403,
      'a member is no teacher',
    );
    const locked = await c.call('PATCH', room.at, { key: room.key, body: { phase: 'locked' } });
    assert.equal(locked.status, 200, locked.text);
    assert.deepEqual((await c.get(room.at)).json.state.tally, [0, 0, 1, 1]);
    const control = async () => (await c.get(`/api/v1/sessions/${after.board}`)).json.params.players[1].control;
    assert.equal((await c.call('PATCH', room.at, { key: room.key, body: { phase: 'free' } })).status, 200);
    await waitFor(async () => (await control()) === 'person', 'after the lesson the holder drives');
    const input = { key: room.player.token, body: { player: 1, axes: [1, 0], buttons: 0 } };
    const drives = await c.call('POST', `/api/v1/sessions/${after.board}/input`, input);
    assert.ok(drives.status < 300, `its token drives: ${drives.text}`);
    const free = await c.call('PATCH', `${room.at}/member`, { key: room.player.token, body: { role: 'watch' } });
    assert.equal(free.status, 200, free.text);
    await waitFor(async () => (await control()) === 'script', 'a seat that is left goes back to the script');
    stream.close?.();
  });

test('a class that was frozen while it ran is frozen, and runs on to its stop', async (t) => {
  const { start } = place(t);
  const first = await start(),
    room = await open(first.c);
  await first.c.call('PATCH', room.at, { key: room.key, body: { phase: 'run', stop_tick: 100000 } });
  await waitFor(async () => (await first.c.get(room.at)).json.state.status === 'playing', 'the run');
  await first.c.call('PATCH', room.at, { key: room.key, body: { frozen: true } });
  await waitFor(async () => (await first.c.get(room.at)).json.state.status === 'paused', 'frozen');
  const { tick } = (await first.c.get(room.at)).json.state;
  const stop_tick = tick + 60;
  assert.equal((await first.c.call('PATCH', room.at, { key: room.key, body: { stop_tick } })).status, 200);
  await first.daemon.kill();
  const { c } = await start();
  const state = async () => (await c.get(room.at)).json.state;
  await waitFor(async () => (await state()).status === 'paused', 'the board is read');
  await pause(300);
  assert.deepEqual(
    [(await state()).frozen, (await state()).status, (await state()).tick],
    [true, 'paused', tick],
    'and stays where it was',
  );
  await c.call('PATCH', room.at, { key: room.key, body: { frozen: false } });
  await waitFor(async () => (await state()).status === 'playing' || (await state()).phase === 'stopped', 'it plays on');
  await waitFor(async () => (await state()).phase === 'stopped', 'the stop');
  assert.equal((await state()).tick, stop_tick);
});

test('nothing that was shown once is on disk: neither keys nor tokens', async (t) => {
  const { data, start } = place(t);
  const { daemon, c } = await start(),
    room = await open(c);
  await daemon.kill();
  const files = readdirSync(data).filter((name) => name.startsWith('laglab.db'));
  const bytes = Buffer.concat(files.map((name) => readFileSync(path.join(data, name))));
  assert.ok(bytes.includes(room.id), 'the class is there');
  for (const secret of [room.key, room.player.token, room.watcher.token, room.copier.token]) assert.ok(!bytes.includes(secret));
});

test('an ended class stays ended, and one that was not used for --class-ttl-s is gone', async (t) => {
  const { start } = place(t);
  const first = await start(),
    over = await open(first.c),
    old = await open(first.c);
  assert.equal((await first.c.call('DELETE', over.at, { key: over.key })).status, 204);
  await first.daemon.kill();
  const second = await start();
  assert.equal((await second.c.get(over.at)).status, 404);
  assert.equal((await second.c.get(old.at)).status, 200);
  await second.daemon.kill();
  await pause(1500);
  const third = await start(['--class-ttl-s', '1']);
  assert.equal((await third.c.get(old.at)).status, 404);
  await third.daemon.stop();
  const fourth = await start();
  assert.equal((await fourth.c.get(old.at)).status, 404, 'it was deleted');
});
