// Workers under a real Slurm, one of them requeued and one killed while it works: the rows are those of an undisturbed sweep. The store is
// PostgreSQL's, as on a cluster; where that is not installed, a file of SQLite's, which workers of one machine may share.
import assert from 'node:assert/strict';
import { execFile, execFileSync, spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import test from 'node:test';
import { fileURLToPath } from 'node:url';
import { promisify } from 'node:util';
import { BINARY } from '../lib/daemon.mjs';
import { RUNS } from '../lib/runs.mjs';
import { noSlurm, startSlurm } from '../lib/slurm.mjs';

const POSTGRES = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../support/postgres');
const run = promisify(execFile),
  NODES = 3,
  REPEATS = 30;
const EXPERIMENT = {
  scenario: 'race',
  set: { duration_s: 8 },
  axes: [{ path: 'players.0.lag_ms', from: 0, to: 290, count: RUNS / REPEATS }],
  repeats: REPEATS,
  metrics: ['players.0.own_lead_m.mean', 'players.0.bandwidth.down_bytes_per_s'],
};

/** The URL of a store that is there as long as the test. @param {import('node:test').TestContext} t @param {string} folder */
function startStore(t, folder) {
  const made = spawnSync(POSTGRES, ['make'], { encoding: 'utf8' }),
    server = made.stdout.trim();
  if (made.status === 77) {
    t.diagnostic(`SQLite in place of PostgreSQL: ${made.stderr.trim()}`);
    return `sqlite:${path.join(folder, 'runs.db')}`;
  }
  t.after(() => execFileSync(POSTGRES, ['remove', server]));
  return execFileSync(POSTGRES, ['start', server], { encoding: 'utf8' }).trim();
}

test(`${RUNS} runs by ${NODES} workers under Slurm, one requeued and one killed: every row once, and as in an undisturbed sweep`, {
  skip: noSlurm() || false,
}, async (t) => {
  const folder = mkdtempSync(path.join(tmpdir(), 'laglab-slurm-'));
  const file = (/** @type {string} */ name) => path.join(folder, name);
  writeFileSync(file('experiment.json'), JSON.stringify(EXPERIMENT));
  const slurm = await startSlurm(folder, NODES);
  t.after(async () => {
    await slurm.stop();
    rmSync(folder, { recursive: true, force: true });
  });
  const laglab = async (/** @type {string[]} */ ...args) => (await run(BINARY, args, { env: slurm.env, cwd: folder })).stdout;

  const store = ['--store', startStore(t, folder)];
  const submit = ['submit', 'experiment.json', '--engine', 'slurm', '-n', String(NODES), '--lease-s', '2', ...store];
  const script = await laglab(...submit, '--print');
  assert.match(script, /^#!\/bin\/sh\n#SBATCH/);
  assert.equal(await slurm.ask('squeue', '-h'), '', '--print submits nothing');

  const job = /^Submitted batch job (\d+)/.exec(await laglab(...submit))?.[1];
  assert.ok(job);
  const working = async () => (await slurm.ask('squeue', '-h', '-r', '-t', 'RUNNING', '-o', '%i')).split('\n').filter(Boolean);
  await slurm.until(`${NODES} tasks at work`, async () => (await working()).length === NODES);
  await new Promise((resolve) => setTimeout(resolve, 1000)); // each has its first chunks
  await slurm.ask('scontrol', 'requeue', `${job}_2`);
  await slurm.ask('scancel', '--signal=KILL', '--full', `${job}_3`);
  // Without threads of its own a sweep waits for the workers.
  await laglab('sweep', 'experiment.json', ...store, '--jobs', '0', '--out', 'slurm.csv');
  assert.match(await slurm.ask('scontrol', 'show', 'job', `${job}_2`), /Restarts=1/, 'it was at work when it was requeued');
  assert.match(await slurm.ask('scontrol', 'show', 'job', `${job}_3`), /JobState=(FAILED|CANCELLED)/, 'it was at work when it was killed');

  await laglab('sweep', 'experiment.json', '--jobs', '2', '--out', 'alone.csv');
  const alone = readFileSync(file('alone.csv'), 'utf8');
  assert.equal(alone.trimEnd().split('\r\n').length, 1 + RUNS);
  assert.equal(readFileSync(file('slurm.csv'), 'utf8'), alone);
});
