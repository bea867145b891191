// Both loops of a client and of the server, with the buffer between the two, and one input on its way through them.
import { DISPLAY, INPUT, INPUT_RESULT, STATE, STEP } from '../core/frame.js';
import { fixed } from '../../../base/format.js';
import { cross, drawMark, drawText } from '../../../draw/marks.js';
import { paintOf } from '../../../draw/palette.js';
import { drawShown, place } from '../../../draw/shown.js';

/** @typedef {import('./way.js').Way} Way */
/** @typedef {import('./way.js').Station} Station */
/** @typedef {[number, number]} Point */

/**
 * @typedef {object} Loops
 * @property {CanvasRenderingContext2D} pen
 * @property {number} width
 * @property {number} height
 * @property {import('../../../draw/palette.js').Palette} colours
 * @property {import('../core/memory.js').Memory} memory
 * @property {Way} way
 * @property {number} now       s
 * @property {number} expected  s, that the whole way takes about
 * @property {string} name      of the player
 * @property {string} serverName
 * @property {(ms: number) => string} ms  as text
 * @property {string} shared     what the shared buffer is called
 * @property {[string, string, string, string]} rows  game loop, buffer, network loop, link
 */

const LOST_AT = 0.6; /* of its way */
const NARROW = 520; /* px */

/** @param {Loops} at */
export function placesOf(at) {
  const { width, height, colours, way, now, expected } = at;
  const left = width < NARROW ? 66 : Math.round(colours.text * 8.2),
    right = width - 14;
  const head = colours.text * 1.7,
    foot = height - colours.text * 1.9,
    unit = (foot - head) / 11;
  const begin = /** @type {Station} */ (way.stations[0]).t;
  const end = Math.max(begin + expected, /** @type {Station} */ (way.stations.at(-1)).t, way.arrives, way.fate === 'open' ? now : 0);
  const span = Math.max(0.05, (end - begin) * 1.07);
  return {
    left,
    right,
    begin,
    end: begin + span,
    x: (/** @type {number} */ t) => left + ((t - begin + span * 0.03) / (span * 1.03)) * (right - left),
    y: {
      game: head + unit * 0.5,
      buffer: head + unit * 2,
      net: head + unit * 3.5,
      serverNet: head + unit * 7.5,
      serverBuffer: head + unit * 9,
      serverGame: head + unit * 10.5,
    },
    unit,
  };
}

/** @typedef {ReturnType<typeof placesOf>} Places */

/** The corners of the way up to the last station, each with its time. @param {Places} places @param {Way} way
 * @returns {{t: number, y: number}[]} */
function corners({ y }, way) {
  const levels = /** @type {Record<import('./way.js').StationId, number[]>} */ ({
    touched: [y.game],
    made: [y.game],
    sent: [y.game, y.net],
    arrived: [y.serverNet, y.serverBuffer],
    taken: [y.serverBuffer, y.serverGame],
    left: [y.serverGame, y.serverNet],
    came: [y.net, y.buffer],
    released: [y.buffer],
    shown: [y.buffer, y.game],
  });
  return way.stations.flatMap(({ id, t }) => levels[id].map((level) => ({ t, y: level })));
}

/** Where it goes on from the last station: over a link to its end, else it waits where it is. @param {Places} places @param {Way} way */
function goal({ y }, way) {
  const last = way.stations.at(-1)?.id;
  if (last === 'sent') return y.serverNet;
  if (last === 'left') return y.net;
  return null;
}

/** Where it is now. @param {Loops} at @param {Places} places @returns {{x: number, y: number, lost: boolean}} */
export function markOf(at, places) {
  const { way, now } = at;
  const list = corners(places, way);
  const last = /** @type {{t: number, y: number}} */ (list.at(-1));
  const to = goal(places, way);
  if (way.fate !== 'open' && !way.dropped) return { x: places.x(last.t), y: last.y, lost: false };
  if (way.dropped) {
    const way_s = at.expected / 3,
      part = Math.min(LOST_AT, Math.max(0, now - last.t) / way_s);
    return { x: places.x(last.t + part * way_s), y: last.y + part * (places.y.serverNet - last.y), lost: part >= LOST_AT };
  }
  if (to === null) return { x: places.x(Math.max(last.t, now)), y: last.y, lost: false };
  const part = way.arrives > last.t ? Math.min(1, Math.max(0, (now - last.t) / (way.arrives - last.t))) : 1;
  return { x: places.x(last.t + part * (way.arrives - last.t)), y: last.y + part * (to - last.y), lost: false };
}

/** @param {Loops} at @param {Point[]} points */
function line({ pen }, points) {
  pen.beginPath();
  for (const [x, y] of points) pen.lineTo(x, y);
  pen.stroke();
}

/** The rows with their names, and the ticks of the loops as far as they have happened. @param {Loops} at @param {Places} places */
function drawRows(at, places) {
  const { pen, colours, width, way, now, memory } = at;
  const { y, x, left, right, unit, begin, end } = places;
  const player = paintOf(colours, way.player).text;
  const [game, buffer, net, link] = at.rows;
  pen.setLineDash([]);
  pen.fillStyle = colours.grid;
  for (const level of [y.buffer, y.serverBuffer]) pen.fillRect(left, level - unit * 0.75, right - left, unit * 1.5);
  for (const [level, text, colour] of /** @type {[number, string, string][]} */ ([
    [y.game, game, player],
    [y.buffer, buffer, colours.ink],
    [y.net, net, player],
    [(y.net + y.serverNet) / 2, link, colours.faint],
    [y.serverNet, net, colours.truth],
    [y.serverBuffer, buffer, colours.ink],
    [y.serverGame, game, colours.truth],
  ])) {
    drawText(pen, colours, text, 4, level, { colour });
    if (text === buffer || text === link) continue;
    pen.strokeStyle = colour;
    pen.lineWidth = 1.5;
    line(at, [
      [left, level],
      [right, level],
    ]);
  }
  drawText(pen, colours, at.name, 4, colours.text * 0.75, { colour: player, bold: true });
  drawText(pen, colours, at.serverName, 4, at.height - colours.text * 0.7, { colour: colours.truth, bold: true });
  const tick = (/** @type {number} */ t, /** @type {number} */ level, /** @type {string} */ colour) => {
    if (t < begin - 1e-9 || t > Math.min(now, end)) return;
    pen.strokeStyle = colour;
    line(at, [
      [x(t), level - unit * 0.32],
      [x(t), level + unit * 0.32],
    ]);
  };
  pen.lineWidth = width < NARROW ? 0.8 : 1.2;
  for (const one of memory.events.values()) {
    if (one.type === STEP) tick(one.begin_s, y.serverGame, colours.truth);
    if (one.player !== way.player) continue;
    if (one.type === INPUT || one.type === DISPLAY) tick(one.begin_s, y.game, player);
    if (one.type === INPUT) tick(one.begin_s, y.net, player);
    if (one.type === INPUT_RESULT || one.type === STATE) tick(one.begin_s, y.serverNet, colours.truth);
    if (one.type === STATE && one.fate === 0) tick(one.end_s, y.net, player);
  }
}

/** The other packets on the links, thin. @param {Loops} at @param {Places} places */
function drawOthers(at, places) {
  const { pen, colours, memory, way, now } = at;
  const { x, y, begin, end } = places;
  pen.strokeStyle = colours.edge;
  pen.lineWidth = 0.7;
  pen.globalAlpha = 0.55;
  for (const one of memory.events.values()) {
    if (one.player !== way.player || (one.type !== INPUT && one.type !== STATE) || one.fate !== 0) continue;
    const until = Math.min(now, one.end_s);
    if (one.begin_s > Math.min(now, end) || one.end_s < begin || one.end_s <= one.begin_s) continue;
    const [from, to] = one.type === INPUT ? [y.net, y.serverNet] : [y.serverNet, y.net];
    const level = (/** @type {number} */ t) => from + ((t - one.begin_s) / (one.end_s - one.begin_s)) * (to - from);
    const start = Math.max(begin, one.begin_s);
    line(at, [
      [x(start), level(start)],
      [x(until), level(until)],
    ]);
  }
  pen.globalAlpha = 1;
}

/** Inputs of a player that have been sent and not been taken yet: what the paper's shared buffer holds.
 * @param {import('../core/memory.js').Memory} memory @param {number} player @param {number} now s
 * @returns {{arrived: number, until: number}[]} s; of each on its way or in the server's buffer, and of those that were */
export function waitsOf(memory, player, now) {
  const steps = new Map(),
    packets = [];
  for (const one of memory.events.values()) {
    if (one.type === STEP && one.begin_s <= now) steps.set(one.number, one.begin_s);
    if (one.type === INPUT && one.player === player && one.fate === 0 && one.begin_s <= now && one.tick > 0) packets.push(one);
  }
  return packets.map((one) => ({ arrived: one.end_s, until: steps.get(one.tick) ?? Number.POSITIVE_INFINITY }));
}

/** The inputs that wait at the server, thin; a frame around what Figures 6 and 7 call the shared buffer. @param {Loops} at
 * @param {Places} places */
function drawShared(at, places) {
  const { pen, colours, memory, way, now } = at;
  const { x, y, left, right, unit } = places;
  const list = waitsOf(memory, way.player, now);
  pen.strokeStyle = colours.edge;
  pen.lineWidth = 1.2;
  list.forEach(({ arrived, until }, i) => {
    const end = Math.min(until, now),
      level = y.serverBuffer + ((i % 5) - 2) * unit * 0.25;
    if (arrived > end || end < places.begin) return;
    line(at, [
      [Math.max(left, x(arrived)), level],
      [Math.max(left, x(end)), level],
    ]);
  });
  pen.strokeStyle = colours.buffer;
  pen.lineWidth = 2;
  pen.setLineDash([6, 4]);
  pen.strokeRect(left, y.net + unit * 0.45, right - left, y.serverBuffer + unit * 0.75 - y.net - unit * 0.45);
  pen.setLineDash([]);
  const inside = list.filter(({ until }) => until > now).length;
  drawText(pen, colours, `${at.shared}: ${inside}`, right - 5, y.serverNet - unit * 0.62, { align: 'right', colour: colours.bufferText });
}

/** Each waiting time as a number where it is spent. @param {Loops} at @param {Places} places
 * @param {{from: string, to: string, ms: number}[]} parts */
function drawNumbers(at, places, parts) {
  const { pen, colours, way } = at;
  const { x, y, unit, left, right } = places;
  const between = (y.net + y.serverNet) / 2;
  const levels = /** @type {Record<string, number>} */ ({
    sent: y.game - unit * 0.9,
    arrived: between,
    taken: y.serverBuffer,
    left: y.serverGame + unit * 0.9,
    came: between,
    released: y.buffer,
    shown: y.buffer,
  });
  parts.forEach(({ to, ms }, i) => {
    const a = way.stations[i],
      b = way.stations[i + 1],
      level = levels[to];
    if (!a || !b || level === undefined || ms < 0.05) return;
    const text = at.ms(ms);
    pen.font = `700 ${colours.text}px ${colours.font}`;
    const wide = pen.measureText(text).width,
      [from, until] = [x(a.t), x(b.t)];
    /* next to its stretch where that is too short for it */
    if (until - from > wide + 10) drawText(pen, colours, text, (from + until) / 2, level, { align: 'center', bold: true });
    else if (from - wide - 8 > left) drawText(pen, colours, text, from - 7, level, { align: 'right', bold: true });
    else drawText(pen, colours, text, Math.min(until + 7, right - wide), level, { bold: true });
  });
}

/** @param {Loops} at @param {{from: string, to: string, ms: number}[]} parts */
export function drawLoops(at, parts) {
  const { pen, colours, way, now } = at;
  const places = placesOf(at);
  const { x, left, right } = places;
  const paint = paintOf(colours, way.player);
  drawRows(at, places);
  pen.save();
  pen.beginPath();
  pen.rect(left - 2, 0, right - left + 4, at.height);
  pen.clip();
  drawOthers(at, places);
  drawShared(at, places);
  pen.restore();
  const mark = markOf(at, places);
  pen.strokeStyle = paint.text;
  pen.lineWidth = colours.line + 1.5;
  pen.lineJoin = 'round';
  for (const { id, t } of way.stations) place(pen.canvas, id, x(t), places.y.game, t * 1000);
  const path = corners(places, way).map((one) => /** @type {Point} */ ([x(one.t), one.y]));
  line(at, way.fate === 'open' || way.dropped ? [...path, [mark.x, mark.y]] : path);
  drawNumbers(at, places, parts);
  if (now <= places.end) {
    pen.strokeStyle = colours.accent;
    pen.lineWidth = 1.5;
    line(at, [
      [x(now), colours.text * 1.4],
      [x(now), at.height - colours.text * 1.5],
    ]);
  }
  if (mark.lost || way.fate === 'late' || way.fate === 'refused') {
    pen.strokeStyle = colours.snap;
    pen.lineWidth = colours.line + 1;
    cross(pen, mark.x, mark.y, 8);
  } else drawMark(pen, colours, way.player, mark.x, mark.y, 16);
  const { begin } = places,
    foot = at.height - colours.text * 0.7;
  const wish = (places.end - begin) / 5,
    step = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1].find((one) => one >= wish) ?? 2;
  for (let t = at.width < NARROW ? step : 0; t < places.end - begin - step / 4; t += step)
    drawText(pen, colours, `${fixed(t * 1000, 0)} ms`, x(begin + t), foot, { align: 'center', colour: colours.faint });
  drawShown(pen, colours);
}

/** The input whose packet was on the link nearest to a point; null: none. @param {Loops} at @param {number} px @param {number} py
 * @returns {number | null} */
export function inputAt(at, px, py) {
  const { x, y } = placesOf(at);
  let best = null,
    least = 14;
  for (const one of at.memory.events.values()) {
    if (one.type !== INPUT || one.player !== at.way.player || one.begin_s > at.now) continue;
    const end = one.fate === 0 ? one.end_s : one.begin_s,
      part = Math.max(0, Math.min(1, (py - y.net) / (y.serverNet - y.net)));
    const distance = Math.abs(x(one.begin_s + part * (end - one.begin_s)) - px);
    if (distance < least) {
      least = distance;
      best = one.number;
    }
  }
  return best;
}
