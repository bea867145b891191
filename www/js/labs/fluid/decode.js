// What a frame has of fluids, put together for each of those side by side.

/** @typedef {{status: number, held: boolean, numbers: number[]}} State  status: 0 ok, 1 diverged */
/** Bytes row by row from the bottom: 0 to 254 from low to high, 255 where there is no fluid.
 * @typedef {{layer: number, width: number, height: number, low: number, high: number, bytes: Uint8Array}} Field */
/** Records of `columns` values each. @typedef {{layer: number, columns: number, count: number, values: Float32Array}} Points */
/** @typedef {{state: State, field: Field | null, points: Points[]}} Fluid */
/** @typedef {import('../../stream/frame.js').Frame} Frame */

const COLUMNS = ['x', 'y', 'value', 'value_2', 'value_3']; /* a layer has the first of them */

/** @param {import('../../stream/decode.js').Section} section @param {number} from @param {number} to rows of one layer
 * @param {number} layer @returns {Points} */
function points(section, from, to, layer) {
  const all = COLUMNS.map((name) => section.column(name).subarray(from, to)),
    count = to - from;
  const used = all.filter((column) => !Number.isNaN(column[0])),
    columns = used.length,
    values = new Float32Array(columns * count);
  used.forEach((column, k) => {
    for (let i = 0, at = k; i < count; i++, at += columns) values[at] = /** @type {number} */ (column[i]);
  });
  return { layer, columns, count, values };
}

/** The layers of a fluid's points. @param {Frame} frame @param {number} fluid @returns {Points[]} */
function layersOf(frame, fluid) {
  const section = frame.sections.get('points');
  if (!section) return [];
  const whose = section.column('fluid'),
    layers = section.column('layer');
  /** @type {Points[]} */
  const found = [];
  for (let from = 0, to = 0; from < section.count; from = to) {
    while (to < section.count && whose[to] === whose[from] && layers[to] === layers[from]) to++;
    if (whose[from] === fluid) found.push(points(section, from, to, /** @type {number} */ (layers[from])));
  }
  return found;
}

/** The fluids side by side. @param {Frame} frame @returns {Fluid[]} */
export function fluidsOf(frame) {
  return frame.fluid.map(({ status, held }, i) => {
    const field = frame.where('field', 'fluid', i)[0];
    return {
      state: { status, held, numbers: frame.where('fluid_numbers', 'fluid', i).map(({ value }) => value) },
      field: field ? { ...field, bytes: field.values } : null,
      points: layersOf(frame, i),
    };
  });
}
