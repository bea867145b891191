// Several daemons over one PostgreSQL: who is killed, frozen, drained or without its database loses nothing that was acknowledged, and
// no session is run by two.
import assert from 'node:assert/strict';
import { spawn, spawnSync } from 'node:child_process';
import { once } from 'node:events';
import { readFileSync, readdirSync } from 'node:fs';
import { after, before, test } from 'node:test';
import { ownPostgres } from '../lib/chaos.mjs';
import { client, openStream, pause, waitFor } from '../lib/client.mjs';
import { BINARY, startDaemon } from '../lib/daemon.mjs';
import { eventually, freePort, member, memberOf, metric } from '../lib/group.mjs';

const { missing: skip, call: postgres } = ownPostgres();

/** @type {string} */
let url;
before(() => {
  if (!skip) url = postgres('start');
});
after(() => {
  if (!skip) postgres('remove');
});

const join = (t, wish) => memberOf(t, url, wish);

/** Each thread of a stopped process stands: on a busy machine a signal takes a moment, and one may still work until then. */
const isStopped = (pid) =>
  readdirSync(`/proc/${pid}/task`).every((thread) => /\) T /.test(readFileSync(`/proc/${pid}/task/${thread}/stat`, 'utf8')));

/** Lags that the log says were set, in order. */
const lags = async (c, session) =>
  (await c.get(session.links.log)).text
    .trimEnd()
    .split('\n')
    .map((line) => JSON.parse(line))
    .filter((line) => line.op === 'set')
    .map((line) => line.values['players.0.lag_ms']);

/** The log without the state hashes that it is given for reading. */
const commands = async (c, session) =>
  (await c.get(session.links.log)).text.split('\n').filter((line) => line && !('hash' in JSON.parse(line)));

const sameTick = (a, b) => assert.deepEqual([a.tick, a.hash], [b.tick, b.hash]);

test('kill -9 of the owner: another answers within two seconds with the same log and hash', { skip }, async (t) => {
  const [a, b] = await Promise.all([join(t, { lease: 30 }), join(t, { lease: 30 })]);
  const paused = await a.c.make({ paused: true, seed: 4 }),
    playing = await a.c.make({ speed: 1 });
  const acknowledged = [];
  for (let i = 1; i <= 20; i++) {
    assert.equal((await a.c.patch(paused, { 'players.0.lag_ms': i })).status, 200);
    acknowledged.push(i);
    await a.c.control(paused, { op: 'step', ticks: 3 });
  }
  const log = await commands(a.c, paused),
    state = (await a.c.get(paused.links.state)).json,
    seen = (await a.c.get(playing.links.self)).json;
  const stream = await a.c.stream(playing);
  await stream.frame();
  await a.kill();
  const { answer, took } = await eventually(() => b.c.get(paused.links.state));
  assert.ok(took < 2000, `${took} ms`);
  assert.equal(answer.status, 200, answer.text);
  sameTick(answer.json, state);
  assert.deepEqual(await commands(b.c, paused), log);
  assert.deepEqual(await lags(b.c, paused), acknowledged);
  // A viewer comes first, with a message before its hello.
  const viewer = await b.c.stream(playing);
  viewer.say({ auth: playing.owner_key, id: 1 });
  assert.equal((await viewer.wait((each) => each.id === 1)).ok, true);
  assert.ok((await viewer.frame((each) => each.tick > seen.tick)).tick < seen.tick + 600, 'the same tick goes on');
  assert.equal((await b.c.patch(paused, { 'players.0.lag_ms': 99 })).status, 200);
  assert.equal(await metric(b.c, 'claims_total', 'dead'), 2);
  assert.equal(await metric(b.c, 'replay_mismatch_total'), 0);
  t.diagnostic(`answered after ${took.toFixed(0)} ms`);
  await viewer.close();
});

test('a viewer and a request find a session at any daemon, and a code', { skip }, async (t) => {
  const [a, b] = await Promise.all([join(t, { lease: 30 }), join(t, { lease: 30 })]);
  const session = await a.c.make({ paused: true });
  const first = await a.c.stream(session);
  assert.equal((await b.c.get(`/api/v1/codes/${session.code}`)).json.id, session.id);
  assert.equal((await b.c.get('/api/v1/codes/2222')).status, 404);
  // It was made at A and is given away at once: its viewers there are sent to where it is.
  const viewer = await b.c.stream(session);
  await viewer.frame();
  await waitFor(() => first.closed, 'the end of the stream at its first daemon');
  assert.equal(first.closed.code, 1012);
  assert.equal((await b.c.patch(session, { 'players.0.lag_ms': 7 })).status, 200);
  assert.equal(await metric(b.c, 'claims_total', 'given'), 1);
  assert.equal(await metric(a.c, 'sessions_given_total'), 1);
  // B keeps it for a while.
  const back = await a.c.get(session.links.self);
  assert.equal(back.status, 503, back.text);
  assert.ok(Number(back.headers['retry-after']) >= 1 && back.json.detail.includes(`http://127.0.0.1:${b.port}`), back.text);
  assert.equal(viewer.closed, undefined);
  // What is not there is not there, for both.
  const none = session.links.self.replace(session.id, 'a'.repeat(26));
  assert.equal((await a.c.get(none)).status, 404);
  await assert.rejects(b.c.stream({ id: 'b'.repeat(26) }), { code: 4404 });
  assert.equal((await b.c.call('DELETE', session.links.self, { key: session.owner_key })).status, 204);
  assert.equal((await a.c.get(session.links.self)).status, 404);
  assert.equal((await a.c.get(`/api/v1/codes/${session.code}`)).status, 404);
});

test('a repeated request is answered once, through any daemon', { skip, timeout: 40000 }, async (t) => {
  const [a, b] = await Promise.all([join(t, { lease: 30 }), join(t, { lease: 30 })]);
  const body = { scenario: 'race', paused: true };
  const post = (c, name, /** @type {object} */ given = body) =>
    c.call('POST', '/api/v1/sessions', { body: given, headers: { 'Idempotency-Key': name } });
  const count = () => Number(postgres('sql', 'SELECT count(*) FROM laglab_sessions.session'));
  const before = count();
  const first = await post(a.c, 'one');
  assert.equal(first.status, 201, first.text);
  for (const { c } of [b, a, b]) {
    const again = await post(c, 'one');
    assert.deepEqual([again.status, again.json, again.headers.location], [201, first.json, first.headers.location]);
  }
  assert.equal((await post(b.c, 'one', { ...body, seed: 1 })).status, 422);
  const dump = postgres('sql', 'SELECT name, body, answer FROM laglab_sessions.answer');
  assert.ok(dump.length > 200);
  for (const secret of [first.json.owner_key, first.json.id, ...first.json.player_keys]) assert.ok(!dump.includes(secret), 'it is sealed');
  // One that failed gives its key back at once.
  assert.equal((await post(a.c, 'two', { scenario: 'no such' })).status, 400);
  assert.equal((await post(b.c, 'two')).status, 201);
  assert.equal(count(), before + 2);
  // At once at both: one makes it.
  const burst = await Promise.all(Array.from({ length: 12 }, (_, i) => post([a, b][i % 2].c, 'three')));
  assert.ok(burst.every(({ status }) => status === 201 || status === 409));
  assert.equal(new Set(burst.filter(({ status }) => status === 201).map(({ json }) => json.id)).size, 1);
  assert.equal(count(), before + 3);
  // A dies at some point of each of these; who repeats gets what it answered, or would have.
  const names = Array.from({ length: 24 }, (_, i) => `kill ${i}`);
  const begun = names.map((name) => post(a.c, name).catch(() => null));
  await Promise.any(begun);
  await a.kill();
  const got = await Promise.all(begun);
  const known = got.filter((one) => one?.status === 201).length;
  for (const [i, name] of names.entries()) {
    const { answer } = await eventually(() => post(b.c, name));
    assert.equal(answer.status, 201, answer.text);
    if (got[i]?.status === 201) assert.deepEqual(answer.json, got[i].json);
    assert.equal((await b.c.patch(answer.json, { 'players.0.lag_ms': 5 })).status, 200, 'its key counts');
  }
  assert.equal(count(), before + 3 + names.length, 'none was made twice');
  t.diagnostic(`${known} of ${names.length} were answered before`);
});

test('an owner that is frozen beyond its lease cannot write when it wakes, and drops its sessions', { skip }, async (t) => {
  const [a, b] = await Promise.all([join(t, { lease: 1.5 }), join(t, { lease: 1.5 })]);
  const session = await a.c.make({ paused: true });
  const acknowledged = [];
  for (let i = 1; i <= 5; i++) if ((await a.c.patch(session, { 'players.0.lag_ms': i })).status === 200) acknowledged.push(i);
  const viewer = await a.c.stream(session);
  process.kill(a.pid, 'SIGSTOP');
  await waitFor(() => isStopped(a.pid), 'the owner to stand still');
  // One command is on its way to the frozen daemon.
  const late = a.c.patch(session, { 'players.0.lag_ms': 500 }).catch(() => ({ status: 0 }));
  const { took } = await eventually(() => b.c.get(session.links.self));
  assert.ok(took < 1500 + 1500, `${took} ms`);
  assert.equal((await b.c.patch(session, { 'players.0.lag_ms': 50 })).status, 200);
  acknowledged.push(50);
  await (await b.c.stream(session)).frame(); // with a viewer B keeps it
  process.kill(a.pid, 'SIGCONT');
  await waitFor(() => viewer.closed, 'the viewer of the old owner to be sent away');
  assert.ok([1012, 1013].includes(viewer.closed.code), `${viewer.closed.code}`);
  const [first, refused] = await Promise.all([late, a.c.patch(session, { 'players.0.lag_ms': 600 })]);
  if (first.status === 200) acknowledged.push(500);
  assert.equal(refused.status, 503, refused.text);
  assert.ok(Number(refused.headers['retry-after']) >= 1);
  assert.deepEqual(await lags(b.c, session), acknowledged);
  await waitFor(async () => (await a.c.get('/readyz')).status === 200, 'the old owner as a new daemon');
  await waitFor(async () => (await metric(a.c, 'sessions')) === 0, 'the old owner to drop its session');
  t.diagnostic(`taken over after ${took.toFixed(0)} ms`);
});

test('the database crashes and comes back: nothing moves, nothing is lost', { skip }, async (t) => {
  const daemons = await Promise.all([join(t, { lease: 8 }), join(t, { lease: 8 })]);
  const sessions = [];
  for (const { c } of daemons) {
    const session = await c.make({ paused: true });
    sessions.push({ c, session, acknowledged: [], stream: await c.stream(session) });
  }
  let load = true;
  const work = sessions.map(async ({ c, session, acknowledged }) => {
    for (let i = 1; load; i++) {
      const value = i % 1000;
      const answer = await c.patch(session, { 'players.0.lag_ms': value });
      if (answer.status === 200) acknowledged.push(value);
      else assert.equal(answer.status, 503, answer.text);
      await pause(5);
    }
  });
  await pause(200);
  postgres('kill');
  await pause(300);
  assert.equal(postgres('start'), url);
  await pause(700);
  load = false;
  await Promise.all(work);
  for (const { c, session, acknowledged, stream } of sessions) {
    const found = await lags(c, session);
    let at = 0;
    for (const value of acknowledged) {
      while (at < found.length && found[at] !== value) at++;
      assert.ok(at < found.length, `${value} was acknowledged and is not in the log`);
      at++;
    }
    assert.equal(stream.closed, undefined, 'its viewer stayed');
    assert.equal(await metric(c, 'claims_total'), 0);
    t.diagnostic(`${acknowledged.length} acknowledged, ${found.length} stored`);
  }
});

test('without the database for longer all freezes, and goes on', { skip }, async (t) => {
  const a = await join(t, { lease: 1.5 });
  const session = await a.c.make({ speed: 1 });
  const viewer = await a.c.stream(session);
  await viewer.frame();
  assert.ok((await metric(a.c, 'lease_left_seconds')) > 0);
  postgres('kill');
  await waitFor(async () => (await a.c.get('/readyz')).status === 404, 'it to freeze');
  await waitFor(() => viewer.closed, 'its viewer to be sent away');
  assert.equal(viewer.closed.code, 1013);
  assert.equal(await metric(a.c, 'lease_left_seconds'), 0);
  for (const answer of [
    await a.c.get(session.links.state),
    await a.c.patch(session, { 'players.0.lag_ms': 3 }),
    await a.c.call('POST', '/api/v1/sessions', { body: { scenario: 'race' } }),
  ])
    assert.equal(answer.status, 503, answer.text);
  assert.equal((await a.c.get('/healthz')).status, 200);
  postgres('start');
  await waitFor(async () => (await a.c.get('/readyz')).status === 200, 'it to go on');
  assert.equal((await a.c.patch(session, { 'players.0.lag_ms': 4 })).status, 200);
  const again = await a.c.stream(session);
  await again.frame();
  assert.equal(await metric(a.c, 'claims_total'), 0, 'it kept its memory');
});

test('SIGTERM hands sessions over', { skip }, async (t) => {
  const [a, b] = await Promise.all([join(t, { lease: 30 }), join(t, { lease: 30 })]);
  const session = await a.c.make({ paused: true }),
    playing = await a.c.make({ speed: 1 });
  await a.c.control(session, { op: 'step', ticks: 77 });
  const state = (await a.c.get(session.links.state)).json;
  const viewer = await a.c.stream(playing);
  await viewer.frame();
  const ended = a.stop();
  await waitFor(async () => (await a.c.get('/readyz')).status === 404, '404', 2000);
  await waitFor(() => viewer.closed, 'the viewer to be sent on');
  assert.equal(viewer.closed.code, 1012);
  const last = viewer.frames.at(-1).tick;
  const there = await b.c.stream(playing);
  assert.ok((await there.frame()).tick >= last, 'no tick is shown again');
  sameTick((await b.c.get(session.links.state)).json, state);
  assert.equal((await ended).code, 0, a.errors());
  assert.equal((await metric(b.c, 'claims_total', 'free')) + (await metric(b.c, 'claims_total', 'given')), 2);
  assert.equal(await metric(b.c, 'claims_total', 'dead'), 0);
});

test('a daemon that is started again on its address has its sessions at once', { skip }, async (t) => {
  const a = await join(t, { lease: 30 });
  const session = await a.c.make({ paused: true });
  await a.c.control(session, { op: 'step', ticks: 50 });
  const state = (await a.c.get(session.links.state)).json;
  await a.kill();
  const again = await join(t, { lease: 30, port: a.port });
  const answer = await again.c.get(session.links.state);
  assert.equal(answer.status, 200, answer.text);
  sameTick(answer.json, state);
});

test('many requests for sessions that another daemon keeps hold up nothing else', { skip }, async (t) => {
  const [a, b] = await Promise.all([join(t, { lease: 30 }), join(t, { lease: 30 })]);
  const sessions = await Promise.all(Array.from({ length: 60 }, () => a.c.make({ paused: true })));
  /* B has just claimed them, for viewers. */
  for (let i = 0; i < 60; i += 10) await Promise.all(sessions.slice(i, i + 10).map((session) => b.c.stream(session)));
  const asked = sessions.map((session) => a.c.get(session.links.self));
  await pause(50);
  const took = [];
  for (let i = 0; i < 5; i++) {
    const begun = performance.now();
    assert.equal((await a.c.get('/api/v1/scenarios')).status, 200); // a task, as are requests that wait for a session
    took.push(performance.now() - begun);
    assert.equal((await a.c.get('/readyz')).status, 200);
  }
  const slowest = Math.max(...took);
  t.diagnostic(`${took.map((ms) => ms.toFixed(0))} ms`);
  assert.ok(slowest < 600, `${slowest} ms`);
  for (const answer of await Promise.all(asked)) assert.equal(answer.status, 503, answer.text);
});

test('a viewer follows a session that has no viewer where it is; without room it is asked to come again', { skip }, async (t) => {
  const [a, b] = await Promise.all([join(t, { lease: 30 }), join(t, { lease: 30, args: ['--max-sessions', '1'] })]);
  const session = await a.c.make({ paused: true }),
    other = await a.c.make({ paused: true });
  assert.equal((await b.c.get(session.links.self)).status, 200); // a request that went astray
  await assert.rejects(b.c.stream(other), /503/);
  const begun = performance.now();
  await (await a.c.stream(session)).frame();
  const took = performance.now() - begun;
  t.diagnostic(`${took.toFixed(0)} ms`);
  assert.ok(took < 2000, `${took} ms`);
});

test('a daemon that starts before its database waits for it, as long as it may', { skip }, async (t) => {
  const other = ownPostgres().call;
  try {
    const its = other('start');
    other('kill');
    await assert.rejects(member(its, { args: ['--store-wait-s', '0'] }), /ended with 1: .*not usable/s);
    const port = await freePort(),
      c = client(`http://127.0.0.1:${port}/`);
    t.after(() => c.close());
    const starting = member(its, { port });
    // Alive and not ready; what asks for anything else may come again.
    await waitFor(async () => (await c.get('/healthz').catch(() => null))?.status === 200, 'it is alive');
    const early = await c.get('/readyz');
    assert.deepEqual([early.status, /** @type {any} */ (early.json).detail], [404, 'The daemon is starting: it waits for its store.']);
    const session = '/api/v1/sessions';
    for (const { status, headers } of [
      await c.get('/'),
      await c.get('/metrics'),
      await c.get(`${session}/${'a'.repeat(26)}?x=1`),
      await c.call('POST', session, { body: { scenario: 'race' } }),
      await c.call('DELETE', `${session}/${'a'.repeat(26)}`),
    ]) {
      assert.equal(status, 503);
      assert.ok(Number(headers['retry-after']) >= 1);
    }
    await assert.rejects(openStream(c.url, `sessions/${'a'.repeat(26)}`), { status: 503 });
    // From here on it is asked all the time: no connection is refused while it becomes ready.
    const end = performance.now() + 20000;
    let last = 0,
      asked = 0,
      refused = 0;
    const asking = (async () => {
      for (; last !== 200 && performance.now() < end; asked++) {
        const answer = await fetch(`${c.url}readyz`, { headers: { connection: 'close' }, signal: AbortSignal.timeout(5000) }).catch(
          (error) => {
            if (error.cause?.code === 'ECONNREFUSED') refused++;
            return null; // of one that was accepted just before the end its head was not read
          },
        );
        await answer?.text();
        last = answer?.status ?? 0;
      }
    })();
    assert.equal(other('start'), its);
    const daemon = await starting;
    t.after(daemon.kill);
    await asking;
    assert.deepEqual([last, refused], [200, 0]);
    t.diagnostic(`asked ${asked} times`);
    assert.match(daemon.errors(), /waiting for the store.*not usable/);
    assert.equal((await daemon.c.get('/readyz')).status, 200);
    daemon.c.close();
    await daemon.kill();
    other('kill');
    const child = spawn(BINARY, ['serve', '--listen', '127.0.0.1:0', '--store', its], { stdio: ['ignore', 'ignore', 'pipe'] });
    await once(child.stderr, 'data');
    child.kill('SIGTERM');
    assert.deepEqual(await once(child, 'exit'), [0, null]);
  } finally {
    other('remove');
  }
});

test('another engine is named, and a replay that differs is no session', { skip }, async (t) => {
  const [a, b] = await Promise.all([join(t, { lease: 30 }), join(t, { lease: 30 })]);
  const foreign = await a.c.make({ paused: true }),
    differs = await a.c.make({ paused: true });
  await a.c.control(differs, { op: 'step', ticks: 90 });
  const log = (await a.c.get(differs.links.log)).text;
  await a.kill();
  postgres('sql', `UPDATE laglab_sessions.session SET engine='0123456789ab' WHERE id='${foreign.id}'`);
  postgres('sql', `UPDATE laglab_sessions.session SET hash=hash+1 WHERE id='${differs.id}' AND hash_lines>0`);
  const other = await b.c.get(foreign.links.self);
  assert.equal(other.status, 409, other.text);
  assert.match(other.json.detail, /engine 0123456789ab, and this daemon has engine [0-9a-f]{12}/);
  await assert.rejects(b.c.stream(foreign), { code: 4404 });
  const wrong = await b.c.get(differs.links.self);
  assert.equal(wrong.status, 409, wrong.text);
  assert.match(wrong.json.detail, /another state/);
  assert.equal(await metric(b.c, 'replay_mismatch_total'), 1);
  const kept = await b.c.get(differs.links.log);
  assert.equal(kept.status, 200, kept.text);
  assert.ok(log.startsWith(kept.text.split('\n')[0]), 'the same header');
});

const numberOf = ({ id }) => `(SELECT no FROM laglab_sessions.session WHERE id='${id}')`;

/** The sizes of the stored states, by session. @returns {Map<string, number>} */
const states = () =>
  new Map(
    postgres('sql', 'SELECT id, length(body) FROM laglab_sessions.state JOIN laglab_sessions.session ON no=session')
      .split('\n')
      .filter(Boolean)
      .map((line) => line.split('|'))
      .map(([id, lines]) => [id, Number(lines)]),
  );

test('a session with a long log begins from a stored state: same hash, same later ones; without it, from its log', { skip }, async (t) => {
  const [a, b] = await Promise.all([join(t, { lease: 30 }), join(t, { lease: 30 })]);
  const young = await a.c.make({ paused: true }),
    old = await Promise.all([1, 2, 3, 4].map((seed) => a.c.make({ scenario: 'cannon_drag', paused: true, seed })));
  const [, rewound, damaged, late] = old; // the first one is as it was
  const step = async (c, session, ticks) => assert.equal((await c.control(session, { op: 'step', ticks })).status, 200);
  for (const session of old) {
    for (let i = 1; i <= 6; i++) {
      await step(a.c, session, 200);
      assert.equal((await a.c.patch(session, { 'players.0.lag_ms': i })).status, 200);
    }
  }
  await step(a.c, young, 20);
  await waitFor(() => old.every(({ id }) => states().has(id)), 'the states', 10000);
  assert.equal(states().has(young.id), false, 'its log is replayed at once');
  // A command at an earlier tick: the state is of a run that the log does not have any more.
  await a.c.control(rewound, { op: 'seek', tick: 100 });
  await a.c.patch(rewound, { 'players.0.lag_ms': 77 });
  await step(a.c, late, 3);
  await a.c.patch(late, { 'players.0.lag_ms': 88 });
  const seen = await Promise.all(old.map(async (session) => (await a.c.get(session.links.state)).json));
  await a.kill();
  postgres('sql', `UPDATE laglab_sessions.state SET body=substr(body,1,length(body)-9) WHERE session=${numberOf(damaged)}`);
  for (const [i, session] of old.entries()) {
    const { answer } = await eventually(() => b.c.get(session.links.state));
    assert.equal(answer.status, 200, answer.text);
    sameTick(answer.json, seen[i]);
  }
  assert.equal(await metric(b.c, 'states_used_total'), 2, 'used and late');
  assert.equal(await metric(b.c, 'replay_mismatch_total'), 0);
  // All go on as their logs say from the beginning.
  for (const session of [...old, young]) {
    await step(b.c, session, 40);
    // The log has the hash of the present tick.
    const replay = spawnSync(BINARY, ['replay', '-'], { input: (await b.c.get(session.links.log)).text, encoding: 'utf8' });
    assert.equal(replay.status, 0, replay.stderr);
    assert.ok(replay.stdout.includes((await b.c.get(session.links.state)).json.hash), replay.stdout);
  }
});

test('a parked session wakes from its state, by four requests at once; the state of another log is not used', { skip }, async (t) => {
  const args = ['--park-after-s', '0.2'];
  const [a, b] = await Promise.all([join(t, { lease: 30, args }), join(t, { lease: 30, args })]);
  // Each tick takes more than the 2 ms that a worker has for a piece: tasks run it, and unlock the session meanwhile.
  const heavy = await a.c.make({ scenario: 'stack_rollback', paused: true });
  await a.c.control(heavy, { op: 'step', ticks: 150 });
  await waitFor(() => states().has(heavy.id), 'its state', 10000);
  const state = (await a.c.get(heavy.links.state)).json;
  for (let round = 1; round <= 3; round++) {
    await waitFor(async () => (await metric(a.c, 'sessions_parked')) === 1, 'it is parked', 10000);
    const seen = await Promise.all([1, 2, 3, 4].map(() => a.c.get(heavy.links.state)));
    for (const answer of seen) sameTick(answer.json, state);
    assert.equal(await metric(a.c, 'states_used_total'), round);
  }
  // The state of another session, whose log is the same, but not its seed.
  const other = await a.c.make({ scenario: 'stack_rollback', paused: true, seed: 99 });
  await a.c.control(other, { op: 'step', ticks: 150 });
  await waitFor(() => states().has(other.id), 'the other state', 10000);
  await a.kill();
  postgres(
    'sql',
    `UPDATE laglab_sessions.state SET body=(SELECT body FROM laglab_sessions.state WHERE session=${numberOf(other)})
      WHERE session=${numberOf(heavy)}`,
  );
  const { answer } = await eventually(() => b.c.get(heavy.links.state));
  sameTick(answer.json, state);
  assert.equal(await metric(b.c, 'states_used_total'), 0);
  assert.equal(await metric(b.c, 'replay_mismatch_total'), 0);
});

test('a single daemon without --url keeps its sessions over a restart', { skip }, async (t) => {
  const port = await freePort();
  const one = await startDaemon({ listen: `127.0.0.1:${port}`, args: ['--store', url] });
  const c = client(one.url),
    session = await c.make({ paused: true });
  await c.control(session, { op: 'step', ticks: 30 });
  const state = (await c.get(session.links.state)).json;
  assert.equal((await c.call('POST', '/api/v1/classes', { body: {} })).status, 201);
  c.close();
  assert.equal((await one.stop()).code, 0);
  const again = await startDaemon({ listen: `127.0.0.1:${port}`, args: ['--store', url] });
  t.after(() => again.stop());
  const d = client(again.url);
  t.after(() => d.close());
  sameTick((await d.get(session.links.state)).json, state);
});

const SESSIONS = 200,
  ROUNDS = 3,
  AT_ONCE = 24;

/** Runs jobs, a number of them at a time. @template T @param {T[]} list @param {(item: T) => Promise<void>} job */
async function each(list, job) {
  const waiting = [...list];
  const one = async () => {
    for (let item = waiting.pop(); item; item = waiting.pop()) await job(item);
  };
  await Promise.all(Array.from({ length: AT_ONCE }, one));
}

test(`${SESSIONS} sessions through kills of their daemons are as undisturbed ones`, { skip, timeout: 110000 }, async (t) => {
  const seed = Number(process.env.LAGLAB_TEST_SEED ?? Date.now() % 1e6);
  let random = seed;
  const chance = () => (random = (random * 1103515245 + 12345) % 2147483648) / 2147483648;
  t.diagnostic(`LAGLAB_TEST_SEED=${seed}`);
  const daemons = await Promise.all([join(t, { lease: 3 }), join(t, { lease: 3 }), join(t, { lease: 3 })]);
  const twin = await startDaemon({ data: 'memory', args: ['--max-new-sessions-per-min', '100000', '--max-commands-per-s', '100000'] });
  t.after(() => twin.stop());
  const calm = client(twin.url);
  t.after(() => calm.close());
  const known = Array.from({ length: SESSIONS }, (_, i) => ({ i, at: i % daemons.length, session: null, ticks: 0, lags: [] }));

  /** As a proxy: the daemon that had it, and the next one when that is gone. */
  const ask = async (one, request) => {
    const { answer } = await eventually(async () => {
      try {
        return await request(daemons[one.at].c);
      } catch (error) {
        one.at = (one.at + 1) % daemons.length;
        throw error;
      }
    }, 20000);
    assert.equal(answer.status, 200, answer.text);
    return answer.json;
  };
  await each(known, async (one) => {
    one.session = await daemons[one.at].c.make({ paused: true, seed: one.i });
  });
  let kills = 0,
    repeated = 0,
    on = true;
  const killer = (async () => {
    while (on && kills < 8) {
      await pause(200 + 400 * chance());
      const i = Math.floor(chance() * daemons.length),
        { port } = daemons[i];
      daemons[i].c.close();
      await daemons[i].kill();
      kills++;
      await pause(200 * chance());
      daemons[i] = await join(t, { lease: 3, port });
    }
  })();
  for (let round = 1; round <= ROUNDS; round++) {
    await each(known, async (one) => {
      const lag = (one.i * 7 + round * 31) % 400,
        goal = round * 40;
      await ask(one, (c) => c.patch(one.session, { 'players.0.lag_ms': lag }));
      one.lags.push(lag);
      // A step whose answer is lost may have been made: then only what is missing is made.
      for (let at = (await ask(one, (c) => c.get(one.session.links.self))).tick; at < goal; ) {
        let tried = 0;
        const { answer } = await eventually(async () => {
          if (tried++ > 0) {
            repeated++;
            at = (await ask(one, (c) => c.get(one.session.links.self))).tick;
          }
          return at < goal ? daemons[one.at].c.control(one.session, { op: 'step', ticks: goal - at }) : { status: 200, json: { tick: at } };
        }, 20000);
        at = answer.json.tick;
      }
    });
  }
  on = false;
  await killer;
  let differ = 0,
    lost = 0;
  await each(known, async (one) => {
    const state = await ask(one, (c) => c.get(one.session.links.state));
    const found = new Set(await lags(daemons[one.at].c, one.session));
    lost += one.lags.filter((lag) => !found.has(lag)).length;
    const same = await calm.make({ paused: true, seed: one.i });
    for (let round = 1; round <= ROUNDS; round++) {
      await calm.patch(same, { 'players.0.lag_ms': one.lags[round - 1] });
      await calm.control(same, { op: 'step', ticks: 40 });
    }
    const { tick, hash } = (await calm.get(same.links.state)).json;
    differ += state.tick !== tick || state.hash !== hash ? 1 : 0;
  });
  const claims = (await Promise.all(daemons.map(({ c }) => metric(c, 'claims_total')))).reduce((sum, n) => sum + n);
  t.diagnostic(`${kills} kills, ${claims} sessions claimed by the last daemons, ${repeated} steps repeated`);
  assert.deepEqual([lost, differ], [0, 0]);
  assert.ok(kills >= 2 && claims > 0);
});
