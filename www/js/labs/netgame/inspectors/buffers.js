// A player's buffers: the snapshots around the render time, with the times of arrival and play-out.
import { V_CATCHING_UP, V_EXTRAPOLATING, V_NEWEST, V_NORMAL, V_SLOWING, V_STARVED } from '../core/frame.js';
import { fixed, signed } from '../../../base/format.js';
import { t } from '../../../base/words.js';
import { BUFFERED_PLACE } from '../../../stream/names.js';
import { paintOf } from '../../../draw/palette.js';
import { cross, drawText } from '../../../draw/marks.js';

/** @typedef {import('../core/inspector.js').InspectorContext} InspectorContext */

/** Ends of the keys of their words. @type {Record<number, string>} */
const STATES = {
  [V_NEWEST]: 'newest',
  [V_NORMAL]: 'normal',
  [V_CATCHING_UP]: 'catching_up',
  [V_SLOWING]: 'slowing',
  [V_STARVED]: 'starved',
  [V_EXTRAPOLATING]: 'extrapolating',
};

/** A snapshot in a buffer; ms. `time`: its server time less the render time; the others count from the frame's time.
 * @typedef {{place: number, time: number, arrived: number, due: number}} Item */

/** @param {InspectorContext} at */
function of({ frame, player }) {
  const buffer = frame.buffers.find((one) => one.player === player),
    drawn = buffer?.drawn_s ?? 0;
  /** @type {Item[]} */
  const items = frame.where('buffered', 'player', player).map((one) => ({
    place: one.place,
    time: 1000 * (one.time_s - drawn),
    arrived: 1000 * (one.arrived_s - frame.time_s),
    due: 1000 * (one.due_s - frame.time_s),
  }));
  return { buffer, items };
}

/** The gauge: snapshots by server time, the needle at the render time, the two around it, and α between them.
 * @param {InspectorContext} at @param {Item[]} list @param {number} state @param {number} top @param {number} height */
function gauge(at, list, state, top, height) {
  const { pen, colours, width, player } = at;
  const reach = Math.max(120, ...list.map((one) => Math.abs(one.time))) * 1.15;
  const left = colours.text * 9,
    right = width - 12,
    x = (/** @type {number} */ ms) => left + ((ms + reach) / (2 * reach)) * (right - left);
  const middle = top + height / 2;
  drawText(pen, colours, t('netgame_more.buffers.server_time'), 8, middle - colours.text * 0.7, { colour: colours.faint });
  drawText(pen, colours, `±${fixed(reach, 0)} ms`, 8, middle + colours.text * 0.7, { colour: colours.faint });
  pen.setLineDash([]);
  pen.lineWidth = 1;
  pen.strokeStyle = colours.edge;
  pen.beginPath();
  pen.moveTo(left, middle);
  pen.lineTo(right, middle);
  pen.stroke();
  const before = list.filter((one) => one.time <= 0).sort((a, b) => b.time - a.time)[0];
  const after = list.filter((one) => one.time > 0).sort((a, b) => a.time - b.time)[0];
  if (before && after) {
    pen.fillStyle = colours.buffer;
    pen.globalAlpha = 0.35;
    pen.fillRect(x(before.time), middle - height * 0.28, x(after.time) - x(before.time), height * 0.56);
    pen.globalAlpha = 1;
    const alpha = -before.time / (after.time - before.time);
    drawText(pen, colours, `${fixed(100 * alpha, 0)} %`, x(after.time) + 4, top + colours.text * 0.7);
  } else if (state === V_STARVED || state === V_EXTRAPOLATING) {
    /* hatched: nothing to draw from */
    pen.strokeStyle = colours.snap;
    for (let hx = x(0); hx < right; hx += 6) {
      pen.beginPath();
      pen.moveTo(hx, middle + height * 0.25);
      pen.lineTo(hx + 4, middle - height * 0.25);
      pen.stroke();
    }
  }
  for (const one of list) {
    const bracket = one === before || one === after;
    pen.fillStyle = bracket ? paintOf(colours, player).text : colours.edge;
    pen.fillRect(
      x(one.time) - (bracket ? 2 : 1),
      middle - height * (bracket ? 0.32 : 0.2),
      bracket ? 4 : 2,
      height * (bracket ? 0.64 : 0.4),
    );
  }
  pen.strokeStyle = colours.ink;
  pen.lineWidth = colours.line;
  pen.beginPath();
  pen.moveTo(x(0), middle - height * 0.42);
  pen.lineTo(x(0), middle + height * 0.42);
  pen.stroke();
  drawText(pen, colours, t('netgame_more.buffers.drawn'), x(0), top + height - colours.text * 0.6, { align: 'center', bold: true });
}

/** Two rows of dots, joined: the arrival of each snapshot, and its play-out.
 * @param {InspectorContext} at @param {Item[]} list @param {number} top @param {number} height */
function dejitter(at, list, top, height) {
  const { pen, colours, width, player } = at;
  const times = list.flatMap((one) => [one.arrived, one.due]);
  const low = Math.min(-100, ...times),
    high = Math.max(100, ...times);
  const left = colours.text * 9,
    right = width - 12,
    x = (/** @type {number} */ ms) => left + ((ms - low) / (high - low)) * (right - left);
  const up = top + height * 0.3,
    down = top + height * 0.78;
  drawText(pen, colours, t('netgame_more.buffers.arrived'), 8, up, { colour: colours.faint });
  drawText(pen, colours, t('netgame_more.buffers.played_out'), 8, down, { colour: colours.faint });
  pen.lineWidth = 1;
  pen.setLineDash([]);
  pen.strokeStyle = colours.edge;
  pen.beginPath();
  pen.moveTo(x(0), top);
  pen.lineTo(x(0), top + height);
  pen.stroke();
  for (const one of list) {
    const late = one.due < one.arrived;
    pen.strokeStyle = pen.fillStyle = late ? colours.snap : paintOf(colours, player).text;
    pen.beginPath();
    pen.moveTo(x(one.arrived), up);
    pen.lineTo(x(one.due), down);
    pen.stroke();
    for (const [ms, y] of [
      [one.arrived, up],
      [one.due, down],
    ]) {
      pen.beginPath();
      pen.arc(x(ms), y, colours.line + 1, 0, 2 * Math.PI);
      pen.fill();
    }
    if (late) cross(pen, x(one.due), down, 5);
  }
}

/** @type {import('../core/inspector.js').Inspector} */
export const buffers = {
  id: 'buffers',
  players: true,
  fits: (frame) => frame.buffers.length > 0,
  draw(at) {
    const { buffer, items } = of(at);
    if (!buffer) return;
    const played = items.filter((one) => one.place === BUFFERED_PLACE.dejitter),
      head = at.colours.text * 1.4;
    const rest = at.height - head,
      half = played.length > 0 ? rest / 2 : rest;
    drawText(at.pen, at.colours, buffers.words(at), 8, head / 2);
    gauge(
      at,
      items.filter((one) => one.place === BUFFERED_PLACE.snapshot),
      buffer.state,
      head,
      half,
    );
    if (played.length > 0) dejitter(at, played, head + half, half);
  },
  words(at) {
    const { buffer } = of(at);
    if (!buffer) return t('netgame_more.buffers.none');
    return [
      t(`netgame_more.buffers.${STATES[buffer.state] ?? 'normal'}`),
      t('netgame_more.buffers.says', { delay: fixed(buffer.delay_ms, 0), scale: fixed(buffer.time_scale, 2), n: buffer.underruns }),
      buffer.dejitter_ms > 0 ? t('netgame_more.buffers.dejitter', { ms: fixed(buffer.dejitter_ms, 0), n: buffer.late }) : '',
      t('netgame_more.buffers.behind', { ms: signed(-buffer.behind_ms, 0) }),
    ]
      .filter((part) => part !== '')
      .join(' · ');
  },
};
