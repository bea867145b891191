// An experiment on PostgreSQL whose workers are replaced when they end: what the tests and the benchmark of disturbances share.
import { execFileSync, spawn, spawnSync } from 'node:child_process';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

const SCRIPT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../support/postgres');

/** Seconds after which a worker that is silent loses its chunk. */
export const LEASE_S = 2;

/** A PostgreSQL server of one's own, not yet started; `missing` says why there is none. */
export function ownPostgres() {
  const made = spawnSync(SCRIPT, ['make'], { encoding: 'utf8' });
  const folder = made.stdout.trim();
  const call = (/** @type {string} */ verb, /** @type {string[]} */ ...more) =>
    execFileSync(SCRIPT, [verb, folder, ...more], { encoding: 'utf8' }).trim();
  return { missing: made.status === 77 && made.stderr.trim(), call, count: (/** @type {string} */ sql) => Number(call('sql', sql)) };
}

/** Short runs: Kepler's orbit by one method. @param {number} runs */
export const orbits = (runs, dt_s = 0.001, count = Math.min(runs / 10, 10000)) => ({
  scenario: { kind: 'motion', problem: 'kepler', duration_s: 1, methods: [{ method: 'rk4', dt_s }] },
  axes: [{ path: 'params.e', from: 0.1, to: 0.6, count }],
  repeats: runs / count,
  metrics: ['methods.0.e_final', 'methods.0.energy_drift_max'],
});

/**
 * Workers; one that ends is replaced, as a cluster's engine does.
 * @param {string} binary @param {string} store @param {number} size
 */
export function crew(binary, store, size) {
  /** @type {Set<import('node:child_process').ChildProcess>} */
  const workers = new Set();
  let hiring = true,
    hired = 0;
  const hire = () => {
    if (!hiring) return;
    const child = spawn(binary, ['worker', '--store', store, '--jobs', '1', '--lease-s', String(LEASE_S)], { stdio: 'ignore' });
    hired++;
    workers.add(child);
    child.once('close', () => {
      workers.delete(child);
      setTimeout(hire, 100); /* while the server is away it could not even begin */
    });
  };
  for (let i = 0; i < size; i++) hire();
  return {
    any: (random = Math.random) => [...workers][Math.floor(random() * workers.size)],
    hired: () => hired,
    kill: () => {
      hiring = false;
      for (const child of workers) child.kill('SIGKILL');
    },
    dismiss: async () => {
      hiring = false;
      await Promise.all(
        [...workers].map(
          (child) =>
            new Promise((resolve) => {
              child.once('close', resolve).kill('SIGTERM');
            }),
        ),
      );
    },
  };
}
