// Error against one cost: a mark per setting with whiskers, a line per method, the front, the levels of error, a ring around what was
// chosen.
import { outline } from '../../draw/marks.js';
import { paintOf } from '../../draw/palette.js';
import { drawPlot } from '../../draw/plot.js';

/** @typedef {import('./jobs.js').Answer} Answer */
/** @typedef {import('./jobs.js').Measured} Measured */
/** index: its place in the rows; method: its number; line: of a method by one of its settings; chosen: the cheapest at a level
 * @typedef {{index: number, method: number, line: number, x: Measured, y: Measured, front: boolean, chosen: boolean}} Point */
/** A drawn point, in CSS px. @typedef {{index: number, x: number, y: number}} Spot */

const FORMS = 8; /* marks, and colours */
const CROWD = 8; /* of more methods those off the front are small and pale */
const NEAR_PX = 20;

/** Of a method by its number: with more methods than marks the same mark has another colour. @param {number} method */
export const formOf = (method) => ({ shape: method % FORMS, colour: (method + Math.floor(method / FORMS)) % FORMS });

/** Methods of a problem in the order of their rows. @param {Answer} answer @param {number} problem */
export const methodsOf = (answer, problem) => [
  ...new Set(answer.rows.filter((row) => row.problem === problem).map(({ method }) => method)),
];

/** Points of a problem and a cost; a single error of 0 would make an axis of many decades linear, and is left out.
 * @param {Answer} answer @param {number} problem @param {number} cost @returns {Point[]} */
export function pointsOf(answer, problem, cost) {
  const methods = methodsOf(answer, problem),
    chosen = new Set(answer.choices.filter((one) => one.problem === problem && one.cost === cost).map(({ row }) => row));
  /** @type {string[]} */
  const lines = [];
  return answer.rows.flatMap((row, index) => {
    const x = row.costs[cost] ?? [null, null, null],
      y = row.error;
    if (row.problem !== problem || x[0] === null || y[0] === null || (y[0] <= 0 && !row.random)) return [];
    const line = `${row.method} ${row.setting}`;
    if (!lines.includes(line)) lines.push(line);
    return [
      {
        index,
        method: methods.indexOf(row.method),
        line: lines.indexOf(line),
        x,
        y,
        front: row.front[cost] === true,
        chosen: chosen.has(index),
      },
    ];
  });
}

/** Logarithmic where no value is 0. @param {Measured[]} values */
const isLog = (values) => values.length > 0 && values.every(([value]) => (value ?? 0) > 0);

/** The ends of whiskers that an axis has room for. @param {Measured[]} values @param {boolean} log */
const endsOf = (values, log) =>
  values.flatMap(([value, low, high]) => [value, low, high].filter((one) => one !== null && (!log || one > 0)));

/** @param {CanvasRenderingContext2D} pen @param {number} ax @param {number} ay @param {number} bx @param {number} by */
function stroke(pen, ax, ay, bx, by) {
  pen.beginPath();
  pen.moveTo(ax, ay);
  pen.lineTo(bx, by);
  pen.stroke();
}

/** @param {{pen: CanvasRenderingContext2D, width: number, height: number}} surface @param {import('../../draw/palette.js').Palette} colours
 * @param {Point[]} points @param {{levels: number[], hidden: Set<number>, selected: number, x: string, y: string,
 * empty: string}} wish hidden: methods that are left out; selected: a place in the rows, -1 for none
 * @returns {Spot[]} from left to right */
export function drawTradeoff(surface, colours, points, { levels, hidden, selected, x: nameX, y: nameY, empty }) {
  const { pen } = surface,
    shown = points.filter(({ method }) => !hidden.has(method)),
    crowded = new Set(shown.map(({ method }) => method)).size > CROWD;
  const logX = isLog(points.map(({ x }) => x)),
    logY = isLog(points.map(({ y }) => y));
  const xs = /** @type {number[]} */ (
      endsOf(
        points.map(({ x }) => x),
        logX,
      )
    ),
    ys = /** @type {number[]} */ (
      endsOf(
        points.map(({ y }) => y),
        logY,
      )
    );
  const frontLine = shown.filter(({ front }) => front).sort((a, b) => (a.x[0] ?? 0) - (b.x[0] ?? 0));
  const ofLine = (/** @type {number} */ line) => shown.filter((point) => point.line === line).sort((a, b) => (a.x[0] ?? 0) - (b.x[0] ?? 0));
  const values = (/** @type {Point[]} */ list, /** @type {'x' | 'y'} */ axis) => list.map((point) => point[axis][0] ?? NaN);
  const plot = drawPlot(surface, colours, {
    lines: [
      { xs, ys: xs.map(() => ys[0] ?? NaN), colour: 'transparent' } /* room for the whiskers */,
      { xs: ys.map(() => xs[0] ?? NaN), ys, colour: 'transparent' },
      ...[...new Set(shown.map(({ line }) => line))].map(ofLine).map((list) => ({
        xs: values(list, 'x'),
        ys: values(list, 'y'),
        colour: crowded ? colours.grid : paintOf(colours, formOf(list[0]?.method ?? 0).colour).text,
        dash: paintOf(colours, formOf(list[0]?.method ?? 0).colour).dash,
        width: 1.5,
      })),
      { xs: values(frontLine, 'x'), ys: values(frontLine, 'y'), colour: colours.ink, width: colours.line },
    ],
    x: nameX,
    y: nameY,
    logX,
    logY,
    empty,
  });
  if (!plot) return [];
  const left = plot.toX(Math.min(...xs)),
    right = plot.toX(Math.max(...xs));
  pen.strokeStyle = colours.faint;
  pen.lineWidth = 1;
  pen.setLineDash([5, 4]);
  for (const level of levels) if (!logY || level > 0) stroke(pen, left - 8, plot.toY(level), right + 8, plot.toY(level));
  pen.setLineDash([]);
  /** @param {Point} point @returns {Spot} */
  const mark = (point) => {
    const x = plot.toX(point.x[0] ?? NaN),
      y = plot.toY(point.y[0] ?? NaN),
      pale = crowded && !point.front && !point.chosen && point.index !== selected;
    const form = formOf(point.method),
      size = Math.max(9, colours.marker * 0.48) * (point.front ? 1.25 : pale ? 0.7 : 1);
    pen.globalAlpha = pale ? 0.45 : 1;
    pen.strokeStyle = colours.faint;
    pen.lineWidth = 1.5;
    const [, lowX, highX] = point.x,
      [, lowY, highY] = point.y;
    if (lowY !== null && highY !== null && lowY < highY)
      stroke(pen, x, plot.toY(logY && lowY <= 0 ? Math.min(...ys) : lowY), x, plot.toY(highY));
    if (lowX !== null && highX !== null && lowX < highX)
      stroke(pen, plot.toX(logX && lowX <= 0 ? Math.min(...xs) : lowX), y, plot.toX(highX), y);
    outline(pen, form.shape, x, y, size);
    pen.fillStyle = paintOf(colours, form.colour).fill;
    pen.fill();
    pen.lineWidth = point.front ? 3 : 1.5;
    pen.strokeStyle = point.front ? colours.ink : colours.truth;
    pen.stroke();
    pen.globalAlpha = 1;
    for (const [wanted, radius, colour] of /** @type {[boolean, number, string][]} */ ([
      [point.chosen, size * 0.75 + 3, colours.ink],
      [point.index === selected, size * 0.75 + 7, colours.accent],
    ])) {
      if (!wanted) continue;
      pen.beginPath();
      pen.arc(x, y, radius, 0, 2 * Math.PI);
      pen.strokeStyle = colour;
      pen.lineWidth = colour === colours.accent ? 3 : 1.5;
      pen.stroke();
    }
    return { index: point.index, x, y };
  };
  const byRank = [...shown].sort((a, b) => Number(a.front) - Number(b.front));
  return byRank.map(mark).sort((a, b) => a.x - b.x || a.y - b.y);
}

/** The point that a pointer is at. @param {Spot[]} spots @param {number} x @param {number} y
 * @returns {number} its place in the rows; -1: none */
export function nearest(spots, x, y) {
  let best = -1,
    least = NEAR_PX ** 2;
  for (const spot of spots) {
    const distance = (spot.x - x) ** 2 + (spot.y - y) ** 2;
    if (distance < least) [best, least] = [spot.index, distance];
  }
  return best;
}
