// Lockstep and rollback: which player waits for which, resimulated ticks, and desyncs.
import { DESYNC, FIELDS, ROLLBACK, STALL, STALLED } from '../core/frame.js';
import { fixed, letter } from '../../../base/format.js';
import { paintOf } from '../../../draw/palette.js';
import { drawText } from '../../../draw/marks.js';

/** @typedef {import('../core/inspector.js').InspectorContext} InspectorContext */
/** @typedef {import('../core/frame.js').Peer} Peer */

const SPAN_S = 4;

/** @param {number} bits @returns {string} */
const lettersOf = (bits) =>
  Array.from({ length: 16 }, (_, p) => p)
    .filter((p) => bits & (1 << p))
    .map(letter)
    .join(', ');

/** @param {Peer} peer @param {number} p @returns {string} */
function wordsOf(peer, p) {
  const waits = peer.waiting ? `waits for ${lettersOf(peer.waiting)}` : `tick ${peer.tick}, confirmed ${peer.confirmed}`;
  const parted =
    peer.desync_tick < 0
      ? ''
      : ` · desync at tick ${peer.desync_tick}: ${peer.desync_entity < 0 ? 'game' : letter(peer.desync_entity)} ` +
        `${FIELDS[peer.desync_field] ?? ''} by ${fixed(peer.desync_ulps, 0)} ulp, now ${fixed(peer.desync_m, 3)} m`;
  return `${letter(p)}: ${waits} · stalled ${fixed(peer.stalled_s, 1)} s · resimulated ${peer.rollback_ticks}${parted}`;
}

/** @type {import('../core/inspector.js').Inspector} */
export const waits = {
  id: 'waits',
  label: 'Waits and desyncs',
  players: false,
  fits: (frame, params) => frame.peers.length > 0 || String(params?.server?.sync).startsWith('lockstep'),
  draw(at) {
    const { pen, colours, width, height, frame, memory } = at;
    const rows = frame.views.length - 1,
      left = colours.text * 2.4,
      right = width - 8;
    const high = (height - colours.text * 1.4) / Math.max(1, rows);
    const x = (/** @type {number} */ t) => left + ((t - frame.time_s + SPAN_S) / SPAN_S) * (right - left);
    drawText(
      pen,
      colours,
      frame.peers.length > 0
        ? `last ${SPAN_S} s: filled: stalls · bars: resimulated ticks · cross: desync`
        : frame.views[0] && frame.views[0].flags & STALLED
          ? 'lockstep: the server waits for inputs'
          : 'lockstep: the server steps',
      left,
      colours.text * 0.7,
      { colour: colours.faint },
    );
    for (let p = 0; p < rows; p++) {
      const top = colours.text * 1.4 + p * high,
        paint = paintOf(colours, p);
      pen.setLineDash([]);
      pen.strokeStyle = colours.grid;
      pen.lineWidth = 1;
      pen.beginPath();
      pen.moveTo(left, top + high - 1);
      pen.lineTo(right, top + high - 1);
      pen.stroke();
      drawText(pen, colours, letter(p), 8, top + high / 2, { colour: paint.text, bold: true });
      const peer = frame.peers[p];
      for (const event of memory.events.values()) {
        if (event.player !== p || event.begin_s < frame.time_s - SPAN_S) continue;
        if (event.type === STALL) {
          const from = Math.max(frame.time_s - SPAN_S, event.end_s - event.value / 1000);
          pen.fillStyle = colours.buffer;
          pen.globalAlpha = 0.5;
          pen.fillRect(x(from), top + 2, Math.max(2, x(event.end_s) - x(from)), high - 5);
          pen.globalAlpha = 1;
          if (x(event.end_s) - x(from) > colours.text * 5)
            drawText(pen, colours, `waits for ${lettersOf(event.number)}`, x(from) + 3, top + high * 0.3);
        } else if (event.type === ROLLBACK) {
          pen.fillStyle = paint.text;
          const tall = Math.min(high - 6, 3 + event.value * 2);
          pen.fillRect(x(event.begin_s) - 1, top + high - 2 - tall, 2, tall);
        } else if (event.type === DESYNC) {
          drawText(pen, colours, '✕', x(event.begin_s), top + high / 2, { colour: colours.snap, bold: true, align: 'center' });
        }
      }
      if (!peer) continue;
      if (peer.waiting) {
        pen.fillStyle = colours.buffer;
        pen.fillRect(right - 6, top + 2, 6, high - 5);
      }
      drawText(pen, colours, wordsOf(peer, p), left + 4, top + high * 0.68, { colour: peer.desync_tick < 0 ? colours.ink : colours.snap });
    }
  },
  words({ frame }) {
    return (
      frame.peers.map(wordsOf).join('; ') ||
      (frame.views[0] && frame.views[0].flags & STALLED ? 'The server waits for inputs' : 'The server steps')
    );
  },
};
