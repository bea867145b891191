// What every view of a game shares: the picture it draws into, the scale, ghosts, corrections.
import { fixed, signed } from '../format.js';
import { paintOf } from '../theme.js';
import { cross, drawGhost, drawText, spring } from './marks.js';

/** @typedef {import('../frame.js').Frame} Frame */
/** @typedef {import('../frame.js').Entity} Entity */
/** @typedef {import('../memory.js').Memory} Memory */

/**
 * @typedef {object} Picture
 * @property {CanvasRenderingContext2D} pen
 * @property {number} width
 * @property {number} height   of the scene; the strip lies below
 * @property {import('../theme.js').Palette} colours
 * @property {Frame} frame
 * @property {Memory} memory
 * @property {import('../state.js').Layout} layout
 * @property {number} view     0 is the server
 * @property {{ghosts: boolean, dots: boolean, labels: boolean}} overlays
 * @property {'px' | 'm' | 'ms'} unit
 */

const MARGIN = 14; /* px left and right, so that a mark on the edge is seen */
const FADE_S = 0.6;
const CROWD = 10;  /* corrections per second: a number is then shown in place of marks */

/** @param {Picture} at @returns {number} px per metre */
export function scaleX(at) {
  const { x_min: low, x_max: high } = at.layout.scene;
  return (at.width - 2 * MARGIN) / Math.max(1e-6, high - low);
}

/** @param {Picture} at @param {number} x m @returns {number} px */
export function toX(at, x) {
  return MARGIN + (x - at.layout.scene.x_min) * scaleX(at);
}

/** A round step for grid lines about `wanted` px apart. @param {number} perMetre @param {number} wanted @returns {number} */
export function gridStep(perMetre, wanted) {
  const raw = wanted / perMetre;
  const power = 10 ** Math.floor(Math.log10(raw));
  const lead = raw / power;
  return (lead < 1.5 ? 1 : lead < 3.5 ? 2 : lead < 7.5 ? 5 : 10) * power;
}

/** The common x axis: lines and metres. @param {Picture} at */
export function drawGrid(at) {
  const { pen, colours, layout, height } = at;
  const step = gridStep(scaleX(at), 90);
  pen.lineWidth = 1;
  pen.setLineDash([]);
  const first = Math.ceil(layout.scene.x_min / step - 1e-9);
  for (let i = first; i * step <= layout.scene.x_max + 1e-9; i++) {
    const x = Math.round(toX(at, i * step)) + 0.5;
    pen.strokeStyle = colours.grid;
    pen.beginPath();
    pen.moveTo(x, 0);
    pen.lineTo(x, height);
    pen.stroke();
    const metres = String(Number((i * step).toPrecision(6))).replace('-', '−');
    const last = (i + 1) * step > layout.scene.x_max + 1e-9;
    drawText(pen, colours, `${metres}${i === first || last ? ' m' : ''}`, last ? x - 3 : x + 3, colours.text * 0.7,
      { colour: colours.faint, align: last ? 'right' : 'left' });
  }
}

/** How far the drawn thing is from the truth, in words. @param {Picture} at @param {number} dx m @param {number} age ms
 * @returns {string} */
export function gapLabel(at, dx, age) {
  const way = at.unit === 'm' ? `${signed(dx, 2)} m` : `${signed(dx * scaleX(at), 0)} px`;
  const late = Math.round(age);
  const time = late === 0 ? '' : late > 0 ? `${fixed(late, 0)} ms behind` : `${fixed(-late, 0)} ms ahead`;
  return time === '' ? way : `${way} · ${time}`;
}

/** The server's truth in a player's view. @param {Picture} at @param {number} player @param {number} x px, of the drawn mark
 * @param {number} y px @param {number} gx px, of the ghost @param {number} gy @param {number} size @param {string} label */
export function ghost(at, player, x, y, gx, gy, size, label) {
  const { pen, colours } = at;
  const far = Math.hypot(gx - x, gy - y);
  drawGhost(pen, colours, player, gx, gy, size);
  if (far > 2) {
    pen.lineWidth = 1.5;
    pen.strokeStyle = colours.truth;
    pen.beginPath();
    pen.moveTo(x, y);
    pen.lineTo(gx, gy);
    pen.stroke();
  }
  if (!at.overlays.labels || far < 1) return;
  const right = Math.max(x, gx) + size * 0.9, left = Math.min(x, gx) - size * 0.9;
  pen.font = `${colours.text}px ${colours.font}`;
  const fits = right + pen.measureText(label).width < at.width - 4;
  drawText(pen, colours, label, fits ? right : left, gy > y + size || gy < y - size ? (y + gy) / 2 : y,
    { align: fits ? 'left' : 'right', colour: colours.faint });
}

/** Corrections of the last moments. @param {Picture} at @param {number} player
 * @param {(x: number, y: number) => {x: number, y: number}} place of a point in m, in px */
export function corrections(at, player, place) {
  const { pen, colours, memory, frame } = at;
  const list = memory.corrections[player] ?? [];
  const lately = list.filter((c) => frame.time - c.t < 1);
  const marked = lately.filter((c) => Math.abs(c.dx) * scaleX(at) >= 0.5);
  if (marked.length >= CROWD) return;
  for (const c of marked) {
    const age = frame.time - c.t;
    if (age < 0 || age > FADE_S) continue;
    const now = place(c.x, c.y), before = now.x - c.dx * scaleX(at);
    pen.globalAlpha = 1 - age / FADE_S;
    pen.strokeStyle = colours.snap;
    pen.setLineDash([]);
    pen.lineWidth = colours.line;
    spring(pen, before, now.x, now.y);
    pen.lineWidth = colours.line + 1;
    cross(pen, before, now.y, Math.min(9, 4 + Math.abs(before - now.x) / 12));
    if (c.replayed) drawText(pen, colours, 'replayed', before, now.y - 14, { align: 'center', colour: colours.snap });
    pen.globalAlpha = 1;
  }
}

/** What the corrections come to, in words. @param {Picture} at @param {number} player @returns {string} */
export function correctionWords(at, player) {
  const view = at.frame.views[1 + player];
  if (!view || view.corrections === 0) return '';
  const list = at.memory.corrections[player] ?? [];
  const rate = list.filter((c) => at.frame.time - c.t < 1).length;
  const largest = at.memory.largest[player] ?? 0;
  const size = at.unit === 'm' ? `${fixed(largest, 2)} m` : `${fixed(largest * scaleX(at), 0)} px`;
  const word = (view.flags & 2) !== 0 ? 'corrections' : 'snaps';
  const pace = rate >= CROWD ? ` · ${rate}/s` : '';
  return `${word} ${view.corrections}${pace} · max ${size}`;
}

/** One dot per arrived packet. @param {Picture} at @param {(x: number, y: number) => {x: number, y: number}} place
 * @param {(dot: import('../memory.js').Dot) => boolean} wanted */
export function dots(at, place, wanted) {
  const { pen, colours } = at;
  for (const dot of at.memory.dots[at.view] ?? []) {
    if (!wanted(dot)) continue;
    const { x, y } = place(dot.x, dot.y);
    pen.beginPath();
    pen.arc(x, y, colours.line + 1, 0, 2 * Math.PI);
    pen.fillStyle = paintOf(colours, dot.entity).text;
    pen.fill();
  }
}
