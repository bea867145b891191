// The C library as a course has it: installed into a folder, linked by pkg-config, its values and hashes those of `laglab run`.
import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { promisify } from 'node:util';
import { BINARY } from '../lib/daemon.mjs';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
const run = promisify(execFile);
const WARNINGS = ['-std=c99', '-Wall', '-Wextra', '-pedantic', '-Werror'];

let folder, prefix, libraries, scenarios, environment;
const at = (name) => path.join(folder, name);

async function pkgConfig(...options) {
  const { stdout } = await run('pkg-config', [...options, 'laglab'], { env: environment });
  return stdout.trim().split(/\s+/);
}

before(async () => {
  folder = mkdtempSync(path.join(tmpdir(), 'laglab-c-'));
  prefix = at('prefix');
  await run('cmake', ['--install', path.dirname(BINARY), '--prefix', prefix]);
  libraries = path.dirname(
    path.dirname(readdirSync(prefix, { recursive: true, encoding: 'utf8' }).find((name) => name.endsWith('laglab.pc'))),
  );
  libraries = path.join(prefix, libraries);
  environment = { ...process.env, PKG_CONFIG_PATH: path.join(libraries, 'pkgconfig'), LD_LIBRARY_PATH: libraries };
  [scenarios] = await pkgConfig('--variable=scenarios');
});
after(() => rmSync(folder, { recursive: true, force: true }));

/** What `laglab run` prints. */
async function printed(...args) {
  const { stdout } = await run(BINARY, ['run', ...args], { maxBuffer: 1 << 24 });
  return JSON.parse(stdout);
}

test('the example, linked with the shared and with the static library, has the values of the program', async () => {
  const source = path.join(ROOT, 'examples/lag.c'),
    shared = await pkgConfig('--cflags', '--libs'),
    options = await pkgConfig('--cflags', '--libs', '--static');
  await run('cc', [...WARNINGS, '-o', at('shared'), source, ...shared]);
  await run('cc', [
    ...WARNINGS,
    '-o',
    at('static'),
    source,
    ...options.map((one) => (one === '-llaglab' ? path.join(libraries, 'liblaglab.a') : one)),
  ]);
  const { stdout } = await run(at('shared'), [scenarios], { env: environment });
  assert.equal((await run(at('static'), [scenarios])).stdout, stdout);
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
    ['-D', path.join(libraries, 'liblaglab.so')],
    ['-g', path.join(libraries, 'liblaglab.a')],
  ]) {
    const { stdout } = await run('nm', ['--defined-only', '--format=posix', ...args]);
    const names = stdout
      .split('\n')
      .filter((line) => /^\w+ [A-TV-Z] /.test(line))
      .map((line) => line.split(' ')[0]);
    assert.deepEqual(names.sort(), declared, args.join(' '));
  }
});

// Errors, time, changes and every document, by a program that prints a line of JSON for each.
const EVERYTHING = String.raw`
#include <inttypes.h>
#include <laglab.h>
#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* As its bits: printf would write it in the locale. */
static uint64_t bits(double number)
{
    uint64_t same;
    memcpy(&same, &number, sizeof same);
    return same;
}

static void say(const char *name, laglab_run *run, laglab_code code)
{
    printf("{\"name\":\"%s\",\"code\":%d,\"field\":\"%s\",\"error\":\"%s\"}\n", name, code, laglab_error_field(run), laglab_error(run));
}

static void place(const char *name, laglab_run *run)
{
    printf("{\"name\":\"%s\",\"tick\":%" PRId64 ",\"time_s\":\"%016" PRIx64 "\",\"hash\":\"%016" PRIx64 "\"}\n", name, laglab_tick(run),
           bits(laglab_time_s(run)), laglab_hash(run));
}

static void document(const char *name, laglab_run *run, laglab_document which)
{
    char *text = laglab_json(run, which);
    printf("{\"name\":\"%s\",\"document\":%s}\n", name, text);
    laglab_free(text);
}

static void open_badly(const char *name, const char *json, const char *const *sets)
{
    laglab_run *run;
    laglab_code code = laglab_open(json, sets, &run);
    say(name, run, code);
    double value;
    if (laglab_run_to(run, 1) != LAGLAB_CONFLICT || laglab_metric(run, "x", &value) != LAGLAB_CONFLICT ||
        !isnan(value) || laglab_hash(run) != 0 ||
        laglab_metric_count(run) != 0 || laglab_json(run, LAGLAB_STATE) != NULL)
        printf("a run that could not be opened does something\n");
    laglab_close(run);
}

int main(int argc, char **argv)
{
    (void)argc;
    laglab_run *run;
    double value;
    const char *text;
    setlocale(LC_ALL, "");
    printf("{\"name\":\"point\",\"point\":\"%s\"}\n", localeconv()->decimal_point);
    printf("{\"name\":\"version\",\"version\":\"%s\"}\n", laglab_version());
    open_badly("syntax", "{", NULL);
    open_badly("kind", "{\"kind\":\"magnetism\"}", NULL);
    const char *const long_run[] = {"duration_s=-3", NULL};
    open_badly("range", "{\"kind\":\"motion\",\"problem\":\"kepler\",\"methods\":[{\"method\":\"rk4\"}]}", long_run);
    laglab_code code = laglab_open_named(argv[1], "nothing", NULL, &run);
    say("unknown", run, code);
    laglab_close(run);
    laglab_close(NULL);

    const char *const sets[] = {"players.0.control=person", "duration_s=6", "seed=9", NULL};
    code = laglab_open_named(argv[1], "race", sets, &run);
    say("open", run, code);
    say("run", run, laglab_run_to(run, 120));
    place("at 120", run);
    say("input", run, laglab_input(run, 0, 1, 0, 0));
    say("set", run, laglab_set(run, "players.1.lag_ms=40"));
    say("not live", run, laglab_set(run, "players.0.name=C"));
    say("bad input", run, laglab_input(run, 0, 2, 0, 0));
    say("no path", run, laglab_set(run, "players"));
    say("end", run, laglab_run_to(run, laglab_end_tick(run)));
    place("at end", run);
    say("back", run, laglab_run_to(run, 120));
    place("again at 120", run);
    say("forward", run, laglab_run_to(run, laglab_end_tick(run)));
    place("again at end", run);
    say("beyond", run, laglab_run_to(run, laglab_end_tick(run) + 1));
    say("metric", run, laglab_metric(run, "players.0.remote_error_m.mean", &value));
    printf("{\"name\":\"value\",\"value\":\"%016" PRIx64 "\"}\n", bits(value));
    say("no metric", run, laglab_metric(run, "players.0.remote_eror_m", &value));
    size_t count = laglab_metric_count(run), numbers = 0;
    for (size_t i = 0; i < count; i++)
        numbers += laglab_metric(run, laglab_metric_path(run, i), &value) == LAGLAB_OK;
    printf("{\"name\":\"paths\",\"count\":%zu,\"numbers\":%zu,\"beyond\":%d}\n", count, numbers, laglab_metric_path(run, count) == NULL);
    document("metrics", run, LAGLAB_METRICS);
    document("scenario", run, LAGLAB_SCENARIO);
    document("state", run, LAGLAB_STATE);
    laglab_close(run);

    const char kepler[] = "{\"kind\":\"motion\",\"problem\":\"kepler\",\"duration_s\":2,\"methods\":[{\"method\":\"rk4\",\"dt_s\":0.01}]}";
    code = laglab_open(kepler, NULL, &run);
    say("motion", run, code);
    laglab_run_to(run, laglab_end_tick(run));
    say("text", run, laglab_metric_text(run, "methods.0.status", &text));
    printf("{\"name\":\"status\",\"text\":\"%s\"}\n", text);
    say("no text", run, laglab_metric_text(run, "methods.0.e_final", &text));
    laglab_close(run);
    return 0;
}
`;

/** @param {string[]} before @param {Record<string, string>} more */
async function everything(before = [], more = {}) {
  const [program, ...args] = [...before, at('everything'), scenarios];
  const { stdout } = await run(program, args, { env: { ...environment, ...more }, maxBuffer: 1 << 24 });
  const said = stdout
    .trim()
    .split('\n')
    .map((line) => JSON.parse(line));
  return new Map(said.map((one) => [one.name, one]));
}

/** @param {string} bits */
const double = (bits) => new DataView(BigUint64Array.of(BigInt(`0x${bits}`)).buffer).getFloat64(0, true);

test('errors, time, changes and documents', async () => {
  writeFileSync(at('everything.c'), EVERYTHING);
  await run('cc', [...WARNINGS, '-g', '-o', at('everything'), at('everything.c'), ...(await pkgConfig('--cflags', '--libs'))]);
  const said = await everything();
  const code = (name) => said.get(name).code,
    error = (name) => said.get(name).error;
  assert.match((await run(BINARY, ['--version'])).stdout, new RegExp(`^laglab ${said.get('version').version.replace('+', '\\+')}$`, 'm'));

  assert.deepEqual(['syntax', 'kind', 'range', 'unknown'].map(code), [1, 1, 1, 2]);
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

test('in a program whose numbers have a comma it is the same', async () => {
  writeFileSync(at('comma.src'), 'LC_NUMERIC\ndecimal_point ","\nthousands_sep ""\ngrouping -1\nEND LC_NUMERIC\n');
  // It warns of the categories that are missing, by its status too.
  await run('localedef', ['--no-archive', '-c', '-i', at('comma.src'), at('comma')]).catch(() => {});
  const [point, comma] = [await everything(), await everything([], { LOCPATH: folder, LC_ALL: 'comma' })];
  assert.equal(comma.get('point').point, ',');
  comma.set('point', point.get('point'));
  assert.deepEqual(comma, point);
});

test('no byte is leaked or read wrongly', async () => {
  await everything(['valgrind', '--quiet', '--leak-check=full', '--errors-for-leak-kinds=all', '--error-exitcode=9']);
});
