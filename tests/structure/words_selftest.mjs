// Proves that words.mjs can fail: on a small tree whose text and code are known.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { execPath } from 'node:process';
import { fileURLToPath } from 'node:url';
import { count, findings, readList, roomOf } from './words.mjs';

const list = readList('# a list\n!standard deviation\nstandard:default\nrungs?:level\n');
const words = (text, kind) => findings(text, kind, list).map(({ line, word }) => `${line} ${word}`);

assert.deepEqual(words('int rung; /* the Rung\n * of rungs */\nf("a rung", "rung", \'rungs\');', 'code'), ['1 Rung', '2 rungs', '3 rung']);
assert.deepEqual(words('/* a `rung`, the standard deviation, a standard */ // {Rung} laddered', 'code'), ['1 standard']);
assert.deepEqual(words('A rung.\n```sh\nrung\n```\n`rung` [x](rung.md)\n<!-- generated: x -->\nrung\n<!-- end -->\nrungs', 'markdown'), [
  '1 rung',
  '9 rungs',
]);
assert.deepEqual(words('{"help": "a rung",\n "name": "standard"}', 'data'), ['2 standard', '1 rung']);
assert.throws(() => readList('rung'), /no replacement/);
assert.deepEqual(['a.md', 'docs/a.md', 'src/main.c', 'src/ode/problems/a.c', 'tests/ode/a.c'].map(roomOf), [
  '.',
  'docs',
  'src',
  'src/ode',
  'tests/ode',
]);

const root = mkdtempSync(join(tmpdir(), 'words-'));
const write = (name, text) => writeFileSync(join(root, name), text);
const run = (...args) => spawnSync(execPath, [fileURLToPath(new URL('words.mjs', import.meta.url)), root, ...args], { encoding: 'utf8' });
try {
  for (const folder of ['tests/structure', 'src/ode', 'src/sim', 'node_modules']) mkdirSync(join(root, folder), { recursive: true });
  write('tests/structure/words.txt', 'rungs?:level\n');
  write('src/ode/a.c', '/* a rung */\n');
  write('src/sim/a.c', '/* a level */\n');
  write('node_modules/a.js', '// a rung\n');
  assert.deepEqual(count(root).counts, { 'src/ode': 1, 'src/sim': 0 });
  assert.equal(run().status, 1, 'a room without a limit has none to spare');
  assert.equal(run('--update').status, 0);
  assert.equal(readFileSync(join(root, 'tests/structure/words.csv'), 'utf8'), 'room,count\nsrc/ode,1\nsrc/sim,0\n');
  assert.equal(run().status, 0);
  write('src/ode/a.c', '/* a rung of rungs */\n');
  const more = run('--update');
  assert.equal(more.status, 1, 'counts may not rise');
  assert.match(more.stdout, /src\/ode\/a\.c:1: "rungs"; write: level/);
  write('src/ode/a.c', '/* a level */\n');
  write('src/sim/a.c', '/* a rung */\n');
  assert.equal(run().status, 1, 'nor in one room for another');
  assert.equal(run('--update').status, 0, 'but a file may move');
  write('src/sim/a.c', '/* a level */\n');
  assert.equal(run().status, 0, 'and fall');
} finally {
  rmSync(root, { recursive: true });
}
console.log('the words are counted as they must');
