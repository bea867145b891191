// Effects of hostile clients on others: attacks run in processes of their own while this one measures latencies of an ordinary client.
import { fork } from 'node:child_process';
import { readFileSync, readdirSync } from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { client, pause, waitFor, decodeAll } from './client.mjs';

const ATTACKER = path.join(path.dirname(fileURLToPath(import.meta.url)), 'hostile_client.mjs');
const POOL = { kind: 'fluid', scene: 'pool', params: { size: 400 }, duration_s: 3600 };

export const ATTACKS = [
  'seek',
  'look',
  'dry_run',
  'advise',
  'state_at',
  'trace',
  'set_many',
  'results',
  'report',
  'fork',
  'heavy_create',
  'heavy_state',
];
export const ARGS = ['--max-new-sessions-per-min', '1000000', '--max-sessions', '100000'];

/** Targets of the attacks: a large session, one that cannot keep its speed, one with a long past, and an experiment with many rows. */
export async function prepare(url, runs = 20000) {
  const c = client(url),
    long = { timeout: 300000 };
  const pool = await c.make({ scenario: POOL, paused: true }),
    slow = await c.make({ scenario: POOL, speed: 10 });
  const old = await c.make({ scenario: 'race', set: { duration_s: 2000 }, paused: true });
  for (let status = 503; status !== 200; ) {
    const at = { key: old.owner_key, body: { op: 'seek', tick: 90005 }, ...long };
    status = (await c.call('POST', `/api/v1/sessions/${old.id}/control`, at)).status;
    if (status !== 200 && status !== 503) throw new Error(`no past: ${status}`);
  }
  const experiment = (
    await c.call('POST', '/api/v1/experiments', {
      body: {
        scenario: 'race',
        set: { duration_s: 0.1 },
        repeats: runs,
        metrics: ['players.0.input_latency_ms.mean', 'players.0.remote_error_m.mean'],
      },
    })
  ).json;
  if (!experiment.id) throw new Error(`no experiment: ${JSON.stringify(experiment)}`);
  await waitFor(async () => (await c.get(`/api/v1/experiments/${experiment.id}`)).json.state === 'done', 'the experiment', 600000);
  c.close();
  return { pool, slow, old, experiment };
}

/** Starts `count` clients of the attack, or of each of several in turn; `begun` waits for all. `answers` is how many each kind got so far;
 * `end` kills them. */
export function attack(url, names, place, count = 4) {
  const answers = /** @type {Record<string, number>} */ (Object.fromEntries(names.map((/** @type {string} */ name) => [name, 0])));
  const begun = /** @type {string[]} */ ([]);
  let ending = false;
  const children = Array.from({ length: count }, (_, i) => {
    const name = names[i % names.length],
      child = fork(ATTACKER, [url, name, JSON.stringify(place)]);
    child.on('message', (said) => (said === 'begun' ? begun.push(name) : answers[name]++));
    child.once('exit', (code) => {
      if (!ending) throw new Error(`the attacker ${name} ended by itself, with ${code}`);
    });
    return child;
  });
  process.setMaxListeners(process.getMaxListeners() + count);
  for (const child of children) {
    const die = () => child.kill('SIGKILL'); // ends with the test, also when it fails
    process.once('exit', die);
    child.once('close', () => process.off('exit', die));
  }
  return {
    answers,
    begun: () => waitFor(() => begun.length === count, 'the attackers'),
    end: () => {
      ending = true;
      return Promise.all(
        children.map(
          (child) =>
            new Promise((resolve) => {
              if (child.exitCode !== null || child.signalCode !== null) resolve(undefined);
              child.once('close', resolve);
              child.kill('SIGKILL');
            }),
        ),
      );
    },
  };
}

const quantile = (values, q) =>
  values.length ? [...values].sort((a, b) => a - b)[Math.min(values.length - 1, Math.floor(q * values.length))] : NaN;

/**
 * What an ordinary client sees for so long, or in a number of rounds: milliseconds of each kind of request, and by how much frames of a
 * stream come off their interval, as published (by the daemon's own clock) and as received.
 * @returns {Promise<Record<string, {count: number, p50: number, p99: number, max: number}>>}
 */
export async function measure(url, seconds, rounds = Infinity) {
  const c = client(url),
    took = { pause: [], play: [], patch: [], state: [], create: [], delete: [], health: [] };
  const mine = await c.make({ scenario: 'race', set: { duration_s: 1000 } }),
    watched = await c.make({ scenario: 'race', set: { duration_s: 1000 } });
  const timed = async (name, status, call) => {
    const from = performance.now();
    const answer = await call();
    took[name].push(performance.now() - from);
    if (answer.status !== status) throw new Error(`${name}: ${answer.status} ${answer.text.slice(0, 200)}`);
    return answer;
  };
  const stream = await c.stream(watched, 'bin', { ack: true });
  const first = stream.frames.length,
    received = [];
  stream.socket.on('message', (/** @type {Buffer} */ _, binary) => {
    if (binary) received.push(performance.now());
  });
  const end = performance.now() + 1000 * seconds;
  const key = mine.owner_key,
    at = `/api/v1/sessions/${mine.id}`;
  const changing = async () => {
    for (let i = 0; performance.now() < end && i < rounds; i++) {
      await timed('pause', 200, () => c.control(mine, { op: 'pause' }));
      await timed('patch', 200, () => c.patch(mine, { players: { 0: { lag_ms: 50 + (i % 50) } } }));
      await timed('play', 200, () => c.control(mine, { op: 'play' }));
      await timed('state', 200, () => c.get(`${at}/state`, { key }));
      await pause(15);
    }
  };
  const making = async () => {
    for (let i = 0; performance.now() < end && i < rounds; i++) {
      const made = (await timed('create', 201, () => c.call('POST', '/api/v1/sessions', { body: { scenario: 'race', paused: true } })))
        .json;
      await timed('delete', 204, () => c.call('DELETE', `/api/v1/sessions/${made.id}`, { key: made.owner_key }));
      await timed('health', 200, () => c.get('/readyz'));
      await pause(15);
    }
  };
  await Promise.all([changing(), making()]);
  await stream.close();
  for (const s of [mine, watched]) await c.call('DELETE', `/api/v1/sessions/${s.id}`, { key: s.owner_key });
  c.close();
  const off = (times) => times.slice(1).map((t, i) => Math.abs(t - times[i] - 1000 / 60));
  const published = (await decodeAll(stream.frames, 60)).slice(first).map((frame) => frame.clock.wall_us / 1e3);
  const all = { ...took, frame_published: off(published), frame_received: off(received) };
  return Object.fromEntries(
    Object.entries(all).map(([name, values]) => [
      name,
      { count: values.length, p50: quantile(values, 0.5), p99: quantile(values, 0.99), max: quantile(values, 1) },
    ]),
  );
}

/** Processor time of a process so far, s. */
export function cpu_s(pid) {
  const fields = readFileSync(`/proc/${pid}/stat`, 'utf8').split(') ')[1].split(' ');
  return (Number(fields[11]) + Number(fields[12])) / 100;
}

/** Processor time of each thread so far, s, by its name and number. @param {number} pid */
export const threads_s = (pid) =>
  new Map(
    readdirSync(`/proc/${pid}/task`).map((id) => {
      const [head = '', tail = ''] = readFileSync(`/proc/${pid}/task/${id}/stat`, 'utf8').split(') '),
        fields = tail.split(' ');
      return [`${head.split('(')[1]} ${id}`, (Number(fields[11]) + Number(fields[12])) / 100];
    }),
  );

/** CPU of each thread of the process by its name, over a second: those that use more than a hundredth of a core. */
export async function busiest(/** @type {number} */ pid) {
  const before = threads_s(pid);
  await new Promise((resolve) => setTimeout(resolve, 1000));
  return [...threads_s(pid)]
    .map(([name, s]) => ({ name, percent: Math.round(100 * (s - (before.get(name) ?? 0))) }))
    .filter((t) => t.percent > 1)
    .sort((a, b) => b.percent - a.percent)
    .map((t) => `${t.name} ${t.percent} %`)
    .join(', ');
}
