// Clients that send the heaviest small requests of one operation after the other (tests/lib/heavy.mjs), without a pause: the latency of
// a control call of another session, and the frames of one that is watched. `--before PROGRAM` measures another daemon too, in turn with
// this one.
import YAML from 'yaml';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { digits, option, pause, printTable, root, say, start, writeCsv } from './lib.mjs';
import { BINARY } from '../tests/lib/daemon.mjs';
import { HEAVY, prepare, requestsOf } from '../tests/lib/heavy.mjs';
import { storm, witness } from '../tests/lib/stall.mjs';

const quick = process.argv.includes('--quick'),
  only = option('only')?.split(','),
  before = option('before');
const SECONDS = quick ? 1 : 3,
  CLIENTS = quick ? [8] : [4, 8, 32],
  GOAL_MS = 50;
const began = performance.now();

const ARGS = [
  '--max-new-sessions-per-min',
  '1000000',
  '--max-sessions',
  '100000',
  '--max-experiments',
  '100000',
  '--max-client-experiments',
  '100000',
];
const daemons = [],
  data = mkdtempSync(join(tmpdir(), 'laglab-bench-'));
process.on('exit', () => rmSync(data, { recursive: true, force: true }));
for (const [name, program] of [
  ['before', before],
  ['now', BINARY],
]) {
  if (!program) continue;
  const daemon = await start(
    program,
    ['serve', '--listen', '127.0.0.1:0', '--data', join(data, name), ...ARGS],
    (line) => /listening on (http:\S+?)\/?$/.exec(line)?.[1],
    { quiet: true },
  );
  daemons.push({ name, daemon, url: daemon.what, place: await prepare(daemon.what), witness: await witness(daemon.what) });
}

const api = YAML.parse(readFileSync(join(root, 'api/openapi.yaml'), 'utf8'));
const operations = Object.entries(api.paths)
  .flatMap(([path, methods]) =>
    ['get', 'post', 'put', 'patch', 'delete']
      .filter((method) => methods[method])
      .map((method) => ({ id: methods[method].operationId, method, path })),
  )
  .filter(({ id }) => HEAVY[id] && (!only || only.includes(id)));
const rows = [],
  worst = new Map();

for (const { name, witness } of daemons) {
  const u = await witness.look(SECONDS);
  rows.push({ daemon: name, operation: 'none', clients: 0, ...u });
}
for (const { id, method, path } of operations)
  for (const clients of CLIENTS)
    for (const { name, url, place, witness } of daemons) {
      const load = await storm(url, requestsOf(method, path, HEAVY[id](place), place), clients);
      await pause(200);
      const u = await witness.look(SECONDS);
      const statuses = await load.end();
      const answers = Object.entries(statuses).map(([status, n]) => `${status}: ${n}`);
      rows.push({ daemon: name, operation: id, clients, ...u, answers: answers.join(', ') });
      const key = `${name} ${clients}`;
      if (!(worst.get(key)?.p99 > u.p99)) worst.set(key, { ...u, id });
      if (!quick || only || u.p99 > GOAL_MS) console.log(`${id}, ${clients} clients, ${name}: ${digits(u.p99)} ms, ${answers.join(', ')}`);
      await idle(url);
    }

/** Work that was begun for clients that are gone must not count for the next. */
async function idle(/** @type {string} */ url) {
  for (let quiet = 0, i = 0; quiet < 2 && i < 200; i++) {
    const from = performance.now();
    await fetch(`${url}/healthz`);
    const text = await (await fetch(`${url}/metrics`)).text();
    const busy = Number(/^laglab_tasks_running (\d+)/m.exec(text)?.[1] ?? 0);
    quiet = busy === 0 && performance.now() - from < 50 ? quiet + 1 : 0;
    await pause(50);
  }
}

for (const { daemon, witness } of daemons) {
  await witness.close();
  await daemon.stop();
}

const of = (daemon, clients) => rows.filter((r) => r.daemon === daemon && r.clients === clients);
printTable(
  'Control calls of another session, ms, and frames of a watched one, over all operations',
  daemons.flatMap(({ name }) =>
    [0, ...CLIENTS].map((clients) => {
      const them = of(name, clients),
        most = them.reduce((a, b) => (b.p99 > a.p99 ? b : a)),
        mean = (what) => them.reduce((sum, r) => sum + r[what], 0) / them.length;
      return {
        daemon: name,
        clients,
        'median p50': digits([...them].sort((a, b) => a.p50 - b.p50)[them.length >> 1].p50),
        'largest p99': digits(most.p99),
        of: most.operation,
        'operations above 50 ms': them.filter((r) => r.p99 > GOAL_MS).length,
        'frames late': `${digits(100 * mean('late'), 2)} %`,
        'frames lost': `${digits(100 * mean('lost'), 2)} %`,
      };
    }),
  ),
);
if (!only)
  writeCsv(
    'stall',
    `bench/run stall${quick ? ' --quick' : ''}${before ? ' --before PROGRAM' : ''}`,
    {
      daemon: 'now, or before: the program of --before',
      operation: 'operationId of openapi.yaml; none: without other clients',
      clients: 'that send its requests of tests/lib/heavy.mjs without a pause',
      count: 'control calls meanwhile: a step of another session',
      p50: 'ms, of these calls',
      p99: '',
      max: '',
      late: 'part of the frames of a watched session that came more than a slot of 1/60 s late',
      lost: 'part of them that did not come',
      answers: 'that the clients got, by status',
    },
    rows,
  );
say(`${operations.length} operations in ${digits((performance.now() - began) / 1000)} s.`);
