// The motion itself: where the solution and each method have the body now.
import { drawMark, drawText } from '../../draw/marks.js';
import { gridStep } from '../../draw/axis.js';
import { paintOf } from '../../draw/palette.js';
import { fixed, letter, localized } from '../../base/format.js';
import { drawShown, place } from '../../draw/shown.js';
import { camera } from '../../session/state.js';
import { t } from '../../base/words.js';

/** @typedef {import('./record.js').Record} Record */
/** @typedef {import('./record.js').Motion} Motion */
/** @typedef {{pen: CanvasRenderingContext2D, width: number, height: number}} Surface */

const NARROW = 500; /* px */

/** Problems whose first two components are a place in the plane. */
const PLANES = new Set(['drag_2d', 'lorentz', 'kepler', 'henon_heiles', 'elastic_pendulum', 'stiff_pendulum', 'arenstorf']);

/** @param {string} problem */
export const isPlane = (problem) => PLANES.has(problem);

/** The range of all values so far, the current ones included. @param {number[][]} lists */
function extent(lists) {
  let low = Infinity,
    high = -Infinity;
  for (const list of lists) {
    for (const value of list) {
      if (!Number.isFinite(value)) continue;
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
  }
  return low <= high ? { low, high } : { low: -1, high: 1 };
}

/** Far away, a blow-up would shrink the rest to a point: the view is the solution with room around it.
 * @param {Record} record @param {'x' | 'y' | 'value'} name */
function around(record, name) {
  const all = extent(record.tracks.map((track) => track[name]));
  const own = extent([record.tracks[0]?.[name] ?? []]);
  const size = Math.max(own.high - own.low, 0.5);
  return { low: Math.max(all.low, own.low - size), high: Math.min(all.high, own.high + size) };
}

/** A grid line. @param {CanvasRenderingContext2D} pen @param {import('../../draw/palette.js').Palette} colours @param {number} x
 * @param {number} to */
function upright(pen, colours, x, to) {
  pen.setLineDash([]);
  pen.strokeStyle = colours.grid;
  pen.lineWidth = 1;
  pen.beginPath();
  pen.moveTo(x, 0);
  pen.lineTo(x, to);
  pen.stroke();
}

/** @param {Surface} surface @param {import('../../draw/palette.js').Palette} colours @param {Record} record @param {Motion[]} motion */
function plane(surface, colours, record, motion) {
  const { pen } = surface;
  const x = around(record, 'x'),
    y = around(record, 'y');
  const margin = colours.marker * 1.2;
  const scale = Math.min(
    (surface.width - 2 * margin) / Math.max(x.high - x.low, 1e-9),
    (surface.height - 2 * margin) / Math.max(y.high - y.low, 1e-9),
  );
  const toX = (/** @type {number} */ v) => surface.width / 2 + (v - (x.low + x.high) / 2) * scale;
  const toY = (/** @type {number} */ v) => surface.height / 2 - (v - (y.low + y.high) / 2) * scale;
  const step = gridStep(scale, Math.max(90, colours.axis * 6));
  for (let i = Math.ceil((x.low - margin / scale) / step); toX(i * step) < surface.width; i++) {
    upright(pen, colours, toX(i * step), surface.height);
    drawText(pen, colours, localized(`${Number((i * step).toPrecision(4))} m`), toX(i * step) + 3, surface.height - colours.text * 0.7, {
      colour: colours.faint,
    });
  }
  record.tracks.forEach((track, i) => {
    pen.strokeStyle = i === 0 ? colours.truth : paintOf(colours, i - 1).text;
    pen.setLineDash(i === 0 ? [5, 4] : paintOf(colours, i - 1).dash);
    pen.lineWidth = i === 0 ? 1.5 : colours.line;
    pen.beginPath();
    track.x.forEach((vx, k) => {
      if (!Number.isFinite(vx)) return; /* frames were skipped: no chord */
      if (Number.isFinite(track.x[k - 1])) pen.lineTo(toX(vx), toY(track.y[k] ?? 0));
      else pen.moveTo(toX(vx), toY(track.y[k] ?? 0));
    });
    pen.stroke();
  });
  pen.setLineDash([]);
  motion.forEach((one, i) => {
    if (i === 0 || one.status !== 0) return;
    drawMark(pen, colours, i - 1, toX(one.state[0] ?? 0), toY(one.state[1] ?? 0), colours.marker * 0.7);
  });
  const truth = motion[0];
  if (truth) ring(pen, colours, toX(truth.state[0] ?? 0), toY(truth.state[1] ?? 0));
}

/** Where the solution has it. @param {CanvasRenderingContext2D} pen @param {import('../../draw/palette.js').Palette} colours
 * @param {number} x @param {number} y */
function ring(pen, colours, x, y) {
  pen.setLineDash([4, 3]);
  pen.strokeStyle = colours.truth;
  pen.lineWidth = colours.line;
  pen.beginPath();
  pen.arc(x, y, colours.marker * 0.55, 0, 2 * Math.PI);
  pen.stroke();
  pen.setLineDash([]);
}

/** A lane per method along the first component: the mark, and the solution's ring on it.
 * @param {Surface} surface @param {import('../../draw/palette.js').Palette} colours @param {Record} record @param {Motion[]} motion
 * @param {string[]} names
 * @param {string} unit @param {Motion[] | null} first */
function strip(surface, colours, record, motion, names, unit, first) {
  const { pen } = surface;
  const truth = motion[0]?.state[0] ?? 0,
    lens = camera.value === null ? 0 : surface.width < NARROW ? camera.value.narrow_m : camera.value.m;
  const range = lens > 0 ? { low: truth - lens / 2, high: truth + lens / 2 } : around(record, 'value');
  const left = colours.text * 13,
    right = surface.width - colours.marker;
  const span = Math.max(range.high - range.low, 1e-9);
  const toX = (/** @type {number} */ v) => left + ((v - range.low) / span) * (right - left);
  const step = gridStep((right - left) / span, Math.max(90, colours.axis * 6));
  for (let i = Math.ceil(range.low / step); i * step <= range.high + 1e-12; i++) {
    upright(pen, colours, toX(i * step), surface.height - colours.text * 1.4);
    drawText(pen, colours, localized(`${Number((i * step).toPrecision(4))}${unit}`), toX(i * step), surface.height - colours.text * 0.7, {
      colour: colours.faint,
      align: 'center',
    });
  }
  const high = (surface.height - colours.text * 1.6) / Math.max(1, motion.length - 1);
  motion.forEach((one, i) => {
    if (i === 0) return;
    const y = high * (i - 0.5),
      value = one.state[0] ?? 0;
    drawText(pen, colours, names[i - 1] ?? '', 8, y, { colour: paintOf(colours, i - 1).text, bold: true });
    if (one.status === 2) {
      drawText(pen, colours, t('motion.off'), left, y, { colour: colours.faint });
      return;
    }
    ring(pen, colours, toX(truth), y);
    const x = toX(value);
    const before = first?.[i]?.state[0];
    if (before !== undefined) {
      pen.globalAlpha = 0.3;
      drawMark(pen, colours, i - 1, toX(before), y, Math.min(colours.marker, high * 0.7));
      pen.globalAlpha = 1;
      place(pen.canvas, `${letter(i - 1)}.first`, toX(before), y, before);
    }
    place(pen.canvas, `${letter(i - 1)}.truth`, toX(truth), y, truth);
    place(pen.canvas, letter(i - 1), x, y, value);
    if (one.status === 1 || one.status === 3) {
      drawText(pen, colours, t(one.status === 1 ? 'motion.diverged_at' : 'motion.failed_at', { s: fixed(one.t_s, 2) }), left, y, {
        colour: colours.snap,
        bold: true,
      });
    } else if (x < left - 4 || x > surface.width - 4) {
      /* outside of the canvas */
      drawText(pen, colours, `${fixed(value, 1)}${unit} ${x < left ? '◂' : '▸'}`, x < left ? left : right, y, {
        colour: paintOf(colours, i - 1).text,
        align: x < left ? 'left' : 'right',
        bold: true,
      });
    } else {
      drawMark(pen, colours, i - 1, x, y, Math.min(colours.marker, high * 0.7));
    }
  });
}

/** What a lesson is about is marked; in a strip `A` is the first method's body, `A.truth` the solution's.
 * @param {Surface} surface @param {import('../../draw/palette.js').Palette} colours @param {Record} record @param {Motion[]} motion
 * @param {{problem: string, names: string[], unit: string, first: Motion[] | null}} of  first: a lesson's first run */
export function drawScene(surface, colours, record, motion, of) {
  if (isPlane(of.problem)) plane(surface, colours, record, motion);
  else strip(surface, colours, record, motion, of.names, of.unit, of.first);
  drawShown(surface.pen, colours);
}
