// The curves of two runs, from their traces: a line of CSV per tick.

/** @typedef {{ticks: number, hz: number, columns: Map<string, Float64Array>}} Trace  by column a value per tick, NaN where there is none */
/** column: of the trace; words: what the words of metrics or of the comparison call it; player: whose, from 0; digits: after the point;
 * size: without its sign
 * @typedef {{column: string, words: string, player: number, unit: string, digits: number, size: boolean}} Curve */

/** Columns of a player that mean something over time, those that mostly differ first. */
const OWN = /** @type {[string, string, number][]} */ ([
  ['remote_error_m', 'm', 2] /* its sign is of the direction, which changes where things turn */,
  ['view_age_ms', 'ms', 0],
  ['own_lead_m', 'm', 2],
  ['own_timeline_error_m', 'm', 2],
  ['buffer_ms', 'ms', 0],
  ['age_of_information_ms', 'ms', 0],
  ['unacked', '', 0],
  ['corrections', '', 0],
]);

/** @param {number} players @returns {Curve[]} */
export function curvesOf(players) {
  return Array.from({ length: players }, (_, player) => [
    ...OWN.map(([name, unit, digits]) => ({
      column: `player_${player}_${name}`,
      words: name === 'remote_error_m' ? 'others' : `players.*.${name}`,
      player,
      unit,
      digits,
      size: name === 'remote_error_m',
    })),
    ...['x', 'y'].map((way) => ({ column: `server_${player}_${way}_m`, words: `place.${way}`, player, unit: 'm', digits: 2, size: false })),
  ]).flat();
}

/** @param {string} text CSV with a line per tick from 0 on @param {number} hz @param {Curve[]} wanted @returns {Trace} */
export function readTrace(text, hz, wanted) {
  const lines = text.split(/\r?\n/),
    names = (lines[0] ?? '').split(',');
  const ticks = lines.filter((line) => line !== '').length - 1;
  const places = names.flatMap((name, i) => {
    const curve = wanted.find(({ column }) => column === name);
    return curve ? [{ i, name, size: curve.size, values: new Float64Array(ticks).fill(NaN) }] : [];
  });
  for (let tick = 0; tick < ticks; tick++) {
    const cells = /** @type {string} */ (lines[tick + 1]).split(',');
    for (const { i, values, size } of places) {
      const value = cells[i] === '' || cells[i] === undefined ? NaN : Number(cells[i]);
      values[tick] = size ? Math.abs(value) : value;
    }
  }
  return { ticks, hz, columns: new Map(places.map(({ name, values }) => [name, values])) };
}

/** How far two curves are apart: where both have values. @param {Float64Array} one @param {Float64Array} other
 * @returns {{mean: number, most: number, at: number}} at: the tick where it is most */
export function apart(one, other) {
  let sum = 0,
    count = 0,
    most = 0,
    at = 0;
  for (let tick = 0; tick < Math.min(one.length, other.length); tick++) {
    const distance = Math.abs(/** @type {number} */ (other[tick]) - /** @type {number} */ (one[tick]));
    if (!(distance >= 0)) continue;
    sum += distance;
    count++;
    if (distance > most) {
      most = distance;
      at = tick;
    }
  }
  return { mean: count > 0 ? sum / count : 0, most, at };
}
