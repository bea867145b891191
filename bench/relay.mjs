// Many viewers of one session over two relays: CPU per frame at the owner and at the relays, age of the frames; 5,000 viewers at 20 Hz,
// and at 60 Hz by calculation.
import { readFileSync } from 'node:fs';
import {
  digits,
  interleave,
  laglab,
  makeSession,
  measureStreams,
  median,
  pause,
  printTable,
  range,
  say,
  start,
  startDaemon,
  writeCsv,
} from './lib.mjs';

const quick = process.argv.includes('--quick');
const rounds = quick ? 1 : 3;
const seconds = quick ? 8 : 20;
const warmup = quick ? 3 : 4;
const VIEWERS = 500; // of each daemon that has viewers: what two cores carry together with the client
const GOAL_US = 4.5; // CPU per frame, as the daemon's
const MANY = 5000;
const TICK_HZ = 100; // of /proc/PID/stat

const startRelay = async (/** @type {string} */ of) => {
  const relay = await start(
    laglab,
    [
      'relay',
      '--of',
      of,
      '--listen',
      '127.0.0.1:0',
      '--max-viewers',
      '30000',
      '--max-connections',
      '30000',
      '--max-connections-per-ip',
      '30000',
    ],
    (line) => /listening on (http:\S+?)\/?$/.exec(line)?.[1],
    { quiet: true },
  );
  return { ...relay, url: relay.what, port: Number(new URL(relay.what).port) };
};

/** Seconds of processor time of a process so far. @param {number} pid */
const cpuOf = (pid) => {
  const fields = readFileSync(`/proc/${pid}/stat`, 'utf8').split(') ')[1].split(' ');
  return (Number(fields[11]) + Number(fields[12])) / TICK_HZ;
};

/** Where the viewers are: at the owner itself, at one relay, at two relays, at one whose owner is a relay. `hz`: that viewers ask for,
 * 60 if left out. */
const WAYS = {
  owner: { relays: 0, viewers: [VIEWERS] },
  'one relay': { relays: 1, viewers: [VIEWERS] },
  'two relays': { relays: 2, viewers: [VIEWERS / 2, VIEWERS / 2] },
  'a relay of a relay': { relays: 2, chain: true, viewers: [VIEWERS] },
  'two relays, 2,000 viewers': { relays: 2, viewers: [1000, 1000] },
  'two relays, 5,000 viewers': { relays: 2, viewers: [MANY / 2, MANY / 2], hz: 20 },
};

async function measure(name) {
  const way = WAYS[name];
  const owner = await startDaemon();
  const relays = [];
  for (let i = 0; i < way.relays; i++) relays.push(await startRelay(way.chain && i > 0 ? relays[i - 1].url : owner.url));
  try {
    const session = await makeSession(owner.url);
    const shown = way.relays === 0 ? [owner] : way.chain ? [relays[way.relays - 1]] : relays;
    const servers = [owner, ...relays];
    let before, after;
    const clock = (async () => {
      await pause(1000 * (warmup + 2)); /* all viewers are open by then */
      before = servers.map(({ pid }) => cpuOf(pid));
      await pause(1000 * (seconds - 4));
      after = servers.map(({ pid }) => cpuOf(pid));
    })();
    const [results] = await Promise.all([
      Promise.all(
        shown.map(({ port, pid }, i) =>
          measureStreams({ port, pid, mode: 'laglab', targets: Array(way.viewers[i]).fill(session.stream), warmup, seconds, hz: way.hz }),
        ),
      ),
      clock,
    ]);
    const used = servers.map((_, i) => (after[i] - before[i]) / (seconds - 4));
    const frames = results.reduce((sum, r) => sum + r.frames_per_s, 0);
    const relayed = used.slice(1).reduce((sum, s) => sum + s, 0);
    return {
      way: name,
      viewers: way.viewers.reduce((sum, n) => sum + n, 0),
      frames_per_s: frames,
      // At a lower rate the numbers of the frames have gaps: then those that are due count.
      lost: way.hz
        ? Math.max(0, Math.round(seconds * (way.hz * way.viewers.reduce((sum, n) => sum + n, 0) - frames)))
        : results.reduce((sum, r) => sum + r.fast.lost, 0),
      age_p50_ms: Math.max(...results.map((r) => r.fast.age_ms.p50)),
      age_p99_ms: Math.max(...results.map((r) => r.fast.age_ms.p99)),
      interval_p99_ms: Math.max(...results.map((r) => r.fast.interval_ms.p99)),
      owner_cpu_pct: 100 * used[0],
      relay_cpu_pct: way.relays ? 100 * relayed : '',
      us_per_frame: (1e6 * (way.relays ? relayed : used[0])) / frames,
      rss_mb: Math.max(...results.map((r) => r.server_rss_mb)),
      frame_bytes: results[0].fast.bytes_per_frame,
    };
  } finally {
    for (const one of [...relays].reverse()) await one.stop();
    await owner.stop();
    await pause(500);
  }
}

const names = /** @type {(keyof typeof WAYS)[]} */ (Object.keys(WAYS));
const found = await interleave(rounds, names, async (name, round) => ({ round, ...(await measure(name)) }));
const of = (name, column) => found.get(name).map((row) => row[column]);
const middle = (name, column, n = 3) => digits(median(of(name, column)), n);
printTable(
  `Viewers of one session of scenario race, acknowledged, at 60 frames/s unless said: median of ${rounds} rounds of ${seconds} s`,
  names.map((name) => {
    const us = range(of(name, 'us_per_frame'));
    return {
      'viewers at': name,
      viewers: WAYS[name].viewers.reduce((sum, n) => sum + n, 0),
      hz: WAYS[name].hz ?? 60,
      'frames/s': middle(name, 'frames_per_s', 6),
      lost: middle(name, 'lost'),
      'age p50': middle(name, 'age_p50_ms'),
      'age p99 ms': middle(name, 'age_p99_ms'),
      'interval p99 ms': middle(name, 'interval_p99_ms'),
      'owner CPU %': middle(name, 'owner_cpu_pct'),
      'relays CPU %': WAYS[name].relays ? middle(name, 'relay_cpu_pct') : '-',
      'us/frame there': `${digits(us.median)} (${digits(us.min)}-${digits(us.max)})`,
      'RSS MB': middle(name, 'rss_mb'),
    };
  }),
);

const cost = median(of('two relays', 'us_per_frame')),
  idle = median(of('two relays', 'owner_cpu_pct')),
  late = median(of('one relay', 'age_p50_ms')) - median(of('owner', 'age_p50_ms')),
  bytes = median(of('two relays', 'frame_bytes'));
const verdict = (/** @type {boolean} */ met) => (met ? 'met' : 'MISSED');
say('');
say(`A frame of one viewer costs a relay ${digits(cost)} us of CPU (goal ${GOAL_US}): ${verdict(cost <= GOAL_US)}`);
say(`A frame is ${digits(late)} ms older through a relay, p50 (goal: at most a frame, 16.7 ms): ${verdict(late <= 1000 / 60)}`);
say(
  `Calculated, not run: ${MANY} viewers at 60 frames/s over two relays: ${digits((MANY * 60 * cost) / 2e6)} cores each, ` +
    `${digits((MANY * 60 * bytes * 8) / 2e9)} Gbit/s each; the owner stays at ${digits(idle)} % of a core.`,
);

writeCsv(
  'relay',
  `bench/run relay${quick ? ' --quick' : ''}`,
  {
    way: 'where the viewers of the one session are',
    viewers: 'in all',
    round: 'rounds are interleaved over the ways',
    frames_per_s: 'read by all viewers',
    lost: 'frames missing from the sequences; at a lower rate than 60 Hz, from those that are due',
    age_p50_ms: 'time read - time stamped by the owner, quantiles',
    age_p99_ms: '',
    interval_p99_ms: 'between two frames of a viewer',
    owner_cpu_pct: 'of one core, user + system',
    relay_cpu_pct: 'of all relays together',
    us_per_frame: 'CPU of who has the viewers (of all relays) per frame read by a viewer',
    rss_mb: 'of who has the viewers, at the end',
    frame_bytes: 'mean payload',
  },
  names.flatMap((name) => found.get(name)),
);
