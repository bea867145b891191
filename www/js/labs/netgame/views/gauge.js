// The interpolation buffer: snapshots by server time, a needle at the render time, the two snapshots around it.
import { STATE, UNDERRUN } from '../core/frame.js';
import { fixed } from '../../../base/format.js';
import { drawText, widthOf } from '../../../draw/marks.js';
import { t } from '../../../base/words.js';
import { paintOf } from '../../../draw/palette.js';

/** @typedef {import('./scene.js').DrawContext} DrawContext */

/** When the snapshots that have arrived were sent: all since a time, and the last before it. The five seconds that are remembered have
 * some hundreds. @param {import('../core/memory.js').Met[]} list in the order of time @param {number} now s @param {number} since s
 * @returns {number[]} */
function arrivedSince(list, now, since) {
  const times = [];
  for (let i = list.length - 1; i >= 0; i--) {
    const { begin_s: sent, end_s: arrives, fate } = /** @type {import('../core/memory.js').Met} */ (list[i]);
    if (fate !== 0 || arrives > now) continue;
    times.push(sent);
    if (sent < since) break;
  }
  return times.reverse();
}

/** @param {DrawContext} at @param {number} left @param {number} width @param {number} top @param {number} height */
export function drawGauge(at, left, width, top, height) {
  const view = at.frame.views[at.view];
  if (!view) return;
  const { pen, colours, frame } = at;
  const player = at.view - 1;
  const dry = (view.flags & UNDERRUN) !== 0;
  const words = dry ? t('netgame.underrun') : t('netgame.gauge', { ms: fixed(view.buffer_ms, 0) });
  const room = width - widthOf(pen, colours, t('netgame.gauge', { ms: '0000' })) - 12;
  if (room < 40) {
    drawText(pen, colours, words, left, top + height / 2, { colour: colours.faint });
    return;
  }
  const arrived = arrivedSince(at.memory.of(STATE, player), frame.time_s, 2 * view.render_time_s - frame.time_s - 0.2);
  const newest = arrived[arrived.length - 1] ?? view.render_time_s;
  const span = Math.max(0.2, (frame.time_s - view.render_time_s) * 1.4, (newest - view.render_time_s) * 2);
  const start = frame.time_s - span;
  const x = (/** @type {number} */ t) => left + Math.max(0, Math.min(1, (t - start) / span)) * room;
  const middle = top + height / 2;

  pen.setLineDash([]);
  pen.fillStyle = colours.buffer;
  pen.globalAlpha = 0.35;
  if (newest > view.render_time_s) pen.fillRect(x(view.render_time_s), top + 4, x(newest) - x(view.render_time_s), height - 8);
  pen.globalAlpha = 1;
  if (dry) {
    /* hatched: nothing to draw from */
    pen.strokeStyle = colours.snap;
    pen.lineWidth = 1;
    pen.beginPath();
    for (let hx = x(newest); hx < left + room; hx += 5) {
      pen.moveTo(hx, top + height - 4);
      pen.lineTo(hx + 4, top + 4);
    }
    pen.stroke();
  }
  pen.strokeStyle = colours.edge;
  pen.lineWidth = 1;
  pen.strokeRect(left + 0.5, top + 3.5, room, height - 7);
  const after = arrived.findIndex((t) => t > view.render_time_s);
  arrived.forEach((t, i) => {
    if (t < start) return;
    const bracket = i === after || i === after - 1;
    pen.fillStyle = bracket ? paintOf(colours, player).text : colours.edge;
    pen.fillRect(x(t) - (bracket ? 1.5 : 0.5), top + (bracket ? 2 : 5), bracket ? 3 : 1, height - (bracket ? 4 : 10));
  });
  pen.fillStyle = colours.ink; /* the needle */
  const nx = x(view.render_time_s);
  pen.beginPath();
  pen.moveTo(nx - 5, top);
  pen.lineTo(nx + 5, top);
  pen.lineTo(nx, middle);
  pen.closePath();
  pen.fill();
  drawText(pen, colours, words, left + room + 8, middle, { colour: dry ? colours.snap : colours.faint });
}
