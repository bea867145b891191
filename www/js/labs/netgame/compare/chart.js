// The curves of both runs over time, the space between them filled, and where the runs are now.
import { gridStep } from '../../../draw/axis.js';
import { drawText } from '../../../draw/marks.js';
import { paletteVersion } from '../../../draw/palette.js';

/** @typedef {{first: string, second: string, gap: string, gapText: string}} Colours */
/**
 * @typedef {object} Chart
 * @property {[Float64Array, Float64Array]} values  of each run a value per tick
 * @property {number} hz      ticks per second
 * @property {number} tick    where the runs are
 * @property {(value: number) => string} number  of the y axis
 * @property {string} time    at the top of the post
 * @property {string} gap     the distance at the post; empty where there is none
 */

/** @type {Colours | null} */
let cached = null;
let version = -1;
/** Of the two runs, from the style sheet. @returns {Colours} */
export function colours() {
  if (cached && version === paletteVersion()) return cached;
  const style = getComputedStyle(document.querySelector('main.compare') ?? document.documentElement);
  const read = (/** @type {string} */ name) => style.getPropertyValue(name).trim();
  version = paletteVersion();
  cached = { first: read('--first'), second: read('--second'), gap: read('--gap'), gapText: read('--gap-text') };
  return cached;
}

export const DASH = [7, 5];

/** @param {[Float64Array, Float64Array]} values */
function rangeOf(values) {
  let low = Infinity,
    high = -Infinity;
  for (const list of values) {
    for (const value of list) {
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  if (low > high) return { low: 0, high: 1 };
  const room = Math.max((high - low) * 0.08, Math.abs(high) * 0.01, 0.01);
  return { low: low === 0 ? 0 : low - room, high: high + room };
}

/** @param {CanvasRenderingContext2D} pen @param {number} x0 @param {number} y0 @param {number} x1 @param {number} y1 */
function rule(pen, x0, y0, x1, y1) {
  pen.beginPath();
  pen.moveTo(x0, y0);
  pen.lineTo(x1, y1);
  pen.stroke();
}

/** Ticks in order, with their values. @typedef {{ticks: Uint32Array, values: Float64Array}} Thinned */
/** By its values and how many ticks each group has. @type {WeakMap<Float64Array, {each: number, thinned: Thinned}>} */
const kept = new WeakMap();

/** Of each group of ticks those with the least and the greatest value, and each tick without a value: no peak and no gap is lost.
 * @param {Float64Array} list @param {number} each ticks of a group @returns {Thinned} */
export function thin(list, each) {
  const known = kept.get(list);
  if (known?.each === each) return known.thinned;
  /** @type {number[]} */
  const found = [];
  for (let from = 0; from < list.length; from += each) {
    const to = Math.min(from + each, list.length);
    let least = from,
      most = from;
    for (let tick = from; tick < to; tick++) {
      const value = /** @type {number} */ (list[tick]);
      if (Number.isNaN(value)) found.push(tick);
      if (!(value >= /** @type {number} */ (list[least]))) least = Number.isNaN(value) ? least : tick;
      if (!(value <= /** @type {number} */ (list[most]))) most = Number.isNaN(value) ? most : tick;
    }
    found.push(least, most);
  }
  const ticks = Uint32Array.from([...new Set(found)].sort((a, b) => a - b));
  const thinned = { ticks, values: Float64Array.from(ticks, (tick) => /** @type {number} */ (list[tick])) };
  kept.set(list, { each, thinned });
  return thinned;
}

/** @param {Thinned} list @param {number} from @param {number} to @param {(tick: number, value: number) => void} visit
 * @param {boolean} [back] */
function along({ ticks, values }, from, to, visit, back = false) {
  for (let k = 0; k < ticks.length; k++) {
    const at = back ? ticks.length - 1 - k : k,
      tick = /** @type {number} */ (ticks[at]);
    if (tick >= from && tick < to) visit(tick, /** @type {number} */ (values[at]));
  }
}

/** Pieces in which both curves have values. @param {[Float64Array, Float64Array]} values @returns {[number, number][]} from, to */
function pieces([one, other]) {
  const found = /** @type {[number, number][]} */ ([]);
  const ticks = Math.min(one.length, other.length);
  for (let from = 0; from < ticks; from++) {
    let to = from;
    while (to < ticks && !Number.isNaN(one[to]) && !Number.isNaN(other[to])) to++;
    if (to > from) found.push([from, to]);
    from = to;
  }
  return found;
}

/** Where the chart's time axis lies, px. @param {import('../../../draw/palette.js').Palette} palette @param {number} width */
export const spanOf = (palette, width) => ({ left: palette.text * 4.4, right: width - palette.text * 1.2 });

/** @param {import('../../../draw/surface.js').Surface} surface @param {import('../../../draw/palette.js').Palette} palette
 * @param {Chart} chart */
export function drawChart({ pen, width, height }, palette, chart) {
  const { text } = palette,
    { left, right } = spanOf(palette, width),
    top = text * 2.2,
    bottom = height - text * 1.9;
  const { first, second, gap, gapText } = colours();
  const ticks = Math.max(...chart.values.map((list) => list.length), 2),
    { low, high } = rangeOf(chart.values);
  const toX = (/** @type {number} */ tick) => left + ((right - left) * tick) / (ticks - 1);
  const toY = (/** @type {number} */ value) => bottom - ((bottom - top) * (value - low)) / (high - low);

  pen.setLineDash([]);
  pen.lineWidth = 1;
  pen.strokeStyle = palette.grid;
  const stepY = gridStep((bottom - top) / (high - low), text * 3.2);
  for (let i = Math.ceil(low / stepY); i * stepY <= high; i++) {
    const y = Math.round(toY(i * stepY)) + 0.5;
    pen.strokeStyle = palette.grid;
    rule(pen, left, y, right, y);
    drawText(pen, palette, chart.number(i * stepY), left - 6, y, { align: 'right', colour: palette.faint });
    pen.lineWidth = 1;
  }
  const seconds = (ticks - 1) / chart.hz,
    stepX = gridStep((right - left) / seconds, text * 7);
  for (let i = 0; i * stepX <= seconds + 1e-9; i++) {
    const x = toX(i * stepX * chart.hz);
    drawText(pen, palette, `${Number((i * stepX).toPrecision(6))} s`, Math.min(x, width - text * 1.5), height - text * 0.8, {
      align: 'center',
      colour: palette.faint,
    });
  }

  const [one, other] = chart.values;
  const thinned = [one, other].map((list) => thin(list, Math.ceil(ticks / (2 * (right - left)))));
  pen.fillStyle = gap;
  for (const [from, to] of pieces(chart.values)) {
    pen.beginPath();
    along(/** @type {Thinned} */ (thinned[0]), from, to, (tick, value) => pen.lineTo(toX(tick), toY(value)));
    along(/** @type {Thinned} */ (thinned[1]), from, to, (tick, value) => pen.lineTo(toX(tick), toY(value)), true);
    pen.fill();
  }
  thinned.forEach((list, side) => {
    pen.strokeStyle = side === 0 ? first : second;
    pen.lineWidth = palette.line + 0.5;
    pen.lineJoin = 'round';
    pen.setLineDash(side === 0 ? [] : DASH);
    pen.beginPath();
    let open = false;
    along(list, 0, Infinity, (tick, value) => {
      if (Number.isNaN(value)) open = false;
      else if (open) pen.lineTo(toX(tick), toY(value));
      else pen.moveTo(toX(tick), toY(value));
      if (!Number.isNaN(value)) open = true;
    });
    pen.stroke();
  });
  pen.setLineDash([]);
  if (chart.tick < ticks) drawPost();

  function drawPost() {
    const x = toX(chart.tick),
      ys = chart.values.map((list) => toY(list[chart.tick] ?? NaN));
    pen.strokeStyle = palette.ink;
    pen.lineWidth = 2;
    rule(pen, x, top - 2, x, bottom);
    pen.font = `700 ${text}px ${palette.font}`;
    const half = pen.measureText(chart.time).width / 2 + 9,
      middle = Math.max(half, Math.min(width - half, x));
    pen.fillStyle = palette.ink;
    pen.beginPath();
    pen.roundRect(middle - half, 2, 2 * half, text * 1.7, text * 0.85);
    pen.fill();
    pen.fillStyle = palette.paper;
    pen.textAlign = 'center';
    pen.textBaseline = 'middle';
    pen.fillText(chart.time, middle, 2 + text * 0.88);
    pen.lineWidth = 2.5;
    pen.fillStyle = palette.paper;
    const [y0 = NaN, y1 = NaN] = ys;
    if (Number.isFinite(y1)) {
      pen.strokeStyle = second;
      pen.beginPath();
      pen.rect(x - 5, y1 - 5, 10, 10);
      pen.fill();
      pen.stroke();
    }
    if (Number.isFinite(y0)) {
      pen.strokeStyle = first;
      pen.beginPath();
      pen.arc(x, y0, 5, 0, 2 * Math.PI);
      pen.fill();
      pen.stroke();
    }
    if (chart.gap === '' || !Number.isFinite(y0) || !Number.isFinite(y1)) return;
    const before = x > (left + right) / 2;
    const at = x + (before ? -14 : 14);
    pen.strokeStyle = gapText;
    pen.lineWidth = 2;
    rule(pen, at, y0, at, y1);
    drawText(pen, palette, chart.gap, at + (before ? -6 : 6), (y0 + y1) / 2, {
      align: before ? 'right' : 'left',
      bold: true,
      colour: gapText,
    });
  }
}
