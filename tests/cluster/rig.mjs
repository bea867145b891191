// A cluster on one machine: daemons, PostgreSQL, HAProxy and clients, each on a machine of its own (net.mjs), with the configuration of
// deploy/cluster. `node tests/cluster/run.mjs` disturbs it; so do tests/daemon/cluster.test.mjs (a little) and bench/cluster.mjs (a lot).
import { execFileSync, fork, spawn, spawnSync } from 'node:child_process';
import { closeSync, mkdirSync, mkdtempSync, openSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { pause } from '../lib/client.mjs';
import { noNamespaces, openNet } from './net.mjs';

const HERE = path.dirname(fileURLToPath(import.meta.url)),
  ROOT = path.resolve(HERE, '../..'),
  POSTGRES = path.join(ROOT, 'tests/support/postgres');
const PORT = 8080,
  START_MS = 30000;
const env = { ...process.env, PATH: `${process.env.PATH}:/usr/sbin:/sbin` }; // where Debian keeps haproxy

/** ms since 1970, as of tests/cluster/load.mjs */
export const now = () => performance.timeOrigin + performance.now();

/** Numbers from 0 to 1 that a seed gives again (mulberry32). @param {number} seed */
export function randomOf(seed) {
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let x = Math.imul(state ^ (state >>> 15), 1 | state);
    x = (x + Math.imul(x ^ (x >>> 7), 61 | x)) ^ x;
    return ((x ^ (x >>> 14)) >>> 0) / 2 ** 32;
  };
}

/** Why there can be no cluster here; empty where there can. @param {string} binary */
export function noCluster(binary) {
  const haproxy = spawnSync('haproxy', ['-v'], { env, encoding: 'utf8' });
  if (haproxy.error) return 'haproxy is not installed';
  if (spawnSync('cc', ['--version']).error) return 'there is no compiler';
  if (!/--lease-s/.test(spawnSync(binary, ['serve', '--help'], { encoding: 'utf8' }).stdout ?? ''))
    return 'this laglab keeps sessions in one daemon: serve has no --lease-s';
  return noNamespaces();
}

/**
 * The configuration of deploy/cluster for these daemons, each by its name and address.
 * @param {string} proxy
 * @param {[string, string][]} daemons
 */
export function haproxyConfig(proxy, daemons) {
  const lines = readFileSync(path.join(ROOT, 'deploy/cluster/haproxy.cfg'), 'utf8').split('\n'),
    first = lines.findIndex((line) => /^\s+server laglab-0 /.test(line));
  if (first < 0) throw new Error('deploy/cluster/haproxy.cfg has no server laglab-0');
  const rest = lines.filter((line) => !/^\s+server laglab-\d/.test(line));
  rest.splice(
    first,
    0,
    '    http-response set-header X-Served-By %s',
    ...daemons.map(([name, address]) => `    server ${name} ${address}:${PORT}`),
  );
  /* All clients come from one address, the machines have no names, and a process here may have few descriptors. */
  return rest
    .join('\n')
    .replace('bind :8080', `bind ${proxy}:80`)
    .replace(/^[ \t]+http-request deny deny_status 429 .*\n/m, '')
    .replace('maxconn 20000', 'maxconn 4096')
    .replace(' resolvers names', '')
    .replace(/^resolvers names\n(?:[ \t]+.*\n)+/m, '');
}

/** A program on one of the machines, started again when it ends by itself, as an orchestrator does. */
class Process {
  /** @param {string} name @param {() => string[]} command @param {string} log */
  constructor(name, command, log) {
    this.name = name;
    this.command = command;
    this.log = log;
    this.wanted = false;
    this.accidents = /** @type {string[]} */ ([]); // how it ended by itself
    this.child = /** @type {import('node:child_process').ChildProcess | null} */ (null);
    this.gone = /** @type {Promise<string>} */ (Promise.resolve(''));
  }

  start() {
    this.wanted = true;
    const [command, ...words] = this.command(),
      file = openSync(this.log, 'a');
    const child = spawn(command, words, { cwd: ROOT, stdio: ['ignore', file, file], env });
    closeSync(file);
    this.child = child;
    this.gone = new Promise((resolve) => {
      child.once('error', (error) => resolve(error.message));
      child.once('exit', (code, signal) => resolve(signal ?? `exit ${code}`));
    });
    this.gone.then((how) => {
      if (this.child === child) this.child = null;
      if (!this.wanted) return;
      this.accidents.push(`${this.name}: ${how}`);
      setTimeout(() => this.wanted && !this.child && this.start(), 1000);
    });
  }

  /** @param {NodeJS.Signals} signal */
  signal(signal) {
    this.child?.kill(signal);
  }

  /** It stays away until it is started. @param {NodeJS.Signals} signal @param {number} [patience_ms] */
  async end(signal, patience_ms = 60000) {
    this.wanted = false;
    this.child?.kill(signal);
    const timer = setTimeout(() => this.child?.kill('SIGKILL'), patience_ms);
    await this.gone;
    clearTimeout(timer);
  }
}

/**
 * @param {{binary: string, daemons?: number, lease_s?: number, fsync?: boolean, args?: string[], seed?: number, folder?: string}} wish
 * `fsync`: the database waits for its disk, as in operation.
 */
export async function startCluster(wish) {
  const { binary, daemons: count = 3, lease_s = 3, fsync = false, args = [], seed = 1 } = wish;
  const random = randomOf(seed),
    names = Array.from({ length: count }, (_, i) => `d${i}`);
  const folder = mkdtempSync(path.join(tmpdir(), 'laglab-cluster-')),
    logs = wish.folder ?? folder;
  mkdirSync(logs, { recursive: true });
  const net = openNet(['proxy', 'data', 'load', ...names]);
  const closing = [() => rmSync(folder, { recursive: true, force: true }), net.close];
  const close = async () => {
    for (const act of closing.splice(0).reverse()) await act();
  };
  /** @type {Set<Process>} */
  const processes = new Set();
  let data = '';
  const die = () => {
    for (const each of processes) each.signal('SIGKILL');
    if (data) spawnSync(POSTGRES, ['remove', data]);
    net.close();
  };
  process.once('exit', die);
  closing.push(() => process.off('exit', die));

  try {
    // ---- the database: its socket in a folder is for the rig, its address for the daemons ----
    data = execFileSync(POSTGRES, ['make'], { encoding: 'utf8' }).trim();
    closing.push(() => execFileSync(POSTGRES, ['remove', data]));
    const database_env = { ...env, LAGLAB_TEST_FSYNC: fsync ? 'on' : 'off' };
    const database = {
      folder: data,
      start: () =>
        execFileSync(net.before('data')[0], [...net.before('data').slice(1), POSTGRES, 'start', data, net.address('data')], {
          env: database_env,
          stdio: 'pipe',
        }),
      kill: () => execFileSync(POSTGRES, ['kill', data], { stdio: 'pipe' }),
      /** Rows of columns. @param {string} command @returns {string[][]} */
      sql: (command) =>
        execFileSync(POSTGRES, ['sql', data, command], { encoding: 'utf8', maxBuffer: 1 << 30 })
          .split('\n')
          .filter(Boolean)
          .map((line) => line.split('|')),
    };
    database.start();
    const store = `postgresql://laglab@${net.address('data')}/lab`;

    // ---- the daemons ----
    const place = (/** @type {string} */ name) => `http://${net.address(name)}:${PORT}`;
    const clock = (/** @type {string} */ name) => path.join(folder, `${name}.clock`);
    /* Not libfaketime: with it threads that wait by the monotonic clock never sleep. */
    const preloaded = path.join(folder, 'date.so');
    execFileSync('cc', ['-shared', '-fPIC', '-o', preloaded, path.join(ROOT, 'tests/lib/date.c')]);
    const daemons = names.map((name) => {
      const own = path.join(folder, name);
      mkdirSync(own);
      const daemon = Object.assign(
        new Process(
          name,
          () => [
            ...net.before(name),
            ...(daemon.faked ? ['env', `LD_PRELOAD=${preloaded}`, `DATE_FILE=${clock(name)}`] : []),
            binary,
            'serve',
            ...['--listen', `${net.address(name)}:${PORT}`, '--url', place(name), '--store', store, '--lease-s', String(lease_s)],
            ...['--data', own, '--trusted-proxy', net.address('proxy')],
            ...['--max-new-sessions-per-min', '1000000', '--max-sessions', '100000', ...args],
          ],
          path.join(logs, `${name}.log`),
        ),
        {
          url: place(name),
          faked: false,
          /** Its time of day from now on. @param {number} ahead_s */
          setClock: (ahead_s) => writeFileSync(clock(name), String(ahead_s)),
        },
      );
      processes.add(daemon);
      return daemon;
    });

    // ---- the proxy ----
    const file = path.join(folder, 'haproxy.cfg');
    writeFileSync(
      file,
      haproxyConfig(
        net.address('proxy'),
        names.map((name) => [name, net.address(name)]),
      ),
    );
    const proxy = new Process('proxy', () => [...net.before('proxy'), 'haproxy', '-db', '-f', file], path.join(logs, 'proxy.log'));
    processes.add(proxy);
    closing.push(async () => {
      for (const each of processes) {
        each.signal('SIGCONT');
        await each.end('SIGKILL');
      }
    });

    // ---- the clients ----
    const [enter, ...words] = net.before('load');
    const child = fork(path.join(HERE, 'load.mjs'), [], {
      execPath: enter,
      execArgv: [...words, process.execPath],
      stdio: ['ignore', 'inherit', 'inherit', 'ipc'],
    });
    closing.push(() => child.kill('SIGKILL'));
    let next = 0;
    const open = /** @type {Map<number, {resolve: Function, reject: Function}>} */ (new Map());
    child.on('message', (/** @type {any} */ { id, answer, error }) => {
      if (error) open.get(id)?.reject(new Error(error));
      else open.get(id)?.resolve(answer);
      open.delete(id);
    });
    child.once('exit', () => {
      for (const { reject } of open.values()) reject(new Error('the clients have ended'));
      open.clear();
    });
    /** @param {string} act @param {any} [wish_] @returns {Promise<any>} */
    const ask = (act, wish_) =>
      new Promise((resolve, reject) => {
        open.set(next, { resolve, reject });
        child.send({ id: next++, act, wish: wish_ });
      });

    const rig = {
      names,
      net,
      database,
      daemons,
      proxy,
      ask,
      random,
      lease_s,
      url: `http://${net.address('proxy')}`,
      servers: Object.fromEntries(daemons.map((daemon) => [daemon.name, daemon.url])),
      any: () => daemons[Math.floor(random() * count)],
      log: (/** @type {string} */ name) => readFileSync(path.join(logs, `${name}.log`), 'utf8'),
      /** Waits until it answers that it takes work. @param {string} place_ */
      ready: async (place_, ms = START_MS) => {
        for (const end = now() + ms; ; ) {
          const { status, text } = await ask('get', { at: `${place_}/readyz` });
          if (status === 200) return;
          if (now() > end) throw new Error(`${place_} is not ready: ${status} ${text}`);
          await pause(50);
        }
      },
      close,
    };
    for (const daemon of daemons) daemon.start();
    for (const daemon of daemons) await rig.ready(daemon.url);
    proxy.start();
    await rig.ready(rig.url);
    return rig;
  } catch (error) {
    await close();
    throw error;
  }
}
