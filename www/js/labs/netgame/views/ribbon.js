// Under a player's view: one cell per input, filled until the server has acknowledged it.
import { INPUT } from '../core/frame.js';
import { cross, drawText, widthOf } from '../../../draw/marks.js';
import { fixed } from '../../../base/format.js';
import { paintOf } from '../../../draw/palette.js';
import { t } from '../../../base/words.js';

/** @typedef {import('./scene.js').DrawContext} DrawContext */

const CELLS = 48;

/** Inputs per second over the last moments. @param {DrawContext} at @param {number} player @returns {number} */
function inputRate(at, player) {
  const now = at.frame.time_s,
    list = at.memory.of(INPUT, player);
  let from = list.length;
  while (from > 0 && /** @type {import('../core/memory.js').Met} */ (list[from - 1]).begin_s >= now - 1) from--;
  const oldest = list[from],
    newest = list.at(-1);
  return newest && oldest && newest.begin_s > oldest.begin_s ? (newest.number - oldest.number) / (newest.begin_s - oldest.begin_s) : 0;
}

/** The first text that has room, or the last. @param {string[]} keys from long to short @param {Record<string, unknown>} values
 * @param {(text: string) => boolean} fits @returns {string} */
function inRoom(keys, values, fits) {
  let text = '';
  for (const key of keys) {
    text = t(key, values);
    if (fits(text)) break;
  }
  return text;
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
  const forms = steady ? ['netgame.unacked.long', 'netgame.unacked.middle', 'netgame.unacked'] : ['netgame.unacked'];
  const text = inRoom(forms, values, (words) => widthOf(pen, colours, words) < width * 0.6);

  const room = width - widthOf(pen, colours, text) - 20;
  const shown = Math.max(CELLS / 2, Math.min(CELLS, view.unacked + 8));
  const count = Math.max(8, Math.min(shown, Math.floor(room / 5)));
  const cell = Math.min(9, room / count);
  const refused = at.memory.refused[player];
  pen.lineWidth = 1;
  pen.setLineDash([]);
  pen.strokeStyle = colours.edge;
  pen.fillStyle = paintOf(colours, player).fill;
  const first = view.input_seq - count + 1;
  for (let i = Math.max(0, -first); i < count; i++) {
    const x = left + i * cell;
    if (first + i > view.acked_seq) pen.fillRect(x, top + 2, cell - 1.5, height - 4);
    else pen.strokeRect(x + 0.5, top + 4.5, Math.max(1, cell - 2.5), height - 9);
  }
  pen.strokeStyle = colours.snap;
  pen.lineWidth = 2;
  for (const seq of refused ?? []) {
    const i = seq - first;
    if (i >= 0 && i < count) cross(pen, left + (i + 0.5) * cell, top + height / 2, Math.min(4, cell / 2));
  }
  drawText(pen, colours, text, left + count * cell + 8, top + height / 2, { colour: colours.faint });
}
