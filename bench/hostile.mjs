// Four clients that send the heaviest requests that the API takes, without a pause: the latency of other clients, the time until the
// machine is idle afterwards, and whether SIGTERM ends the daemon in time. Each attack alone, then all together; each compared with a run
// without any.
import { digits, pause, printTable, say, writeCsv } from './lib.mjs';
import { loadavg } from 'node:os';
import { startDaemon } from '../tests/lib/daemon.mjs';
import { ARGS, ATTACKS, attack, busiest, cpu_s, measure, prepare } from '../tests/lib/hostile.mjs';

const quick = process.argv.includes('--quick');
const only = process.argv
  .find((word) => word.startsWith('--only='))
  ?.slice(7)
  .split(',');
const seconds = quick ? 4 : 15,
  DRAIN_S = 3,
  GOAL_MS = 100,
  FRAME_MS = 5,
  IDLE_MAX_MS = 30000;

const daemon = await startDaemon({ args: [...ARGS, '--drain-s', String(DRAIN_S)] });
const place = await prepare(daemon.url, quick ? 20000 : 100000);
const MIXED = ['seek', 'look', 'trace', 'heavy_create'];
const cases = only ?? [...ATTACKS, 'mixed', 'all'];
const clients = { mixed: MIXED, all: ATTACKS }; // all: three times as many clients as the goal is for
const rows = [],
  table = [];
let worst = 0;

/** Seconds until the daemon uses less than a tenth of a core, over 200 ms. */
async function idle_after() {
  const from = performance.now();
  for (;;) {
    const before = cpu_s(daemon.pid),
      since = performance.now();
    await pause(200);
    if (cpu_s(daemon.pid) - before < (0.1 * (performance.now() - since)) / 1000 + 0.005) return (performance.now() - from) / 1000;
    if (performance.now() - from > IDLE_MAX_MS) {
      say(`not idle after ${IDLE_MAX_MS / 1000} s: ${await busiest(daemon.pid)}`);
      return Infinity;
    }
  }
}

for (const name of cases) {
  const alone = await measure(daemon.url, quick ? 3 : 6);
  const attackers = attack(daemon.url, clients[name] ?? [name], place, clients[name]?.length ?? 4);
  await pause(1500);
  const under = await measure(daemon.url, seconds);
  await attackers.end();
  const idle_s = await idle_after();
  for (const [what, u] of Object.entries(under)) {
    rows.push({
      attack: name,
      what,
      count: u.count,
      alone_p50_ms: alone[what].p50,
      alone_p99_ms: alone[what].p99,
      p50_ms: u.p50,
      p99_ms: u.p99,
      max_ms: u.max,
      idle_s,
      load: loadavg()[0],
    });
    if (!what.startsWith('frame') && name !== 'all') worst = Math.max(worst, u.p99);
  }
  const p99 = (of) => Object.fromEntries(Object.entries(of).map(([what, u]) => [what, digits(u.p99)]));
  const line = p99(under),
    bare = p99(alone);
  table.push({
    attack: name,
    ...Object.fromEntries(Object.keys(line).map((what) => [what, `${line[what]} (${bare[what]})`])),
    idle_s: digits(idle_s),
  });
  say(`${name}: ${JSON.stringify(line)}, idle after ${digits(idle_s)} s`);
}
printTable('p99 in ms under four hostile clients (and without them)', table);

const last = attack(daemon.url, ATTACKS, place, 8);
await pause(2000);
const from = performance.now();
const how = await daemon.stop();
const stop_s = (performance.now() - from) / 1000;
await last.end();
rows.push({ attack: 'all', what: 'sigterm', count: 1, p50_ms: stop_s * 1000, p99_ms: stop_s * 1000, max_ms: stop_s * 1000 });
say(`SIGTERM under all of them: exit ${how.code ?? how.signal} after ${digits(stop_s)} s (--drain-s ${DRAIN_S}).`);
if (!only)
  writeCsv(
    'hostile',
    `bench/run hostile${quick ? ' --quick' : ''}`,
    {
      attack: 'what four clients send without a pause (mixed: one each of four kinds; all: one client of each kind)',
      what: 'what an ordinary client asks meanwhile; frames: how far off their interval of 16.7 ms',
      count: '',
      alone_p50_ms: 'just before, without the attack',
      alone_p99_ms: '',
      p50_ms: 'under the attack',
      p99_ms: '',
      max_ms: '',
      idle_s:
        'until the daemon uses less than a tenth of a core, after the clients were killed; a search for advice is given up after 10 s',
      load: 'of the machine (1 minute), all programs',
    },
    rows,
  );
const met = (measured, goal) => `${digits(measured)} ms (${measured < goal ? 'met' : 'missed'}: ${goal} ms)`,
  published = Math.max(...rows.filter((r) => r.what === 'frame_published' && r.attack !== 'all').map((r) => r.p99_ms));
say(`Largest p99: requests ${met(worst, GOAL_MS)}; frames as published, off their interval ${met(published, FRAME_MS)}.`);
