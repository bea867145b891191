// A viewer that reads a fifth of its frames, together with fast ones on the same session: the age of the frames that it sees.
// Direct and through proxies, whose buffers hide a slow reader from the daemon's socket.
import { digits, interleave, makeSession, measureStreams, printTable, range, say, startDaemon, writeCsv } from './lib.mjs';
import { plain, publicProxy } from '../tests/lib/public.mjs';
import { names } from './proxies/proxies.mjs';

const quick = process.argv.includes('--quick');
const rounds = quick ? 1 : 3;
const seconds = quick ? 8 : 12;
/** The first frame, whole and with four seconds of events, is as large as a hundred deltas: a slow viewer must get past it. */
const warmup = 20;
const FAST = 4;
const GOAL_MS = 350;

const kinds = [
  ['slow', 'bytes'],
  ['slowframes', 'frames'],
];
const cases = ['direct', ...names].flatMap((way) =>
  ['race', 'eight'].flatMap((scenario) => kinds.map(([word, reads]) => ({ way, scenario, word, reads }))),
);

const daemon = await startDaemon();
const proxies = Object.fromEntries(await Promise.all(names.map(async (name) => [name, await publicProxy(name, daemon.port, plain)])));
const results = await interleave(rounds, cases, async ({ way, scenario, word }) => {
  const session = await makeSession(daemon.url, scenario);
  const targets = [...Array(FAST).fill(session.stream), `${word} ${session.stream}`];
  const result = await measureStreams({ port: (proxies[way] ?? daemon).port, mode: 'laglab', pid: daemon.pid, targets, warmup, seconds });
  await fetch(`${daemon.url}/api/v1/sessions/${session.id}`, {
    method: 'DELETE',
    headers: { authorization: `Bearer ${session.owner_key}` },
  });
  return { ...result, slow: result.slow_bytes ?? result.slow_frames };
});
await Promise.all(Object.values(proxies).map((proxy) => proxy.stop()));
await daemon.stop();

const rows = [];
let oldest = 0,
  lost = 0;
printTable(
  `${FAST} fast viewers and one that reads a fifth, race of 2 and of 8 players: ${rounds} rounds of ${seconds} s (median, min-max)`,
  cases.map((thing) => {
    const of = results.get(thing);
    const show = (pick) => {
      const r = range(of.map(pick));
      return `${digits(r.median)} (${digits(r.min)}-${digits(r.max)})`;
    };
    of.forEach((r, round) =>
      rows.push({
        way: thing.way,
        scenario: thing.scenario,
        reads: thing.reads,
        round,
        fast_frames: r.fast.frames,
        fast_lost: r.fast.lost,
        fast_p99_ms: r.fast.interval_ms.p99,
        fast_age_p99_ms: r.fast.age_ms.p99,
        fast_bytes: r.fast.bytes_per_frame,
        slow_frames: r.slow?.frames ?? 0,
        slow_keys: r.slow?.keys,
        slow_bytes: r.slow?.bytes_per_frame,
        slow_age_p50_ms: r.slow?.age_ms.p50,
        slow_age_p99_ms: r.slow?.age_ms.p99,
        slow_age_max_ms: r.slow?.age_ms.max,
        slow_late_until_s: r.slow?.late_until_s,
        others_cpu_pct: r.others_cpu_pct,
      }),
    );
    oldest = Math.max(oldest, ...of.map((r) => r.slow?.age_ms.max ?? Infinity));
    lost += of.reduce((sum, r) => sum + r.fast.lost, 0);
    return {
      way: thing.way,
      scenario: thing.scenario,
      'reads 1/5 of': thing.reads,
      'slow: frames/s': show((r) => (r.slow?.frames ?? 0) / r.seconds),
      'of them whole': show((r) => r.slow?.keys),
      bytes: show((r) => r.slow?.bytes_per_frame),
      'age p50': show((r) => r.slow?.age_ms.p50),
      p99: show((r) => r.slow?.age_ms.p99),
      'max ms': show((r) => r.slow?.age_ms.max),
      'late until s': show((r) => r.slow?.late_until_s),
      'fast: bytes': show((r) => r.fast.bytes_per_frame),
      lost: show((r) => r.fast.lost),
      'interval p99 ms': show((r) => r.fast.interval_ms.p99),
    };
  }),
);

const verdict = (met) => (met ? 'met' : 'MISSED');
say('');
say(`a slow viewer sees frames no older than ${GOAL_MS} ms: oldest ${digits(oldest)} ms: ${verdict(oldest <= GOAL_MS)}`);
say(`fast viewers of the same session lose nothing: ${lost} lost: ${verdict(lost === 0)}`);
writeCsv(
  'slow',
  `bench/run slow${quick ? ' --quick' : ''}`,
  {
    way: 'to the daemon',
    scenario: 'of the session',
    reads: 'what the slow viewer reads a fifth of',
    round: 'rounds are interleaved over the cases',
    fast_frames: `read by the ${FAST} fast viewers`,
    fast_lost: 'missing from their sequences',
    fast_p99_ms: 'of their intervals',
    fast_age_p99_ms: '',
    fast_bytes: 'mean of a frame',
    slow_frames: 'read by the slow viewer',
    slow_keys: 'of them whole, after a jump',
    slow_bytes: 'mean of a frame',
    slow_age_p50_ms: 'time when the whole frame was read - time stamped by the daemon',
    slow_age_p99_ms: '',
    slow_age_max_ms: '',
    slow_late_until_s: 'when, after opening, it last saw a frame older than 350 ms (the first frames of a stream are large)',
    others_cpu_pct: 'all else on the machine: 0 to 100 x cores',
  },
  rows,
);
