// Relays: viewers of one session through one and two of them, seen from outside.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { createServer } from 'node:http';
import { connect, createServer as createTcpServer } from 'node:net';
import { after, before, describe, test } from 'node:test';
import { WebSocketServer } from 'ws';
import '../lib/inflate_raw.mjs';
import { BINARY, startDaemon } from '../lib/daemon.mjs';
import { client, openStream, pause, waitFor } from '../lib/client.mjs';
import { Decoder, JUMP } from '../../www/js/stream/decode.js';
import { RECORDS } from '../../www/js/stream/records.js';

const built = !/without libcurl/.test(spawnSync(BINARY, ['relay'], { encoding: 'utf8' }).stderr);
const skip = built ? false : 'this program was built without libcurl';

/** A value of /metrics. @param {string} url @param {string} name */
async function metric(url, name) {
  const text = await (await fetch(new URL('/metrics', url))).text();
  const found = new RegExp(`^laglab_${name} (\\S+)$`, 'm').exec(text);
  return found ? Number(found[1]) : undefined;
}

/** What a viewer sees of each tick that has one frame, as text; of each event; and the last tick. @param {any} stream */
async function seen(stream) {
  const decoder = new Decoder(RECORDS, stream.hello.tick_hz);
  const all = [...stream.frames];
  /** @type {Map<number, string>} */
  const ticks = new Map();
  /** @type {Map<number, string>} */
  const events = new Map();
  let read = 0;
  for (const bytes of all)
    decoder.decode(
      new Uint8Array(bytes).buffer,
      (frame) => {
        const { seq, flags, events: some = [], ...rest } = frame.plain();
        for (const event of some) events.set(event.id, JSON.stringify(event));
        if (read++ > 0) ticks.set(frame.tick, ticks.has(frame.tick) ? '' : JSON.stringify({ ...rest, flags: flags & ~JUMP }));
      },
      (error) => {
        throw error;
      },
    );
  while (read < all.length) await pause(1);
  const last = Math.max(...ticks.keys());
  for (const [tick, text] of ticks) if (text === '' || tick === 0 || tick === last) ticks.delete(tick);
  return { ticks, events, last };
}

/** Ticks that two viewers have seen. @param {Map<number, any>} one @param {Map<number, any>} other */
const common = (one, other) => [...one.keys()].filter((tick) => other.has(tick));

/** What an acknowledging viewer of texts saw while it played: there are several frames of a tick while it is paused. @param {any} stream */
const texts_of = ({ frames }) =>
  new Map(frames.filter(({ tick, flags }) => tick > 0 && flags.includes('playing')).map((frame) => [frame.tick, frame]));

const SCENARIOS = ['race', 'rigid/tumbler', 'fluid/cylinder', 'motion/spring'];

describe('relays', { skip, concurrency: 4 }, () => {
  /** @type {any} */
  let owner, near, far, http;
  before(async () => {
    owner = await startDaemon();
    near = await startDaemon({ of: owner.url, args: ['--linger-s', '0.3', '--max-viewers', '3000'] });
    far = await startDaemon({ of: near.url, args: ['--linger-s', '0.3'] });
    http = client(owner.url);
  });
  after(async () => {
    http?.close();
    for (const one of [far, near, owner]) if (one) assert.equal((await one.stop()).code, 0, one.errors());
  });

  for (const scenario of SCENARIOS)
    test(`frames through one and two equal the owner's: ${scenario}`, async () => {
      const session = await http.make({ scenario, paused: true });
      const streams = await Promise.all(
        [owner, near, far].map(({ url }) => openStream(url, `sessions/${session.id}`, 'bin', { ack: true })),
      );
      const texts = await Promise.all([owner, far].map(({ url }) => openStream(url, `sessions/${session.id}`, 'json')));
      assert.deepEqual(streams[1].hello, streams[0].hello);
      assert.deepEqual(streams[2].hello, streams[0].hello);
      assert.deepEqual(texts[1].hello, texts[0].hello);
      for (const one of [...streams, ...texts]) await one.frame();
      await pause(100); /* a first subscription counts */
      await http.control(session, { op: 'play' });
      /* Each viewer gets the newest frame when it is due. Which ticks it sees depends on the load of the machine, so that a time
       * says nothing of how many all have seen. */
      for (let wanted = 60, enough = false; !enough; wanted += 60) {
        assert.ok(wanted <= 600, `too few ticks that all viewers have seen, of ${wanted - 60} frames for each`);
        await waitFor(
          () => [...streams, ...texts].every(({ frames }) => frames.length >= wanted),
          `${wanted} frames for each viewer`,
          30000,
        );
        const [direct, ...others] = await Promise.all(streams.map(seen));
        const [said, passed] = texts.map(texts_of);
        enough = others.every(({ ticks }) => common(direct.ticks, ticks).length >= 30) && common(said, passed).length >= 20;
      }
      await http.control(session, { op: 'pause' });
      const { tick: end } = (await http.get(`/api/v1/sessions/${session.id}`)).json;
      await waitFor(
        async () => {
          await pause(100);
          const lasts = await Promise.all(streams.map(seen));
          return lasts.every(({ last }) => last === end) && texts.every(({ frames }) => frames.at(-1).tick === end);
        },
        'the last frame, after which it is paused',
        20000,
      );
      const [direct, once, twice] = await Promise.all(streams.map(seen));
      for (const { name, other } of [
        { name: 'one', other: once },
        { name: 'two', other: twice },
      ]) {
        for (const tick of common(direct.ticks, other.ticks))
          assert.ok(other.ticks.get(tick) === direct.ticks.get(tick), `tick ${tick} through ${name}`);
        assert.equal(other.events.size, direct.events.size, `events through ${name}`);
        for (const [id, event] of direct.events) assert.equal(other.events.get(id), event, `event ${id} through ${name}`);
      }
      const plain = (/** @type {any} */ { seq, flags, ...rest }) => rest;
      const [owner_texts, far_texts] = texts.map(texts_of);
      for (const tick of common(owner_texts, far_texts)) {
        const frame = owner_texts.get(tick);
        const other = far_texts.get(tick);
        for (const name of Object.keys(plain(frame)))
          if (name !== 'events' && other[name] !== undefined)
            /* events: since that viewer's frame before */
            assert.ok(JSON.stringify(other[name]) === JSON.stringify(frame[name]), `${name} of tick ${frame.tick}`);
      }
      const [said, passed] = texts.map(
        (one) => new Map(one.frames.flatMap(({ events = [] }) => events.map((event) => [event.id, JSON.stringify(event)]))),
      );
      assert.deepEqual(passed, said);
      await Promise.all([...streams, ...texts].map((one) => one.close()));
    });

  test('who joins gets a frame at once, and costs the owner nothing', async () => {
    const session = await http.make({ set: { duration_s: 3600 } });
    const first = await openStream(near.url, `sessions/${session.id}`, 'bin', { ack: true });
    await first.frame();
    await http.control(session, { op: 'pause' });
    await pause(200);
    const info = async () => (await http.get(`/api/v1/sessions/${session.id}`)).json;
    const begun = performance.now();
    const second = await openStream(near.url, `sessions/${session.id}`, 'json');
    await second.frame((frame) => frame.events?.length > 0);
    assert.ok(performance.now() - begun < 1000);
    assert.ok(second.frames[0].flags.includes('jump') && second.frames.some(({ views }) => views?.length === 3));
    assert.equal((await info()).viewers, 1);
    await http.control(session, { op: 'play' });
    const opened = performance.now();
    const many = await Promise.all(
      Array.from({ length: 200 }, () => openStream(near.url, `sessions/${session.id}`, 'bin', { ack: true, subscribe: { scene: 20 } })),
    );
    const before = many.map(({ frames }) => frames.length);
    await waitFor(() => many.every(({ frames }, i) => frames.length >= before[i] + 15), '15 frames for each viewer', 30000);
    const most = Math.max(...many.map(({ frames }) => frames.length));
    const seconds = (performance.now() - opened) / 1000;
    assert.ok(most <= 20 * seconds + 3, `${most} frames in ${seconds} s, of 20 a second`); /* and of a start up to three */
    assert.equal((await info()).viewers, 1);
    assert.equal((await metric(near.url, 'viewers')) >= 202, true);
    await Promise.all([first, second, ...many].map((one) => one.close()));
    await waitFor(async () => (await info()).viewers === 0, 'the end of the subscription');
  });

  test('a slow viewer delays no other', async () => {
    const session = await http.make({ scenario: 'rigid/tumbler', set: { duration_s: 3600 } });
    /* The same way through relays at the same time, without a slow viewer: the load of the machine delays both. */
    const without_slow = await startDaemon({ of: near.url });
    /* One that stops to acknowledge is left out of the next frames; to one that never does, frames go until its socket is full. */
    const slow = await Promise.all([true, false].map((ack) => openStream(far.url, `sessions/${session.id}`, 'json', { ack })));
    const [fast, other] = await Promise.all(
      [far, without_slow].map(({ url }) => openStream(url, `sessions/${session.id}`, 'bin', { ack: true })),
    );
    await Promise.all([fast.frame(), other.frame()]);
    for (const { socket } of slow) socket._socket.pause();
    const full = other.frames.length + 150; /* of 60 kB each: more than the buffers of two sockets */
    await waitFor(() => other.frames.length >= full, '150 frames without a slow viewer', 30000);
    const from = [fast.frames.length, other.frames.length];
    await waitFor(() => other.frames.length >= from[1] + 60, '60 frames without a slow viewer', 30000);
    const [with_slow, without] = [fast.frames.length - from[0], other.frames.length - from[1]];
    assert.ok(with_slow > 0.7 * without, `${without} frames without a slow viewer, ${with_slow} with one`);
    for (const { socket } of slow) socket.terminate();
    await Promise.all([fast.close(), other.close()]);
    assert.equal((await without_slow.stop()).code, 0, without_slow.errors());
  });

  test('keys and inputs reach the owner, and so do requests', async () => {
    const c = client(far.url);
    const session = await c.make({ set: { duration_s: 3600, 'players.1.control': 'person' } });
    const stream = await openStream(far.url, `sessions/${session.id}`);
    stream.say({ input: { player: 1, axes: [1, 0] }, id: 'a' });
    assert.equal((await stream.wait((m) => m.id === 'a')).problem.status, 403);
    stream.say({ auth: session.owner_key, id: 'b' });
    assert.equal((await stream.wait((m) => m.id === 'b')).role, 'owner');
    stream.say({ input: { player: 1, axes: [1, 0] }, id: 'c' });
    assert.equal((await stream.wait((m) => m.id === 'c')).ok, true);
    stream.say({ subscribe: { scene: 7 }, id: 'd' });
    assert.deepEqual((await stream.wait((m) => m.id === 'd')).subscribed, { scene: 6 });
    stream.say({ ping: 3, id: 'e' });
    assert.ok(Math.abs((await stream.wait((m) => m.id === 'e')).wall_ns / 1e6 - Number(process.hrtime.bigint()) / 1e6) < 2000);
    stream.say('nonsense');
    await stream.wait((m) => m.type === 'error' && m.problem.status === 400);
    const before = (await c.get(`/api/v1/sessions/${session.id}`)).json;
    const patched = await c.patch(session, { 'players.0.lag_ms': 77 });
    assert.equal(patched.status, 200, patched.text);
    const now = (await c.get(`/api/v1/sessions/${session.id}`)).json;
    assert.notDeepEqual(now, before);
    assert.equal(now.params.players[0].lag_ms, 77);
    /* who comes now is greeted with the present parameters */
    await waitFor(async () => {
      const late = await openStream(far.url, `sessions/${session.id}`);
      await late.close();
      return late.hello.params.players[0].lag_ms === 77;
    }, 'a new hello');
    const tagged = await c.get('/api/v1/schema');
    assert.equal(tagged.status, 200);
    if (tagged.headers.etag)
      assert.equal((await c.get('/api/v1/schema', { headers: { 'if-none-match': tagged.headers.etag } })).status, 304);
    assert.equal((await c.get('/api/v1/nothing')).status, 404);
    assert.equal((await c.get('/')).status, 200);
    assert.equal((await c.get('/readyz')).json.status, 'ready');
    assert.equal((await c.control({ ...session, owner_key: 'wrong' }, { op: 'pause' })).status, 403);
    const gone = await c.call('DELETE', `/api/v1/sessions/${session.id}`, { key: session.owner_key });
    assert.equal(gone.status, 204, gone.text);
    await waitFor(() => stream.closed, 'the end');
    assert.equal(stream.closed.code, 4404);
    await assert.rejects(openStream(far.url, `sessions/${session.id}`), (/** @type {any} */ error) => error.code === 4404);
    c.close();
  });

  test('classes go through a connection for each member', async () => {
    const c = client(near.url);
    const made = await c.call('POST', '/api/v1/classes', { body: {} });
    assert.equal(made.status, 201, made.text);
    const stream = await openStream(near.url, `classes/${made.json.id}`);
    assert.equal(stream.hello.class, made.json.id);
    stream.say({ auth: made.json.teacher_key });
    assert.equal((await stream.wait((m) => m.type === 'reply')).role, 'teacher');
    const ended = await c.call('DELETE', `/api/v1/classes/${made.json.id}`, { key: made.json.teacher_key });
    assert.equal(ended.status, 204, ended.text);
    await waitFor(() => stream.closed, 'the end of the class');
    c.close();
  });

  test('the owner is killed and starts again: viewers keep their connection', async () => {
    const mortal = await startDaemon();
    const c = client(mortal.url);
    const relay = await startDaemon({ of: mortal.url });
    const session = await c.make({ set: { duration_s: 3600 } });
    const stream = await openStream(relay.url, `sessions/${session.id}`, 'json', { subscribe: { scene: 60, session: 60 } });
    stream.say({ auth: session.owner_key, id: 1 });
    await stream.wait((m) => m.id === 1);
    const before = await stream.frame((frame) => frame.tick > 30);
    await mortal.kill();
    await pause(300);
    /* Who comes now sees the last frame; requests are answered with the owner's address. */
    const late = await openStream(relay.url, `sessions/${session.id}`, 'json', { subscribe: { scene: 60 } });
    const still = await late.frame();
    await stream.wait((m) => m.type === 'owner' && m.connected === false);
    await late.wait((m) => m.type === 'owner' && m.connected === false);
    assert.ok(still.tick >= before.tick && still.views.length === 3);
    const refused = await fetch(new URL(`/api/v1/sessions/${session.id}/state`, relay.url));
    assert.equal(refused.status, 503);
    assert.match((await refused.json()).detail, new RegExp(`127\\.0\\.0\\.1:${mortal.port}`));
    const count = stream.frames.length;
    const again = await startDaemon({ listen: `127.0.0.1:${mortal.port}`, data: mortal.data });
    await waitFor(() => stream.frames.length > count + 10 && late.frames.length > 10, 'frames of the owner that has returned', 8000);
    assert.equal(stream.closed, undefined);
    await stream.wait((m) => m.type === 'owner' && m.connected === true);
    const seqs = stream.frames.map(({ seq }) => seq);
    assert.ok(
      seqs.every((seq, i) => i === 0 || seq > seqs[i - 1]),
      'numbers rise',
    );
    stream.say({ input: { player: 0, axes: [0, 0] }, id: 2 }); /* its key was sent again */
    const answer = await stream.wait((m) => m.id === 2);
    assert.ok(answer.ok || !/auth/.test(answer.problem.detail), JSON.stringify(answer));
    c.close();
    await stream.close();
    await late.close();
    assert.equal((await relay.stop()).code, 0, relay.errors());
    await again.stop();
    await mortal.stop();
  });

  test('an owner that sends anything', async () => {
    /* A real hello, then bytes that are none. */
    const session = await http.make({ paused: true });
    const real = await openStream(owner.url, `sessions/${session.id}`, 'bin');
    const frame = Buffer.from(await real.frame());
    await real.close();
    let kind = 0;
    const server = createServer();
    const sockets = new WebSocketServer({ server, handleProtocols: (all) => [...all][0] });
    sockets.on('connection', (socket) => {
      const hostile = [
        () => socket.send(Buffer.from([1, 2])),
        () => socket.send(frame.subarray(0, frame.length - 3)),
        () => socket.send(Buffer.concat([frame, Buffer.from([1, 2, 3])])),
        () => socket.send('{"type":"hello"}', () => socket.terminate()),
        () => socket.send('not JSON', () => socket.close()),
        () => socket.close(1013, 'later'),
        () => socket.terminate(),
        () => /** @type {any} */ (socket)._socket.write(Buffer.from([0xff, 0xff, 0xff])),
        () => socket.send(frame.map((byte, i) => (i > 4 && i % 7 === 0 ? byte ^ 0x55 : byte))),
      ];
      socket.on('error', () => {});
      socket.send(JSON.stringify(real.hello));
      hostile[kind++ % hostile.length]();
    });
    await new Promise((resolve) => server.listen(0, '127.0.0.1', () => resolve(undefined)));
    const { port } = /** @type {import('node:net').AddressInfo} */ (server.address());
    const relay = await startDaemon({ of: `http://127.0.0.1:${port}` });
    const streams = await Promise.all(['a', 'b', 'c'].map((id) => openStream(relay.url, `sessions/${id}`, 'json')));
    await waitFor(() => kind > 9, 'connections', 8000);
    assert.ok(Number(await metric(relay.url, 'relay_lost_total')) >= 6);
    assert.ok(Number(await metric(relay.url, 'relay_faults_total')) >= 2);
    assert.equal((await fetch(new URL('/healthz', relay.url))).status, 200);
    for (const stream of streams) {
      assert.equal(stream.closed, undefined);
      await stream.close();
    }
    assert.equal((await relay.stop()).code, 0, relay.errors());
    sockets.close();
    server.closeAllConnections();
    server.close();
  });

  test('an owner whose few bytes become many is cut off', async (t) => {
    const session = await http.make({ paused: true });
    const real = await openStream(owner.url, `sessions/${session.id}`, 'bin');
    await real.close();
    /* 32 bytes: a frame with 16 MiB of entities, all of them zeros. */
    const entities = RECORDS.find(({ name }) => name === 'entities'),
      rows = Math.floor((16 << 20) / (8 * entities.fields.length)),
      varint = (/** @type {number} */ n) => (n < 128 ? [n] : [128 + (n % 128), ...varint(Math.floor(n / 128))]),
      body = [...varint(rows), 0];
    let sent = 0,
      cuts = 0;
    const server = createServer();
    const sockets = new WebSocketServer({ server, handleProtocols: (all) => [...all][0] });
    sockets.on('connection', (socket) => {
      const timer = setInterval(() => {
        socket.send(Buffer.from([1, 0, ...varint(++sent), 0, entities.id, ...varint(4 * body.length + 2), ...body]));
      }, 5);
      socket.on('error', () => {});
      socket.on('close', () => {
        clearInterval(timer);
        cuts++;
      });
      socket.send(JSON.stringify(real.hello));
    });
    await new Promise((resolve) => server.listen(0, '127.0.0.1', () => resolve(undefined)));
    t.after(() => {
      sockets.close();
      server.closeAllConnections();
      server.close();
    });
    const { port } = /** @type {import('node:net').AddressInfo} */ (server.address());
    const relay = await startDaemon({ of: `http://127.0.0.1:${port}` });
    t.after(async () => assert.equal((await relay.stop()).code, 0, relay.errors()));
    const viewer = await openStream(relay.url, `sessions/${session.id}`, 'bin', { ack: true });
    await waitFor(() => cuts > 1, 'the end of two connections', 15000);
    assert.match(relay.errors(), /the owner's messages, when unpacked, have more than 64 MiB a second/);
    assert.ok(Number(await metric(relay.url, 'relay_faults_total')) >= 2);
    assert.equal(viewer.closed, undefined);
    await viewer.close();
  });

  test('answers that are not kept are asked for at the same time', async (t) => {
    let asked = 0,
      most = 0;
    const large = 'x'.repeat(1 << 20);
    const server = createServer((request, response) => {
      asked++;
      most = Math.max(most, asked);
      setTimeout(() => {
        asked--;
        response.end(request.url === '/api/v1/schema' ? large + large : '{}');
      }, 300);
    });
    await new Promise((resolve) => server.listen(0, '127.0.0.1', () => resolve(undefined)));
    t.after(() => {
      server.closeAllConnections();
      server.close();
    });
    const of = `http://127.0.0.1:${/** @type {import('node:net').AddressInfo} */ (server.address()).port}`;
    for (const [path, args] of /** @type {[string, string[]][]} */ ([
      ['metrics', ['--cache-s', '0']],
      ['schema', []] /* too large to be kept: the others wait for the first alone */,
    ])) {
      const relay = await startDaemon({ of, args });
      most = 0;
      const all = await Promise.all(Array.from({ length: 4 }, () => fetch(new URL(`/api/v1/${path}`, relay.url))));
      assert.deepEqual(
        all.map(({ status }) => status),
        [200, 200, 200, 200],
      );
      assert.ok(most >= 2, `${path}: ${most} at a time`);
      assert.equal((await relay.stop()).code, 0, relay.errors());
    }
  });

  /** An owner behind a port that can stop passing bytes on. @param {any} t */
  const throttled = async (t) => {
    /** What becomes of new connections: all passes, only the head of the answer, or nothing more is read once it has passed. While it is
     * dead, nothing passes on any of them, and none is closed. */
    const way = { of: /** @type {'all' | 'head' | 'unread'} */ ('all'), dead: false };
    const ends = /** @type {import('node:net').Socket[]} */ ([]);
    const server = createTcpServer((near) => {
      const { of } = way,
        end = connect(Number(new URL(owner.url).port), '127.0.0.1');
      let headed = false;
      ends.push(near, end);
      for (const one of [near, end]) one.on('error', () => {}).on('close', () => [near, end].forEach((each) => each.destroy()));
      near.on('data', (bytes) => way.dead || end.write(bytes));
      end.on('data', (bytes) => {
        if (way.dead) return;
        const head = bytes.indexOf('\r\n\r\n');
        if (of === 'all' || !headed) near.write(of === 'head' ? bytes.subarray(0, head + 4) : bytes);
        headed = true;
        if (of === 'unread') near.pause();
      });
    });
    await new Promise((resolve) => server.listen(0, '127.0.0.1', () => resolve(undefined)));
    t.after(() => {
      for (const one of ends) one.destroy();
      server.close();
    });
    const { port } = /** @type {import('node:net').AddressInfo} */ (server.address());
    const relay = await startDaemon({ of: `http://127.0.0.1:${port}`, args: ['--max-messages-per-s', '100000'] });
    t.after(async () => assert.equal((await relay.stop()).code, 0, relay.errors()));
    return { relay, way };
  };

  test('who joins gets a hello though the connection for a newer one is mute', async (t) => {
    const { relay, way } = await throttled(t);
    const session = await http.make({ speed: 1 });
    const first = await openStream(relay.url, `sessions/${session.id}`, 'bin', { ack: true });
    await first.frame();
    way.of = 'head';
    assert.equal((await http.patch(session, { 'players.0.lag_ms': 77 })).status, 200);
    await pause(1000);
    const second = await openStream(relay.url, `sessions/${session.id}`, 'bin', { ack: true });
    await second.frame();
    await Promise.all([first.close(), second.close()]);
  });

  test('a connection that has died without a word is noticed, one that is only quiet is kept', async (t) => {
    const { relay, way } = await throttled(t);
    const made = await Promise.all(['dead', 'quiet'].map(() => http.call('POST', '/api/v1/classes', { body: {} })));
    const session = await http.make({ paused: true });
    const dead = await openStream(relay.url, `classes/${made[0].json.id}`),
      quiet = await openStream(near.url, `classes/${made[1].json.id}`),
      watched = await openStream(relay.url, `sessions/${session.id}`, 'json');
    await watched.frame();
    way.dead = true;
    const begun = performance.now();
    await waitFor(() => dead.closed, 'the end of the stream', 15000);
    assert.deepEqual([dead.closed.code, dead.closed.reason], [1013, 'the owner is silent']);
    await watched.wait((m) => m.type === 'owner' && m.connected === false);
    assert.ok(performance.now() - begun < 12000, 'before the owner, which waits longer, finds the relay silent');
    assert.equal(quiet.closed, undefined);
    await Promise.all([quiet.close(), watched.close()]);
  });

  test('a relay that was stopped for a while keeps its connections', async (t) => {
    const relay = await startDaemon({ of: owner.url });
    t.after(() => relay.stop());
    const made = await http.call('POST', '/api/v1/classes', { body: {} });
    const quiet = await openStream(relay.url, `classes/${made.json.id}`);
    process.kill(relay.pid, 'SIGSTOP');
    await pause(7500); /* longer than a silent owner is waited for */
    process.kill(relay.pid, 'SIGCONT');
    quiet.say({ auth: made.json.teacher_key });
    assert.equal((await quiet.wait((m) => m.type === 'reply')).role, 'teacher');
    await pause(700); /* it has looked for silent ones */
    assert.equal(quiet.closed, undefined);
    await quiet.close();
  });

  test('messages for an owner that does not read end, and do not fill the memory', async (t) => {
    const { relay, way } = await throttled(t);
    const session = await http.make({ paused: true });
    const viewer = await openStream(relay.url, `sessions/${session.id}`, 'bin', { ack: true });
    await viewer.frame();
    way.of = 'unread';
    const text = JSON.stringify({ none: 'x'.repeat(60000) });
    const refused = () => viewer.messages.find((message) => /does not read/.test(JSON.stringify(message)));
    let sent = 0;
    for (; sent < 600 && !refused() && !viewer.closed; sent++) {
      viewer.say(text);
      if (sent % 4 === 3) await pause(25);
    }
    await waitFor(refused, `an error after ${sent} messages: ${JSON.stringify(viewer.closed)}`);
    await viewer.close();
  });

  test('an address that is none is refused', () => {
    for (const of of ['', 'ftp://host', 'http://', 'http://a b', 'http://host/?x=1']) {
      const { status, stderr } = spawnSync(BINARY, ['relay', '--of', of, '--listen', '127.0.0.1:0'], { encoding: 'utf8' });
      assert.equal(status, 2, of);
      assert.match(stderr, /of: must be like/);
    }
  });

  test('a relay of itself ends', async () => {
    const { port } = await new Promise((resolve) => {
      const probe = createServer().listen(0, '127.0.0.1', () => {
        const place = /** @type {import('node:net').AddressInfo} */ (probe.address());
        probe.close(() => resolve(place));
      });
    });
    const loop = await startDaemon({ of: `http://127.0.0.1:${port}`, listen: `127.0.0.1:${port}` });
    const answer = await fetch(new URL('/api/v1/sessions/a/state', loop.url));
    assert.equal(answer.status, 508);
    const untrue = await fetch(new URL('/api/v1/sessions/a/state', loop.url), { headers: { 'x-laglab-hops': '-1000000' } });
    assert.equal(untrue.status, 508);
    assert.equal((await loop.stop()).code, 0, loop.errors());
  });
});
