// Speed against error in netcode: each technique on the same race over the same bad link, what it costs and what it is worth.
import { join } from 'node:path';
import { build, digits, laglab, median, printTable, run, say, writeCsv } from './lib.mjs';

const quick = process.argv.includes('--quick');
const seeds = quick ? 3 : 20;
const duration_s = 60;
const cost_s = quick ? 300 : 1200; // of the runs that are timed
const cost_rounds = quick ? 1 : 5;
const link = { jitter_ms: 20, loss_pct: 1 };
const full = { prediction: true, reconciliation: true, interpolation: true };
const predicted = { prediction: true, reconciliation: true };

/** Techniques by what they are for. `server`, `player` and `more` are added to the scenario. */
const techniques = [
  ['synchronisation', 'free, nothing else', {}, {}],
  ['synchronisation', 'lockstep', { sync: 'lockstep' }, {}],
  ['synchronisation', 'pipelined lockstep', { sync: 'lockstep_pipelined' }, {}],
  ['synchronisation', 'bucket, 150 ms', { sync: 'bucket' }, {}, { bucket_delay_ms: 150 }],
  ['synchronisation', 'deterministic lockstep', { sync: 'deterministic' }, {}],
  ['synchronisation', 'deterministic lockstep, input delay 8', { sync: 'deterministic' }, { input_delay_ticks: 8 }],
  ['synchronisation', 'deterministic lockstep, mesh', { sync: 'deterministic' }, {}, { peers: { topology: 'mesh' } }],
  ['synchronisation', 'rollback', { sync: 'rollback' }, {}],
  ['synchronisation', 'rollback, mesh', { sync: 'rollback' }, {}, { peers: { topology: 'mesh' } }],
  ['synchronisation', 'rollback, input delay 3', { sync: 'rollback' }, { input_delay_ticks: 3 }],
  ['own entity', 'prediction', {}, { prediction: true }],
  ['own entity', 'prediction, reconciliation', {}, predicted],
  ['own entity', 'scope contacts', {}, { ...predicted, prediction_scope: 'contacts' }],
  ['own entity', 'scope all', {}, { ...predicted, prediction_scope: 'all' }],
  ['own entity', 'corrections smoothed', {}, { ...predicted, correction: 'smooth' }],
  ['own entity', 'acknowledged per input', {}, { ...predicted, ack: 'per_input' }],
  ['own entity', 'time dilation', {}, { ...predicted, time_dilation: true }],
  ['own entity', 'no redundancy', {}, { ...predicted, redundancy: 0 }],
  ['others', 'interpolation, ratio 2', {}, full],
  ['others', 'interpolation, ratio 3', {}, { ...full, interpolation_ratio: 3 }],
  ['others', 'hermite', {}, { ...full, interpolation_method: 'hermite' }],
  ['others', 'adaptive delay', {}, { ...full, interpolation_delay: 'adaptive' }],
  ['others', 'extrapolation, 250 ms', {}, { ...full, interpolation_ratio: 1, jitter_margin_ms: 0, extrapolation_ms: 250 }],
  ['others', 'de-jitter buffer, send time + 60 ms', {}, { ...predicted, dejitter: 'send_time', dejitter_ms: 60 }],
  ['snapshots', 'full', {}, full],
  ['snapshots', 'quantised', { snapshot_encoding: 'quantised' }, full],
  ['snapshots', 'delta', { snapshot_encoding: 'delta' }, full],
  ['snapshots', 'partial, 40 bytes', { snapshot_encoding: 'partial', snapshot_bytes: 40 }, full],
  ['snapshots', 'partial delta, 40 bytes', { snapshot_encoding: 'partial_delta', snapshot_bytes: 40 }, full],
  ['snapshots', 'interest, 40 m', { snapshot_encoding: 'interest', interest_radius_m: 40 }, full],
  ['dead reckoning', 'velocity, 1 m', {}, predicted, { reckoning: { model: 'velocity', threshold_m: 1 } }],
  ['dead reckoning', 'velocity and spin, 1 m', {}, predicted, { reckoning: { model: 'velocity_spin', threshold_m: 1 } }],
  ['dead reckoning', 'acceleration, 1 m', {}, predicted, { reckoning: { model: 'acceleration', threshold_m: 1 } }],
  ['dead reckoning', 'acceleration, 0.1 m', {}, predicted, { reckoning: { model: 'acceleration', threshold_m: 0.1 } }],
  ['transports', 'UDP', { transport: 'udp' }, { ...full, redundancy: 0 }],
  ['transports', 'TCP', { transport: 'tcp' }, { ...full, redundancy: 0 }],
  ['transports', 'QUIC, reliable and unordered', { transport: 'quic', delivery: 'reliable_unordered' }, { ...full, redundancy: 0 }],
];

/** Four cars in two lanes: who shares a lane touches. */
function raceOf(server, player, more = {}, players = 4) {
  const seats = Array.from({ length: players }, (_, i) => ({
    name: 'ABCDEFGHIJKLMNOP'[i],
    lag_ms: 100,
    lane: Math.floor(i / 2),
    link: { up: link, down: link },
    ...player,
  }));
  return {
    kind: 'netgame',
    game: 'race',
    duration_s,
    params: { laps: 10000 },
    server: { update_hz: 30, ...server },
    players: seats,
    ...more,
  };
}

const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;
const quantileOfT = { 3: 4.303, 20: 2.093 }; // 97.5 %, by the number of runs
function interval(values) {
  const m = mean(values);
  const sd = Math.sqrt(values.reduce((sum, value) => sum + (value - m) ** 2, 0) / (values.length - 1));
  return (quantileOfT[values.length] * sd) / Math.sqrt(values.length);
}

const metrics = {
  input_latency_ms: (p) => p.input_latency_ms.mean,
  own_timeline_error_m: (p) => p.own_timeline_error_m.rms,
  remote_error_m: (p) => p.remote_error_m.rms,
  timeline_error_m: (p) => p.timeline_error_m.rms,
  view_age_ms: (p) => p.view_age_ms.mean,
  corrections_per_s: (p) => p.corrections_per_s,
  correction_m: (p) => p.correction_m.mean,
  pop_m: (p) => p.pop_m.max,
  up_bytes_per_s: (p) => p.bandwidth.up_bytes_per_s,
  down_bytes_per_s: (p) => p.bandwidth.down_bytes_per_s,
};

async function measure(json) {
  const runs = [];
  for (let seed = 1; seed <= seeds; seed++) {
    const text = await run(laglab, ['run', '-', '--seed', String(seed)], JSON.stringify(json));
    runs.push(JSON.parse(text).metrics.players);
  }
  const costs = [];
  for (let round = 0; round < cost_rounds; round++) {
    const cost = JSON.parse(await run(join(build, 'bench', 'speed'), [String(cost_s), '1'], JSON.stringify(json)));
    costs.push((1e6 * cost.cpu_s) / cost_s);
  }
  const values = Object.fromEntries(
    Object.entries(metrics).map(([name, of]) => {
      const perRun = runs.map((players) => mean(players.map(of)));
      return [name, { mean: mean(perRun), ci: interval(perRun) }];
    }),
  );
  return { values, us_per_sim_s: median(costs), us_per_sim_s_min: Math.min(...costs), us_per_sim_s_max: Math.max(...costs) };
}

const rows = [];
for (const [group, name, server, player, more] of techniques) {
  const { values, ...cost } = await measure(raceOf(server, player, more));
  rows.push({
    group,
    technique: name,
    ...cost,
    ...Object.fromEntries(
      Object.entries(values).flatMap(([metric, v]) => [
        [metric, v.mean],
        [`${metric}_ci95`, v.ci],
      ]),
    ),
  });
}
const shown = (row, metric) => `${digits(row[metric])} +- ${digits(row[`${metric}_ci95`], 2)}`;
printTable(
  `Four cars, two lanes, 100 ms one way, 20 ms jitter, 1 % loss, 30 updates/s; ${seeds} runs of ${duration_s} s (mean +- 95 %)`,
  rows.map((row) => ({
    technique: row.technique,
    'input latency ms': shown(row, 'input_latency_ms'),
    'own error m': shown(row, 'own_timeline_error_m'),
    'others now m': shown(row, 'remote_error_m'),
    'others, own timeline m': shown(row, 'timeline_error_m'),
    'view age ms': shown(row, 'view_age_ms'),
    'corrections/s': digits(row.corrections_per_s),
    'correction m': digits(row.correction_m),
    'bytes/s up': digits(row.up_bytes_per_s),
    down: digits(row.down_bytes_per_s),
    'us/simulated s': `${digits(row.us_per_sim_s)} (${digits(row.us_per_sim_s_min)}-${digits(row.us_per_sim_s_max)})`,
  })),
);

// ---- eight players with everything on ----

const everything = raceOf(
  { snapshot_encoding: 'delta' },
  {
    ...full,
    prediction_scope: 'all',
    ack: 'per_input',
    correction: 'smooth',
    time_dilation: true,
    interpolation_method: 'hermite',
    interpolation_delay: 'adaptive',
    extrapolation_ms: 250,
    dejitter: 'mirror',
    redundancy: 4,
  },
  {},
  8,
);
const speeds = [];
for (let round = 0; round < (quick ? 3 : 7); round++) {
  const cost = JSON.parse(await run(join(build, 'bench', 'speed'), [String(cost_s), '1'], JSON.stringify(everything)));
  speeds.push(cost_s / cost.cpu_s);
}
const speed = median(speeds);
rows.push({ group: 'batch', technique: 'eight players, everything on', us_per_sim_s: 1e6 / speed });
say('');
say(
  `eight players with everything on: ${digits(speed)} times real time ` +
    `(${digits(Math.min(...speeds))} to ${digits(Math.max(...speeds))}); ` +
    `at least 1,000: ${speed >= 1000 ? 'met' : 'MISSED'}`,
);

writeCsv(
  'techniques',
  `bench/run techniques${quick ? ' --quick' : ''}`,
  {
    group: 'what the technique is for',
    technique: 'the settings, in addition to the common link',
    ...Object.fromEntries(
      Object.keys(metrics).flatMap((metric) => [
        [metric, 'mean over runs and players'],
        [`${metric}_ci95`, 'half the 95 % interval over the runs'],
      ]),
    ),
    us_per_sim_s: 'CPU microseconds per simulated second of the whole session, median of some runs',
    us_per_sim_s_min: 'the least of these',
    us_per_sim_s_max: 'the most',
  },
  rows,
);
