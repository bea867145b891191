// The paper's claims as experiments: what each of scenarios/experiments is for shows in its rows. claims.all.test.mjs has the longest.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { readFileSync, readdirSync } from 'node:fs';
import { along, points, rises } from '../lib/claims.mjs';

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
  const rows = points('dejitter');
  for (const row of rows) {
    // A client looks once in 1/60 s, so a state may be half of that later without being late.
    const wanted = Math.max(0, 1 - (row['players.0.dejitter_ms'] + 1000 / 120) / 490);
    const found = row['players.0.dejitter.late_ratio'];
    assert.ok(
      Math.abs(found - wanted) < 0.01 + 1.5 * row['players.0.dejitter.late_ratio.ci95'],
      `${row['players.0.dejitter_ms']} ms: ${found}, not ${wanted}`,
    );
  }
  assert.equal(rows.at(-1)['players.0.dejitter.underruns'], 0);
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

test('iterations against the drift of a stack: each doubling more than halves it', () => {
  const rows = points('stack_iterations');
  for (const method of ['pgs', 'pgs_ngs']) {
    const drift = along(rows, { 'solver.method': method }, 'drift_worst_m');
    for (let i = 1; i < drift.length; i++) assert.ok(drift[i] < (i < 3 ? 1 : 0.5) * drift[i - 1], `${method}: ${drift}`);
    assert.ok(drift[0] > 50 * drift[5]);
  }
});

test('every experiment of the library is checked', () => {
  const at = (/** @type {string} */ name) => new URL(name, import.meta.url),
    texts = ['claims.test.mjs', 'claims.all.test.mjs'].map((name) => readFileSync(at(name), 'utf8')).join(),
    checked = [...texts.matchAll(/points\('(\w+)'\)/g)].map(([, name]) => name);
  const all = readdirSync(at('../../scenarios/experiments'))
    .map((name) => name.replace('.json', ''))
    .filter((name) => !name.startsWith('published_')); // those are in published.test.mjs
  assert.deepEqual(checked.sort(), all.sort());
});
