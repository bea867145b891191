// The example in R: it reads the runs of an experiment and fits a model. The same model by numpy and scipy has the same estimates and
// intervals.
import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { promisify } from 'node:util';
import { BINARY } from '../lib/daemon.mjs';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
const EXAMPLE = path.join(ROOT, 'clients/r');
const run = promisify(execFile);

test('a linear model of error on lag by technique is that of Python', async () => {
  const folder = mkdtempSync(path.join(tmpdir(), 'laglab-r-'));
  const at = (/** @type {string} */ name) => path.join(folder, name);
  try {
    await run(BINARY, ['sweep', path.join(EXAMPLE, 'techniques.json'), '--out', at('runs.csv')]);
    const said = await run('Rscript', ['--vanilla', path.join(EXAMPLE, 'techniques.R'), at('runs.csv'), at('model.csv'), at('figure.pdf')]);
    assert.match(said.stdout, /Residual standard error: .* on 232 degrees of freedom/);
    assert.match(said.stdout, /Model 2: error_m ~ technique \* lag_ms/);
    const expected = JSON.parse(
      (await run('/usr/bin/python3', ['-B', path.join(ROOT, 'tests/lib/least_squares.py'), at('runs.csv')])).stdout,
    );
    assert.equal(expected.runs, 4 * 5 * 12);
    const rows = readFileSync(at('model.csv'), 'utf8').trim().split('\n');
    assert.equal(rows[0], 'term,estimate,low,high');
    assert.equal(rows.length, 1 + expected.rows.length);
    for (const [i, [term, ...values]] of expected.rows.entries()) {
      const [name, ...numbers] = rows[i + 1].split(',');
      assert.equal(name.trim(), term);
      values.forEach((/** @type {number} */ value, /** @type {number} */ k) => {
        assert.ok(
          Math.abs(Number(numbers[k]) - value) <= 1e-9 * Math.max(1e-3, Math.abs(value)),
          `${term}: ${numbers[k]}, expected ${value}`,
        );
      });
    }
    assert.match(readFileSync(at('figure.pdf'), 'latin1'), /^%PDF-1[\s\S]*%%EOF\s*$/);
  } finally {
    rmSync(folder, { recursive: true, force: true });
  }
});
