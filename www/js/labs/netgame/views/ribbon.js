// Under a player's view: one cell per input, filled until the server has acknowledged it.
import { INPUT } from '../core/frame.js';
import { cross, drawText } from '../../../draw/marks.js';
import { fixed } from '../../../base/format.js';
import { paintOf } from '../../../draw/palette.js';
import { t } from '../../../base/words.js';

/** @typedef {import('./scene.js').DrawContext} DrawContext */

const CELLS = 48;

/** Inputs per second over the last moments. @param {DrawContext} at @param {number} player @returns {number} */
function inputRate(at, player) {
  const now = at.frame.time_s;
  const sent = at.memory.of(INPUT, player).filter((event) => event.begin_s <= now && event.begin_s >= now - 1),
    oldest = sent[0],
    newest = sent.at(-1);
  return newest && oldest && newest.begin_s > oldest.begin_s ? (newest.number - oldest.number) / (newest.begin_s - oldest.begin_s) : 0;
}

/** @param {DrawContext} at @param {number} left @param {number} width @param {number} top @param {number} height */
export function drawRibbon(at, left, width, top, height) {
  const player = at.view - 1;
  const view = at.frame.views[at.view];
  if (!view) return;
  const { pen, colours } = at;
  const rate = inputRate(at, player);
  const rtt = (2 * view.lag_ms) / 1000;
  const steady = rate > 0 && Math.abs(view.unacked - rtt * rate) <= view.unacked / 2 + 3; /* not while packets are missing */
  const values = { n: view.unacked, rtt: fixed(rtt, 2), rate: fixed(rate, 0) };
  const long = t('netgame.unacked.long', values),
    middle = t('netgame.unacked.middle', values);
  pen.font = `${colours.text}px ${colours.font}`;
  const text = (steady ? [long, middle] : []).find((words) => pen.measureText(words).width < width * 0.6) ?? t('netgame.unacked', values);
  const room = width - pen.measureText(text).width - 20;
  const shown = Math.max(CELLS / 2, Math.min(CELLS, view.unacked + 8));
  const count = Math.max(8, Math.min(shown, Math.floor(room / 5)));
  const cell = Math.min(9, room / count);
  const refused = at.memory.refused[player];
  for (let i = 0; i < count; i++) {
    const seq = view.input_seq - count + 1 + i;
    if (seq < 0) continue;
    const x = left + i * cell;
    const waiting = seq > view.acked_seq;
    pen.lineWidth = 1;
    pen.setLineDash([]);
    pen.strokeStyle = colours.edge;
    pen.fillStyle = paintOf(colours, player).fill;
    if (waiting) pen.fillRect(x, top + 2, cell - 1.5, height - 4);
    else pen.strokeRect(x + 0.5, top + 4.5, Math.max(1, cell - 2.5), height - 9);
    if (refused?.has(seq)) {
      pen.strokeStyle = colours.snap;
      pen.lineWidth = 2;
      cross(pen, x + cell / 2, top + height / 2, Math.min(4, cell / 2));
    }
  }
  drawText(pen, colours, text, left + count * cell + 8, top + height / 2, { colour: colours.faint });
}
