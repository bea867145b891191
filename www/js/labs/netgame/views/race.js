// One view of a race (or of the demo's rule): cars on lanes along the common x axis.
import { E_FINISHED, entitiesOf, gameOf } from '../core/frame.js';
import { paintOf } from '../../../draw/palette.js';
import { fixed, letter } from '../../../base/format.js';
import { FADED, isAway } from './connection.js';
import { corrections, correctionWords, dots, drawGrid, gapLabel, ghost, scaleX, tellDot, toX } from './scene.js';
import { Labels } from './labels.js';
import { HIGH, LONG, drawCar, hasCar } from '../../../draw/cars.js';
import { backdrop } from '../../../draw/backdrop.js';
import { drawMark, drawText } from '../../../draw/marks.js';
import { drawBand, drawPosts, place as tell } from '../../../draw/shown.js';
import { t } from '../../../base/words.js';

/** @typedef {import('./scene.js').DrawContext} DrawContext */

/** The part of a lap. @param {DrawContext} at @param {number} x m @returns {number} */
function onLap(at, x) {
  const { wraps, x_max: lap } = at.layout.scene;
  return wraps ? x - Math.floor(x / lap) * lap : x;
}

/** Of the frame that is drawn. @type {{frame: unknown, list: number[]}} */
let levels = { frame: null, list: [] };
/** The lanes in use, from top to bottom. @param {DrawContext} at @returns {number[]} m */
function levelsOf({ frame, only }) {
  if (levels.frame !== frame) {
    const own = entitiesOf(frame, 0).filter((_, i) => only?.includes(i) ?? true);
    levels = { frame, list: [...new Set(own.map((e) => e.y))].sort((a, b) => a - b) };
  }
  return levels.list;
}

/** Height of a lane. @param {DrawContext} at @returns {number} px */
function laneHeight(at) {
  return (at.height - at.colours.text * 1.3) / Math.max(1, levelsOf(at).length);
}

/** @param {DrawContext} at @param {number} y m @returns {number} px; lane 0 lies on top */
function toY(at, y) {
  const list = levelsOf(at);
  const low = list[0] ?? 0,
    step = list.length > 1 ? ((list[list.length - 1] ?? 1) - low) / (list.length - 1) : 1;
  return at.colours.text * 1.3 + ((y - low) / step + 0.5) * laneHeight(at);
}

/** Where the finish is, in the lap that ends the race. @param {DrawContext} at @returns {number | null} px */
function finishX(at) {
  const { finish_m: finish, x_max: lap, wraps } = at.layout.scene;
  const furthest = Math.max(...entitiesOf(at.frame, at.view).map((e) => e.x));
  if (!(finish > 0) || (wraps && furthest < finish - lap)) return null;
  const rest = wraps ? finish - Math.floor(finish / lap) * lap : finish;
  return toX(at, rest === 0 ? lap : rest);
}

/** The chequered line. @param {DrawContext} at @param {number} x px */
function finishLine(at, x) {
  const { pen, colours } = at;
  for (let row = 0; row * 6 < at.height; row++) {
    for (let column = 0; column < 2; column++) {
      pen.fillStyle = (row + column) % 2 === 0 ? colours.truth : colours.paper;
      pen.fillRect(x - 6 + column * 6, row * 6, 6, 6);
    }
  }
}

/** @param {DrawContext} at */
function lanes(at) {
  const { pen, colours } = at;
  pen.strokeStyle = colours.grid;
  pen.lineWidth = 1;
  pen.setLineDash([8, 8]);
  const list = levelsOf(at);
  for (let i = 1; i < list.length; i++) {
    const y = Math.round(toY(at, ((list[i - 1] ?? 0) + (list[i] ?? 0)) / 2)) + 0.5;
    pen.beginPath();
    pen.moveTo(0, y);
    pen.lineTo(at.width, y);
    pen.stroke();
  }
  pen.setLineDash([]);
}

/** @param {DrawContext} at @param {number} player @returns {string} */
function standing(at, player) {
  const names = at.layout.game_values;
  const values = gameOf(at.frame, player);
  if (!values) return '';
  const value = (/** @type {string} */ name) => values[names.indexOf(name)];
  const finish = value('finish_s'),
    place = value('place'),
    laps = value('laps'),
    speed = value('speed_mps');
  const parts = [];
  if (place !== undefined) parts.push(finish ? t('netgame.finished', { place, time: fixed(finish, 2) }) : t('netgame.place', { place }));
  if (laps !== undefined && !finish) parts.push(t('netgame.lap', { n: laps + 1 }));
  if (speed !== undefined) parts.push(`${fixed(speed, 1)} m/s`);
  return parts.join(' · ');
}

/** Reports where the cars of a view are: `A` as it is drawn, `A.truth` where the server has it now; in the server's view `A.seen` as A's
 * own screen draws it.
 * @param {DrawContext} at @param {(x: number, y: number) => {x: number, y: number}} place */
function tellPlaces(at, place) {
  const { canvas } = at.pen;
  entitiesOf(at.frame, at.view).forEach((car, i) => {
    const here = place(car.x, car.y);
    tell(canvas, letter(i), here.x, here.y, car.x);
    const other = at.view > 0 ? entitiesOf(at.frame, 0)[i] : entitiesOf(at.frame, 1 + i)[i];
    if (other) tell(canvas, `${letter(i)}.${at.view > 0 ? 'truth' : 'seen'}`, here.x + (other.x - car.x) * scaleX(at), here.y, other.x);
  });
}

/** @param {DrawContext} at @returns {import('./scene.js').Drawn[]} the dots */
export function drawRace(at) {
  const { pen, colours, overlays } = at;
  const lap = at.layout.scene.x_max;
  const full = Math.max(colours.marker, Math.min(at.layout.scene.entity_length_m * scaleX(at), at.height / 3.2));
  const size = Math.min(full, Math.max(15, laneHeight(at) * 0.8));
  const place = (/** @type {number} */ x, /** @type {number} */ y) => ({ x: toX(at, onLap(at, x)), y: toY(at, y) });
  const labels = new Labels(at);
  /** @type {(() => void)[]} */
  const later = [];

  const finish = finishX(at),
    { x_min, x_max } = at.layout.scene;
  backdrop(pen, at, ['race', x_min, x_max, levelsOf(at), finish].join(' '), (on) => {
    const still = { ...at, pen: on };
    drawGrid(still);
    lanes(still);
    if (finish !== null) finishLine(still, finish);
  });
  /** @type {import('./scene.js').Drawn[]} */
  let drawn = [];
  if (overlays.dots) {
    drawn = dots(at, place, (dot) => {
      const car = entitiesOf(at.frame, at.view)[dot.entity];
      return car !== undefined && (!at.layout.scene.wraps || Math.abs(car.x - dot.x) < lap * 0.9);
    });
  }
  tellPlaces(at, place);
  drawBand(pen, colours);
  entitiesOf(at.frame, at.view).forEach((car, i) => {
    if (at.only?.includes(i) === false) return;
    const { x, y } = place(car.x, car.y);
    const real = entitiesOf(at.frame, 0)[i];
    const half = hasCar(i) ? (size * LONG) / HIGH / 2 : size * 0.6;
    labels.block(x, y, 2 * half, size);
    if (at.view > 0 && real) {
      const gx = x + (real.x - car.x) * scaleX(at),
        gy = toY(at, real.y);
      if (overlays.ghosts) {
        ghost(at, i, x, y, gx, gy, size);
        const turn = at.layout.scene.wraps ? lap * scaleX(at) : 0;
        if (turn > 0 && gx > at.width) ghost(at, i, gx - turn, gy, gx - turn, gy, size);
        if (turn > 0 && gx < 0) ghost(at, i, gx + turn, gy, gx + turn, gy, size);
        labels.block(gx, gy, 2 * half, size * 0.6);
        const put = () =>
          labels.put(gapLabel(at, car, real), Math.min(x, gx) - half, Math.max(x, gx) + half, y, size, {
            colour: colours.faint,
          });
        if (at.view === 1 + i) later.unshift(put);
        else later.push(put);
      }
      if (at.view === 1 + i) corrections(at, i, (cx, cy) => ({ x: x + (cx - car.x) * scaleX(at), y: toY(at, cy) }), size);
    }
    const away = isAway(car);
    if (away) pen.globalAlpha = FADED;
    if (hasCar(i)) drawCar(pen, colours, i, x, y, size);
    else drawMark(pen, colours, i, x, y, size);
    if (away) pen.globalAlpha = 1;
    if (away) labels.put(t('netgame.away'), x - half, x + half, y, size, { colour: colours.snap, bold: true });
    if (at.view === 0) {
      later.push(() =>
        labels.put(standing(at, i), x - half, x + half, y, size, {
          colour: paintOf(colours, i).text,
          bold: (car.flags & E_FINISHED) !== 0,
        }),
      );
    }
  });
  if (overlays.labels) for (const put of later) put();
  drawPosts(pen, colours);
  const words = at.view > 0 ? correctionWords(at, at.view - 1) : '';
  if (words !== '') {
    drawText(pen, colours, words, at.width - 8, at.height - colours.text * 0.8, { align: 'right', colour: colours.snap });
  }
  tellDot(at, drawn);
  return drawn;
}
