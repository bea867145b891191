// Instructions by valgrind, of whole runs and of their functions: the same numbers each time, on a busy machine too. What starting costs
// cancels out: each run is made with two lengths, and the difference is divided by the steps between them.
import { execFile } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, relative } from 'node:path';
import { fileURLToPath } from 'node:url';
import { promisify } from 'node:util';

const ROOT = fileURLToPath(new URL('../..', import.meta.url)),
  BUILD = process.env.LAGLAB_BUILD ?? join(ROOT, 'build/symbols');
/** The same everywhere: how the stack is aligned follows from its length, and by that what copying takes. */
const ENVIRONMENT = { PATH: '/usr/local/bin:/usr/bin:/bin' };
/** Before the name of a function of which no line is in this project. */
export const LIBRARY = 'library:';

/**
 * Instructions of a run or of a step.
 * @typedef {object} Profile
 * @property {number} total
 * @property {Map<string, number>} compiled by name in the program, with `library:` before those of others: clones of gcc are one, and what
 * is inlined counts for the caller
 * @property {Map<string, number>} written by `file:name` in the sources: its lines alone, wherever they are inlined
 */
/** @typedef {'compiled' | 'written'} Counted */
/** @typedef {{program: string, arguments: string, from: number, to: number, steps_per_unit: number}} Run as in instructions.csv */
/** @typedef {{name: string, from: number, to: number}} Span lines of a function */

/** Builds the release with the lines that counts of functions need, unless LAGLAB_BUILD names a build. */
export async function build() {
  if (process.env.LAGLAB_BUILD) return;
  const command = 'cmake --preset symbols && cmake --build --preset symbols --target laglab www cost_frames';
  await promisify(execFile)('flock', ['build/.lock-symbols', 'sh', '-c', command], { cwd: ROOT, maxBuffer: 64 << 20 });
}

/** @type {Map<string, Span[]>} */
const spans_of_files = new Map();

/** @param {string} source laid out by clang-format: bodies begin and end in the first column @returns {Span[]} */
export function spans(source) {
  const lines = source.split('\n'),
    found = [];
  for (let open = lines.indexOf('{'); open >= 0; open = lines.indexOf('{', open + 1)) {
    let head = open - 1;
    while (head > 0 && /^[\s{}]|^$/.test(lines[head])) head--;
    const signature = lines.slice(head, open).join(' '),
      plain = signature.replaceAll(/__attribute__\s*\(\((?:[^()]|\([^()]*\))*\)\)/g, ''),
      name = /^[A-Z_]+\((\w+)\)$/.exec(plain) ?? /(\w+)\s*\(/.exec(plain), // of MACRO(name): name
      close = lines.findIndex((line, i) => i > open && line.startsWith('}'));
    if (name && close > 0) found.push({ name: name[1], from: head + 1, to: close + 1 });
  }
  return found;
}

/** @param {string} path of a file of this project @returns {Span[]} */
function spans_of(path) {
  let found = spans_of_files.get(path);
  if (!found) spans_of_files.set(path, (found = spans(readFileSync(join(ROOT, path), 'utf8'))));
  return found;
}

/** @param {string} path as the compiler noted it, in whichever folder that was @returns {string} from the project's folder, or '' */
function own_path(path) {
  for (const { index } of path.matchAll(/\/(?=(src|tests|bench)\/)/g)) {
    const rest = path.slice(index + 1);
    if (existsSync(join(ROOT, rest))) return rest;
  }
  return '';
}

/** @param {string} symbol @returns {string} without what gcc adds to clones and libc to versions and instruction sets */
export function plain_name(symbol) {
  const name = symbol.replace(/@.*$/, '').replace(/(\.(constprop|isra|part|cold|lto_priv|\d+)(\.\d+)*)+$/, '');
  return name.replace(/^_*((mem|str|wcs|wmem)[a-z]+)_(sse|avx|evex|erms).*$/, '$1').replace(/^memmove$/, 'memcpy'); // one function
}

/** @param {Map<string, number>} sums @param {string} key @param {number} count */
const add = (sums, key, count) => sums.set(key, (sums.get(key) ?? 0) + count);

/** @param {string} text what cachegrind writes @returns {Profile} of the whole run */
export function profile_of(text) {
  /** @type {Profile} */
  const profile = { total: 0, compiled: new Map(), written: new Map() };
  const own = new Set();
  let file = '',
    name = '';
  for (const line of text.split('\n')) {
    if (line.startsWith('fl=')) file = own_path(line.slice(3));
    else if (line.startsWith('fn=')) name = plain_name(line.slice(3));
    else if (/^\d/.test(line)) {
      const [number, count] = line.split(' ').map(Number),
        span = file ? spans_of(file).find((s) => number >= s.from && number <= s.to) : undefined;
      profile.total += count;
      add(profile.compiled, name, count);
      if (file) own.add(name);
      if (span) add(profile.written, `${file.replace(/^src\//, '')}:${span.name}`, count);
    }
  }
  const named = [...profile.compiled].map(([f, count]) => /** @type {const} */ ([own.has(f) ? f : LIBRARY + f, count]));
  return { ...profile, compiled: new Map(named) };
}

/** @param {string} program @param {string[]} args @returns {Promise<Profile>} of a whole run */
async function profile_run(program, args) {
  const folder = mkdtempSync(join(tmpdir(), 'cost-')),
    out = join(folder, 'out');
  try {
    const options = ['--tool=cachegrind', '--cache-sim=no', `--cachegrind-out-file=${out}`];
    await promisify(execFile)('valgrind', [...options, relative(ROOT, program), ...args], {
      cwd: ROOT,
      env: ENVIRONMENT,
      maxBuffer: 64 << 20,
    });
    return profile_of(readFileSync(out, 'utf8'));
  } finally {
    rmSync(folder, { recursive: true });
  }
}

/** @param {Run} run its program below the build folder, or anywhere by an absolute path @returns {Promise<Profile>} per step */
export async function measure(run) {
  const program = run.program.startsWith('/') ? run.program : join(BUILD, run.program),
    args = (/** @type {number} */ length) => run.arguments.replace('{}', String(length)).split(' '),
    [short, long] = await Promise.all([run.from, run.to].map((length) => profile_run(program, args(length)))),
    steps = (run.to - run.from) * run.steps_per_unit;
  const differences = (/** @type {Counted} */ counted) =>
    new Map([...long[counted]].map(([name, count]) => [name, Math.round((count - (short[counted].get(name) ?? 0)) / steps)]));
  return {
    total: Math.round((long.total - short.total) / steps),
    compiled: differences('compiled'),
    written: differences('written'),
  };
}
