// The cases for comparing the adviser with brute force: grids of settings, each with the limits that are asked for on it.
// `limits` are numbers, or {rank: r}: the error at the r-th part of the grid's settings in the order of their errors, exactly. Where
// seeds matter, `repeats` is above 1; where the error counts rare events, `event` is what one adds to that of a run. `sample` is
// what the tests take.

/** @typedef {{name: string, kind: string, what: string[], experiment: Record<string, any>, limits: (number | {rank: number})[],
 * sample?: boolean, event?: number}} Grid */

const log = (path, from, to, count) => ({ path, from, to, count, scale: 'log' });
const list = (path, ...values) => ({ path, values });

/** One method on one problem. */
const motion = (problem, duration_s, method, axes, error, cost = 'evaluations', more = {}, repeats = 1) => ({
  scenario: { kind: 'motion', problem, duration_s, methods: [method], ...more },
  axes,
  repeats,
  metrics: [`methods.0.${error}`, `methods.0.${cost}`],
});
const METHODS = ['explicit_euler', 'semi_implicit_euler', 'velocity_verlet', 'rk4', 'yoshida4', 'yoshida6', 'implicit_euler', 'trapezoid'];
const method = (...names) => list('methods.0.method', ...names);
const dt = (...values) => list('methods.0.dt_s', ...values);
const rk4 = { method: 'rk4', dt_s: 0.01 };

const of = (scenario, set, axes, error, cost, repeats = 1) => ({ scenario, set, axes, repeats, metrics: [error, cost] });
const SOLVERS = ['pgs', 'pgs_ngs', 'soft_step', 'tgs_sticky', 'xpbd', 'avbd'];
const solver = (...names) => list('solver.method', ...(names.length ? names : SOLVERS));
const passes = (...values) => ({ zip: [list('solver.substeps', ...values), list('solver.iterations', ...values)] });
const hz = (...values) => list('hz', ...values);

const link = (up, down) =>
  Object.fromEntries([
    ...Object.entries(up).map(([k, v]) => [`players.0.link.up.${k}`, v]),
    ...Object.entries(down).map(([k, v]) => [`players.0.link.down.${k}`, v]),
  ]);
const down_bytes = 'players.0.bandwidth.down_bytes_per_s',
  up_bytes = 'players.0.bandwidth.up_bytes_per_s';
const together =
  (...paths) =>
  (...values) => ({ zip: paths.map((path) => list(path, ...values)) });

/** @type {Grid[]} */
export const grids = [
  // ---- motion: nothing is random but the lengths of frames ----
  {
    name: 'orbit, fixed steps',
    kind: 'motion',
    what: ['methods that fail'],
    sample: true,
    limits: [1e-2, 1e-4, 1e-6, 1e-15],
    experiment: motion('kepler', 10, rk4, [method(...METHODS), dt(0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002)], 'e_max', 'evaluations', {
      params: { e: 0.6 },
    }),
  },
  {
    name: 'fast spring',
    kind: 'motion',
    what: ['methods that fail', 'limit exactly on a value'],
    limits: [0.1, 1e-4, { rank: 0.3 }],
    experiment: motion('oscillator', 6, rk4, [method(...METHODS, 'ab4'), log('methods.0.dt_s', 0.004, 0.5, 14)], 'e_max', 'evaluations', {
      params: { omega: 9 },
    }),
  },
  {
    name: 'limit cycle',
    kind: 'motion',
    what: ['methods that fail', 'not converging'],
    limits: [0.5, 1e-2],
    experiment: motion(
      'van_der_pol',
      9,
      rk4,
      [
        method('explicit_euler', 'rk2', 'rk4', 'ab2', 'ab4', 'implicit_euler', 'implicit_midpoint', 'trapezoid'),
        log('methods.0.dt_s', 0.002, 0.5, 14),
      ],
      'e_max',
      'evaluations',
      { params: { mu: 8 } },
    ),
  },
  {
    name: 'energy of a pendulum',
    kind: 'motion',
    what: ['signed'],
    sample: true,
    limits: [1e-2, 1e-5],
    experiment: motion(
      'pendulum',
      12,
      rk4,
      [
        method('explicit_euler', 'semi_implicit_euler', 'velocity_verlet', 'rk2', 'rk3', 'rk4', 'ruth3', 'yoshida4', 'yoshida6'),
        log('methods.0.dt_s', 0.002, 0.3, 16),
      ],
      'energy_drift_final',
    ),
  },
  {
    name: 'tolerances in a galaxy',
    kind: 'motion',
    what: ['adaptive', 'log axis'],
    limits: [1e-3, 1e-6, 1e-9],
    experiment: motion(
      'henon_heiles',
      30,
      { method: 'dopri5' },
      [method('bs32', 'dopri5', 'tsit5', 'dop853', 'extrapolated_midpoint'), log('methods.0.tolerance', 1e-12, 1e-1, 23)],
      'e_max',
    ),
  },
  {
    name: 'stiff reaction',
    kind: 'motion',
    what: ['adaptive', 'cost is factorisations, 0 of an explicit method'],
    limits: [1e-5, 1e-9],
    experiment: motion(
      'robertson',
      4,
      { method: 'radau5' },
      [method('bs32', 'rodas4', 'rodas5p', 'radau5', 'radau9'), log('methods.0.tolerance', 1e-11, 1e-1, 16)],
      'e_max',
      'evaluations',
    ),
  },
  {
    name: 'slopes of many lengths',
    kind: 'motion',
    what: ['ties', 'cost is steps'],
    limits: [0.5, 0.02],
    experiment: motion(
      'drag_vertical',
      3,
      rk4,
      [
        method('explicit_euler', 'semi_implicit_euler', 'rk2', 'ralston', 'rk3', 'rk4', 'velocity_verlet'),
        dt(0.5, 0.3, 0.2, 0.1, 0.06, 0.03, 0.02, 0.01),
      ],
      'e_final',
      'steps',
    ),
  },
  {
    name: 'frames of random length',
    kind: 'motion',
    what: ['noisy'],
    limits: [0.1, 0.03],
    sample: true,
    experiment: motion(
      'damped',
      4,
      { method: 'rk2', steps: 'frame' },
      [
        method('explicit_euler', 'semi_implicit_euler', 'verlet_improved', 'velocity_verlet', 'rk2', 'rk4'),
        log('frame_s', 0.01, 0.3, 10),
        list('frame_jitter', 0.2, 0.5, 0.8),
      ],
      'e_max',
      'evaluations',
      { params: { omega: 4 }, frames: 'random' },
      10,
    ),
  },
  {
    name: 'accumulator, random frames',
    kind: 'motion',
    what: ['noisy', 'cost with noise'],
    limits: [0.3, 0.1],
    experiment: motion(
      'oscillator',
      4,
      { method: 'rk4', steps: 'accumulator' },
      [
        method('semi_implicit_euler', 'velocity_verlet', 'rk4'),
        log('methods.0.dt_s', 0.005, 0.2, 10),
        list('methods.0.steps', 'frame', 'accumulator'),
      ],
      'e_l2',
      'evaluations',
      { params: { omega: 3 }, frames: 'random', frame_s: 0.05, frame_jitter: 0.6 },
      10,
    ),
  },

  // ---- rigid bodies: nothing is random ----
  {
    name: 'pyramid',
    kind: 'rigid',
    what: ['ties'],
    limits: [0.02, 0.002],
    sample: true,
    experiment: of(
      'rigid/pyramid',
      { duration_s: 1 },
      [solver(), hz(30, 60, 120), passes(1, 2, 4, 8, 16, 32)],
      'drift_worst_m',
      'passes_per_s',
    ),
  },
  {
    name: 'energy of a column',
    kind: 'rigid',
    what: ['signed', 'ties', 'no feasible setting'],
    limits: [1, 8.05, 25],
    sample: true,
    experiment: of(
      'rigid/column',
      { duration_s: 1, 'params.size': 8, side_by_side: [] },
      [solver('impulse', ...SOLVERS), hz(30, 60, 120), passes(1, 2, 4, 8, 16, 32)],
      'energy_change_j',
      'passes_per_s',
    ),
  },
  {
    name: 'joints of a bridge',
    kind: 'rigid',
    what: ['ties'],
    limits: [0.05, 0.01],
    experiment: of(
      'rigid/bridge',
      { duration_s: 1 },
      [solver('pgs', 'soft_step', 'tgs_sticky', 'xpbd', 'avbd'), hz(30, 60, 90, 120), passes(1, 2, 4, 8, 16, 32)],
      'joint_error_worst',
      'passes_per_s',
    ),
  },
  {
    name: 'integer substeps of a stack',
    kind: 'rigid',
    what: ['integer axis', 'limit exactly on a value'],
    limits: [{ rank: 0.2 }, { rank: 0.5 }],
    experiment: of(
      'rigid/circle_stack',
      { duration_s: 1 },
      [solver('soft_step', 'tgs_sticky', 'xpbd'), { path: 'solver.substeps', from: 1, to: 32, count: 32 }],
      'sag_worst_m',
      'passes_per_s',
    ),
  },
  {
    name: 'ball and chain',
    kind: 'rigid',
    what: ['log axis'],
    limits: [0.2, 0.03],
    experiment: of(
      'rigid/ball_chain',
      { duration_s: 1, side_by_side: [] },
      [solver('soft_step', 'tgs_sticky', 'xpbd'), { path: 'solver.substeps', from: 1, to: 64, count: 12, scale: 'log' }, hz(30, 60, 120)],
      'joint_error_worst',
      'passes_per_s',
    ),
  },
  {
    name: 'overlap at the start',
    kind: 'rigid',
    what: ['no feasible setting'],
    limits: [1e-9, 0.3],
    experiment: of(
      'rigid/overlap',
      { duration_s: 0.5 },
      [solver(), hz(30, 60, 120), passes(1, 2, 4, 8, 16)],
      'penetration_max_m',
      'passes_per_s',
    ),
  },
  {
    name: 'dominoes',
    kind: 'rigid',
    what: ['signed'],
    limits: [0.5, 1.05],
    experiment: of(
      'rigid/domino',
      { duration_s: 1 },
      [solver(), hz(30, 60, 120), passes(1, 2, 4, 8, 16, 32)],
      'energy_change_j',
      'passes_per_s',
    ),
  },
  {
    name: 'stiffness of contacts',
    kind: 'rigid',
    what: ['log axis', 'two axes of no cost: ties by error'],
    limits: [0.01, 0.001],
    experiment: of(
      'rigid/column',
      { duration_s: 1, 'params.size': 6, side_by_side: [] },
      [
        log('solver.contact_hertz', 5, 500, 8),
        list('solver.contact_damping_ratio', 0.5, 2, 10),
        { path: 'solver.substeps', from: 1, to: 24, count: 6 },
      ],
      'penetration_worst_m',
      'passes_per_s',
    ),
  },

  // ---- fluids: nothing is random ----
  {
    name: 'vortices on a grid',
    kind: 'fluid',
    what: ['log axis'],
    limits: [0.02, 0.005],
    sample: true,
    experiment: of(
      'fluid/taylor_green',
      { duration_s: 0.5 },
      [
        list('params.n', 16, 24, 32, 48),
        list('solver.pressure', 'gauss_seidel', 'sor', 'pcg', 'multigrid', 'direct'),
        log('solver.tolerance', 1e-4, 0.3, 4),
      ],
      'error_l2',
      'cell_visits',
    ),
  },
  {
    name: 'decay of vortices',
    kind: 'fluid',
    what: ['signed', 'no feasible setting'],
    limits: [0.05, 0.01, 1e-7],
    experiment: of(
      'fluid/taylor_green',
      { duration_s: 0.5 },
      [
        list('solver.advection', 'semi_lagrangian', 'maccormack', 'bfecc', 'central'),
        list('params.n', 12, 16, 20, 24, 32, 40, 48),
        list('solver.cfl', 0.3, 0.6, 1),
      ],
      'decay_error',
      'cell_visits',
    ),
  },
  {
    name: 'divergence that is left',
    kind: 'fluid',
    what: ['not converging'],
    limits: [0.1, 1e-3, 1e-6],
    experiment: of(
      'fluid/cavity',
      { duration_s: 0.3, 'solver.tolerance': 0, 'params.n': 24 },
      [list('solver.pressure', 'jacobi', 'gauss_seidel', 'sor', 'pcg', 'multigrid'), log('solver.sweeps', 1, 300, 14)],
      'divergence_max',
      'cell_visits',
    ),
  },
  {
    name: 'rotation of a disc',
    kind: 'fluid',
    what: ['cost is bytes', 'ties by error'],
    limits: [0.06, 0.04],
    experiment: of(
      'fluid/rotation',
      { duration_s: 0.3 },
      [
        list('solver.advection', 'semi_lagrangian', 'maccormack', 'bfecc'),
        list('params.n', 16, 24, 32, 48, 64),
        list('solver.cfl', 0.5, 1, 2, 4),
      ],
      'error_l1',
      'bytes',
    ),
  },
  {
    name: 'particles in a channel',
    kind: 'fluid',
    what: ['integer axis'],
    limits: [0.05, 0.02],
    experiment: of(
      'fluid/poiseuille',
      { duration_s: 0.3, 'solver.iterations': 20 },
      [list('solver.method', 'wcsph', 'pbf', 'dfsph'), { path: 'params.size', from: 16, to: 28, count: 13 }, list('solver.cfl', 0.25, 0.5)],
      'velocity_error_rms',
      'cell_visits',
    ),
  },
  {
    name: 'water at rest',
    kind: 'fluid',
    what: ['log axis'],
    limits: [0.1, 0.02],
    sample: true,
    experiment: of(
      'fluid/hydrostatic',
      { duration_s: 0.4 },
      [list('solver.method', 'pbf', 'dfsph'), list('params.size', 8, 10, 12, 16), log('solver.iterations', 1, 64, 7)],
      'pressure_error_rms',
      'cell_visits',
    ),
  },
  {
    name: 'dam that may explode',
    kind: 'fluid',
    what: ['blows up', 'signed'],
    limits: [0.025, 0.005],
    experiment: of(
      'fluid/dam_break',
      { duration_s: 0.5 },
      [
        list('solver.method', 'wcsph', 'pbf', 'dfsph'),
        list('solver.lagged_density', false, true),
        list('params.size', 8, 10, 12, 14),
        list('solver.iterations', 2, 6, 20),
      ],
      'front_error',
      'cell_visits',
    ),
  },
  {
    name: 'lid and its vortex',
    kind: 'fluid',
    what: ['methods that fail'],
    limits: [0.15, 0.13, 0.124],
    experiment: of(
      'fluid/cavity',
      { duration_s: 1.5 },
      [
        list('solver.advection', 'semi_lagrangian', 'maccormack', 'bfecc', 'central'),
        list('params.n', 8, 12, 16, 24),
        list('solver.pressure', 'sor', 'pcg', 'multigrid', 'direct'),
        list('solver.cfl', 1, 8),
      ],
      'error_max',
      'cell_visits',
    ),
  },

  // ---- netgames: loss, jitter and scripts are drawn by the seed ----
  {
    name: 'race, what A sees of B',
    kind: 'netgame',
    what: ['noisy'],
    limits: [3, 1.5],
    sample: true,
    experiment: of(
      'race',
      { duration_s: 5, ...link({ jitter_ms: 30 }, { loss_pct: 5 }) },
      [
        list('server.update_hz', 2, 3, 5, 7, 10, 15, 20, 30, 45, 60),
        list('players.0.lag_ms', 20, 60, 100, 150),
        list('players.0.interpolation', false, true),
      ],
      'players.0.remote_error_m.mean',
      down_bytes,
      12,
    ),
  },
  {
    name: 'rate and codec',
    kind: 'netgame',
    what: ['noisy'],
    limits: [0.3, 0.15, 0.08],
    experiment: of(
      'crates',
      { duration_s: 6, 'params.count': 12, ...link({ jitter_ms: 20, loss_pct: 3 }, { jitter_ms: 30, loss_pct: 3 }) },
      [
        list('server.snapshot_encoding', 'full', 'quantised', 'delta'),
        list('server.update_hz', 4, 6, 8, 10, 15, 20, 30, 40, 60),
        list('players.0.interpolation_ratio', 1, 2, 3),
      ],
      'players.0.remote_error_m.mean',
      down_bytes,
      8,
    ),
  },
  {
    name: 'jerk against age',
    kind: 'netgame',
    what: ['noisy', '480 settings'],
    limits: [3000, 1000, 700],
    experiment: of(
      'race',
      { duration_s: 5, 'players.0.lag_ms': 60, ...link({}, { jitter_ms: 40, loss_pct: 4 }) },
      [
        list('server.update_hz', 6, 8, 10, 12, 15, 20, 30, 60),
        list('players.0.interpolation_ratio', 1, 1.5, 2, 3),
        list('players.0.jitter_margin_ms', 0, 10, 20, 40, 80),
        list('players.0.extrapolation_ms', 0, 100, 250),
      ],
      'players.0.smoothness.jerk_rms_mps3',
      'players.0.view_age_ms.mean',
      3,
    ),
  },
  {
    name: 'de-jitter buffer',
    kind: 'netgame',
    what: ['noisy'],
    limits: [0.1, 0.02],
    experiment: of(
      'dejitter_500',
      { duration_s: 8 },
      [list('players.0.dejitter', 'send_time', 'mirror', 'nfe'), { path: 'players.0.dejitter_ms', from: 20, to: 490, count: 20 }],
      'players.0.dejitter.late_ratio',
      'players.0.dejitter.added_mean_ms',
      12,
    ),
  },
  {
    name: 'shots that miss by rewinding',
    kind: 'netgame',
    what: ['noisy', 'rare counts'],
    event: 1,
    limits: [1, 0.25],
    experiment: of(
      'behind_cover',
      { duration_s: 15 },
      [
        list('server.update_hz', 10, 12, 15, 20, 25, 30, 40, 60),
        list('server.max_rewind_ms', 100, 150, 200, 250, 300),
        list('players.1.interpolation_ratio', 1, 2),
      ],
      'players.1.shots.hitscan.false_misses',
      'players.1.bandwidth.down_bytes_per_s',
      12,
    ),
  },
  {
    name: 'rollback and input delay',
    kind: 'netgame',
    what: ['noisy', 'integer axis', 'rare counts'],
    event: 1 / 12,
    limits: [1, 0.05],
    experiment: of(
      'rollback_loss',
      { duration_s: 14 },
      [
        list('server.max_rollback_ticks', 4, 6, 8),
        list('server.sync', 'deterministic', 'rollback'),
        together('players.0.input_delay_ticks', 'players.1.input_delay_ticks')(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12),
      ],
      'players.0.rollback.ticks_per_s',
      'players.0.ack_rtt_ms.mean',
      10,
    ),
  },
  {
    name: 'corrections over a bad uplink',
    kind: 'netgame',
    what: ['noisy', 'integer axes', 'cost is bytes up', 'rare counts'],
    event: 1 / 6,
    limits: [0.3, 0.12],
    experiment: of(
      'race',
      { duration_s: 8, 'players.0.lag_ms': 80, ...link({ jitter_ms: 20, loss_pct: 30, loss_corr_pct: 60 }, {}) },
      [
        { path: 'players.0.redundancy', from: 0, to: 9, count: 10 },
        { path: 'players.0.slack_ticks', from: 0, to: 4, count: 5 },
        list('players.0.send_hz', 20, 30, 0),
      ],
      'players.0.visible_corrections_per_s',
      up_bytes,
      8,
    ),
  },
  {
    name: 'inputs that come late',
    kind: 'netgame',
    what: ['noisy', 'cost is a delay', 'rare counts'],
    event: 1 / 6,
    limits: [0.8, 0.2],
    sample: true,
    experiment: of(
      'race',
      { duration_s: 8, 'players.0.lag_ms': 50, ...link({ jitter_ms: 30, distribution: 'normal', loss_pct: 2 }, {}) },
      [
        { path: 'players.0.slack_ticks', from: 0, to: 10, count: 11 },
        { path: 'players.0.redundancy', from: 0, to: 4, count: 5 },
        list('players.0.time_dilation', false, true),
      ],
      'players.0.inputs.starved_per_s',
      'players.0.own_lead_ms.mean',
      8,
    ),
  },
  {
    name: 'lockstep over bursts of loss',
    kind: 'netgame',
    what: ['noisy', 'heavy tails'],
    limits: [0.5, 0.02],
    experiment: of(
      'race',
      { duration_s: 8, 'server.sync': 'deterministic', ...link({ loss_model: 'gemodel', ge_p_pct: 2, ge_r_pct: 30 }, { jitter_ms: 15 }) },
      [
        together('players.0.input_delay_ticks', 'players.1.input_delay_ticks')(0, 1, 2, 3, 4, 6, 8, 10, 12, 14, 16),
        together('players.0.lag_ms', 'players.1.lag_ms')(20, 50, 80),
        list('players.0.redundancy', 0, 3, 10),
      ],
      'players.0.stalls.stalled_s',
      'players.0.ack_rtt_ms.mean',
      8,
    ),
  },
  {
    name: 'a metric that a third of the settings lacks',
    kind: 'netgame',
    what: ['null metric'],
    limits: [10, 1],
    experiment: of(
      'race',
      { duration_s: 8, ...link({ jitter_ms: 10 }, { jitter_ms: 30 }) },
      [
        list('players.0.dejitter', 'none', 'send_time', 'arrival'),
        { path: 'players.0.dejitter_ms', from: 5, to: 100, count: 8 },
        list('server.update_hz', 10, 20, 30),
      ],
      'players.0.dejitter.added_mean_ms',
      down_bytes,
      6,
    ),
  },
];
