// The paper's claims as experiments: what each of scenarios/experiments is for shows in its rows.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { spawnSync } from 'node:child_process';
import { readdirSync } from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { BINARY } from '../lib/daemon.mjs';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
const checked = new Set();

/** @param {string} name @returns {Record<string, any>[]} a row per point */
function points(name) {
  const result = spawnSync(BINARY, ['sweep', `experiments/${name}`, '--points', '--format', 'json'], { encoding: 'utf8', timeout: 600000 });
  assert.equal(result.status, 0, result.stderr);
  checked.add(name);
  return JSON.parse(result.stdout);
}

/** @param {Record<string, any>[]} rows @param {Record<string, any>} values @param {string} metric */
const along = (rows, values, metric) =>
  rows.filter((row) => Object.entries(values).every(([key, value]) => row[key] === value)).map((row) => row[metric]);
const rises = (/** @type {number[]} */ values) => values.every((value, i) => i === 0 || value >= values[i - 1]);

test('error against dt: the slope of each integrator is its order', () => {
  const rows = points('integrators');
  for (const [method, order, from, to] of /** @type {[string, number, number, number][]} */ ([
    ['semi_implicit_euler', 1, 0, 3],
    ['velocity_verlet', 2, 0, 6],
    ['rk4', 4, 2, 6],
  ])) {
    const errors = along(rows, { 'methods.0.method': method }, 'methods.0.e_final');
    for (let i = from; i < to; i++) {
      const slope = Math.log2(errors[i + 1] / errors[i]); // dt doubles
      assert.ok(Math.abs(slope - order) < 0.1 * order, `${method}: slope ${slope} at ${i}`);
    }
  }
  const at = (method) => along(rows, { 'methods.0.method': method }, 'methods.0.e_final')[3];
  assert.ok(
    at('explicit_euler') > 100 * at('semi_implicit_euler') &&
      at('semi_implicit_euler') > 10 * at('velocity_verlet') &&
      at('velocity_verlet') > 1e4 * at('rk4'),
  );
});

test('de-jitter delay against late states: U(10, 500) ms leaves 1 - d / 490 of them late', () => {
  for (const row of points('dejitter')) {
    // A client looks once in 1/60 s, so a state may be half of that later without being late.
    const wanted = Math.max(0, 1 - (row['players.0.dejitter_ms'] + 1000 / 120) / 490);
    const found = row['players.0.dejitter.late_ratio'];
    assert.ok(
      Math.abs(found - wanted) < 0.01 + 1.5 * row['players.0.dejitter.late_ratio.ci95'],
      `${row['players.0.dejitter_ms']} ms: ${found}, not ${wanted}`,
    );
  }
  assert.equal(points('dejitter').at(-1)['players.0.dejitter.underruns'], 0);
});

test('lag against what is felt and seen: prediction takes the round trip out of the own car', () => {
  const rows = points('lag_techniques');
  for (const row of rows) {
    const lag = row['players.0.lag_ms'],
      felt = row['players.0.input_latency_ms.mean'];
    if (row['players.0.prediction']) assert.equal(felt, 0);
    else assert.ok(felt > 2 * lag && felt < 2 * lag + 60, `${lag} ms: ${felt}`); // and a tick of server, snapshot and client
  }
  for (const row of rows) {
    const lead = row['players.0.own_lead_ms.mean'],
      lag = row['players.0.lag_ms'],
      right = row['players.0.reconciliation'];
    if (right || !row['players.0.prediction'])
      assert.equal(row['players.0.own_timeline_error_m.rms'], 0); // the display is right at its tick
    else if (lag > 0) assert.ok(row['players.0.own_timeline_error_m.rms'] > 0);
    assert.ok(right ? lead >= lag && lead < lag + 50 : lag === 0 || lead <= -lag / 2, `${lag} ms: ${lead}`);
  }
  const others = (interpolation) =>
    along(rows, { 'players.0.reconciliation': true, 'players.0.interpolation': interpolation }, 'players.0.remote_error_m.mean');
  others(true).forEach((error, i) => assert.ok(error > others(false)[i]));
});

test('loss against lockstep: all wait, and with a free server or buckets none', () => {
  const rows = points('lockstep_loss');
  const pipelined = { 'server.sync': 'lockstep_pipelined' };
  const stalled = along(rows, pipelined, 'server.stalled_s'),
    pace = along(rows, pipelined, 'server.steps_per_s');
  assert.ok(rises(stalled) && stalled[2] > 3 * stalled[0] && stalled[7] > 30 * stalled[0], String(stalled));
  assert.ok(pace[0] - pace[2] < 0.2, `with two in ten lost the steps are late, not fewer: ${pace}`);
  assert.ok(pace[7] < pace[0] - 3, String(pace));
  for (const sync of ['free', 'bucket']) assert.ok(along(rows, { 'server.sync': sync }, 'server.stalled_s').every((value) => value === 0));
  assert.ok(along(rows, { 'server.sync': 'bucket' }, 'server.steps_per_s').every((value) => value > 29.9));
});

test('rewind limit: more hits behind cover, fewer hits that do not count', () => {
  const rows = points('rewind_cover');
  const behind = along(rows, {}, 'players.1.shots.hitscan.shot_behind_cover'),
    missed = along(rows, {}, 'players.1.shots.hitscan.false_misses');
  // without rewinding only a victim that is hit while its own view, ahead of the server, shows it hidden
  assert.ok(rises(behind) && behind[0] < 0.5 && behind[6] > 20, String(behind));
  assert.ok(missed[0] > 50 && missed[6] === 0, String(missed));
});

test('relay or mesh: without the wait rollbacks are shorter, and no client stalls for longer', () => {
  const rows = points('topologies');
  const of = (/** @type {string} */ metric) =>
    ['relay', 'mesh'].map((way) => along(rows, { 'peers.topology': way }, `players.1.${metric}`));
  const [[relayed, direct], [waited, never]] = [of('rollback.ticks_max'), of('stalls.stalled_s')];
  for (let i = 0; i < 4; i++) assert.ok(direct[i] < relayed[i] - 1 && never[i] === 0, `${direct} and ${relayed}`);
  assert.ok(waited[3] > 1 && never[4] < waited[4] / 5, `${never} and ${waited}`);
  const [up, down] = [of('bandwidth.up_bytes_per_s'), of('bandwidth.down_bytes_per_s')];
  assert.ok(up[1].every((value, i) => value < 1.2 * up[0][i]) && down[1].every((value, i) => value > 2 * down[0][i]), `${up} and ${down}`);
});

test('policies of lag compensation: the shooter bears the lag, its victims, or both by its amount', () => {
  const rows = points('lag_policies');
  const of = (/** @type {string} */ policy, /** @type {string} */ metric) =>
    along(rows, { 'server.hitscan': policy }, `players.1.shots.${metric}`);
  const [none, rewind, hybrid, veto] = ['none', 'rewind', 'hybrid', 'victim_veto'].map((policy) => ({
    favour: of(policy, 'hitscan.favour_the_shooter'),
    longest: of(policy, 'behind_cover_ms.max'),
    hits: of(policy, 'behind_cover_ms.count'),
  }));
  assert.ok(none.favour[4] < none.favour[0] - 0.3, String(none.favour));
  assert.ok(rewind.favour.every((value) => value > 0.99) && rises(rewind.longest), String(rewind.longest));
  assert.ok(hybrid.favour[0] === rewind.favour[0] && hybrid.favour[4] === none.favour[4], String(hybrid.favour));
  for (let i = 0; i < 5; i++) {
    assert.ok(hybrid.favour[i] >= none.favour[i] && hybrid.favour[i] <= rewind.favour[i]);
    // A's own two ways of 40 ms, the grace of 100 ms, four ticks and an update
    assert.ok(veto.longest[i] <= 280 && veto.hits[i] <= rewind.hits[i], String(veto.longest));
  }
});

test('iterations against the drift of a stack: each doubling more than halves it', () => {
  const rows = points('stack_iterations');
  for (const method of ['pgs', 'pgs_ngs']) {
    const drift = along(rows, { 'solver.method': method }, 'drift_worst_m');
    for (let i = 1; i < drift.length; i++) assert.ok(drift[i] < (i < 3 ? 1 : 0.5) * drift[i - 1], `${method}: ${drift}`);
    assert.ok(drift[0] > 50 * drift[5]);
  }
});

test('transports against loss: one stream holds up what is behind a lost message, datagrams do not', () => {
  const rows = points('transports'),
    loss = 'players.0.link.up.loss_pct',
    T = 1000 / 30;
  const age = (/** @type {string} */ transport, part = 'mean') =>
    along(rows, { 'server.transport': transport }, `players.0.age_of_information_ms.${part}`);
  const pct = along(rows, { 'server.transport': 'udp' }, loss);
  assert.deepEqual(pct, [0, 0.5, 1, 2, 3, 5]);
  for (const transport of ['tcp', 'quic', 'webrtc'])
    assert.ok(Math.abs(age(transport)[0] - age('udp')[0]) < 1e-6, `without loss ${transport} is as fast as udp`);
  for (const [i, percent] of pct.entries()) {
    // The newest of states that arrive every T, each with probability 1 - p: mean age d + T / 2 (1 + p) / (1 - p).
    const p = percent / 100,
      more = (T / 2) * ((1 + p) / (1 - p) - 1);
    for (const transport of ['udp', 'webrtc'])
      assert.ok(Math.abs(age(transport)[i] - age(transport)[0] - more) < 0.4, `${transport} ${percent} %: ${age(transport)}`);
    if (i > 0) assert.ok(age('tcp')[i] > age('quic')[i] && age('quic')[i] > age('udp')[i] + 1, `${percent} %`);
    // A lost state is sent again when three later ones were acknowledged: it and those behind it are up to 3 T + R late.
    if (i > 0) assert.ok(age('tcp', 'p99')[i] > age('tcp', 'p99')[0] + 0.5 * (3 * T + 100));
  }
});

test('every experiment of the library is checked', () => {
  const all = readdirSync(path.join(ROOT, 'scenarios/experiments'))
    .map((name) => name.replace('.json', ''))
    .filter((name) => !name.startsWith('published_')); // those are in published.test.mjs
  assert.deepEqual([...checked].sort(), all.sort());
});
