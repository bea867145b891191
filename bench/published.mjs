// Published results made again, by the experiments of the library whose names begin with published_: docs/published.md compares them with
// the papers.
// --quick: fewer and shorter runs.
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { drawFigure } from './figure.mjs';
import { digits, laglab, printTable, results, root, run, writeCsv } from './lib.mjs';

const quick = process.argv.includes('--quick');
const command = `bench/run published${quick ? ' --quick' : ''}`;
const folder = mkdtempSync(join(tmpdir(), 'laglab-published-'));
process.on('exit', () => rmSync(folder, { recursive: true, force: true }));
mkdirSync(join(results, 'published'), { recursive: true });

/** The rows of an experiment of the library, one for each run. @param {string} name */
async function rowsOf(name) {
  let experiment = `experiments/published_${name}`;
  if (quick) {
    const spec = JSON.parse(readFileSync(join(root, 'scenarios', `${experiment}.json`), 'utf8'));
    experiment = join(folder, `${name}.json`);
    writeFileSync(experiment, JSON.stringify({ ...spec, repeats: Math.min(spec.repeats ?? 1, 3) }));
  }
  const out = join(folder, `${name}.rows.json`);
  await run(laglab, ['sweep', experiment, '--out', out]);
  return JSON.parse(readFileSync(out, 'utf8'));
}

const six = (/** @type {number} */ value) => Number(value.toPrecision(6));
const sum = (/** @type {number[]} */ values) => values.reduce((total, value) => total + value, 0);
const mean = (/** @type {number[]} */ values) => sum(values) / values.length;

/** Rows by the values of some columns, in their order. */
function groupsOf(rows, columns) {
  const groups = new Map();
  for (const row of rows) {
    const key = JSON.stringify(columns.map((column) => row[column]));
    groups.set(key, [...(groups.get(key) ?? []), row]);
  }
  return [...groups.values()];
}

/** @param {string} name @param {import('./figure.mjs').Figure} figure */
const draw = (name, figure) => writeFileSync(join(results, 'published', `${name}.svg`), drawFigure(figure));

// ---- Bettner and Terrano, 2001 ----

async function archers() {
  const rows = (await rowsOf('archers')).map((row) => ({
    way: row['server.sync'] === 'free' ? `snapshots, ${row['server.snapshot_encoding']}` : 'orders',
    update_hz: row['server.update_hz'],
    units: row['params.bodies'],
    down_bytes_per_s: six(row['players.0.bandwidth.down_bytes_per_s']),
    up_bytes_per_s: six(row['players.0.bandwidth.up_bytes_per_s']),
    input_latency_ms: six(row['players.0.input_latency_ms.mean']),
    steps_per_s: six(row['server.steps_per_s']),
  }));
  printTable('Units on a modem', rows);
  writeCsv(
    'published/archers',
    command,
    {
      way: 'what is sent: orders, or snapshots in an encoding',
      update_hz: 'messages a second',
      units: 'bodies that move',
      down_bytes_per_s: 'bytes a second from the server to the first of eight players, headers included',
      up_bytes_per_s: 'and from that player to the server',
      input_latency_ms: 'mean time from an order to its effect on the own screen',
      steps_per_s: 'steps of the server; 15 are wanted',
    },
    rows,
  );
  draw('archers', {
    title: 'Bytes a second to one of eight players',
    x: 'units',
    y: 'bytes per second',
    logarithmic: true,
    levels: [{ at: 3600, name: '28.8 kbit/s' }],
    series: groupsOf(rows, ['way']).map((group) => ({
      name: group[0].way,
      points: group.map((row) => [row.units, row.down_bytes_per_s]),
    })),
  });
}

// ---- Lee and Chang, 2018 ----

async function shotBehindCover() {
  const SHOOTERS = [1, 3]; // B and D, who have the lag
  const all = (await rowsOf('shot_behind_cover')).map((row) => ({
    policy: row['server.hitscan'],
    grace_ms: row['server.hitscan'] === 'victim_veto' ? row['policies.veto_grace_ms'] : '',
    lag_ms: row['players.1.lag_ms'],
    ...Object.fromEntries(
      ['shot_behind_cover', 'hits_on_players', 'client_view_hits', 'false_misses'].map((metric) => [
        metric,
        sum(SHOOTERS.map((player) => row[`players.${player}.shots.hitscan.${metric}`])),
      ]),
    ),
  }));
  const rows = groupsOf(all, ['policy', 'grace_ms', 'lag_ms']).map((group) => ({
    policy: group[0].policy,
    grace_ms: group[0].grace_ms,
    lag_ms: group[0].lag_ms,
    runs: group.length,
    behind_cover: sum(group.map((row) => row.shot_behind_cover)),
    hits: sum(group.map((row) => row.hits_on_players)),
    seen_hits: sum(group.map((row) => row.client_view_hits)),
    denied: sum(group.map((row) => row.false_misses)),
  }));
  printTable('Shots behind cover', rows);
  writeCsv(
    'published/shot_behind_cover',
    command,
    {
      policy: 'server.hitscan',
      grace_ms: 'policies.veto_grace_ms',
      lag_ms: 'one-way lag of B and D; A and C have 5 ms',
      runs: 'runs of two minutes, of all of which the following are sums over B and D',
      behind_cover: 'hits that counted while the victim was in cover in its own view',
      hits: 'hits on players that counted',
      seen_hits: 'shots that hit in the view of the shooter',
      denied: 'of them, those that did not count',
    },
    rows,
  );
  const rewind = rows.filter(({ policy }) => policy === 'rewind');
  draw('shot_behind_cover', {
    title: 'Shots behind cover that remain, of those with rewind',
    x: 'one-way lag of the shooters, ms',
    y: '%',
    levels: [{ at: 5.9, name: '94.1 % fewer' }],
    series: groupsOf(
      rows.filter(({ policy }) => policy === 'victim_veto'),
      ['grace_ms'],
    ).map((group) => ({
      name: `veto, grace ${group[0].grace_ms} ms`,
      points: group.map((row, i) => [row.lag_ms, (100 * row.behind_cover) / rewind[i].behind_cover]),
    })),
  });
}

// ---- Griwodz and Halvorsen, 2006 ----

async function thinStreams() {
  const DURATION_S = 600,
    WARMUP_S = 2,
    LOSS = 0.01,
    TIMER_S = 0.2;
  const at = (row, metric) => row[`players.0.transport_down.${metric}`];
  /** Mean extra latency where a lost message is sent again after so long, and those behind it wait (docs/transports.md). */
  const extraOf = (after_ms, interval_ms) => {
    const waiting = Math.ceil(after_ms / interval_ms);
    return LOSS * (waiting * after_ms - (interval_ms * waiting * (waiting - 1)) / 2);
  };
  const rows = groupsOf(await rowsOf('thin_streams'), ['players.0.lag_ms', 'server.update_hz']).map((group) => {
    const rtt_ms = 2 * group[0]['players.0.lag_ms'],
      messages_per_s = mean(group.map((row) => at(row, 'messages'))) / (DURATION_S - WARMUP_S),
      packets = sum(group.map((row) => at(row, 'packets') - at(row, 'ack_packets'))),
      timeouts = sum(group.map((row) => at(row, 'timeouts')));
    const interval_ms = 1000 / messages_per_s,
      mean_ms = mean(group.map((row) => at(row, 'latency_ms.mean')));
    return {
      rtt_ms,
      update_hz: group[0]['server.update_hz'],
      messages_per_s: six(messages_per_s),
      in_timer: six(messages_per_s * TIMER_S),
      runs: group.length,
      packets,
      timeouts,
      timeouts_per_loss: six(timeouts / (LOSS * packets)),
      extra_ms: six(mean_ms - rtt_ms / 2),
      timer_ms: six(extraOf(1000 * TIMER_S + Math.max(0, rtt_ms - interval_ms), interval_ms)),
      fast_ms: six(extraOf(rtt_ms + 3 * interval_ms, interval_ms)),
      p99_ms: six(mean(group.map((row) => at(row, 'latency_ms.p99')))),
      max_ms: six(Math.max(...group.map((row) => at(row, 'latency_ms.max')))),
    };
  });
  printTable(
    'Thin streams',
    rows.map((row) => Object.fromEntries(Object.entries(row).map(([name, value]) => [name, digits(value, 4)]))),
  );
  writeCsv(
    'published/thin_streams',
    command,
    {
      rtt_ms: 'round trip',
      update_hz: 'snapshots a second',
      messages_per_s: 'messages from the server to A: snapshots and answers to pings',
      in_timer: 'messages in the 200 ms of the retransmission timer',
      runs: 'runs of ten minutes, of all of which the following are sums, means or the maximum',
      packets: 'packets with messages, of which 1 % are lost',
      timeouts: 'times that the retransmission timer ended',
      timeouts_per_loss: 'the same per lost packet with messages, which are 1 % of the packets',
      extra_ms: 'mean latency of a message beyond half of the round trip',
      timer_ms: 'the same by a closed form, if the timer repairs all losses',
      fast_ms: 'the same by a closed form, if fast retransmit repairs all losses',
      p99_ms: '99th percentile of the latency',
      max_ms: 'the longest latency of all runs',
    },
    rows,
  );
  draw('thin_streams', {
    title: 'Mean extra latency by 1 % loss, round trip 100 ms',
    x: 'packets in the 200 ms of the timer',
    y: 'ms',
    series: [
      { name: 'if the timer repairs', column: 'timer_ms' },
      { name: 'if fast retransmit does', column: 'fast_ms' },
      { name: 'laglab', column: 'extra_ms' },
    ].map(({ name, column }) => ({
      name,
      points: rows.filter((row) => row.rtt_ms === 100).map((row) => [row.in_timer, row[column]]),
    })),
  });
}

await archers();
await shotBehindCover();
await thinStreams();
