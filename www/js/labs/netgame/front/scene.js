// The two views of the race on the first page: what the person sees and what the server knows, with one camera, so that columns of
// metres can be compared.
import { gridStep } from '../../../draw/axis.js';
import { HIGH, LONG, drawCar, drawCarGhost } from '../../../draw/cars.js';
import { drawText, widthOf } from '../../../draw/marks.js';
import { paintOf, palette } from '../../../draw/palette.js';
import { drawBand, drawPosts, place, shows } from '../../../draw/shown.js';
import { fixed, localized } from '../../../base/format.js';
import { t } from '../../../base/words.js';
import { surfaceOf } from '../../../workbench/canvas.js';
import { entitiesOf } from '../core/frame.js';
import { APART_M } from './opponent.js';
import { START } from './start.js';

/** @typedef {import('../../../stream/frame.js').Frame} Frame */
/** @typedef {import('../../../draw/palette.js').Palette} Palette */
/** @typedef {{left: number, wide: number}} Camera  m */
/** pen and sizes of one view; toX: of metres, px; half: of a car, px
 * @typedef {{pen: CanvasRenderingContext2D, canvas: HTMLCanvasElement, colours: Palette, width: number, height: number, top: number,
 *   lane: number, size: number, half: number, view: number, frame: Frame, camera: Camera, toX: (x: number) => number}} Scene */

const CAR_M = 4,
  PX_PER_M = 30,
  LEAST_M = 14,
  MOST_M = 30; /* so that 2 m are 40 px on a phone too */
const TOP_MPS = Number(START.set['params.top_speed_mps']),
  TICK_S = 0.05; /* more than a packet needs: the server's steps */
const GAP_PX = 48; /* of the gap at top speed: it is to be seen */
const FOLLOW_S = 0.2; /* how far the camera is behind: a car that starts is seen to move */
const BEHIND = 0.24,
  BEHIND_LEAD = 0.44; /* of the width, where the own car stands at rest */
const FAR_PX = 12; /* a ghost that is nearer says nothing */
const TRAIL_S = 0.75,
  DOT_S = 0.12;

let follows = { x: 0, wide: MOST_M, behind: BEHIND, time: -1, generation: -1 };
/** Where cars were: of view 0 and 1, at equal times. @type {{t: number, xs: number[][]}[]} */
let past = [];
/** @type {Frame | null} */
let last = null;

/** What was seen of another session. */
export function forget() {
  follows = { x: 0, wide: MOST_M, behind: BEHIND, time: -1, generation: -1 };
  past = [];
  last = null;
}

/** Each frame that comes, drawn or not: trails need all. @param {Frame} frame */
export function remember(frame) {
  const xs = [0, 1].map((view) => entitiesOf(frame, view).map((e) => e.x));
  if (last !== null && (frame.session.generation !== last.session.generation || frame.time_s < last.time_s)) forget();
  const before = last;
  last = frame;
  if (before === null) return;
  const old = [0, 1].map((view) => entitiesOf(before, view).map((e) => e.x));
  const span = frame.time_s - before.time_s;
  for (let k = Math.floor(before.time_s / DOT_S) + 1; k * DOT_S <= frame.time_s && span < 2 * DOT_S; k++) {
    const part = (k * DOT_S - before.time_s) / span;
    past.push({ t: k * DOT_S, xs: xs.map((list, v) => list.map((x, i) => (old[v]?.[i] ?? x) * (1 - part) + x * part)) });
  }
  while ((past[0]?.t ?? frame.time_s) < frame.time_s - TRAIL_S) past.shift();
}

/** Of all views of a frame: as near as the gap of this lag wants, and as far as it wants room. @param {Frame} frame
 * @param {number} width px @param {number} lag ms
 * @param {boolean} leads whether the own car is ahead of the truth, which is to be seen too: then the other is older still
 * @returns {Camera} */
export function cameraOf(frame, width, lag, leads) {
  const own = entitiesOf(frame, 1)[0]?.x ?? 0,
    way = TOP_MPS * (lag / 1000 + TICK_S) /* that is driven while a packet is on its way */,
    back = leads ? 2 * way + APART_M + CAR_M : 0 /* where the other is drawn at most */,
    near = Math.max(LEAST_M, (width * way) / GAP_PX),
    wide = Math.max(Math.min(MOST_M, width / PX_PER_M, near), LEAST_M, CAR_M + 2.6 * way, back + 2 * CAR_M);
  const jumped = frame.session.generation !== follows.generation || frame.time_s < follows.time;
  const part = jumped ? 1 : 1 - Math.exp((follows.time - frame.time_s) / FOLLOW_S);
  const behind = leads ? Math.max(BEHIND_LEAD, back / wide) : BEHIND;
  follows = {
    x: follows.x + (own - follows.x) * part,
    wide: follows.wide + (wide - follows.wide) * part,
    behind: follows.behind + (behind - follows.behind) * part,
    time: frame.time_s,
    generation: frame.session.generation,
  };
  return { left: follows.x - follows.wide * follows.behind, wide: follows.wide };
}

/** @param {Scene} of */
function road({ pen, colours, width, height, top, lane, size, camera, toX, view }) {
  const bottom = top + 2 * lane;
  pen.fillStyle = colours.verge;
  pen.fillRect(0, 0, width, height);
  pen.fillStyle = colours.road;
  pen.fillRect(0, top, width, 2 * lane);
  pen.fillStyle = colours.roadMarks;
  pen.fillRect(0, top, width, 3);
  pen.fillRect(0, bottom - 3, width, 3);
  for (let k = Math.floor(camera.left / 2); k * 2 < camera.left + camera.wide; k++) {
    const x = toX(k * 2);
    pen.fillRect(x, top + lane - 1.5, toX(k * 2 + 1) - x, 3);
  }
  if (view === 0) return;
  const step = gridStep(width / camera.wide, 90);
  const first = Math.max(0, Math.ceil((camera.left + (16 * camera.wide) / width) / step)); /* its number has room */
  for (let k = first; k * step < camera.left + camera.wide; k++) {
    const x = toX(k * step),
      text = `${localized(String(k * step))}${k === first ? ' m' : ''}`;
    pen.fillStyle = colours.edge;
    pen.fillRect(x - 0.5, bottom, 1, size * 0.12);
    if (x < width - 24)
      drawText(pen, { ...colours, paper: colours.verge }, text, x, bottom + size * 0.12 + colours.axis * 0.7, {
        size: colours.axis,
        align: 'center',
        colour: colours.faint,
      });
  }
}

/** @param {Scene} of @param {number} i player @param {number} x px, of the car @param {number} y */
function trail({ pen, colours, size, half, toX, view, frame }, i, x, y) {
  for (const { t: time, xs } of past) {
    const at = toX(xs[view]?.[i] ?? 0);
    if (at > x - half - 6) continue;
    pen.globalAlpha = Math.max(0, 1 - (frame.time_s - time) / TRAIL_S) * 0.8;
    pen.fillStyle = paintOf(colours, i).fill;
    pen.beginPath();
    if (i === 0) pen.arc(at, y, size * 0.09, 0, 2 * Math.PI);
    else {
      pen.moveTo(at - size * 0.1, y - size * 0.1);
      pen.lineTo(at + size * 0.12, y);
      pen.lineTo(at - size * 0.1, y + size * 0.1);
    }
    pen.fill();
  }
  pen.globalAlpha = 1;
}

/** A word next to a car, where there is room. @param {Scene} of @param {string} text @param {number} x px @param {number} y */
function beside({ pen, colours, width }, text, x, y) {
  if (x + widthOf(pen, colours, text) < width - 6) drawText(pen, { ...colours, paper: colours.road }, text, x, y, { colour: colours.ink });
}

/** B is too far behind to be seen: where. @param {Scene} of @param {number} gap m @param {number} y */
const away = ({ pen, colours }, gap, y) =>
  drawText(pen, { ...colours, paper: colours.road }, t('front.away', { m: fixed(gap, 0) }), 12, y, { colour: colours.ink });

/** @param {Scene} of @param {number} i @param {() => void} draw */
function inLane({ pen, width, top, lane }, i, draw) {
  pen.save();
  pen.beginPath();
  pen.rect(0, i === 0 ? 0 : top + lane, width, lane + (i === 0 ? top : 0));
  pen.clip();
  draw();
  pen.restore();
}

/** @param {HTMLCanvasElement} canvas @param {Frame} frame @param {Camera} camera @param {(wide: number) => void} report how wide it is */
export function drawScene(canvas, frame, camera, report) {
  const view = Number(canvas.dataset.view),
    surface = surfaceOf(canvas);
  const cars = entitiesOf(frame, view),
    truth = entitiesOf(frame, 0);
  if (cars.length < 2 || !surface.begin()) return;
  const colours = palette(),
    { pen, width, height } = surface,
    top = Math.round(height * 0.045),
    axis = view === 0 ? top : Math.round(colours.axis * 2.1),
    lane = (height - top - axis) / 2,
    scale = width / camera.wide;
  const size = Math.min((CAR_M * scale * HIGH) / LONG, lane * 0.84);
  /** @type {Scene} */
  const of = {
    pen,
    canvas,
    colours,
    width,
    height,
    top,
    lane,
    size,
    half: (size * LONG) / HIGH / 2,
    view,
    frame,
    camera,
    toX: (x) => (x - camera.left) * scale,
  };
  const rowOf = (/** @type {number} */ i) => top + lane * (i + 0.5);
  report(width);
  road(of);
  cars.forEach((car, i) => {
    place(canvas, `nose_${i}`, of.toX(car.x) + of.half, rowOf(i), car.x);
    place(canvas, `true_nose_${i}`, of.toX(truth[i]?.x ?? 0) + of.half, rowOf(i), truth[i]?.x);
  });
  const about = Number(shows.value?.from.at(-1) ?? 0); /* whose lane the sentence is about */
  inLane(of, about, () => drawBand(pen, colours));
  cars.forEach((car, i) => {
    const x = of.toX(car.x),
      y = rowOf(i),
      true_x = of.toX(truth[i]?.x ?? 0);
    if (i === 1 && x < -of.half) away(of, Math.round((cars[0]?.x ?? 0) - car.x), y);
    trail(of, i, x, y);
    if (view > 0) drawCarGhost(pen, colours, i, true_x, y, size);
    drawCar(pen, colours, i, x, y, size);
    if (view > 0 && i === 1 && about !== 1 && true_x - x > FAR_PX) beside(of, t('front.as_it_was'), Math.max(x, true_x) + of.half + 10, y);
  });
  inLane(of, about, () => drawPosts(pen, colours, rowOf(about)));
  if (view === 0) {
    const x = of.toX(cars[0]?.x ?? 0) + of.half;
    pen.strokeStyle = colours.markLine;
    pen.lineWidth = 2.5;
    pen.setLineDash([5, 4]);
    pen.beginPath();
    pen.moveTo(x, 0);
    pen.lineTo(x, top + lane);
    pen.stroke();
    pen.setLineDash([]);
    beside(of, t('front.truly'), x + 12, rowOf(0));
  }
}
