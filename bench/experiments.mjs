// Sweeps: what a second thread brings, what the store costs, and a large sweep in little memory.
// Wall time is what a person waits; CPU time does not depend on other load.
import { spawn } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { cpus, tmpdir } from 'node:os';
import { join } from 'node:path';
import { build, digits, interleave, laglab, median, printTable, range, run, say, writeCsv } from './lib.mjs';

const quick = process.argv.includes('--quick');
const rounds = quick ? 3 : 9;
const RUN_MS = 10;
const bare = join(build, 'bench', 'experiments');
const folder = mkdtempSync(join(tmpdir(), 'laglab-bench-'));
process.on('exit', () => rmSync(folder, { recursive: true, force: true }));
const file = (name) => join(folder, name);
const write = (name, experiment) => {
  writeFileSync(file(name), JSON.stringify(experiment));
  return file(name);
};

/** Wall and CPU time of `laglab sweep` and the most memory that it had, whole process. */
function sweep(...args) {
  return new Promise((resolve, reject) => {
    const begun = performance.now();
    let peak_kib = 0;
    // The shell reports the CPU time of its children.
    const child = spawn('bash', ['-c', '"$@" & echo $! >&3; wait $! || exit 1; times >&4', '-', laglab, 'sweep', ...args], {
      stdio: ['ignore', 'ignore', 'inherit', 'pipe', 'pipe'],
    });
    let pid = '',
      times = '',
      wall_s = NaN;
    const look = setInterval(() => {
      try {
        peak_kib = Math.max(peak_kib, Number(/VmHWM:\s+(\d+)/.exec(readFileSync(`/proc/${pid.trim()}/status`, 'utf8'))?.[1] ?? 0));
      } catch {} // it has ended
    }, 20);
    child.stdio[3].on('data', (part) => {
      pid += part;
    });
    child.stdio[4].on('data', (part) => {
      times += part;
    });
    child.on('exit', () => {
      wall_s = (performance.now() - begun) / 1000;
    });
    child.on('close', (code) => {
      clearInterval(look);
      if (code !== 0) return reject(new Error(`laglab sweep ${args.join(' ')} failed`));
      const spent = times
        .trim()
        .split('\n')
        .at(-1)
        .matchAll(/(\d+)m([\d.]+)s/g);
      resolve({ wall_s, cpu_s: [...spent].reduce((sum, [, m, s]) => sum + 60 * m + Number(s), 0), peak_mib: peak_kib / 1024 });
    });
  });
}

const race = (duration_s, repeats) => ({
  scenario: 'race',
  set: { duration_s },
  axes: [{ path: 'players.0.lag_ms', from: 0, to: 300, count: 10 }],
  repeats,
  metrics: ['players.0.own_timeline_error_m.rms', 'players.0.remote_error_m.mean', 'players.0.bandwidth.down_bytes_per_s'],
});
const bareRun = async (experiment, runs) =>
  JSON.parse(await run(bare, [String(runs), join(build, 'scenarios')], readFileSync(experiment, 'utf8')));

const rows = [];
const note = (measured, round, values) => rows.push({ measured, round, ...values });
const show = (values) => {
  const r = range(values);
  return `${digits(r.median)} (${digits(r.min)}-${digits(r.max)})`;
};
const verdict = (met) => (met ? 'met' : 'MISSED');

// ---- a race that takes 10 ms ----

const tried = await bareRun(write('try.json', race(60, 1)), 10);
const duration_s = Math.round((60 * RUN_MS) / (tried.cpu_s * 100));
const runs = quick ? 200 : 1000;
const steady = write('steady.json', race(duration_s, runs / 10));

// ---- threads, and the store ----

const ways = ['bare runs', 'one job', 'two jobs'];
const taken = await interleave(rounds, ways, async (way, round) => {
  const result =
    way === 'bare runs'
      ? await bareRun(steady, runs)
      : await sweep(steady, '--jobs', way === 'one job' ? '1' : '2', '--out', file(`${round}.csv`));
  note(way, round, { runs, ...result });
  return result;
});
const ratios = (a, b, pick) => taken.get(a).map((r, i) => pick(r) / pick(taken.get(b)[i]));
const gain = ratios('one job', 'two jobs', (r) => r.wall_s);
const gainCpu = ratios('one job', 'two jobs', (r) => r.cpu_s).map((r) => 2 * r);
const over = ratios('one job', 'bare runs', (r) => r.wall_s).map((r) => 100 * (r - 1));
const overCpu = ratios('one job', 'bare runs', (r) => r.cpu_s).map((r) => 100 * (r - 1));
printTable(
  `${runs} races of ${duration_s} s, about ${RUN_MS} ms each: ${rounds} rounds (median, min-max)`,
  ways.map((way) => ({
    way,
    'wall s': show(taken.get(way).map((r) => r.wall_s)),
    'CPU s': show(taken.get(way).map((r) => r.cpu_s)),
    'CPU ms a run': show(taken.get(way).map((r) => (1000 * r.cpu_s) / runs)),
  })),
);

// ---- a million rows ----

const many = quick ? 100000 : 1000000;
const points = write('points.json', {
  scenario: { kind: 'motion', problem: 'free_fall', duration_s: 0.05, methods: [{ method: 'rk4', dt_s: 0.05 }] },
  axes: [{ path: 'methods.0.dt_s', from: 0.01, to: 0.05, count: 10 }],
  repeats: many / 10,
  metrics: ['methods.0.e_max', 'methods.0.e_final', 'methods.0.evaluations'],
});
const filled = await sweep(points, '--jobs', String(Math.min(2, cpus().length)), '--out', file('many.csv'));
note('runs and stores', 0, { runs: many, ...filled });

// ---- a large sweep ----

const races = quick ? 5000 : 100000;
const large = await sweep(write('large.json', race(10, races / 10)), '--jobs', '2', '--out', file('large.csv'));
note('races of 10 s', 0, { runs: races, ...large });
printTable('rows and memory', [
  {
    what: `run and store ${many} short runs`,
    'wall s': digits(filled.wall_s),
    'CPU s': digits(filled.cpu_s),
    'peak MiB': digits(filled.peak_mib),
  },
  {
    what: `${races} races of 10 s, two jobs`,
    'wall s': digits(large.wall_s),
    'CPU s': digits(large.cpu_s),
    'peak MiB': digits(large.peak_mib),
  },
]);

say('');
say(
  `two jobs against one, by wall time: ${show(gain)} times: ${verdict(median(gain) >= 1.8)}; ` +
    `by CPU time, as two free cores would give: ${show(gainCpu)}`,
);
say(`what the store adds to runs of ${RUN_MS} ms, wall: ${show(over)} %: ${verdict(median(over) < 2)}; CPU: ${show(overCpu)} %`);
say(
  `100000 races of 10 s in minutes: ${digits((large.wall_s * 1e5) / races / 60)} min${races < 1e5 ? `, from ${races}` : ''}; ` +
    `in at most 64 MiB: ${digits(large.peak_mib)} MiB: ${verdict(large.peak_mib <= 64)}`,
);
writeCsv(
  'experiments',
  `bench/run experiments${quick ? ' --quick' : ''}`,
  {
    measured: 'what was run',
    round: 'rounds of one table are interleaved over its lines',
    runs: 'runs of the experiment',
    wall_s: '',
    cpu_s: 'of the whole process, user and system',
    peak_mib: 'largest resident set (VmHWM), sampled every 20 ms',
  },
  rows,
);
