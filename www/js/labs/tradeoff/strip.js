// How far off things are drawn from moment to moment, below a scene.
import { drawText, widthOf } from '../../draw/marks.js';
import { t } from '../../base/words.js';
import { brief } from './names.js';

/** @typedef {import('./live.js').Run} Run */
/** @typedef {import('../../draw/palette.js').Palette} Palette */
/** @typedef {{pen: CanvasRenderingContext2D, width: number, height: number}} Surface */

export const STRIP_PX = 24;
export const STRIP_S = 6; /* of the past, in a strip */

/** How far off the others were until now, and the mean that the sentence has: a moment is one thing, the mean of runs is another. Both
 * runs have one scale.
 * @param {Surface} surface its whole height @param {Palette} colours @param {Run} run @param {Run | null} peer */
export function drawStrip({ pen, width, height }, colours, run, peer) {
  const { gaps } = run.memory,
    top = height - STRIP_PX,
    now = gaps.at(-1)?.t ?? 0,
    mean = run.row.error[0] ?? 0,
    most = Math.max(1e-9, mean, peer?.row.error[0] ?? 0, run.memory.high, peer?.memory?.high ?? 0);
  const words = t('tradeoff.strip', { figure: `${brief(mean)} m`, n: run.row.seeds }),
    left = widthOf(pen, colours, words, true) + 14,
    toX = (/** @type {number} */ time) => width - ((now - time) / STRIP_S) * (width - left),
    toY = (/** @type {number} */ gap) => height - 1 - (gap / most) * (STRIP_PX - 5);
  pen.fillStyle = colours.paper;
  pen.fillRect(0, top, width, STRIP_PX);
  const seen = gaps.filter((/** @type {{t: number}} */ one) => toX(one.t) >= left);
  if (seen.length === 0) return;
  pen.beginPath();
  pen.moveTo(toX(seen[0].t), height);
  for (const { t: time, gap } of seen) pen.lineTo(toX(time), toY(gap));
  pen.lineTo(width, height);
  pen.fillStyle = colours.mark;
  pen.fill();
  pen.strokeStyle = colours.markLine;
  pen.lineWidth = 2;
  pen.setLineDash([]);
  pen.beginPath();
  pen.moveTo(left, toY(mean));
  pen.lineTo(width, toY(mean));
  pen.stroke();
  drawText(pen, colours, words, 8, top + STRIP_PX / 2, { bold: true, colour: colours.markText });
}
