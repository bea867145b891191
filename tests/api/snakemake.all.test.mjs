// Snakemake runs deploy/snakemake/Snakefile, as docs/experiments.md says.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { test } from 'node:test';
import { BINARY } from '../lib/daemon.mjs';
import { makeFolder, results, SHARDS, SNAKEFILE } from '../lib/workflows.mjs';

const snakemake = spawnSync('snakemake', ['--version']).status === 0;
test('Snakemake runs its file as it is', { skip: snakemake ? false : 'snakemake is not installed' }, (t) => {
  const folder = makeFolder(),
    at = folder.place('snakemake');
  t.after(folder.remove);
  const wish = ['--config', 'experiment=lag.json', `shards=${SHARDS}`, `laglab=${BINARY}`];
  const run = spawnSync('snakemake', ['-s', SNAKEFILE, '--cores', '2', ...wish], {
    cwd: at,
    encoding: 'utf8',
    env: { ...process.env, HOME: at },
  });
  assert.equal(run.status, 0, run.stderr);
  assert.deepEqual(results(at), folder.whole);
});
