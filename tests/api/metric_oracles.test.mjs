// Metrics whose values only the page reads, compared with a closed form, with a count of another kind, or with what must be conserved.
// A metric that no other test names has a check here, or fails the first test.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync, readdirSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { ROOT } from '../lib/cli.mjs';
import { BINARY } from '../lib/daemon.mjs';
import { metricsOf } from '../lib/metrics.mjs';

const near = (/** @type {number} */ value, /** @type {number} */ wanted, tolerance = 1e-9) =>
  assert.ok(Math.abs(value - wanted) <= tolerance, `${value}, not ${wanted} within ${tolerance}`);
const within = (/** @type {number} */ value, /** @type {number} */ low, /** @type {number} */ high) =>
  assert.ok(value >= low && value <= high, `${value}, not from ${low} to ${high}`);

const S = 10, // of each game
  LOSSY = { warmup_s: 0, 'players.0.lag_ms': 0, 'players.0.link.up.delay_ms': 120, 'players.0.link.up.loss_pct': 20 };

/** What is checked: names of metrics, and how. @type {Record<string, {names: string, check: () => Promise<void>}>} */
const CHECKS = {
  'rates are their counts over the time': {
    names: 'count_per_s starved_per_s',
    async check() {
      const { rollback } = (await metricsOf('rollback', S, { warmup_s: 0 })).players[0],
        { inputs } = (await metricsOf('race', S, LOSSY)).players[0];
      assert.ok(rollback.count > 0 && inputs.starved_steps > 0);
      near(rollback.count_per_s * S, rollback.count);
      near(inputs.starved_per_s * S, inputs.starved_steps);
    },
  },
  'a clock that is set over unequal ways is off by half of the difference': {
    names: 'clock_error_ms clock_snaps',
    async check() {
      for (const [name, sign] of /** @type {[string, number][]} */ ([
        ['up', 1],
        ['down', -1],
      ])) {
        const { connection } = (await metricsOf('race', S, { 'players.0.lag_ms': 0, [`players.0.link.${name}.delay_ms`]: 120 })).players[0];
        near(connection.clock_error_ms, (sign * 120) / 2, 1e-6);
        assert.equal(connection.clock_snaps, 0, 'which it cannot know');
      }
    },
  },
  'lost packets are those of the bursts, which single losses of p make as long as 1 / (1 - p)': {
    names: 'loss_burst_mean_packets',
    async check() {
      const { link_up: up } = (await metricsOf('race', 60, LOSSY)).players[0];
      near(up.loss_burst_mean_packets * up.loss_bursts, up.lost);
      within(up.loss_burst_mean_packets, 1.15, 1.35);
    },
  },
  'packets that do not meet are in the queue for their own bits': {
    names: 'queue_mean_ms',
    async check() {
      const { link_up: up, bandwidth } = (await metricsOf('race', S, { 'players.0.link.up.rate_kbps': 100 })).players[0],
        packets_per_s = bandwidth.input.packets_per_s + bandwidth.ping.packets_per_s;
      near(up.queue_mean_ms, (8 * bandwidth.up_bytes_per_s) / packets_per_s / 100, 0.02); // more pings come at the beginning
    },
  },
  'a replay has the inputs of a round trip': {
    names: 'inputs_per_s',
    async check() {
      const { replay } = (await metricsOf('race', S, LOSSY)).players[0];
      within(replay.inputs_per_s / replay.replays_per_s, 0.12 * 60, 0.12 * 60 + 4);
    },
  },
  'inputs that the client takes as skipped are late or lost ones': {
    names: 'skipped_per_s',
    async check() {
      const { acks, inputs } = (await metricsOf('race', S, LOSSY)).players[0];
      within(acks.skipped_per_s * S, 1, inputs.results.late + inputs.results.lost);
      assert.equal((await metricsOf('race', S, { warmup_s: 0 })).players[0].acks.skipped_per_s, 0, 'without loss');
    },
  },
  'snapshots without a baseline: all of the encoding full, few of deltas': {
    names: 'full_ratio',
    async check() {
      assert.equal((await metricsOf('race', S)).players[0].snapshot.full_ratio, 1);
      within((await metricsOf('crates_delta', S)).players[0].snapshot.full_ratio, 0, 0.2);
    },
  },
  'an implicit step of Newton has one Jacobian and one factorisation, an explicit one has none': {
    names: 'jacobians factorisations',
    async check() {
      const of = async (/** @type {string} */ method) =>
          (await metricsOf('motion/spring', 1, { methods: [{ method, dt_s: 0.02 }] })).methods[0],
        [implicit, explicit] = [await of('implicit_euler'), await of('rk4')];
      assert.deepEqual([implicit.steps, implicit.jacobians, implicit.factorisations], [50, 50, 50]);
      assert.deepEqual([explicit.steps, explicit.jacobians, explicit.factorisations], [50, 0, 0]);
    },
  },
  'where a solution and steps come from': {
    names: 'solution_by steps_by',
    async check() {
      const { methods } = JSON.parse(readFileSync(path.join(ROOT, 'scenarios/motion/accumulator.json'), 'utf8')),
        found = await metricsOf('motion/accumulator', 1);
      assert.equal(found.solution_by, 'formula');
      for (const [i, { steps }] of methods.entries())
        assert.equal(
          found.methods[i].steps_by,
          ['frame', 'accumulator'].find((name) => name === steps),
          `method ${i}`,
        );
      const pendulum = { kind: 'motion', problem: 'double_pendulum', duration_s: 1, methods: [{ method: 'rk4', dt_s: 0.01 }] };
      assert.equal((await metricsOf(pendulum, 1)).solution_by, 'integration');
    },
  },
  'alarms: of an honest player all are false, of one that cheats all the time none; the first has a time': {
    names: 'false_alarms first_alarm_s',
    async check() {
      const [honest, cheat] = (await metricsOf('aim_bot', 60)).players;
      for (const kind of ['rate', 'reaction', 'aim']) {
        assert.equal(honest.detection[kind].false_alarms, honest.detection[kind].alarms, kind);
        assert.equal(cheat.detection[kind].false_alarms, 0, kind);
        for (const { detection } of [honest, cheat]) {
          const { alarms, first_alarm_s: first } = detection[kind];
          assert.equal(first === null, alarms === 0, kind);
          if (first !== null) within(first, 0, 60);
        }
      }
      assert.ok(cheat.detection.aim.alarms > 0);
    },
  },
  'a field that differs is never farther off than at most, and one that does not is not': {
    names: 'ulps_1s ulps_10s',
    async check() {
      const [same, other] = (await metricsOf('desync_float', 20)).players;
      assert.deepEqual([same.desync.tick, same.desync.ulps_1s, same.desync.ulps_10s], [-1, 0, 0]);
      assert.ok(other.desync.tick >= 0);
      for (const name of ['ulps_1s', 'ulps_10s']) within(other.desync[name], 1, other.desync.ulps_max);
    },
  },
  'a pyramid of rows of boxes': {
    names: 'mean_height_m',
    async check() {
      const { game } = (await metricsOf('stack_watched', 0.02)).players[0],
        rows = game.top_m + 0.5; // boxes of 1 m
      const row = Array.from({ length: rows }, (_, i) => ({ boxes: rows - i, height: i + 0.5 })),
        boxes = row.reduce((sum, { boxes: n }) => sum + n, 0);
      near(game.mean_height_m, row.reduce((sum, { boxes: n, height }) => sum + n * height, 0) / boxes, 1e-3);
    },
  },
  'a boat floats on the water under it': {
    names: 'water_m heave_m pitch_rad',
    async check() {
      const waters = (await metricsOf('sea_watched', 5)).players.map(({ game }) => {
        near(game.heave_m, game.water_m, 0.5);
        within(Math.abs(game.pitch_rad), 0, 0.5);
        return game.water_m;
      });
      assert.equal(new Set(waters).size, waters.length, 'each at its place');
    },
  },
  'the game counts the shots that are judged; each is rewound as far as its view was old, or less': {
    names: 'rifle_shots rifle_hits shell_shots shell_hits shots_within_max_rewind',
    async check() {
      for (const scenario of ['rifle', 'hybrid_rewind', 'rifle_no_rewind'])
        for (const { game, shots } of (await metricsOf(scenario, S, { warmup_s: 0 })).players) {
          const {
            shots: count,
            compensated_hits: hits,
            shots_within_max_rewind: whole,
            clamped,
            view_time_rejected: other,
          } = shots.hitscan;
          assert.ok(count > 0 && hits > 0);
          assert.deepEqual([game.rifle_shots, game.rifle_hits, game.shell_shots, game.shell_hits], [count, hits, 0, 0], scenario);
          assert.equal(whole + clamped + other, scenario === 'rifle_no_rewind' ? 0 : count, scenario);
        }
      for (const { game, shots } of (await metricsOf('cannon_drag', 20, { warmup_s: 0 })).players) {
        assert.deepEqual([game.rifle_shots, game.rifle_hits], [0, 0]);
        within(game.shell_shots - shots.projectile.shots, 0, 4); // on their flight
        within(game.shell_hits - shots.projectile.compensated_hits, 0, 4);
        assert.ok(game.shell_hits > 0 && game.shell_hits <= game.shell_shots);
      }
    },
  },
  'what is in the de-jitter buffer: how many come in a second, times how long they stay (Little), and half of the one that has come': {
    names: 'depth_mean',
    async check() {
      const { dejitter } = (await metricsOf('dejitter_500', 20, { warmup_s: 0 })).players[0];
      near(dejitter.depth_mean, ((dejitter.states / 20) * dejitter.added_mean_ms) / 1000 + 0.5, 0.15);
    },
  },
  'water that begins to fall': {
    names: 'water_speed_mps',
    async check() {
      for (const t of [0.05, 0.1]) within((await metricsOf('dam_watched', t)).players[0].game.water_speed_mps, 0.5 * 9.81 * t, 9.81 * t);
    },
  },
  'the distance in the false hits of one pair': {
    names: 'gap_mean_m',
    async check() {
      const body = { shape: 'circle', radius: 0.5 };
      const { volumes } = await metricsOf(
        {
          kind: 'rigid',
          gravity: [0, 0],
          compare_volumes: true,
          bodies: [
            { type: 'static', shape: 'box', size: [9, 1] },
            { type: 'dynamic', ...body, position: [0, 1.25] },
          ],
        },
        0.1,
      );
      const loose = Object.values(volumes).filter(({ false_hits: n }) => n > 0);
      assert.ok(loose.length > 0);
      for (const volume of loose) near(volume.gap_mean_m, 1.25 - 0.5 - 0.5, 1e-9);
    },
  },
};

/** Those that have no check yet. A new metric gets one. */
const OPEN = `visible_correction_arcmin input_delay_changes lead_ticks deep_rollback_ratio gain_over_honest_m allowance_used_m end_m
  seen_second near_error_m far_error_m connections_ended miss_m pressing ghia_error_max`.split(/\s+/);

/** The text of all files below a folder with such names. @param {string} folder @param {RegExp} names @returns {string} */
const textOf = (folder, names) =>
  readdirSync(path.join(ROOT, folder), { withFileTypes: true })
    .map((entry) => {
      const at = path.join(folder, entry.name);
      if (entry.isDirectory()) return textOf(at, names);
      return names.test(entry.name) && at !== 'tests/api/metric_oracles.test.mjs' ? readFileSync(path.join(ROOT, at), 'utf8') : '';
    })
    .join('\n');

test('each metric that no other test names is checked here', () => {
  const words = new Set((textOf('tests', /\.(c|mjs|py)$/) + textOf('scenarios', /json$/) + textOf('www/lessons', /json$/)).match(/\w+/g)),
    { kinds, common } = JSON.parse(execFileSync(BINARY, ['schema', 'metrics'], { encoding: 'utf8' })),
    names = [...kinds.flatMap(({ tables }) => tables), ...common].flatMap(({ metrics }) => metrics.map(({ name }) => name)),
    here = new Set([...Object.values(CHECKS).flatMap((one) => one.names.split(' ')), ...OPEN]);
  assert.ok(names.length > 300);
  assert.deepEqual(
    [...new Set(names)].filter((name) => !words.has(name) && !here.has(name)),
    [],
    'no test names these',
  );
  assert.deepEqual(
    [...here].filter((name) => !names.includes(name)),
    [],
    'there are no such metrics',
  );
});

for (const [what, { names, check }] of Object.entries(CHECKS)) test(`${what} (${names})`, check);
