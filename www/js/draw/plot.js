// A plot with linear or logarithmic axes, drawn as a whole: lines, points, guides.
import { localized } from '../base/format.js';
import { drawText } from './marks.js';
import { drawShown, place } from './shown.js';

/** name: in a file of the plot's numbers; guides have none
 * @typedef {{xs: number[], ys: number[], colour: string, name?: string, dash?: number[], width?: number, points?: boolean}} Line */
/**
 * @typedef {{lines: Line[], x: string, y: string, logX?: boolean, logY?: boolean, equal?: boolean, least?: number, empty: string}} Plot
 *  least: the smallest span of y */

/** @param {number[]} values @param {boolean} log @param {number} [least] */
function rangeOf(values, log, least = 1e-12) {
  let low = Infinity,
    high = -Infinity;
  for (const value of values) {
    if (!Number.isFinite(value) || (log && value <= 0)) continue;
    low = Math.min(low, log ? Math.log10(value) : value);
    high = Math.max(high, log ? Math.log10(value) : value);
  }
  if (low > high) return null;
  const room = Math.max((high - low) * 0.06, log ? 0.3 : Math.max(least, Math.abs(high) * 0.02));
  return { low: low - room, high: high + room };
}

/** @param {number} low @param {number} high @param {number} wanted @param {boolean} log @returns {number[]} */
function ticksOf(low, high, wanted, log) {
  const raw = (high - low) / Math.max(1, wanted),
    power = 10 ** Math.floor(Math.log10(raw));
  const lead = raw / power;
  const step = log ? Math.max(1, Math.ceil(raw)) : (lead <= 1 ? 1 : lead <= 2 ? 2 : lead <= 5 ? 5 : 10) * power;
  const ticks = [];
  for (let i = Math.ceil(low / step); i * step <= high; i++) ticks.push(i * step);
  return ticks;
}

/** What each canvas shows. @type {WeakMap<HTMLCanvasElement, Plot>} */
export const plots = new WeakMap();

const SUPER = '⁰¹²³⁴⁵⁶⁷⁸⁹';

/** @param {number} value @param {boolean} log @returns {string} */
function label(value, log) {
  if (!log) return localized(String(Number(value.toPrecision(5))));
  return `10${value < 0 ? '⁻' : ''}${[...String(Math.abs(Math.round(value)))].map((digit) => SUPER[Number(digit)]).join('')}`;
}

/** Where a line begins and ends: what a lesson compares. @param {HTMLCanvasElement} canvas @param {string} name @param {number[]} xs
 * @param {number[]} ys @param {(v: number) => number} toX @param {(v: number) => number} toY */
function tell(canvas, name, xs, ys, toX, toY) {
  const known = xs.flatMap((x, i) => (Number.isFinite(x) && Number.isFinite(ys[i]) ? [i] : []));
  for (const [end, i] of /** @type {[string, number | undefined][]} */ ([
    ['.start', known[0]],
    ['', known.at(-1)],
  ]))
    if (i !== undefined) place(canvas, name + end, toX(/** @type {number} */ (xs[i])), toY(/** @type {number} */ (ys[i])), ys[i]);
}

/** @param {{pen: CanvasRenderingContext2D, width: number, height: number}} surface @param {import('./palette.js').Palette} colours
 * @param {Plot} plot
 * @returns {{toX: (v: number) => number, toY: (v: number) => number} | null} where values are; null when there are none */
export function drawPlot(surface, colours, plot) {
  plots.set(surface.pen.canvas, plot);
  const { pen } = surface,
    text = colours.axis;
  const logX = plot.logX === true,
    logY = plot.logY === true;
  let xr = rangeOf(
      plot.lines.flatMap((line) => line.xs),
      logX,
    ),
    yr = rangeOf(
      plot.lines.flatMap((line) => line.ys),
      logY,
      plot.least,
    );
  if (!xr || !yr) {
    drawText(pen, colours, plot.empty, surface.width / 2, surface.height / 2, { align: 'center', colour: colours.faint });
    return null;
  }
  const left = text * 4.2,
    top = text * 0.9,
    right = surface.width - 10,
    bottom = surface.height - text * 2.7;
  if (plot.equal) {
    /* one metre is one metre on both axes */
    const scale = Math.max((xr.high - xr.low) / (right - left), (yr.high - yr.low) / (bottom - top));
    const grow = (/** @type {{low: number, high: number}} */ r, /** @type {number} */ px) => {
      const middle = (r.low + r.high) / 2;
      return { low: middle - (scale * px) / 2, high: middle + (scale * px) / 2 };
    };
    xr = grow(xr, right - left);
    yr = grow(yr, bottom - top);
  }
  const { low: x0, high: x1 } = xr,
    { low: y0, high: y1 } = yr;
  const toX = (/** @type {number} */ v) => left + (((logX ? Math.log10(v) : v) - x0) / (x1 - x0)) * (right - left);
  const toY = (/** @type {number} */ v) => bottom - (((logY ? Math.log10(v) : v) - y0) / (y1 - y0)) * (bottom - top);
  const rule = (/** @type {number} */ ax, /** @type {number} */ ay, /** @type {number} */ bx, /** @type {number} */ by) => {
    pen.setLineDash([]);
    pen.lineWidth = 1;
    pen.strokeStyle = colours.grid;
    pen.beginPath();
    pen.moveTo(ax, ay);
    pen.lineTo(bx, by);
    pen.stroke();
  };
  for (const tick of ticksOf(x0, x1, (right - left) / Math.max(70, text * 4), logX)) {
    const x = Math.round(left + ((tick - x0) / (x1 - x0)) * (right - left)) + 0.5;
    rule(x, top, x, bottom);
    drawText(pen, colours, label(tick, logX), x, bottom + text * 0.8, { size: text, align: 'center', colour: colours.faint });
  }
  for (const tick of ticksOf(y0, y1, (bottom - top) / Math.max(34, text * 2), logY)) {
    const y = Math.round(bottom - ((tick - y0) / (y1 - y0)) * (bottom - top)) + 0.5;
    rule(left, y, right, y);
    drawText(pen, colours, label(tick, logY), left - 5, y, { size: text, align: 'right', colour: colours.faint });
  }
  drawText(pen, colours, plot.x, right, surface.height - text * 0.7, { size: text, align: 'right', colour: colours.ink });
  drawText(pen, colours, plot.y, left + 4, top + text * 0.4, { size: text, colour: colours.ink, bold: true });
  pen.save();
  pen.beginPath();
  pen.rect(left, top, right - left, bottom - top);
  pen.clip();
  for (const line of plot.lines) {
    pen.strokeStyle = pen.fillStyle = line.colour;
    pen.lineWidth = line.width ?? colours.line;
    pen.setLineDash(line.dash ?? []);
    pen.beginPath();
    let open = false;
    line.xs.forEach((vx, i) => {
      const vy = line.ys[i] ?? NaN;
      if (!Number.isFinite(vx) || !Number.isFinite(vy) || (logX && vx <= 0) || (logY && vy <= 0)) {
        open = false;
        return;
      }
      if (open) pen.lineTo(toX(vx), toY(vy));
      else pen.moveTo(toX(vx), toY(vy));
      open = true;
    });
    pen.stroke();
    if (!line.points) continue;
    pen.setLineDash([]);
    line.xs.forEach((vx, i) => {
      const vy = line.ys[i] ?? NaN;
      if (!Number.isFinite(vx) || !Number.isFinite(vy) || (logX && vx <= 0) || (logY && vy <= 0)) return;
      pen.beginPath();
      pen.arc(toX(vx), toY(vy), colours.line + 1.5, 0, 2 * Math.PI);
      pen.fill();
    });
  }
  pen.restore();
  plot.lines.filter(({ name }) => name !== undefined).forEach(({ xs, ys }, i) => tell(pen.canvas, `curve_${i}`, xs, ys, toX, toY));
  drawShown(pen, colours);
  return { toX, toY };
}
