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
import { quantile, storm, witness } from '../tests/lib/stall.mjs';

const quick = process.argv.includes('--quick'),
  only = option('only')?.split(','),
  before = option('before');
const SECONDS = quick ? 1 : 2,
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
  all = new Map();

for (const { name, witness } of daemons) rows.push({ daemon: name, operation: 'none', clients: 0, ...(await witness.look(3 * SECONDS)) });
for (const { id, method, path } of operations)
  for (const clients of CLIENTS)
    for (const { name, url, place, witness } of daemons) {
      const load = await storm(url, requestsOf(method, path, HEAVY[id](place), place), clients);
      await pause(200);
      const u = await witness.look(SECONDS);
      const statuses = await load.end();
      const answers = Object.entries(statuses)
        .map(([status, n]) => `${status}: ${n}`)
        .join(', ');
      rows.push({ daemon: name, operation: id, clients, ...u, answers });
      all.set(`${name} ${clients}`, [...(all.get(`${name} ${clients}`) ?? []), ...u.took]);
      console.log(`${id}, ${clients} clients, ${name}: ${digits(u.p50)}, ${digits(u.p99)} ms; ${answers}`);
      await idle(url);
    }
const share = (of, what) => of.reduce((sum, row) => sum + row[what], 0) / of.length;
for (const { name } of daemons)
  for (const clients of CLIENTS) {
    const took = all.get(`${name} ${clients}`),
      of = rows.filter((row) => row.daemon === name && row.clients === clients);
    rows.push({
      daemon: name,
      operation: 'all',
      clients,
      count: took.length,
      p50: quantile(took, 0.5),
      p99: quantile(took, 0.99),
      max: Math.max(...took),
      late: share(of, 'late'),
      lost: share(of, 'lost'),
    });
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

printTable(
  'Control calls of another session, ms, and frames of a watched one',
  rows
    .filter((row) => ['none', 'all'].includes(row.operation))
    .map((row) => {
      const of = rows.filter((one) => one.daemon === row.daemon && one.clients === row.clients && one.operation !== 'all'),
        worst = of.reduce((a, b) => (b.p99 > a.p99 ? b : a));
      return {
        daemon: row.daemon,
        clients: row.clients,
        p50: digits(row.p50),
        p99: digits(row.p99),
        'largest p99': digits(worst.p99),
        of: worst.operation,
        [`operations above ${GOAL_MS} ms`]: of.filter((one) => one.p99 > GOAL_MS).length,
        'frames late': `${digits(100 * row.late, 2)} %`,
        'frames lost': `${digits(100 * row.lost, 2)} %`,
      };
    }),
);
if (!only)
  writeCsv(
    'stall',
    `bench/run stall${quick ? ' --quick' : ''}${before ? ' --before PROGRAM' : ''}`,
    {
      daemon: 'now, or before: the program of --before',
      operation: 'operationId of openapi.yaml; none: without other clients; all: all operations together',
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
