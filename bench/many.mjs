// Many players and entities: what a snapshot encoding costs in CPU and bytes, and how far off the views are, against both counts.
import { digits, interleave, laglab, median, printTable, run, say, writeCsv } from './lib.mjs';

const quick = process.argv.includes('--quick');
const rounds = quick ? 1 : 3;
const duration_s = quick ? 6 : 20;
const PLAYERS = [8, 16, 32, 64],
  BODIES = [250, 1000];
const DENSITY = 196 / 150 ** 2; // bodies per square metre, as in the scenario swarm_interest
const GOAL = 20; // times real time, with interest management
const link = { up: { loss_pct: 1 }, down: { loss_pct: 1 } };

/** Encodings, and the limit of a snapshot's bytes. */
const WAYS = {
  delta: { snapshot_encoding: 'delta' },
  partial: { snapshot_encoding: 'partial', snapshot_bytes: 400 },
  interest: { snapshot_encoding: 'interest', snapshot_bytes: 400, interest_radius_m: 40, interest_margin_m: 5 },
};

/** @param {number} players @param {number} bodies @param {keyof typeof WAYS} way */
const swarmOf = (players, bodies, way) => ({
  kind: 'netgame',
  game: 'swarm',
  duration_s,
  params: { bodies, field_m: Math.round(Math.sqrt(bodies / DENSITY)) },
  server: { update_hz: 30, ...WAYS[way] },
  players: Array.from({ length: players }, (_, i) => ({
    lag_ms: 40 + 5 * (i % 17),
    link,
    prediction: true,
    reconciliation: true,
    interpolation: true,
  })),
});

const mean = (/** @type {number[]} */ values) => values.reduce((sum, value) => sum + value, 0) / values.length;
/** Root of the mean square over players who draw about equally many entities. */
const rms = (/** @type {number[]} */ values) => Math.sqrt(mean(values.map((value) => value ** 2)));

/** One round: with all metrics, and with those alone for which no view is observed. */
async function measure({ encoding, bodies, players }, round) {
  const json = JSON.stringify(swarmOf(players, bodies, encoding));
  const result = JSON.parse(await run(laglab, ['run', '-'], json));
  const few = JSON.parse(await run(laglab, ['run', '-', '--metrics', 'players.0.bandwidth.down_bytes_per_s'], json));
  if (few.hash !== result.hash) throw new Error('observing has changed the run');
  const seats = result.metrics.players;
  return {
    encoding,
    bodies,
    players,
    round,
    times: 1e9 / result.cost.ns_per_sim_s,
    times_unobserved: 1e9 / few.cost.ns_per_sim_s,
    kb_per_s: mean(seats.map((seat) => seat.bandwidth.down_bytes_per_s)) / 1000,
    error_m: rms(seats.map((seat) => seat.remote_error_m.rms)),
    near_error_m: encoding === 'interest' ? mean(seats.map((seat) => seat.selection.near_error_m).filter((error) => error !== null)) : '',
    drawn: encoding === 'interest' ? mean(seats.map((seat) => seat.selection.in_scope)) : players + bodies - 1,
    mib: result.cost.bytes / 2 ** 20,
  };
}

const encodings = /** @type {(keyof typeof WAYS)[]} */ (Object.keys(WAYS));
const cases = encodings.flatMap((encoding) => BODIES.flatMap((bodies) => PLAYERS.map((players) => ({ encoding, bodies, players }))));
const found = await interleave(rounds, cases, measure);
const middle = (/** @type {any[]} */ of, /** @type {string} */ column) => digits(median(of.map((row) => row[column])));

printTable(
  `Swarm, ${digits(DENSITY * 1000, 2)} bodies per 1,000 m2, ` +
    `40 to 120 ms one way, 1 % loss, 30 updates/s, ${duration_s} s; median of ${rounds}`,
  cases.map((one) => {
    const of = found.get(one);
    return {
      ...one,
      'x real time': middle(of, 'times'),
      'no view observed': middle(of, 'times_unobserved'),
      'kB/s a player': middle(of, 'kb_per_s'),
      'error m': middle(of, 'error_m'),
      'near m': one.encoding === 'interest' ? middle(of, 'near_error_m') : '-',
      drawn: middle(of, 'drawn'),
    };
  }),
);
const hardest = found.get(cases[cases.length - 1]);
const times = median(hardest.map((row) => row.times)),
  unobserved = median(hardest.map((row) => row.times_unobserved));
say('');
say(
  `Goal: ${GOAL} times real time with interest, 64 players and 1,000 bodies. ` +
    `All metrics: ${digits(times)}; no view observed: ${digits(unobserved)}.`,
);

writeCsv(
  'many',
  `bench/run many${quick ? ' --quick' : ''}`,
  {
    encoding: 'of snapshots: delta; partial, 400 bytes; interest, 40 m, 400 bytes',
    bodies: 'entities besides the players, at the same density',
    players: 'each a client, whose view is measured',
    round: 'each case once',
    times: 'simulated time per CPU time of one core, all metrics observed',
    times_unobserved: 'the same where no metric needs a view',
    kb_per_s: 'kB/s to a player, payloads',
    error_m: 'm, others: drawn position against the truth now, root of the mean square',
    near_error_m: 'm, mean of those within a quarter of the radius of interest',
    drawn: 'others that a view contains',
    mib: 'MiB of the session',
  },
  cases.flatMap((one) => found.get(one)),
);
