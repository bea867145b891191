// A netgame recovers from its network, seen from outside: random outages compared with an undisturbed twin, clean links that predict
// without an error, waits that add up, and an adviser that draws the right conclusion. Cases are drawn from seeds, so that a failure can be
// had again.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { BINARY } from '../lib/daemon.mjs';

const STEPWISE = ['lockstep', 'lockstep_pipelined'];
const SYNCS = ['free', 'gambetta', 'deterministic', 'rollback', ...STEPWISE];
const PLAYING = 2;

let folder;
before(() => {
  folder = mkdtempSync(path.join(tmpdir(), 'laglab-recovery-'));
});
after(() => rmSync(folder, { recursive: true, force: true }));

/** Numbers from 0 to 1 (mulberry32). @param {number} seed */
function random(seed) {
  return () => {
    seed = (seed + 0x6d2b79f5) | 0;
    let t = Math.imul(seed ^ (seed >>> 15), 1 | seed);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 2 ** 32;
  };
}

/** @param {string[]} args */
function laglab(args) {
  const result = spawnSync(BINARY, args, { cwd: folder, encoding: 'utf8', maxBuffer: 1 << 28, timeout: 600000 });
  assert.equal(result.status, 0, `laglab ${args.join(' ')}: ${result.signal ?? ''} ${result.stderr}`);
  return JSON.parse(result.stdout);
}

/** @param {Record<string, any>} scenario @param {string[]} [more] @returns {any} its metrics */
function metrics(scenario, more = []) {
  writeFileSync(path.join(folder, 'it.json'), JSON.stringify(scenario));
  return laglab(['run', path.join(folder, 'it.json'), ...more]).metrics;
}

/** A run and its trace. @param {Record<string, any>} scenario @returns {{players: any[], column: (name: string) => number[]}} */
function traced(scenario) {
  const file = path.join(folder, 'it.csv');
  const { players } = metrics(scenario, ['--trace', file]);
  const [head, ...rows] = readFileSync(file, 'utf8')
    .trimEnd()
    .split('\n')
    .map((line) => line.split(','));
  return {
    players,
    column: (name) =>
      rows.map((row) => (assert.ok(head.includes(name), name), row[head.indexOf(name)] === '' ? NaN : Number(row[head.indexOf(name)]))),
  };
}

const mean = (/** @type {number[]} */ values) => values.reduce((sum, value) => sum + value, 0) / values.length;

/** A game whose network fails once, and when that is over. */
function outage(/** @type {string} */ sync, /** @type {number} */ seed) {
  const unit = random(seed),
    pick = (/** @type {any[]} */ values) => values[Math.floor(unit() * values.length)];
  const length = 0.1 * 120 ** unit(),
    begin = unit() * 8,
    way = pick([['up'], ['down'], ['up', 'down']]),
    all = unit() < 0.3;
  const count = pick([1, 2, 3]),
    victim = pick([0, count - 1]),
    rate = pick([30, 60, 64]);
  const blackout = { blackout_at_ms: Math.round(begin * 1000), blackout_length_ms: Math.round(length * 1000) };
  const players = Array.from({ length: count }, (_, i) => ({
    lag_ms: Math.floor(unit() * 90),
    prediction: unit() < 0.5,
    reconciliation: true,
    ack: pick(['high_water', 'per_input']),
    input_delay_ticks: ['deterministic', 'rollback'].includes(sync) ? 16 : 0, // so that no client waits on a good link
    link: all || i === victim ? Object.fromEntries(way.map((/** @type {string} */ direction) => [direction, blackout])) : undefined,
  }));
  const slowest = Math.max(...players.map(({ lag_ms }) => lag_ms));
  // 2 s and twice the round trip; under gambetta a lost input is reported one by one only when 64 more were made, at half of the frames
  const single = sync === 'gambetta' && players.some(({ ack }) => ack === 'per_input') ? 160 / rate : 0;
  const heals = begin + length + 2 + (4 * slowest) / 1000 + single;
  return {
    heals,
    scenario: {
      kind: 'netgame',
      game: sync === 'gambetta' ? 'gambetta' : 'race',
      seed: 1 + Math.floor(unit() * 1e6),
      tick_hz: rate,
      warmup_s: 0,
      duration_s: Math.ceil(heals + 8),
      params: sync === 'gambetta' ? undefined : { laps: 1000 },
      server: { sync, update_hz: pick([20, 30]), snapshot_encoding: pick(['full', 'quantised', 'delta']) },
      players,
    },
  };
}

for (const sync of SYNCS) {
  test(`${sync}: after any outage inputs are applied again, and nothing is worse than without`, () => {
    for (let seed = 1; seed <= 8; seed++) {
      const { scenario, heals } = outage(sync, 100 * seed + sync.length),
        what = `${sync}, case ${seed}`;
      const twin = { ...scenario, players: scenario.players.map(({ link: _, ...player }) => player) };
      const hit = traced(scenario),
        well = traced(twin);
      const from = hit.column('time_s').findIndex((time) => time >= heals);
      // What a turn is shared by: ticks of the clients, and a server that steps when inputs come, may meet another way than in the twin.
      const turn = 1000 / scenario.tick_hz + (sync === 'free' ? 0 : 1000 / scenario.server.update_hz / 2);
      const applied = (/** @type {any} */ run, /** @type {any} */ of) => {
        // inputs since the deadline, by player
        const until = metrics({ ...of, duration_s: Math.round(heals * 1000) / 1000 }).players;
        return run.players.map(
          (/** @type {any} */ player, /** @type {number} */ i) => player.inputs.results.applied - until[i].inputs.results.applied,
        );
      };
      const now = applied(hit, scenario),
        usually = applied(well, twin);
      hit.players.forEach((player, i) => {
        const { made, open, refused, late, lost } = player.inputs.results;
        assert.equal(made, open + player.inputs.results.applied + refused + late + lost, `${what}: every input has one result`);
        assert.equal(player.validation.false_refusals, 0, `${what}: no honest input is refused`);
        assert.ok(
          hit
            .column(`player_${i}_connection`)
            .slice(from)
            .every((state) => state === PLAYING),
          `${what}: player ${i} plays`,
        );
        for (const [name, allowed] of /** @type {[string, number][]} */ ([
          ['unacked', 1],
          ['view_age_ms', turn],
        ])) {
          const [is, would] = [hit, well].map((run) => mean(run.column(`player_${i}_${name}`).slice(from)));
          if (Number.isNaN(would)) continue; // no other player is there
          assert.ok(Math.abs(is - would) <= 0.1 * would + allowed, `${what}: player ${i}, ${name} ${is}, without outage ${would}`);
        }
        assert.ok(
          usually[i] > 0 && now[i] > 0.9 * usually[i] - 2,
          `${what}: player ${i}, ${now[i]} inputs applied, without outage ${usually[i]}`,
        );
      });
    }
  });
}

test('an outage is over for all when one has joined again, however states travel', () => {
  for (const sync of ['free', ...STEPWISE]) {
    for (const snapshot of ['full', 'quantised', 'delta']) {
      for (const direction of ['up', 'down']) {
        const link = { [direction]: { blackout_at_ms: 2500, blackout_length_ms: 6200 } };
        const { column } = traced({
          kind: 'netgame',
          game: 'race',
          seed: 8,
          duration_s: 20,
          server: { sync, snapshot_encoding: snapshot },
          players: [{ lag_ms: 15, link }, { lag_ms: 25 }],
        });
        const steps = column('server_step'),
          time = column('time_s');
        const made = (/** @type {number} */ from, /** @type {number} */ to) =>
          steps[time.findIndex((t) => t >= to)] - steps[time.findIndex((t) => t >= from)];
        const [before, then] = [made(0.5, 2.5), made(17, 19)];
        assert.ok(
          Math.abs(then - before) <= 0.1 * before + 1,
          `${sync}, ${snapshot}, ${direction}: ${then} steps in 2 s, ${before} before the outage`,
        );
      }
    }
  }
});

test('prediction with reconciliation is exact on a clean link, at every lag', () => {
  for (let seed = 1; seed <= 20; seed++) {
    const unit = random(9000 + seed),
      pick = (/** @type {any[]} */ values) => values[Math.floor(unit() * values.length)];
    const scenario = {
      kind: 'netgame',
      game: pick(['race', 'gambetta']),
      seed,
      duration_s: 8,
      tick_hz: pick([20, 60, 64, 128]),
      server: { sync: pick(['free', 'free', ...STEPWISE]), update_hz: pick([5, 10, 20]) },
      players: Array.from({ length: 1 + Math.floor(unit() * 4) }, () => ({
        lag_ms: pick([0, 1000, unit() * 1000]),
        prediction: true,
        reconciliation: true,
        prediction_scope: pick(['own', 'contacts', 'all']),
        display_hz: pick([0, 31, 144]),
        input_delay_ticks: pick([0, 0, 5]),
      })),
    };
    for (const { own_timeline_error_m: error, corrections } of metrics(scenario).players) {
      assert.ok(error.count > 0);
      assert.equal(error.max, 0, JSON.stringify(scenario));
      assert.equal(corrections, 0, JSON.stringify(scenario));
    }
  }
});

test('without prediction a change is seen after the round trip and the waits for step, update and display', () => {
  const TICK = 1000 / 60;
  for (const [lag, phase, update, slack] of [
    [37, 0.25, 60, 1],
    [111, 0.7, 60, 0],
    [240, 0.45, 30, 2],
    [5.5, 0.9, 20, 1],
  ]) {
    const { input_latency_ms: told } = metrics({
      kind: 'netgame',
      game: 'race',
      seed: 5,
      duration_s: 30,
      params: { laps: 1000 },
      server: { update_hz: update },
      players: [{ lag_ms: lag, clock_phase: phase, slack_ticks: slack }],
    }).players[0];
    // The first step not before its arrival, and the slack; then at most an update's interval; then the way back, and the next display.
    const first = Math.max(1, Math.ceil((phase * TICK + lag) / TICK - 1e-9)) + slack;
    const shown = (/** @type {number} */ sent) => Math.ceil((sent + lag) / TICK - phase - 1e-9) * TICK; // from the display at the input
    const soonest = shown(first * TICK),
      latest = shown(first * TICK + 1000 / update - TICK);
    assert.ok(told.count > 20 && told.lost_ratio === 0);
    assert.ok(
      told.mean > soonest - 1e-3 && told.max < latest + 1e-3,
      `${lag} ms: ${told.mean} to ${told.max}, not ${soonest} to ${latest}`,
    );
    if (update === 60) assert.ok(Math.abs(told.mean - soonest) < 1e-3, `${lag} ms: ${told.mean}, not ${soonest}`);
  }
});

test('the adviser that is asked for the smallest latency under a limit of corrections switches prediction on', () => {
  for (const [metric, limit] of [
    ['players.0.visible_corrections_per_s', 0.2],
    ['players.0.corrections_per_s', 1],
    ['players.0.own_timeline_error_m.rms', 0.05],
  ]) {
    const { advice } = laglab([
      'advise',
      'race',
      '--metric',
      String(metric),
      '--max-error',
      String(limit),
      '--cost',
      'players.0.input_latency_ms.mean',
      '--vary',
      'players.0.prediction=false,true',
      '--set',
      'players.0.lag_ms=130',
      '--set',
      'duration_s=10',
      '--repeats',
      '2',
    ]);
    assert.deepEqual(advice.set, { 'players.0.prediction': true });
    assert.equal(advice.cost, 0);
  }
});

test('lag of each millisecond, clocks in any phase: input latency is a line; in one phase it is a staircase', () => {
  const sweep = (/** @type {Record<string, any>} */ player, /** @type {number} */ repeats) => {
    const experiment = {
      scenario: { kind: 'netgame', game: 'race', seed: 21, duration_s: 4, warmup_s: 0.5, server: { update_hz: 60 }, players: [player] },
      axes: [{ path: 'players.0.lag_ms', from: 0, to: 300, count: 76 }],
      repeats,
      metrics: ['players.0.input_latency_ms.mean'],
    };
    writeFileSync(path.join(folder, 'sweep.json'), JSON.stringify(experiment));
    return laglab(['sweep', path.join(folder, 'sweep.json'), '--points', '--format', 'json']).map((/** @type {any} */ row) => [
      row['players.0.lag_ms'],
      row['players.0.input_latency_ms.mean'],
    ]);
  };
  const line = sweep({}, 24),
    stairs = sweep({ clock_phase: 0 }, 1),
    TICK = 1000 / 60;
  const offset = mean(line.map(([lag, felt]) => felt - 2 * lag));
  for (const [lag, felt] of line) assert.ok(Math.abs(felt - 2 * lag - offset) < TICK / 2, `${lag} ms: ${felt}, not ${2 * lag + offset}`);
  for (const [lag, felt] of stairs)
    assert.ok(Math.abs(felt / TICK - Math.round(felt / TICK)) < 1e-3, `${lag} ms: ${felt} is no whole number of ticks`);
  assert.ok(new Set(stairs.map(([, felt]) => felt.toFixed(3))).size < 25);
});
