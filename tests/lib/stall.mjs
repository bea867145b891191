// What heavy requests of some clients do to others: the latency of a control call of another session, and the frames of one that is
// watched.
import { fork } from 'node:child_process';
import { fileURLToPath } from 'node:url';
import { client, pause } from './client.mjs';

/** Starts `clients` that send `requests`; `end` gives how many answers of which status they got.
 * @param {string} url @param {any[]} requests */
export async function storm(url, requests, clients, seed = 0) {
  const child = fork(fileURLToPath(new URL('storm.mjs', import.meta.url)), [url, String(clients), String(seed)]);
  const message = () =>
    new Promise((resolve, reject) => child.once('message', resolve).once('exit', () => reject(new Error('the clients ended'))));
  const die = () => child.kill('SIGKILL');
  process.once('exit', die);
  const begun = message();
  child.send(requests);
  await begun;
  return {
    /** @returns {Promise<Record<string, number>>} */
    async end() {
      const told = message();
      child.send('end');
      const statuses = await told;
      process.off('exit', die);
      return statuses;
    },
  };
}

export const quantile = (values, q) => [...values].sort((a, b) => a - b)[Math.min(values.length - 1, Math.floor(q * values.length))];

const SLOT_MS = 1000 / 60;

/** A client of its own: it steps one session and watches another. @param {string} url */
export async function witness(url) {
  const c = client(url, 4);
  const stepped = await c.make({ paused: true, set: { duration_s: 3600 } }),
    watched = await c.make({ set: { duration_s: 3600, 'params.laps': 1000 } });
  const stream = await c.stream(watched, 'bin', { ack: true });
  const received = /** @type {number[]} */ ([]);
  stream.socket.on('message', (/** @type {Buffer} */ _, binary) => {
    if (binary) received.push(performance.now());
  });
  return {
    /** Milliseconds of control calls, and frames that came more than a slot late or not at all, for so long or that number of calls,
     * with a rest after each call. */
    async look(/** @type {number} */ seconds, calls = Infinity, rest_ms = 10) {
      const took = /** @type {number[]} */ ([]),
        from = performance.now(),
        first = received.length;
      while (performance.now() - from < 1000 * seconds && took.length < calls) {
        const before = performance.now();
        const answer = await c.call('POST', `/api/v1/sessions/${stepped.id}/control`, {
          key: stepped.owner_key,
          body: { op: 'step' },
          timeout: 600000,
        });
        took.push(performance.now() - before);
        if (answer.status !== 200) throw new Error(`step: ${answer.status} ${answer.text.slice(0, 200)}`);
        if (rest_ms > 0) await pause(rest_ms);
      }
      const lasted = performance.now() - from,
        frames = received.slice(first),
        expected = lasted / SLOT_MS;
      return {
        took,
        count: took.length,
        p50: quantile(took, 0.5),
        p99: quantile(took, 0.99),
        max: Math.max(...took),
        late: frames.filter((at, i) => i > 0 && at - frames[i - 1] > 2 * SLOT_MS).length / expected,
        lost: Math.max(0, 1 - frames.length / expected),
      };
    },
    async close() {
      await stream.close();
      for (const s of [stepped, watched]) await c.call('DELETE', `/api/v1/sessions/${s.id}`, { key: s.owner_key, timeout: 600000 });
      c.close();
    },
  };
}
