// The published results that docs/published.md compares with: the statements of the papers hold in shorter runs of the same experiments.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { readFileSync, readdirSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { BINARY } from '../lib/daemon.mjs';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
const checked = new Set();

/** Runs an experiment of the library with other settings. @param {string} name @param {(spec: any) => void} change
 * @returns {Record<string, any>[]} a row per run */
function rowsOf(name, change) {
  const spec = JSON.parse(readFileSync(path.join(ROOT, `scenarios/experiments/${name}.json`), 'utf8'));
  change(spec);
  const result = spawnSync(BINARY, ['sweep', '-', '--format', 'json'], { input: JSON.stringify(spec), encoding: 'utf8', timeout: 600000 });
  assert.equal(result.status, 0, result.stderr);
  checked.add(name);
  const rows = JSON.parse(result.stdout);
  assert.ok(rows.every((/** @type {{status: string}} */ { status }) => status === 'ok'));
  return rows;
}

/** Leaves the values at these places of an axis, or of all axes of a zip. @param {any} axis @param {number[]} places */
function keep(axis, places) {
  for (const one of axis.zip ?? [axis]) one.values = places.map((place) => one.values[place]);
}

const sum = (/** @type {number[]} */ values) => values.reduce((total, value) => total + value, 0);

test('Bettner and Terrano: positions of some 250 units fill a modem, orders do not grow with the units', () => {
  const MODEM = 3600; // bytes a second: 28.8 kbit/s
  const rows = rowsOf('published_archers', (spec) => {
    spec.set = { duration_s: 8 };
    keep(spec.axes[1], [0, 2, 4]);
  });
  const down = (/** @type {string} */ sync, /** @type {string} */ encoding) =>
    rows
      .filter((row) => row['server.sync'] === sync && row['server.snapshot_encoding'] === encoding)
      .map((row) => row['players.0.bandwidth.down_bytes_per_s']);
  const orders = down('deterministic', 'full');
  assert.equal(new Set(orders).size, 1, `${orders}`);
  assert.ok(orders[0] < MODEM, `${orders}`);
  for (const encoding of ['full', 'quantised', 'delta']) {
    const [none, some, most] = down('free', encoding);
    assert.ok(Math.abs((most - none) / (some - none) - 2) < 0.1, `${encoding}: ${[none, some, most]} is linear`);
    const fit = (240 * (MODEM - none)) / (most - none);
    if (encoding === 'full') assert.ok(fit < 25, `${fit}`);
    else assert.ok(fit > 125 && fit < 500, `${encoding}: ${fit} units, within a factor of two of 250`);
  }
  for (const row of rows.filter((one) => one['server.sync'] === 'deterministic')) {
    assert.ok(Math.abs(row['players.0.input_latency_ms.mean'] - 400) < 1, `${row['players.0.input_latency_ms.mean']} ms`);
    assert.ok(row['server.steps_per_s'] > 14.5, `${row['server.steps_per_s']}`);
  }
});

test('Lee and Chang: nine in ten shots behind cover go, and the other hits stay', () => {
  const rows = rowsOf('published_shot_behind_cover', (spec) => {
    Object.assign(spec, { repeats: 4, set: { duration_s: 60 } });
    keep(spec.axes[0], [0, 1, 2, 3]);
    keep(spec.axes[1], [0, 2, 4]);
  });
  const of = (/** @type {string} */ policy, /** @type {number} */ grace, /** @type {string} */ metric, lag = 0) =>
    sum(
      rows
        .filter(
          (row) =>
            row['server.hitscan'] === policy && row['policies.veto_grace_ms'] === grace && (lag === 0 || row['players.1.lag_ms'] === lag),
        )
        .flatMap((row) => [1, 3].map((player) => row[`players.${player}.shots.hitscan.${metric}`])),
    );
  const BEHIND = 'shot_behind_cover',
    HITS = 'hits_on_players';
  const rewound = of('rewind', 100, BEHIND),
    fair = of('rewind', 100, HITS) - rewound;
  assert.ok(rewound > 200 && fair > 200, `${rewound}, ${fair}`);
  assert.ok(of('rewind', 100, BEHIND, 250) > 2 * of('rewind', 100, BEHIND, 50), 'more with more lag');
  const left = [100, 50, 0].map((grace) => of('victim_veto', grace, BEHIND));
  assert.ok(left[0] < 0.5 * rewound && left[1] < left[0] && left[2] < left[1], `${rewound}: ${left}`);
  const fewer = 1 - of('victim_veto', 0, BEHIND, 250) / of('rewind', 100, BEHIND, 250);
  assert.ok(Math.abs(fewer - 0.941) < 0.04, `${fewer} fewer`);
  for (const [i, grace] of [100, 50, 0].entries()) {
    const stays = (of('victim_veto', grace, HITS) - left[i]) / fair;
    assert.ok(stays > 0.95 && stays < 1.05, `${grace} ms: ${stays}`);
  }
});

test('Griwodz and Halvorsen: with fewer than four packets in flight losses wait for the timer, else fast retransmit repairs them', () => {
  const rows = rowsOf('published_thin_streams', (spec) => {
    Object.assign(spec, { repeats: 4, set: { duration_s: 300 } });
    keep(spec.axes[0], [2]);
    keep(spec.axes[1], [0, 2, 5]);
  });
  const RTT = 100,
    TIMER = 200,
    LOSS = 0.01;
  /** Mean extra latency where a lost message is sent again after so long, and those behind it wait. @param {number} after
   * @param {number} interval */
  const extraOf = (after, interval) => {
    const waiting = Math.ceil(after / interval);
    return LOSS * (waiting * after - (interval * waiting * (waiting - 1)) / 2);
  };
  for (const [hz, byTimer] of /** @type {[number, boolean][]} */ ([
    [10, true],
    [20, false],
    [60, false],
  ])) {
    const here = rows.filter((row) => row['server.update_hz'] === hz),
      of = (/** @type {string} */ metric) => sum(here.map((row) => row[`players.0.transport_down.${metric}`])) / here.length;
    const interval = (1000 * 298) / of('messages'),
      extra = of('latency_ms.mean') - RTT / 2,
      [timer, fast] = [extraOf(TIMER + RTT - interval, interval), extraOf(RTT + 3 * interval, interval)];
    assert.equal(TIMER / interval < 4, byTimer, `${TIMER / interval} packets in the time of the timer`);
    const [near, far] = byTimer ? [timer, fast] : [fast, timer];
    assert.ok(Math.abs(extra - near) < 0.5 * Math.abs(far - near), `${hz} updates/s: ${extra} ms; timer ${timer}, fast retransmit ${fast}`);
    if (byTimer) assert.ok(of('timeouts') > 0.7 * LOSS * (of('packets') - of('ack_packets')), 'a time-out for each loss');
  }
});

test('every published result of the library is checked', () => {
  const all = readdirSync(path.join(ROOT, 'scenarios/experiments'))
    .map((name) => name.replace('.json', ''))
    .filter((name) => name.startsWith('published_'));
  assert.deepEqual([...checked].sort(), all.sort());
});
