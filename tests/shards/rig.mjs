// Shards on one machine: daemons, HAProxy and clients, each on a machine of its own (net.mjs), with the configuration of deploy/shards.
// `node tests/shards/run.mjs` disturbs them; so do tests/daemon/shards.test.mjs (a little) and bench/shards.mjs (a lot).
import { fork, spawn, spawnSync } from 'node:child_process';
import { closeSync, mkdirSync, mkdtempSync, openSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { pause } from '../lib/client.mjs';
import { haproxyConfig } from '../lib/shards.mjs';
import { noNamespaces, openNet } from './net.mjs';

const HERE = path.dirname(fileURLToPath(import.meta.url)),
  ROOT = path.resolve(HERE, '../..');
const PORT = 8080,
  START_MS = 30000;
const env = { ...process.env, PATH: `${process.env.PATH}:/usr/sbin:/sbin` }; // where Debian keeps haproxy

/** ms since 1970, as of load.mjs */
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

/** Why there can be no shards here; empty where there can. */
export function noShards() {
  if (spawnSync('haproxy', ['-v'], { env }).error) return 'haproxy is not installed';
  return noNamespaces();
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

/** @param {{binary: string, shards?: number, args?: string[], seed?: number, folder?: string}} wish `folder`: of the messages */
export async function startRig({ binary, shards: count = 3, args = [], seed = 1, folder: wanted }) {
  const random = randomOf(seed),
    names = Array.from({ length: count }, (_, i) => `s${i}`);
  const folder = mkdtempSync(path.join(tmpdir(), 'laglab-shards-')),
    logs = wanted ?? folder;
  mkdirSync(logs, { recursive: true });
  const net = openNet(['proxy', 'load', ...names]);
  const closing = [() => rmSync(folder, { recursive: true, force: true }), net.close];
  const close = async () => {
    for (const act of closing.splice(0).reverse()) await act();
  };
  /** @type {Set<Process>} */
  const processes = new Set();
  const die = () => {
    for (const each of processes) each.signal('SIGKILL');
    net.close();
  };
  process.once('exit', die);
  closing.push(() => process.off('exit', die));

  try {
    const place = (/** @type {string} */ name) => `${net.address(name)}:${PORT}`;
    const daemons = names.map((name) => {
      const own = path.join(folder, name);
      mkdirSync(own);
      const daemon = Object.assign(
        new Process(
          name,
          () => [
            ...net.before(name),
            ...[binary, 'serve', '--listen', place(name), '--data', own, '--shard', name, '--trusted-proxy', net.address('proxy')],
            ...['--max-new-sessions-per-min', '1000000', '--max-sessions', '100000', '--max-client-classes', '1000', ...args],
          ],
          path.join(logs, `${name}.log`),
        ),
        { url: `http://${place(name)}` },
      );
      processes.add(daemon);
      return daemon;
    });

    // ---- the proxy ----
    const file = path.join(folder, 'haproxy.cfg');
    writeFileSync(
      file,
      haproxyConfig(
        `${net.address('proxy')}:80`,
        names.map((name) => [name, place(name)]),
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
      daemons,
      proxy,
      ask,
      random,
      url: `http://${net.address('proxy')}`,
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

// ---- faults ----

/** @typedef {Awaited<ReturnType<typeof startRig>>} Rig */

/** Until it takes sessions. @param {Rig} rig @param {Rig['daemons'][number]} daemon */
async function start({ ready }, daemon) {
  daemon.start();
  await ready(daemon.url);
}

/**
 * Each returns when its cause is over. `weight`: how often among random ones.
 * @type {Record<string, {weight: number, what: string, act: (rig: Rig) => Promise<void>}>}
 */
export const FAULTS = {
  killed: {
    weight: 20,
    what: 'a daemon by SIGKILL, started again after 0.5 to 2 s',
    act: async (rig) => {
      const daemon = rig.any();
      await daemon.end('SIGKILL');
      await pause(500 + 1500 * rig.random());
      await start(rig, daemon);
    },
  },
  stopped: {
    weight: 14,
    what: 'a daemon by SIGTERM, started again when it has ended',
    act: async (rig) => {
      const daemon = rig.any();
      await daemon.end('SIGTERM');
      await start(rig, daemon);
    },
  },
  frozen: {
    weight: 5,
    what: 'a daemon by SIGSTOP for 3 s, then SIGCONT',
    act: async ({ any }) => {
      const daemon = any();
      daemon.signal('SIGSTOP');
      await pause(3000);
      daemon.signal('SIGCONT');
    },
  },
  'cut off': {
    weight: 5,
    what: 'the cable of a daemon for 3 s',
    act: async ({ any, net }) => {
      const { name } = any();
      net.cut(name);
      await pause(3000);
      net.heal(name);
    },
  },
  'proxy restarted': {
    weight: 4,
    what: 'HAProxy by SIGKILL, started again at once',
    act: async ({ proxy }) => {
      await proxy.end('SIGKILL');
      proxy.start();
    },
  },
  'rolling restart': {
    weight: 2,
    what: 'all daemons by SIGTERM, one after the other',
    act: async (rig) => {
      for (const daemon of rig.daemons) {
        await daemon.end('SIGTERM');
        await start(rig, daemon);
      }
    },
  },
};

/** The kinds of `count` faults, in the order of a shuffled list. @param {number} count @param {() => number} random @returns {string[]} */
export function draw(count, random) {
  const possible = Object.keys(FAULTS),
    all = possible.reduce((sum, kind) => sum + FAULTS[kind].weight, 0);
  const kinds = possible.flatMap((kind) => Array(Math.max(1, Math.round((count * FAULTS[kind].weight) / all))).fill(kind));
  for (let i = kinds.length - 1; i > 0; i--) {
    const k = Math.floor(random() * (i + 1));
    [kinds[i], kinds[k]] = [kinds[k], kinds[i]];
  }
  while (kinds.length < count) kinds.push(possible[0]);
  return kinds.slice(0, count);
}
