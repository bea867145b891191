// Shared by all views of a game: the drawing context, the scale, ghosts, corrections.
import { gridStep } from '../../../draw/axis.js';
import { E_PREDICTED, entitiesOf } from '../core/frame.js';
import { fixed, letter, localized, signed } from '../../../base/format.js';
import { paintOf } from '../../../draw/palette.js';
import { place, shows } from '../../../draw/shown.js';
import { drawCarGhost, hasCar } from '../../../draw/cars.js';
import { cross, drawGhost, drawText, spring } from '../../../draw/marks.js';
import { t } from '../../../base/words.js';

/** @typedef {import('../core/frame.js').Frame} Frame */
/** @typedef {import('../core/frame.js').Entity} Entity */
/** @typedef {import('../core/memory.js').Memory} Memory */

/**
 * @typedef {object} DrawContext
 * @property {CanvasRenderingContext2D} pen
 * @property {number} width
 * @property {number} height   of the scene; the strip lies below
 * @property {import('../../../draw/palette.js').Palette} colours
 * @property {Frame} frame
 * @property {Memory} memory
 * @property {import('../core/layout.js').Layout} layout
 * @property {number} view     0 is the server
 * @property {{ghosts: boolean, dots: boolean, labels: boolean}} overlays
 * @property {'px' | 'm' | 'ms'} unit
 * @property {number[] | null} only  the players that are drawn; null for all
 * @property {import('../../../session/state.js').Staged | null} staged  what a lesson adds
 * @property {import('../../../session/state.js').Recorded | null} run  recorded, of what is drawn
 * @property {import('../../../session/state.js').Recorded | null} first  recorded, of a lesson's first run
 * @property {boolean} [faded]  it is what was
 * @property {Picked | null} picked  the dot that is asked about
 */

/** A dot as drawn. @typedef {{x: number, y: number, dot: import('../core/memory.js').Dot}} Drawn */
/** @typedef {{view: number, dot: import('../core/memory.js').Dot}} Picked */

const MARGIN = 14; /* px left and right, so that a mark on the edge is seen */
const FADE_S = 0.6;
const CROWD = 10; /* corrections per second: a number is then shown in place of marks */

/** A scene of shapes has one scale for x and y. @param {DrawContext} at @returns {number} px per metre */
export function scaleX(at) {
  const { x_min: left, x_max: right, y_min: low, y_max: high } = at.layout.scene;
  const across = (at.width - 2 * MARGIN) / Math.max(1e-6, right - left);
  if (at.layout.entities.length === 0) return across;
  return Math.max(1e-6, Math.min(across, (at.height - MARGIN) / Math.max(1e-6, high - low)));
}

/** @param {DrawContext} at @param {number} x m @returns {number} px */
export function toX(at, x) {
  const { x_min: left, x_max: right } = at.layout.scene;
  return (at.width - (right - left) * scaleX(at)) / 2 + (x - left) * scaleX(at);
}

/** The common x axis: lines and metres. @param {DrawContext} at */
export function drawGrid(at) {
  const { pen, colours, layout, height } = at;
  const step = gridStep(scaleX(at), Math.max(90, colours.axis * 5));
  const first = Math.ceil(layout.scene.x_min / step - 1e-9),
    last = Math.floor(layout.scene.x_max / step + 1e-9);
  for (let i = first; i <= last; i++) {
    const x = Math.round(toX(at, i * step));
    pen.fillStyle = colours.grid;
    pen.fillRect(x, 0, 1, height);
    if (i === last - 1 && scaleX(at) * step < colours.axis * 5.4) continue; /* the last label needs the room */
    const metres = localized(String(Number((i * step).toPrecision(6))));
    drawText(pen, colours, `${metres}${i === first || i === last ? ' m' : ''}`, i === last ? x - 3 : x + 3, colours.axis * 0.7, {
      size: colours.axis,
      colour: colours.faint,
      align: i === last ? 'right' : 'left',
    });
  }
}

/** Distance of a drawn entity from the ground truth, in words; of a predicted one the time follows from the distance.
 * @param {DrawContext} at @param {Entity} drawn @param {Entity} real @returns {string} */
export function gapLabel(at, drawn, real) {
  const along = drawn.x - real.x;
  const dx = (along < 0 ? -1 : 1) * Math.hypot(along, drawn.y - real.y); /* as the daemon measures it: a distance with a sign */
  const predicted = (drawn.flags & E_PREDICTED) !== 0 || drawn.age_ms === 0;
  const age = !predicted ? drawn.age_ms : Math.abs(real.vx) > 0.5 ? -(dx / real.vx) * 1000 : 0;
  const about = predicted ? '≈ ' : '';
  const way = at.unit === 'm' ? `${signed(dx, 2)} m` : `${signed(dx * scaleX(at), 0)} px`;
  const late = Math.round(age);
  const time = late === 0 ? '' : t(late > 0 ? 'netgame.behind' : 'netgame.ahead', { ms: `${about}${fixed(Math.abs(late), 0)}` });
  return time === '' ? way : `${way} · ${time}`;
}

/** Reports where the players' bodies are in a view: `A` as it is drawn, `A.truth` where the server has it, in the server's view `A.seen` as
 * A's own screen draws it; where a lesson has recorded its runs, `A.before` a tick ago and `A.first` in the first run. The same of another
 * body that a lesson is about, `body_32`. @param {DrawContext} at @param {(body: {x: number, y: number}) => number} toY px */
export function reportBodies(at, toY) {
  const { canvas } = at.pen,
    { tick } = at.frame;
  /** @param {string} name @param {number} i */
  const reportOne = (name, i) => {
    const body = entitiesOf(at.frame, at.view)[i];
    if (!body) return;
    const report = (/** @type {string} */ what, /** @type {{x: number, y: number} | undefined} */ one) => {
      if (one) place(canvas, name + what, toX(at, body.x) + (one.x - body.x) * scaleX(at), toY(one), one.x);
    };
    report('', body);
    report(at.view > 0 ? '.truth' : '.seen', entitiesOf(at.frame, at.view > 0 ? 0 : 1 + i)[i]);
    report('.before', at.run?.get(tick - 1)?.[at.view]?.[i]);
    report('.first', at.first?.get(tick)?.[at.view]?.[i]);
  };
  at.layout.players.forEach((_, i) => reportOne(letter(i), i));
  const other = /^body_(\d+)/.exec(shows.value?.from ?? '');
  if (other) reportOne(other[0], Number(other[1]));
}

/** The server's truth in a player's view. @param {DrawContext} at @param {number} player @param {number} x px, of the drawn mark
 * @param {number} y px @param {number} gx px, of the ghost @param {number} gy @param {number} size */
export function ghost(at, player, x, y, gx, gy, size) {
  const { pen, colours } = at;
  if (hasCar(player) && at.layout.controls !== 'aim') {
    drawCarGhost(pen, colours, player, gx, gy, size);
    return;
  }
  drawGhost(pen, colours, player, gx, gy, size);
  if (Math.hypot(gx - x, gy - y) <= 2) return;
  pen.lineWidth = 1.5;
  pen.strokeStyle = colours.truth;
  pen.beginPath();
  pen.moveTo(x, y);
  pen.lineTo(gx, gy);
  pen.stroke();
}

/** Corrections of the last moments. @param {DrawContext} at @param {number} player
 * @param {(x: number, y: number) => {x: number, y: number}} place of a point in m, in px @param {number} size of the mark */
export function corrections(at, player, place, size) {
  const { pen, colours, memory, frame } = at;
  const list = memory.corrections[player] ?? [];
  const lately = list.filter((c) => frame.time_s - c.t < 1);
  const marked = lately.filter((c) => Math.abs(c.dx) * scaleX(at) >= 0.5);
  const newest = lately[lately.length - 1];
  if (newest?.replayed && marked.length === 0 && frame.time_s - newest.t < FADE_S / 2) {
    /* replayed, and nothing to see: a check */
    const { x, y } = place(newest.x, newest.y);
    pen.strokeStyle = colours.snap;
    pen.lineWidth = colours.line;
    pen.setLineDash([]);
    pen.beginPath();
    pen.moveTo(x - 5, y - size * 0.5 - 8);
    pen.lineTo(x - 1, y - size * 0.5 - 4);
    pen.lineTo(x + 6, y - size * 0.5 - 12);
    pen.stroke();
  }
  if (marked.length >= CROWD) return;
  for (const c of marked) {
    const age = frame.time_s - c.t;
    if (age < 0 || age > FADE_S) continue;
    const now = place(c.x, c.y),
      before = now.x - c.dx * scaleX(at);
    pen.globalAlpha = 1 - age / FADE_S;
    pen.strokeStyle = colours.snap;
    pen.setLineDash([]);
    pen.lineWidth = colours.line;
    spring(pen, before, now.x, now.y);
    pen.lineWidth = colours.line + 1;
    cross(pen, before, now.y, Math.min(9, 4 + Math.abs(before - now.x) / 12));
    if (c.replayed && c === marked[marked.length - 1])
      drawText(pen, colours, t('netgame.replayed'), before, now.y - 14, { align: 'center', colour: colours.snap });
    pen.globalAlpha = 1;
  }
}

/** Sum of the corrections, in words. @param {DrawContext} at @param {number} player @returns {string} */
export function correctionWords(at, player) {
  const view = at.frame.views[1 + player];
  if (!view || view.corrections === 0) return '';
  const list = at.memory.corrections[player] ?? [];
  const rate = list.filter((c) => at.frame.time_s - c.t < 1).length;
  const largest = at.memory.largest[player] ?? 0;
  const size = at.unit === 'm' ? `${fixed(largest, 2)} m` : `${fixed(largest * scaleX(at), 0)} px`;
  const count = t((view.flags & 2) !== 0 ? 'netgame.corrections' : 'netgame.snaps', { n: view.corrections });
  const pace = rate >= CROWD ? ` · ${rate}/s` : '';
  return `${count}${pace} · ${t('netgame.largest', { size })}`;
}

/** One dot per arrived packet; where they would run together, one of k. @param {DrawContext} at
 * @param {(x: number, y: number) => {x: number, y: number}} place @param {(dot: import('../core/memory.js').Dot) => boolean} wanted
 * @returns {Drawn[]} */
export function dots(at, place, wanted) {
  const { pen, colours } = at;
  const r = colours.line + 1;
  const list = (at.memory.dots[at.view] ?? []).filter(wanted);
  /** @type {Drawn[]} */
  const drawn = [];
  let most = 1;
  for (const entity of new Set(list.map((dot) => dot.entity))) {
    const own = list.filter((dot) => dot.entity === entity).map((dot) => ({ ...place(dot.x, dot.y), dot }));
    let way = 0;
    for (let i = 1; i < own.length; i++) {
      const a = own[i - 1],
        b = own[i];
      if (a && b) way += Math.min(40, Math.hypot(b.x - a.x, b.y - a.y)); /* a jump back to the start is no way */
    }
    const spacing = way / Math.max(1, own.length - 1);
    const k = own.length < 8 || spacing > 2.6 * r || way < 20 ? 1 : Math.ceil((3 * r) / spacing);
    most = Math.max(most, k);
    pen.fillStyle = paintOf(colours, entity).text;
    for (const one of own) {
      if (one.dot.n % k !== 0) continue;
      drawn.push(one);
      pen.beginPath();
      pen.arc(one.x, one.y, r, 0, 2 * Math.PI);
      pen.fill();
    }
  }
  if (most > 1) drawText(pen, colours, t('netgame.dots', { n: most }), 8, colours.text * 2.1, { colour: colours.faint });
  return drawn;
}

/** Names the dot that is asked about. @param {DrawContext} at @param {Drawn[]} drawn */
export function tellDot(at, drawn) {
  const { pen, colours, picked } = at;
  const one = picked && picked.view === at.view ? drawn.find(({ dot }) => dot === picked.dot) : undefined;
  if (!one) return;
  pen.strokeStyle = colours.accent;
  pen.lineWidth = colours.line;
  pen.beginPath();
  pen.arc(one.x, one.y, colours.line + 5, 0, 2 * Math.PI);
  pen.stroke();
  const text = at.memory.describe(one.dot);
  pen.font = `700 ${colours.text}px ${colours.font}`;
  const half = pen.measureText(text).width / 2 + 6;
  drawText(pen, colours, text, Math.max(half, Math.min(at.width - half, one.x)), Math.max(colours.text * 2, one.y - colours.text * 1.6), {
    align: 'center',
    bold: true,
  });
}
