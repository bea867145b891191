// The program gives the golden hashes; tests/golden holds the same objects against them in the default tier.
import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { promisify } from 'node:util';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
const BINARY = path.resolve(process.env.LAGLAB_BIN ?? path.join(ROOT, 'build/laglab'));
const run = promisify(execFile);

test('the binary gives the golden hash of every netgame', async () => {
  const rows = readFileSync(path.join(ROOT, 'tests/golden/hashes.csv'), 'utf8')
    .trim()
    .split('\n')
    .slice(1)
    .map((line) => line.split(','));
  const netgames = rows.filter(([id]) => JSON.parse(readFileSync(path.join(ROOT, 'scenarios', `${id}.json`), 'utf8')).kind === 'netgame');
  assert.ok(netgames.length >= 50, `${netgames.length} netgames`);
  const others = [];
  for (const [id = '', tick, hash] of netgames) {
    const { stdout } = await run(BINARY, ['run', id], { cwd: ROOT, maxBuffer: 1 << 26 });
    const result = JSON.parse(stdout);
    if (result.hash !== hash || result.ticks !== Number(tick)) others.push(`${id}: ${result.ticks} ${result.hash}, golden ${tick} ${hash}`);
  }
  assert.deepEqual(others, []);
});
