// Who began with one daemon and a folder goes on with PostgreSQL: `laglab store import` takes sessions and classes along, all or nothing.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import { existsSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { test } from 'node:test';
import { ownPostgres } from '../lib/chaos.mjs';
import { client, pause, waitFor } from '../lib/client.mjs';
import { BINARY, startDaemon } from '../lib/daemon.mjs';
import { eventually, memberOf, metric } from '../lib/group.mjs';

const C = '/api/v1/classes';
const WRITTEN_MS = 300; /* after an answer, until a change of a class is on disk */

const must = async (answer, status = 200) => {
  const got = await answer;
  assert.equal(got.status, status, got.text);
  return got.json;
};

/** A class with a race, a player, and a member with a copy. */
async function open(c) {
  const { id, code, teacher_key: key } = await must(c.call('POST', C), 201),
    at = `${C}/${id}`;
  const board = await must(c.call('PUT', `${at}/board`, { key, body: { scenario: 'race', set: { duration_s: 600 } } }));
  await waitFor(async () => (await c.get(at)).json.state.seats.length === 2, 'the players');
  const player = await must(c.call('POST', `${at}/members`, { body: { role: 'play', player: 1 } }), 201),
    copier = await must(c.call('POST', `${at}/members`, { body: { role: 'copy' } }), 201);
  await must(c.call('PATCH', at, { key, body: { phase: 'predict', lesson: 'late_answer', step: 1, choices: 4 } }));
  await must(c.call('PUT', `${at}/vote`, { key: player.token, body: { step: 1, choice: 2 } }), 204);
  await pause(WRITTEN_MS);
  return { id, code, key, at, board, player, copier };
}

/** A class that shows a session which was made for itself, with a player. */
async function openWithOwn(c) {
  const { id, teacher_key: key } = await must(c.call('POST', C), 201),
    at = `${C}/${id}`,
    own = await c.make({ scenario: 'race', paused: true });
  const shown = { session: own.id, owner_key: own.owner_key };
  await must(c.call('PUT', `${at}/board`, { key, body: shown }));
  await waitFor(async () => (await c.get(at)).json.state.seats.length === 2, 'the players');
  const player = await must(c.call('POST', `${at}/members`, { body: { role: 'play', player: 1 } }), 201);
  await pause(WRITTEN_MS);
  return { at, key, shown, player };
}

/** What a session is to who reads it; the log without the hashes that it is given for reading. */
async function look(c, session) {
  const { json } = await c.get(session.links.self),
    log = (await c.get(session.links.log)).text.split('\n').filter((line) => line && !('hash' in JSON.parse(line)));
  return {
    tick: json.tick,
    status: json.status,
    speed: json.speed,
    code: json.code,
    hash: (await c.get(session.links.state)).json.hash,
    log,
  };
}

const digests = (folder) =>
  ['laglab.db', 'laglab.db-wal'].map((name) =>
    createHash('sha256')
      .update(readFileSync(path.join(folder, name)))
      .digest('hex'),
  );

test('sessions and a class of a folder go on in PostgreSQL, with names, keys, clocks and hashes', async (t) => {
  const { missing, call: postgres, count } = ownPostgres();
  if (missing) return t.skip(missing);
  t.after(() => postgres('remove'));
  const data = mkdtempSync(path.join(tmpdir(), 'laglab-test-'));
  t.after(() => rmSync(data, { recursive: true, force: true }));
  const store = postgres('start');
  const take = (folder = data, url = store) =>
    spawnSync(BINARY, ['store', 'import', folder, '--store', url], { encoding: 'utf8', timeout: 20000 });
  const stored = () => ['session', 'line', 'code', 'class'].map((table) => count(`SELECT count(*) FROM laglab_sessions.${table}`));

  const daemon = await startDaemon({ data, args: ['--save-every-s', '0.1'] }),
    c = client(daemon.url);
  t.after(() => daemon.kill());
  const sessions = [];
  for (let i = 0; i < 4; i++) {
    const session = await c.make({ paused: true, seed: i, set: { 'players.0.name': 'a"\\b' } });
    assert.equal((await c.patch(session, { 'players.0.lag_ms': 10 * i })).status, 200);
    await c.control(session, { op: 'step', ticks: 60 + i });
    await c.control(session, { op: 'step', ticks: 30 });
    sessions.push({ session, before: await look(c, session) });
  }
  const playing = await c.make({ speed: 0.25 });
  const viewer = await c.stream(playing); // the clock of a session with viewers is stored while it plays
  const { tick: begun } = await viewer.frame(({ tick }) => tick > 0);
  const room = await open(c),
    own = await openWithOwn(c);
  const busy = take();
  assert.deepEqual([busy.status, busy.stdout], [1, ''], busy.stderr);
  assert.match(busy.stderr, /is in use by another laglab/);
  const last = (await c.get(playing.links.self)).json.tick;
  c.close();
  await daemon.kill();

  const before = digests(data),
    done = take();
  assert.equal(done.status, 0, done.stderr);
  assert.deepEqual(digests(data), before, 'the folder stays as it is');
  const [, lines] = stored();
  const counts = `sessions 8\\nlines    ${lines} of their logs, \\d+ bytes\\nclasses  2\\nengine   [0-9a-f]{12},[^\\n]*`;
  assert.match(done.stdout, new RegExp(`^${counts}\\nboards to be shown again: 1\\n$`));
  assert.deepEqual(stored(), [8, lines, 8, 2]);

  const group = await memberOf(t, store, { lease: 30 });
  for (const { session, before } of sessions) {
    assert.deepEqual(await look(group.c, session), before);
    assert.equal((await group.c.get(`/api/v1/codes/${session.code}`)).json.id, session.id);
    assert.equal((await group.c.patch({ ...session, owner_key: session.player_keys[0] }, { 'players.0.lag_ms': 1 })).status, 403);
    assert.equal((await group.c.patch(session, { 'players.0.lag_ms': 77 })).status, 200, 'its key counts, and it goes on');
  }
  const { json: goes } = await group.c.get(playing.links.self);
  assert.equal(goes.speed, 0.25);
  assert.ok(goes.tick >= begun && goes.tick < last + 200, `${begun} ${last} ${goes.tick}: the clock goes on`);
  await waitFor(async () => (await group.c.get(playing.links.self)).json.tick > last, 'it plays');

  const { answer } = await eventually(() => group.c.get(`${C}/${room.code}`));
  const { id, state } = answer.json;
  assert.deepEqual([id, state.phase, state.votes, state.board, state.copies], [room.id, 'predict', 1, room.board.id, 1], answer.text);
  const mine = await must(group.c.call('GET', `${room.at}/member`, { key: room.player.token }));
  assert.deepEqual([mine.role, mine.player, mine.choice], ['play', 1, 2]);
  const { answer: lag } = await eventually(() =>
    group.c.patch({ id: room.copier.copy, owner_key: room.copier.token }, { 'players.0.lag_ms': 9 }),
  );
  assert.equal(lag.status, 200, `the copy obeys its member: ${lag.text}`);
  assert.deepEqual((await must(group.c.call('PATCH', room.at, { key: room.key, body: { phase: 'locked' } }))).tally, [0, 0, 1, 0]);
  assert.equal(await metric(group.c, 'replay_mismatch_total'), 0);
  assert.equal(count(`SELECT count(*) FROM laglab_sessions.code WHERE stem='${room.id.slice(0, 10)}'`), 2, 'they count for the class');

  const { answer: empty } = await eventually(() => group.c.get(own.at));
  assert.deepEqual([empty.json.state.board, empty.json.state.seats], [null, []], empty.text);
  const seated = await must(group.c.call('GET', `${own.at}/member`, { key: own.player.token }));
  assert.deepEqual([seated.role, seated.player ?? null], ['watch', null], 'the seat went with the board');
  const { id: fork } = await must(group.c.call('PUT', `${own.at}/board`, { key: own.key, body: own.shown }));
  assert.notEqual(fork, own.shown.session);
  assert.equal(fork.slice(0, 10), own.at.split('/').at(-1)?.slice(0, 10), 'it is where the class is');

  // What is there already is named, and nothing is done; also where only the last is there.
  group.c.close();
  await group.stop();
  for (const [sql, named] of [
    ['SELECT 1', 'Class '],
    ['DELETE FROM laglab_sessions.class', `Session ${sessions[0].session.id} is in the store`],
    [`DELETE FROM laglab_sessions.session WHERE id<>'${room.copier.copy}'`, `Code ${sessions[0].session.code} of session`],
    [`DELETE FROM laglab_sessions.code WHERE code<>'${room.code}'`, `Session ${room.copier.copy} is`],
  ]) {
    postgres('sql', sql);
    const there = stored(),
      refused = take();
    assert.deepEqual([refused.status, refused.stdout], [2, ''], refused.stderr);
    assert.ok(refused.stderr.includes(named), `${named}: ${refused.stderr}`);
    assert.deepEqual(stored(), there, named);
  }
  postgres('sql', 'DELETE FROM laglab_sessions.session; DELETE FROM laglab_sessions.line');
  assert.equal(take().status, 0, 'as often as one likes');
  assert.deepEqual(stored().slice(0, 2), [8, lines]);

  const nothing = path.join(data, 'nothing');
  assert.match(take(nothing).stderr, /no sessions in .*: it has no laglab\.db/);
  assert.ok(!existsSync(nothing));
  assert.match(take(data, `sqlite:${data}/x.db`).stderr, /must be postgresql:/);
});
