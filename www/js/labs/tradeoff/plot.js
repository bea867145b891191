// Error against one cost: the lines of methods with their names at the ends, the two handles with the field within both, the ring.
import { drawText, outline, widthOf } from '../../draw/marks.js';
import { paintOf } from '../../draw/palette.js';
import { localized } from '../../base/format.js';
import { countOf, tenTo } from './names.js';

/** @typedef {import('./rule.js').Point} Point */
/** @typedef {import('./rule.js').Lines} Lines */
/** @typedef {import('../../draw/palette.js').Palette} Palette */
/** log: in decades; low, high: its ends, as numbers or decades @typedef {{log: boolean, low: number, high: number}} Axis */
/** In CSS px. @typedef {{x: number, y: number}} Spot */
/** left, right, top, bottom: of the field, px; limit: how far names may reach
 * @typedef {{left: number, right: number, limit: number, top: number, bottom: number, across: Axis, up: Axis,
 *   toX: (value: number) => number, toY: (value: number) => number, ofX: (px: number) => number, ofY: (px: number) => number}} Frame */
/** @typedef {{method: string, text: string, x: number, y: number, width: number}} Label */

const FORMS = 8; /* marks, and colours */
const MANY = 8; /* times between least and largest, from which on an axis has decades */
const NEAR_PX = 22;
export const SMALL_PX = 520; /* of a phone */
export const TOUCH_PX = 44; /* of what a thumb takes */
const LABEL_PX = 26; /* between two names, one below the other: each can be pressed */

/** Of a method by its place: with more methods than marks the same mark has another colour. @param {number} place */
export const formOf = (place) => ({ shape: place % FORMS, colour: (place + Math.floor(place / FORMS)) % FORMS });

/** @param {number[]} values @param {boolean} zero whether 0 is one of them @returns {Axis} */
function axisOf(values, zero) {
  const above = values.filter((value) => value > 0),
    low = Math.min(...above),
    high = Math.max(...above);
  if (above.length === 0) return { log: false, low: 0, high: 1 };
  if (zero || high / low < MANY) return { log: false, low: 0, high: high * 1.08 };
  const room = Math.max(0.12, (Math.log10(high) - Math.log10(low)) * 0.04);
  return { log: true, low: Math.log10(low) - room, high: Math.log10(high) + room };
}

/** Where values are, in a plot of this size. @param {Point[]} points all that may be shown, and both lines
 * @param {{width: number, height: number}} size @param {number} text px @returns {Frame} */
export function frameOf(points, { width, height }, text) {
  const small = width < SMALL_PX,
    costs = points.map(({ cost }) => cost),
    errors = points.map(({ error }) => error);
  const across = axisOf(costs, costs.includes(0)),
    up = axisOf(errors, errors.includes(0));
  const left = small ? text * 3.6 : text * 5.6,
    right = width - (small ? 8 : text * 2),
    top = text * (small ? 4.4 : 3.4),
    bottom = height - text * 3.6;
  const at = (/** @type {Axis} */ { log, low, high }, /** @type {number} */ value) =>
    log ? (value > 0 ? Math.log10(value) - low : -0.1) / (high - low) : (value - low) / (high - low);
  const of = (/** @type {Axis} */ { log, low, high }, /** @type {number} */ share) => {
    const value = low + Math.max(0, Math.min(1, share)) * (high - low);
    return log ? 10 ** value : value;
  };
  return {
    left,
    right,
    limit: width - 4,
    top,
    bottom,
    across,
    up,
    toX: (value) => left + Math.max(0, Math.min(1, at(across, value))) * (right - left),
    toY: (value) => bottom - Math.max(0, Math.min(1, at(up, value))) * (bottom - top),
    ofX: (px) => of(across, (px - left) / (right - left)),
    ofY: (px) => of(up, (bottom - px) / (bottom - top)),
  };
}

/** Round values along an axis. @param {Axis} axis @param {number} most how many have room @returns {number[]} */
function ticksOf({ log, low, high }, most) {
  if (log) {
    const step = Math.max(1, Math.ceil((high - low) / Math.max(2, most))),
      leads = high - low < 1.6 ? [1, 2, 5] : high - low < 2.4 && most > 5 ? [1, 3] : [1],
      list = [];
    for (let power = Math.floor(low); power <= high; power++)
      if (power % step === 0)
        for (const lead of leads) if (Math.log10(lead) + power >= low && Math.log10(lead) + power <= high) list.push(lead * 10 ** power);
    return list;
  }
  const raw = (high - low) / Math.max(2, most),
    power = 10 ** Math.floor(Math.log10(raw)),
    step = (raw / power <= 1 ? 1 : raw / power <= 2 ? 2 : raw / power <= 5 ? 5 : 10) * power,
    list = [];
  for (let k = Math.ceil(low / step); k * step <= high; k++) list.push(Number((k * step).toPrecision(12)));
  return list;
}

/** @param {number} value */
function tickText(value) {
  const power = Math.log10(value);
  if (value === 0 || (value >= 0.001 && value < 1)) return localized(String(Number(value.toPrecision(3))));
  if (value >= 1 && value < 1e12) return countOf(value);
  return Math.abs(power - Math.round(power)) < 1e-9
    ? tenTo(Math.round(power))
    : `${value / 10 ** Math.floor(power)} · ${tenTo(Math.floor(power))}`;
}

/** The lines: of a method by one of its settings. @param {Point[]} points @returns {Point[][]} each in the order of the setting */
function linesOf(points) {
  /** @type {Map<string, Point[]>} */
  const lines = new Map();
  for (const point of points) lines.set(point.line, [...(lines.get(point.line) ?? []), point]);
  return [...lines.values()].map((list) => list.sort((a, b) => a.value - b.value));
}

/** @param {CanvasRenderingContext2D} pen @param {Spot[]} spots */
function way(pen, spots) {
  pen.beginPath();
  spots.forEach(({ x, y }, k) => (k === 0 ? pen.moveTo(x, y) : pen.lineTo(x, y)));
  pen.stroke();
}

/** @param {CanvasRenderingContext2D} pen @param {Palette} colours @param {Frame} frame @param {{x: string, y: string, small: boolean}} of
 * names of the axes */
function grid(pen, colours, frame, { x, y, small }) {
  const { left, right, top, bottom } = frame,
    size = colours.axis;
  const rule = (/** @type {Spot} */ from, /** @type {Spot} */ to) => {
    pen.lineWidth = 1;
    pen.strokeStyle = colours.grid;
    pen.setLineDash([]);
    way(pen, [from, to]);
  };
  for (const tick of ticksOf(frame.across, (right - left) / 72)) {
    const at = Math.round(frame.toX(tick)) + 0.5;
    rule({ x: at, y: top }, { x: at, y: bottom });
    drawText(pen, colours, tickText(tick), at, bottom + size * 1.1, { size, align: 'center', colour: colours.faint });
  }
  for (const tick of ticksOf(frame.up, (bottom - top) / 42)) {
    const at = Math.round(frame.toY(tick)) + 0.5;
    rule({ x: left, y: at }, { x: right, y: at });
    drawText(pen, colours, tickText(tick), left - 7, at, { size, align: 'right', colour: colours.faint });
  }
  pen.strokeStyle = colours.edge;
  pen.lineWidth = 1.5;
  way(pen, [
    { x: left, y: top },
    { x: left, y: bottom },
    { x: right, y: bottom },
  ]);
  drawText(pen, colours, x, (left + right) / 2, bottom + size * 2.6, { align: 'center', bold: true, size });
  if (small) {
    drawText(pen, colours, y, 4, size * 0.7, { bold: true, size });
    return;
  }
  pen.save();
  pen.translate(size * 0.9, (top + bottom) / 2);
  pen.rotate(-Math.PI / 2);
  drawText(pen, colours, y, 0, 0, { align: 'center', bold: true, size });
  pen.restore();
}

/** A pill with words. @param {CanvasRenderingContext2D} pen @param {Palette} colours @param {{x: number, y: number, width: number,
 * height: number, text: string}} of its middle */
function pill(pen, colours, { x, y, width, height, text }) {
  pen.fillStyle = colours.accent;
  pen.beginPath();
  pen.roundRect(x - width / 2, y - height / 2, width, height, 7);
  pen.fill();
  drawText(pen, { ...colours, paper: colours.accent, ink: colours.paper }, text, x, y + 0.5, { align: 'center', bold: true });
}

/** Where the handles are, px: on a small plot above their line, so that they cover less.
 * @param {CanvasRenderingContext2D} pen @param {Palette} colours @param {Frame} frame @param {Lines} lines
 * @param {{budget: string, enough: string}} words */
export function handlesOf(pen, colours, frame, lines, words) {
  const height = colours.text * 2.3,
    wide = widthOf(pen, colours, words.budget, true) + colours.text * 1.6,
    long = widthOf(pen, colours, words.enough, true) + colours.text * 1.6;
  const x = frame.toX(lines.cost),
    y = frame.toY(lines.error);
  return {
    budget: {
      x: Math.max(frame.left + wide / 2 - 20, Math.min(frame.right - wide / 2 + 8, x)),
      y: frame.top - height / 2 - 3,
      width: wide,
      height,
      text: words.budget,
    },
    enough: {
      x: frame.right - long / 2 + 4,
      y: Math.max(frame.top + height / 2, Math.min(frame.bottom - height / 2, frame.right - frame.left < 460 ? y - height / 2 - 2 : y)),
      width: long,
      height,
      text: words.enough,
    },
    x,
    y,
  };
}

/**
 * @typedef {object} Wish
 * @property {Point[]} points  that count
 * @property {Point[]} former  shipped rows in whose place there are others
 * @property {string[]} named  methods with a name at the end of their line; the others are pale
 * @property {(method: string) => number} place  of a method, for its mark
 * @property {(method: string) => string} nameOf
 * @property {string} dark  the only method that is not pale; empty: none
 * @property {Lines} lines
 * @property {{budget: string, enough: string}} words
 * @property {string} x
 * @property {string} y
 * @property {Point} winner  or what comes nearest
 * @property {string} ring  what is said next to it
 * @property {Point | undefined} rival
 * @property {string} hidden  what is said next to the truest of all; empty: nothing
 * @property {number} selected  place of a row; -1: none
 */

/** @param {CanvasRenderingContext2D} pen @param {Palette} colours @param {Frame} frame @param {Wish} wish */
function field(pen, colours, frame, { lines }) {
  const x = frame.toX(lines.cost),
    y = frame.toY(lines.error);
  pen.globalAlpha = 0.12;
  pen.fillStyle = colours.accent;
  pen.fillRect(frame.left, y, x - frame.left, frame.bottom - y);
  pen.globalAlpha = 1;
}

/** A mark: solid of what was measured here or ships without a rival, hollow of what is the program's alone.
 * @param {CanvasRenderingContext2D} pen @param {Palette} colours @param {Spot} at @param {number} place @param {{size: number,
 * hollow: boolean}} how */
function markAt(pen, colours, at, place, { size, hollow }) {
  const form = formOf(place),
    paint = paintOf(colours, form.colour);
  outline(pen, form.shape, at.x, at.y, size);
  pen.setLineDash([]);
  pen.fillStyle = hollow ? colours.paper : paint.fill;
  pen.fill();
  pen.lineWidth = 1.8;
  pen.strokeStyle = paint.text;
  pen.stroke();
}

/** @param {{pen: CanvasRenderingContext2D, width: number, height: number}} surface @param {Palette} colours @param {Frame} frame
 * @param {Wish} wish @returns {{spots: (Spot & {index: number})[], labels: Label[], ring: Spot, rival: Spot | null,
 *   handles: ReturnType<typeof handlesOf>}} */
export function drawTradeoff(surface, colours, frame, wish) {
  const { pen } = surface,
    { points, named } = wish;
  grid(pen, colours, frame, { x: wish.x, y: wish.y, small: surface.width < SMALL_PX });
  field(pen, colours, frame, wish);
  const spotOf = (/** @type {Point} */ point) => ({ x: frame.toX(point.cost), y: frame.toY(point.error) });
  const pale = (/** @type {string} */ method) => (wish.dark === '' ? !named.includes(method) : method !== wish.dark);
  const mixed = points.some(({ here }) => here);
  const order = [...points].sort((a, b) => Number(pale(b.method)) - Number(pale(a.method)));
  const size = Math.max(9, colours.marker * 0.46);
  for (const point of wish.former) {
    pen.globalAlpha = pale(point.method) ? 0.2 : 0.6;
    markAt(pen, colours, spotOf(point), wish.place(point.method), { size: size * 0.9, hollow: true });
  }
  for (const list of linesOf(order)) {
    const method = list[0]?.method ?? '',
      paint = paintOf(colours, formOf(wish.place(method)).colour);
    pen.globalAlpha = pale(method) ? 0.28 : 1;
    pen.strokeStyle = paint.text;
    pen.lineWidth = pale(method) ? 1.2 : colours.line + 0.5;
    pen.setLineDash(paint.dash);
    way(pen, list.map(spotOf));
  }
  /* of another method at the same place: next to it, so that each is seen */
  /** @type {(Spot & {method: string})[]} */
  const placed = [];
  const spots = order.map((point) => {
    const exact = spotOf(point),
      same = placed.filter((one) => one.method !== point.method && Math.hypot(one.x - exact.x, one.y - exact.y) < 2),
      methods = new Set(same.map(({ method }) => method)).size,
      at = { x: Math.max(frame.left, exact.x - methods * size * 1.1), y: exact.y },
      light = pale(point.method),
      [, low, high] = point.errors;
    placed.push({ ...exact, method: point.method });
    pen.globalAlpha = light ? 0.3 : 1;
    if (low !== null && high !== null && low < high) {
      pen.setLineDash([]);
      pen.lineWidth = 1.5;
      pen.strokeStyle = colours.faint;
      way(pen, [
        { x: at.x, y: frame.toY(Math.max(0, low)) },
        { x: at.x, y: frame.toY(high) },
      ]);
    }
    markAt(pen, colours, at, wish.place(point.method), { size: light ? size * 0.75 : size, hollow: mixed && !point.here });
    return { ...at, index: point.index };
  });
  pen.globalAlpha = 1;

  const x = frame.toX(wish.lines.cost),
    y = frame.toY(wish.lines.error);
  pen.strokeStyle = colours.accent;
  pen.lineWidth = colours.line + 1;
  pen.setLineDash([]);
  way(pen, [
    { x, y: frame.top },
    { x, y: frame.bottom },
  ]);
  way(pen, [
    { x: frame.left, y },
    { x: frame.right, y },
  ]);
  const handles = handlesOf(pen, colours, frame, wish.lines, wish.words);
  const ring = spotOf(wish.winner),
    rival = wish.rival ? spotOf(wish.rival) : null;
  const words = besideRing(pen, colours, frame, ring, wish.ring);
  const labels = labelsOf(pen, colours, frame, wish, spotOf, [
    ...[handles.enough, handles.budget].map((one) => ({ ...one, high: Math.max(TOUCH_PX, one.height) })),
    { ...words, high: colours.text },
    /* a mark: names stand next to it */
    ...spots.map((at) => ({ ...at, width: -16, high: 10 })),
  ]);
  for (const { method, text, x: at, y: high } of labels) {
    pen.globalAlpha = pale(method) ? 0.45 : 1;
    drawText(pen, colours, text, at, high, { bold: true, colour: paintOf(colours, formOf(wish.place(method)).colour).text });
  }
  pen.globalAlpha = 1;
  if (rival) {
    pen.setLineDash([4, 3]);
    pen.lineWidth = 2;
    pen.strokeStyle = colours.ink;
    pen.beginPath();
    pen.arc(rival.x, rival.y, size * 0.9 + 3, 0, 2 * Math.PI);
    pen.stroke();
    pen.setLineDash([]);
  }
  pill(pen, colours, handles.budget);
  pill(pen, colours, handles.enough);
  drawRing(pen, colours, ring, words, wish.ring, size);
  if (wish.hidden !== '')
    beside(
      pen,
      colours,
      frame,
      points.map((point) => ({ point, ...spotOf(point) })),
      wish.hidden,
    );
  const chosen = spots.find(({ index }) => index === wish.selected);
  if (chosen) {
    pen.strokeStyle = colours.accent;
    pen.lineWidth = 3;
    pen.beginPath();
    pen.arc(chosen.x, chosen.y, size + 4, 0, 2 * Math.PI);
    pen.stroke();
  }
  return { spots, labels, ring, rival, handles };
}

const RING_PX = 6; /* more than a mark */

/** Where the words of the ring are, px, of their middle. @param {CanvasRenderingContext2D} pen @param {Palette} colours
 * @param {Frame} frame @param {Spot} at @param {string} text */
function besideRing(pen, colours, frame, at, text) {
  const width = widthOf(pen, colours, text, true),
    below = at.y + 62 < frame.bottom;
  return {
    x: Math.max(frame.left + 8 + width / 2, Math.min(frame.right - width / 2 - 4, at.x - 46)),
    y: below ? at.y + 52 : Math.max(frame.top + 10, at.y - 52),
    width,
    below,
  };
}

/** @param {CanvasRenderingContext2D} pen @param {Palette} colours @param {Spot} at @param {ReturnType<typeof besideRing>} words
 * @param {string} text @param {number} size of a mark */
function drawRing(pen, colours, at, words, text, size) {
  const radius = size + RING_PX;
  for (const [width, colour] of /** @type {[number, string][]} */ ([
    [7, colours.paper],
    [4, colours.markLine],
  ])) {
    pen.lineWidth = width;
    pen.strokeStyle = colour;
    pen.beginPath();
    pen.arc(at.x, at.y, radius, 0, 2 * Math.PI);
    pen.stroke();
  }
  pen.lineWidth = 2;
  pen.strokeStyle = colours.markLine;
  const far = Math.hypot(words.x - at.x, words.y - at.y);
  way(pen, [
    { x: at.x + ((words.x - at.x) / far) * (radius + 2), y: at.y + ((words.y - at.y) / far) * (radius + 2) },
    { x: words.x, y: words.y + (words.below ? -9 : 9) },
  ]);
  drawText(pen, colours, text, words.x, words.y, { align: 'center', bold: true, colour: colours.markText });
}

/** Next to the truest of all: what its cost hides. @param {CanvasRenderingContext2D} pen @param {Palette} colours @param {Frame} frame
 * @param {(Spot & {point: Point})[]} spots @param {string} text */
function beside(pen, colours, frame, spots, text) {
  const at = spots.reduce((best, one) => (one.point.error < best.point.error ? one : best));
  const right = at.x + 14 + widthOf(pen, colours, text, true) < frame.right,
    room = right ? frame.right - at.x : at.x - frame.left - 18;
  /* in two lines where one has no room */
  const words = text.split(' '),
    half = Math.ceil(words.length / 2),
    lines = widthOf(pen, colours, text, true) < room ? [text] : [words.slice(0, half).join(' '), words.slice(half).join(' ')];
  const low = Math.min(frame.bottom - 12, at.y + 6);
  lines.forEach((line, k) =>
    drawText(pen, colours, line, right ? at.x + 14 : at.x - 14, low - (lines.length - 1 - k) * colours.text * 1.3, {
      align: right ? 'left' : 'right',
      bold: true,
      colour: colours.snap,
    }),
  );
}

/** Names at the ends of the lines: at the dear end, where there is room; none covers another or a handle.
 * @param {CanvasRenderingContext2D} pen @param {Palette} colours @param {Frame} frame @param {Wish} wish
 * @param {(point: Point) => Spot} spotOf @param {{x: number, y: number, width: number, high: number}[]} taken @returns {Label[]} */
function labelsOf(pen, colours, frame, wish, spotOf, taken) {
  const used = taken.map(({ x, y, width, high }) => ({ left: x - width / 2, right: x + width / 2, y, high }));
  /** @type {Label[]} */
  const labels = [];
  for (const method of wish.named) {
    const own = wish.points.filter((point) => point.method === method).map(spotOf);
    if (own.length === 0) continue;
    const text = wish.nameOf(method),
      width = widthOf(pen, colours, text, true),
      last = own.reduce((far, one) => (one.x > far.x || (one.x === far.x && one.y > far.y) ? one : far)),
      start = own.reduce((near, one) => (one.x < near.x ? one : near));
    const free = (/** @type {Spot} */ { x, y }) =>
      x > frame.left &&
      x + width <= frame.limit &&
      y > frame.top + 6 &&
      y < frame.bottom - 6 &&
      used.every((one) => x > one.right + 14 || x + width < one.left - 14 || Math.abs(one.y - y) >= (one.high + LABEL_PX) / 2);
    /* at either side of the dear end, then of the cheap one, as near as there is room */
    const sides = [last, start].flatMap(({ x, y }) => [
      { x: x + 12, y },
      { x: x - 12 - width, y: y - LABEL_PX * 0.8 },
    ]);
    const { x, y } =
      Array.from({ length: 61 }, (_, k) => (k % 2 === 0 ? 1 : -1) * Math.ceil(k / 2) * (LABEL_PX / 3))
        .flatMap((down) => sides.map((side, k) => ({ x: side.x, y: side.y + down, far: Math.abs(down) + 60 * Math.floor(k / 2) })))
        .sort((one, other) => one.far - other.far)
        .find(free) ?? /** @type {Spot} */ (sides[0]);
    used.push({ left: x, right: x + width, y, high: LABEL_PX });
    labels.push({ method, text, x, y, width });
  }
  return labels;
}

/** The point that a pointer is at. @param {(Spot & {index: number})[]} spots @param {number} x @param {number} y
 * @returns {number} its place in the rows; -1: none */
export function nearestSpot(spots, x, y) {
  let best = -1,
    least = NEAR_PX ** 2;
  for (const spot of spots) {
    const distance = (spot.x - x) ** 2 + (spot.y - y) ** 2;
    if (distance < least) [best, least] = [spot.index, distance];
  }
  return best;
}
