// The experiments of scenarios/experiments, and what their rows are compared by.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { BINARY } from './daemon.mjs';

/** @param {string} name @returns {Record<string, any>[]} a row per point */
export function points(name) {
  const result = spawnSync(BINARY, ['sweep', `experiments/${name}`, '--points', '--format', 'json'], { encoding: 'utf8', timeout: 600000 });
  assert.equal(result.status, 0, result.stderr);
  return JSON.parse(result.stdout);
}

/** @param {Record<string, any>[]} rows @param {Record<string, any>} values @param {string} metric */
export const along = (rows, values, metric) =>
  rows.filter((row) => Object.entries(values).every(([key, value]) => row[key] === value)).map((row) => row[metric]);
export const rises = (/** @type {number[]} */ values) => values.every((value, i) => i === 0 || value >= values[i - 1]);
