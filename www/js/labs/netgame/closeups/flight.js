// The past part of a shell's flight and the straight line that the server checks in its place: to scale, and their middle through a lens.
import { gridStep } from '../../../draw/axis.js';
import { drawText, widthOf } from '../../../draw/marks.js';
import { paintOf } from '../../../draw/palette.js';
import { drawBand, drawPosts, place } from '../../../draw/shown.js';
import { fixed, letter } from '../../../base/format.js';
import { t } from '../../../base/words.js';
import { PROJECTILE, bodiesOf } from '../core/frame.js';

/** @typedef {import('../core/frame.js').Frame} Frame */
/** @typedef {{x: number, y: number}} Point  m */
/** @typedef {{pen: CanvasRenderingContext2D, width: number, height: number, colours: import('../../../draw/palette.js').Palette,
 *   frame: Frame, layout: import('../core/layout.js').Layout, player: number, speed: number, gravity: number, parabola: boolean}} Drawing
 *   parabola: the server checks the flight itself */

const BEFORE = 1.5,
  AFTER = 3; /* m, in front of the muzzle and behind the checked part */
const PARTS = 40;

/** The newest shell of a player, as the server has taken it. @param {Frame} frame @param {number} player */
export const shellOf = (frame, player) =>
  frame.shots
    .filter((one) => one.player === player && one.weapon === PROJECTILE && one.evaluated_at_s <= frame.time_s)
    .sort((a, b) => b.evaluated_at_s - a.evaluated_at_s)[0];

/** @param {Drawing} at */
export function drawFlight(at) {
  const { pen, width, height, colours, frame, layout, player, speed, gravity, parabola } = at,
    shot = shellOf(frame, player);
  if (!shot) {
    drawText(pen, colours, t('netgame_more.flight.none', { name: letter(player) }), 10, height / 2, { colour: colours.faint });
    return;
  }
  const long = shot.evaluated_at_s - shot.view_time_s; /* s, that have passed when the server takes it */
  /** @param {number} s @returns {Point} */
  const fly = (s) => ({ x: shot.x + speed * shot.dx * s, y: shot.y + speed * shot.dy * s - (gravity / 2) * s * s });
  const [start, end, middle] = [fly(0), fly(long), fly(long / 2)],
    chord = { x: (start.x + end.x) / 2, y: (start.y + end.y) / 2 };
  const way = Math.sign(end.x - start.x) || 1,
    scale = width / (Math.abs(end.x - start.x) + BEFORE + AFTER),
    level = Math.min(height * 0.3, 120);
  const x = (/** @type {number} */ m) => (way > 0 ? BEFORE + m - start.x : AFTER + m - end.x) * scale,
    y = (/** @type {number} */ m) => level - (m - middle.y) * scale;
  /** A curve of the flight or its line. @param {(s: number) => Point} of @param {(p: Point) => [number, number]} to */
  const trace = (of, to) => {
    pen.beginPath();
    for (let i = 0; i <= PARTS; i++) pen.lineTo(...to(of((long * i) / PARTS)));
    pen.stroke();
  };
  const straight = (/** @type {number} */ s) => ({
    x: start.x + ((end.x - start.x) * s) / long,
    y: start.y + ((end.y - start.y) * s) / long,
  });
  const both = (/** @type {(p: Point) => [number, number]} */ to, /** @type {number} */ wide) => {
    pen.setLineDash([]);
    pen.lineWidth = wide;
    pen.strokeStyle = paintOf(colours, player).text;
    trace(fly, to);
    pen.strokeStyle = parabola ? colours.faint : colours.snap;
    pen.setLineDash([9, 5]);
    trace(straight, to);
    pen.setLineDash([]);
  };
  const step = gridStep(scale, 90);
  for (let m = Math.ceil(Math.min(start.x, end.x) / step) * step; m <= Math.max(start.x, end.x) + AFTER; m += step) {
    pen.fillStyle = colours.grid;
    pen.fillRect(Math.round(x(m)), 0, 1, height);
    drawText(pen, colours, `${fixed(m, 0)} m`, x(m), height - colours.axis, { size: colours.axis, colour: colours.faint, align: 'center' });
  }
  bodiesOf(frame, shot).forEach((body, i) => {
    const r = ((layout.entities[i]?.width_m ?? 1) / 2) * scale;
    if (i === player || y(body.looked_y) > level + 60 || y(body.looked_y) < 0) return;
    pen.strokeStyle = colours.edge;
    pen.lineWidth = 1.5;
    pen.beginPath();
    pen.arc(x(body.looked_x), y(body.looked_y), r, 0, 2 * Math.PI);
    pen.stroke();
  });
  both((p) => [x(p.x), y(p.y)], colours.line);
  pen.fillStyle = paintOf(colours, player).fill;
  for (const [p, r] of /** @type {[Point, number][]} */ ([
    [start, 9],
    [end, 5],
  ])) {
    pen.beginPath();
    pen.arc(x(p.x), y(p.y), r, 0, 2 * Math.PI);
    pen.fill();
  }
  const below = (/** @type {string} */ text, /** @type {Point} */ p) =>
    drawText(pen, colours, text, Math.max(4, Math.min(x(p.x) - 20, width - widthOf(pen, colours, text) - 4)), y(p.y) + 24);
  below(t('netgame_more.flight.fired', { name: letter(player) }), start);
  below(t('netgame_more.flight.taken', { ms: fixed(long * 1000, 0) }), end);

  /* the lens */
  const bottom = height - colours.axis * 2 - colours.text * 1.7,
    r = Math.min(width * 0.3, (bottom - level - 40) / 2),
    cx = x(middle.x),
    cy = bottom - r,
    off = Math.max(0.01, middle.y - chord.y),
    larger = Math.max(2, Math.floor((r * 1.1) / off / scale)),
    k = scale * larger,
    centre = (middle.y + chord.y) / 2;
  const to = (/** @type {Point} */ p) => /** @type {[number, number]} */ ([cx + (p.x - middle.x) * k, cy - (p.y - centre) * k]);
  pen.strokeStyle = colours.ink;
  pen.lineWidth = 2;
  pen.beginPath();
  pen.arc(cx, level + (middle.y - centre) * scale, r / larger, 0, 2 * Math.PI);
  pen.moveTo(cx - r / larger, level + 4);
  pen.lineTo(cx - r, cy);
  pen.moveTo(cx + r / larger, level + 4);
  pen.lineTo(cx + r, cy);
  pen.stroke();
  pen.save();
  pen.beginPath();
  pen.arc(cx, cy, r, 0, 2 * Math.PI);
  pen.fillStyle = colours.paper;
  pen.fill();
  pen.clip();
  place(pen.canvas, 'flight', ...to(middle), middle.y);
  place(pen.canvas, 'line', ...to(chord), chord.y);
  drawBand(pen, colours);
  const target = layout.entities[layout.players.length];
  pen.strokeStyle = colours.edge;
  pen.setLineDash([]);
  pen.lineWidth = 1.5;
  pen.beginPath();
  pen.arc(...to(middle), ((target?.width_m ?? 1) / 2) * k, 0, 2 * Math.PI);
  pen.stroke();
  both(to, colours.line + 1.5);
  pen.restore();
  pen.strokeStyle = colours.ink;
  pen.lineWidth = 3;
  pen.beginPath();
  pen.arc(cx, cy, r, 0, 2 * Math.PI);
  pen.stroke();
  drawText(pen, colours, t('netgame_more.flight.lens', { n: fixed(larger, 0) }), cx, cy + r + colours.text, {
    align: 'center',
    bold: true,
  });
  drawPosts(pen, colours);
}
