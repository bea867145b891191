// What is measured of a run is what GET /api/v1/metrics says: each member of the metrics is a row of a table, with its type, null only
// where the row says when; and every row occurs in a run.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { execFileSync } from 'node:child_process';
import { client } from '../lib/client.mjs';
import { BINARY, startDaemon } from '../lib/daemon.mjs';
import { checkMetrics, metricsOf } from '../lib/metrics.mjs';
import { metricRow } from '../../www/js/base/metrics.js';

/** @typedef {import('../lib/metrics.mjs').Row} Row */
/** @typedef {import('../lib/metrics.mjs').Table} Table */

let daemon, c, kinds, common;
before(async () => {
  daemon = await startDaemon();
  c = client(daemon.url);
  ({ kinds, common } = (await c.get('/api/v1/metrics')).json);
});
after(async () => {
  c.close();
  await daemon.stop();
});

test('the tables are those of the program, and of all kinds', () => {
  const own = JSON.parse(execFileSync(BINARY, ['schema', 'metrics'], { encoding: 'utf8' }));
  assert.deepEqual(own, { kinds, common });
  assert.deepEqual(
    kinds.map((/** @type {any} */ kind) => kind.kind),
    ['netgame', 'motion', 'rigid', 'fluid'],
  );
});

/** Which have most rows for their time: these first, others when a row is not among theirs. metrics.all.test.mjs runs all. */
const FIRST = `position_reports motion/accumulator victim_veto published/thin_streams fluid/sea_tiled fluid/poiseuille dejitter_500 mesh
  motion/penalty_floor dead_reckoning_dis motion/bounce aim_bot swarm_interest motion/far_from_origin desync_float fluid/cavity dam_watched
  sea_watched fluid/dam_break fluid/hydrostatic motion/clock_drift cannon_drag fluid/rotation stack_watched`.split(/\s+/);

test('each metric of a run is a row, and every row is a metric of one, in runs until each was there', async (t) => {
  const { scenarios } = (await c.get('/api/v1/scenarios')).json;
  const place = ({ id }) => (FIRST.includes(id) ? FIRST.indexOf(id) : FIRST.length);
  scenarios.sort((one, other) => place(one) - place(other));
  t.diagnostic(`${await checkMetrics(scenarios, { kinds, common })} runs`);
});

/** Paths of all numbers. @param {any} value @param {string[]} path @returns {string[]} */
const paths = (value, path) =>
  value !== null && typeof value === 'object'
    ? Object.entries(value).flatMap(([name, part]) => paths(part, [...path, name]))
    : [path.join('.')];

test('the page finds the row of each number that a run has, and none elsewhere', async () => {
  for (const [name, kind] of [
    ['rifle', 'netgame'],
    ['motion/orbit', 'motion'],
    ['rigid/warm_start', 'rigid'],
    ['fluid/cavity', 'fluid'],
  ]) {
    const all = paths(await metricsOf(name), []);
    assert.ok(all.length > 30, name);
    for (const path of all) assert.ok(metricRow({ kinds, common }, kind, path), `${name}: ${path}`);
    for (const path of ['', 'no_such', `${all[0]}.no_such`, 'players.0.name.mean', `x.${all[0]}`])
      assert.equal(metricRow({ kinds, common }, kind, path), undefined, path);
  }
  assert.equal(metricRow({ kinds, common }, 'netgame', 'players.1.remote_error_m.p95')?.unit, 'm');
  assert.equal(metricRow({ kinds, common }, 'rigid', 'side_by_side.0.energy_change_j')?.signed, true);
});

test('the rows say which metrics are signed and which are rare', () => {
  const row = (/** @type {string} */ kind, /** @type {string} */ path, /** @type {string} */ name) =>
    kinds
      .find((/** @type {any} */ one) => one.kind === kind)
      .tables.filter((/** @type {Table} */ table) => table.path === path)
      .flatMap((/** @type {Table} */ table) => table.metrics)
      .find((/** @type {Row} */ one) => one.name === name);
  assert.equal(row('rigid', '', 'energy_change_j').signed, true);
  assert.equal(row('rigid', '', 'drift_m').signed, undefined);
  assert.equal(row('netgame', 'players.*', 'visible_corrections').rare, true);
  assert.equal(row('netgame', 'players.*', 'corrections').rare, undefined);
  assert.deepEqual(
    ['visible_corrections_per_s', 'visible_corrections'].map((name) => row('netgame', 'players.*', name).rate),
    [true, undefined],
  );
});
