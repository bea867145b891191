// One view of a game that is drawn by its shapes, to scale and with y upwards: players, targets, crates, water, shells, scenery.
import { gridStep } from '../../../draw/axis.js';
import { E_ACTIVE, E_PREDICTED, E_UNKNOWN, entitiesOf, gameOf } from '../core/frame.js';
import { fixed, letter } from '../../../base/format.js';
import { paintOf } from '../../../draw/palette.js';
import { corrections, correctionWords, dots, gapLabel, reportBodies, scaleX, tellDot, toX } from './scene.js';
import { FADED, isAway } from './connection.js';
import { Labels } from './labels.js';
import { backdrop } from '../../../draw/backdrop.js';
import { drawText, widthOf } from '../../../draw/marks.js';
import { t } from '../../../base/words.js';

/** @typedef {import('./scene.js').DrawContext} DrawContext */
/** @typedef {import('../core/layout.js').Shape} Shape */
/** @typedef {import('../core/frame.js').Entity} Entity */

const FAR = 2; /* px: a ghost that is nearer says nothing */

/** @param {DrawContext} at @param {number} y m @returns {number} px; the ground lies below */
export function toY(at, y) {
  const { y_min: low, y_max: high } = at.layout.scene;
  return (at.height + (high - low) * scaleX(at)) / 2 - (y - low) * scaleX(at);
}

/** The outline of a shape around (x, y), turned by `angle`, at least `least` px across. @param {DrawContext} at @param {Shape} shape
 * @param {number} x px @param {number} y px @param {number} angle @param {number} least */
function outline(at, shape, x, y, angle, least) {
  const { pen } = at;
  const width = Math.max(least, shape.width_m * scaleX(at)) / 2,
    height = Math.max(least, shape.height_m * scaleX(at)) / 2;
  pen.beginPath();
  if (shape.round) {
    pen.ellipse(x, y, width, height, -angle, 0, 2 * Math.PI);
    return;
  }
  const c = Math.cos(angle),
    s = -Math.sin(angle); /* y points down on a canvas */
  for (const [u, v] of /** @type {[number, number][]} */ ([
    [-width, -height],
    [width, -height],
    [width, height],
    [-width, height],
  ])) {
    pen.lineTo(x + u * c - v * s, y + u * s + v * c);
  }
  pen.closePath();
}

/** @param {DrawContext} at */
function ground(at) {
  const {
    pen,
    colours,
    layout: { scene },
  } = at;
  const left = toX(at, scene.x_min),
    right = toX(at, scene.x_max),
    top = toY(at, scene.y_max),
    bottom = toY(at, scene.y_min);
  const step = gridStep(scaleX(at), 90);
  pen.setLineDash([]);
  pen.lineWidth = 1;
  pen.strokeStyle = colours.grid;
  pen.beginPath();
  for (let i = Math.ceil(scene.x_min / step); i * step <= scene.x_max; i++) {
    const x = Math.round(toX(at, i * step)) + 0.5;
    pen.moveTo(x, top);
    pen.lineTo(x, bottom);
  }
  for (let i = Math.ceil(scene.y_min / step); i * step <= scene.y_max; i++) {
    const y = Math.round(toY(at, i * step)) + 0.5;
    pen.moveTo(left, y);
    pen.lineTo(right, y);
  }
  pen.stroke();
  pen.strokeStyle = colours.edge;
  pen.strokeRect(Math.round(left) - 0.5, Math.round(top) - 0.5, Math.round(right - left) + 1, Math.round(bottom - top) + 1);
  drawText(pen, colours, `${step} m`, left + 4, top + colours.axis * 0.8, { size: colours.axis, colour: colours.faint });
  for (const shape of at.layout.fixed) {
    outline(at, shape, toX(at, shape.x), toY(at, shape.y), 0, 1);
    pen.fillStyle = colours.edge;
    pen.fill();
  }
}

/** How a kind is filled and edged. @param {DrawContext} at @param {Shape} shape @param {number} i @param {Entity} e */
function look(at, shape, i, e) {
  const { colours } = at;
  const own = (e.flags & E_PREDICTED) !== 0 && at.view > 0;
  if (shape.kind === 'player') return { fill: paintOf(colours, i).fill, edge: colours.truth, line: Math.max(1.5, colours.line) };
  if (shape.kind === 'crate')
    return { fill: colours.grid, edge: own ? paintOf(colours, at.view - 1).text : colours.edge, line: own ? colours.line : 1 };
  if (shape.kind === 'water') return { fill: colours.accent, edge: colours.accent, line: 1 };
  if (shape.kind === 'target') return { fill: colours.buffer, edge: colours.truth, line: 1.5 };
  return { fill: colours.truth, edge: colours.truth, line: 1 };
}

/** px: a letter fits a player, and a shell is seen. @param {DrawContext} at @param {Shape} shape @returns {number} */
function leastOf(at, shape) {
  return shape.kind === 'player' ? at.colours.text + 3 : 4;
}

/** Whether there is something to see: a shell only while it flies, and nothing that the player's snapshots do not contain.
 * @param {Shape} shape @param {Entity} e @returns {boolean} */
function seen(shape, e) {
  return (e.flags & E_UNKNOWN) === 0 && (shape.kind !== 'shell' || (e.flags & E_ACTIVE) !== 0);
}

/** @param {DrawContext} at @param {Shape} shape @param {number} i @param {Entity} e */
function thing(at, shape, i, e) {
  const { pen, colours } = at;
  const x = toX(at, e.x),
    y = toY(at, e.y),
    { fill, edge, line } = look(at, shape, i, e);
  outline(at, shape, x, y, e.angle, leastOf(at, shape));
  pen.setLineDash([]);
  pen.fillStyle = fill;
  pen.fill();
  pen.lineWidth = line;
  pen.strokeStyle = edge;
  pen.stroke();
  if (shape.kind === 'player') {
    drawText(pen, { ...colours, paper: fill, ink: colours.onFill }, letter(i), x, y + 1, { align: 'center', bold: true });
  }
}

/** Where the server has it: hollow and dashed, joined to where it is drawn. @param {DrawContext} at @param {Shape} shape
 * @param {Entity} drawn
 * @param {Entity} real @returns {boolean} whether it is far enough to be seen */
function ghost(at, shape, drawn, real) {
  const { pen, colours } = at;
  const x = toX(at, drawn.x),
    y = toY(at, drawn.y),
    gx = toX(at, real.x),
    gy = toY(at, real.y);
  const turned = Math.abs(real.angle - drawn.angle) * shape.width_m * scaleX(at);
  if (!seen(shape, real) || Math.hypot(gx - x, gy - y) + (shape.round ? 0 : turned) <= FAR) return false;
  outline(at, shape, gx, gy, real.angle, leastOf(at, shape));
  pen.setLineDash([4, 3]);
  pen.lineWidth = shape.kind === 'player' ? colours.line : 1;
  pen.strokeStyle = colours.truth;
  pen.stroke();
  pen.setLineDash([]);
  pen.lineWidth = 1;
  pen.beginPath();
  pen.moveTo(x, y);
  pen.lineTo(gx, gy);
  pen.stroke();
  return true;
}

/** The game's own numbers of a player. @param {DrawContext} at @param {number} player @param {number} most of them @returns {string} */
function standing(at, player, most) {
  const units = new Map([
    ['m', ' m'],
    ['mps', ' m/s'],
    ['s', ' s'],
    ['ms', ' ms'],
    ['rad', ' rad'],
  ]);
  const values = gameOf(at.frame, player);
  const parts = at.layout.game_values.slice(0, most).map((name, k) => {
    const unit = units.get(name.slice(name.lastIndexOf('_') + 1)),
      value = values[k] ?? 0;
    return `${t(`netgame.value.${name}`) || name} ${fixed(value, unit ? 1 : 0)}${unit ?? ''}`;
  });
  return `${at.layout.players[player]?.name ?? letter(player)}: ${parts.join(' · ')}`;
}

/** In a line, as many players as have room. @param {DrawContext} at @param {number} y px */
export function drawStandings(at, y) {
  const { pen, colours } = at;
  let x = 8;
  for (let p = 0; p < at.layout.players.length; p++) {
    let most = at.layout.game_values.length,
      text = standing(at, p, most);
    while (p === 0 && most > 1 && x + widthOf(pen, colours, text) > at.width - 8) text = standing(at, p, --most);
    const width = widthOf(pen, colours, text);
    if (p > 0 && x + width > at.width - 8) break;
    drawText(pen, colours, text, x, y, { colour: paintOf(colours, p).text });
    x += width + 2 * colours.text;
  }
}

/** @param {DrawContext} at @returns {import('./scene.js').Drawn[]} the dots */
export function drawField(at) {
  const {
    pen,
    colours,
    overlays,
    layout: { entities: shapes, players },
  } = at;
  const place = (/** @type {number} */ x, /** @type {number} */ y) => ({ x: toX(at, x), y: toY(at, y) });
  const labels = new Labels(at);
  /** @type {number[]} */
  const far = [];
  const { x_min, x_max, y_min, y_max } = at.layout.scene;
  backdrop(pen, at, ['field', x_min, x_max, y_min, y_max, ...at.layout.fixed.flatMap((s) => [s.x, s.y])].join(' '), (on) =>
    ground({ ...at, pen: on }),
  );
  const drawn = overlays.dots ? dots(at, place, () => true) : [];
  /** @type {[number, Shape, Entity][]} players last, so that they are drawn on top */
  const all = entitiesOf(at.frame, at.view)
    .flatMap((e, i) => {
      const shape = shapes[i];
      return shape && seen(shape, e) ? [/** @type {[number, Shape, Entity]} */ ([i, shape, e])] : [];
    })
    .reverse();
  for (const [i, shape, e] of all) {
    const real = entitiesOf(at.frame, 0)[i];
    if (at.view > 0 && overlays.ghosts && real && ghost(at, shape, e, real) && i < players.length) far.push(i);
  }
  for (const [i, shape, e] of all) {
    pen.globalAlpha = isAway(e) ? FADED : 1;
    thing(at, shape, i, e);
    pen.globalAlpha = 1;
    if (i < players.length) labels.block(toX(at, e.x), toY(at, e.y), shape.width_m * scaleX(at), shape.height_m * scaleX(at));
  }
  for (const [i, shape, e] of all) {
    if (i >= players.length || !isAway(e)) continue;
    const { x, y } = place(e.x, e.y),
      half = (shape.width_m * scaleX(at)) / 2;
    labels.put(t('netgame.away'), x - half, x + half, y, 2 * half, { colour: colours.snap, bold: true });
  }
  const own = entitiesOf(at.frame, at.view)[at.view - 1];
  if (own) corrections(at, at.view - 1, (x, y) => place(x, y), colours.marker);
  if (overlays.labels) {
    for (const i of far) {
      const e = entitiesOf(at.frame, at.view)[i],
        real = entitiesOf(at.frame, 0)[i];
      if (!e || !real) continue;
      const { x, y } = place(e.x, e.y),
        gx = toX(at, real.x),
        half = ((shapes[i]?.width_m ?? 1) * scaleX(at)) / 2;
      labels.put(gapLabel(at, e, real), Math.min(x, gx) - half, Math.max(x, gx) + half, y, 2 * half, { colour: colours.faint });
    }
  }
  const words = at.view > 0 ? correctionWords(at, at.view - 1) : '';
  if (words !== '') drawText(pen, colours, words, at.width - 8, at.height - colours.text * 0.8, { align: 'right', colour: colours.snap });
  reportBodies(at, ({ y }) => toY(at, y));
  tellDot(at, drawn);
  return drawn;
}
