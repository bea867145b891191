// The example notebook, executed by Jupyter's kernel with Debian's pandas and matplotlib: what its variables then have is compared with
// runs of the program that this test makes by itself. The notebook is committed without outputs: images differ with each version of the
// fonts, and figures that are not computed again grow stale.
import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { before, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { promisify } from 'node:util';
import { connect } from '../../clients/js/laglab.js';
import { BINARY, startDaemon } from '../lib/daemon.mjs';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
const NOTEBOOK = path.join(ROOT, 'clients/python/examples/techniques.ipynb');
const run = promisify(execFile);

const LAG = 'players.0.lag_ms',
  LATENCY = 'players.0.input_latency_ms.mean',
  OWN = 'players.0.own_timeline_error_m.rms',
  OTHERS = 'players.0.remote_error_m.mean';
const METRICS = [LATENCY, OWN, OTHERS];
const SEEDS = 12,
  STUDENT = 2.200985; // quantile 0.975 of Student's t with 11 degrees of freedom

/** As to_json(orient="split") has it. @typedef {{columns: string[], index: unknown[], data: any[][]}} Frame */

/** @param {Frame} frame @returns {Record<string, any>[]} */
const records = (frame) => frame.data.map((row) => Object.fromEntries(row.map((value, i) => [frame.columns[i], value])));

/** @type {{shown: string[][], values: {runs: Frame, points: Frame, difference: Frame, slopes: any}}} */
let made;
before(async () => {
  const { stdout } = await run(
    '/usr/bin/python3',
    ['-B', path.join(ROOT, 'tests/lib/notebook.py'), NOTEBOOK, 'runs', 'points', 'difference', 'slopes'],
    {
      env: { ...process.env, LAGLAB_BIN: BINARY, PYTHONPATH: path.join(ROOT, 'clients/python'), MPLBACKEND: '' },
      maxBuffer: 1 << 26,
    },
  );
  made = JSON.parse(stdout);
});

test('it is ten cells, committed without outputs', () => {
  const { cells } = JSON.parse(readFileSync(NOTEBOOK, 'utf8'));
  assert.equal(cells.length, 10);
  for (const cell of cells.filter((/** @type {any} */ one) => one.cell_type === 'code')) {
    assert.deepEqual(cell.outputs, []);
    assert.equal(cell.execution_count, null);
  }
});

test('each cell of code but the plan and the question shows something, one of them a figure', () => {
  const silent = made.shown.flatMap((kinds, i) => (kinds.length === 0 ? [i] : []));
  assert.deepEqual(silent, [0, 2]);
  assert.equal(made.shown.filter((kinds) => kinds.includes('image/png')).length, 1);
  assert.ok(made.shown.filter((kinds) => kinds.includes('text/html')).length >= 4, JSON.stringify(made.shown));
});

/** @param {string} technique */
const switches = (technique) => {
  const level = ['none', 'prediction', '+ reconciliation', '+ interpolation'].indexOf(technique);
  return ['prediction', 'reconciliation', 'interpolation'].map((name, i) => `players.0.${name}=${level > i}`);
};

/** By the command line, as no client does. @param {string} technique @param {number} lag @param {number} seed */
async function alone(technique, lag, seed) {
  const sets = [
    'players.0.link.up.jitter_ms=20',
    'players.0.link.down.jitter_ms=20',
    'players.0.link.down.loss_pct=2',
    `${LAG}=${lag}`,
    ...switches(technique),
  ];
  const { stdout } = await run(
    BINARY,
    ['run', 'race', '--duration', '10', '--seed', String(seed), ...sets.flatMap((set) => ['--set', set])],
    {
      maxBuffer: 1 << 24,
    },
  );
  const { hash, metrics } = JSON.parse(stdout);
  const at = (/** @type {string} */ where) => where.split('.').reduce((value, part) => value[part], metrics);
  return { hash, values: METRICS.map(at) };
}

const near = (/** @type {number} */ got, /** @type {number} */ expected, /** @type {string} */ what) =>
  assert.ok(Math.abs(got - expected) <= 1e-12 * Math.max(1, Math.abs(expected)), `${what}: ${got}, expected ${expected}`);
const mean = (/** @type {number[]} */ values) => values.reduce((sum, value) => sum + value, 0) / values.length;

test('rows, means and paired differences are those of separate runs', async () => {
  const rows = records(made.values.runs),
    points = records(made.values.points);
  assert.equal(rows.length, 4 * 5 * SEEDS);
  assert.equal(points.length, 4 * 5);
  /** @type {Record<string, number[]>} */
  const others = {};
  for (const technique of ['+ reconciliation', '+ interpolation']) {
    const runs = await Promise.all(
      [...Array(SEEDS)].map(async (_, seed) => {
        const got = await alone(technique, 200, seed + 1);
        const row = rows.find((one) => one.technique === technique && one[LAG] === 200 && one.seed === seed + 1);
        assert.equal(row?.hash, got.hash);
        METRICS.forEach((metric, i) => near(row?.[metric], got.values[i], metric));
        return got.values;
      }),
    );
    const point = points.find((one) => one.technique === technique && one[LAG] === 200);
    METRICS.forEach((metric, i) => near(point?.[metric], mean(runs.map((values) => values[i])), `mean of ${metric}`));
    assert.ok(point?.[`${OTHERS}.ci95_low`] < point?.[OTHERS] && point?.[OTHERS] < point?.[`${OTHERS}.ci95_high`], JSON.stringify(point));
    others[technique] = runs.map((values) => values[2]);
  }
  const differences = others['+ interpolation'].map((value, i) => value - others['+ reconciliation'][i]);
  const middle = mean(differences),
    spread = Math.sqrt(differences.reduce((sum, value) => sum + (value - middle) ** 2, 0) / (SEEDS - 1) / SEEDS);
  const { index, columns, data } = made.values.difference,
    told = data[index.indexOf(200)];
  near(told[columns.indexOf('mean')], middle, 'mean of the differences');
  near(told[columns.indexOf('sem')], spread, 'its standard error');
  assert.equal(told[columns.indexOf('count')], SEEDS);
  assert.ok(middle - STUDENT * spread > 0, 'interpolation shows the others later, beyond chance');
});

test('the comparison is that of the paper', () => {
  const points = records(made.values.points);
  const at = (/** @type {string} */ technique, /** @type {number} */ lag) =>
    /** @type {Record<string, any>} */ (points.find((one) => one.technique === technique && one[LAG] === lag));
  // Without prediction a key is felt after a round trip; with it at once, at any lag.
  assert.ok(at('none', 400)[LATENCY] - at('none', 0)[LATENCY] > 780, JSON.stringify(at('none', 400)));
  for (const technique of ['prediction', '+ reconciliation', '+ interpolation']) {
    assert.ok(at(technique, 400)[LATENCY] < 35, JSON.stringify(at(technique, 400)));
  }
  // Prediction alone drifts from the server; reconciliation takes the error back.
  assert.ok(at('prediction', 200)[OWN] > 2 * at('+ reconciliation', 200)[OWN]);
  // The others are as old as the link makes them, and interpolation adds its delay.
  assert.ok(at('+ interpolation', 50)[OTHERS] > at('+ reconciliation', 50)[OTHERS]);
  const slopes = Object.fromEntries(
    made.values.slopes.index.map((/** @type {string} */ name, /** @type {number} */ i) => [name, made.values.slopes.data[i]]),
  );
  assert.ok(Math.abs(slopes.none - 2) < 0.05 && Math.abs(slopes.prediction) < 0.01, JSON.stringify(slopes));
});

// ---- the same in the other languages ----

const PLAN = JSON.parse(readFileSync(path.join(ROOT, 'clients/r/techniques.json'), 'utf8'));

test('the experiment of the example in R has the runs of the notebook', async () => {
  const { stdout } = await run(BINARY, ['sweep', path.join(ROOT, 'clients/r/techniques.json'), '--format', 'json'], { maxBuffer: 1 << 26 });
  const hashes = (/** @type {Record<string, any>[]} */ rows) => rows.map((row) => row.hash);
  assert.deepEqual(hashes(JSON.parse(stdout)), hashes(records(made.values.runs)));
});

test('the JavaScript client gets the figures of the notebook from a daemon', async () => {
  const daemon = await startDaemon();
  try {
    const lab = await connect(daemon.url);
    const technique = Object.fromEntries(
      ['none', 'prediction', '+ reconciliation', '+ interpolation'].map((name, level) => [
        name,
        Object.fromEntries(['prediction', 'reconciliation', 'interpolation'].map((part, i) => [`players.0.${part}`, level > i])),
      ]),
    );
    const seen = [];
    const points = await lab.sweep('race', {
      set: PLAN.set,
      axes: { technique, [LAG]: [0, 50, 100, 200, 400] },
      repeats: SEEDS,
      metrics: METRICS,
      points: true,
      progress: ({ done, runs }) => seen.push([done, runs]),
    });
    assert.deepEqual(seen.at(-1), [240, 240]);
    const expected = records(made.values.points);
    assert.equal(points.length, expected.length);
    points.forEach((point, i) => {
      assert.equal(point.technique, expected[i]?.technique);
      assert.equal(point[LAG], expected[i]?.[LAG]);
      for (const metric of METRICS)
        for (const column of [metric, `${metric}.ci95_low`, `${metric}.ci95_high`]) {
          if (point[column] === null) assert.equal(expected[i]?.[column], null, column);
          else near(point[column], expected[i]?.[column], column);
        }
    });
  } finally {
    await daemon.stop();
  }
});
