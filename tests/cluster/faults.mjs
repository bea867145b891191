// What happens to a cluster. Each fault returns when its cause is over; how long its effects last is measured by who calls.
import { pause } from '../lib/client.mjs';

/** @typedef {Awaited<ReturnType<typeof import('./rig.mjs').startCluster>>} Rig */

/**
 * With the right time of day, and until it takes sessions: one that finds no database when it starts ends.
 * @param {Rig} rig
 * @param {Rig['daemons'][number]} daemon
 */
async function start({ ready }, daemon) {
  daemon.faked = false;
  daemon.start();
  await ready(daemon.url);
}

/**
 * `weight`: how often among random ones. `beyond_s`: how long a daemon is frozen or cut off that must lose its sessions.
 * @type {Record<string, {weight: number, what: string, act: (rig: Rig, beyond_s: number) => Promise<void>}>}
 */
export const FAULTS = {
  killed: {
    weight: 26,
    what: 'a daemon by SIGKILL, started again after 0.5 to 2 s',
    act: async (rig) => {
      const daemon = rig.any();
      await daemon.end('SIGKILL');
      await pause(500 + 1500 * rig.random());
      await start(rig, daemon);
    },
  },
  drained: {
    weight: 12,
    what: 'a daemon by SIGTERM, started again when it has ended',
    act: async (rig) => {
      const daemon = rig.any();
      await daemon.end('SIGTERM');
      await start(rig, daemon);
    },
  },
  'frozen briefly': {
    weight: 10,
    what: 'a daemon by SIGSTOP for a third of its lease, then SIGCONT',
    act: async ({ any, lease_s }) => {
      const daemon = any();
      daemon.signal('SIGSTOP');
      await pause((1000 * lease_s) / 3);
      daemon.signal('SIGCONT');
    },
  },
  'frozen beyond its lease': {
    weight: 10,
    what: 'a daemon by SIGSTOP, SIGCONT after its sessions are others',
    act: async ({ any }, beyond_s) => {
      const daemon = any();
      daemon.signal('SIGSTOP');
      await pause(1000 * beyond_s);
      daemon.signal('SIGCONT');
    },
  },
  'cut off briefly': {
    weight: 10,
    what: 'the cable of a daemon, for a third of its lease',
    act: async ({ any, net, lease_s }) => {
      const { name } = any();
      net.cut(name);
      await pause((1000 * lease_s) / 3);
      net.heal(name);
    },
  },
  'cut off beyond its lease': {
    weight: 10,
    what: 'the cable of a daemon',
    act: async ({ any, net }, beyond_s) => {
      const { name } = any();
      net.cut(name);
      await pause(1000 * beyond_s);
      net.heal(name);
    },
  },
  'database crashed': {
    weight: 8,
    what: 'PostgreSQL stopped as a crash does, back after 0.2 to 1 s',
    act: async ({ database, random }) => {
      database.kill();
      await pause(200 + 800 * random());
      database.start();
    },
  },
  'database away beyond the lease': {
    weight: 2,
    what: 'PostgreSQL stopped as a crash does',
    act: async ({ database }, beyond_s) => {
      database.kill();
      await pause(1000 * beyond_s);
      database.start();
    },
  },
  'proxy restarted': {
    weight: 6,
    what: 'HAProxy by SIGKILL, started again at once',
    act: async ({ proxy }) => {
      await proxy.end('SIGKILL');
      proxy.start();
    },
  },
  'clock wrong': {
    weight: 6,
    what: 'a daemon is drained and started again; then its time of day jumps a minute ahead or back, and stays there until the next start',
    act: async ({ any, random, ready }) => {
      const daemon = any();
      await daemon.end('SIGTERM');
      daemon.faked = true;
      daemon.setClock(0);
      daemon.start();
      await ready(daemon.url);
      await pause(500);
      daemon.setClock(random() < 0.5 ? 60 : -60);
      await pause(2000);
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
