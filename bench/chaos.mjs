// Many short runs over PostgreSQL while everything is killed: workers, the process that waits for the rows, the server; and workers are
// frozen.
//   bench/run chaos [--quick] [--runs=1000000] [--disturbances=60] [--workers=3] [--seed=1]
import { createHash } from 'node:crypto';
import { createReadStream, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { spawn } from 'node:child_process';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { digits, laglab, pause, printTable, run, say, writeCsv } from './lib.mjs';
import { LEASE_S, crew, orbits, ownPostgres } from '../tests/lib/chaos.mjs';

const option = (name, standard) => Number(process.argv.find((word) => word.startsWith(`--${name}=`))?.split('=')[1] ?? standard);
const quick = process.argv.includes('--quick');
const runs = option('runs', quick ? 50_000 : 1_000_000),
  disturbances = option('disturbances', quick ? 20 : 60),
  size = option('workers', 3),
  seed = option('seed', 1);

const { missing, call: postgres, count } = ownPostgres();
if (missing) {
  console.error(missing);
  process.exit(1);
}
const folder = mkdtempSync(join(tmpdir(), 'laglab-chaos-'));
process.on('exit', () => {
  postgres('remove');
  rmSync(folder, { recursive: true, force: true });
});
const file = (name) => join(folder, name);
const checksum = async (name) => {
  const hash = createHash('sha256');
  for await (const part of createReadStream(file(name))) hash.update(part);
  return hash.digest('hex');
};

/** Numbers from 0 to 1 that a seed gives again (mulberry32). */
function random() {
  state = (state + 0x6d2b79f5) | 0;
  let x = Math.imul(state ^ (state >>> 15), 1 | state);
  x = (x + Math.imul(x ^ (x >>> 7), 61 | x)) ^ x;
  return ((x ^ (x >>> 14)) >>> 0) / 2 ** 32;
}
let state = seed;

writeFileSync(file('orbits.json'), JSON.stringify(orbits(runs, 0.01)));
let url = postgres('start');

// ---- the process that waits: killed, it is started again ----

let waiting, finished;
const ended = new Promise((resolve) => {
  finished = resolve;
});
function wait() {
  waiting = spawn(laglab, ['sweep', file('orbits.json'), '--store', url, '--jobs', '0', '--out', file('disturbed.csv')], {
    stdio: 'ignore',
  });
  waiting.once('close', (code, signal) => {
    if (code === 2) throw new Error('the sweep was refused');
    if (code === 0 || failedChunks() > 0) finished();
    else setTimeout(wait, signal === 'SIGKILL' ? 0 : 300); // without the server it cannot begin
  });
}

const counted = (/** @type {string} */ sql) => {
  try {
    return count(sql);
  } catch {
    return 0; // the server is away, or the store is not there yet
  }
};
/** A chunk fails after five lost leases: then the experiment has failed. */
const failedChunks = () => counted('SELECT count(*) FROM laglab.chunk WHERE state = 3');
const rows = () => counted('SELECT count(*) FROM laglab.result');

// ---- disturbances, in the order of a shuffled list of their kinds ----

const KINDS = {
  'worker killed': { weight: 14, does: () => workers.any(random)?.kill('SIGKILL') },
  'waiting process killed': { weight: 3, does: () => waiting.kill('SIGKILL') },
  'server crashed': {
    weight: 2,
    does: async () => {
      postgres('kill');
      await pause(300 + 700 * random());
      url = postgres('start');
    },
  },
  'worker frozen beyond its lease': {
    weight: 1,
    does: async () => {
      const worker = workers.any(random);
      worker?.kill('SIGSTOP');
      await pause(LEASE_S * 1000 + 500);
      worker?.kill('SIGCONT');
    },
  },
};
const wheel = Object.keys(KINDS).flatMap((kind) => Array(KINDS[kind].weight).fill(kind));
const met = Object.fromEntries(Object.keys(KINDS).map((kind) => [kind, 0]));

let begun = performance.now();
wait();
const workers = crew(laglab, url, size);
process.on('exit', () => {
  waiting.kill('SIGKILL');
  workers.kill();
});
let done = false;
ended.then(() => {
  done = true;
});
// By progress, not by time: on a slow machine the same chunk would be lost again and again, until it fails.
for (let i = 0; i < disturbances && !done; i++) {
  while (!done && rows() <= (runs * i) / disturbances) await pause(100);
  const kind = wheel[Math.floor(random() * wheel.length)];
  await KINDS[kind].does();
  met[kind]++;
}
await ended;
const wall_s = (performance.now() - begun) / 1000;
await workers.dismiss();

const stored = count('SELECT count(*) FROM laglab.result'),
  distinct = count('SELECT count(DISTINCT run) FROM laglab.result'),
  chunks = count('SELECT count(*) FROM laglab.chunk'),
  again = count('SELECT count(*) FROM laglab.chunk WHERE attempt > 1');

// ---- the same without a store and without disturbances ----

begun = performance.now();
await run(laglab, [
  'sweep',
  file('orbits.json'),
  '--jobs',
  '2',
  '--out',
  file('undisturbed.csv'),
  '--store',
  `sqlite:${file('undisturbed.db')}`,
]);
const undisturbed_s = (performance.now() - begun) / 1000;
const same = failedChunks() === 0 && (await checksum('disturbed.csv')) === (await checksum('undisturbed.csv'));

const row = {
  runs,
  stored,
  lost: runs - distinct,
  doubled: stored - distinct,
  same,
  ...Object.fromEntries(Object.entries(met).map(([kind, n]) => [kind.replaceAll(' ', '_'), n])),
  workers: workers.hired(),
  chunks,
  chunks_tried_again: again,
  wall_s: digits(wall_s),
  rows_per_s: digits(runs / wall_s),
  undisturbed_wall_s: digits(undisturbed_s),
  undisturbed_rows_per_s: digits(runs / undisturbed_s),
};
printTable(`${runs} short runs over PostgreSQL, ${size} workers, ${disturbances} disturbances`, [row]);
const good = same && row.lost === 0 && row.doubled === 0 && again > 0;
say(`nothing lost or doubled, the same bytes as without disturbances: ${good ? 'met' : 'MISSED'}`);
writeCsv(
  'chaos',
  `bench/run chaos --runs=${runs} --disturbances=${disturbances} --workers=${size} --seed=${seed}`,
  {
    runs: "of Kepler's orbit, a hundred steps each",
    stored: 'rows of the store at the end',
    lost: 'runs without a row',
    doubled: 'rows beyond one per run',
    same: 'whether the exported CSV has the same bytes as that of an undisturbed sweep with SQLite',
    worker_killed: 'SIGKILL',
    waiting_process_killed: 'SIGKILL of the process that waits for the rows and exports them; it is started again',
    server_crashed: 'PostgreSQL stopped as a crash does, back after 0.3 to 1 s',
    worker_frozen_beyond_its_lease: 'SIGSTOP, SIGCONT after its chunk may belong to another',
    workers: 'started',
    chunks: '',
    chunks_tried_again: 'whose worker had ended or was frozen',
    wall_s: 'disturbed, with the export',
    rows_per_s: '',
    undisturbed_wall_s: 'two jobs with SQLite, with the export',
    undisturbed_rows_per_s: '',
  },
  [row],
);
process.exit(good ? 0 : 1);
