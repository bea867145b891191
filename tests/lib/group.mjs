// Several daemons over one PostgreSQL server, and a client that finds its way as a proxy would.
import net from 'node:net';
import { client, pause } from './client.mjs';
import { startDaemon } from './daemon.mjs';

/** A port that was free just now: a daemon has to know its address before it listens. @returns {Promise<number>} */
export const freePort = () =>
  new Promise((resolve) => {
    const server = net.createServer();
    server.listen(0, '127.0.0.1', () => {
      const { port } = /** @type {net.AddressInfo} */ (server.address());
      server.close(() => resolve(port));
    });
  });

const ARGS = ['--threads', '1', '--work-threads', '2', '--max-commands-per-s', '100000', '--max-new-sessions-per-min', '100000'];

/**
 * A daemon of the group; `again` gives one on the address of an earlier one.
 * @param {string} url of the store
 * @param {{lease?: number, args?: string[], port?: number}} [wish]
 */
export async function member(url, { lease = 2, args = [], port } = {}) {
  const at = port ?? (await freePort());
  const daemon = await startDaemon({
    listen: `127.0.0.1:${at}`,
    args: ['--store', url, '--url', `http://127.0.0.1:${at}`, '--lease-s', String(lease), ...ARGS, ...args],
  });
  return { ...daemon, c: client(daemon.url) };
}

/** A daemon of the group that ends with the test. @param {{after: (end: () => Promise<void>) => void}} t @param {string} url
 * @param {Parameters<typeof member>[1]} [wish] */
export async function memberOf(t, url, wish) {
  const daemon = await member(url, wish);
  t.after(async () => {
    daemon.c.close();
    await daemon.kill();
  });
  return daemon;
}

/** The value of a metric, summed over its labels unless they are given. @param {{get: (path: string) => Promise<{text: string}>}} c */
export async function metric(c, name, labels = '') {
  let sum = 0;
  for (const line of (await c.get('/metrics')).text.split('\n')) {
    const found = /^laglab_(\w+)(\{[^}]*\})? (\S+)$/.exec(line);
    if (found && found[1] === name && (found[2] ?? '').includes(labels)) sum += Number(found[3]);
  }
  return sum;
}

/** Repeats a request until it is not refused for the moment; gives its answer and how long that took.
 * @param {() => Promise<import('./client.mjs').Answer>} ask @param {number} [ms] */
export async function eventually(ask, ms = 10000) {
  const begun = performance.now();
  for (;;) {
    let answer;
    try {
      answer = await ask();
      if (answer.status !== 503) return { answer, took: performance.now() - begun };
    } catch {
      // refused or cut: it was killed
    }
    if (performance.now() - begun > ms) throw new Error(`no answer within ${ms} ms: ${answer?.text}`);
    await pause(20);
  }
}
