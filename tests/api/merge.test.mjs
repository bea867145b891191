// `laglab merge`: shards, also killed ones that were run again, give the bytes of one sweep in every output.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { spawn, spawnSync } from 'node:child_process';
import { existsSync, mkdirSync, mkdtempSync, readFileSync, readlinkSync, rmSync, statSync, symlinkSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { waitFor } from '../lib/client.mjs';
import { BINARY } from '../lib/daemon.mjs';

let folder;
before(() => {
  folder = mkdtempSync(path.join(tmpdir(), 'laglab-merge-'));
});
after(() => rmSync(folder, { recursive: true, force: true }));

const file = (/** @type {string} */ name) => path.join(folder, name);
const read = (/** @type {string} */ name) => readFileSync(file(name));

/** @param {string[]} args @param {string} [cwd] */
function laglab(args, cwd = folder) {
  const result = spawnSync(BINARY, args, { cwd, encoding: 'utf8', maxBuffer: 1 << 28, timeout: 600000 });
  assert.equal(result.signal, null, `laglab ${args.join(' ')} ended by ${result.signal}: ${result.stderr}`);
  return result;
}

/** @param {string[]} args @param {string} [cwd] */
function good(args, cwd) {
  const result = laglab(args, cwd);
  assert.equal(result.status, 0, `laglab ${args.join(' ')}: ${result.stderr}`);
  return result;
}

/** @param {RegExp} message @param {string[]} args */
function refused(message, args) {
  const result = laglab(args);
  assert.equal(result.status, 2, `laglab ${args.join(' ')}: ${result.stdout}`);
  assert.match(result.stderr, message);
  assert.equal(result.stdout, '');
}

/** @param {string} name @param {object} experiment */
function write(name, experiment) {
  writeFileSync(file(name), JSON.stringify(experiment));
  return name;
}

/** @param {string} name @param {number} count */
function shards(name, count) {
  const made = Array.from({ length: count }, (_, i) => `${name}.${i + 1}.csv`);
  for (const [i, out] of made.entries()) good(['sweep', name, '--shard', `${i + 1}/${count}`, '--out', out]);
  return made;
}

const FORMATS = ['csv', 'ndjson', 'json', 'sqlite'];
const TABLES = [[], ['--points'], ['--points', '--compare', '1']];

/** Outputs of one sweep and of a merge, with the same names of files, and what they say on the way.
 * @param {string} name @param {string[]} parts @param {string[][]} tables */
function compare(name, parts, tables) {
  const inputs = parts.map((part) => `../${part}`);
  for (const place of ['swept', 'merged']) mkdirSync(file(place), { recursive: true });
  for (const wish of tables)
    for (const format of FORMATS) {
      const outputs = ['--out', `out.${format}`, ...(format === 'csv' ? ['--report', 'out.html'] : [])];
      const one = good(['sweep', `../${name}`, ...wish, ...outputs], file('swept')),
        merged = good(['merge', `../${name}`, ...inputs, ...wish, ...outputs], file('merged'));
      assert.equal(merged.stderr, one.stderr, `${name} ${wish.join(' ')}`);
      for (const output of [`out.${format}`, 'out.html'])
        assert.ok(read(`merged/${output}`).equals(read(`swept/${output}`)), `${name} ${wish.join(' ')}: ${output}`);
    }
}

const LAG = 'players.0.lag_ms',
  ERROR = 'players.0.remote_error_m.mean';
/** @param {object} [more] */
const race = (more) => ({
  scenario: 'race',
  set: { duration_s: 3 },
  axes: [{ path: LAG, values: [0, 80, 160] }],
  repeats: 12,
  metrics: [ERROR, 'players.0.bandwidth.down_bytes_per_s'],
  ...more,
});

/** @type {Record<string, object>} */
const EXPERIMENTS = {
  // a refused and a diverged run have sentences with commas, the title has quotes
  failed: {
    scenario: { kind: 'motion', problem: 'kepler', duration_s: 2, methods: [{ method: 'rk4' }] },
    set: { title: '=commas, and "quotes"' },
    axes: [
      { path: 'methods.0.method', values: ['rk4', 'velocity_verlet', 'explicit_euler'] },
      { path: 'methods.0.dt_s', from: 0.001, to: 1, count: 4, scale: 'log' },
      { path: 'duration_s', values: [2, 0.5] },
    ],
    repeats: 2,
    metrics: ['methods.0.e_final', 'methods.0.evaluations', 'methods.0.energy_drift_max'],
  },
  diverged: {
    scenario: { kind: 'motion', problem: 'pendulum', duration_s: 20, methods: [{ method: 'explicit_euler' }, { method: 'rk4' }] },
    axes: [{ path: 'methods.0.dt_s', from: 0.01, to: 2, count: 8, scale: 'log' }],
    repeats: 2,
    metrics: ['methods.0.e_max', 'methods.1.e_max'],
  },
  until: race({ set: { duration_s: 4 }, repeats: 40, until: { half_width: 0.15, least: 10 } }),
  windows: race({
    windows: [
      { name: 'late', from_s: 2.5, to_s: 3 },
      { name: 'stale', while: { value: 'player_1_age_of_information_ms', above: 250 } },
    ],
    metrics: [`${ERROR}@late`, 'counted_s@stale'],
  }),
  stopped: race({ stop: { metric: 'players.0.bandwidth.down_bytes_per_s', above: 3000, every_s: 0.5 } }),
  sobol: race({ axes: [{ path: LAG, from: 0, to: 200 }], sample: { method: 'sobol', count: 8 }, repeats: 3 }),
  lhs: race({
    axes: [
      { path: LAG, from: 0, to: 200 },
      { path: 'players.0.prediction', values: [true, false] },
    ],
    sample: { method: 'lhs', count: 7, seed: 3 },
    repeats: 3,
  }),
};
for (const [what, experiment] of Object.entries(EXPERIMENTS))
  test(`all outputs are those of one sweep: ${what}`, () => {
    const name = write(`${what}.json`, experiment);
    compare(name, shards(name, 5).reverse(), TABLES);
  });

test('the experiments have the rows that they are for', () => {
  const status = (/** @type {string} */ name) =>
    new Set(
      [
        ...read(`${name}.json.5.csv`)
          .toString()
          .matchAll(/,(ok|stopped|diverged|failed|skipped),/g),
      ].map((m) => m[1]),
    );
  assert.ok(status('diverged').has('diverged') && status('stopped').has('stopped'));
  assert.ok([1, 2, 3, 4, 5].some((i) => read(`until.json.${i}.csv`).includes(',skipped,')));
});

test('sensitivity from shards', () => {
  const name = write('saltelli.json', {
    scenario: { kind: 'motion', problem: 'free_fall', duration_s: 1, methods: [{ method: 'explicit_euler', dt_s: 0.01 }] },
    sample: { method: 'saltelli', count: 32 },
    axes: [
      { path: 'methods.0.dt_s', from: 0.001, to: 0.01 },
      { path: 'params.v0', from: 0, to: 5 },
    ],
    metrics: ['methods.0.e_final'],
  });
  compare(name, shards(name, 3), [[], ['--sensitivity']]);
});

test('a file of all rows is a shard; shards may be more than runs', () => {
  const name = write('few.json', race({ repeats: 2 }));
  good(['sweep', name, '--out', 'few.csv']);
  compare(name, ['few.csv'], TABLES);
  assert.equal(good(['merge', name, ...shards(name, 9)]).stdout, read('few.csv').toString());
});

test('16 shards, some killed midway and run again: the bytes of one sweep', async () => {
  const name = write('killed.json', race({ repeats: 900, set: { duration_s: 2.5 } })),
    parts = Array.from({ length: 16 }, (_, i) => `killed.${i + 1}.csv`),
    command = (/** @type {number} */ i) => ['sweep', name, '--jobs', '1', '--shard', `${i + 1}/16`, '--out', parts[i]];
  for (const i of [1, 6, 7, 15]) {
    const worker = spawn(BINARY, command(i), { cwd: folder, stdio: 'ignore' }),
      kept = file(`${parts[i]}.runs-wal`),
      ended = new Promise((resolve) => worker.on('exit', (code, signal) => resolve(signal ?? code)));
    await waitFor(() => existsSync(kept) && statSync(kept).size > 100000, 'some rows');
    worker.kill('SIGKILL');
    assert.equal(await ended, 'SIGKILL', 'it was at work');
    assert.equal(existsSync(file(parts[i])), false, 'there is no part of an output');
  }
  refused(/cannot read killed\.1\.csv/, ['merge', name, ...parts]);
  for (const suffix of ['', '-wal', '-shm']) rmSync(file(`${parts[6]}.runs${suffix}`), { force: true }); // this one begins again
  for (let i = 0; i < 16; i++) good(command(i));
  const order = [...parts.slice(5).reverse(), ...parts.slice(0, 5)];
  compare(name, order, TABLES);
});

test('rows of another experiment are refused, with the row, the column and both values', () => {
  const name = write('own.json', race({ repeats: 2 })),
    [first, second] = shards(name, 2);
  /** @type {[string, object, RegExp][]} */
  const others = [
    [
      'values',
      { axes: [{ path: LAG, values: [0, 90, 160] }] },
      /the row of run 2: players\.0\.lag_ms: must be `80` in this experiment; got `90`/,
    ],
    ['fixed values', { set: { duration_s: 4 } }, /the row of run 0: duration_s: must be `3` in this experiment; got `4`/],
    ['repeats', { repeats: 3 }, /the row of run 2: point: must be `1` in this experiment; got `0`/],
    ['metrics', { metrics: [ERROR] }, /must have the header of this experiment's runs in CSV/],
  ];
  for (const [what, more, message] of others) {
    const [foreign] = shards(write('other.json', race({ repeats: 2, ...more })), 1);
    refused(message, ['merge', name, foreign, second]);
    assert.match(laglab(['merge', name, foreign]).stderr, /another experiment/, what);
  }
  const rows = read(first).toString();
  /** @type {[string, string, RegExp][]} */
  const changed = [
    ['seed', rows.replace('\r\n0,0,0,1,', '\r\n0,0,0,5,'), /run 0: seed: must be `1` in this experiment; got `5`/],
    ['digits', rows.replace(',7408,', ',7408.0,'), /run 0: players\.0\.bandwidth\.down_bytes_per_s: must be/],
    ['status', rows.replace(',ok,', ',well,'), /run 0: status: must be `ok` in this experiment; got `well`/],
    ['quotes', rows.replace(',ok,', ',"ok",'), /run 0: must have quotes only where they are needed/],
    ['hash', rows.replace(/,ok,,\w/, ',ok,,X'), /run 0: hash: must be/],
    ['no version', rows.replace(/,[^,]*\r\n$/, ',\r\n'), /must end with the version/],
  ];
  for (const [what, text, message] of changed) {
    assert.notEqual(text, rows, what);
    writeFileSync(file('changed.csv'), text);
    refused(message, ['merge', name, 'changed.csv', second]);
  }
});

test('a shard twice is that shard, but not with other rows; a missing one is counted', () => {
  const name = write('twice.json', race({ repeats: 2 })),
    [first, second] = shards(name, 2);
  assert.equal(good(['merge', name, second, first, first]).stdout, good(['sweep', name]).stdout);
  writeFileSync(
    file('twice.csv'),
    read(first)
      .toString()
      .replace(/,ok,,\w{16}/, ',ok,,0123456789abcdef'),
  );
  refused(/twice\.csv: run 0 differs between two shards/, ['merge', name, first, 'twice.csv', second]);
  refused(/3 of 6 runs are missing, the first is run 3/, ['merge', name, first, '--points']);
  refused(/6 of 6 runs are missing/, ['merge', name]);
});

test('what is no table of runs in CSV is refused', () => {
  const name = write('kinds.json', race({ repeats: 2 }));
  for (const [out, ...wish] of [['kinds.json.json'], ['kinds.sqlite'], ['kinds.csv', '--points']]) {
    good(['sweep', name, ...wish, '--out', out]);
    refused(/must have the header of this experiment's runs in CSV/, ['merge', name, out]);
  }
  refused(/cannot read nosuch\.csv/, ['merge', name, 'nosuch.csv']);
});

test('a shard gives rows, and says which results need all of them', () => {
  const name = write('part.json', race());
  for (const wish of [['--points'], ['--points', '--compare', 'first'], ['--report', 'part.html']])
    refused(new RegExp(`${wish[0]}: must be without --shard, since it uses all runs; give it to laglab merge`), [
      'sweep',
      name,
      '--shard',
      '1/2',
      ...wish,
    ]);
  refused(/--sensitivity: must be without --shard/, ['sweep', 'saltelli.json', '--shard', '1/2', '--sensitivity']);
  refused(/--compare: must have --points/, ['merge', name, 'part.csv', '--compare', 'first']);
  refused(/saltelli/, ['merge', name, 'part.csv', '--sensitivity']);
});

test('an output replaces no input, no device and no link', () => {
  const name = write('outputs.json', race({ repeats: 2 })),
    parts = shards(name, 2),
    rows = good(['sweep', name]).stdout;
  for (const [verb, inputs] of /** @type {[string, string[]][]} */ ([
    ['merge', parts],
    ['sweep', []],
  ])) {
    refused(/--out: must be another file than the input outputs\.json/, [verb, name, ...inputs, '--out', name]);
    refused(/--report: must be another file than the input outputs\.json/, [verb, name, ...inputs, '--report', name]);
  }
  refused(new RegExp(`--out: must be another file than the input ${parts[1]}`), ['merge', name, ...parts, '--out', `./${parts[1]}`]);
  const piped = spawnSync('sh', ['-c', `'${BINARY}' merge ${name} ${parts.join(' ')} --out /dev/stdout | cat`], {
    cwd: folder,
    encoding: 'utf8',
  });
  assert.equal(piped.stdout, rows, piped.stderr);
  symlinkSync('target.csv', file('link.csv'));
  for (const [verb, inputs] of /** @type {[string, string[]][]} */ ([
    ['merge', parts],
    ['sweep', []],
  ])) {
    writeFileSync(file('target.csv'), 'before');
    good([verb, name, ...inputs, '--out', 'link.csv']);
    assert.equal(readlinkSync(file('link.csv')), 'target.csv');
    assert.equal(read('target.csv').toString(), rows, verb);
  }
});
