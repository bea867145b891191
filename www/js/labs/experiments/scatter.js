// The scatter of the points: two columns, a series by a third, the front of cost and error, 95 % intervals.
import { drawPlot } from '../../draw/plot.js';
import { paintOf } from '../../draw/palette.js';
import { outline } from '../../draw/marks.js';
import { boundsOf, numberOf } from './columns.js';

/** @typedef {import('./shown.js').Cells} Cells */
/** @typedef {{x: string, y: string, by: string, logX: boolean, logY: boolean}} Choice  by: the column of the series; empty: one series */
/** @typedef {{index: number, x: number, y: number}} Spot  a drawn point, in CSS px */

export const SERIES_MAX = 8;
/** Of more points those that would lie under another of their series are left out. */
const CROWD = 2000,
  CELL_PX = 4;

/** The values of a column that make series, in their order. @param {Cells[]} rows @param {string} by @returns {string[]} */
export const seriesOf = (rows, by) => (by === '' ? [''] : [...new Set(rows.map((row) => String(row[by])))]);

/** Points of one series, from left to right. @param {Cells[]} rows @param {Choice} of */
function linesOf(rows, of) {
  const names = seriesOf(rows, of.by);
  return names.map((name, s) => ({
    series: s,
    places: rows
      .map((row, index) => ({ index, x: numberOf(row, of.x), y: numberOf(row, of.y), here: of.by === '' || String(row[of.by]) === name }))
      .filter((p) => p.here && Number.isFinite(p.x) && Number.isFinite(p.y))
      .sort((a, b) => a.x - b.x || a.index - b.index),
  }));
}

/** @param {{pen: CanvasRenderingContext2D, width: number, height: number}} surface @param {import('../../draw/palette.js').Palette} colours
 * @param {Cells[]} rows @param {Choice} of @param {Set<number>} front @param {number} selected
 * @param {{x: string, y: string, empty: string}} named what axes are called, and what stands where nothing is drawn
 * @returns {{spots: Spot[], covered: number}} covered: points that are not drawn, since they lie under others */
export function drawScatter(surface, colours, rows, of, front, selected, named) {
  const { pen } = surface,
    lines = linesOf(rows, of),
    size = Math.max(9, colours.marker * 0.48);
  const joined = of.by !== '' && lines.length <= SERIES_MAX && rows.length <= 400;
  const frontLine = rows
    .map((row, i) => ({ i, x: numberOf(row, of.x), y: numberOf(row, of.y) }))
    .filter((p) => front.has(p.i))
    .sort((a, b) => a.x - b.x || a.y - b.y);
  const plot = drawPlot(surface, colours, {
    lines: [
      ...lines.map(({ series, places }) => ({
        xs: places.map((p) => p.x),
        ys: places.map((p) => p.y),
        colour: joined ? paintOf(colours, series).text : 'transparent',
        dash: paintOf(colours, series).dash,
        width: 1.5,
      })),
      ...(frontLine.length > 1
        ? [{ xs: frontLine.map((p) => p.x), ys: frontLine.map((p) => p.y), colour: colours.ink, width: colours.line }]
        : []),
    ],
    x: named.x,
    y: named.y,
    logX: of.logX,
    logY: of.logY,
    empty: named.empty,
  });
  if (!plot) return { spots: [], covered: 0 };
  /** @type {Spot[]} */
  const spots = [];
  /** @type {Set<string>} */
  const taken = new Set();
  let covered = 0;
  const mark = (/** @type {number} */ index, /** @type {number} */ series, /** @type {number} */ vx, /** @type {number} */ vy) => {
    if ((of.logX && vx <= 0) || (of.logY && vy <= 0)) return;
    const x = plot.toX(vx),
      y = plot.toY(vy),
      row = /** @type {Cells} */ (rows[index]);
    const place = `${series} ${Math.round(x / CELL_PX)} ${Math.round(y / CELL_PX)}`;
    if (rows.length > CROWD && taken.has(place) && index !== selected && !front.has(index)) {
      covered++;
      return;
    }
    taken.add(place);
    const { low, high } = boundsOf(row, of.y);
    pen.setLineDash([]);
    if (low < high && (!of.logY || low > 0)) {
      pen.strokeStyle = colours.faint;
      pen.lineWidth = 1.5;
      pen.beginPath();
      pen.moveTo(x, plot.toY(low));
      pen.lineTo(x, plot.toY(high));
      pen.stroke();
    }
    outline(pen, series, x, y, front.has(index) ? size * 1.25 : size);
    pen.fillStyle = paintOf(colours, series).fill;
    pen.fill();
    pen.lineWidth = front.has(index) ? 3 : 1.5;
    pen.strokeStyle = front.has(index) ? colours.ink : colours.truth;
    pen.stroke();
    if (index === selected) {
      pen.beginPath();
      pen.arc(x, y, size * 1.15 + 3, 0, 2 * Math.PI);
      pen.strokeStyle = colours.accent;
      pen.lineWidth = 3;
      pen.stroke();
    }
    spots.push({ index, x, y });
  };
  for (const { series, places } of lines) for (const p of places) mark(p.index, series % SERIES_MAX, p.x, p.y);
  return { spots: spots.sort((a, b) => a.x - b.x || a.y - b.y), covered };
}

/** The point that a pointer is at.
 * @param {Spot[]} spots
 * @param {number} x
 * @param {number} y
 * @returns {number} its place, -1: none is near */
export function nearest(spots, x, y) {
  let best = -1,
    least = 18 ** 2; /* px */
  for (const spot of spots) {
    const distance = (spot.x - x) ** 2 + (spot.y - y) ** 2;
    if (distance < least) [best, least] = [spot.index, distance];
  }
  return best;
}
