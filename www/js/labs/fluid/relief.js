// A field as a surface that is lit from the upper left: cubic B-splines over the cells, smooth to their second derivative, so that neither
// cells nor the steps of the bytes are seen; light by Lambert's law.

/** @typedef {import('./decode.js').Field} Field */

const RISE = 0.06; /* of the drawing's width: height of the whole range of colours */
const DEPTH = 0.45; /* how much of the light the colours take on */
const DIAGONAL = Math.SQRT1_2;

/** What the four cells around a place weigh, at the middles of `factor` parts of a cell: `factor` times four. @param {number} factor */
function weightsOf(factor) {
  return Array.from({ length: factor }, (_, part) => {
    const along = (part + 0.5) / factor - 0.5,
      from = Math.floor(along),
      t = along - from;
    return {
      from: from - 1,
      w: [(1 - t) ** 3 / 6, (3 * t ** 3 - 6 * t ** 2 + 4) / 6, (-3 * t ** 3 + 3 * t ** 2 + 3 * t + 1) / 6, t ** 3 / 6],
    };
  });
}

/** What is reused from frame to frame. */
let rows = new Float32Array(0),
  fine = new Float32Array(0);

/** Cells without fluid continue the cell before them. @param {Field} field @returns {Float32Array} */
function known({ bytes, width, height }) {
  const values = new Float32Array(width * height);
  for (let k = 0, last = 0; k < values.length; k++) {
    if (bytes[k] !== 255) last = bytes[k] ?? 0;
    values[k] = last;
  }
  return values;
}

/** The field in steps of a byte, `factor` times as fine, first along rows, then across. @param {Field} field @param {number} factor */
function refine(field, factor) {
  const { width, height } = field,
    w = width * factor,
    h = height * factor,
    values = known(field),
    weights = weightsOf(factor);
  if (rows.length < w * height) rows = new Float32Array(w * height);
  if (fine.length < w * h) fine = new Float32Array(w * h);
  for (let i = 0; i < w; i++) {
    const {
        from,
        w: [a = 0, b = 0, c = 0, d = 0],
      } = /** @type {{from: number, w: number[]}} */ (weights[i % factor]),
      at = Math.floor(i / factor) + from;
    const k = [0, 1, 2, 3].map((n) => Math.max(0, Math.min(width - 1, at + n))),
      [k0 = 0, k1 = 0, k2 = 0, k3 = 0] = k;
    for (let j = 0, base = 0; j < height; j++, base += width) {
      rows[j * w + i] =
        a * (values[base + k0] ?? 0) + b * (values[base + k1] ?? 0) + c * (values[base + k2] ?? 0) + d * (values[base + k3] ?? 0);
    }
  }
  for (let j = 0; j < h; j++) {
    const {
        from,
        w: [a = 0, b = 0, c = 0, d = 0],
      } = /** @type {{from: number, w: number[]}} */ (weights[j % factor]),
      at = Math.floor(j / factor) + from;
    const k = [0, 1, 2, 3].map((n) => Math.max(0, Math.min(height - 1, at + n)) * w),
      [k0 = 0, k1 = 0, k2 = 0, k3 = 0] = k;
    for (let i = 0, out = j * w; i < w; i++) {
      fine[out + i] = a * (rows[k0 + i] ?? 0) + b * (rows[k1 + i] ?? 0) + c * (rows[k2 + i] ?? 0) + d * (rows[k3 + i] ?? 0);
    }
  }
}

/** @param {Field} field @param {number[]} range of the colours @param {Uint32Array} map @param {number} none colour of cells without fluid
 * @param {number} factor pixels along a cell @param {Uint32Array} out pixels, rows going down */
export function drawRelief(field, [low = 0, high = 1], map, none, factor, out) {
  refine(field, factor);
  const w = field.width * factor,
    h = field.height * factor,
    top = map.length - 1;
  const step = (field.high - field.low) / 254 / (high - low),
    from = (field.low - low) / (high - low),
    rise = (step * RISE * w) / 2;
  for (let j = 0; j < h; j++) {
    const up = Math.min(h - 1, j + 1) * w,
      down = Math.max(0, j - 1) * w,
      here = j * w,
      to = (h - 1 - j) * w;
    for (let i = 0; i < w; i++) {
      const along = rise * ((fine[here + (i < w - 1 ? i + 1 : i)] ?? 0) - (fine[here + (i > 0 ? i - 1 : 0)] ?? 0));
      const across = rise * ((fine[up + i] ?? 0) - (fine[down + i] ?? 0));
      const light = DEPTH * ((1 + DIAGONAL * (along - across)) / Math.sqrt(1 + along * along + across * across) - 1);
      const place = Math.round((from + step * (fine[here + i] ?? 0)) * top),
        colour = map[place < 0 ? 0 : place > top ? top : place] ?? 0;
      const end = light < 0 ? 0 : 255,
        share = Math.min(0.5, Math.abs(light)); /* on the way to black or to white */
      const r = colour & 255,
        g = (colour >> 8) & 255,
        b = (colour >> 16) & 255;
      out[to + i] = (255 << 24) | ((b + (end - b) * share) << 16) | ((g + (end - g) * share) << 8) | (r + (end - r) * share);
    }
  }
  if (field.bytes.includes(255)) cover(field, none, factor, out);
}

/** @param {Field} field @param {number} none @param {number} factor @param {Uint32Array} out */
function cover({ bytes, width, height }, none, factor, out) {
  for (let k = 0; k < width * height; k++) {
    if (bytes[k] !== 255) continue;
    const left = (k % width) * factor,
      low = Math.floor(k / width) * factor;
    for (let j = low; j < low + factor; j++)
      out.fill(none, (height * factor - 1 - j) * width * factor + left, (height * factor - 1 - j) * width * factor + left + factor);
  }
}
