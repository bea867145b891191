// Runs test files of node side by side, each once and in a process of its own, and prints what each said when it has ended.
//   node tests/run.mjs FILE|FOLDER... [--workers=N] [--all] [--renew]
// --workers: how many files at a time; as many as there are processors, and one more. --all: of folders also the files NAME.all.test.mjs.
// --renew: the seconds of these files go to tests/seconds.csv, by which those that take longest begin.
// A file may ask for the browser of its place, which stays open from file to file: tests/page/lib.mjs does.
import { spawn } from 'node:child_process';
import { existsSync, readdirSync, readFileSync, statSync, writeFileSync } from 'node:fs';
import { availableParallelism } from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '..');
const TABLE = path.join(ROOT, 'tests/seconds.csv');
/** A file that has not said a word for so long hangs. */
const SILENT_MS = 600000;
const COUNTS = ['tests', 'suites', 'pass', 'fail', 'cancelled', 'skipped', 'todo'];

/** @param {string} text @returns {never} */
function refuse(text) {
  console.error(`tests/run.mjs: ${text}`);
  process.exit(2);
}

/** @param {string[]} args */
function options(args) {
  const wish = { workers: availableParallelism() + 1, all: false, renew: false, places: /** @type {string[]} */ ([]) };
  for (const arg of args) {
    const [name, value] = arg.split('=');
    if (arg === '--all') wish.all = true;
    else if (arg === '--renew') wish.renew = true;
    else if (name === '--workers') {
      wish.workers = Number(value);
      if (!Number.isInteger(wish.workers) || wish.workers < 1 || wish.workers > 64) refuse(`--workers takes 1 to 64; got ${value}`);
    } else if (arg.startsWith('-')) refuse(`takes FILE|FOLDER... [--workers=N] [--all] [--renew]; got ${arg}`);
    else wish.places.push(arg);
  }
  if (wish.places.length === 0) refuse('takes FILE|FOLDER... [--workers=N] [--all] [--renew]; got no file');
  return wish;
}

/** The files of a place, from the root. @param {string} place @param {boolean} all */
function filesOf(place, all) {
  if (!existsSync(place)) refuse(`${place} is not there`);
  const from = path.relative(ROOT, path.resolve(place));
  if (!statSync(place).isDirectory()) return [from];
  const names = readdirSync(place).filter((name) => name.endsWith('.test.mjs') && (all || !name.endsWith('.all.test.mjs')));
  if (names.length === 0) refuse(`no test in ${place}`);
  return names.map((name) => path.join(from, name));
}

/** How long each file took. */
function table() {
  const rows = readFileSync(TABLE, 'utf8').trim().split('\n').slice(1);
  return new Map(rows.map((row) => /** @type {[string, number]} */ ([row.split(',')[0], Number(row.split(',')[1])])));
}

/** The browser of one worker, started when a file first asks for it, and again when it has ended. */
class Browser {
  /** @type {ReturnType<typeof import('./page/lib.mjs').serve> | null} */
  #server = null;

  async address() {
    this.#server ??= this.#start().catch((error) => {
      this.#server = null;
      throw error;
    });
    return (await this.#server).address;
  }

  async #start() {
    const { serve } = await import('./page/lib.mjs');
    const server = await serve();
    server.browser.on('disconnected', () => {
      this.#server = null;
    });
    return server;
  }

  async close() {
    const server = await this.#server?.catch(() => null);
    await server?.browser.close();
  }
}

/** The files that run now, each the first process of a group. @type {Set<number>} */
const running = new Set();

/** Ends a file and what it has started. @param {number} pid @param {NodeJS.Signals} signal */
function end(pid, signal) {
  try {
    process.kill(-pid, signal);
  } catch {} /* nothing is left */
}

/** @param {string} file @param {Browser} browser */
function run(file, browser) {
  return new Promise((resolve) => {
    const start = Date.now();
    const { FORCE_COLOR, ...env } = process.env;
    const child = spawn(process.execPath, ['--test-reporter=spec', file], {
      cwd: ROOT,
      env,
      stdio: ['ignore', 'pipe', 'pipe', 'ipc'],
      detached: true,
    });
    const pid = /** @type {number} */ (child.pid);
    running.add(pid);
    let text = '';
    const timer = setTimeout(() => end(pid, 'SIGKILL'), SILENT_MS);
    for (const stream of [child.stdout, child.stderr])
      stream?.setEncoding('utf8').on('data', (/** @type {string} */ more) => {
        text += more;
        timer.refresh();
      });
    child.on('message', async () => {
      const answer = await browser.address().then(
        (address) => ({ address }),
        (error) => ({ error: error.message }),
      );
      if (child.connected) child.send(answer);
    });
    child.on('exit', () => end(pid, 'SIGKILL')); // what it left behind would hold its output open
    child.on('close', (code, signal) => {
      clearTimeout(timer);
      running.delete(pid);
      resolve({ file, text, ended: code ?? signal, seconds: (Date.now() - start) / 1000 });
    });
  });
}

/** What a file said without its counts, its counts, and its list of what failed.
 * @param {{file: string, text: string, ended: number | string}} result */
function read({ file, text, ended }) {
  const counts = Object.fromEntries(COUNTS.map((name) => [name, 0]));
  const lines = text.split('\n');
  const from = lines.lastIndexOf(text.match(/^ℹ tests \d+$/gm)?.at(-1) ?? 'no counts');
  if (from >= 0)
    for (const line of lines.splice(from, COUNTS.length + 1)) {
      const [, name, value] = /^ℹ (\w+) ([\d.]+)$/.exec(line) ?? [];
      if (name in counts) counts[name] = Number(value);
    }
  const list = lines.lastIndexOf('✖ failing tests:');
  let failed = list < 0 ? '' : lines.splice(list).slice(1).join('\n').trim();
  if (counts.fail + counts.cancelled === 0 && (ended !== 0 || counts.tests === 0)) {
    counts.fail++;
    counts.tests++;
    failed = `${file}: ${ended === 0 ? 'has no test' : `ended with ${ended} and no failed test`}`;
  }
  return { text: lines.join('\n').trim(), counts, failed };
}

const wish = options(process.argv.slice(2));
const seconds = table();
const files = [...new Set(wish.places.flatMap((place) => filesOf(place, wish.all)))];
files.sort((a, b) => (seconds.get(b) ?? Number.POSITIVE_INFINITY) - (seconds.get(a) ?? Number.POSITIVE_INFINITY) || (a < b ? -1 : 1));
for (const signal of /** @type {NodeJS.Signals[]} */ (['SIGINT', 'SIGTERM', 'SIGHUP']))
  process.once(signal, () => {
    for (const pid of running) end(pid, signal);
    process.exit(130);
  });

const start = Date.now();
const sum = Object.fromEntries(COUNTS.map((name) => [name, 0]));
/** @type {string[]} */
const failures = [];
await Promise.all(
  Array.from({ length: Math.min(wish.workers, files.length) }, async () => {
    const browser = new Browser();
    for (let file = files.shift(); file !== undefined; file = files.shift()) {
      const result = await run(file, browser);
      const { text, counts, failed } = read(result);
      console.log(`\n== ${file} (${result.seconds.toFixed(1)} s)\n${text}`);
      for (const name of COUNTS) sum[name] += counts[name];
      if (failed !== '') failures.push(failed);
      seconds.set(file, result.seconds);
    }
    await browser.close();
  }),
);
if (failures.length > 0) console.log(`\n✖ failing tests:\n${failures.join('\n\n')}`);
console.log('');
for (const name of COUNTS) console.log(`ℹ ${name} ${sum[name]}`);
console.log(`ℹ duration_ms ${Date.now() - start}`);
if (wish.renew) {
  const rows = [...seconds].filter(([file]) => existsSync(path.join(ROOT, file))).sort(([a], [b]) => (a < b ? -1 : 1));
  writeFileSync(TABLE, `file,seconds\n${rows.map(([file, s]) => `${file},${s.toFixed(1)}`).join('\n')}\n`);
}
process.exitCode = sum.fail + sum.cancelled > 0 ? 1 : 0;
