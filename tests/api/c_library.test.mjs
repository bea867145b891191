// The C library as a course has it: installed into a folder, linked by pkg-config, its values and hashes those of `laglab run`.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { install, run, WARNINGS } from '../lib/c_library.mjs';
import { BINARY } from '../lib/daemon.mjs';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');

/** @type {Awaited<ReturnType<typeof install>>} */ let library;
const at = (/** @type {string} */ name) => path.join(library.folder, name);
before(async () => {
  library = await install();
});
after(() => library?.remove());

/** What `laglab run` prints. */
async function printed(...args) {
  const { stdout } = await run(BINARY, ['run', ...args], { maxBuffer: 1 << 24 });
  return JSON.parse(stdout);
}

test('the example, linked with the shared and with the static library, has the values of the program', async () => {
  const source = path.join(ROOT, 'examples/lag.c'),
    shared = await library.pkgConfig('--cflags', '--libs'),
    options = await library.pkgConfig('--cflags', '--libs', '--static');
  await run('cc', [...WARNINGS, '-o', at('shared'), source, ...shared]);
  await run('cc', [
    ...WARNINGS,
    '-o',
    at('static'),
    source,
    ...options.map((one) => (one === '-llaglab' ? path.join(library.libraries, 'liblaglab.a') : one)),
  ]);
  const { stdout } = await run(at('shared'), [library.scenarios], { env: library.environment });
  assert.equal((await run(at('static'), [library.scenarios])).stdout, stdout);
  const [head, ...rows] = stdout.trim().split('\n');
  assert.equal(head, 'lag_ms,prediction,input_latency_ms,remote_error_m,hash');
  assert.equal(rows.length, 8);
  for (const row of rows) {
    const [lag, prediction, latency, error, hash] = row.split(',');
    const told = await printed(
      'race',
      '--duration',
      '10',
      '--set',
      `players.0.lag_ms=${lag}`,
      '--set',
      `players.0.prediction=${prediction}`,
    );
    assert.equal(hash, told.hash, row);
    // Some are printed with 15 digits.
    for (const [got, printed] of [
      [Number(latency), told.metrics.players[0].input_latency_ms.mean],
      [Number(error), told.metrics.players[0].remote_error_m.mean],
    ]) {
      assert.ok(got === printed || Number(got.toPrecision(15)) === printed, `${row}: ${printed}`);
    }
  }
});

test('only the names of the header can be seen', async () => {
  const header = readFileSync(path.join(ROOT, 'include/laglab.h'), 'utf8');
  const declared = [...header.replace(/\/\*[\s\S]*?\*\//g, '').matchAll(/LAGLAB_PUBLIC [^;]*?\b(laglab_\w+)\(/g)]
    .map(([, name]) => name)
    .sort();
  assert.ok(declared.length >= 19, declared.join());
  for (const args of [
    ['-D', path.join(library.libraries, 'liblaglab.so')],
    ['-g', path.join(library.libraries, 'liblaglab.a')],
  ]) {
    const { stdout } = await run('nm', ['--defined-only', '--format=posix', ...args]);
    const names = stdout
      .split('\n')
      .filter((line) => /^\w+ [A-TV-Z] /.test(line))
      .map((line) => line.split(' ')[0]);
    assert.deepEqual(names.sort(), declared, args.join(' '));
  }
});

/** @param {string} bits */
const double = (bits) => new DataView(BigUint64Array.of(BigInt(`0x${bits}`)).buffer).getFloat64(0, true);

test('errors, time, changes and documents', async () => {
  const said = await library.everything();
  const code = (name) => said.get(name).code,
    error = (name) => said.get(name).error;
  assert.match((await run(BINARY, ['--version'])).stdout, new RegExp(`^laglab ${said.get('version').version.replace('+', '\\+')}$`, 'm'));

  assert.deepEqual(['syntax', 'kind', 'range', 'unknown', 'unreadable'].map(code), [1, 1, 1, 2, 6]);
  assert.match(error('unreadable'), /^cannot read .*folder\.json$/);
  assert.match(error('syntax'), /^not valid JSON: line 1/);
  assert.match(error('kind'), /^kind: must be one of/);
  assert.match(error('range'), /^duration_s: must be .*; got -3/);
  assert.equal(said.get('range').field, 'duration_s');
  // The sentence of the program.
  const refused = await run(BINARY, ['run', 'race', '--duration', '-3']).catch((failure) => failure);
  assert.equal(refused.stderr.trim(), `laglab: ${error('range')}`);

  for (const name of ['open', 'run', 'input', 'set', 'end', 'back', 'forward', 'metric', 'motion', 'text'])
    assert.equal(code(name), 0, name);
  assert.deepEqual(['not live', 'bad input', 'no path', 'beyond', 'no metric', 'no text'].map(code), [3, 1, 1, 1, 1, 1]);
  assert.match(error('no metric'), /has no metric players\.0\.remote_eror_m; players\.0 has .*/);
  assert.match(error('beyond'), /^tick: must be 0 to 360; got 361$/);
  assert.equal(said.get('status').text, 'ok');

  const still = await printed('race', '--seed', '9', '--duration', '2', '--set', 'players.0.control=person');
  assert.equal(said.get('at 120').tick, 120);
  assert.equal(double(said.get('at 120').time_s), 2);
  assert.equal(still.ticks, 120);
  assert.equal(said.get('at end').tick, 360);
  assert.notEqual(said.get('at end').hash, said.get('at 120').hash);
  assert.equal(said.get('again at end').hash, said.get('at end').hash);

  const { metrics } = said.get('metrics').document;
  assert.equal(said.get('metrics').document.hash, said.get('at end').hash);
  assert.equal(metrics.players[0].remote_error_m.mean, double(said.get('value').value));
  const leaves = (tree) => (tree !== null && typeof tree === 'object' ? Object.values(tree).flatMap(leaves) : [tree]);
  assert.equal(said.get('paths').count, leaves(metrics).filter((value) => typeof value !== 'string').length);
  assert.equal(said.get('paths').numbers, said.get('paths').count);
  assert.equal(said.get('paths').beyond, 1);
  assert.equal(said.get('state').document.state !== undefined, true);
  assert.equal(said.get('scenario').document.players[1].lag_ms, 40);
});

test('a run that has no memory is refused', async () => {
  writeFileSync(
    at('memory.c'),
    `#include <laglab.h>
     #include <stddef.h>
     extern void *__libc_calloc(size_t, size_t);
     static int none;
     void *calloc(size_t count, size_t size) { return none ? NULL : __libc_calloc(count, size); }
     int main(void)
     {
         laglab_run *run = NULL;
         none = 1;
         laglab_code code = laglab_open("{}", NULL, &run);
         return code == LAGLAB_NO_MEMORY && run == NULL ? 0 : 1;
     }`,
  );
  await run('cc', [...WARNINGS, '-fno-builtin', '-o', at('memory'), at('memory.c'), ...(await library.pkgConfig('--cflags', '--libs'))]);
  await run(at('memory'), [], { env: library.environment });
});

test('in a program whose numbers have a comma it is the same', async () => {
  writeFileSync(at('comma.src'), 'LC_NUMERIC\ndecimal_point ","\nthousands_sep ""\ngrouping -1\nEND LC_NUMERIC\n');
  // It warns of the categories that are missing, by its status too.
  await run('localedef', ['--no-archive', '-c', '-i', at('comma.src'), at('comma')]).catch(() => {});
  const [point, comma] = [await library.everything(), await library.everything([], { LOCPATH: library.folder, LC_ALL: 'comma' })];
  assert.equal(comma.get('point').point, ',');
  comma.set('point', point.get('point'));
  assert.deepEqual(comma, point);
});
