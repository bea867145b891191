// Sessions with a small state whose single tick takes seconds to hours, one of each kind: these and all other sessions can be controlled
// while it is made, ticks that are no longer wanted are interrupted, and SIGTERM ends the daemon. How long answers take then:
// bench/hostile.mjs.
import assert from 'node:assert/strict';
import { once } from 'node:events';
import net from 'node:net';
import { after, before, test } from 'node:test';
import { client, pause, waitFor } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';
import { cpu_s } from '../lib/hostile.mjs';

const DRAIN_S = 2;
const box = (/** @type {number} */ i) => ({ shape: 'box', size: [1, 1], position: [(i % 40) * 0.25, 0.5 + 0.25 * Math.floor(i / 40)] });
/** @type {Record<string, any>} */
const HEAVY = {
  'a motion of tiny fixed steps': {
    kind: 'motion',
    problem: 'kepler',
    duration_s: 4,
    tick_hz: 1,
    methods: Array.from({ length: 8 }, () => ({ method: 'velocity_verlet', dt_s: 3e-7 })),
  },
  'a motion of a tolerance that asks for tiny steps': {
    kind: 'motion',
    problem: 'kepler',
    duration_s: 4000 / 1.2,
    tick_hz: 1,
    methods: Array.from({ length: 8 }, () => ({ method: 'bs32', tolerance: 1e-15 })),
  },
  'a motion whose reference has far to go': {
    kind: 'motion',
    problem: 'double_pendulum',
    duration_s: 3600,
    tick_hz: 1,
    methods: [{ method: 'rk4', dt_s: 3600 }],
  },
  'a grid with all sweeps and substeps': {
    kind: 'fluid',
    scene: 'cavity',
    params: { n: 64 },
    hz: 1,
    duration_s: 5,
    solver: { pressure: 'jacobi', sweeps: 100000, tolerance: 0, substeps: 1000 },
  },
  'a grid by multigrid': {
    kind: 'fluid',
    scene: 'cavity',
    params: { n: 48 },
    hz: 1,
    duration_s: 5,
    solver: { pressure: 'multigrid', sweeps: 100000, tolerance: 0, cfl: 0.01 },
  },
  'a grid by conjugate gradients': {
    kind: 'fluid',
    scene: 'taylor_green',
    params: { n: 64 },
    hz: 1,
    duration_s: 5,
    solver: { pressure: 'pcg', sweeps: 100000, tolerance: 0, cfl: 0.1 },
  },
  'particles with all iterations': {
    kind: 'fluid',
    scene: 'pool',
    params: { size: 120 },
    hz: 1,
    duration_s: 5,
    solver: { method: 'dfsph', iterations: 1000, tolerance: 1e-9, substeps: 100000, cfl: 0.05 },
  },
  'particles by position': {
    kind: 'fluid',
    scene: 'dam_break',
    params: { size: 40 },
    hz: 1,
    duration_s: 5,
    solver: { method: 'pbf', iterations: 1000, substeps: 100000, cfl: 0.05 },
  },
  'bodies with all iterations, three times': {
    kind: 'rigid',
    duration_s: 5,
    hz: 60,
    side_by_side: [{}, {}],
    compare_volumes: true,
    solver: { method: 'pgs_ngs', iterations: 200, position_iterations: 200, sleep: false, recycle: false },
    bodies: [{ type: 'static', shape: 'box', size: [400, 1], position: [0, -0.5] }, ...Array.from({ length: 600 }, (_, i) => box(i))],
  },
  'a game of particles with sixteen players': {
    kind: 'netgame',
    game: 'dam',
    params: { iterations: 50, across: 15, side_m: 0.1, height_m: 0.14, width_m: 0.3, radius_m: 0.012 }, // many substeps
    duration_s: 5,
    tick_hz: 10,
    warmup_s: 0,
    server: { update_hz: 10 },
    players: Array.from({ length: 16 }, () => ({ lag_ms: 1000, prediction: true, reconciliation: true, prediction_scope: 'all' })),
  },
};
const S = (session, rest = '') => `/api/v1/sessions/${session.id}${rest}`;

let daemon, c, other;
before(async () => {
  daemon = await startDaemon({ args: ['--drain-s', String(DRAIN_S)] });
  c = client(daemon.url);
  other = await c.make({ scenario: 'race', set: { duration_s: 1000 } });
});
after(async () => {
  c.close();
  await daemon.stop();
});

/** What an answer has, which must have `status`. */
const good = async (answer, status = 200) => {
  const { status: got, json, text } = await answer;
  assert.equal(got, status, text);
  return json;
};

/** Waits until the daemon has computed for so long. */
async function computes(of, seconds) {
  const from = cpu_s(of.pid);
  await waitFor(() => cpu_s(of.pid) - from >= seconds, 'the daemon to compute');
}

for (const [what, scenario] of Object.entries(HEAVY)) {
  test(`${what}: it and others are controlled while a tick is made`, async () => {
    const session = await good(c.call('POST', '/api/v1/sessions', { body: { scenario, speed: 10, paused: true } }), 201);
    const viewer = await c.stream(session, 'bin');
    for (let i = 0; i < 5; i++) {
      await good(c.control(session, { op: 'play' }));
      await computes(daemon, 0.05);
      await good(c.get(S(session)));
      await good(c.patch(other, { players: { 0: { lag_ms: 10 + i } } }));
      await good(c.get(S(other, '/state')));
      await good(c.control(other, { op: i % 2 ? 'play' : 'pause' }));
      const { status, tick } = await good(c.control(session, { op: 'pause' }));
      assert.deepEqual([status, tick], ['paused', 0], 'none of them waited for the tick');
    }
    await good(c.control(session, { op: 'play' }));
    await computes(daemon, 0.05);
    await good(c.call('DELETE', S(session), { key: session.owner_key }), 204);
    await viewer.close();
    await c.control(other, { op: 'pause' });
    await waitFor(async () => {
      const from = cpu_s(daemon.pid);
      await pause(200);
      return cpu_s(daemon.pid) - from <= 0.02;
    }, 'the tick to be interrupted');
  });
}

test('a step that takes longer than a request may is reported, and the session stays where it was', async () => {
  const strict = await startDaemon({ args: ['--request-cpu-s', '0.2'] }),
    s = client(strict.url);
  try {
    const session = await s.make({ scenario: HEAVY['a grid by multigrid'], paused: true });
    const hash = (await s.get(S(session, '/state'))).json.hash;
    const answer = await s.control(session, { op: 'step' });
    assert.equal(answer.status, 503, answer.text);
    assert.match(answer.json.detail, /0\.2 s of processor time.*tick 0 of 1/);
    const now = (await s.get(S(session, '/state'))).json;
    assert.deepEqual([now.tick, now.hash], [0, hash]);
    const copy = await s.get(S(session, '/trace'));
    assert.equal(copy.status, 200, copy.text);
  } finally {
    s.close();
    await strict.stop();
  }
});

test('a change that recomputes a long run does not hold the session, and gives what a run with it from the start gives', async () => {
  const scenario = { kind: 'motion', problem: 'double_pendulum', duration_s: 300, tick_hz: 1, methods: [{ method: 'rk4', dt_s: 0.0005 }] };
  const session = await c.make({ scenario, paused: true });
  assert.equal((await c.control(session, { op: 'seek', tick: 200 })).status, 200);
  await good(c.patch(session, { methods: { 0: { dt_s: 0.0001 } } }));
  const answered = [];
  const own = good(c.get(S(session, '/state'))).then((state) => {
    answered.push('own');
    return state;
  });
  await good(c.get(S(other, '/state')));
  answered.push('other');
  const state = await own;
  assert.deepEqual(answered, ['other', 'own'], 'the run was not ready at the answer to the change');
  const fresh = await c.make({ scenario: { ...scenario, methods: [{ method: 'rk4', dt_s: 0.0001 }] }, paused: true });
  assert.equal((await c.control(fresh, { op: 'seek', tick: 200 })).status, 200);
  assert.deepEqual(state.state, (await c.get(S(fresh, '/state'))).json.state);
  assert.equal(state.tick, 200);
});

test('ticks that are long now and then are made all the same', async () => {
  // Each change of the timeline recomputes the run, in the middle of ticks that take microseconds.
  const timeline = [3, 6, 9].map((at_s, i) => ({ at_s, set: { 'methods.0.dt_s': 2e-5 * (i + 2) } }));
  const scenario = {
    kind: 'motion',
    problem: 'kepler',
    duration_s: 10,
    tick_hz: 60,
    timeline,
    methods: [{ method: 'velocity_verlet', dt_s: 2e-5 }],
  };
  const session = await c.make({ scenario, paused: true });
  assert.equal((await c.control(session, { op: 'seek', tick: 600 })).status, 200);
  const sought = (await c.get(S(session, '/state'))).json;
  const played = await c.make({ scenario, paused: true, speed: 10 });
  const viewer = await c.stream(played, 'json');
  await c.control(played, { op: 'play' });
  await waitFor(async () => (await c.get(S(played))).json.status === 'ended', 'the end');
  await viewer.close();
  assert.equal((await c.get(S(played, '/state'))).json.hash, sought.hash);
});

/** A viewer that reads nothing, answers nothing and closes nothing. */
async function mute(of) {
  const maker = client(of.url),
    session = await maker.make({ paused: true }),
    socket = net.connect(of.port, '127.0.0.1');
  maker.close();
  socket.on('error', () => undefined);
  socket.write(
    `GET ${S(session, '/stream')} HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n` +
      'Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Protocol: laglab.v2.json\r\n\r\n',
  );
  await once(socket, 'readable');
  return socket;
}

// No later than that by the order of ends, not by time: one that waits for a viewer for a minute is still there when the other is not.
test('SIGTERM ends the daemon while ticks are made, after --drain-s', async (t) => {
  const victim = await startDaemon({ args: ['--drain-s', String(DRAIN_S)] }),
    patient = await startDaemon({ args: ['--drain-s', '60'] }),
    v = client(victim.url);
  t.after(() => patient.kill());
  for (const of of [victim, patient]) {
    const socket = await mute(of);
    t.after(() => socket.destroy());
  }
  const steps = [];
  for (const scenario of Object.values(HEAVY)) {
    const session = await v.make({ scenario, paused: true });
    steps.push(v.control(session, { op: 'step' }).catch(() => undefined));
  }
  await computes(victim, 0.5);
  let ended = false;
  patient.stop().then(() => {
    ended = true;
  });
  const from = performance.now(),
    how = await victim.stop(), // kills it where it does not end
    took_s = (performance.now() - from) / 1000;
  assert.equal(ended, false, 'the other waits for its viewer');
  assert.ok(took_s >= DRAIN_S, `it waited ${took_s} s for its viewer`);
  await Promise.all(steps);
  v.close();
  assert.deepEqual(how, { code: 0, signal: null }, victim.errors());
});
