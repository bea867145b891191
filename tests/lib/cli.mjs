// The command line as its tests call it: in a folder that goes when the process ends.
import assert from 'node:assert/strict';
import { spawn, spawnSync } from 'node:child_process';
import { once } from 'node:events';
import { mkdtempSync, readFileSync, readdirSync, rmSync } from 'node:fs';
import { availableParallelism, tmpdir } from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { BINARY } from './daemon.mjs';

export const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
export const SCENARIOS = path.join(ROOT, 'scenarios');

export const folder = mkdtempSync(path.join(tmpdir(), 'laglab-cli-'));
process.once('exit', () => rmSync(folder, { recursive: true, force: true }));

/** @param {string[]} args @param {string} [input] */
export function laglab(args, input = '') {
  const result = spawnSync(BINARY, args, { cwd: folder, input, encoding: 'utf8', maxBuffer: 1 << 28, timeout: 600000 });
  assert.equal(result.signal, null, `laglab ${args.join(' ')} ended by ${result.signal}: ${result.stderr}`);
  return result;
}

/** @param {string[]} args @param {string} [input] */
export function good(args, input) {
  const result = laglab(args, input);
  assert.equal(result.status, 0, `laglab ${args.join(' ')}: ${result.stderr}`);
  assert.equal(result.stderr, '');
  return result.stdout;
}

/** Exit 2, nothing on stdout, one line on stderr that holds all of `words`.
 * @param {string[]} args
 * @param {string[]} words
 * @param {string} [input] */
export function refused(args, words, input) {
  return refusal(laglab(args, input), args, words);
}

/** The results of many calls, which a shell for each processor makes one after another.
 * @param {string[][]} calls @returns {Promise<{status: number, stdout: string, stderr: string}[]>} */
export async function all(calls) {
  const quoted = (arg) => `'${arg.replaceAll("'", "'\\''")}'`,
    at = mkdtempSync(path.join(folder, 'calls-')),
    lines = calls.map((args, i) => `${[BINARY, ...args].map(quoted).join(' ')} >${i}.out 2>${i}.err; echo $? >${i}.status\n`),
    shells = availableParallelism();
  await Promise.all(
    Array.from({ length: shells }, async (_, k) => {
      const shell = spawn('sh', [], { cwd: at, stdio: ['pipe', 'ignore', 'inherit'] });
      shell.stdin.end(lines.filter((_, i) => i % shells === k).join(''));
      await once(shell, 'close');
    }),
  );
  const read = (i, name) => readFileSync(path.join(at, `${i}.${name}`), 'utf8');
  return calls.map((_, i) => ({ status: Number(read(i, 'status')), stdout: read(i, 'out'), stderr: read(i, 'err') }));
}

export function refusal(result, args, words) {
  const what = `laglab ${args.join(' ').slice(0, 200)}: ${result.status} ${result.stderr}`;
  assert.equal(result.status, 2, what);
  assert.equal(result.stdout, '', what);
  assert.match(result.stderr, /^laglab: [^\n]+\n$/, what);
  for (const word of words) assert.ok(result.stderr.includes(word), `${word} is missing: ${what}`);
  return result.stderr;
}

/** @param {string[]} args @param {string} [input] */
export const run = (args, input) => JSON.parse(good(['run', ...args], input));

export function ids() {
  const found = [];
  for (const entry of readdirSync(SCENARIOS, { withFileTypes: true })) {
    if (entry.name === 'experiments') continue;
    if (entry.isDirectory()) for (const name of readdirSync(path.join(SCENARIOS, entry.name))) found.push(`${entry.name}/${name}`);
    else found.push(entry.name);
  }
  return found
    .filter((name) => name.endsWith('.json'))
    .map((name) => name.slice(0, -5))
    .sort();
}
export const scenario = (id) => JSON.parse(readFileSync(path.join(SCENARIOS, `${id}.json`), 'utf8'));
export const schema = () => JSON.parse(good(['schema']));

/** A run is made twice, the second time with a log, which is replayed: the same bytes but for measured times, and the same hash.
 * @param {string} id */
export function checkRepeats(id, wish = ['--duration', '1.5', '--seed', '5']) {
  const log = path.join(folder, 'repeats.log'),
    ask = ['run', id, ...wish],
    texts = [ask, [...ask, '--log', log]].map((args) =>
      good(args)
        .replace(/"wall_s":\t[^,\n]+/, '"wall_s":')
        .replace(/"(ns_per_sim_s|ns_per_test)":\t[^,\n]+/g, '"$1":'),
    );
  assert.equal(texts[0], texts[1], id);
  assert.match(texts[0], /"wall_s":,/);
  const { hash, ticks } = JSON.parse(texts[1].replace('"wall_s":', '"wall_s":0').replace(/"(ns_per_sim_s|ns_per_test)":/g, '"$1":0'));
  for (const line of readFileSync(log, 'utf8').trimEnd().split('\n')) JSON.parse(line);
  assert.ok(ticks >= 5, id);
  assert.deepEqual(JSON.parse(good(['replay', log])), { ticks, compared: ticks, hash }, id);
}

/** Every parameter refuses bad values by name and range. Gives the number of values.
 * @param {boolean} [each] else three parameters of each type and each kind of scenario */
export async function checkBadValues(each = false) {
  const root = schema();
  const follow = (node) => (node.$ref ? { ...root.$defs[node.$ref.split('/').at(-1)], ...node, $ref: undefined } : node);
  /** @type {{name: string, value: string, full: any, sets: string[]}[]} */
  const cases = [];

  /** How many parameters of a type there were. @type {Map<string, number>} */
  const types = new Map();
  /** Whether one more of a type is taken, which is counted. @param {string} type */
  const takes = (type) => {
    types.set(type, (types.get(type) ?? 0) + 1);
    return each || types.get(type) <= 3;
  };

  /** @param {string[]} at @param {string[]} sets what the scenario needs first */
  const walk = (node, at, sets) => {
    const full = follow(node);
    if (full.properties)
      for (const [name, child] of Object.entries(full.properties).filter(([key]) => key !== 'timeline')) walk(child, [...at, name], sets);
    else if (full.items) {
      // An array that may be empty is, unless it is given an element.
      const item = follow(full.items),
        one = !full.minItems && item.properties && !item.required?.length ? ['--set', `${at.join('.')}=[{}]`] : [];
      if (item.properties || item.items) walk(item, [...at, '0'], [...sets, ...one]);
      else if (takes('numbers')) {
        for (const value of [`[${item.minimum - 1}]`, `[${item.maximum * 2 + 1}]`, '[true]', 'nan', '"1"'])
          cases.push({ name: at.join('.'), value, full: item, sets });
      }
    } else if (full.anyOf?.[0].$ref)
      for (const any of full.anyOf)
        walk(any, at, [...sets, '--set', `${sets[0] === 'race' ? 'game' : 'problem'}=${any.$ref.split('/').at(-1)}`]);
    else leaf(at.join('.'), full, sets);
  };
  // Texts that no value of a type can be are read by the type, whichever the parameter: each parameter gets some of them, in turn.
  let turn = 0;
  const some = (texts) => Array.from({ length: 4 }, () => texts[turn++ % texts.length]);
  const leaf = (name, full, sets) => {
    if (!takes([sets[0], full.type, full.enum ? 'enum' : ''].join())) return;
    const values = {
      boolean: some(['yes', '1', '', 'null', '"true"']),
      string: full.enum ? ['maybe', ...some(['', '3', 'null'])] : ['x'.repeat(1000), '\u0007'],
    }[full.type] ?? [
      String(full.minimum - 1),
      String(full.maximum * 2 + 1),
      ...(full.type === 'integer' ? [String(full.minimum + 0.5)] : []),
      ...some(['NaN', 'nan', 'inf', '-inf', '1e999', '-1e999', '', 'fast', '"1"', 'true', 'null', '[1]', '0x10', '1,5', '1e300']),
    ];
    for (const value of values) cases.push({ name, value, full, sets });
  };
  walk(root.oneOf[0], [], ['race']);
  walk(root.oneOf[1], [], ['motion/orbit', '--set', 'methods=[{"method":"rk4"}]']);
  const results = await all(cases.map(({ name, value, sets }) => ['run', ...sets, '--duration', '0.1', '--set', `${name}=${value}`]));
  for (const [i, { name, value, full }] of cases.entries()) {
    const words = [name, ...(full.enum ?? []).slice(0, 6)]; // a message names the first of many
    const message = refusal(results[i], [`${name}=${value}`], words);
    // The message has the range for every number outside of it.
    const numbers = (message.match(/-?\d[\d.]*(e[+-]?\d+)?/g) ?? []).map(Number);
    if (full.minimum !== undefined && /^-?\d+(\.\d+)?$/.test(value))
      assert.ok(numbers.includes(full.minimum) && numbers.includes(full.maximum), message);
  }
  return cases.length;
}
