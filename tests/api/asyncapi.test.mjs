// Holds the stream of the running daemon against api/asyncapi.yaml: texts by their schemas, binary frames read by nothing but what it says
// of them and compared with the text of the same number. Rates are measured by the numbers of frames and the daemon's clock, not by this
// process's, so that a busy machine changes none of them; what needs time waits until it is there.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import Ajv from 'ajv/dist/2020.js';
import YAML from 'yaml';
import { client, pause, seqOf, waitFor } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';
import { reader } from '../lib/sections.mjs';

let daemon, c, api, ajv;

before(async () => {
  // What the tests themselves send late is not closed.
  daemon = await startDaemon({ args: ['--ack-timeout-s', '600', '--head-timeout-s', '60', '--max-new-sessions-per-min', '100000'] });
  c = client(daemon.url);
  api = YAML.parse((await c.get('/api/v1/asyncapi.yaml')).text);
  ajv = new Ajv({ strict: false, allErrors: true });
  ajv.addSchema(api, 'asyncapi');
});
after(async () => {
  c.close();
  await daemon.stop();
});

function check(name, message) {
  const validate = ajv.getSchema(`asyncapi#/components/messages/${name}/payload`);
  assert.ok(validate(message), `${name}: ${ajv.errorsText(validate.errors)} in ${JSON.stringify(message).slice(0, 600)}`);
}

/** What was read of each viewer. @type {WeakMap<any, {decoder: any, frames: any[]}>} */
const read = new WeakMap();

/** All frames that a viewer got, as texts. */
function framesOf(stream) {
  if (!read.has(stream)) read.set(stream, { decoder: reader(api), frames: [] });
  const { decoder, frames } = read.get(stream);
  for (const frame of stream.frames.slice(frames.length)) frames.push(Buffer.isBuffer(frame) ? decoder.read(frame) : frame);
  return [...frames];
}

/** Everything that a viewer got. */
function checkAll(stream) {
  for (const message of stream.messages) check(message.type, message);
  for (const frame of stream.frames) if (!Buffer.isBuffer(frame)) check('frame', frame);
  framesOf(stream);
}

let barriers = 0;
/** Waits until the daemon has taken all that the viewer said, and all that it sent before is here. Gives the count of its frames then. */
function settled(stream) {
  const id = `barrier ${++barriers}`;
  const count = new Promise((resolve) => {
    stream.socket.on('message', function listen(data, binary) {
      if (binary || !data.includes(id)) return;
      stream.socket.off('message', listen);
      resolve(stream.frames.length);
    });
  });
  stream.say({ ping: 1, id });
  return count;
}

/** Repeats `check` until it passes, or fails as it did last. */
async function eventually(check, ms = 20000) {
  for (const end = performance.now() + ms; ; await pause(200)) {
    try {
      return check();
    } catch (error) {
      if (performance.now() > end) throw error;
    }
  }
}

/**
 * Of every n-th frame that is there a record comes with that one, or with the next that the viewer gets; and with no other.
 * @param {any[]} frames texts @param {string} name of the record @param {number} n
 */
function checkRate(frames, name, n) {
  for (let i = 1; i < frames.length; i++) {
    const { seq } = frames[i],
      due = Math.floor(seq / n) > Math.floor(frames[i - 1].seq / n),
      what = `${name} at ${60 / n} Hz: frame ${seq} after ${frames[i - 1].seq}`;
    if (seq % n === 0) assert.ok(frames[i][name], `${what} is without it`);
    if (!due) assert.ok(!frames[i][name], `${what} has it`);
  }
}

const channelsOf = (stream) => stream.hello.channels.map(({ name }) => name);

// ---- the tables ----

test('the schemas are those of the tables that the daemon reads and writes by', async () => {
  const { records, channels, hash } = (await c.get('/api/v1/stream/schema.json')).json,
    { tables } = reader(api);
  assert.equal(records.length, tables.size);
  assert.ok(records.length > 20, `${records.length} records`);
  for (const record of records) {
    const table = tables.get(record.id);
    assert.deepEqual([table.name, table.form], [record.name, record.form]);
    assert.deepEqual(
      table.fields.map(([name, p]) => [name, p['x-coding'], p['x-unit'], p.description]),
      record.fields.map((f) => [f.name, f.coding === 'int' ? 'int' : `${f.coding} ${f.bits}`, f.unit, f.help]),
    );
  }
  assert.deepEqual(
    api.components.schemas.Channel.enum,
    channels.map(({ name }) => name),
  );
  const session = await c.make({ paused: true }),
    stream = await c.stream(session);
  assert.equal(stream.hello.schema, hash);
  await stream.close();
});

const STEPS = [1, 1, 4, 9, 1]; // ticks

/** Texts and binary frames of one scenario, compared. Returns the names of the records that had rows. */
async function compareEncodings(id) {
  const session = await c.make({ scenario: id, paused: true });
  const json = await c.stream(session, 'json'),
    binary = await c.stream(session, 'bin');
  await waitFor(() => json.frames.length > 0 && binary.frames.length > 0, `the first frames of ${id}`);
  const changes = [{ op: 'seek', time_s: Math.min(1, json.hello.duration_s / 2) }, ...STEPS.map((ticks) => ({ op: 'step', ticks }))];
  for (const change of changes) {
    const { tick } = (await c.control(session, change)).json; // a frame follows
    await waitFor(() => json.frames.at(-1).tick === tick && seqOf(binary.frames.at(-1)) >= json.frames.at(-1).seq, `tick ${tick} of ${id}`);
  }
  checkAll(json);
  for (const message of binary.messages) check(message.type, message);
  const texts = new Map(json.frames.map((frame) => [frame.seq, frame])),
    seen = new Set(),
    events = new Map();
  let compared = 0;
  for (const frame of framesOf(binary)) {
    for (const event of frame.events ?? []) events.set(event.id, event);
    const text = texts.get(frame.seq);
    if (!text) continue;
    assert.equal(frame.tick, text.tick);
    assert.deepEqual(
      frame.flags.filter((flag) => flag !== 'jump'),
      text.flags.filter((flag) => flag !== 'jump'),
    );
    for (const [name, rows] of Object.entries(text)) {
      if (!Array.isArray(rows) || name === 'flags') continue;
      if (rows.length > 0) seen.add(name);
      if (name !== 'events') assert.deepEqual(frame[name], rows, `${id}: ${name} of frame ${frame.seq}`);
    }
    compared++;
  }
  for (const { events: told } of json.frames)
    for (const event of told ?? []) if (events.has(event.id)) assert.deepEqual(events.get(event.id), event);
  assert.ok(compared >= changes.length, `${compared} frames compared of ${id}`);
  const { format: _, ...hello } = json.hello,
    { format: __, ...other } = binary.hello;
  assert.deepEqual(hello, other);
  await json.close();
  await binary.close();
  await c.call('DELETE', session.links.self ?? `/api/v1/sessions/${session.id}`, { key: session.owner_key });
  return seen;
}

test('binary frames say what texts say, in every library scenario, and every record comes in some', async () => {
  const left = (await c.get('/api/v1/scenarios')).json.scenarios.map(({ id }) => id),
    seen = new Set();
  assert.ok(left.length > 100, `${left.length} scenarios`);
  // Most of the time is waiting for frames: three at a time.
  await Promise.all(
    Array.from({ length: 3 }, async () => {
      for (let id = left.pop(); id; id = left.pop()) for (const name of await compareEncodings(id)) seen.add(name);
    }),
  );
  assert.deepEqual(
    [...reader(api).tables.values()].map(({ name }) => name).filter((name) => !seen.has(name)),
    [],
    'records without a row',
  );
});

test('traffic is what the metrics count', async () => {
  const session = await c.make({ scenario: 'link_coasts', paused: true });
  await c.control(session, { op: 'seek', time_s: 20 });
  const stream = await c.stream(session, 'bin');
  await stream.frame();
  const [{ traffic, links }] = framesOf(stream);
  const { players } = (await c.get(`/api/v1/sessions/${session.id}/metrics`)).json.metrics;
  assert.deepEqual([...new Set(traffic.map(({ message }) => message))].sort(), ['input', 'ping', 'pong', 'state']);
  for (const { player, message, messages, packets, bytes, wire_bytes } of traffic) {
    const rates = players[player].bandwidth[message],
      s = messages / rates.messages_per_s;
    assert.ok(Math.abs(s - 19.5) < 0.1, `${s} s since the warm-up`);
    for (const [count, rate] of [
      [packets, rates.packets_per_s],
      [bytes, rates.payload_bytes_per_s],
      [wire_bytes, rates.wire_bytes_per_s],
    ])
      assert.ok(Math.abs(count - rate * s) < 1e-6 * count, `${message}: ${count}, ${rate}`);
  }
  for (const link of links) {
    const { link_up: up, link_down: down } = players[link.player];
    assert.deepEqual(
      [link.up_sent, link.up_lost, link.down_sent, link.down_lost],
      [up.messages, up.messages_lost, down.messages, down.messages_lost],
    );
  }
  const inFibre_ms = 2 * (4130 / 299792.458) * 1.5 * 1000; // light, there and back
  assert.ok(Math.abs(links[0].ping_ms - inFibre_ms) < 0.5, `${links[0].ping_ms} ms`);
  assert.ok(links[1].down_lost > 0 && links[0].down_lost === 0);
  await stream.close();
});

test('the input history', async () => {
  const session = await c.make({ scenario: 'contact', paused: true });
  await c.control(session, { op: 'seek', time_s: 20 });
  const stream = await c.stream(session, 'bin');
  await stream.frame();
  const [{ input_history: history }] = framesOf(stream);
  assert.equal(history.length, 64, 'of each of two players the last 32');
  for (const r of history) {
    assert.equal(r.correction_m === null, r.predicted_x === null || r.server_x === null);
    if (r.correction_m !== null) assert.ok(Math.abs(r.server_x - r.predicted_x - r.correction_m) <= 1.5 / 2 ** 13, JSON.stringify(r));
  }
  assert.ok(history.some((r) => r.state === 'open') && history.some((r) => r.correction_m !== null && r.state === 'acknowledged'));
  await stream.close();
});

test('the buffers of views', async () => {
  const session = await c.make({ scenario: 'interpolation_jitter', paused: true });
  await c.control(session, { op: 'seek', time_s: 9 });
  const stream = await c.stream(session);
  const { buffers, buffered } = await stream.frame((frame) => frame.buffered);
  assert.ok(buffers.length === 2 && buffered.length >= 4, `${buffered.length} states`);
  const ahead = buffered.filter((b) => b.player === 0),
    { drawn_s } = buffers[0];
  assert.ok(ahead[0].time_s <= drawn_s && ahead[1].time_s > drawn_s, 'from the state that is drawn on');
  assert.ok(
    ahead.every((b, i) => i === 0 || b.tick > ahead[i - 1].tick),
    'in order',
  );
  assert.ok(
    buffered.every((b) => b.place === 'snapshot'),
    'no de-jitter buffer',
  );
  assert.ok(buffers[0].behind_ms > 180 && buffers[0].delay_ms === 210, JSON.stringify(buffers));
  await stream.close();
});

test('a de-jitter buffer reports its content', async () => {
  const session = await c.make({ scenario: 'dejitter', paused: true });
  await c.control(session, { op: 'seek', time_s: 9 });
  const stream = await c.stream(session);
  const { buffers, buffered, time_s } = await stream.frame((frame) => frame.buffered);
  const held = (player) => buffered.filter((b) => b.place === 'dejitter' && b.player === player);
  assert.deepEqual(buffers.map((b) => b.dejitter_ms).slice(0, 3), [0, 100, 100]);
  assert.equal(held(0).length, 0);
  for (const b of held(1)) assert.ok(Math.abs(b.due_s - b.arrived_s - 0.1) < 2e-6, JSON.stringify(b));
  for (const b of [...held(1), ...held(2)]) {
    assert.ok(b.time_s < b.arrived_s && b.arrived_s <= time_s + 1e-6 && b.due_s > time_s, JSON.stringify(b));
  }
  assert.ok(held(1).length >= 1 && held(2).length >= 1, JSON.stringify(buffered));
  await stream.close();
});

// ---- which frames come, and when ----

const DENSE = 25; // frames: how evenly 60 come in a second is for bench/ to say, on a quiet machine

/** The most frames in any second of the daemon's clock. */
function mostInASecond(frames) {
  const at = frames.map((frame) => frame.clock[0].wall_us);
  return Math.max(...at.map((from, i) => at.slice(i).filter((us) => us < from + 1e6).length));
}

test('the beginning: hello, all whole, then 60 frames a second in order', async () => {
  const session = await c.make({ set: { duration_s: 600 } });
  for (const format of ['json', 'bin']) {
    const stream = await c.stream(session, format, { ack: true });
    // On a machine that is busy just now some later second has them.
    await eventually(() => {
      const most = mostInASecond(framesOf(stream));
      assert.ok(most >= DENSE, `${most} frames in a second`);
    }, 30000);
    const frames = framesOf(stream),
      seqs = frames.map(({ seq }) => seq);
    assert.ok(mostInASecond(frames) <= 62, `${mostInASecond(frames)} frames in a second`);
    assert.ok(
      seqs.every((seq, i) => i === 0 || seq > seqs[i - 1]),
      'in order',
    );
    assert.ok(frames.every(({ flags }) => flags.includes('playing')));
    assert.deepEqual(
      frames.map(({ flags }, i) => (flags.includes('jump') ? i : -1)).filter((i) => i >= 0),
      [0],
      'a jump at the beginning alone',
    );
    checkAll(stream);
    await stream.close();
  }
});

test('rates are those that were asked for, and channels those that were subscribed to', async () => {
  const session = await c.make({ scenario: 'eight', set: { duration_s: 600 } });
  const stream = await c.stream(session, 'json', { subscribe: {} }),
    other = await c.stream(session, 'json', { subscribe: { session: 60 } });
  await waitFor(() => other.frames.length >= 18, 'frames of another viewer');
  assert.equal(await settled(stream), 0, 'no subscription, no frame');
  stream.say({ subscribe: { scene: 20, gauges: 7, session: 60 }, id: 5 });
  const reply = await stream.wait((each) => each.id === 5, 'the reply');
  assert.deepEqual(reply.subscribed, { session: 60, scene: 20, gauges: 6 });
  const begun = () => stream.frames.findIndex((frame) => frame.views && frame.buffers && frame.session);
  await waitFor(() => begun() >= 0 && stream.frames.length >= begun() + 60, '60 frames', 60000);
  const frames = stream.frames.slice(begun());
  for (const frame of frames) assert.ok(!frame.input_history && !frame.events, `frame ${frame.seq}: ${Object.keys(frame)}`);
  checkRate(frames, 'session', 1);
  checkRate(frames, 'views', 3);
  checkRate(frames, 'buffers', 10);
  stream.say({ subscribe: {}, id: 6 });
  await stream.wait((each) => each.id === 6, 'the reply');
  const count = await settled(stream),
    of_other = other.frames.length;
  await waitFor(() => other.frames.length >= of_other + 12, 'frames of another viewer');
  assert.equal(await settled(stream), count);
  checkAll(stream);
  await stream.close();
  await other.close();
});

test('who does not subscribe gets what is drawn, after a second', async () => {
  const session = await c.make({ set: { duration_s: 600 } });
  const begun = performance.now();
  const stream = await c.stream(session, 'json', { subscribe: null });
  const frame = await stream.frame();
  assert.ok(performance.now() - begun > 900);
  assert.deepEqual(
    [Boolean(frame.views), Boolean(frame.session), Boolean(frame.events), Boolean(frame.buffers)],
    [true, true, false, false],
  );
  await waitFor(() => stream.frames.length >= 12, '12 frames', 60000);
  checkRate(stream.frames, 'views', 6);
  checkRate(stream.frames, 'session', 6);
  for (const each of stream.frames) assert.ok(each.views, 'no other frames');
  checkAll(stream);
  await stream.close();
});

test('time jumps: the flag, a new generation; the end and the replay', async () => {
  const session = await c.make({ set: { duration_s: 1 } });
  const stream = await c.stream(session);
  const over = await stream.frame((frame) => frame.flags.includes('ended') && frame.session);
  assert.equal(over.tick, 60);
  await c.control(session, { op: 'seek', tick: 10 });
  const back = await stream.frame((frame) => frame.session?.[0].generation > over.session[0].generation);
  assert.equal(back.tick, 10);
  assert.deepEqual(back.flags, ['behind', 'jump']);
  assert.equal(back.session[0].behind_ticks, 50);
  await c.control(session, { op: 'play' });
  await stream.frame((frame) => frame.flags.includes('ended') && frame.seq > back.seq);
  const count = stream.frames.length;
  await pause(200);
  assert.equal(stream.frames.length, count, 'nothing new, no frame');
  await c.patch(session, { 'players.0.lag_ms': 10 });
  const changed = await stream.frame((frame) => frame.seq > stream.frames[count - 1].seq);
  assert.ok(changed.session[0].params_version > back.session[0].params_version);
  checkAll(stream);
  await stream.close();
});

test('a viewer that acknowledges has at most four frames in flight, then the newest, as a delta to what it has', async () => {
  const session = await c.make({ set: { duration_s: 600 } });
  const other = await c.stream(session, 'bin'), // acknowledges none, and gets all
    stream = await c.stream(session, 'bin');
  const passed = (seq, n) => waitFor(() => seqOf(other.frames.at(-1)) > seq + n, `${n} frames of another viewer`, 60000);
  await other.frame();
  await stream.frame();
  stream.say({ ack: seqOf(stream.frames.at(-1)) });
  const begun = await settled(stream); // from here on the daemon knows that it acknowledges
  await passed(seqOf(stream.frames.at(-1)), 24);
  const before = await settled(stream),
    last = seqOf(stream.frames.at(-1));
  assert.ok(before - begun <= 4, `${before - begun} frames in flight`);
  await passed(seqOf(other.frames.at(-1)), 60);
  assert.equal(await settled(stream), before, 'no frame without an ack');
  stream.say({ ack: last });
  await waitFor(() => stream.frames.length > before, 'the next frame');
  const frames = framesOf(stream),
    next = frames[before],
    events = frames.flatMap((frame) => frame.events ?? []);
  assert.ok(next.seq > last + 60, 'the newest');
  assert.ok(!next.flags.includes('jump') && !next.whole.has('views') && !next.whole.has('events'), 'the gap makes nothing whole');
  assert.ok(next.events.length > 10 && next.lost === 0, `${next.events.length} events`);
  assert.ok(
    events.every((event, i) => i === 0 || event.id === events[i - 1].id + 1),
    'no event is missed',
  );
  checkAll(stream);
  await stream.close();
  await other.close();
});

test('a slow viewer gets half of its frames, and a message', async () => {
  const session = await c.make({ scenario: 'eight', set: { duration_s: 60 } });
  const stream = await c.stream(session, 'json');
  const timer = setInterval(() => {
    if (stream.frames.length > 0) stream.say({ ack: stream.frames.at(-1).seq });
  }, 250);
  try {
    const slower = await stream.wait((message) => message.type === 'rate', 'the message');
    assert.deepEqual(slower, { type: 'rate', reason: 'slow viewer', divisor: 2 });
  } finally {
    clearInterval(timer);
  }
  checkAll(stream);
  await stream.close();
});

/** Numbers that are the same each time. @param {number} seed */
function numbers(seed) {
  let state = seed;
  return (/** @type {number} */ below) => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return Math.floor((state / 2 ** 32) * below);
  };
}

/** Events go on where they left off, but for those that are reported lost, and after a jump or another subscription. */
function checkEvents(frames) {
  let next = -1;
  for (const frame of frames) {
    const { events = [], lost, whole } = frame;
    if (events.length === 0) continue;
    if (next >= 0 && !whole.has('events')) assert.equal(events[0].id, next + lost, `frame ${frame.seq}`);
    events.forEach((event, i) => assert.equal(event.id, events[0].id + i));
    next = events.at(-1).id + 1;
  }
}

for (const scenario of ['eight', 'rigid/tumbler', 'fluid/dam_break']) {
  test(`${scenario}: viewers of any rates and channels, that skip, jump and change their minds, end with the same`, async () => {
    const draw = numbers(scenario.length),
      session = await c.make({ scenario, set: { duration_s: 60 } });
    const viewers = [];
    for (const ack of [true, true, true, true, false]) viewers.push(await c.stream(session, 'bin', { ack, subscribe: {} }));
    const names = channelsOf(viewers[0]),
      stalled = viewers.at(-1);
    const wishes = viewers.map(() => ({}));
    let stalls = 0;
    const choose = (i, all = false) => {
      wishes[i] = Object.fromEntries(
        names.filter((name) => name !== 'clock' && (all || draw(3) > 0)).map((name) => [name, [60, 20, 5, 1][draw(4)]]),
      );
      viewers[i].say({ subscribe: wishes[i] });
    };
    viewers.forEach((_, i) => choose(i, true));
    for (let round = 0; round < 40; round++) {
      await pause(40 + draw(120));
      if (draw(2) === 0) choose(draw(viewers.length - 1));
      if (draw(6) === 0) await c.control(session, { op: 'seek', tick: draw(240) });
      if (draw(6) === 0) await c.control(session, { op: 'play' });
      if (round === 8) {
        stalled.say({ ack: framesOf(stalled).at(-1).seq }); // from now on at most four in flight: none for the rest of the rounds
        stalls = await settled(stalled);
      }
    }
    const more = (await settled(stalled)) - stalls;
    assert.ok(more <= 4, `${more} frames to one that acknowledges none`);
    await c.control(session, { op: 'pause' });
    const { tick } = (await c.get(session.links.self)).json,
      truth = await c.stream(session);
    const ends = (viewer, i) => {
      const frames = framesOf(viewer),
        last = frames.at(-1),
        now = framesOf(truth).at(-1); // its first may be of before the last seek, whose frame is still under way
      if (viewer === stalled) stalled.say({ ack: last.seq });
      checkEvents(frames);
      assert.equal(now?.tick, tick, 'a new viewer');
      assert.equal(last.tick, tick, `viewer ${i}`);
      for (const { name, id } of reader(api).tables.values()) {
        const { channel } = Object.values(api.components.schemas).find((schema) => schema['x-record']?.id === id)['x-record'];
        if (!wishes[i][channel] || !now[name] || ['session', 'events'].includes(name)) continue;
        assert.deepEqual(last[name], now[name], `viewer ${i}: ${name}`);
      }
    };
    for (const [i, viewer] of viewers.entries()) await eventually(() => ends(viewer, i));
    for (const viewer of [...viewers, truth]) await viewer.close();
  });
}

// ---- messages ----

test('keys and inputs', async () => {
  const session = await c.make({ set: { 'players.0.control': 'person', 'players.1.control': 'person' } });
  const stream = await c.stream(session);
  const say = async (message, type) => {
    stream.say(message);
    const answer = await stream.wait((each) => each.id === message.id && each.type !== 'hello', JSON.stringify(message));
    check(answer.type, answer);
    assert.equal(answer.type, type, JSON.stringify(answer));
    return answer;
  };
  let id = 0;
  const input = (player, x) => ({ input: { player, axes: [x, 0], buttons: 0 }, id: ++id });
  assert.equal((await say(input(0, 1), 'error')).problem.status, 403);
  assert.equal((await say({ auth: 'b'.repeat(32), id: 'text' }, 'error')).problem.status, 403);
  const player = await say({ auth: session.player_keys[1], id: ++id }, 'reply');
  assert.deepEqual([player.role, player.player], ['player', 1]);
  assert.equal((await say(input(0, 1), 'error')).problem.status, 403);
  await say(input(1, 1), 'reply');
  assert.equal((await say({ auth: session.owner_key, id: ++id }, 'reply')).role, 'owner');
  const { tick } = await say(input(0, 1), 'reply');
  const lines = (await c.get(session.links.log)).text
    .trimEnd()
    .split('\n')
    .map((line) => JSON.parse(line));
  assert.ok(lines.some((line) => line.op === 'input' && line.player === 0 && line.tick === tick));
  assert.equal((await say({ ping: 4.5, id: ++id }, 'pong')).ping, 4.5);
  assert.deepEqual((await say({ subscribe: { scene: 60 }, id: ++id }, 'reply')).subscribed, { scene: 60 });
  assert.match((await say({ subscribe: { scenes: 60 }, id: ++id }, 'error')).problem.detail, /scenes/);
  checkAll(stream);
  await stream.close();
});

test('messages that are none change nothing', async () => {
  const session = await c.make({ paused: true, set: { 'players.0.control': 'person' } });
  const stream = await c.stream(session);
  stream.say({ auth: session.owner_key, id: 1 });
  await stream.wait((each) => each.id === 1);
  const before = await c.get(session.links.log);
  const bad = [
    '',
    'x',
    '{',
    '[]',
    'null',
    '{}',
    '{"what":1}',
    '{"ping":1,"auth":"x"}',
    '{"ping":"x"}',
    '{"auth":7}',
    '{"input":[]}',
    '{"input":{}}',
    '{"input":{"player":8}}',
    '{"input":{"player":-1}}',
    '{"input":{"player":0.5}}',
    '{"input":{"player":0,"axes":[2]}}',
    '{"input":{"player":0,"axes":[1,1,1]}}',
    '{"input":{"player":0,"axes":[NaN]}}',
    '{"input":{"player":0,"axes":[1e999]}}',
    '{"input":{"player":0,"buttons":-1}}',
    '{"input":{"player":0,"buttons":4294967296}}',
    '{"input":{"player":0,"more":1}}',
    '{"subscribe":1}',
    '{"subscribe":[]}',
    '{"subscribe":{"scene":0}}',
    '{"subscribe":{"scene":61}}',
    '{"subscribe":{"scene":"60"}}',
    '{"subscribe":{"scene":null}}',
    '{"subscribe":{"Scene":60}}',
    '{"subscribe":{},"auth":"x"}',
    '{"ping":1,"id":{}}',
    '{"ping":1,"id":"12345678901234567"}',
    '['.repeat(5000),
    `{"ping":1,"id":${'9'.repeat(400)}}`,
  ];
  for (const message of bad) {
    const count = stream.messages.length;
    stream.say(message);
    const answer = await waitFor(() => stream.messages[count], `an answer to ${message.slice(0, 60)}`);
    assert.equal(answer.type, 'error', message);
    assert.equal(answer.problem.status, 400, message);
    await pause(20); // within the rate of messages
  }
  checkAll(stream);
  assert.equal((await c.get(session.links.log)).text, before.text);
  await stream.close();
});

const E = '/api/v1/experiments';
const order = (repeats) => ({
  scenario: 'race',
  set: { duration_s: 3 },
  repeats,
  axes: [{ path: 'players.0.lag_ms', values: [0, 100] }],
  metrics: ['players.0.own_lead_m.mean'],
});

/** What a watcher of an experiment got. */
function checkProgress(stream) {
  stream.messages.forEach((message, i) => check(i === 0 ? 'experimentHello' : message.type, message));
}

test('an experiment reports its progress: paused, resumed, finished; then its stream ends', async () => {
  const made = (await c.call('POST', E, { body: order(4000) })).json;
  const control = (op) => c.call('POST', `${E}/${made.id}/control`, { key: made.owner_key, body: { op } });
  const first = await c.progress(made.id),
    second = await c.progress(made.id);
  assert.deepEqual([first.hello.experiment, first.hello.runs, first.hello.state], [made.id, 8000, 'running']);
  const moving = await first.wait((m) => m.type === 'progress' && m.done > 0, 'rows');
  assert.ok(moving.rate_per_s > 0 && moving.left_s > 0);
  await control('pause');
  const paused = await first.wait((m) => m.state === 'paused');
  assert.deepEqual([paused.rate_per_s, paused.left_s], [0, null]);
  await control('resume');
  await waitFor(() => first.messages.at(-1).state === 'running', 'the resume');
  await first.wait((m) => m.done > paused.done, 'more rows');
  await control('cancel');
  for (const stream of [first, second]) {
    const last = await stream.wait((m) => m.state === 'cancelled');
    await waitFor(() => stream.closed, 'the end');
    assert.equal(stream.closed.code, 1000);
    assert.equal(stream.messages.at(-1).type, 'bye');
    assert.equal(last.left_s, null);
    assert.deepEqual(
      stream.messages.map((m) => m.done ?? 0).filter((n, i, all) => i > 0 && i < all.length - 1 && n < all[i - 1]),
      [],
      'done only grows',
    );
    checkProgress(stream);
  }
  const late = await c.progress(made.id);
  assert.equal(late.hello.state, 'cancelled');
  await waitFor(() => late.closed, 'the end');
  assert.deepEqual(
    late.messages.map((m) => m.type),
    ['hello', 'bye'],
  );
});

test('an experiment that is deleted under its watchers, messages to it, and paths that are none', async () => {
  const made = (await c.call('POST', E, { body: order(4000) })).json,
    session = await c.make({ paused: true });
  await c.call('POST', `${E}/${made.id}/control`, { key: made.owner_key, body: { op: 'pause' } });
  const stream = await c.progress(made.id);
  stream.say({ ping: 1 });
  assert.match((await stream.wait((m) => m.type === 'error')).problem.detail, /read-only/);
  await assert.rejects(c.progress(session.id), { status: 404 });
  await assert.rejects(c.stream(made), { status: 404 });
  assert.equal((await c.call('DELETE', `${E}/${made.id}`, { key: made.owner_key })).status, 204);
  await waitFor(() => stream.closed, 'the end');
  assert.equal(stream.closed.code, 4404);
  await assert.rejects(c.progress(made.id), { status: 404 });
  checkProgress(stream);
});
