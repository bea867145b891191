// Runs the finished experiments that the Experiments view opens on, and writes their points.
//
//   node docs/finished.mjs             # writes www/finished.json; uses build/laglab, or the binary that LAGLAB_BIN names
//
// Their metrics are those of the game alone, not of the machine: every machine has the same points (tests/page/experiments.test.mjs).
import { execFileSync } from 'node:child_process';
import { writeFileSync } from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '..');
export const FINISHED = path.join(ROOT, 'www/finished.json');

const JITTER = { 'players.0.link.up.jitter_ms': 20, 'players.0.link.down.jitter_ms': 20 };
/** at: the value of the first axis that is marked; twelve runs of a point, since fewer than ten have no interval */
const EXAMPLES = {
  lag: {
    at: 300,
    experiment: {
      scenario: 'race',
      set: { duration_s: 20, ...JITTER },
      axes: [
        { path: 'players.0.lag_ms', values: [0, 50, 100, 150, 200, 250, 300, 400, 500] },
        { path: 'players.0.prediction', values: [false, true] },
      ],
      repeats: 12,
      metrics: ['players.0.input_latency_ms.mean', 'players.0.remote_error_m.mean'],
    },
  },
  jitter: {
    at: 100,
    experiment: {
      scenario: 'race',
      set: { duration_s: 20 },
      axes: [
        { path: 'players.0.link.down.jitter_ms', values: [0, 25, 50, 75, 100, 125, 150] },
        { path: 'players.0.interpolation', values: [false, true] },
      ],
      repeats: 12,
      metrics: ['players.0.smoothness.step_max_m', 'players.0.remote_error_m.mean'],
    },
  },
  updates: {
    at: 10,
    experiment: {
      scenario: 'race',
      set: { duration_s: 20, ...JITTER },
      axes: [
        { path: 'server.update_hz', values: [5, 10, 15, 20, 30, 60] },
        { path: 'players.0.interpolation', values: [false, true] },
      ],
      repeats: 12,
      metrics: ['players.0.remote_error_m.mean', 'players.0.bandwidth.down_bytes_per_s'],
    },
  },
};

/** @param {string} binary @returns {any[]} each with its points, as the daemon gives them */
export const finished = (binary) =>
  Object.entries(EXAMPLES).map(([id, { at, experiment }]) => ({
    id,
    at,
    experiment,
    points: JSON.parse(
      execFileSync(binary, ['sweep', '-', '--points', '--format', 'json'], { input: JSON.stringify(experiment), encoding: 'utf8' }),
    ),
  }));

/** A line for each point. @param {ReturnType<typeof finished>} all */
const layout = (all) =>
  `[\n${all
    .map(
      ({ points, ...of }) => `${JSON.stringify(of).slice(0, -1)}, "points": [\n${points.map((row) => JSON.stringify(row)).join(',\n')}\n]}`,
    )
    .join(',\n')}\n]\n`;

if (process.argv[1] === fileURLToPath(import.meta.url))
  writeFileSync(FINISHED, layout(finished(process.env.LAGLAB_BIN ?? path.join(ROOT, 'build/laglab'))));
