// Holds the stream of the running daemon against api/asyncapi.yaml: JSON messages by their schemas, binary frames by the layout
// table, decoded and compared with the JSON frame of the same number.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import Ajv from 'ajv/dist/2020.js';
import YAML from 'yaml';
import { client, pause, waitFor } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';
import { decodeFrame } from '../lib/layout.mjs';
import { decode } from '../../www/js/frame.js';

let daemon, c, api, ajv, layout;

before(async () => {
  daemon = await startDaemon();
  c = client(daemon.url);
  api = YAML.parse((await c.get('/api/v1/asyncapi.yaml')).text);
  layout = api.components.messages.binaryFrame['x-layout'];
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

/** Everything that a viewer got. */
function checkAll(stream) {
  for (const message of stream.messages) check(message.type, message);
  for (const frame of stream.frames) {
    if (Buffer.isBuffer(frame)) decodeFrame(layout, frame);
    else check('frame', frame);
  }
}

const seqOf = (frame) => (Buffer.isBuffer(frame) ? frame.readUInt32LE(4) : frame.seq);
const flagsOf = (frame) => (Buffer.isBuffer(frame) ? frame.readUInt16LE(2) : frame.flags);
const KEY = 1, PLAYING = 2, ENDED = 4, BEHIND = 8;

/** Equal but for the last bit that 15 digits of JSON leave open. */
function near(a, b, path) {
  if (typeof a === 'number' && typeof b === 'number') return assert.ok(Math.abs(a - b) <= 1e-14 * Math.abs(a), `${path}: ${a} and ${b}`);
  if (typeof a !== 'object' || a === null) return assert.equal(a, b, path);
  assert.deepEqual(Object.keys(a).sort(), Object.keys(b).sort(), path);
  for (const key of Object.keys(a)) near(a[key], b[key], `${path}.${key}`);
}

function same(binary, json) {
  const { sections, reserved, type, ...rest } = binary;
  const { type: _, ...other } = json;
  for (const view of rest.views ?? []) assert.ok(view.entities.length >= rest.game.length);
  near(rest, other, 'frame');
}

/** Frames of both encodings of one scenario, held against each other. */
async function compareEncodings(id) {
  const session = await c.make({ scenario: id, paused: true });
  await c.control(session, { op: 'seek', time_s: 1 });
  const json = await c.stream(session, 'json'), binary = await c.stream(session, 'bin');
  await c.control(session, { op: 'play' });
  const ended = () => (json.frames.at(-1)?.flags & ENDED) !== 0; // a short one on a busy machine
  // On a busy machine a viewer may miss a frame, and is then sent a whole one: pairs are those that are told alike.
  const pairs = () => {
    const texts = new Map(json.frames.map((frame) => [frame.seq, frame]));
    return binary.frames.map((bytes) => [bytes, texts.get(seqOf(bytes))])
      .filter(([bytes, text]) => text && (text.flags & KEY) === (flagsOf(bytes) & KEY));
  };
  await waitFor(() => pairs().length > 30 || ended(), `frames of ${id}`, 20000);
  await c.control(session, { op: 'pause' });
  await pause(60);
  checkAll(json);
  checkAll(binary);
  const compared = pairs();
  for (const [bytes, text] of compared) same(decodeFrame(layout, bytes), text);
  assert.ok(compared.length > (ended() ? 5 : 25), `${compared.length} frames compared of ${id}`);
  assert.deepEqual(json.hello.layout, binary.hello.layout);
  await json.close();
  await binary.close();
}

test('binary frames say what JSON frames say, in every library scenario', async () => {
  const left = (await c.get('/api/v1/scenarios')).json.scenarios.map(({ id }) => id);
  assert.ok(left.length > 100, `${left.length} scenarios`);
  // Most of the time is waiting for frames: three at a time.
  await Promise.all(Array.from({ length: 3 }, async () => {
    for (let id = left.pop(); id; id = left.pop()) await compareEncodings(id);
  }));
});

test('the page decodes the reconciliation ladder as the layout has it', async () => {
  const session = await c.make({ scenario: 'contact', paused: true });
  await c.control(session, { op: 'seek', time_s: 20 });
  const stream = await c.stream(session, 'bin');
  const bytes = await stream.frame(() => true), { ladder } = decodeFrame(layout, bytes);
  const page = decode(new Uint8Array(bytes).buffer);
  assert.equal(ladder.length, 64, 'of each of two players the last 32');
  assert.deepEqual(page.ladder.map((r) => [r.player, r.state, r.seq, r.made]), ladder.map((r) => [r.player, r.state, r.seq, r.made_ms]));
  assert.deepEqual(page.ladder.map((r) => [r.predictedX, r.serverX, r.correction]),
    ladder.map((r) => [r.known & 1 ? r.predicted_x : null, r.known & 2 ? r.server_x : null, r.known === 3 ? r.correction_m : null]));
  assert.ok(ladder.some((r) => r.state === 0) && ladder.some((r) => r.known === 3 && r.state === 1));
  await stream.close();
});

test('the page decodes the buffers of views as the layout has them', async () => {
  const session = await c.make({ scenario: 'interpolation_jitter', paused: true });
  await c.control(session, { op: 'seek', time_s: 9 });
  const stream = await c.stream(session, 'bin');
  const bytes = await stream.frame(() => true), frame = decodeFrame(layout, bytes);
  const page = decode(new Uint8Array(bytes).buffer);
  assert.ok(page && frame.buffers.length === 2 && frame.buffered.length >= 4, `${frame.buffered.length} states`);
  assert.deepEqual(page.buffers.map((b) => [b.player, b.state, b.delay, b.behind, b.timeScale, b.dejitter, b.underruns, b.overruns, b.late]),
    frame.buffers.map((b) => [b.player, b.state, b.delay_ms, b.behind_ms, b.time_scale, b.dejitter_ms, b.underruns, b.overruns, b.late]));
  assert.deepEqual(page.buffered.map((b) => [b.player, b.place, b.tick, b.time, b.sent, b.arrived, b.due]),
    frame.buffered.map((b) => [b.player, b.place, b.tick, b.time_ms, b.sent_ms, b.arrived_ms, b.due_ms]));
  const ahead = frame.buffered.filter((b) => b.player === 0);
  assert.ok(ahead[0].time_ms <= 0 && ahead[1].time_ms > 0, 'from the state that is drawn on');
  assert.ok(ahead.every((b, i) => i === 0 || b.tick > ahead[i - 1].tick), 'in order');
  assert.ok(frame.buffered.every((b) => b.place === 0), 'no de-jitter buffer');
  assert.ok(frame.buffers[0].behind_ms > 180 && frame.buffers[0].delay_ms === 210, JSON.stringify(frame.buffers));
  await stream.close();
});

test('a de-jitter buffer tells what it holds', async () => {
  const session = await c.make({ scenario: 'dejitter', paused: true });
  await c.control(session, { op: 'seek', time_s: 9 });
  const stream = await c.stream(session, 'bin');
  const { buffers, buffered } = decodeFrame(layout, await stream.frame(() => true));
  const held = (player) => buffered.filter((b) => b.place === 1 && b.player === player);
  assert.deepEqual(buffers.map((b) => b.dejitter_ms).slice(0, 3), [0, 100, 100]);
  assert.equal(held(0).length, 0);
  for (const b of held(1)) assert.ok(Math.abs(b.due_ms - b.arrived_ms - 100) < 0.001, JSON.stringify(b));
  for (const b of [...held(1), ...held(2)]) {
    assert.ok(b.sent_ms < b.arrived_ms && b.arrived_ms <= 0 && b.due_ms > 0, JSON.stringify(b));
  }
  assert.ok(held(1).length >= 1 && held(2).length >= 1, JSON.stringify(buffered));
  await stream.close();
});

test('the beginning: hello, a key frame, then 60 frames a second in order', async () => {
  const session = await c.make();
  for (const format of ['json', 'bin']) {
    const stream = await c.stream(session, format, { ack: true });
    await pause(1000);
    const seqs = stream.frames.map(seqOf);
    assert.ok(seqs.length >= 25 && seqs.length <= 70, `${seqs.length} frames`); // how evenly is for bench/ to say, on a quiet machine
    assert.ok(seqs.every((seq, i) => i === 0 || seq > seqs[i - 1]), 'in order');
    const flags = stream.frames.map(flagsOf);
    assert.equal(flags[0] & KEY, KEY);
    assert.ok(flags.every((flag) => flag & PLAYING));
    assert.ok(flags.filter((flag) => flag & KEY).length <= 2 + flags.length / 10, 'key frames are for the beginning and for gaps');
    checkAll(stream);
    await stream.close();
  }
});

test('time jumps: generation and key frames; the end and the replay', async () => {
  const session = await c.make({ set: { duration_s: 1 } });
  const stream = await c.stream(session);
  const over = await stream.frame((frame) => frame.flags & ENDED);
  assert.equal(over.tick, 60);
  await c.control(session, { op: 'seek', tick: 10 });
  const back = await stream.frame((frame) => frame.generation > over.generation);
  assert.equal(back.tick, 10);
  assert.equal(back.flags, KEY | BEHIND);
  await c.control(session, { op: 'play' });
  await stream.frame((frame) => frame.flags & ENDED && frame.seq > back.seq);
  const count = stream.frames.length;
  await pause(200);
  assert.equal(stream.frames.length, count, 'nothing new, no frame');
  await c.patch(session, { 'players.0.lag_ms': 10 });
  const changed = await stream.frame((frame) => frame.seq > stream.frames[count - 1].seq);
  assert.ok(changed.params_version > back.params_version);
  checkAll(stream);
  await stream.close();
});

test('a viewer that acknowledges has at most four frames in flight, and then the newest', async () => {
  const session = await c.make();
  const stream = await c.stream(session);
  stream.say({ ack: (await stream.frame()).seq });
  await pause(100);
  const last = stream.frames.at(-1).seq;
  await pause(400);
  assert.equal(stream.frames.at(-1).seq, last, 'no frame without an ack');
  assert.ok(stream.frames.length <= 12);
  stream.say({ ack: last });
  const next = await stream.frame((frame) => frame.seq > last);
  assert.ok(next.seq > last + 8, 'the newest');
  assert.equal(next.flags & KEY, KEY, 'the gap is filled by a key frame');
  checkAll(stream);
  await stream.close();
});

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
  const lines = (await c.get(session.links.log)).text.trimEnd().split('\n').map((line) => JSON.parse(line));
  assert.ok(lines.some((line) => line.op === 'input' && line.player === 0 && line.tick === tick));
  assert.equal((await say({ ping: 4.5, id: ++id }, 'pong')).ping, 4.5);
  checkAll(stream);
  await stream.close();
});

test('messages that are none change nothing', async () => {
  const session = await c.make({ paused: true, set: { 'players.0.control': 'person' } });
  const stream = await c.stream(session);
  stream.say({ auth: session.owner_key, id: 1 });
  await stream.wait((each) => each.id === 1);
  const before = await c.get(session.links.log);
  const bad = ['', 'x', '{', '[]', 'null', '{}', '{"what":1}', '{"ping":1,"auth":"x"}', '{"ping":"x"}', '{"auth":7}', '{"input":[]}', '{"input":{}}',
    '{"input":{"player":8}}', '{"input":{"player":-1}}', '{"input":{"player":0.5}}', '{"input":{"player":0,"axes":[2]}}',
    '{"input":{"player":0,"axes":[1,1,1]}}', '{"input":{"player":0,"axes":[NaN]}}', '{"input":{"player":0,"axes":[1e999]}}',
    '{"input":{"player":0,"buttons":-1}}', '{"input":{"player":0,"buttons":4294967296}}', '{"input":{"player":0,"more":1}}',
    '{"ping":1,"id":{}}', '{"ping":1,"id":"12345678901234567"}', '['.repeat(5000), `{"ping":1,"id":${'9'.repeat(400)}}`];
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
const order = (repeats) => ({ scenario: 'race', set: { duration_s: 3 }, repeats, axes: [{ path: 'players.0.lag_ms', values: [0, 100] }],
  metrics: ['players.0.own_lead_m.mean'] });

/** What a watcher of an experiment got. */
function checkProgress(stream) {
  stream.messages.forEach((message, i) => check(i === 0 ? 'experimentHello' : message.type, message));
}

test('an experiment tells its progress: paused, resumed, over; then its stream ends', async () => {
  const made = (await c.call('POST', E, { body: order(4000) })).json;
  const control = (op) => c.call('POST', `${E}/${made.id}/control`, { key: made.owner_key, body: { op } });
  const first = await c.progress(made.id), second = await c.progress(made.id);
  assert.deepEqual([first.hello.experiment, first.hello.runs, first.hello.state], [made.id, 8000, 'running']);
  const moving = await first.wait((m) => m.type === 'progress' && m.done > 0, 'rows', 20000);
  assert.ok(moving.rate_per_s > 0 && moving.left_s > 0);
  await control('pause');
  const paused = await first.wait((m) => m.state === 'paused');
  assert.deepEqual([paused.rate_per_s, paused.left_s], [0, null]);
  await control('resume');
  await waitFor(() => first.messages.at(-1).state === 'running', 'the resume');
  await first.wait((m) => m.done > paused.done, 'more rows', 20000);
  await control('cancel');
  for (const stream of [first, second]) {
    const last = await stream.wait((m) => m.state === 'cancelled');
    await waitFor(() => stream.closed, 'the end');
    assert.equal(stream.closed.code, 1000);
    assert.equal(stream.messages.at(-1).type, 'bye');
    assert.equal(last.left_s, null);
    assert.deepEqual(stream.messages.map((m) => m.done ?? 0).filter((n, i, all) => i > 0 && i < all.length - 1 && n < all[i - 1]), [], 'done only grows');
    checkProgress(stream);
  }
  const late = await c.progress(made.id);
  assert.equal(late.hello.state, 'cancelled');
  await waitFor(() => late.closed, 'the end');
  assert.deepEqual(late.messages.map((m) => m.type), ['hello', 'bye']);
});

test('an experiment that is deleted under its watchers, messages to it, and paths that are none', async () => {
  const made = (await c.call('POST', E, { body: order(4000) })).json, session = await c.make({ paused: true });
  await c.call('POST', `${E}/${made.id}/control`, { key: made.owner_key, body: { op: 'pause' } });
  const stream = await c.progress(made.id);
  stream.say({ ping: 1 });
  assert.match((await stream.wait((m) => m.type === 'error')).problem.detail, /only tells/);
  await assert.rejects(c.progress(session.id), { status: 404 });
  await assert.rejects(c.stream(made), { status: 404 });
  assert.equal((await c.call('DELETE', `${E}/${made.id}`, { key: made.owner_key })).status, 204);
  await waitFor(() => stream.closed, 'the end');
  assert.equal(stream.closed.code, 4404);
  await assert.rejects(c.progress(made.id), { status: 404 });
  checkProgress(stream);
});
