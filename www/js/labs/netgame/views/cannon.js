// One view of the cannon: flights with one dot per arrived packet, and the target (Figures 8 and 9).
import { E_ACTIVE, entitiesOf, gameOf } from '../core/frame.js';
import { fixed, letter, signed } from '../../../base/format.js';
import { paintOf } from '../../../draw/palette.js';
import { dots, drawGrid, gapLabel, ghost, reportBodies, tellDot, toX } from './scene.js';
import { FADED, isAway } from './connection.js';
import { Labels } from './labels.js';
import { backdrop } from '../../../draw/backdrop.js';
import { drawMark, drawText } from '../../../draw/marks.js';
import { t } from '../../../base/words.js';

/** @typedef {import('./scene.js').DrawContext} DrawContext */

const GROUND = 18; /* px below the ground line */
const BUTTON = 40; /* px: at the right edge, to save the view */

/** The height that a view shows: little more than was ever flown. @param {DrawContext} at @returns {number} m */
function ceiling(at) {
  return Math.max(at.layout.scene.y_max * 0.3, at.memory.highest * 1.2, 1);
}

/** @param {DrawContext} at @param {number} y m @returns {number} px */
export function toY(at, y) {
  const top = at.colours.text * 1.4;
  return at.height - GROUND - (y / ceiling(at)) * (at.height - GROUND - top);
}

/** @param {DrawContext} at */
function ground(at) {
  const { pen, colours } = at;
  const y = Math.round(toY(at, 0)) + 0.5;
  pen.setLineDash([]);
  pen.strokeStyle = colours.edge;
  pen.lineWidth = 1.5;
  pen.beginPath();
  pen.moveTo(0, y);
  pen.lineTo(at.width, y);
  pen.stroke();
}

/** @param {DrawContext} at */
function target(at) {
  const { target_x: x, target_y: y, target_radius: radius } = at.layout.scene;
  if (!(radius > 0)) return;
  const { pen, colours } = at;
  const r = Math.min(GROUND - 2, Math.max(5, toX(at, x + radius) - toX(at, x)));
  for (const [part, colour] of /** @type {[number, string][]} */ ([
    [1, colours.truth],
    [0.66, colours.paper],
    [0.33, colours.snap],
  ])) {
    pen.beginPath();
    pen.arc(toX(at, x), toY(at, y), r * part, 0, 2 * Math.PI);
    pen.fillStyle = colour;
    pen.fill();
  }
  drawText(pen, colours, t('netgame.target'), toX(at, x), toY(at, y) - r - colours.text * 0.8, { align: 'center', colour: colours.faint });
}

/** @param {DrawContext} at @param {number} player */
function trail(at, player) {
  const points = at.memory.trails[at.view]?.[player] ?? [];
  const { pen, colours } = at;
  pen.beginPath();
  points.forEach((point, i) => {
    if (Number.isNaN(points[i - 1]?.x ?? NaN)) pen.moveTo(toX(at, point.x), toY(at, point.y));
    else pen.lineTo(toX(at, point.x), toY(at, point.y));
  });
  pen.strokeStyle = paintOf(colours, player).text;
  pen.lineWidth = Math.max(1, colours.line - 1);
  pen.setLineDash(paintOf(colours, player).dash);
  pen.stroke();
  pen.setLineDash([]);
}

/** @param {DrawContext} at */
function score(at) {
  const names = at.layout.game_values,
    entities = entitiesOf(at.frame, at.view);
  const away = (/** @type {number} */ p) => entities[p] !== undefined && isAway(entities[p]);
  at.layout.players.forEach((_, p) => {
    const values = gameOf(at.frame, p);
    const value = (/** @type {string} */ name) => values[names.indexOf(name)] ?? 0;
    const shots = value('shots');
    const name = at.layout.players[p]?.name ?? '';
    const text = [
      t('netgame.cannon.hits', { name, hits: fixed(value('hits'), 0), shots: fixed(shots, 0) }),
      shots > 0 ? t('netgame.cannon.last', { miss: signed(value('miss_m'), 1) }) : '',
      value('turn') ? t('netgame.cannon.turn') : '',
      away(p) ? t('netgame.away') : '',
    ]
      .filter((part) => part !== '')
      .join(' · ');
    drawText(at.pen, at.colours, text, at.width - BUTTON, at.colours.text * (2.2 + 1.4 * p), {
      align: 'right',
      colour: paintOf(at.colours, p).text,
    });
  });
}

/** @param {DrawContext} at @returns {import('./scene.js').Drawn[]} the dots */
export function drawCannon(at) {
  const { pen, colours, overlays } = at;
  const size = colours.marker * 0.8;
  const place = (/** @type {number} */ x, /** @type {number} */ y) => ({ x: toX(at, x), y: toY(at, y) });
  const { x_min, x_max } = at.layout.scene;
  backdrop(pen, at, ['cannon', x_min, x_max].join(' '), (on) => drawGrid({ ...at, pen: on }));
  ground(at);
  target(at);
  entitiesOf(at.frame, at.view).forEach((_, i) => trail(at, i));
  const drawn = overlays.dots ? dots(at, place, () => true) : [];
  const labels = new Labels(at);
  if (overlays.dots) labels.block(0, colours.text * 2.1, colours.text * 22, colours.text * 1.4); /* how many packets a dot is */
  const goal = place(at.layout.scene.target_x, at.layout.scene.target_y);
  labels.block(goal.x, goal.y - GROUND, 48, 2 * GROUND + colours.text);
  entitiesOf(at.frame, at.view).forEach((shell, i) => {
    const real = entitiesOf(at.frame, 0)[i];
    const flying = (shell.flags & E_ACTIVE) !== 0,
      reallyFlying = real !== undefined && (real.flags & E_ACTIVE) !== 0;
    const { x, y } = place(shell.x, shell.y);
    if (at.view > 0 && overlays.ghosts && real && reallyFlying) {
      const g = place(real.x, real.y);
      ghost(at, i, flying ? x : g.x, flying ? y : g.y, g.x, g.y, size);
      if (flying && overlays.labels) {
        const text = `${t('netgame.shell', { name: letter(i) })} · ${gapLabel(at, shell, real)}`;
        labels.put(text, Math.min(x, g.x) - size / 2, Math.max(x, g.x) + size * 0.65, (y + g.y) / 2, size, { colour: colours.faint });
      }
    } else if (flying && overlays.labels) {
      labels.put(t('netgame.shell', { name: letter(i) }), x - size / 2, x + size * 0.65, y, size, { colour: colours.faint });
    }
    pen.globalAlpha = isAway(shell) ? FADED : 1;
    if (flying || (at.memory.trails[at.view]?.[i]?.length ?? 0) > 0) drawMark(pen, colours, i, x, y, size);
    pen.globalAlpha = 1;
    if (at.view > 0 && at.view !== 1 + i && isAway(shell)) {
      drawText(pen, colours, t('netgame.is_away', { name: letter(i) }), 8, colours.text * (2.2 + 1.4 * i), {
        colour: colours.snap,
        bold: true,
      });
    }
  });
  if (at.view === 0 && overlays.labels) score(at);
  reportBodies(at, ({ y }) => toY(at, y));
  tellDot(at, drawn);
  return drawn;
}
