// An experiment that queues run in shards, and what an undivided sweep of it gives.
import { execFileSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { BINARY } from './daemon.mjs';

export const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
export const SNAKEFILE = path.join(ROOT, 'deploy/snakemake/Snakefile');
export const SHARDS = 3;
const ORDER = {
  scenario: 'race',
  set: { duration_s: 3 },
  axes: [{ path: 'players.0.lag_ms', values: [0, 80, 160, 240] }],
  repeats: 20,
  metrics: ['players.0.remote_error_m.mean'],
};

export const RESULTS = ['rows.csv', 'report.html', 'points.csv'];
export const results = (/** @type {string} */ at) =>
  Object.fromEntries(RESULTS.map((name) => [name, readFileSync(path.join(at, name), 'utf8')]));

export function makeFolder() {
  const folder = mkdtempSync(path.join(tmpdir(), 'laglab-workflows-'));
  /** A folder with the experiment. @param {string} name */
  const place = (name) => {
    const at = path.join(folder, name);
    mkdirSync(path.join(at, 'shards'), { recursive: true });
    writeFileSync(path.join(at, 'lag.json'), JSON.stringify(ORDER));
    return at;
  };
  const at = place('whole'),
    sweep = (/** @type {string[]} */ ...more) => execFileSync(BINARY, ['sweep', 'lag.json', ...more], { cwd: at });
  sweep('--out', 'rows.csv', '--report', 'report.html');
  sweep('--points', '--out', 'points.csv');
  return { place, whole: results(at), remove: () => rmSync(folder, { recursive: true, force: true }) };
}
