// Lockstep and rollback: which player waits for which, resimulated ticks, and desyncs.
import { DESYNC, FIELDS, ROLLBACK, STALL, STALLED } from '../core/frame.js';
import { fixed, letter } from '../../../base/format.js';
import { t } from '../../../base/words.js';
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
  const says = [
    peer.waiting
      ? t('netgame_more.waits.for', { names: lettersOf(peer.waiting) })
      : t('netgame_more.waits.tick', { tick: String(peer.tick), confirmed: String(peer.confirmed) }),
    t('netgame_more.waits.stalled', { s: fixed(peer.stalled_s, 1) }),
    t('netgame_more.waits.resimulated', { n: peer.rollback_ticks }),
  ];
  if (peer.desync_tick >= 0)
    says.push(
      t('netgame_more.waits.desync', {
        tick: String(peer.desync_tick),
        where: peer.desync_entity < 0 ? t('netgame_more.waits.game') : letter(peer.desync_entity),
        field: t(`netgame_more.field.${FIELDS[peer.desync_field] ?? ''}`),
        ulps: fixed(peer.desync_ulps, 0),
        m: fixed(peer.desync_m, 3),
      }),
    );
  return `${letter(p)}: ${says.join(' · ')}`;
}

/** What the server does. @param {import('../core/frame.js').Frame} frame */
const serverOf = (frame) =>
  t(frame.views[0] && frame.views[0].flags & STALLED ? 'netgame_more.waits.server_waits' : 'netgame_more.waits.server_steps');

/** @type {import('../core/inspector.js').Inspector} */
export const waits = {
  id: 'waits',
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
      frame.peers.length > 0 ? t('netgame_more.waits.legend', { s: SPAN_S }) : t('netgame_more.waits.lockstep', { says: serverOf(frame) }),
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
            drawText(pen, colours, t('netgame_more.waits.for', { names: lettersOf(event.number) }), x(from) + 3, top + high * 0.3);
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
    return frame.peers.map(wordsOf).join('; ') || serverOf(frame);
  },
};
