// Sessions without viewers cost nothing and are at the right tick when they are viewed again; slow, silent or hostile viewers harm neither
// their session nor other viewers.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import { client, pause, waitFor, decodeAll, seqOf } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';
import { threads_s } from '../lib/hostile.mjs';

/** A daemon that is stopped at the end of the test, also when it fails. */
const start = async (t, wish) => {
  const daemon = await startDaemon(wish);
  t.after(() => daemon.stop());
  return daemon;
};

const gauge = async (c, name) => Number(new RegExp(`^laglab_${name} (.+)$`, 'm').exec((await c.get('/metrics')).text)[1]);

test('a hundred parked sessions make no ticks and no frames, and catch up when they are viewed', async (t) => {
  const daemon = await start(t, { args: ['--park-after-s', '2', '--max-new-sessions-per-min', '1000'] });
  const c = client(daemon.url);
  const sessions = [];
  for (let i = 0; i < 100; i++) sessions.push({ ...(await c.make({ set: { duration_s: 600 } })), begun: performance.now() });
  const stream = await c.stream(sessions[0], 'bin');
  await stream.close();
  const made = async () => [await gauge(c, 'ticks_total'), await gauge(c, 'frames_published_total')];
  await waitFor(async () => (await made())[0] > 0, 'ticks');
  await waitFor(async () => (await gauge(c, 'sessions_parked')) === 100, 'all to be parked');
  const before = await made();
  await pause(1000);
  assert.deepEqual(await made(), before);
  for (const session of sessions) {
    const read = async () => (await c.get(session.links.self)).json;
    assert.equal((await read()).parked, true);
    // On a busy machine the answer may be the tick that it has reached so far.
    await waitFor(async () => Math.abs((await read()).time_s - (performance.now() - session.begun) / 1000) < 0.5, 'virtual time');
  }
  c.close();
  await daemon.stop();
});

test('waking a long session does not stall another', async (t) => {
  const daemon = await start(t, { args: ['--park-after-s', '0.3', '--threads', '1'] });
  const c = client(daemon.url);
  const long = await c.make({ scenario: 'eight', paused: true, set: { duration_s: 3600 } }),
    other = await c.make({ set: { duration_s: 600 } });
  assert.equal((await c.control(long, { op: 'seek', time_s: 900 })).status, 200);
  await c.control(long, { op: 'play' });
  await waitFor(async () => (await gauge(c, 'sessions_parked')) === 2, 'both to be parked');
  const watched = await c.stream(other, 'bin', { ack: true });
  await waitFor(() => watched.frames.length > 5, 'frames of the other');
  const from = watched.frames.length,
    begun = performance.now();
  const woken = await c.stream(long, 'bin', { ack: true });
  const meanwhile = watched.frames.length - from;
  t.diagnostic(`woken after ${Math.round(performance.now() - begun)} ms, with ${meanwhile} frames of the other meanwhile`);
  assert.ok(meanwhile > 3, 'the worker does not wake the session itself');
  await woken.frame();
  assert.ok((await decodeAll(woken.frames, woken.hello.tick_hz))[0].time_s >= 900);
  for (const stream of [watched, woken]) await stream.close();
  c.close();
  await daemon.stop();
});

test('slow, silent and hostile viewers together with a good one', async (t) => {
  const daemon = await start(t, { args: ['--max-viewers', '6'] });
  const c = client(daemon.url),
    session = await c.make({ set: { duration_s: 600 } });
  const good = await c.stream(session, 'bin', { ack: true });
  const silent = await c.stream(session, 'json'),
    slow = await c.stream(session, 'bin'),
    greedy = await c.stream(session, 'json');
  silent.socket.pause(); // takes nothing any more
  const slowTimer = setInterval(() => slow.say({ ack: seqOf(slow.frames.at(-1)) }), 100);
  const flood = setInterval(() => {
    for (let i = 0; i < 200; i++) if (!greedy.closed) greedy.say({ ping: i });
  }, 20);
  await waitFor(() => good.frames.length >= 60 && greedy.closed, '60 frames, and the greedy one to be closed');
  clearInterval(flood);
  assert.equal(greedy.closed.code, 1008);
  assert.ok(slow.frames.length < good.frames.length, 'the slow one skips');
  const from = seqOf(slow.frames[0]);
  const lost = ({ frames }) => {
    const seqs = frames.map(seqOf).filter((/** @type {number} */ seq) => seq >= from);
    return seqs.at(-1) - seqs[0] + 1 - seqs.length;
  };
  assert.ok(lost(good) <= lost(slow), `${lost(good)} frames that the good one lost, ${lost(slow)} of the slow one`);
  const behind = () => seqOf(good.frames.at(-1)) - seqOf(slow.frames.at(-1));
  await waitFor(() => behind() <= 20, 'the slow one to be where the good one is');
  clearInterval(slowTimer);

  const crowd = [await c.stream(session), await c.stream(session), await c.stream(session)];
  await assert.rejects(c.stream(session), (error) => /** @type {any} */ (error).code === 4429 || /** @type {any} */ (error).status === 503);
  for (const stream of [good, slow, ...crowd]) await stream.close();
  silent.socket.terminate();
  c.close();
  await daemon.stop();
});

test('a session without requests expires', async (t) => {
  const daemon = await start(t, { args: ['--session-ttl-s', '1', '--park-after-s', '0.2'] });
  const c = client(daemon.url),
    old = await c.make(),
    watched = await c.make(),
    asked = await c.make();
  const stream = await c.stream(watched, 'bin', { ack: true });
  const timer = setInterval(() => c.get(asked.links.self).catch(() => {}), 200);
  await waitFor(async () => (await gauge(c, 'sessions_expired_total')) === 1, 'the session to expire');
  clearInterval(timer);
  assert.equal((await c.get(old.links.self)).status, 404);
  assert.equal((await c.get(watched.links.self)).status, 200);
  assert.equal((await c.get(asked.links.self)).status, 200);
  await stream.close();
  c.close();
  await daemon.stop();
});

test('twenty persons drive and patch one session at once; its log replays to the same hash', async (t) => {
  const daemon = await start(t, { args: ['--max-commands-per-s', '10000', '--max-messages-per-s', '1000'] });
  const c = client(daemon.url),
    session = await c.make({ set: { 'players.0.control': 'person', 'players.1.control': 'person', duration_s: 600 } });
  const streams = await Promise.all(Array.from({ length: 20 }, (_, i) => c.stream(session, i % 2 ? 'bin' : 'json', { ack: true })));
  let replies = 0;
  await Promise.all(
    streams.map(async (stream, i) => {
      stream.say({ auth: session.player_keys[i % 2], id: 'key' });
      await stream.wait((each) => each.id === 'key');
      for (let n = 0; n < 50; n++) {
        stream.say({ input: { player: i % 2, axes: [((n * 7 + i) % 17) / 8 - 1, 0], buttons: 0 }, id: n });
        if (n % 10 === 0) assert.equal((await c.patch(session, { [`players.${i % 2}.lag_ms`]: n * 5 + i })).status, 200);
        const reply = await stream.wait((each) => each.id === n);
        assert.equal(reply.type, 'reply', JSON.stringify(reply));
        replies++;
      }
    }),
  );
  assert.equal(replies, 1000);
  const { json } = await c.control(session, { op: 'pause' });
  const fork = (await c.call('POST', session.links.fork)).json;
  assert.equal((await c.get(fork.links.state)).json.hash, json.hash);
  await c.control(session, { op: 'seek', tick: 0 });
  assert.equal((await c.control(session, { op: 'seek', tick: json.tick })).json.hash, json.hash);
  for (const stream of streams) await stream.close();
  c.close();
  await daemon.stop();
});

test('a large session is parked by a task, not by the worker that publishes frames', async (t) => {
  const daemon = await start(t, { args: ['--park-after-s', '1.5'] });
  const c = client(daemon.url);
  const large = await c.make({ scenario: 'fluid/cavity', paused: true, set: { 'params.n': 256 } });
  await c.make({ paused: true });
  const state = (await c.get(large.links.state)).text;
  await waitFor(async () => (await gauge(c, 'tasks_running')) === 0, 'the tasks of creation to end');
  const tasks = await gauge(c, 'tasks_total');
  assert.equal(await gauge(c, 'sessions_parked'), 0);
  await waitFor(async () => (await gauge(c, 'sessions_parked')) === 2, 'both to be parked');
  await waitFor(async () => (await gauge(c, 'tasks_total')) === tasks + 1, 'one task more');
  assert.equal((await c.get(large.links.state)).text, state);
  c.close();
});

test('long ticks of a session that is viewed are made by a task, not by the worker that publishes frames', async (t) => {
  const daemon = await start(t, {}),
    c = client(daemon.url),
    boxes = Array.from({ length: 300 }, (_, i) => ({ size: [1, 1], position: [(i % 40) * 0.25, 0.5 + 0.25 * Math.floor(i / 40)] })),
    solver = { method: 'pgs_ngs', iterations: 200, position_iterations: 200, sleep: false, recycle: false },
    scenario = {
      kind: 'rigid',
      duration_s: 3600,
      hz: 4,
      solver,
      bodies: [{ type: 'static', size: [400, 1], position: [0, -0.5] }, ...boxes],
    },
    session = (await c.call('POST', '/api/v1/sessions', { body: { scenario, speed: 10 } })).json,
    viewer = await c.stream(session, 'bin', { ack: true, subscribe: { metrics: 1 } });
  const used_s = (name) => [...threads_s(daemon.pid)].reduce((sum, [of, s]) => sum + (of.startsWith(`${name} `) ? s : 0), 0);
  await waitFor(() => used_s('worker') + used_s('task') > 0.5, 'the session to compute');
  assert.ok(used_s('worker') < 0.25, `worker ${used_s('worker')} s, task ${used_s('task')} s`);
  assert.ok((await c.get(session.links.self)).json.tick > 0);
  await viewer.close();
  c.close();
});

test('sessions that would exceed the memory limit are refused, and harm no others', async (t) => {
  const daemon = await start(t, { args: ['--park-after-s', '0.3', '--max-memory-mib', '48'] });
  const c = client(daemon.url);
  const large = { scenario: 'fluid/cavity', paused: true, set: { 'params.n': 256 } }; // 30 MiB with the states that it keeps
  const first = await c.make(large),
    awake = await c.stream(first, 'bin', { subscribe: {} }); // which is watched is not parked
  assert.ok((await gauge(c, 'sessions_memory_bytes')) > 16 * 2 ** 20);
  const refused = await c.call('POST', '/api/v1/sessions', { body: large });
  assert.equal(refused.status, 503);
  assert.match(refused.json.detail, /^This session needs up to [\d.]+ MiB; awake sessions use [\d.]+ of 48\.0 MiB/);
  assert.equal((await c.get(first.links.self)).status, 200);
  await awake.close();
  await waitFor(async () => (await gauge(c, 'sessions_parked')) === 1, 'the first to be parked');
  const second = await c.make(large);
  await c.stream(second, 'bin', { subscribe: {} });
  assert.equal((await c.get(first.links.state)).status, 503);
  assert.match((await c.get('/metrics')).text, /^laglab_refused_total\{limit="memory"\} 2$/m);
  assert.equal((await c.call('DELETE', second.links.self, { key: second.owner_key })).status, 204);
  assert.equal((await c.get(first.links.state)).status, 200);
  c.close();
});

test('a client with many sessions cannot take the memory from others', async (t) => {
  const daemon = await start(t, { args: ['--park-after-s', '20', '--max-memory-mib', '40', '--max-new-sessions-per-min', '1000000'] });
  const c = client(daemon.url);
  const small = { scenario: 'fluid/cavity', paused: true, set: { 'params.n': 64 } }; // 2 MiB
  let made = 0,
    refused = 0;
  while (made < 60 && refused === 0) {
    const { status } = await c.call('POST', '/api/v1/sessions', { body: small });
    made += Number(status === 201);
    refused += Number(status !== 201);
    await pause(60);
  }
  assert.equal(refused, 0, `${made} made`); // 18 fit at once
  const others = [];
  for (let i = 0; i < 20; i++) {
    others.push((await c.call('POST', '/api/v1/sessions', { body: { scenario: 'race', paused: true } })).status);
    await pause(50);
  }
  assert.deepEqual(others, Array(20).fill(201), `${made} made, ${refused} refused`);
  c.close();
});

test('sessions that were deleted leave nothing behind', async (t) => {
  const daemon = await startDaemon({ args: ['--max-new-sessions-per-min', '1000000'] }),
    c = client(daemon.url);
  t.after(() => daemon.stop());
  const kib = () => Number(/^RssAnon:\s+(\d+)/m.exec(readFileSync(`/proc/${daemon.pid}/status`, 'utf8'))[1]);
  const come_and_go = async (/** @type {number} */ count) => {
    let left = count;
    await Promise.all(
      [1, 2, 3, 4].map(async () => {
        while (left-- > 0) {
          const session = await c.make({ paused: true });
          await c.call('DELETE', session.links.self, { key: session.owner_key });
        }
      }),
    );
    await pause(500);
  };
  await come_and_go(1000); // what is kept once
  const before = kib();
  await come_and_go(2500);
  const each = ((kib() - before) * 1024) / 2500;
  t.diagnostic(`${Math.round(each)} bytes more for each`);
  assert.ok(each < 700, `${Math.round(each)} bytes are kept of each session`);
  c.close();
});
