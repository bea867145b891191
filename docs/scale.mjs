// The figures of docs/scale.md, from bench/results: what was measured, and what follows from it by multiplication.

/** @typedef {{comments: [string, string][], rows: any[]}} Result */

const median = (/** @type {number[]} */ values) => {
  const s = [...values].sort((a, b) => a - b);
  return s.length % 2 ? s[(s.length - 1) / 2] : (s[s.length / 2 - 1] + s[s.length / 2]) / 2;
};
/** Two digits: a figure of another machine is no more exact. @param {number} x */
const about = (x) => Number(x.toPrecision(2)).toLocaleString('en');
/* Of Ethernet, IP, TCP and the frame of a WebSocket: what a packet of one frame has in addition. */
const HEADERS = 14 + 4 + 20 + 32 + 4,
  HZ = 60;

/** @param {Result} streams */
function perMachine({ rows }) {
  const of = (/** @type {number} */ sessions, /** @type {number} */ viewers, /** @type {string} */ column) =>
    median(
      rows
        .filter((row) => row.server === 'laglab' && Number(row.sessions) === sessions && Number(row.viewers) === viewers)
        .map((row) => Number(row[column])),
    );
  const own = of(500, 1, 'server_us_per_frame'),
    shared = of(1, 500, 'server_us_per_frame'),
    memory_mb = of(500, 1, 'server_rss_mb') / 500,
    bytes = of(500, 1, 'frame_bytes') + HEADERS;
  return { own, shared, memory_mb, bytes };
}

/** @param {Result} streams @param {Result | null} store @param {(head: string[], rows: unknown[][]) => string} table */
export function capacityDoc(streams, store, table) {
  const { own, shared, memory_mb, bytes } = perMachine(streams),
    mbit = (/** @type {number} */ frames) => (frames * bytes * 8) / 1e6;
  const rows = [
    ['CPU of a frame, each viewer with an own session', `${own.toFixed(1)} us`, '`streams`: 500 sessions of one viewer, 60 Hz'],
    ['CPU of a frame, one session for all viewers', `${shared.toFixed(1)} us`, '`streams`: one session of 500 viewers, 60 Hz'],
    ['Memory of a live session with a viewer', `${about(memory_mb)} MB`, '`streams`: resident memory of the daemon'],
    ['Bytes of a frame on the network', `${Math.round(bytes)}`, `\`streams\`, and ${HEADERS} bytes of headers`],
  ];
  for (const name of ['SQLite', 'PostgreSQL']) {
    const of = (/** @type {string} */ column) =>
      median((store?.rows ?? []).filter((row) => row.store === name && Number(row.clients) === 64).map((row) => Number(row[column])));
    if (store)
      rows.push([
        `Acknowledged commands a second, ${name}`,
        `${about(of('commands_per_s'))}; p99 ${of('p99_ms')} ms`,
        '`cluster`: one daemon, 64 clients, each waits for its answer',
      ]);
  }
  const planned = [
    ['a class', 30, 30],
    ['a lecture', 1, 500],
    ['a course', 500, 500],
    ['a large course', 5000, 5000],
    ['a public site', 20000, 20000],
  ].map(([what, sessions, viewers]) => {
    const each = Number(sessions) > 1 ? own : shared;
    return [
      what,
      Number(sessions).toLocaleString('en'),
      Number(viewers).toLocaleString('en'),
      ...[HZ, 20].map((hz) => about((Number(viewers) * hz * each) / 1e6)),
      about((Number(sessions) * memory_mb) / 1000),
      ...[HZ, 20].map((hz) => about(mbit(Number(viewers) * hz))),
    ];
  });
  return [
    'Measured:',
    table(['What', 'Figure', 'By'], rows),
    'Calculated from these, for races of two cars, by multiplication only. ' +
      'No cache, scheduler or network of a large site is in it: plan for twice the cores.',
    table(['For', 'Sessions', 'Viewers', 'Cores at 60 Hz', 'at 20 Hz', 'Memory, GB', 'Mbit/s at 60 Hz', 'at 20 Hz'], planned),
  ].join('\n\n');
}

const whole = (/** @type {string | number} */ n) => Number(n).toLocaleString('en');

/** @param {any} row @param {(head: string[], rows: unknown[][]) => string} table */
export function totalsDoc(row, table) {
  return table(
    ['Figure', 'Value'],
    [
      ['Sessions, faults, seconds', `${whole(row.sessions)}, ${whole(row.faults)}, ${whole(row.wall_s)}`],
      ['Acknowledged commands; lost', `${whole(row.acknowledged)}; ${row.lost}`],
      ['Commands without a good answer; of these stored', `${whole(row.unanswered)}; ${whole(row.unanswered_stored)}`],
      ['Commands stored twice; log lines out of order; logs with holes', `${row.twice}; ${row.disorder}; ${row.holes}`],
      ['Log lines; written by a daemon that did not own the session', `${whole(row.lines)}; ${row.strangers}`],
      [
        'Frames seen; spans of frames of a daemon that did not own the session',
        `${whole(row.frames)}; ${row.stray}${Number(row.stray) > 0 ? `, at most ${row.stray_ms} ms` : ''}`,
      ],
      ['Moves of sessions to another daemon', whole(row.moves)],
      ['Replays; with another hash', `${whole(row.replayed)}; ${row.replays_differ}`],
      ['Runs of the same commands in one daemon with SQLite; with another hash', `${whole(row.twins)}; ${row.twins_differ}`],
      ['Most ticks that a view went back', row.back_ticks],
      ['Latency of a command without faults, p50 and p99, ms', `${row.command_p50_ms}, ${row.command_p99_ms}`],
      ['Processes that ended by themselves', row.accidents],
    ],
  );
}

/** @param {any[]} rows @param {(head: string[], rows: unknown[][]) => string} table */
export const gapsDoc = (rows, table) =>
  table(
    ['What happened', 'Times', 'Viewers without frames', 'p50, s', 'p99, s', 'longest, s'],
    rows.map((row) => [row.fault, row.times, whole(row.viewers), row.gap_p50_s, row.gap_p99_s, row.gap_max_s]),
  );
