// Decodes a frame's sections of a fluid, 48 to 51.

/** @typedef {{status: number, held: boolean, numbers: number[]}} State  status: 0 ok, 1 diverged */
/** Bytes row by row from the bottom: 0 to 254 from low to high, 255 where there is no fluid.
 * @typedef {{layer: number, width: number, height: number, low: number, high: number, bytes: Uint8Array}} Field */
/** Records of `columns` values each. @typedef {{layer: number, columns: number, count: number, values: Float32Array}} Points */
/** @typedef {{state: State, field: Field | null, points: Points[]}} Fluid */
/** @typedef {import('../frame.js').Section} Section */

const HEAD = 24;

/** @param {Section} section @returns {State} */
function state({ bytes }) {
  const count = Math.min(bytes.getUint16(2, true), (bytes.byteLength - 8) / 8);
  return {
    status: bytes.getUint8(0), held: bytes.getUint8(1) === 1, numbers: Array.from({ length: count }, (_, i) => bytes.getFloat64(8 + 8 * i, true)),
  };
}

/** @param {Section} section @returns {Field} */
function field({ bytes }) {
  return {
    layer: bytes.getUint8(0), width: bytes.getUint32(4, true), height: bytes.getUint32(8, true), low: bytes.getFloat32(16, true),
    high: bytes.getFloat32(20, true), bytes: new Uint8Array(bytes.buffer, bytes.byteOffset + HEAD, bytes.byteLength - HEAD),
  };
}

/** @param {Section} section @returns {Points} */
function points({ bytes }) {
  const columns = bytes.getUint8(1), count = bytes.getUint32(4, true);
  return { layer: bytes.getUint8(0), columns, count, values: new Float32Array(bytes.buffer, bytes.byteOffset + HEAD, columns * count) };
}

/** The fluids side by side. @param {import('../frame.js').Frame} frame @returns {Fluid[]} */
export function fluidsOf(frame) {
  const all = (/** @type {number} */ type, /** @type {number} */ place) => (frame.own.get(type) ?? []).filter(({ bytes }) => bytes.getUint16(2, true) === place);
  return (frame.own.get(48) ?? []).map((section, i) => ({
    state: state(section), field: all(49, i).map(field)[0] ?? null, points: [...all(50, i), ...all(51, i)].map(points),
  }));
}
