// The adviser compared with brute force, from outside: a sample of the cases of `bench/run advise`, and critical cases.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { test } from 'node:test';
import { grids } from '../../bench/advise/cases.mjs';
import { ask, bruteForce, judge, seeded } from '../../bench/advise/judge.mjs';
import { LONG, advise, checkAdvice } from '../lib/advise.mjs';
import { BINARY } from '../lib/daemon.mjs';

for (const grid of grids.filter((g) => g.sample && !LONG.includes(g.name)))
  test(`${grid.kind}, ${grid.name}: within 2 % of the cheapest, and it holds on other seeds`, () => checkAdvice(grid));

const orbit = {
  scenario: { kind: 'motion', problem: 'kepler', params: { e: 0.45 }, duration_s: 7, methods: [{ method: 'rk4', dt_s: 0.01 }] },
  axes: [
    { path: 'methods.0.method', values: ['explicit_euler', 'velocity_verlet', 'rk4', 'implicit_euler'] },
    { path: 'methods.0.dt_s', values: [0.6, 0.25, 0.1, 0.04, 0.015] },
  ],
  metrics: ['methods.0.e_max', 'methods.0.evaluations'],
};

test('a limit exactly at an error holds, and the next number below it does not', async () => {
  const truth = await bruteForce(BINARY, orbit, 1);
  for (const point of [6, 8, 12]) {
    const limit = truth[point].error,
      alone = {
        ...orbit,
        axes: [
          { path: 'methods.0.method', values: [answerOf(point)[0]] },
          { path: 'methods.0.dt_s', values: [answerOf(point)[1]] },
        ],
      };
    assert.equal((await advise(alone, limit)).advice.error, limit);
    const below = await advise(alone, limit * (1 - 1e-15));
    assert.deepEqual([below.holds, below.advice, below.nearest.error, below.optimum], [false, null, limit, 'proven']);
  }
});
const answerOf = (/** @type {number} */ point) => [orbit.axes[0].values[Math.floor(point / 5)], orbit.axes[1].values[point % 5]];

test('a budget of one advises nothing, a budget beyond the grid proves', async () => {
  const one = await advise(orbit, 0.05, '--runs', '1');
  assert.deepEqual([one.holds, one.advice, one.optimum, one.runs], [false, null, 'best found', 1]);
  const truth = await bruteForce(BINARY, orbit, 1),
    all = await advise(orbit, 0.05, '--runs', '100000');
  assert.equal(all.optimum, 'proven');
  assert.ok(all.runs <= truth.length + 5);
  assert.equal(judge(all, truth, 0.05).regret, 0);
});

test('metrics and costs that are null are not advised, with the reason', async () => {
  const race = {
    scenario: 'race',
    set: { duration_s: 6 },
    repeats: 3,
    axes: [
      { path: 'players.0.dejitter', values: ['none', 'send_time'] },
      { path: 'server.update_hz', values: [12, 24] },
    ],
  };
  const buffered = 'players.0.dejitter.added_mean_ms',
    error = 'players.0.remote_error_m.mean';
  for (const metrics of [
    [buffered, error],
    [error, buffered],
  ]) {
    const answer = await advise({ ...race, metrics }, 1000);
    assert.equal(answer.advice.set['players.0.dejitter'], 'send_time');
    for (const setting of answer.ruled_out.filter((s) => s.set['players.0.dejitter'] === 'none'))
      assert.equal(setting.why, 'a run lacks this error or cost');
  }
  const none = await advise({ ...race, axes: race.axes.slice(1), metrics: [error, buffered] }, 1000);
  assert.deepEqual([none.holds, none.advice, none.nearest, none.front], [false, null, null, []]);
});

test('events that come in bursts are not taken for single ones', async () => {
  const lossy = {
    scenario: 'race',
    set: { duration_s: 6, 'players.0.lag_ms': 90, 'players.0.link.up.loss_pct': 20, 'players.0.link.up.jitter_ms': 15 },
    repeats: 5,
    axes: [
      { path: 'players.0.redundancy', values: [0, 1, 2, 3, 4, 6] },
      { path: 'players.0.slack_ticks', values: [0, 1, 2, 3] },
      { path: 'players.0.send_hz', values: [15, 30, 60] },
    ],
    metrics: ['players.0.visible_corrections', 'players.0.bandwidth.up_bytes_per_s'],
  };
  const limit = 0.0485,
    { advice, optimum } = await advise(seeded(lossy, 2631), limit); // none in 96 runs, where each event of a burst counts as one
  if (!advice) {
    assert.equal(optimum, 'best found');
    return;
  }
  const own = { ...lossy, axes: [], repeats: 700, set: { ...lossy.set, ...advice.set, seed: 80_000_000 } };
  const [point] = JSON.parse(await ask(BINARY, ['sweep', '-', '--points', '--format', 'json'], own));
  assert.ok(point['players.0.visible_corrections'] <= limit, `${point['players.0.visible_corrections']} for ${limit}`);
});

test('an unknown name is reported', () => {
  for (const [metric, value, said] of [
    ['methods.0.e_max', 'rk5', /must be one of .*got "rk5"/],
    ['methods.0.e_mox', 'rk4', /no metric methods\.0\.e_mox/],
  ]) {
    const result = spawnSync(
      BINARY,
      ['advise', '-', '--max-error', '1', '--metric', String(metric), '--vary', `methods.0.method=${value},rk2`],
      { input: JSON.stringify(orbit.scenario), encoding: 'utf8' },
    );
    assert.notEqual(result.status, 0);
    assert.match(result.stderr, /** @type {RegExp} */ (said));
    assert.equal(result.stdout, '');
  }
});
