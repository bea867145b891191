// Clients that send the heaviest possible requests without a pause: others are answered, and do not wait for the ends of these; the daemon
// is idle after they have left, and SIGTERM ends it without losing acknowledged changes. How long others wait: bench/hostile.mjs.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { client, pause, raw, waitFor } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';
import { ARGS, attack, cpu_s, measure, prepare } from '../lib/hostile.mjs';

/** Of an ordinary client: 4 requests of one session and 3 of new ones in each. */
const ROUNDS = 10;
const POOL = { kind: 'fluid', scene: 'pool', params: { size: 300 }, duration_s: 3000 };
const S = (session, rest = '') => `/api/v1/sessions/${session.id}${rest}`;

let daemon, c, place;

before(async () => {
  daemon = await startDaemon({ args: [...ARGS, '--job-idle-s', '1'] });
  c = client(daemon.url);
  place = await prepare(daemon.url, 3000);
});
after(async () => {
  c.close();
  await daemon.stop();
});

async function others() {
  const seen = await measure(daemon.url, Infinity, ROUNDS);
  for (const name of ['pause', 'patch', 'play', 'state', 'create', 'delete', 'health']) assert.equal(seen[name].count, ROUNDS, name);
}

/** Waits until the daemon uses less than a fifth of a core. */
const becomesIdle = () =>
  waitFor(async () => {
    const from = cpu_s(daemon.pid);
    await pause(300);
    return cpu_s(daemon.pid) - from <= 0.06;
  }, 'the daemon to be idle after its clients have left');

const GROUPS = {
  'seeks of a large session, and reads of one that cannot keep its speed': ['seek', 'look', 'seek', 'look'],
  'dry runs and states of a distant tick': ['dry_run', 'state_at', 'dry_run', 'state_at'],
  'long traces and bodies of 50,000 paths': ['trace', 'set_many', 'trace', 'set_many'],
  'results, reports and forks': ['results', 'report', 'fork', 'results'],
  'searches for advice, which end without requests for them': ['advise'],
};

for (const [what, names] of Object.entries(GROUPS)) {
  test(`others are answered under ${what}`, async (t) => {
    const attackers = attack(daemon.url, names, place, 4);
    try {
      await attackers.begun();
      await others();
      t.diagnostic(`answers to the attackers meanwhile: ${JSON.stringify(attackers.answers)}`);
    } finally {
      await attackers.end();
    }
    await becomesIdle();
  });
}

test('a search pauses without requests for it, and continues at the next one', async () => {
  const patient = await startDaemon({ args: ['--job-idle-s', '60'] }),
    p = client(patient.url);
  const metrics = ['cell_visits', 'density_error_mean'];
  const experiment = {
    scenario: { ...POOL, duration_s: 20 },
    metrics,
    error: metrics[1],
    cost: metrics[0],
    axes: [{ path: 'params.size', values: [40, 60, 80] }],
    repeats: 50,
  };
  try {
    const order = await p.call('POST', '/api/v1/advise', { body: { max_error: 1e-3, experiment } });
    assert.equal(order.status, 202, order.text);
    const used = async (/** @type {number} */ ms) => {
      const from = cpu_s(patient.pid);
      await pause(ms);
      return cpu_s(patient.pid) - from;
    };
    await waitFor(async () => (await used(600)) <= 0.06, 'it to rest');
    const from = cpu_s(patient.pid);
    await waitFor(async () => {
      assert.equal((await p.get(order.json.links.self)).json.state, 'running');
      await pause(100);
      return cpu_s(patient.pid) - from > 0.2;
    }, 'it to go on');
  } finally {
    p.close();
    await patient.stop();
  }
});

test('a request that has used up its processor time reports its progress, and the next one continues', async () => {
  const strict = await startDaemon({ args: ['--request-cpu-s', '0.3'] }),
    s = client(strict.url);
  try {
    const session = await s.make({ scenario: POOL, paused: true });
    let tick = 0;
    for (let i = 0; i < 3; i++) {
      const answer = await s.control(session, { op: 'seek', tick: 100000 });
      assert.equal(answer.status, 503, answer.text);
      assert.match(answer.json.detail, /0\.3 s of processor time.*tick \d+ of 100000/);
      const reached = Number(/tick (\d+) of/.exec(answer.json.detail)[1]);
      assert.ok(reached > tick, `${reached} after ${tick}`);
      tick = reached;
      const now = (await s.get(S(session))).json;
      assert.deepEqual([now.status, now.tick, now.head_tick], ['paused', tick, tick]);
    }
    const back = await s.get(S(session, `/state?tick=${tick - 1}`));
    assert.equal(back.status, 503);
    assert.match(back.json.detail, new RegExp(`tick \\d+ of ${tick - 1}`));
    assert.equal((await s.control(session, { op: 'seek', tick: 2 })).json.tick, 2);
  } finally {
    s.close();
    await strict.stop();
  }
});

test('others are answered during a seek, and a command of its session ends it at the present tick', async () => {
  const session = await c.make({ scenario: POOL, paused: true });
  let over = false;
  const seek = c.control(session, { op: 'seek', tick: 100000 }).finally(() => (over = true));
  await waitFor(async () => (await c.get(S(session))).json.tick > 20, 'the seek to be on its way');
  await others();
  assert.equal(over, false, 'they did not wait for its end');
  const paused = await c.control(session, { op: 'pause' });
  assert.equal(paused.status, 200);
  const answer = await seek;
  assert.equal(answer.status, 409);
  assert.match(answer.json.detail, new RegExp(`at tick ${paused.json.tick}\\.`));
  assert.equal((await c.get(S(session))).json.tick, paused.json.tick);
});

test('a client that disconnects ends its request, and the session stays at its tick', async () => {
  const session = await c.make({ scenario: POOL, paused: true });
  const body = JSON.stringify({ op: 'seek', tick: 100000 });
  await raw(
    daemon.port,
    `POST ${S(session, '/control')} HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n` +
      `Authorization: Bearer ${session.owner_key}\r\nContent-Length: ${body.length}\r\n\r\n${body}`,
    700,
  );
  await becomesIdle();
  const { tick } = (await c.get(S(session))).json;
  assert.ok(tick < 100000);
  await pause(300);
  assert.equal((await c.get(S(session))).json.tick, tick, 'no task continues it');
});

test('a session that cannot keep its speed is reported at the tick that it has', async () => {
  const { tick } = (await c.get(S(place.slow))).json;
  const session = (await c.control(place.slow, { op: 'pause' })).json;
  assert.equal(session.status, 'paused');
  assert.ok(session.tick >= tick);
});

test('SIGTERM ends the daemon while requests of minutes are under way, and all acknowledged changes are stored', async () => {
  const data = mkdtempSync(path.join(tmpdir(), 'laglab-hostile-'));
  const victim = await startDaemon({ data, args: [...ARGS, '--drain-s', '2', '--request-cpu-s', '600'] });
  const v = client(victim.url);
  try {
    const there = await prepare(victim.url, 1000);
    const mine = await v.make({ scenario: 'race', paused: true });
    const attackers = attack(victim.url, ['seek', 'state_at', 'dry_run', 'advise', 'trace', 'look', 'fork', 'results'], there, 8);
    await attackers.begun();
    let acknowledged = 0;
    const patching = (async () => {
      for (let lag = 1; lag < 900; lag++) {
        const answer = await v.patch(mine, { players: { 0: { lag_ms: lag } } }).catch(() => undefined);
        if (answer?.status !== 200) return;
        acknowledged = lag;
      }
    })();
    await waitFor(() => acknowledged > 3, 'changes');
    const how = await victim.stop(); // kills it where it does not end
    await Promise.all([attackers.end(), patching]);
    assert.deepEqual(how, { code: 0, signal: null }, victim.errors());
    const again = await startDaemon({ data }),
      a = client(again.url);
    const session = (await a.get(S(mine))).json,
      other = await a.get(S(there.slow));
    a.close();
    await again.stop();
    assert.ok(session.params.players[0].lag_ms >= acknowledged, `${session.params.players[0].lag_ms} of ${acknowledged}`);
    assert.equal(other.status, 200);
  } finally {
    v.close();
    rmSync(data, { recursive: true, force: true });
  }
});
