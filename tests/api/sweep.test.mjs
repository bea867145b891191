// Experiments on the command line: the same rows for any number of jobs, in every format, after a crash and from shards.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { execFileSync, spawn, spawnSync } from 'node:child_process';
import { existsSync, mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { parseCsv } from '../lib/csv.mjs';
import { readReport } from '../lib/report.mjs';
import { stored } from '../lib/store.mjs';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
const BINARY = path.resolve(process.env.LAGLAB_BIN ?? path.join(ROOT, 'build/laglab'));

let folder;
before(() => {
  folder = mkdtempSync(path.join(tmpdir(), 'laglab-sweep-'));
});
after(() => rmSync(folder, { recursive: true, force: true }));

const file = (/** @type {string} */ name) => path.join(folder, name);

/** @param {string[]} args @param {{input?: string, env?: Record<string, string>}} [wish] */
function laglab(args, wish = {}) {
  const result = spawnSync(BINARY, args, {
    cwd: folder,
    input: wish.input ?? '',
    encoding: 'utf8',
    maxBuffer: 1 << 28,
    timeout: 600000,
    env: { ...process.env, ...wish.env },
  });
  assert.equal(result.signal, null, `laglab ${args.join(' ')} ended by ${result.signal}: ${result.stderr}`);
  return result;
}

/** @param {string[]} args @param {{input?: string, env?: Record<string, string>,
 * messages?: RegExp}} [wish] messages: text on standard error */
function good(args, wish) {
  const result = laglab(args, wish);
  assert.equal(result.status, 0, `laglab ${args.join(' ')}: ${result.stderr}`);
  if (wish?.messages) assert.match(result.stderr, wish.messages);
  else assert.equal(result.stderr, '');
  return result.stdout;
}

/** @param {string} name @param {object} experiment */
function write(name, experiment) {
  writeFileSync(file(name), JSON.stringify(experiment));
  return name;
}

// Every type of column; a text with a comma and quotes; a refused row with its sentence.
const mixed = () =>
  write('mixed.json', {
    scenario: { kind: 'motion', problem: 'kepler', duration_s: 2, methods: [{ method: 'rk4' }] },
    set: { title: 'commas, and "quotes"' },
    axes: [
      { path: 'methods.0.method', values: ['rk4', 'velocity_verlet', 'boris'].slice(0, 2) },
      { path: 'methods.0.dt_s', from: 0.001, to: 1, count: 4, scale: 'log' },
      { path: 'duration_s', values: [2, 0.5] },
      { path: 'methods.0.shown', values: [true] },
    ],
    repeats: 2,
    metrics: ['methods.0.e_final', 'methods.0.evaluations', 'methods.0.energy_drift_max'],
  });
const race = (repeats = 6) =>
  write('race.json', {
    scenario: 'race',
    set: { duration_s: 4 },
    axes: [
      { path: 'players.0.lag_ms', values: [0, 100, 200] },
      { path: 'players.0.link.up.jitter_ms', values: [0, 40] },
    ],
    repeats,
    metrics: ['players.0.own_lead_m.mean', 'players.0.bandwidth.down_bytes_per_s'],
  });

test('rows are the same for any number of jobs, from shards, and from standard input', () => {
  const name = race();
  const one = good(['sweep', name, '--jobs', '1']);
  assert.equal(one.split('\r\n').length, 38);
  for (const jobs of ['2', '7']) assert.equal(good(['sweep', name, '--jobs', jobs]), one);
  assert.equal(good(['sweep', '-'], { input: readFileSync(file(name), 'utf8') }), one);
  for (const i of [1, 2, 3]) good(['sweep', name, '--shard', `${i}/3`, '--out', `s${i}.csv`]);
  assert.equal(good(['merge', name, 's3.csv', 's1.csv', 's2.csv']), one);
  good(['sweep', name, '--shard', 'auto', '--out', 's2.csv'], {
    env: { SLURM_ARRAY_TASK_ID: '2', SLURM_ARRAY_TASK_COUNT: '3', SLURM_ARRAY_TASK_MIN: '1' },
  });
  assert.equal(good(['merge', name, 's3.csv', 's1.csv', 's2.csv', 's2.csv']), one, 'a shard run twice is the same shard');
  const missing = laglab(['merge', name, 's1.csv', 's3.csv']);
  assert.equal(missing.status, 2);
  assert.match(missing.stderr, /12 of 36 runs are missing, the first is run 12/);
});

test('shards that a copy cut or an editor changed are refused, and never make two rows into one', () => {
  const name = mixed();
  for (const i of [1, 2]) good(['sweep', name, '--shard', `${i}/2`, '--out', `m${i}.csv`]);
  const whole = readFileSync(file('m1.csv'), 'utf8');
  /** @type {[string, string, RegExp][]} */
  const changed = [
    ['no newline', whole.slice(0, -1), /run \d+ is incomplete/],
    ['no line end', whole.slice(0, -2), /run \d+ is incomplete/],
    ['Unix lines', whole.replace(/\r\n$/, '\n'), /is incomplete/],
    ['a field less', whole.replace(/\r\n0,0,/, '\r\n0,'), /run 0: must have the \d+ fields/],
    ['an open quote', whole.replace(',ok,,', ',ok,",'), /: must have the \d+ fields/],
    ['a NUL', whole.replace(',ok,,', ',ok,\0,'), /: must have the \d+ fields/],
    ['a line end within', whole.replace(/\r\n$/, '\r+x\r\n'), /is incomplete/],
    ['a sign', whole.replace(/\r\n0,/, '\r\n+0,'), /must begin with its run/],
    ['a zero before', whole.replace(/\r\n1,/, '\r\n01,'), /must begin with its run/],
  ];
  for (const [what, text, message] of changed) {
    assert.notEqual(text, whole, what);
    writeFileSync(file('bad.csv'), text);
    const refused = laglab(['merge', name, 'bad.csv', 'm2.csv']);
    assert.equal(refused.status, 2, what);
    assert.match(refused.stderr, message, what);
    assert.equal(refused.stdout, '', what);
  }
  assert.equal(good(['merge', name, 'm1.csv', 'm2.csv']), good(['sweep', name]));
});

test('a metric that was not counted is empty in CSV and null in JSON, and holds no limit', () => {
  const name = write('short.json', {
    scenario: 'race',
    set: { duration_s: 1.5 },
    axes: [{ path: 'players.0.lag_ms', values: [0, 80] }],
    metrics: ['players.0.input_latency_ms.mean', 'players.0.corrections'],
  }); // all within the warm-up
  const messages =
    /duration_s, 1\.5 s, is not longer than warmup_s, 2 s.*\n.*No run has players\.0\.input_latency_ms\.mean: it is null in all 2/;
  const rows = good(['sweep', name], { messages }).trimEnd().split('\r\n'),
    column = rows[0].split(',').indexOf('players.0.input_latency_ms.mean');
  for (const row of rows.slice(1)) {
    assert.equal(row.split(',')[column], '');
    assert.equal(row.split(',')[column + 1], '0');
  }
  for (const row of JSON.parse(good(['sweep', name, '--format', 'json'], { messages })))
    assert.equal(row['players.0.input_latency_ms.mean'], null);
  const [point] = JSON.parse(good(['sweep', name, '--points', '--format', 'json'], { messages }));
  assert.equal(point['players.0.input_latency_ms.mean'], null);
  good(['sweep', name, '--out', 'short.sqlite'], { messages });
  assert.equal(sql('short.sqlite', 'SELECT COUNT(*) FROM results WHERE "players.0.input_latency_ms.mean" IS NULL'), '2');
  good(['sweep', name, '--out', 'short.csv', '--report', 'short.html'], { messages });
  const [text] = readFileSync(file('short.html'), 'utf8').split('<script>\n');
  assert.ok(text.includes('id="head"') && !/NaN|undefined|Infinity/.test(text));
  const answer = JSON.parse(
    good([
      'advise',
      'race',
      '--metric',
      'players.0.input_latency_ms.mean',
      '--max-error',
      '1e9',
      '--vary',
      'players.0.prediction=true,false',
      '--set',
      'duration_s=1.5',
    ]),
  );
  assert.equal(answer.holds, false);
  assert.equal(answer.advice, null);
});

test('the adviser that is asked for a short latency switches prediction on', () => {
  const answer = JSON.parse(
    good([
      'advise',
      'race',
      '--metric',
      'players.0.input_latency_ms.mean',
      '--max-error',
      '40',
      '--vary',
      'players.0.prediction=false,true',
      '--set',
      'duration_s=20',
      '--set',
      'players.0.lag_ms=90',
    ]),
  );
  assert.equal(answer.holds, true);
  assert.equal(answer.advice.set['players.0.prediction'], true);
});

test('columns name every parameter with its unit', () => {
  const [head, first] = good(['sweep', mixed()]).split('\r\n');
  assert.equal(
    head,
    'run,point,repeat,seed,methods.0.method,methods.0.dt_s,duration_s,methods.0.shown,title,status,error,hash,t_s,' +
      'methods.0.e_final,methods.0.evaluations,methods.0.energy_drift_max,version',
  );
  assert.match(first, /^0,0,0,1,rk4,0.001,2,true,"commas, and ""quotes""",ok,,[0-9a-f]{16},2,/);
  const spring = write('g.json', {
    scenario: 'motion/free_fall',
    axes: [{ path: 'params.g', values: [1] }],
    metrics: ['methods.0.e_final'],
  });
  assert.match(good(['sweep', spring]), /^run,point,repeat,seed,params.g_m_per_s2,/);
});

test('all formats hold the same values', () => {
  const name = mixed();
  for (const format of ['csv', 'ndjson', 'json', 'sqlite']) good(['sweep', name, '--out', `r.${format}`]);
  const rows = good(['sweep', name, '--format', 'ndjson'])
    .trim()
    .split('\n')
    .map((line) => JSON.parse(line));
  assert.equal(rows.length, 32);
  assert.ok(rows.some((row) => row.status === 'refused' && row.error.includes('dt_s') && row['methods.0.e_final'] === null));
  assert.deepEqual(JSON.parse(readFileSync(file('r.json'), 'utf8')), rows);
  assert.equal(readFileSync(file('r.ndjson'), 'utf8'), good(['sweep', name, '--format', 'ndjson']));
  const [header = [], ...cells] = parseCsv(readFileSync(file('r.csv'), 'utf8'));
  const types = Object.fromEntries(header.map((column) => [column, typeof rows.find((row) => row[column] !== null)?.[column]]));
  const value = (/** @type {string} */ column, /** @type {string} */ text) =>
    text === '' ? null : types[column] === 'number' ? Number(text) : types[column] === 'boolean' ? text === 'true' : text;
  assert.deepEqual(
    cells.map((row) => Object.fromEntries(row.map((text, i) => [header[i], value(header[i] ?? '', text)]))),
    rows,
  );
  const sqlite = spawnSync('sqlite3', ['-json', file('r.sqlite'), 'SELECT * FROM results ORDER BY run'], { encoding: 'utf8' });
  assert.deepEqual(
    JSON.parse(sqlite.stdout).map((row) => ({ ...row, 'methods.0.shown': row['methods.0.shown'] === 1 })),
    rows,
  );
});

test('points are the means of their runs with spread and 95 % intervals', () => {
  const name = race(11),
    lead = 'players.0.own_lead_m.mean';
  const rows = JSON.parse(good(['sweep', name, '--format', 'json']));
  const points = JSON.parse(good(['sweep', name, '--points', '--format', 'json']));
  const specification = { ...JSON.parse(readFileSync(file(name), 'utf8')), interval: 't' };
  const byT = JSON.parse(good(['sweep', write('race_t.json', specification), '--points', '--format', 'json']));
  assert.equal(points.length, 6);
  for (const [i, point] of points.entries()) {
    const values = rows
      .filter((/** @type {any} */ row) => row.point === point.point)
      .map((/** @type {any} */ row) => row[lead])
      .sort((/** @type {number} */ a, /** @type {number} */ b) => a - b);
    const mean = values.reduce((/** @type {number} */ a, /** @type {number} */ b) => a + b) / 11;
    const deviation = Math.sqrt(
      values.reduce((/** @type {number} */ sum, /** @type {number} */ value) => sum + (value - mean) ** 2, 0) / 10,
    );
    assert.equal(point.runs, 11);
    assert.ok(Math.abs(point[lead] - mean) < 1e-12 && Math.abs(point[`${lead}.sd`] - deviation) < 1e-9);
    assert.ok(Math.abs(point[`${lead}.p25`] - (values[2] + values[3]) / 2) < 1e-9);
    assert.ok(Math.abs(point[`${lead}.p50`] - values[5]) < 1e-9);
    assert.deepEqual([point[`${lead}.p50_low`], point[`${lead}.p50_high`]], [values[1], values[9]]);
    assert.equal(byT[i][`${lead}.ci95_method`], 't');
    assert.match(byT[i][`${lead}.ci95_covers`], /normal values/);
    assert.ok(Math.abs(byT[i][`${lead}.ci95`] - (2.228138852 * deviation) / Math.sqrt(11)) < 1e-9);
    assert.equal(point[`${lead}.ci95_method`], 'bootstrap-t');
    assert.match(point[`${lead}.ci95_covers`], /^(a bound: at least 93 %|93 to 97 %)/);
    assert.ok(point[`${lead}.ci95_low`] < mean && mean < point[`${lead}.ci95_high`]);
    assert.ok(Math.abs(point[`${lead}.ci95_high`] - point[`${lead}.ci95_low`] - 2 * point[`${lead}.ci95`]) < 1e-9);
  }
});

test('a point is run until its mean is known well enough, the same for any number of jobs and from shards', () => {
  const error = 'players.0.remote_error_m.mean',
    until = { half_width: 0.15, least: 10 };
  const name = write('until.json', {
    scenario: 'race',
    set: { duration_s: 4 },
    axes: [{ path: 'players.0.link.down.jitter_ms', values: [0, 10, 150] }],
    repeats: 60,
    until,
    metrics: [error],
  });
  const all = good(['sweep', name, '--jobs', '1']),
    rows = JSON.parse(good(['sweep', name, '--format', 'json']));
  assert.equal(good(['sweep', name, '--jobs', '4']), all);
  for (const shard of [1, 2]) good(['sweep', name, '--shard', `${shard}/2`, '--out', file(`until${shard}.csv`)]);
  assert.equal(good(['merge', name, 'until1.csv', 'until2.csv']), all);
  const points = JSON.parse(good(['sweep', name, '--points', '--format', 'json']));
  for (const point of points) {
    const made = rows.filter((/** @type {any} */ row) => row.point === point.point && row.status === 'ok').length;
    assert.deepEqual([point.runs, point.failed], [made, 0]);
    assert.ok([10, 20, 40, 60].includes(made));
    assert.ok(made === 60 || point[`${error}.ci95`] <= 0.15);
    for (const row of rows) if (row.point === point.point) assert.equal(row.status, row.repeat < made ? 'ok' : 'skipped');
  }
  assert.ok(
    points.some((/** @type {any} */ point) => point.runs < 60),
    'some point has enough',
  );
});

test('sensitivity indices show which axis a metric depends on', () => {
  // free fall for 1 s with Euler steps: the error is g dt / 2 to first order, and does not know of the speed at first
  const sampled = {
    scenario: { kind: 'motion', problem: 'free_fall', duration_s: 1, methods: [{ method: 'explicit_euler', dt_s: 0.01 }] },
    sample: { method: 'saltelli', count: 128 },
    axes: [
      { path: 'methods.0.dt_s', from: 0.001, to: 0.01 },
      { path: 'params.v0', from: 0, to: 5 },
    ],
    metrics: ['methods.0.e_final'],
  };
  const name = write('sampled.json', sampled),
    rows = JSON.parse(good(['sweep', name, '--sensitivity', '--format', 'json']));
  assert.deepEqual(
    rows.map((/** @type {any} */ row) => [row.metric, row.parameter, row.samples]),
    [
      ['methods.0.e_final', 'methods.0.dt_s', 128],
      ['methods.0.e_final', 'params.v0', 128],
    ],
  );
  assert.ok(Math.abs(rows[0].first - 1) < 0.05 && Math.abs(rows[0].total - 1) < 0.05 && rows[0].total_low < 1 && rows[0].total_high > 0.95);
  assert.ok(rows[1].total < 1e-6);
  assert.match(laglab(['sweep', race(), '--sensitivity']).stderr, /saltelli/);
  assert.match(laglab(['sweep', name, '--sensitivity', '--points']).stderr, /--sensitivity: must be without --points/);
});

test('points are compared with one of them by seed', () => {
  const name = race(11),
    lead = 'players.0.own_lead_m.mean';
  const rows = JSON.parse(good(['sweep', name, '--format', 'json']));
  const of = (/** @type {number} */ point) =>
    rows.filter((/** @type {any} */ row) => row.point === point).map((/** @type {any} */ row) => row[lead]);
  const points = JSON.parse(good(['sweep', name, '--points', '--compare', '2', '--format', 'json'])),
    base = of(2);
  for (const point of points) {
    const differences = of(point.point).map((/** @type {number} */ value, /** @type {number} */ i) => value - base[i]);
    const mean = differences.reduce((/** @type {number} */ a, /** @type {number} */ b) => a + b) / 11;
    assert.ok(Math.abs(point[`${lead}.diff`] - mean) < 1e-9);
    assert.equal(point[`${lead}.diff_pairs`], 11);
    assert.equal(point[`${lead}.diff_low`] === null, point.point === 2);
  }
  for (const format of ['csv', 'sqlite'])
    good(['sweep', name, '--points', '--compare', 'first', '--format', format, '--out', file(`compared.${format}`)]);
  assert.match(laglab(['sweep', name, '--compare', 'first']).stderr, /must have --points/);
  assert.match(laglab(['sweep', name, '--points', '--compare', '99']).stderr, /from 0 to 5; got 99/);
});

test('repeats that are all equal give no interval, and say so', () => {
  // frames of random lengths are drawn from the seed, alternating ones are not
  const name = write('frames.json', {
    scenario: {
      kind: 'motion',
      problem: 'kepler',
      duration_s: 3,
      methods: [{ method: 'velocity_verlet', steps: 'frame' }],
      frame_jitter: 0.5,
    },
    axes: [
      { path: 'params.e', values: [0.2, 0.5] },
      { path: 'frames', values: ['alternating', 'random'] },
    ],
    repeats: 11,
    metrics: ['methods.0.e_max', 'methods.0.evaluations'],
  });
  const sweep = laglab(['sweep', name, '--points', '--format', 'json', '--report', file('frames.html')]);
  assert.equal(sweep.status, 0, sweep.stderr);
  assert.match(sweep.stderr, /at 2 of 4 points all repeats gave identical metrics/);
  const points = JSON.parse(sweep.stdout),
    half = 'methods.0.e_max.ci95';
  assert.deepEqual(
    points.map((/** @type {any} */ p) => p.identical),
    [true, false, true, false],
  );
  for (const point of points) {
    assert.equal(point.runs, 11);
    assert.match(
      point[`${half}_method`],
      point.identical ? /^none: all runs gave the same; others are at most 28.5 % of runs$/ : /^bootstrap-t$/,
    );
    if (point.identical) assert.equal(point[half], null);
    else assert.ok(point[half] > 0);
  }
  assert.match(readFileSync(file('frames.html'), 'utf8'), /<p>At 2 of 4 points all repeats gave identical metrics/);
  const csv = laglab(['sweep', name, '--points']).stdout.split('\r\n'),
    column = csv[0].split(',').indexOf(half);
  assert.deepEqual(
    csv.slice(1, 5).map((line) => line.split(',')[column] === ''),
    [true, false, true, false],
  );
  const once = JSON.parse(
    good(
      [
        'sweep',
        write('once.json', { scenario: 'race', set: { duration_s: 1 }, metrics: ['players.0.remote_error_m.mean'] }),
        '--points',
        '--format',
        'json',
      ],
      { messages: /is not longer than warmup_s/ },
    ),
  );
  assert.deepEqual([once[0].identical, once[0]['players.0.remote_error_m.mean.ci95']], [null, null]);
});

test('what scripts did is recorded once and replayed under other techniques', () => {
  const run = (/** @type {string[]} */ ...more) =>
    good(['run', 'contact', '--duration', '9', '--seed', '12', '--set', 'players.1.lag_ms=77', ...more]);
  const persons = ['--set', 'players.0.control=person', '--set', 'players.1.control=person'];
  run('--record-inputs', 'drive.log', '--trace', 'script.csv');
  run(...persons, '--workload', 'drive.log', '--trace', 'person.csv');
  assert.equal(readFileSync(file('person.csv'), 'utf8'), readFileSync(file('script.csv'), 'utf8'));
  assert.equal(JSON.parse(good(['replay', 'drive.log'])).ticks, 540);
  mkdirSync(file('elsewhere/logs'), { recursive: true });
  writeFileSync(file('elsewhere/logs/drive.log'), readFileSync(file('drive.log')));
  const order = (/** @type {object} */ more) => ({
    scenario: 'contact',
    set: { duration_s: 9, 'players.0.control': 'person', 'players.1.control': 'person' },
    axes: [
      { path: 'players.0.prediction', values: [true, false] },
      { path: 'players.1.lag_ms', values: [20, 140] },
    ],
    repeats: 3,
    metrics: ['players.0.game.laps', 'players.0.game.speed_mps', 'players.0.input_latency_ms.mean'],
    workload: 'logs/drive.log',
    ...more,
  });
  const name = write('elsewhere/workload.json', order({})),
    rows = good(['sweep', name, '--jobs', '1']);
  assert.equal(good(['sweep', name, '--jobs', '3']), rows);
  for (const i of [1, 2]) good(['sweep', name, '--shard', `${i}/2`, '--out', `workload${i}.csv`]);
  assert.equal(good(['merge', name, 'workload1.csv', 'workload2.csv']), rows);
  // other inputs are another experiment
  const other = write('other.json', order({ workload: { inputs: [{ tick: 0, player: 0, axes: [0.5, 0] }] } }));
  assert.notEqual(good(['sweep', other], { messages: /No run has players\.0\.input_latency_ms\.mean/ }), rows);
  // the speed at the end is what the players do, for every technique
  const speeds = rows
    .split('\r\n')
    .slice(1, -1)
    .map((row) => row.split(',')[12]);
  assert.ok(
    new Set(
      rows
        .split('\r\n')
        .slice(1, -1)
        .map((row) => row.split(',')[14]),
    ).size > 1,
    'latencies differ',
  );
  assert.ok(speeds.every((speed) => Number(speed) > 0));
  // all workers need is in the specification
  good(['sweep', name, '--dry-run']);
  const bad = (/** @type {object} */ more) => {
    const got = laglab(['sweep', write('bad.json', order(more))]);
    assert.equal(got.status, 2);
    return got.stderr;
  };
  assert.match(bad({}), /workload: cannot read .*logs\/drive\.log/);
  assert.match(bad({ workload: 'drive.log', set: {} }), /workload: no player takes its inputs; set players\.0\.control/);
  assert.match(bad({ workload: { inputs: [{ tick: 0, player: 4, axes: [1, 0] }] } }), /player: must be 0 to 1; got 4/);
  writeFileSync(
    file('broken.log'),
    readFileSync(file('drive.log'), 'utf8')
      .split('\n')
      .map((line, i) => (i === 6 ? line.replace(/"axes":\[[^,]*,/, '"axes":[-3,') : line))
      .join('\n'),
  );
  assert.match(bad({ workload: 'broken.log' }), /workload: line 7 of the log: axes: must be two numbers from -1 to 1; got -3/);
  const advice = JSON.parse(
    good([
      'advise',
      'contact',
      '--set',
      'players.0.control=person',
      '--set',
      'duration_s=4',
      '--workload',
      'drive.log',
      '--metric',
      'players.0.remote_error_m.mean',
      '--max-error',
      '100',
      '--vary',
      'server.update_hz=20,30',
      '--repeats',
      '2',
    ]),
  );
  assert.equal(advice.holds, true);
});

test('a report is one page with all points, the front, and what repeats it', () => {
  const name = write('orbit.json', {
    title: 'Orbit <b>&',
    scenario: { kind: 'motion', problem: 'kepler', params: { e: 0.5 }, duration_s: 5, methods: [{ method: 'rk4' }] },
    axes: [
      { path: 'methods.0.method', values: ['semi_implicit_euler', 'velocity_verlet', 'rk4'] },
      { path: 'methods.0.dt_s', from: 0.001, to: 0.1, count: 6, scale: 'log' },
    ],
    metrics: ['methods.0.e_max', 'methods.0.evaluations'],
  });
  const points = JSON.parse(good(['sweep', name, '--points', '--format', 'json', '--report', 'orbit.html']));
  const page = readFileSync(file('orbit.html'), 'utf8');
  assert.doesNotMatch(page, /<link|src=|href=|url\(|import\b/);
  assert.match(page, /<h1>Orbit &lt;b&gt;&amp;<\/h1>/);
  assert.match(page, /laglab sweep experiment.json/);
  // The front by its definition: no point is as good in both and better in one.
  const at = (point) => [point['methods.0.evaluations'], point['methods.0.e_max']];
  const front = points.filter(
    (a) => !points.some((b) => at(b)[0] <= at(a)[0] && at(b)[1] <= at(a)[1] && (at(b)[0] < at(a)[0] || at(b)[1] < at(a)[1])),
  );
  const { head, columns } = readReport(page);
  assert.deepEqual(
    head.metrics.map((_, m) => columns[`mean ${m}`]),
    head.metrics.map((metric) => points.map((point) => point[metric])),
  );
  const marked = points.filter((_, k) => columns['front 0'][k] === 1);
  assert.deepEqual(marked, front);
  assert.ok(marked.length > 3 && marked.length < 18);
  const specification = /<h2>Specification<\/h2><pre>([\s\S]*?)<\/pre>/
    .exec(page)[1]
    .replaceAll('&quot;', '"')
    .replaceAll('&lt;', '<')
    .replaceAll('&gt;', '>')
    .replaceAll('&amp;', '&');
  assert.equal(good(['sweep', '-'], { input: specification }), good(['sweep', name]), 'its command repeats it');
});

test('a report of many points stays small and has them all', () => {
  const many = {
    title: 'Many',
    scenario: { kind: 'motion', problem: 'oscillator', duration_s: 0.3, methods: [{ method: 'rk4' }] },
    axes: [
      {
        zip: [
          { path: 'methods.0.method', values: ['explicit_euler', 'velocity_verlet'] },
          { path: 'reverse', values: [true, false] },
        ],
      },
      { path: 'methods.0.dt_s', from: 0.01, to: 0.1, count: 150, scale: 'log' },
      { path: 'params.omega', from: 0.5, to: 5, count: 40 },
    ],
    metrics: ['methods.0.e_max', 'methods.0.evaluations'],
  };
  const rows = JSON.parse(good(['sweep', write('many.json', many), '--points', '--format', 'json', '--report', 'many.html']));
  assert.equal(rows.length, 12000);
  const page = readFileSync(file('many.html'), 'utf8'),
    { head, columns } = readReport(page);
  assert.ok(page.length < 2e6, `${page.length} bytes`);
  assert.deepEqual([head.points, head.shown, head.dimensions.length], [12000, 12000, 3], 'what goes together is one');
  for (const [m, metric] of head.metrics.entries())
    for (const [k, row] of rows.entries()) {
      const held = columns[`mean ${m}`][k];
      assert.ok(row[metric] === null ? Number.isNaN(held) : Math.abs(held - row[metric]) <= 1e-6 * Math.abs(row[metric]), `${metric} ${k}`);
    }
  // The front, by its definition.
  const at = (/** @type {any} */ p) => [p['methods.0.evaluations'], p['methods.0.e_max']],
    least = new Map();
  for (const row of rows) {
    const [cost, error] = at(row);
    if (error !== null && !(error > (least.get(cost) ?? Infinity))) least.set(cost, error);
  }
  let best = Infinity;
  const front = new Set(
    [...least]
      .sort(([a], [b]) => a - b)
      .filter(([, error]) => error < best && ((best = error), true))
      .map(String),
  );
  const marked = rows.filter((/** @type {any} */ _, /** @type {number} */ k) => columns['front 0'][k] === 1);
  assert.deepEqual(
    marked,
    rows.filter((/** @type {any} */ row) => front.has(String(at(row)))),
  );
  assert.ok(marked.length > 5);
});

test('a sweep that was killed goes on where it was, and every row is there once', async () => {
  const name = race(300);
  const whole = good(['sweep', name]);
  const begun = spawn(BINARY, ['sweep', name, '--jobs', '2', '--out', 'k.csv'], { cwd: folder, stdio: 'ignore' });
  await stored(file('k.csv'));
  begun.kill('SIGKILL');
  await new Promise((resolve) => begun.once('close', resolve));
  assert.equal(existsSync(file('k.csv')), false, 'no half file');
  good(['sweep', name, '--jobs', '2', '--out', 'k.csv']);
  assert.equal(readFileSync(file('k.csv'), 'utf8'), whole);
  assert.equal(existsSync(file('k.csv.runs')), false);
});

// The version that made a store's rows is altered in it, as if another laglab had been at work.
const OTHER = '0.0.9+0123456789ab',
  OWN = spawnSync(BINARY, ['--version'], { encoding: 'utf8' }).stdout.trim().split(' ')[1];
const sql = (/** @type {string} */ name, /** @type {string} */ text) =>
  execFileSync('sqlite3', ['-cmd', '.timeout 5000', file(name), text], { encoding: 'utf8' }).trim();
const RENAMED = ['experiment', 'chunk', 'result'].map((table) => `UPDATE ${table} SET id=substr(id,1,length(id)-8)||'00000000';`).join('');

test('a sweep that another version began is not gone on with, and its rows stay', async () => {
  const name = race(300);
  const begun = spawn(BINARY, ['sweep', name, '--jobs', '2', '--out', 'v.csv'], { cwd: folder, stdio: 'ignore' });
  await stored(file('v.csv'));
  begun.kill('SIGKILL');
  await new Promise((resolve) => begun.once('close', resolve));
  const rows = sql('v.csv.runs', `UPDATE experiment SET version='${OTHER}';${RENAMED}SELECT count(*) FROM result`);
  assert.ok(Number(rows) > 0, 'it was at work');
  const refused = laglab(['sweep', name, '--out', 'v.csv']);
  assert.equal(refused.status, 2);
  for (const words of [OTHER, OWN, '--anew']) assert.ok(refused.stderr.includes(words), refused.stderr);
  assert.equal(existsSync(file('v.csv')), false);
  assert.equal(sql('v.csv.runs', 'SELECT count(*) FROM result'), rows);
  good(['sweep', name, '--out', 'v.csv', '--anew']);
  assert.equal(readFileSync(file('v.csv'), 'utf8'), good(['sweep', name]), 'all was run again');
});

test('shards of two versions are not merged', () => {
  const name = race();
  for (const i of [1, 2]) good(['sweep', name, '--shard', `${i}/2`, '--out', `w${i}.csv`]);
  writeFileSync(file('w2.csv'), readFileSync(file('w2.csv'), 'utf8').replaceAll(OWN, OTHER));
  const refused = laglab(['merge', name, 'w1.csv', 'w2.csv', '--out', 'w.csv']);
  assert.equal(refused.status, 2);
  for (const words of ['w2.csv', OTHER, OWN]) assert.ok(refused.stderr.includes(words), refused.stderr);
  assert.equal(existsSync(file('w.csv')), false);
});

test('a dry run counts and estimates, and runs nothing', () => {
  const answer = JSON.parse(good(['sweep', race(50), '--dry-run', '--jobs', '2']));
  assert.equal(answer.points, 6);
  assert.equal(answer.runs, 300);
  assert.ok(answer.estimated_s > 0);
});

test('advise answers with a setting that holds, and its evidence', () => {
  const args = ['advise', 'motion/pendulum', '--set', 'methods=[{"method":"rk4"}]', '--set', 'duration_s=5', '--metric', 'methods.0.e_max'];
  const answer = JSON.parse(good([...args, '--max-error', '1e-4']));
  assert.equal(answer.holds, true);
  assert.ok(answer.advice.error <= 1e-4 && answer.runs <= answer.of_runs + 40);
  assert.ok(
    answer.advice.verified.runs >= 1 && answer.advice.verified.error === answer.advice.error && answer.advice.verified.error_ci95 === null,
    'nothing in it is random',
  );
  assert.ok(['proven', 'best found'].includes(answer.optimum));
  assert.ok(answer.front.some((setting) => setting.point === answer.advice.point));
  assert.ok(
    answer.ruled_out.every((setting) =>
      ['the error is above the limit', 'it costs more', 'a run failed', 'not all seeds were run', 'not verified'].includes(setting.why),
    ),
  );
  const run = JSON.parse(
    good([
      'run',
      'motion/pendulum',
      '--set',
      'methods=[{"method":"rk4"}]',
      '--duration',
      '5',
      ...Object.entries(answer.advice.set).flatMap(([key, value]) => ['--set', `${key}=${value}`]),
    ]),
  );
  assert.equal(run.metrics.methods[0].e_max, answer.advice.error, 'what it advises is what a run of it gives');
  const vary = JSON.parse(
    good([...args, '--max-error', '1e-30', '--vary', 'methods.0.dt_s=0.01:0.1:5:log', '--vary', 'methods.0.method=rk4,velocity_verlet']),
  );
  assert.equal(vary.of_runs, 10);
  assert.equal(vary.advice, null);
  assert.equal(vary.optimum, 'proven', 'all ten were tried');
  assert.ok(vary.nearest.error > 1e-30);
});

test('traces are those of the runs alone, end where a run was stopped or before it diverged, the same for any number of jobs', () => {
  const order = {
    scenario: 'race',
    set: { duration_s: 3 },
    axes: [{ path: 'players.0.lag_ms', values: [0, 200] }],
    repeats: 2,
    metrics: ['players.0.own_lead_m.mean'],
    traces: true,
  };
  const base = JSON.parse(readFileSync(path.join(ROOT, 'scenarios/race.json'), 'utf8'));
  good(['sweep', write('traced.json', order), '--out', 'traced.csv']);
  assert.deepEqual(readdirSync(file('traced.csv.traces')).sort(), ['run0.csv', 'run1.csv', 'run2.csv', 'run3.csv']);
  good(['run', '-', '--trace', 'alone.csv', '--duration', '3', '--seed', String((base.seed ?? 1) + 1), '--set', 'players.0.lag_ms=200'], {
    input: JSON.stringify(base),
  });
  assert.equal(readFileSync(file('traced.csv.traces/run3.csv'), 'utf8'), readFileSync(file('alone.csv'), 'utf8'));
  const mixedRuns = write('stops.json', {
    scenario: { kind: 'motion', problem: 'kepler', duration_s: 10, methods: [{ method: 'explicit_euler' }] },
    axes: [
      { path: 'methods.0.dt_s', values: [0.01, 0.6] },
      { path: 'duration_s', values: [10, 0.55] },
    ],
    metrics: ['methods.0.e_final'],
    stop: { metric: 'methods.0.e_final', above: 1e-3, every_s: 0.5 },
  });
  for (const jobs of ['1', '3']) good(['sweep', mixedRuns, '--out', `stops${jobs}.csv`, '--traces', `stops${jobs}`, '--jobs', jobs]);
  assert.deepEqual(readdirSync(file('stops1')), readdirSync(file('stops3')));
  const rows = good(['sweep', mixedRuns])
    .trimEnd()
    .split('\r\n')
    .map((row) => row.split(','));
  const [head] = rows,
    at = (/** @type {string[]} */ row, /** @type {string} */ name) => row[head.indexOf(name)];
  for (const row of rows.slice(1)) {
    const name = file(`stops1/run${row[0]}.csv`);
    if (at(row, 'status') === 'refused') {
      assert.ok(!existsSync(name));
      continue;
    }
    const text = readFileSync(name, 'utf8');
    assert.equal(text, readFileSync(name.replace('stops1', 'stops3'), 'utf8'));
    assert.equal(Number(text.trimEnd().split('\r\n').at(-1)?.split(',')[0]), Number(at(row, 't_s')), 'it ends where the run ended');
  }
  assert.deepEqual([...new Set(rows.slice(1).map((row) => at(row, 'status')))].sort(), ['refused', 'stopped']);
  const body = (/** @type {object} */ more) => ({ type: 'dynamic', shape: 'box', size: [1, 1], position: [0, 5], ...more });
  const lost = good([
    'sweep',
    write('lost.json', {
      scenario: { kind: 'rigid', duration_s: 20, bodies: [body({}), body({ position: [9.9e8, 0], velocity: [1e6, 0] })] },
      axes: [{ path: 'hz', values: [60] }],
      metrics: ['penetration_worst_m'],
    }),
    '--traces',
    'lost',
    '--format',
    'json',
  ]);
  const [row] = JSON.parse(lost),
    last = Number(readFileSync(file('lost/run0.csv'), 'utf8').trimEnd().split('\r\n').at(-1)?.split(',')[0]);
  assert.equal(row.status, 'diverged');
  assert.ok(row.t_s > 5 && Math.abs(row.t_s - last - 1 / 60) < 1e-6, `${row.t_s} after ${last}`);
});

test('advise knows for every kind what may vary and what it costs', () => {
  /** @type {[string, string, string, string, number, string[]?][]} */
  const cases = [
    ['race', 'players.0.own_lead_m.mean', '2', 'players.0.bandwidth.down_bytes_per_s', 7 * 2 * 2 * 2 * 4, ['--set', 'warmup_s=0']],
    ['rigid/pyramid', 'drift_worst_m', '0.01', 'passes_per_s', 7 * 3 * 6], // all solvers
    ['fluid/hydrostatic', 'pressure_error_rms', '0.1', 'cell_visits', 3 * 4 * 3], // of particles: no cells, no pressure solver
    ['fluid/taylor_green', 'error_l2', '1', 'cell_visits', 4 * 6 * 4 * 3, ['--set', 'params.n=16']],
  ];
  for (const [scenario, metric, limit, cost, runs, more = []] of cases) {
    const answer = JSON.parse(good(['advise', scenario, '--metric', metric, '--max-error', limit, '--set', 'duration_s=0.2', ...more]));
    assert.equal(answer.holds, true, scenario);
    assert.equal(answer.cost_metric, cost);
    assert.equal(answer.of_runs, runs, scenario);
    assert.ok(answer.runs <= (scenario === 'race' ? runs : runs + 40)); // with fresh seeds where they matter
  }
});

test('costs that are counted: passes over contacts, visits of cells', () => {
  const pyramid = (/** @type {string[]} */ ...set) =>
    JSON.parse(good(['run', 'rigid/pyramid', '--duration', '0.1', ...set.flatMap((s) => ['--set', s])])).metrics.passes_per_s;
  assert.equal(pyramid('solver.substeps=4'), 60 * 2 * 4);
  assert.equal(pyramid('solver.method=pgs_ngs', 'solver.iterations=10', 'solver.position_iterations=3', 'hz=30'), 30 * (1 + 10 + 3));
  const { metrics } = JSON.parse(
    good(['run', 'fluid/taylor_green', '--duration', '0.1', '--set', 'params.n=16', '--set', 'solver.pressure=multigrid']),
  );
  assert.ok(metrics.sweeps_mean > 1);
  assert.ok(
    Math.abs(metrics.cell_visits - 8 * 256 * Math.round(metrics.cell_visits / 8 / 256)) < 1e-6,
    'a cycle is 8 passes over all cells',
  );
  assert.ok(metrics.cell_visits >= 8 * 256 * metrics.steps);
});

test('every verb prints its usage and options', () => {
  const verbs = [...good(['help']).matchAll(/^ {2}laglab ([a-z-]+)/gm)].map((found) => found[1]);
  assert.ok(verbs.length > 12);
  for (const verb of verbs) assert.match(good([verb, '--help']), new RegExp(`laglab ${verb}`), verb);
  // Each option of a verb has a line; printed options are accepted, and accepted ones are printed.
  for (const verb of ['serve', 'run', 'sweep', 'merge', 'advise']) {
    const printed = [...good([verb, '--help']).matchAll(/^ {2}(--?[a-z-]+)( [A-Z])?.*\n {6}\S/gm)];
    assert.ok(printed.length >= 2, verb);
    for (const [, option, takes] of printed) if (takes) assert.match(laglab([verb, option]).stderr, /needs a value/, `${verb} ${option}`);
    for (const usage of good(['help'])
      .split('\n')
      .filter((line) => line.startsWith(`  laglab ${verb} `)))
      for (const [option] of usage.matchAll(/--?[a-z]+(-[a-z]+)*(?=[ \]]|$)/g))
        assert.ok(
          printed.some((line) => line[1] === option),
          `${verb} ${option}`,
        );
  }
});

test('bad input is a sentence and exit 2', () => {
  const cases = [
    [['sweep'], 'EXPERIMENT: required'],
    [['sweep', 'nosuch.json'], 'nosuch.json'],
    [['sweep', race(), '--jobs', '0'], '--jobs'],
    [['sweep', race(), '--format', 'xls'], 'sqlite'],
    [['sweep', race(), '--shard', '4/3'], '4/3'],
    [['sweep', race(), '--nosuch'], '--nosuch'],
    [['sweep', race(), '--shard', 'auto'], 'SLURM_ARRAY_TASK_ID'],
    [
      [
        'sweep',
        write('big.json', {
          scenario: 'race',
          metrics: ['players.0.corrections'],
          repeats: 100000,
          axes: [{ path: 'players.0.lag_ms', from: 0, to: 1, count: 1000 }],
        }),
      ],
      '1e+08 runs',
    ],
    [['advise', 'race', '--metric', 'players.0.own_lead_m.mean'], '--max-error'],
    [['advise', 'race', '--max-error', '1'], '--metric'],
    [['advise', 'race', '--max-error', '-1'], '-1'],
    [['advise', 'race', '--max-error', '1', '--metric', 'x', '--vary', 'y'], 'path=value'],
    [['advise', race(), '--max-error', '1', '--metric', 'x'], 'an experiment has its own'],
    [
      ['sweep', write('many.json', { scenario: 'race', metrics: ['players.0.corrections'], repeats: 1001, traces: true })],
      'at most 1000 runs; got 1001',
    ],
    [
      ['sweep', write('long.json', { scenario: 'race', metrics: ['players.0.corrections'], repeats: 1001 }), '--traces', 'x'],
      'at most 1000 runs',
    ],
    [
      ['sweep', write('nowhere.json', { scenario: 'race', metrics: ['players.0.corrections'], traces: true })],
      '--traces, or a file by --out',
    ],
    [['sweep', race(), 'other.json'], 'other.json'],
    [['merge', race(), 'nosuch.csv'], 'nosuch.csv'],
  ];
  for (const [args, words] of /** @type {[string[], string][]} */ (cases)) {
    const result = laglab(args);
    assert.equal(result.status, 2, `${args.join(' ')}: ${result.stderr}`);
    assert.match(result.stderr, /^laglab: [^\n]+\n$/);
    assert.ok(result.stderr.includes(words), `${words}: ${result.stderr}`);
    assert.equal(result.stdout, '');
  }
  const full = laglab(['sweep', race(), '--out', '/dev/full/x.csv']);
  assert.equal(full.status, 1);
  assert.match(full.stderr, /\/dev\/full\/x\.csv/);
});
