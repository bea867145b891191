// Three shards behind HAProxy on machines of their own (network namespaces, root) under load, while they are killed, stopped, frozen, cut
// off and restarted in turn.
//   bench/run shards [--quick] [--sessions=300] [--classes=10] [--faults=50] [--steady=2] [--seed=1]
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { digits, laglab, printTable, say, writeCsv } from './lib.mjs';
import { FAULTS, draw, noShards, randomOf } from '../tests/shards/rig.mjs';
import { broken, disturb, summary } from '../tests/shards/run.mjs';

const quick = process.argv.includes('--quick');
const option = (name, standard) => Number(process.argv.find((each) => each.startsWith(`--${name}=`))?.slice(name.length + 3) ?? standard);
const sessions = option('sessions', quick ? 30 : 300),
  classes = option('classes', quick ? 3 : 10),
  count = option('faults', quick ? 10 : 50),
  steady_s = option('steady', 2),
  seed = option('seed', 1);
const HZ = 20,
  EVERY_MS = 1000,
  TWINS = quick ? 10 : 50;

const missing = noShards();
if (missing) {
  console.error(missing);
  process.exit(1);
}
const begun = performance.now(),
  logs = mkdtempSync(join(tmpdir(), 'laglab-shards-logs-'));
const report = await disturb({
  binary: laglab,
  sessions,
  classes,
  kinds: draw(count, randomOf(seed)),
  hz: HZ,
  every_ms: EVERY_MS,
  seed,
  quiet_s: quick ? 5 : 20,
  steady_s,
  twins: TWINS,
  logs,
  say: console.log,
});
const wall_s = (performance.now() - begun) / 1000,
  order = ['undisturbed', ...Object.keys(FAULTS)];
const rows = order
  .filter((kind) => report.faults.some((fault) => fault.kind === kind))
  .map((kind) => {
    const of = report.faults.filter((fault) => fault.kind === kind),
      { viewers, p50_s, p99_s, max_s } = summary(
        of.flatMap(({ gaps }) => gaps),
        HZ,
      );
    return { fault: kind, times: of.length, viewers, gap_p50_s: digits(p50_s), gap_p99_s: digits(p99_s), gap_max_s: digits(max_s) };
  });
printTable(`${sessions} sessions and ${classes} classes on three shards, ${count} faults`, rows);
const { totals, latency } = report,
  row = { ...totals, command_p50_ms: digits(latency.p50), command_p99_ms: digits(latency.p99), wall_s: digits(wall_s) };
say(JSON.stringify({ ...row, closed: report.closed, statuses: report.statuses }));
for (const finding of report.findings.slice(0, 20)) say(finding);
const bad = broken(report);
say(`${bad.length ? `MISSED: ${bad.join(', ')}` : 'Met'}: no acknowledged command lost or doubled, the same hashes, whole classes.`);
const command = `bench/run shards --sessions=${sessions} --classes=${classes} --faults=${count} --steady=${steady_s} --seed=${seed}`;
writeCsv(
  'shards',
  command,
  {
    sessions: 'each with a viewer of the clock at 20 Hz and a command a second',
    faults: '',
    acknowledged: 'commands, also those to the boards of classes',
    unanswered: 'commands that got an error, or no answer in 15 s',
    unanswered_stored: 'of these, those that the log has',
    lost: 'acknowledged, and not in the log at the tick of the answer',
    twice: 'commands that the log has more than once',
    disorder: 'lines with a lower tick than the one before',
    frames: 'that viewers got',
    classes: 'each with a board, a copy of it and six members, who vote every two seconds',
    votes: 'acknowledged',
    classes_lost: 'what of a class was not as before the faults: code, board, members, copy, a vote after them',
    back_ticks: 'most ticks that a view went back',
    replayed: 'logs by laglab replay',
    replays_differ: '',
    twins: 'sessions whose commands were given to an undisturbed daemon',
    twins_differ: '',
    accidents: 'processes that ended by themselves',
    command_p50_ms: 'until acknowledged, without faults',
    command_p99_ms: '',
    wall_s: '',
  },
  [row],
);
writeCsv(
  'shards/gaps',
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
if (bad.length) say(`messages of the daemons: ${logs}`);
else rmSync(logs, { recursive: true, force: true });
process.exit(bad.length ? 1 : 0);
