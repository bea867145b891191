// Holds the page's decoder of binary frames (www/js/frame.js) against the text frames of the same numbers.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { CONNECTIONS, decode } from '../../www/js/frame.js';
import { client, waitFor } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';

let daemon, c;

before(async () => {
  daemon = await startDaemon();
  c = client(daemon.url);
});
after(async () => {
  c.close();
  await daemon.stop();
});

const SHOT = {
  player: 'player', weapon: 'weapon', flags: 'flags', tick: 'tick', pressed: 'pressed_s', seen: 'seen_s', judged: 'judged_s',
  looked: 'looked_s', x: 'x', y: 'y', dx: 'dx', dy: 'dy', serverX: 'server_x', serverY: 'server_y', viewHit: 'client_view_hit',
  nowHit: 'server_now_hit', serverHit: 'compensated_hit', perfectHit: 'perfect_hit',
};
const BODY = { seenX: 'seen_x', seenY: 'seen_y', nowX: 'now_x', nowY: 'now_y', lookedX: 'looked_x', lookedY: 'looked_y' };
const SHELL = {
  view: 'view', player: 'player', number: 'number', flown: 'flown_s', x: 'x', y: 'y', vx: 'vx', vy: 'vy', fromX: 'from_x',
  fromY: 'from_y', fromVx: 'from_vx', fromVy: 'from_vy',
};

function same(names, decoded, told) {
  for (const [ours, theirs] of Object.entries(names)) {
    assert.ok(Math.abs(decoded[ours] - told[theirs]) <= 1e-14 * Math.abs(told[theirs]), `${ours}: ${decoded[ours]}, ${told[theirs]}`);
  }
}

test('shots and shells, as in the text frames', async () => {
  const session = await c.make({ scenario: 'cannon_shell', set: { 'params.weapons': 'both' }, paused: true });
  await c.control(session, { op: 'seek', time_s: 10 });
  const json = await c.stream(session, 'json'), binary = await c.stream(session, 'bin');
  await c.control(session, { op: 'play' });
  await waitFor(() => json.frames.length > 60 && binary.frames.length > 60, 'frames');
  let shots = 0, shells = 0;
  for (const bytes of binary.frames) {
    const frame = decode(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
    const other = json.frames.find((each) => each.seq === frame.seq);
    if (!other) continue;
    assert.equal(frame.shots.length, other.shots.length);
    assert.equal(frame.shells.length, other.shells.length);
    frame.shots.forEach((shot, i) => {
      same(SHOT, shot, other.shots[i]);
      assert.equal(shot.bodies.length, other.shots[i].bodies.length);
      shot.bodies.forEach((body, k) => same(BODY, body, other.shots[i].bodies[k]));
    });
    frame.shells.forEach((shell, i) => same(SHELL, shell, other.shells[i]));
    shots += frame.shots.length;
    shells += frame.shells.length;
  }
  assert.ok(shots > 100 && shells > 20, `${shots} shots, ${shells} shells`);
  await json.close();
  await binary.close();
});

const PEER = {
  confirmed: 'confirmed', tick: 'tick', desyncTick: 'desync_tick', waiting: 'waiting', stalls: 'stalls', stalled: 'stalled_s',
  rollbacks: 'rollbacks', rollbackTicks: 'rollback_ticks', desyncEntity: 'desync_entity', desyncField: 'desync_field',
  desyncDistance: 'desync_m', desyncUlps: 'desync_ulps',
};

test('peers, as in the text frames', async () => {
  const session = await c.make({ scenario: 'rollback_loss', set: { 'players.1.hardware': 'float' }, paused: true });
  await c.control(session, { op: 'seek', time_s: 15.5 });
  const json = await c.stream(session, 'json'), binary = await c.stream(session, 'bin');
  await c.control(session, { op: 'play' });
  await waitFor(() => json.frames.length > 60 && binary.frames.length > 60, 'frames');
  let compared = 0, waiting = 0;
  for (const bytes of binary.frames) {
    const frame = decode(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
    const other = json.frames.find((each) => each.seq === frame.seq);
    if (!other) continue;
    assert.equal(frame.peers.length, 2);
    assert.equal(other.peers.length, 2);
    frame.peers.forEach((peer, i) => same(PEER, peer, other.peers[i]));
    assert.ok(frame.peers[0].desyncTick === -1 && frame.peers[1].desyncTick > 0 && frame.peers[1].desyncUlps > 0);
    compared++;
    waiting += frame.peers[0].waiting === 2 && frame.views[1].flags & 16 ? 1 : 0;
  }
  assert.ok(compared > 25 && waiting > 5, `${compared} frames compared, in ${waiting} A waits for B`);
  await json.close();
  await binary.close();
});

const VIEW = {
  view: 'view', flags: 'flags', inputSeq: 'input_seq', ackedSeq: 'acked_seq', unacked: 'unacked', lag: 'lag_ms', viewAge: 'view_age_ms',
  ownLead: 'own_lead_m', remoteError: 'remote_error_m', buffer: 'buffer_ms', corrections: 'corrections', correction: 'correction_m',
  refused: 'refused', alpha: 'alpha', shown: 'shown_s',
};
const MEASURES = {
  player: 'player', ageOfInformation: 'age_of_information_ms', errorSum: 'own_timeline_error_sum_m', latencySum: 'input_latency_sum_ms',
  errors: 'own_timeline_errors', latencies: 'input_latencies', changes: 'input_changes', lost: 'input_changes_lost',
  visibleCorrections: 'visible_corrections',
};

test('views, connections and what is counted, as in the text frames, through an outage', async () => {
  const session = await c.make({ scenario: 'outage', set: { 'players.1.lag_ms': 120 }, paused: true });
  const json = await c.stream(session, 'json'), binary = await c.stream(session, 'bin');
  /** @type {Set<string>} */
  const met = new Set();
  let compared = 0;
  for (const time of [9, 13.3, 14.5, 17, 18.9, 21]) {
    await c.control(session, { op: 'seek', time_s: time });
    const text = await json.frame((frame) => Math.abs(frame.time_s - time) < 0.02);
    await waitFor(() => binary.frames.some((bytes) => bytes.readUInt32LE(4) === text.seq), `frame ${text.seq}`);
    const bytes = binary.frames.find((each) => each.readUInt32LE(4) === text.seq);
    const frame = decode(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
    frame.views.forEach((view, i) => {
      same(VIEW, view, text.views[i]);
      assert.equal(CONNECTIONS[view.connection], text.views[i].connection);
      assert.equal(view.connected, text.views[i].connected);
      assert.equal(Number.isNaN(view.slack) ? null : view.slack, text.views[i].slack_ticks);
    });
    frame.measures.forEach((one, i) => same(MEASURES, one, text.measures[i]));
    assert.equal(frame.measures.length, 2);
    assert.deepEqual([text.views[0].connection, text.views[0].connected, text.views[1].connection], ['playing', true, 'playing']);
    met.add(`${text.views[2].connection} ${text.views[2].connected} ${(text.views[0].entities[1].flags & 128) !== 0}`);
    compared++;
  }
  assert.equal(compared, 6);
  // The server drops B before B knows that something is amiss.
  assert.deepEqual([...met], ['playing true false', 'playing false true', 'stalled false true', 'disconnected false true', 'resynchronising true false']);
  await json.close();
  await binary.close();
});

test('the events of an outage: stalled, dropped, disconnected, joined again', async () => {
  const session = await c.make({ scenario: 'outage', set: { 'players.1.lag_ms': 120 }, paused: true });
  const json = await c.stream(session, 'json');
  /** @type {Map<number, any>} */
  const events = new Map();
  await c.control(session, { op: 'seek', time_s: 9 });
  await c.control(session, { op: 'speed', speed: 10 });
  await c.control(session, { op: 'play' });
  await waitFor(() => (json.frames.at(-1)?.time_s ?? 0) > 21, 'the time after the outage', 20000);
  for (const frame of json.frames) for (const event of frame.events) events.set(event.id, event);
  const told = [...events.values()].filter((event) => event.player === 1 && event.begin_s > 0 && (event.type === 23 || event.type === 24));
  assert.deepEqual(told.map((event) => (event.type === 24 ? 'dropped' : CONNECTIONS[event.outcome])),
    ['dropped', 'stalled', 'disconnected', 'resynchronising', 'playing'], JSON.stringify(told));
  assert.deepEqual(told.map((event) => event.number), [1, 1, 1, 2, 2]);
  assert.ok(!told.some((event, i) => i > 0 && event.begin_s < told[i - 1].begin_s));
  for (const type of [5, 6, 7, 8]) assert.ok([...events.values()].some((event) => event.type === type && event.player === 1 && event.begin_s > 10), `type ${type}`);
  await json.close();
});
