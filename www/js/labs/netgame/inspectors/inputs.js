// The input history: the last inputs on the client's line and on the server's, with the result of each.
import { CORRECTION, INPUT, INPUT_RESULT } from '../core/frame.js';
import { fixed } from '../../../base/format.js';
import { t } from '../../../base/words.js';
import { paintOf } from '../../../draw/palette.js';
import { cross, drawText } from '../../../draw/marks.js';
import { drawShown, place } from '../../../draw/shown.js';

/** @typedef {import('../core/inspector.js').InspectorContext} InspectorContext */
/** @typedef {'open' | 'acknowledged' | 'refused' | 'late' | 'lost'} Fate */
/** @typedef {{seq: number, fate: Fate, arrived: boolean}} HistoryRow */

const MOST = 24;
const OUTCOMES = /** @type {Record<number, Fate>} */ ({ 1: 'refused', 3: 'late' });

/** @param {InspectorContext} at @returns {HistoryRow[]} oldest first */
function historyOf({ frame, memory, player }) {
  const view = frame.views[1 + player];
  if (!view || view.input_seq === 0) return [];
  const first = Math.max(1, view.input_seq - MOST + 1);
  /** @type {HistoryRow[]} */
  const rows = [];
  for (let seq = first; seq <= view.input_seq; seq++)
    rows.push({ seq, fate: seq <= view.acked_seq ? 'acknowledged' : 'open', arrived: seq <= view.acked_seq });
  for (const event of memory.events.values()) {
    const row = event.player === player ? rows[event.number - first] : undefined;
    if (!row) continue;
    if (event.type === INPUT_RESULT) {
      row.arrived = true;
      row.fate = OUTCOMES[event.outcome] ?? row.fate;
    } else if (event.type === INPUT && event.fate !== 0 && !row.arrived) {
      row.fate = 'lost';
    }
  }
  return rows;
}

/** The last correction of the player, if it is less than 1 s old. @param {InspectorContext} at */
function correctionOf({ frame, memory, player }) {
  let last = null;
  for (const event of memory.events.values())
    if (event.type === CORRECTION && event.player === player && frame.time_s - event.begin_s < 1) last = event;
  return last;
}

/** @type {import('../core/inspector.js').Inspector} */
export const inputs = {
  id: 'inputs',
  players: true,
  fits: (frame) => frame.views.length > 1 && frame.peers.length === 0,
  draw(at) {
    const { pen, colours, width, height, player, frame } = at;
    const rows = historyOf(at),
      paint = paintOf(colours, player);
    const left = colours.text * 5.5,
      step = (width - left - 12) / MOST,
      box = Math.min(step * 0.72, colours.text * 1.9);
    const up = colours.text * 2.6,
      down = height - colours.text * 2.2;
    drawText(pen, colours, inputs.words(at), 8, colours.text * 0.8);
    drawText(pen, colours, t('netgame_more.inputs.client'), 8, up, { colour: colours.faint });
    drawText(pen, colours, t('netgame_more.inputs.server'), 8, down, { colour: colours.faint });
    pen.setLineDash([]);
    pen.lineWidth = 1;
    pen.strokeStyle = colours.edge;
    for (const y of [up, down]) {
      pen.beginPath();
      pen.moveTo(left, y);
      pen.lineTo(width - 8, y);
      pen.stroke();
    }
    rows.forEach((row, i) => {
      const x = left + step * (MOST - rows.length + i + 0.5);
      const bad = row.fate === 'refused' || row.fate === 'late' || row.fate === 'lost';
      pen.strokeStyle = bad ? colours.snap : paint.text;
      pen.lineWidth = colours.line;
      if (row.arrived || row.fate === 'lost') {
        pen.setLineDash(row.arrived ? [] : [3, 3]);
        pen.globalAlpha = row.fate === 'acknowledged' ? 0.35 : 1;
        pen.beginPath();
        pen.moveTo(x, up + box / 2);
        pen.lineTo(x, row.arrived ? down - box / 2 : (up + down) / 2);
        pen.stroke();
        pen.globalAlpha = 1;
        pen.setLineDash([]);
      }
      if (row.fate === 'lost') cross(pen, x, (up + down) / 2, 5);
      for (const y of row.arrived ? [up, down] : [up]) {
        pen.fillStyle = row.fate === 'open' && y === up ? paint.fill : colours.paper;
        pen.fillRect(x - box / 2, y - box / 2, box, box);
        pen.strokeRect(x - box / 2, y - box / 2, box, box);
      }
      if (row.fate === 'refused' || row.fate === 'late') cross(pen, x, down, box / 2);
      if (i % 4 === rows.length % 4)
        drawText(pen, colours, String(row.seq), x, height - colours.text * 0.6, { align: 'center', colour: colours.faint });
    });
    const newest = rows.at(-1)?.seq ?? 0,
      edge = (/** @type {number} */ seq) => left + step * (MOST - newest + seq);
    place(pen.canvas, 'answered', edge(frame.views[1 + player]?.acked_seq ?? 0), up, frame.views[1 + player]?.acked_seq ?? 0);
    place(pen.canvas, 'newest', edge(newest), up, newest);
    drawShown(pen, colours);
    const correction = correctionOf(at);
    if (correction) {
      const again = frame.views[1 + player]?.unacked ?? 0;
      drawText(
        pen,
        colours,
        t('netgame_more.inputs.corrected', { size: fixed(Math.abs(correction.value), 3), n: again }),
        width - 10,
        (up + down) / 2,
        { align: 'right', bold: true, colour: colours.snap },
      );
    }
  },
  words(at) {
    const view = at.frame.views[1 + at.player],
      rows = historyOf(at);
    if (!view) return t('netgame_more.inputs.none');
    const count = (/** @type {Fate} */ fate) => rows.filter((row) => row.fate === fate).length;
    return t('netgame_more.inputs.says', {
      input: String(view.input_seq),
      acked: String(view.acked_seq),
      open: view.unacked,
      rows: rows.length,
      late: count('late'),
      refused: count('refused'),
      lost: count('lost'),
      corrections: view.corrections,
    });
  },
};
