// Three daemons, PostgreSQL and HAProxy on machines of their own (network namespaces, root) under load, while everything is killed,
// frozen and cut off; then all daemons are replaced, one after the other. And what an acknowledged command costs by PostgreSQL and by
// SQLite.
//   bench/run cluster [--quick] [--sessions=500] [--faults=100] [--lease=10] [--beyond=30] [--steady=6] [--seed=1] [--only=store|faults]
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { digits, laglab, pause, printTable, say, startDaemon, writeCsv } from './lib.mjs';
import { ownPostgres } from '../tests/lib/chaos.mjs';
import { client } from '../tests/lib/client.mjs';
import { FAULTS, draw } from '../tests/cluster/faults.mjs';
import { noCluster, randomOf } from '../tests/cluster/rig.mjs';
import { broken, disturb, summary } from '../tests/cluster/run.mjs';

const word = (name, standard) => process.argv.find((each) => each.startsWith(`--${name}=`))?.slice(name.length + 3) ?? standard;
const option = (name, standard) => Number(word(name, standard));
const quick = process.argv.includes('--quick');
const sessions = option('sessions', quick ? 60 : 500),
  count = option('faults', quick ? 20 : 100),
  lease_s = option('lease', quick ? 3 : 10),
  beyond_s = option('beyond', quick ? 6 : 30),
  steady_s = option('steady', quick ? 2 : 6),
  seed = option('seed', 1),
  only = word('only', '');
const HZ = 20,
  EVERY_MS = 1000,
  TWINS = quick ? 10 : 50;

const missing = noCluster(laglab);
if (missing) {
  console.error(missing);
  process.exit(1);
}
let good = true;

// ---- faults ----

if (only !== 'store') {
  const begun = performance.now(),
    logs = mkdtempSync(join(tmpdir(), 'laglab-cluster-logs-'));
  const report = await disturb({
    binary: laglab,
    sessions,
    kinds: draw(count, randomOf(seed)),
    lease_s,
    beyond_s,
    hz: HZ,
    every_ms: EVERY_MS,
    seed,
    fsync: true,
    quiet_s: quick ? 5 : 20,
    steady_s,
    upgrade_rest_s: 10,
    twins: TWINS,
    logs,
    say: console.log,
  });
  const wall_s = (performance.now() - begun) / 1000;
  const kinds = [...new Set(report.faults.map(({ kind }) => kind))].sort(
    (a, b) => Object.keys(FAULTS).indexOf(a) - Object.keys(FAULTS).indexOf(b),
  );
  const rows = kinds.map((kind) => {
    const of = report.faults.filter((fault) => fault.kind === kind),
      { viewers, p50_s, p99_s, max_s } = summary(
        of.flatMap(({ gaps }) => gaps),
        HZ,
      );
    return { fault: kind, times: of.length, viewers, gap_p50_s: digits(p50_s), gap_p99_s: digits(p99_s), gap_max_s: digits(max_s) };
  });
  printTable(`${sessions} sessions on three daemons, ${count} faults, leases of ${lease_s} s, beyond: ${beyond_s} s`, rows);
  const { totals, latency, upgrades } = report;
  const row = {
    ...totals,
    stray_ms: digits(totals.stray_ms),
    command_p50_ms: digits(latency.p50),
    command_p99_ms: digits(latency.p99),
    upgrade_longest_end_s: digits(Math.max(...upgrades)),
    lease_s,
    beyond_s,
    wall_s: digits(wall_s),
  };
  say(JSON.stringify({ ...row, closed: report.closed, statuses: report.statuses }));
  for (const finding of report.findings.slice(0, 20)) say(finding);
  const bad = broken(report);
  good &&= bad.length === 0;
  const outcome = bad.length ? `MISSED: ${bad.join(', ')}` : 'Met';
  say(`${outcome}: no acknowledged command lost, no session run twice at a time, hashes of an undisturbed twin.`);
  const times = `--lease=${lease_s} --beyond=${beyond_s} --steady=${steady_s}`,
    command = `bench/run cluster --sessions=${sessions} --faults=${count} ${times} --seed=${seed}`;
  writeCsv(
    'cluster',
    command,
    {
      sessions:
        'each with a viewer of the clock at 20 Hz and a command a second; every eighth has a second viewer, connected to its daemon',
      faults: '',
      acknowledged: 'commands',
      unanswered: 'commands that got an error, or no answer in 15 s',
      unanswered_stored: 'of these, those that the log has',
      lost: 'acknowledged, and not in the log at the tick of the answer',
      twice: 'commands that the log has more than once',
      disorder: 'lines with a lower tick than the one before',
      lines: 'of all logs',
      holes: 'logs with a line missing',
      strangers: 'lines written by a daemon that did not own the session then',
      frames: 'that viewers got',
      second_viewers: '',
      stray: 'spans of frames that a daemon took outside of the time in which it owned the session',
      stray_ms: 'the longest of them',
      moves: 'of sessions to another daemon',
      back_ticks: 'most ticks that a view went back',
      replayed: 'logs by laglab replay',
      replays_differ: '',
      twins: 'sessions whose commands were given to an undisturbed daemon with SQLite',
      twins_differ: '',
      accidents: 'processes that ended by themselves',
      command_p50_ms: 'until acknowledged, without faults',
      command_p99_ms: '',
      upgrade_longest_end_s: 'from SIGTERM to the end of a daemon',
      lease_s: '',
      beyond_s: 'how long a daemon was frozen or cut off beyond its lease',
      wall_s: '',
    },
    [row],
  );
  writeCsv(
    'cluster/gaps',
    command,
    {
      fault: Object.entries(FAULTS)
        .map(([kind, { what }]) => `${kind}: ${what}`)
        .join('; '),
      times: '',
      viewers: 'that were without frames for more than three periods, in all',
      gap_p50_s: 'seconds without frames of these viewers',
      gap_p99_s: '',
      gap_max_s: '',
    },
    rows,
  );
  if (good) rmSync(logs, { recursive: true, force: true });
  else say(`messages of the daemons: ${logs}`);
}

// ---- what an acknowledged command costs ----

/** Commands to one daemon by clients with a session each: the next when the last is acknowledged. */
async function commands(url, clients, seconds) {
  const c = client(url, Infinity),
    took = [];
  const made = await Promise.all(Array.from({ length: clients }, () => c.make({ set: { duration_s: 3600, 'params.laps': 1000 } })));
  const end = performance.now() + 1000 * (seconds + 1),
    counted = end - 1000 * seconds;
  await Promise.all(
    made.map(async (session) => {
      for (let n = 0; performance.now() < end; n++) {
        const from = performance.now(),
          { status, text } = await c.patch(session, { 'players.1.lag_ms': (n % 8000) / 16 });
        if (status !== 200) throw new Error(`${status} ${text}`);
        if (from >= counted) took.push(performance.now() - from);
      }
    }),
  );
  c.close();
  took.sort((a, b) => a - b);
  const at = (q) => digits(took[Math.round(q * (took.length - 1))]);
  return { commands_per_s: digits(took.length / seconds), p50_ms: at(0.5), p99_ms: at(0.99), max_ms: at(1) };
}

if (only !== 'faults') {
  process.env.LAGLAB_TEST_FSYNC = 'on';
  const rows = [],
    seconds = quick ? 3 : 10,
    rounds = quick ? 1 : 3;
  for (let round = 0; round < rounds; round++)
    for (const clients of [1, 16, 64])
      for (const store of ['SQLite', 'PostgreSQL']) {
        const { call: postgres } = ownPostgres(),
          args = store === 'PostgreSQL' ? ['--store', postgres('start'), '--url', 'http://127.0.0.1:1', '--lease-s', '10'] : [];
        const daemon = await startDaemon('--max-commands-per-s', '100000', '--control-threads', '32', ...args);
        try {
          rows.push({ store, clients, round, ...(await commands(daemon.url, clients, seconds)) });
        } finally {
          await daemon.stop();
          postgres('remove');
        }
        await pause(200);
      }
  printTable('One daemon: commands that are acknowledged when they are stored', rows);
  writeCsv(
    'cluster/store',
    `bench/run cluster --only=store`,
    {
      store:
        'PostgreSQL 15 on the same machine, by a socket, fsync on; ' +
        'SQLite as the daemon uses it: WAL, synchronous=NORMAL; --control-threads 32',
      clients: 'each with a session of its own, the next command when the last is acknowledged',
      round: '',
      commands_per_s: '',
      p50_ms: 'from the request to its answer',
      p99_ms: '',
      max_ms: '',
    },
    rows,
  );
}
process.exit(good ? 0 : 1);
