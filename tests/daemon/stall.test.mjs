// No request is long on the threads that all clients share, by the processor time of these threads: the heaviest requests of every
// operation, one at a time; and of 32 clients with all of them at random, valid and damaged, control calls of another session do not wait
// for the requests.
// bench/stall.mjs measures.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { readFileSync, readdirSync } from 'node:fs';
import YAML from 'yaml';
import { client } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';
import { HEAVY, prepare, requestsOf } from '../lib/heavy.mjs';
import { storm, witness } from '../lib/stall.mjs';

const SHARED = /^(?:control|MHD-worker)$/, // those that run handlers of short requests, and that read and send
  MOST_MS = 4, // of processor time; the most is 1.5
  MEGABYTE_MS = 2, // more for each of the answer, which is sent in parts
  TIMES = 3; // the least counts: the first fills caches
const CLIENTS = 32,
  CALLS = 3000, // of the other, one after another as theirs; each of the clients gets 15 answers meanwhile
  SEED = Number(process.env.LAGLAB_RANDOM_SEED ?? 20261129);
const ARGS = [
  '--request-cpu-s',
  '1',
  '--max-new-sessions-per-min',
  '1000000',
  '--max-sessions',
  '100000',
  '--max-commands-per-s',
  '100000',
];
const METHODS = ['get', 'post', 'put', 'patch', 'delete'];

let daemon, c, place, operations;

before(async () => {
  daemon = await startDaemon({ args: [...ARGS, '--max-experiments', '100000', '--max-client-experiments', '100000'] });
  c = client(daemon.url);
  place = await prepare(daemon.url, 300);
  const api = YAML.parse((await c.get('/api/v1/openapi.yaml')).text);
  operations = Object.entries(api.paths).flatMap(([path, of]) =>
    METHODS.filter((method) => of[method]).map((method) => ({ method, path, id: of[method].operationId })),
  );
});
after(async () => {
  c.close();
  await daemon.stop();
});

/** Processor time of the shared threads so far, ms. */
function shared_ms() {
  const folder = `/proc/${daemon.pid}/task`;
  let ns = 0;
  for (const id of readdirSync(folder))
    if (SHARED.test(readFileSync(`${folder}/${id}/comm`, 'utf8').trim()))
      ns += Number(readFileSync(`${folder}/${id}/schedstat`, 'utf8').split(' ')[0]);
  return ns / 1e6;
}

/** @param {{method: string, path: string, body?: any}} request */
async function cost_of({ method, path, ...wish }) {
  let least = Infinity;
  for (let i = 0; i < TIMES; i++) {
    const from = shared_ms();
    const answer = await c.call(method, path, { ...wish, timeout: 300000 });
    least = Math.min(least, shared_ms() - from - (MEGABYTE_MS * answer.text.length) / 1e6);
    const key = answer.json?.owner_key ?? answer.json?.teacher_key;
    if (key && answer.headers.location) await c.call('DELETE', answer.headers.location, { key, timeout: 300000 });
    if (answer.json?.token) await c.call('DELETE', path.replace('/members', '/member'), { key: answer.json.token });
    if (least < MOST_MS / 2) break;
  }
  return least;
}

test('every operation of openapi.yaml has its heaviest requests, and none is there no longer', () => {
  assert.deepEqual(
    operations.map(({ id }) => id).filter((id) => !(HEAVY[id]?.(place).length > 0)),
    [],
  );
  assert.deepEqual(
    Object.keys(HEAVY).filter((id) => !operations.some((o) => o.id === id)),
    [],
  );
});

test('no request takes long on the threads that all clients share', async () => {
  const long = [];
  for (const { id, method, path } of operations)
    for (const request of requestsOf(method, path, HEAVY[id]?.(place) ?? [], place)) {
      const ms = await cost_of(request);
      if (ms > MOST_MS) long.push(`${id}: ${ms.toFixed(1)} ms for ${JSON.stringify(request).slice(0, 160)}`);
    }
  assert.deepEqual(long, []);
});

test('32 clients with any of them at random, also damaged: control calls of another do not wait for theirs', async () => {
  const other = await witness(daemon.url);
  const requests = operations.flatMap(({ id, method, path }) => requestsOf(method, path, HEAVY[id]?.(place) ?? [], place));
  const load = await storm(daemon.url, requests, CLIENTS, SEED);
  const { took: _, ...seen } = await other.look(Infinity, CALLS, 0),
    statuses = await load.end();
  const faults = Object.keys(statuses).filter((status) => Number(status) >= 500 && status !== '503' && status !== '507');
  await other.close();
  process.stderr.write(`control calls: ${JSON.stringify(seen)}, the others' answers: ${JSON.stringify(statuses)}\n`);
  assert.deepEqual(faults, [], JSON.stringify(statuses));
  // All send one request after another, without a pause. Calls that wait for requests of the clients are as few as these.
  const each = Object.values(statuses).reduce((sum, n) => sum + n, 0) / CLIENTS;
  assert.ok(each > 1, 'the clients were at work');
  assert.ok(CALLS > 5 * each, `${CALLS} control calls, and ${each} answers to each client, seed ${SEED}`);
});
