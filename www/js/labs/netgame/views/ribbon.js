// Under a player's view: one cell per input, filled until the server has acknowledged it.
import { INPUT } from '../core/frame.js';
import { cross, drawText, widthOf } from '../../../draw/marks.js';
import { stamp } from '../../../draw/sprites.js';
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

/** Equal cells side by side, as one image: most frames have as many as the one before.
 * @param {CanvasRenderingContext2D} to @param {string} key
 * @param {{left: number, middle: number, n: number, cell: number, height: number}} at
 * @param {(pen: CanvasRenderingContext2D, x: number) => void} draw one of them, from x on, around the level 0 */
function cells(to, key, { left, middle, n, cell, height }, draw) {
  if (n <= 0) return;
  const centre = Math.round(left + (n * cell) / 2),
    start = left - centre;
  stamp(to, `${key} ${n} ${cell} ${height} ${start}`, centre, middle, (n * cell) / 2 + 1, height / 2, (pen) => {
    for (let i = 0; i < n; i++) draw(pen, start + i * cell);
  });
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
  const cell = Math.min(9, Math.floor((4 * room) / count) / 4); /* few widths: each has its image */
  const refused = at.memory.refused[player];
  const first = view.input_seq - count + 1,
    from = Math.max(0, -first),
    open = Math.max(from, Math.min(count, view.acked_seq + 1 - first)); /* the first cell that is not acknowledged */
  const middle = top + height / 2;
  cells(pen, 'acked', { left: left + from * cell, middle, n: open - from, cell, height }, (on, x) => {
    on.lineWidth = 1;
    on.setLineDash([]);
    on.strokeStyle = colours.edge;
    on.strokeRect(x + 0.5, 4.5 - height / 2, Math.max(1, cell - 2.5), height - 9);
  });
  cells(pen, `open ${player}`, { left: left + open * cell, middle, n: count - open, cell, height }, (on, x) => {
    on.fillStyle = paintOf(colours, player).fill;
    on.fillRect(x, 2 - height / 2, cell - 1.5, height - 4);
  });
  pen.setLineDash([]);
  pen.strokeStyle = colours.snap;
  pen.lineWidth = 2;
  for (const seq of refused ?? []) {
    const i = seq - first;
    if (i >= 0 && i < count) cross(pen, left + (i + 0.5) * cell, top + height / 2, Math.min(4, cell / 2));
  }
  drawText(pen, colours, text, left + count * cell + 8, top + height / 2, { colour: colours.faint });
}
