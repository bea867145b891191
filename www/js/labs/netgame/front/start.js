// What one drives on the first page.

/** Lag that hurts, no technique; a car that is quick enough to be a length away after a second, on a road without an end. A and B have
 * persons: who drives B where no person does, opponent.js says.
 * @type {import('../../../session/lab.js').Start} */
export const START = {
  scenario: 'race',
  seed: 1,
  set: {
    duration_s: 3600,
    warmup_s: 0,
    'params.lap_m': 100000,
    'params.laps': 10000,
    'params.acceleration_mps2': 8,
    'params.brake_mps2': 12,
    'params.top_speed_mps': 13,
    'players.0.lag_ms': 150,
    'players.0.prediction': false,
    'players.0.reconciliation': false,
    'players.0.interpolation': false,
    'players.0.control': 'person',
    'players.1.lag_ms': 0,
    'players.1.control': 'person',
  },
};
