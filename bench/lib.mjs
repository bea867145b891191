// What the benchmarks share: the machine, processes, sessions, medians, tables, CSV.
import { execFileSync, spawn } from 'node:child_process';
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { cpus, loadavg, release, tmpdir, totalmem } from 'node:os';
import { dirname, join, relative } from 'node:path';
import { createInterface } from 'node:readline';
import { fileURLToPath } from 'node:url';
import { fingerprint } from './rooms.mjs';

export const root = dirname(dirname(fileURLToPath(import.meta.url)));
export const build = process.env.BENCH_BUILD ?? join(root, 'build/profiled');
export const laglab = join(build, 'laglab');
export const results = process.env.BENCH_RESULTS ?? join(root, 'bench', 'results');
export const streamClient = join(build, 'bench', 'stream_client');

/** Put before servers and clients alike where other work shares the machine: `chrt -r 1`. The results record it. */
const prefix = (process.env.BENCH_PREFIX ?? '').split(' ').filter(Boolean);
const prefixed = (command, args) => [...prefix, command, ...args];

/** The value of `--name VALUE` on the command line. @param {string} name */
export function option(name) {
  const at = process.argv.indexOf(`--${name}`);
  return at < 0 ? undefined : process.argv[at + 1];
}

// ---- numbers ----

const sorted = (values) => [...values].sort((a, b) => a - b);
export const median = (values) => {
  const s = sorted(values);
  return s.length % 2 ? s[(s.length - 1) / 2] : (s[s.length / 2 - 1] + s[s.length / 2]) / 2;
};
export const quantile = (values, q) => sorted(values)[Math.round(q * (values.length - 1))];
export const range = (values) => ({ median: median(values), min: Math.min(...values), max: Math.max(...values) });
export const digits = (x, n = 3) => (Number.isFinite(x) ? String(Number(x.toPrecision(n))) : '-');
export const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

/** Calls `measure` for each of `things` in turn, `rounds` times, so that a change of the machine's load meets all of them. */
export async function interleave(rounds, things, measure) {
  const results = new Map(things.map((thing) => [thing, []]));
  for (let round = 0; round < rounds; round++) for (const thing of things) results.get(thing).push(await measure(thing, round));
  return results;
}

// ---- results ----

const first = (command, args) => {
  try {
    return execFileSync(command, args, { cwd: root, stdio: ['ignore', 'pipe', 'ignore'] })
      .toString()
      .split('\n')[0];
  } catch {
    return 'unknown';
  }
};

const loadBefore = loadavg()[0];

/** What a number means nothing without. */
export function machine() {
  const cache = readFileSync(join(build, 'CMakeCache.txt'), 'utf8'),
    option = (/** @type {string} */ name) => new RegExp(`^${name}:\\w+=(.*)$`, 'm').exec(cache)?.[1] ?? '',
    linked = option('LAGLAB_LTO') === 'ON' ? ' -flto' : '',
    flags = `${option('LAGLAB_OPTIMISE')}${linked}${option('LAGLAB_PROFILE') === 'use' ? ' by a profile' : ''}`;
  const dirty = first('git', ['status', '--porcelain', '--untracked-files=no', 'src', 'bench']) ? ' with changes' : '';
  return {
    cpu: `${cpus().length} x ${cpus()[0].model.trim()}`,
    memory: `${Math.round(totalmem() / 2 ** 30)} GiB`,
    kernel: `Linux ${release()}`,
    compiler: `${first('cc', ['--version'])}, ${flags}`,
    node: process.version,
    commit: `${first('git', ['rev-parse', '--short=12', 'HEAD'])}${dirty}`,
    date: new Date().toISOString().slice(0, 16) + 'Z',
    priority: prefix.length ? `servers and clients under \`${prefix.join(' ')}\`` : 'as all else',
    load: `1-minute average ${loadBefore.toFixed(2)} before, ${loadavg()[0].toFixed(2)} after`,
  };
}

let tables = '';

/** CSV (RFC 4180) under lines of comments: machine, what the columns are. The tables that were printed since the last go into the .txt file
 * of the same name. */
export function writeCsv(name, command, columns, rows) {
  const cell = (value) => (/[",\n]/.test(String(value)) ? `"${String(value).replaceAll('"', '""')}"` : String(value ?? ''));
  const lines = [
    ...Object.entries(machine()).map(([key, value]) => `# ${key}: ${value}`),
    `# rooms: ${fingerprint(name)}`,
    `# command: ${process.env.BENCH_BUILD ? `BENCH_BUILD=${relative(root, build)} ` : ''}${command}`,
    ...Object.entries(columns).map(([column, meaning]) => `# ${column}: ${meaning}`),
    Object.keys(columns).join(','),
    ...rows.map((row) =>
      Object.keys(columns)
        .map((column) => cell(row[column]))
        .join(','),
    ),
  ];
  const file = join(results, name);
  mkdirSync(dirname(file), { recursive: true });
  writeFileSync(`${file}.csv`, lines.join('\n') + '\n');
  if (tables !== '') writeFileSync(`${file}.txt`, tables.trimStart());
  tables = '';
}

export function printTable(title, rows) {
  const columns = Object.keys(rows[0]);
  const width = columns.map((c) => Math.max(c.length, ...rows.map((row) => String(row[c]).length)));
  const line = (cells) => cells.map((cell, i) => (i === 0 ? String(cell).padEnd(width[i]) : String(cell).padStart(width[i]))).join('  ');
  say(['', title, line(columns), ...rows.map((row) => line(columns.map((c) => row[c])))].join('\n'));
}

/** Prints a line that belongs to the result. */
export function say(text) {
  console.log(text);
  tables += text + '\n';
}

// ---- processes ----

const running = new Set();
process.on('exit', () => running.forEach((child) => child.kill('SIGKILL')));
for (const signal of ['SIGINT', 'SIGTERM']) process.on(signal, () => process.exit(130));

/** Starts a server and waits for the line of its output that `ready` makes something of. */
export async function start(command, args, ready, wish = {}) {
  const [program, ...rest] = prefixed(command, args);
  const child = spawn(program, rest, { stdio: ['ignore', 'pipe', wish.quiet ? 'ignore' : 'inherit'], cwd: wish.cwd });
  running.add(child);
  const ended = new Promise((resolve) =>
    child.once('exit', (code, signal) => {
      running.delete(child);
      resolve(code ?? signal);
    }),
  );
  const lines = createInterface({ input: child.stdout });
  const found = new Promise((resolve) =>
    lines.on('line', (line) => {
      const what = ready(line);
      if (what) resolve(what);
    }),
  );
  const late = pause(30000).then(() => 'late');
  const what = await Promise.race([found, ended.then(() => null), late]);
  if (what === null || what === 'late') throw new Error(`${command} ${args.join(' ')} did not start`);
  return {
    pid: child.pid,
    what,
    ended,
    async stop() {
      child.kill('SIGTERM');
      if ((await Promise.race([ended, pause(8000).then(() => 'late')])) === 'late') child.kill('SIGKILL');
      await ended;
    },
  };
}

/** Runs a program to its end with `input`; its standard output. */
export function run(command, args, input = '') {
  return new Promise((resolve, reject) => {
    const [program, ...rest] = prefixed(command, args);
    const child = spawn(program, rest, { stdio: ['pipe', 'pipe', 'inherit'] });
    running.add(child);
    let text = '';
    child.stdout.on('data', (part) => {
      text += part;
    });
    child.on('error', reject);
    child.stdin.on('error', () => {}); // it may end before it has read all
    child.on('exit', (code) => {
      running.delete(child);
      if (code === 0) resolve(text);
      else reject(new Error(`${command} ${args.join(' ')} ended with ${code}: ${text.slice(0, 400)}`));
    });
    child.stdin.end(input);
  });
}

const folders = [];
process.on('exit', () => folders.forEach((folder) => rmSync(folder, { recursive: true, force: true })));

function temporaryFolder() {
  const folder = mkdtempSync(join(tmpdir(), 'laglab-bench-'));
  folders.push(folder);
  return folder;
}

// ---- the daemon ----

/** A daemon with a store of its own. The limits that a classroom would never meet are raised for the load of a benchmark. */
export const startDaemon = (...options) => startDaemonOf(laglab, ...options);

/** The same of another program, which `--before BIN` names. */
export async function startDaemonOf(binary, ...options) {
  const daemon = await start(
    binary,
    [
      'serve',
      '--listen',
      '127.0.0.1:0',
      '--data',
      temporaryFolder(),
      '--max-new-sessions-per-min',
      '1000000',
      '--max-viewers',
      '30000',
      ...options,
    ],
    (line) => /listening on (http:\S+?)\/?$/.exec(line)?.[1],
    { quiet: true },
  );
  return { ...daemon, url: daemon.what, port: Number(new URL(daemon.what).port) };
}

/** Makes a session that plays for an hour. */
export async function makeSession(url, scenario = 'race', set = {}) {
  const response = await fetch(`${url}/api/v1/sessions`, {
    method: 'POST',
    headers: { 'content-type': 'application/json' },
    body: JSON.stringify({ scenario, set: { duration_s: 3600, 'params.laps': 1000, ...set } }),
  });
  if (response.status !== 201) throw new Error(`no session: ${response.status} ${await response.text()}`);
  const session = await response.json();
  return { ...session, stream: `/api/v1/sessions/${session.id}/stream` };
}

/** Runs the viewers of `targets` (lines of stream_client) against a server. */
export async function measureStreams({ port, mode, pid, targets, warmup, seconds, ack = true, hz = 60 }) {
  const options = ['--port', port, '--mode', mode, '--pid', pid, '--warmup', warmup, '--seconds', seconds, '--hz', hz];
  if (!ack) options.push('--no-ack');
  return JSON.parse(await run(streamClient, options.map(String), targets.join('\n') + '\n'));
}
