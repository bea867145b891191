// A class from outside: opening, joining, seats, votes, phases, freezing, copies, lost connections, hostile members. What thirty-one
// clients at once see and how much is sent is in class_load.test.mjs.
import assert from 'node:assert/strict';
import { networkInterfaces } from 'node:os';
import { after, before, test } from 'node:test';
import { HANG_MS, client, headed, openStream, pause, raw, waitFor } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';

const C = '/api/v1/classes';
const WRONG = 'b'.repeat(32);
const LESSON = { lesson: 'late_answer', step: 1, choices: 4 };

let daemon, c;
before(async () => {
  daemon = await startDaemon();
  c = client(daemon.url);
});
after(async () => {
  c.close();
  await daemon.stop();
});

/** A class with a race on its board. */
async function open(wish = {}, who = c) {
  const made = await who.call('POST', C, wish.call);
  assert.equal(made.status, 201, made.text);
  const key = made.json.teacher_key,
    at = `${C}/${made.json.id}`;
  const room = {
    ...made.json,
    key,
    at,
    board: undefined,
    set: async (patch) => {
      const answer = await who.call('PATCH', at, { key, body: patch });
      assert.equal(answer.status, 200, answer.text);
      return answer.json;
    },
    show: async (body) => {
      const answer = await who.call('PUT', `${at}/board`, { key, body });
      assert.equal(answer.status, 200, answer.text);
      room.board = answer.json;
      await waitFor(async () => (await room.state()).status !== null && (await room.state()).seats.length > 0, 'the players');
    },
    state: async () => (await who.get(at)).json.state,
    enter: async (body) => {
      const answer = await who.call('POST', `${C}/${made.json.code}/members`, { body });
      assert.equal(answer.status, 201, answer.text);
      return answer.json;
    },
    stream: async (token) => {
      const stream = await openStream(who.url, `classes/${made.json.id}`);
      if (token) stream.say({ auth: token });
      if (token) await stream.wait((m) => m.type === 'reply', 'the reply');
      return stream;
    },
    vote: (token, body) => who.call('PUT', `${at}/vote`, { key: token, body }),
    member: (token, body) => who.call(body ? 'PATCH' : 'GET', `${at}/member`, { key: token, body }),
    seat: async (player) => (await room.state()).seats[player],
    end: () => who.call('DELETE', at, { key }),
  };
  if (wish.board !== null) await room.show(wish.board ?? { scenario: 'race', set: { duration_s: 600 } });
  return room;
}

const newest = (stream) => stream.messages.filter((m) => m.type === 'class' || m.type === 'hello').at(-1);
const sees = (stream, test_, what) => waitFor(() => test_(newest(stream)), what);
const session = async (id) => (await c.get(`/api/v1/sessions/${id}`)).json;

// ---- statements 17 to 20: code, address, join ----

test('a code of four characters, addresses of this machine, the way to the page', async () => {
  const room = await open({ board: null });
  assert.match(room.code, /^[2-9A-HJKMNP-Z]{4}$/);
  assert.match(room.teacher_key, /^[a-z2-7]{32}$/);
  assert.deepEqual(room.join, { urls: [`${daemon.url.replace(/\/$/, '')}/${room.code}`], local: true }, 'bound to loopback: nothing else');
  for (const code of [room.code, room.code.toLowerCase(), '2222']) {
    const answer = await c.get(`/${code}`);
    assert.equal(answer.status, 302);
    assert.equal(answer.headers.location, `/#class=${code.toUpperCase()}`);
  }
  for (const path of ['/OOOO', '/abc', '/abcde', '/ab1d']) assert.equal((await c.get(path)).status, 404, path);
  const found = await c.get(`${C}/${room.code.toLowerCase()}`);
  assert.equal(found.json.id, room.id);
  assert.equal(found.json.teacher_key, undefined);
  assert.equal((await room.end()).status, 204);
  assert.equal((await c.get(`${C}/${room.code}`)).status, 404);
});

test('a daemon on all interfaces names their addresses and never loopback', async (t) => {
  const wide = await startDaemon({ listen: '0.0.0.0:0' });
  t.after(() => wide.stop());
  const w = client(`http://127.0.0.1:${wide.port}/`);
  t.after(() => w.close());
  const { join, code } = (await w.call('POST', C)).json;
  const own = Object.values(networkInterfaces())
    .flat()
    .filter((a) => !a.internal && a.family === 'IPv4' && !a.address.startsWith('169.254.'))
    .map((a) => `http://${a.address}:${wide.port}/${code}`);
  if (own.length === 0) {
    assert.equal(join.local, true, 'a machine without a network');
    return;
  }
  assert.equal(join.local, false);
  assert.deepEqual([...join.urls].sort(), own.sort());
  assert.ok(join.urls.every((url) => !/localhost|127\.|\[::1\]/.test(url)));
});

test('behind a named proxy scheme, host and port are those of the proxy; of others they are ignored', async (t) => {
  const behind = await startDaemon({ args: ['--trusted-proxy', '127.0.0.1', '--allow-host', 'lab.example'] });
  t.after(() => behind.stop());
  const b = client(behind.url);
  t.after(() => b.close());
  const headers = { 'x-forwarded-proto': 'https', 'x-forwarded-for': '192.0.2.7', host: 'lab.example' };
  const made = (await b.call('POST', C, { headers })).json;
  assert.deepEqual(made.join, { urls: [`https://lab.example/${made.code}`], local: false });
  const port = { ...headers, 'x-forwarded-host': 'lab.example:8443' };
  assert.deepEqual((await b.get(`${C}/${made.id}`, { headers: port })).json.join.urls, [`https://lab.example:8443/${made.code}`]);
  const evil = { ...headers, 'x-forwarded-host': 'a"><script>' };
  assert.deepEqual((await b.get(`${C}/${made.id}`, { headers: evil })).json.join.urls, [`https://lab.example/${made.code}`]);
  const { join } = (await c.call('POST', C, { headers: { 'x-forwarded-proto': 'https', 'x-forwarded-host': 'evil.example' } })).json;
  assert.ok(join.urls.every((url) => url.startsWith('http://127.0.0.1:')));
});

test('guessing codes is limited by address; it hides no class from an address that knows its code', async (t) => {
  const strict = await startDaemon({ args: ['--max-code-lookups-per-min', '10', '--trusted-proxy', '127.0.0.1'] });
  t.after(() => strict.stop());
  const s = client(strict.url);
  t.after(() => s.close());
  const room = await open({ board: null }, s);
  const from = (/** @type {string} */ address, name = room.code, method = 'GET') =>
    s.call(method, `${C}/${name}${method === 'GET' ? '' : '/members'}`, { headers: { 'x-forwarded-for': address } });
  for (let i = 0; i < 30; i++) assert.equal((await from('192.0.2.1', room.code, 'POST')).status, 201);
  const wrong = room.code === '2222' ? '3333' : '2222';
  for (const address of ['192.0.2.1', '192.0.2.2', '127.0.0.1']) {
    const statuses = [];
    for (let i = 0; i < 12; i++) statuses.push((await from(address, wrong)).status);
    assert.deepEqual(statuses, [...Array(10).fill(404), 429, 429]);
  }
  assert.equal((await from('192.0.2.2')).status, 429, 'who guesses learns nothing more');
  assert.equal((await from('192.0.2.2', room.id)).status, 200);
  assert.equal((await from('192.0.2.1', room.code, 'POST')).status, 201, 'one of this address has joined');
  assert.equal((await from('127.0.0.1', room.code, 'POST')).status, 201, 'it was opened at this address');
  assert.equal((await from('192.0.2.3', room.code, 'POST')).status, 201, 'another address');
});

// ---- 21, 22: seats ----

test('two devices drive, each its own player; a second claim of a seat is refused', async () => {
  const room = await open();
  const a = await room.enter({ role: 'play', player: 0 }),
    b = await room.enter({ role: 'play' });
  assert.deepEqual([a.player, b.player], [0, 1]);
  const again = await c.call('POST', `${room.at}/members`, { body: { role: 'play', player: 0 } });
  assert.equal(again.status, 409);
  assert.equal(again.json.detail, 'player: seat 0 (A) is taken.');
  assert.equal(again.json.errors[0].field, 'player');
  assert.equal((await c.call('POST', `${room.at}/members`, { body: { role: 'play' } })).status, 409);
  assert.equal((await c.call('POST', `${room.at}/members`, { body: { role: 'play', player: 7 } })).status, 400);
  assert.equal((await room.state()).n, 0, 'a refused claim leaves no member');
  const driven = async () => (await session(room.board.id)).params.players.map((p) => p.control);
  await waitFor(async () => (await driven()).join() === 'person,person', 'control by persons');
  const board = `/api/v1/sessions/${room.board.id}`;
  const drive = (key, player) => c.call('POST', `${board}/input`, { key, body: { player, axes: [1, 0] } });
  assert.equal((await drive(a.token, 0)).status, 200);
  assert.equal((await drive(b.token, 1)).status, 200);
  assert.equal((await drive(a.token, 1)).status, 403);
  assert.equal((await drive(WRONG, 0)).status, 403);
  for (const key of [a.token, WRONG]) assert.equal((await c.call('POST', `${board}/control`, { key, body: { op: 'pause' } })).status, 403);
  assert.equal(
    (await c.call('POST', `${board}/control`, { key: room.key, body: { op: 'step' } })).status,
    200,
    'the teacher owns the board',
  );
  const stream = await c.stream(room.board, 'bin');
  stream.say({ auth: a.token, id: 1 });
  assert.deepEqual(await stream.wait((m) => m.id === 1), { type: 'reply', id: 1, ok: true, role: 'player', player: 0 });
  stream.say({ input: { player: 0, axes: [-1, 0] }, id: 2 });
  await stream.wait((m) => m.id === 2 && m.ok);
  assert.equal((await room.member(a.token, { role: 'watch' })).json.player, null);
  await waitFor(async () => {
    stream.say({ input: { player: 0, axes: [1, 0] }, id: 3 });
    return stream.messages.some((m) => m.id === 3 && m.type === 'error');
  }, 'the end of its permission');
  await waitFor(async () => (await driven())[0] === 'script', 'the script');
  assert.equal((await room.enter({ role: 'play', player: 0 })).player, 0, 'the seat is free again');
  await stream.close();
});

test('other boards: without players, another one, an existing session', async () => {
  const room = await open();
  const a = await room.enter({ role: 'play', player: 1 });
  assert.equal((await c.call('PUT', `${room.at}/board`, { key: a.token, body: { scenario: 'race' } })).status, 403);
  const motion = await c.call('PUT', `${room.at}/board`, { key: room.key, body: { scenario: 'motion/spring' } });
  assert.equal(motion.status, 200);
  await waitFor(async () => (await room.state()).status === 'paused', 'the board');
  await waitFor(async () => (await room.member(a.token)).json.player === null, 'there is no such player');
  assert.deepEqual((await room.state()).seats, []);
  assert.equal((await room.member(a.token, { role: 'play' })).status, 409);
  const other = await c.make({ paused: true });
  const body = { session: other.id, owner_key: other.owner_key };
  const put = (b) => c.call('PUT', `${room.at}/board`, { key: room.key, body: b });
  assert.equal((await put({ ...body, owner_key: WRONG })).status, 403);
  assert.equal((await put({ session: 'a'.repeat(26), owner_key: WRONG })).status, 400);
  assert.equal((await put({ session: other.id })).json.errors[0].field, 'owner_key');
  assert.equal((await put({ ...body, scenario: 'race' })).status, 400);
  assert.equal((await put({ scenario: 'no_such' })).status, 400);
  assert.equal((await put(body)).json.owner_key, null);
  await waitFor(async () => (await room.state()).seats.length === 2, 'the players');
  assert.equal((await c.call('POST', `/api/v1/sessions/${other.id}/control`, { key: room.key, body: { op: 'step' } })).status, 200);
  await put({ scenario: 'race' });
  const old = await c.call('POST', `/api/v1/sessions/${other.id}/control`, { key: room.key, body: { op: 'step' } });
  assert.equal(old.status, 403, 'a session that the board has left');
  await c.call('DELETE', `/api/v1/sessions/${(await room.state()).board}`, { key: room.key });
  await waitFor(async () => (await room.state()).board === null, 'the end of a board that was deleted');
});

test('a seat stays on another board that has its player; its token drives there and no longer on the one before', async () => {
  const room = await open();
  const a = await room.enter({ role: 'play', player: 1 }),
    first = await room.stream(a.token),
    before = room.board.id;
  const drive = (/** @type {string} */ id) =>
    c.call('POST', `/api/v1/sessions/${id}/input`, { key: a.token, body: { player: 1, axes: [1, 0], buttons: 0 } });
  const control = async () => (await session(room.board.id)).params.players[1].control;
  await waitFor(async () => (await control()) === 'person', 'the first board');
  const known = first.messages.filter((m) => m.type === 'member').length;
  await room.show({ scenario: 'cannon', set: { duration_s: 600 } });
  assert.notEqual(room.board.id, before);
  await waitFor(async () => (await control()) === 'person', 'its control on the new board');
  assert.equal((await room.seat(1)).state, 'held');
  await waitFor(() => first.messages.filter((m) => m.type === 'member' && m.player === 1).length > known, 'a message of its own');
  assert.equal((await drive(room.board.id)).status, 200);
  assert.equal((await drive(before)).status, 403);
  await first.close();
});

test('in a lesson scripts drive, also where seats are held; phase free plays the board and gives them to their holders', async () => {
  const room = await open();
  const a = await room.enter({ role: 'play', player: 0 }),
    stream = await room.stream(a.token);
  const control = async () => (await session(room.board.id)).params.players[0].control;
  await waitFor(async () => (await control()) === 'person', 'it drives');
  await room.set({ lesson: 'late_answer' });
  await waitFor(async () => (await control()) === 'script', 'the script');
  assert.equal((await room.seat(0)).state, 'held');
  await room.set({ phase: 'change', stop_tick: 31 });
  await waitFor(async () => (await room.state()).tick === 31 && (await room.state()).status === 'paused', 'the stop of the change');
  assert.equal((await room.state()).phase, 'change');
  await room.set({ phase: 'free' });
  await waitFor(async () => (await session(room.board.id)).tick > 31, 'it plays');
  await waitFor(async () => (await control()) === 'person', 'it drives again');
  await room.show({ scenario: 'race', set: { duration_s: 600 } });
  await waitFor(async () => (await session(room.board.id)).tick > 0, 'another board plays at once');
  await stream.close();
});

// ---- phases and the stop ----

test('run plays the board to the stop tick exactly, and the phase becomes stopped', async () => {
  const room = await open();
  const projector = await room.stream();
  await room.set({ phase: 'run', stop_tick: 19 });
  await sees(projector, (s) => s.phase === 'stopped' && s.status === 'paused', 'the stop');
  assert.equal(newest(projector).tick, 19);
  assert.equal((await session(room.board.id)).tick, 19);
  await room.set({ phase: 'run' });
  await sees(projector, (s) => s.status === 'playing', 'going on: the stop has been passed');
  await room.set({ phase: 'stopped' });
  await sees(projector, (s) => s.status === 'paused', 'the pause');
  const serials = projector.messages.map((m) => m.serial).filter((n) => n !== undefined);
  assert.deepEqual(
    serials,
    [...serials].sort((x, y) => x - y),
  );
  await projector.close();
});

test('settings: what is wrong is named with its range, and changes nothing', async () => {
  const room = await open({ board: null });
  for (const [body, detail] of /** @type {[any, RegExp][]} */ ([
    [{ phase: 'party' }, /phase.*lobby.*predict.*locked.*run.*stopped.*explain.*change.*free/],
    [{ step: 1000 }, /step: must be a whole number from 0 to 999; got 1000/],
    [{ step: 1.5 }, /step/],
    [{ choices: 9 }, /choices: must be a whole number from 0 to 8/],
    [{ phase: 'predict' }, /choices: must be 1 to 8 in phase predict/],
    [{ lesson: 'x'.repeat(65) }, /lesson/],
    [{ lesson: 'Anna Müller' }, /lesson: must be an id/],
    [{ frozen: 1 }, /frozen/],
    [{ frozen: null }, /frozen/],
    [{ name: 'Anna' }, /name/],
    [[], /object/],
    ['{', /line 1/],
  ])) {
    const answer = await c.call('PATCH', room.at, { key: room.key, body });
    assert.equal(answer.status, 400, `${JSON.stringify(body)}: ${answer.text}`);
    assert.match(answer.json.detail, detail);
  }
  assert.equal((await room.state()).phase, 'lobby');
  for (const [key, status] of /** @type {[any, number][]} */ ([
    [undefined, 401],
    [WRONG, 403],
    [(await room.enter()).token, 403],
  ]))
    for (const method of ['PATCH', 'DELETE']) {
      const body = method === 'PATCH' ? { phase: 'run' } : undefined;
      assert.equal((await c.call(method, room.at, { key, body })).status, status);
    }
});

// ---- 25, 26: votes ----

test('votes: one a token, changeable until locked, hidden until then', async () => {
  const room = await open();
  const [a, b] = [await room.enter(), await room.enter()];
  const projector = await room.stream(),
    remote = await room.stream(room.key);
  assert.match((await room.vote(a.token, { step: 1, choice: 0 })).json.detail, /locked.*lobby/);
  await room.set({ phase: 'predict', ...LESSON });
  for (const choice of [0, 0, 3, 2]) assert.equal((await room.vote(a.token, { step: 1, choice })).status, 204);
  assert.equal((await room.vote(b.token, { step: 1, choice: 1 })).status, 204);
  for (const stream of [projector, remote]) {
    await sees(stream, (s) => s.votes === 2, 'the count');
    assert.equal(newest(stream).tally, null);
    assert.deepEqual(newest(stream).question, { lesson: 'late_answer', step: 1, choices: 4 });
  }
  assert.equal((await room.state()).tally, null);
  for (const [body, status, detail] of /** @type {[any, number, RegExp][]} */ ([
    [{ step: 1, choice: 4 }, 400, /choice: must be 0 to 3; got 4/],
    [{ step: 1, choice: -1 }, 400, /choice/],
    [{ step: 1, choice: 'A' }, 400, /choice/],
    [{ step: 1 }, 400, /choice/],
    [{ step: 2, choice: 0 }, 409, /step: must be 1/],
    [{ step: 1, choice: 0, name: 'Anna' }, 400, /name/],
  ])) {
    const answer = await room.vote(a.token, body);
    assert.equal(answer.status, status, answer.text);
    assert.match(answer.json.detail, detail);
  }
  assert.match((await room.vote(WRONG, { step: 1, choice: 0 })).json.detail, /Unknown token/);
  assert.equal((await room.vote(undefined, { step: 1, choice: 0 })).status, 401);
  assert.equal((await room.vote(room.key, { step: 1, choice: 0 })).status, 403, 'a teacher does not vote');
  await room.set({ phase: 'locked' });
  await sees(projector, (s) => s.tally, 'the tally');
  assert.deepEqual(newest(projector).tally, [0, 1, 1, 0]);
  const late = await room.vote(b.token, { step: 1, choice: 0 });
  assert.equal(late.status, 409);
  assert.match(late.json.detail, /Votes are locked: the class is in phase locked/);
  await room.set({ phase: 'explain', step: 2 });
  assert.deepEqual((await room.state()).tally, [0, 1, 1, 0], 'it stays with the result');
  await room.set({ phase: 'predict', step: 1 });
  assert.equal((await room.state()).votes, 2, 'asked again: votes stay');
  await room.set({ phase: 'predict', step: 3, choices: 2 });
  assert.equal((await room.state()).votes, 0);
  assert.equal((await room.member(a.token)).json.choice, null);
  await projector.close();
  await remote.close();
});

// ---- 23, 24: freeze, bring here, release; copies ----

test('freeze pauses the board and copies, also against play; its end resumes what played', async () => {
  const room = await open();
  await room.set({ phase: 'free' });
  await c.call('POST', `/api/v1/sessions/${room.board.id}/control`, { key: room.key, body: { op: 'play' } });
  await waitFor(async () => (await room.state()).status === 'playing', 'the board to play');
  const [a, b] = [await room.enter({ role: 'copy' }), await room.enter({ role: 'copy' })];
  assert.equal((await session(a.copy)).status, 'playing', 'a copy goes on as the board does');
  const own = (member, key, op) => c.call('POST', `/api/v1/sessions/${member.copy}/control`, { key, body: { op } });
  assert.equal((await own(b, b.token, 'pause')).status, 200, 'a token owns its copy');
  assert.equal((await own(a, b.token, 'pause')).status, 403);
  const going = await c.make({ set: { duration_s: 1000 } });
  await room.set({ frozen: true, together: true });
  for (const id of [room.board.id, a.copy, b.copy]) await waitFor(async () => (await session(id)).status === 'paused', 'the freeze');
  // They stand still while another session goes on.
  const ticks = () => Promise.all([room.board.id, a.copy, b.copy].map(async (id) => (await session(id)).tick)),
    held = await ticks(),
    { tick: from } = await session(going.id);
  await waitFor(async () => (await session(going.id)).tick > from + 10, 'the other to go on');
  assert.deepEqual(await ticks(), held);
  assert.equal((await own(a, a.token, 'play')).status, 403, 'frozen');
  assert.equal((await own(a, a.copy_key, 'play')).status, 200);
  await waitFor(async () => (await session(a.copy)).status === 'paused', 'it is held again');
  const late = await room.enter({ role: 'copy' });
  assert.equal((await session(late.copy)).status, 'paused');
  assert.equal((await room.state()).together, true);
  await room.set({ frozen: false, together: false });
  for (const id of [room.board.id, a.copy]) await waitFor(async () => (await session(id)).status === 'playing', 'it goes on');
  assert.equal((await session(b.copy)).status, 'paused', 'it was paused before');
  assert.equal((await room.state()).copies, 3);
  const kept = await room.member(a.token, { role: 'copy' });
  assert.deepEqual([kept.json.copy, kept.json.copy_key], [a.copy, null], 'the copy that it has');
  const fresh = await room.member(a.token, { role: 'copy', fresh: true });
  assert.notEqual(fresh.json.copy, a.copy);
  assert.equal((await c.get(`/api/v1/sessions/${a.copy}`)).status, 404);
  assert.equal((await room.member(a.token, { role: 'watch' })).json.copy, fresh.json.copy, 'back at the board it keeps its link');
  const empty = await open({ board: null });
  assert.match((await c.call('POST', `${empty.at}/members`, { body: { role: 'copy' } })).json.detail, /no board to copy/);
});

test('frozen, a phase waits for the end of the freeze', async () => {
  const room = await open();
  await room.set({ frozen: true });
  await room.set({ phase: 'run', stop_tick: 0 });
  await pause(400);
  assert.equal((await session(room.board.id)).status, 'paused');
  assert.equal((await room.state()).phase, 'run');
  await room.set({ frozen: false });
  await waitFor(async () => (await session(room.board.id)).status === 'playing', 'the run');
});

// ---- 27, 28: late and lost ----

test('who joins late gets phase and board at once; a lost member gets seat and vote back', async () => {
  const room = await open();
  await room.set({ phase: 'predict', ...LESSON });
  const a = await room.enter({ role: 'play', player: 0 });
  const first = await room.stream(a.token);
  await room.vote(a.token, { step: 1, choice: 3 });
  await waitFor(() => first.messages.some((m) => m.type === 'member' && m.choice === 3), 'its own vote');
  const measured = await waitFor(async () => (await room.seat(0)).rtt_ms !== null && room.seat(0), 'the round trip');
  assert.ok(measured.rtt_ms >= 0, JSON.stringify(measured));
  assert.deepEqual([measured.name, measured.state, measured.lag_ms], ['A', 'held', 150]);
  first.socket.terminate();
  await waitFor(async () => (await room.seat(0)).state === 'away', 'the loss to be reported');
  await room.set({ phase: 'locked' });
  const late = await room.stream();
  assert.deepEqual([late.hello.phase, late.hello.board, late.hello.class, late.hello.code], ['locked', room.board.id, room.id, room.code]);
  const again = await room.stream(a.token);
  const own = await again.wait((m) => m.type === 'member', 'its own state');
  assert.deepEqual(own, { type: 'member', number: 1, role: 'play', player: 0, choice: 3, copy: null });
  await sees(late, (s) => s.seats[0].state === 'held', 'the return');
  await c.patch({ id: room.board.id, owner_key: room.key }, { 'players.0.lag_ms': 40 });
  await sees(late, (s) => s.seats[0].lag_ms === 40, 'the new lag');
  await again.close();
  await late.close();
});

test('after 20 s the script takes the seat, as the class sees; any member may claim it, and its holder until then', async () => {
  const room = await open();
  await room.set({ phase: 'free' });
  const [a, b] = [await room.enter({ role: 'play', player: 0 }), await room.enter({ role: 'play', player: 1 })];
  const projector = await room.stream();
  for (const { token } of [a, b]) await (await room.stream(token)).close();
  const control = async () => (await session(room.board.id)).params.players.map((p) => p.control).join();
  await pause(10000);
  const one = await room.stream(a.token); /* 28: 10 s offline */
  assert.equal((await one.wait((m) => m.type === 'member')).player, 0);
  assert.equal(newest(projector).seats[1].state, 'away');
  await sees(projector, (s) => s.seats[1].state === 'script', 'the script');
  assert.equal(newest(projector).seats[0].state, 'held');
  await waitFor(async () => (await control()) === 'person,script', 'the control');
  assert.equal(
    (await c.call('POST', `/api/v1/sessions/${room.board.id}/input`, { key: b.token, body: { player: 1, axes: [1] } })).status,
    403,
  );
  const two = await room.stream(b.token);
  assert.equal((await two.wait((m) => m.type === 'member')).player, 1);
  await waitFor(async () => (await control()) === 'person,person', 'it is back');
  await Promise.all([one, two, projector].map((s) => s.close()));
});

// ---- several teachers; what a restart does ----

test('a second device is a remote control; a teacher who has gone changes nothing; the end is said', async () => {
  const room = await open();
  const laptop = await room.stream(room.key),
    phone = await room.stream(room.key);
  assert.equal(phone.messages.find((m) => m.type === 'reply').role, 'teacher');
  await room.set({ phase: 'run' });
  for (const s of [laptop, phone]) await sees(s, (m) => m.phase === 'run' && m.status === 'playing', 'the phase');
  laptop.socket.terminate();
  await phone.close();
  await pause(300);
  assert.deepEqual([(await room.state()).phase, (await session(room.board.id)).status], ['run', 'playing']);
  const a = await room.enter(),
    stream = await room.stream(a.token);
  assert.equal((await room.end()).status, 204);
  await waitFor(() => stream.closed, 'the end');
  assert.equal(stream.closed.code, 4404);
  assert.match(stream.messages.at(-1).reason, /the teacher has ended the class/);
  assert.equal((await room.vote(a.token, { step: 0, choice: 0 })).status, 404);
  assert.equal((await session(room.board.id)).status, 'playing', 'the session stays');
  const input = { key: room.key, body: { op: 'pause' } };
  assert.equal((await c.call('POST', `/api/v1/sessions/${room.board.id}/control`, input)).status, 403, 'its key does not');
});

// What outlives it with a store is in tests/daemon/class_restart.test.mjs.
test('without a store a restart ends classes and says so', async (t) => {
  let d = await startDaemon({ data: 'memory' });
  let s = client(d.url);
  const room = await open({}, s);
  await d.kill();
  s.close();
  d = await startDaemon({ data: 'memory' });
  t.after(() => d.stop());
  s = client(d.url);
  t.after(() => s.close());
  const gone = await s.get(`${C}/${room.code}`);
  assert.equal(gone.status, 404);
  assert.match(gone.json.detail, /^Class not found\. It has ended/);
});

// ---- permissions and limits ----

test('with a class key: who opens needs it, who joins does not, copies of members included', async (t) => {
  const keys = { LAGLAB_CLASS_KEY: 'a-class-of-thirty', LAGLAB_OPERATOR_KEY: 'operator-of-this-lab-72' };
  Object.assign(process.env, keys);
  const closed = await startDaemon().finally(() => Object.keys(keys).forEach((name) => delete process.env[name]));
  t.after(() => closed.stop());
  const s = client(closed.url);
  t.after(() => s.close());
  assert.equal((await s.call('POST', C)).status, 401);
  assert.equal((await s.call('POST', C, { key: WRONG })).status, 403);
  const room = await open({ call: { key: keys.LAGLAB_CLASS_KEY } }, s);
  const a = await room.enter({ role: 'copy' });
  assert.match(a.copy, /^[a-z2-7]{26}$/);
  assert.equal((await s.call('POST', `/api/v1/sessions/${room.board.id}/fork`)).status, 401, 'not outside of the class');
  assert.equal((await s.call('DELETE', room.at, { key: keys.LAGLAB_CLASS_KEY })).status, 403);
  assert.equal((await s.call('DELETE', room.at, { key: keys.LAGLAB_OPERATOR_KEY })).status, 204);
});

test('quotas: classes of the daemon, of an address, members; a class without use ends', async (t) => {
  const small = await startDaemon({
    args: ['--max-classes', '3', '--max-client-classes', '2', '--max-class-members', '2', '--class-ttl-s', '2'],
  });
  t.after(() => small.stop());
  const s = client(small.url);
  t.after(() => s.close());
  const room = await open({ board: null }, s),
    other = await open({ board: null }, s);
  const third = await s.call('POST', C);
  assert.equal(third.status, 429);
  assert.match(third.json.detail, /at most 2 at once from one address/);
  for (let i = 0; i < 2; i++) await room.stream((await room.enter()).token);
  const full = await s.call('POST', `${room.at}/members`);
  assert.equal(full.status, 429);
  assert.match(full.json.detail, /full: it has 2 members/);
  const stream = await room.stream();
  await waitFor(async () => (await s.get('/metrics')).text.includes('laglab_classes 1\n'), 'the end of the unused one');
  assert.equal((await s.get(room.at)).status, 200, 'one with a connection lasts');
  assert.equal((await s.get(other.at)).status, 404);
  await stream.close();
});

test('a class has as many boards and copies as --max-class-sessions allows, other classes and sessions their own', async (t) => {
  const small = await startDaemon({ args: ['--max-class-sessions', '2'] });
  t.after(() => small.stop());
  const s = client(small.url);
  t.after(() => s.close());
  const room = await open({}, s),
    other = await open({}, s);
  const copy = await room.enter({ role: 'copy' });
  const refused = await s.call('POST', `${room.at}/members`, { body: { role: 'copy' } });
  assert.equal(refused.status, 429);
  assert.match(refused.json.detail, /at most 2 of one class \(--max-class-sessions\)/);
  await other.enter({ role: 'copy' });
  await s.make({ paused: true });
  assert.equal((await s.call('DELETE', `/api/v1/sessions/${copy.copy}`, { key: copy.copy_key })).status, 204);
  await room.enter({ role: 'copy' });
});

// ---- hostile members ----

test('a message of the stream may have an id, which the answer repeats', async () => {
  const room = await open({ board: null });
  const a = await room.enter(),
    stream = await room.stream();
  for (const id of [7, 'a message']) {
    stream.say({ auth: a.token, id });
    assert.deepEqual(await stream.wait((m) => m.id === id), { type: 'reply', id, ok: true, role: 'member' });
  }
  stream.say({ auth: WRONG, id: 8 });
  assert.equal((await stream.wait((m) => m.id === 8)).problem.status, 403);
  for (const message of [{ auth: a.token, id: 1.5 }, { id: 9 }, { auth: a.token, id: 9, more: 1 }]) {
    const before = stream.messages.length;
    stream.say(message);
    await waitFor(() => stream.messages.slice(before).some((m) => m.type === 'error'), `the refusal of ${JSON.stringify(message)}`);
  }
  await stream.close();
});

test('floods, huge and odd bodies, odd messages: errors, and the class goes on', async () => {
  const room = await open();
  await room.set({ phase: 'predict', ...LESSON });
  const a = await room.enter();
  const flood = await Promise.all(Array.from({ length: 600 }, (_, i) => room.vote(a.token, { step: 1, choice: i % 4 })));
  assert.ok(flood.every(({ status }) => status === 204 || status === 429));
  const counted = flood.filter(({ status }) => status === 204).length;
  assert.ok(counted >= 19 && counted < 100 /* joining counted too */, `${counted} changes of one vote`);
  assert.equal((await room.state()).votes, 1);
  const big = `{"x":"${'y'.repeat(1 << 20)}"}`;
  for (const [method, path, key] of [
    ['PUT', 'vote', a.token],
    ['PATCH', 'member', a.token],
    ['POST', 'members', a.token],
    ['PUT', 'board', room.key],
  ]) {
    assert.equal((await c.call(method, `${room.at}/${path}`, { key, body: big })).status, 413);
    assert.equal((await c.call(method, `${room.at}/${path}`, { key, body: 'x=1', type: 'text/plain' })).status, 415);
    for (const body of ['[]', '"x"', '{"role":{}}', '{"nonsense":1}', '{', `{"role":"${'x'.repeat(5000)}"}`])
      assert.equal((await c.call(method, `${room.at}/${path}`, { key, body })).status, 400, `${path} ${body.slice(0, 40)}`);
  }
  for (const player of [-2, 16, 1e9, 0.5, '0']) {
    const answer = await c.call('POST', `${room.at}/members`, { body: { role: 'play', player } });
    assert.equal(answer.status, 400, `${player}`);
    assert.match(answer.json.detail, /player/);
  }
  for (const name of ['%00', 'K7Q', 'K7QFX', 'a'.repeat(26), 'x'.repeat(3000), "';--"])
    assert.ok([400, 404].includes((await c.get(`${C}/${name}`)).status), name);
  const stream = await room.stream();
  for (const text of ['{}', '[]', 'x', '{"auth":1}', '{"auth":"x"}', '{"auth":"x","more":1}', '{"vote":{"step":1,"choice":0}}']) {
    const before = stream.messages.length;
    stream.say(text);
    await waitFor(() => stream.messages.slice(before).some((m) => m.type === 'error'), `the refusal of ${text}`);
  }
  for (let i = 0; i < 1500; i++) stream.say({ auth: WRONG });
  await waitFor(() => stream.closed, 'the end of a flood');
  assert.ok([1008, 1013].includes(stream.closed.code), `${stream.closed.code}`); /* too many, or its answers not read */
  const upgrade = [
    `GET /api/v1/classes/${room.code}/stream HTTP/1.1`,
    'Host: localhost',
    'Connection: Upgrade',
    'Upgrade: websocket',
    'Sec-WebSocket-Version: 13',
    'Sec-WebSocket-Key: MDEyMzQ1Njc4OWFiY2RlZg==',
    'Sec-WebSocket-Protocol: laglab.v2.json',
    '\r\n',
  ].join('\r\n');
  assert.match(
    (await raw(daemon.port, upgrade, HANG_MS, headed)).text,
    /^HTTP\/1.1 404 /,
    'codes are not looked up by streams, which nothing limits',
  );
  assert.equal((await room.state()).votes, 1);
});

test('members come and go in every phase', async () => {
  const room = await open();
  for (const phase of ['lobby', 'predict', 'locked', 'run', 'stopped', 'explain', 'change', 'free']) {
    await room.set({ phase, ...LESSON });
    const a = await room.enter({ role: 'play', player: 0 });
    const [kept, lost] = [await room.stream(a.token), await room.stream(a.token)];
    lost.socket.terminate();
    await kept.close();
    const held = await room.stream(a.token);
    assert.equal((await held.wait((m) => m.type === 'member')).player, 0, phase);
    assert.equal((await c.call('DELETE', `${room.at}/member`, { key: a.token })).status, 204);
    assert.equal((await room.member(a.token)).status, 403);
    await waitFor(async () => (await room.seat(0)).state === 'free', `the seat in phase ${phase}`);
    await held.close();
  }
  await waitFor(async () => (await room.state()).n === 0, 'the end');
});

// ---- 29, 30 ----

test('no name, token or key is stored or logged, or part of an address', async (t) => {
  const own = await startDaemon();
  t.after(() => own.stop());
  const s = client(own.url);
  t.after(() => s.close());
  const room = await open({}, s);
  const a = await room.enter({ role: 'play' });
  const refused = await s.call('POST', `${room.at}/members`, { body: { name: 'Anna Example' } });
  assert.equal(refused.status, 400);
  const stream = await room.stream(a.token);
  await room.set({ phase: 'predict', ...LESSON });
  await room.vote(a.token, { step: 1, choice: 1 });
  const texts = [
    JSON.stringify(stream.messages),
    JSON.stringify((await s.get(room.at)).json),
    (await s.get('/metrics')).text,
    own.errors(),
  ];
  const { execFileSync } = await import('node:child_process');
  const stored = execFileSync('sh', ['-c', 'cat "$0"/*', own.data], { encoding: 'latin1', maxBuffer: 1 << 28 });
  for (const secret of [a.token, room.key, 'Anna']) for (const text of [...texts, stored]) assert.ok(!text.includes(secret));
  for (const link of Object.values({ ...room.links, ...a.links })) assert.ok(!link.includes(a.token) && !link.includes(room.key));
  await stream.close();
});
