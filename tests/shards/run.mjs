// Shards under load are disturbed, and what must hold is checked (checks.mjs). One command, as root:
//   node tests/shards/run.mjs [--sessions=12] [--classes=2] [--faults=10] [--hz=20] [--every=500] [--seed=1] [--only=KIND] [--logs=FOLDER]
// LAGLAB_BIN names the program (build/laglab). Ends with 1 if something did not hold.
import { fileURLToPath } from 'node:url';
import { pause } from '../lib/client.mjs';
import { BINARY } from '../lib/daemon.mjs';
import { checkLog, checkReplays, checkTwins } from './checks.mjs';
import { FAULTS, draw, noShards, now, randomOf, startRig } from './rig.mjs';

const CALM_MS = 60000; // a viewer that sees nothing for so long has been forgotten
const sorted = (/** @type {number[]} */ values) => [...values].sort((a, b) => a - b);

/** Percentiles of times without a frame, of the viewers that missed more than two. @param {number[]} gaps @param {number} hz */
export function summary(gaps, hz) {
  const touched = sorted(gaps.filter((gap) => gap > 3000 / hz)),
    at = (/** @type {number} */ q) => (touched.length ? touched[Math.round(q * (touched.length - 1))] / 1000 : 0);
  return { viewers: touched.length, p50_s: at(0.5), p99_s: at(0.99), max_s: at(1) };
}

/** @param {any[]} parts @returns {any} sums of their numbers */
const total = (parts) => {
  const sums = /** @type {Record<string, number>} */ ({});
  for (const part of parts) for (const [name, value] of Object.entries(part)) sums[name] = (sums[name] ?? 0) + Number(value);
  return sums;
};

/**
 * @param {{binary?: string, sessions?: number, classes?: number, kinds: string[], hz?: number, every_ms?: number, seed?: number,
 *   quiet_s?: number, steady_s?: number, twins?: number, logs?: string, say?: (text: string) => void}} wish
 * `kinds`: of the faults, in order. `quiet_s`: without a fault, at the beginning. `steady_s`: after a fault, until no viewer has lost
 * frames for so long. `twins`: how many sessions are run again in an undisturbed daemon.
 */
export async function disturb(wish) {
  const { binary = BINARY, sessions = 12, classes = 2, kinds, hz = 20, every_ms = 500, seed = 1 } = wish,
    { quiet_s = 2, steady_s = 0.5, twins = sessions, logs, say = () => {} } = wish;
  const rig = await startRig({ binary, seed, folder: logs });
  try {
    await rig.ask('begin', { url: rig.url, sessions, classes, hz });
    /** Until every viewer sees frames. @param {number} since */
    const calm = async (since) => {
      for (const end = now() + CALM_MS; ; await pause(50)) {
        const waiting = await rig.ask('waiting', { since });
        if (waiting === 0) return now();
        if (now() > end) throw new Error(`${waiting} of ${sessions} viewers have seen no frame for ${CALM_MS / 1000} s`);
      }
    };
    await calm(now());
    await rig.ask('command', { every_ms });
    const faults = [];
    /** @param {string} kind @param {() => Promise<any>} act */
    const span = async (kind, act) => {
      const from = now();
      await act();
      const over = now(),
        frames = await calm(over);
      for (const end = now() + 3000 + 2000 * steady_s; now() < end && (await rig.ask('unsteady', { ms: 1000 * steady_s })) > 0; )
        await pause(100);
      const to = now();
      const gaps = await rig.ask('gaps', { from, to }),
        told = summary(gaps, hz);
      faults.push({ kind, gaps, from, to, act_s: (over - from) / 1000, calm_s: (frames - over) / 1000 });
      const [act_s, p50_s, max_s] = [(over - from) / 1000, told.p50_s, told.max_s].map((x) => x.toFixed(2));
      say(`${kind}: ${act_s} s, ${told.viewers} viewers without frames for ${p50_s} s, at most ${max_s} s`);
    };
    await pause(1000); // the first frames of a stream are large
    await span('undisturbed', () => pause(1000 * quiet_s));
    const latency = await rig.ask('latency', faults[0]);
    for (const kind of kinds) await span(kind, () => FAULTS[kind].act(rig));
    await rig.ask('halt');
    const of_classes = await rig.ask('classes');
    await rig.ask('settle');
    const known = await rig.ask('known');
    await rig.ask('end');

    const findings = /** @type {string[]} */ ([...of_classes]);
    const logs_ = total(known.sessions.map((/** @type {any} */ session) => checkLog(session, findings)));
    const replays = await checkReplays(binary, known.sessions, findings);
    const random = randomOf(seed),
      chosen = known.sessions.filter((_, i) => i === 0 || random() < twins / sessions);
    const twin = await checkTwins(chosen, findings);
    const accidents = [...rig.daemons, rig.proxy].flatMap((each) => each.accidents);
    findings.push(...accidents);
    const frames = total(known.viewers.map(({ frames: seen }) => ({ seen })));
    return {
      faults,
      latency,
      findings,
      totals: {
        sessions,
        faults: kinds.length,
        ...logs_,
        frames: frames.seen,
        classes: known.classes.count,
        votes: known.classes.votes,
        classes_lost: of_classes.length,
        back_ticks: Math.max(...known.viewers.map((/** @type {any} */ viewer) => viewer.back)),
        replayed: replays.replayed,
        replays_differ: replays.differ,
        twins: twin.twins,
        twins_differ: twin.differ,
        accidents: accidents.length,
      },
      closed: total(known.viewers.map((/** @type {any} */ viewer) => viewer.codes)),
      statuses: total(
        known.sessions.flatMap((/** @type {any} */ session) => session.commands.map((/** @type {any} */ told) => ({ [told.status]: 1 }))),
      ),
    };
  } catch (error) {
    for (const { name } of [...rig.daemons, rig.proxy]) say(`${name}: ${rig.log(name).slice(-1500)}`);
    throw error;
  } finally {
    await rig.close();
  }
}

/** What did not hold: empty when all did. @param {Awaited<ReturnType<typeof disturb>>} report */
export const broken = ({ totals }) =>
  ['lost', 'twice', 'disorder', 'classes_lost', 'replays_differ', 'twins_differ', 'accidents'].filter((name) => totals[name] > 0);

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const option = (/** @type {string} */ name, /** @type {any} */ standard) =>
    process.argv.find((word) => word.startsWith(`--${name}=`))?.slice(name.length + 3) ?? standard;
  const missing = noShards();
  if (missing) {
    console.error(missing);
    process.exit(77);
  }
  const seed = Number(option('seed', 1)),
    only = option('only', ''),
    count = Number(option('faults', 10));
  const report = await disturb({
    sessions: Number(option('sessions', 12)),
    kinds: only ? Array(count).fill(only) : draw(count, randomOf(seed)),
    classes: Number(option('classes', 2)),
    hz: Number(option('hz', 20)),
    every_ms: Number(option('every', 500)),
    seed,
    logs: option('logs', undefined),
    say: console.log,
  });
  console.log(report.totals, { closed: report.closed, statuses: report.statuses, latency: report.latency });
  for (const finding of report.findings.slice(0, 30)) console.log(finding);
  const bad = broken(report);
  console.log(bad.length ? `did not hold: ${bad.join(', ')}` : 'all of it held');
  process.exit(bad.length ? 1 : 0);
}
