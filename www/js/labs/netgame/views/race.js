// One view of a race (or of the demo's rule): cars on lanes along the common x axis.
import { E_FINISHED, entitiesOf, gameOf } from '../core/frame.js';
import { paintOf } from '../../../draw/palette.js';
import { fixed, localized } from '../../../base/format.js';
import { FADED, isAway } from './connection.js';
import { corrections, correctionWords, dots, drawGrid, gapLabel, ghost, reportBodies, scaleX, tellDot, toX } from './scene.js';
import { Labels } from './labels.js';
import { LABEL, drawOver, drawUnder, reportMoments } from './staged.js';
import { HIGH, LONG, drawCar, hasCar } from '../../../draw/cars.js';
import { gridStep } from '../../../draw/axis.js';
import { backdrop } from '../../../draw/backdrop.js';
import { drawMark, drawText } from '../../../draw/marks.js';
import { drawBand, drawPosts, was } from '../../../draw/shown.js';
import { t } from '../../../base/words.js';

/** @typedef {import('./scene.js').DrawContext} DrawContext */

/** The part of a lap. @param {DrawContext} at @param {number} x m @returns {number} */
export function onLap(at, x) {
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

/** Above the lanes. @param {DrawContext} at @returns {number} px */
const topOf = ({ staged, colours, view }) => (staged === null ? colours.text * 1.3 : staged.press > 0 && view > 0 ? colours.text * 2.6 : 4);

/** Height of a lane. @param {DrawContext} at @returns {number} px */
function laneHeight(at) {
  return (at.height - topOf(at) - (at.staged === null ? 0 : at.colours.axis * 1.7)) / Math.max(1, levelsOf(at).length);
}

/** @param {DrawContext} at @param {number} y m @returns {number} px; lane 0 lies on top */
export function toY(at, y) {
  const list = levelsOf(at);
  const low = list[0] ?? 0,
    step = list.length > 1 ? ((list[list.length - 1] ?? 1) - low) / (list.length - 1) : 1;
  return topOf(at) + ((y - low) / step + 0.5) * laneHeight(at);
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

/** The road close by, with metres below it. @param {DrawContext} at */
function drawRoad(at) {
  const { pen, colours, layout, width } = at;
  const top = topOf(at),
    bottom = top + laneHeight(at) * levelsOf(at).length;
  pen.fillStyle = colours.verge;
  pen.fillRect(0, 0, width, at.height);
  pen.fillStyle = colours.road;
  pen.fillRect(0, top, width, bottom - top);
  pen.fillStyle = colours.roadMarks;
  for (const y of [top, bottom - 2]) pen.fillRect(0, y, width, 2);
  const step = gridStep(scaleX(at), Math.max(90, colours.axis * 6));
  for (let i = Math.ceil(layout.scene.x_min / step); i * step <= layout.scene.x_max; i++) {
    if (i < 0) continue;
    const x = Math.round(toX(at, i * step));
    pen.fillStyle = colours.faint;
    pen.fillRect(x, bottom, 1, 5);
    const words = localized(`${Number((i * step).toPrecision(6))} m`),
      edge = colours.axis * 0.32 * words.length; /* at both ends it stays whole */
    drawText(pen, colours, words, Math.max(edge, Math.min(width - edge, x)), bottom + colours.axis, {
      size: colours.axis,
      colour: colours.faint,
      align: 'center',
    });
  }
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

/** @param {DrawContext} at @returns {import('./scene.js').Drawn[]} the dots */
export function drawRace(at) {
  const { pen, colours, overlays } = at;
  const lap = at.layout.scene.x_max;
  const full = Math.max(colours.marker, Math.min(at.layout.scene.entity_length_m * scaleX(at), at.height / 3.2));
  const true_ = (at.layout.scene.entity_length_m * scaleX(at) * HIGH) / LONG; /* to scale */
  const size =
    at.staged === null ? Math.min(full, Math.max(15, laneHeight(at) * 0.8)) : Math.max(12, Math.min(true_, laneHeight(at) * 0.8));
  const place = (/** @type {number} */ x, /** @type {number} */ y) => ({ x: toX(at, onLap(at, x)), y: toY(at, y) });
  const labels = new Labels(at);
  /** @type {(() => void)[]} */
  const later = [];

  const finish = finishX(at),
    { x_min, x_max } = at.layout.scene;
  backdrop(pen, at, ['race', x_min, x_max, levelsOf(at), finish, at.staged !== null].join(' '), (on) => {
    const still = { ...at, pen: on };
    if (at.staged) drawRoad(still);
    else drawGrid(still);
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
  reportBodies(at, (body) => toY(at, body.y));
  const { staged } = at;
  const top = topOf(at),
    road = {
      y: toY(at, entitiesOf(at.frame, 0)[staged?.player ?? 0]?.y ?? 0),
      size,
      top,
      bottom: top + laneHeight(at) * levelsOf(at).length,
    };
  if (staged) reportMoments(at, staged, at.run, road.y);
  drawBand(pen, colours);
  if (staged) drawUnder(at, staged, at.run, road);
  const past = was(pen.canvas);
  if (past && staged) {
    const i = past.name.charCodeAt(0) - 'A'.charCodeAt(0);
    pen.globalAlpha = FADED;
    if (hasCar(i)) drawCar(pen, colours, i, past.x - (size * LONG) / HIGH / 2, past.y, size);
    pen.globalAlpha = 1;
  }
  entitiesOf(at.frame, at.view).forEach((car, i) => {
    if (at.only?.includes(i) === false) return;
    const { x, y } = place(car.x, car.y);
    const real = entitiesOf(at.frame, 0)[i];
    const half = hasCar(i) ? (size * LONG) / HIGH / 2 : size * 0.6;
    const middle = at.staged === null ? x : x - half; /* a car close by has its place at its nose */
    labels.block(middle, y, 2 * half, size);
    if (at.view > 0 && real) {
      const gx = x + (real.x - car.x) * scaleX(at),
        gy = toY(at, real.y);
      if (overlays.ghosts && at.staged) {
        if (at.staged.press === 0) ghost(at, i, middle, y, gx - half, gy, size);
      } else if (overlays.ghosts) {
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
    if (at.faded) pen.globalAlpha = 0.5;
    if (hasCar(i)) drawCar(pen, colours, i, middle, y, size);
    else drawMark(pen, colours, i, x, y, size);
    if (away || at.faded) pen.globalAlpha = 1;
    if (away) labels.put(t('netgame.away'), x - half, x + half, y, size, { colour: colours.snap, bold: true });
    if (at.view === 0 && staged === null) {
      later.push(() =>
        labels.put(standing(at, i), x - half, x + half, y, size, {
          colour: paintOf(colours, i).text,
          bold: (car.flags & E_FINISHED) !== 0,
        }),
      );
    }
  });
  if (overlays.labels) for (const put of later) put();
  drawPosts(pen, colours, at.staged === null ? undefined : road.bottom - LABEL);
  if (staged) drawOver(at, staged, at.run, road);
  const words = at.view > 0 && (staged === null || staged.press === 0) ? correctionWords(at, at.view - 1) : '';
  if (words !== '') {
    drawText(pen, colours, words, at.width - 8, at.height - colours.text * 0.8, { align: 'right', colour: colours.snap });
  }
  tellDot(at, drawn);
  return drawn;
}
