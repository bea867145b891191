// What one daemon carries: a course in one session, and many sessions that each have a viewer.
import { digits, interleave, makeSession, measureStreams, median, pause, printTable, say, startDaemon, writeCsv } from './lib.mjs';

const quick = process.argv.includes('--quick');
const rounds = quick ? 1 : 3;
const seconds = quick ? 8 : 20;
// Thousands who join at once miss frames meanwhile and are sent fewer for some windows of 2 s (daemon/stream/pace.h). What is measured
// comes after.
const warmup = 40;
const ways = [
  { name: 'a course', sessions: 1, viewers: 2000, hz: 20 },
  { name: 'a large course', sessions: 1, viewers: 5000, hz: 20 },
  { name: 'many sessions', sessions: 1000, viewers: 1, hz: 20 },
];
const LIMITS = ['--max-sessions', '2000', '--max-connections', '30000', '--max-connections-per-ip', '30000'];

async function measure({ sessions, viewers, hz }, round) {
  const daemon = await startDaemon(...LIMITS);
  try {
    const targets = [];
    for (let i = 0; i < sessions; i++) targets.push(...Array(viewers).fill((await makeSession(daemon.url)).stream));
    const result = await measureStreams({ port: daemon.port, pid: daemon.pid, mode: 'laglab', targets, warmup, seconds, hz });
    return {
      sessions,
      viewers: sessions * viewers,
      hz,
      round,
      frames_per_s: result.frames_per_s,
      // At less than 60 Hz the numbers of the frames have gaps: the frames that were due are counted.
      lost: Math.max(0, Math.round(seconds * (hz * sessions * viewers - result.frames_per_s))),
      interval_p50_ms: result.fast.interval_ms.p50,
      interval_p99_ms: result.fast.interval_ms.p99,
      age_p50_ms: result.fast.age_ms.p50,
      age_p99_ms: result.fast.age_ms.p99,
      cpu_pct: result.server_cpu_pct,
      us_per_frame: result.server_us_per_frame,
      rss_mb: result.server_rss_mb,
      others_cpu_pct: result.others_cpu_pct,
    };
  } finally {
    await daemon.stop();
    await pause(500);
  }
}

const found = await interleave(rounds, ways, measure);
printTable(
  `Viewers of scenario race, acknowledged: median of ${rounds} rounds of ${seconds} s`,
  ways.map((way) => {
    const middle = (column, n = 3) => digits(median(found.get(way).map((row) => row[column])), n);
    return {
      '': way.name,
      sessions: way.sessions,
      viewers: way.sessions * way.viewers,
      'frames/s each': way.hz,
      'frames/s': middle('frames_per_s', 6),
      lost: middle('lost', 4),
      'interval p99 ms': middle('interval_p99_ms'),
      'age p50': middle('age_p50_ms'),
      'p99 ms': middle('age_p99_ms'),
      'CPU %': middle('cpu_pct'),
      'us/frame': middle('us_per_frame'),
      'RSS MB': middle('rss_mb'),
    };
  }),
);
say('');
for (const way of ways) {
  const lost = found.get(way).reduce((sum, row) => sum + row.lost, 0);
  say(`${way.name}: no frame lost: ${lost} lost: ${lost === 0 ? 'met' : 'MISSED'}`);
}

writeCsv(
  'capacity',
  `bench/run capacity${quick ? ' --quick' : ''}`,
  {
    sessions: 'live sessions of scenario race',
    viewers: 'in all',
    hz: 'frames a second that each viewer asks for',
    round: 'rounds are interleaved over the ways',
    frames_per_s: 'read by all viewers',
    lost: 'frames that were due and not read',
    interval_p50_ms: 'between two frames of a viewer, quantiles over all viewers',
    interval_p99_ms: '',
    age_p50_ms: 'time read - time stamped by the daemon, quantiles',
    age_p99_ms: '',
    cpu_pct: 'of one core, all threads of the daemon, user + system',
    us_per_frame: 'the same per frame read by a viewer',
    rss_mb: 'of the daemon at the end',
    others_cpu_pct: 'all else on the machine but daemon and client: 0 to 100 x cores',
  },
  ways.flatMap((way) => found.get(way)),
);
