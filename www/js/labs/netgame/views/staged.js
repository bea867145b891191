// What a lesson adds to the road of a race: the key where it was pressed, a watch that runs until the car answers, where the car was at the
// key, marks of its tyres while it brakes, flags of the choices, and how far the server is ahead of a screen.
import { fixed, letter } from '../../../base/format.js';
import { t } from '../../../base/words.js';
import { HIGH, LONG, drawCar } from '../../../draw/cars.js';
import { drawText, widthOf } from '../../../draw/marks.js';
import { paintOf } from '../../../draw/palette.js';
import { place as report } from '../../../draw/shown.js';
import { entitiesOf } from '../core/frame.js';
import { scaleX, toX } from './scene.js';

/** @typedef {import('./scene.js').DrawContext} DrawContext */
/** @typedef {import('../../../session/state.js').Staged} Staged */
/** @typedef {import('../../../session/state.js').Recorded} Recorded */

/** Of the road of the one car: its middle and the car's height. @typedef {{y: number, size: number, top: number, bottom: number}} Road */

const SLOWER = 0.05; /* m/s in a tick: it brakes */

/** The first tick, from the key on, at which a view's car brakes; 0: none; -1: it may be one that the run lacks. The tick before is where
 * it begins, as the key is pressed in the tick before it counts. @param {Recorded} run @param {number} view @param {Staged} of */
function answered(run, view, { press, player }) {
  let before = Infinity,
    last = 0;
  for (const [tick, views] of run) {
    const now = views[view]?.[player]?.vx ?? Infinity;
    if (tick >= press && now < before - SLOWER) return tick === last + 1 ? tick : -1;
    before = now;
    last = tick;
  }
  return 0;
}

/** Of the car in a view: where it was when the key was pressed, and from where on it braked, m; NaN where that is not known yet.
 * @param {Recorded | null} run @param {number} view @param {Staged} of @param {number} tick of what is drawn */
function moments(run, view, of, tick) {
  const x = (/** @type {number} */ at) => run?.get(at)?.[view]?.[of.player]?.x ?? NaN;
  const answer = run === null || of.press === 0 ? 0 : answered(run, view, of);
  return {
    press: of.press > 0 && tick >= of.press - 1 ? x(of.press - 1) : NaN,
    brake: answer > 0 && tick >= answer - 1 ? x(answer - 1) : NaN,
    answer,
  };
}

/** The key, lit. @param {DrawContext} at @param {number} player @param {boolean} brake @param {number} x its right edge @param {number} y
 * its middle @param {number} size */
function drawKey({ pen, colours }, player, brake, x, y, size) {
  const w = size * 1.3;
  pen.setLineDash([]);
  pen.fillStyle = paintOf(colours, player).fill;
  pen.strokeStyle = colours.truth;
  pen.lineWidth = colours.line;
  pen.beginPath();
  pen.roundRect(x - w, y - size / 2, w, size, size / 4);
  pen.fill();
  pen.stroke();
  const way = brake ? -1 : 1,
    middle = x - w / 2,
    r = size * 0.28;
  pen.strokeStyle = colours.onFill;
  pen.lineWidth = Math.max(2.5, size / 11);
  pen.beginPath();
  pen.moveTo(middle - way * r, y);
  pen.lineTo(middle + way * r, y);
  pen.moveTo(middle + way * r * 0.2, y - r * 0.8);
  pen.lineTo(middle + way * r, y);
  pen.lineTo(middle + way * r * 0.2, y + r * 0.8);
  pen.stroke();
}

/** A watch and what it shows, in a yellow box: in front of the car, above the label of the band; where there is no room in front, above the
 * road; asked: nothing yet. @param {DrawContext} at @param {string} text @param {number} nose px @param {Road} road
 * @param {boolean} [asked] @returns {number} px, its right edge */
function drawWatch({ pen, colours, width }, text, nose, road, asked = false) {
  const big = { ...colours, text: colours.text * 1.5 },
    r = big.text * 0.5,
    w = widthOf(pen, big, text, true) + r * 2 + 26,
    ahead = nose + 14 + w < width - 4,
    h = ahead ? big.text * 1.9 : Math.min(big.text * 1.9, road.top - 4),
    left = ahead ? nose + 14 : width - w - 4,
    y = ahead ? Math.min(road.y, road.bottom - LABEL - colours.text * 0.85 - 4 - h / 2) : road.top / 2;
  pen.setLineDash(asked ? [7, 5] : []);
  pen.fillStyle = asked ? colours.paper : colours.mark;
  pen.strokeStyle = asked ? colours.accent : colours.markLine;
  pen.lineWidth = 2;
  pen.beginPath();
  pen.roundRect(left, y - h / 2, w, h, 8);
  pen.fill();
  pen.stroke();
  pen.setLineDash([]);
  const cx = left + 10 + r;
  pen.strokeStyle = colours.ink;
  pen.fillStyle = colours.paper;
  pen.beginPath();
  pen.arc(cx, y + 2, r, 0, 2 * Math.PI);
  pen.fill();
  pen.stroke();
  pen.beginPath();
  pen.moveTo(cx - 4, y - r - 2);
  pen.lineTo(cx + 4, y - r - 2);
  pen.moveTo(cx, y + 2);
  pen.lineTo(cx, y + 2 - r * 0.7);
  pen.moveTo(cx, y + 2);
  pen.lineTo(cx + r * 0.5, y + 2);
  pen.stroke();
  pen.font = `700 ${big.text}px ${colours.font}`;
  pen.textAlign = 'left';
  pen.textBaseline = 'middle';
  pen.fillStyle = asked ? colours.accent : colours.markText;
  pen.fillText(text, cx + r + 8, y + 1);
  return left + w;
}

/** Two rows of marks on the road. @param {DrawContext} at @param {number} from px @param {number} to @param {Road} road */
function drawTyres({ pen, colours }, from, to, { y, size }) {
  if (to - from < 3) return;
  pen.strokeStyle = colours.faint;
  pen.lineWidth = Math.max(3, size / 13);
  pen.setLineDash([9, 3]);
  pen.beginPath();
  for (const side of [-0.36, 0.36]) {
    pen.moveTo(from, y + side * size);
    pen.lineTo(to, y + side * size);
  }
  pen.stroke();
  pen.setLineDash([]);
}

/** @param {DrawContext} at @param {number} x px @param {string} text @param {Road} road @param {boolean} chosen */
function drawFlag({ pen, colours }, x, text, { top: edge, bottom }, chosen) {
  const top = Math.max(2, edge - colours.text * 1.9);
  const h = colours.text * 1.5,
    w = colours.text * 2;
  pen.strokeStyle = chosen ? colours.accent : colours.faint;
  pen.fillStyle = chosen ? colours.accent : colours.paper;
  pen.lineWidth = chosen ? 3 : 2;
  pen.setLineDash(chosen ? [] : [5, 4]);
  pen.beginPath();
  pen.moveTo(x, top);
  pen.lineTo(x, bottom);
  pen.stroke();
  pen.setLineDash([]);
  pen.beginPath();
  pen.moveTo(x, top);
  for (const [dx, dy] of /** @type {[number, number][]} */ ([
    [w, 0],
    [w * 0.7, h / 2],
    [w, h],
    [0, h],
  ]))
    pen.lineTo(x + dx, top + dy);
  pen.closePath();
  pen.fill();
  pen.stroke();
  pen.font = `700 ${colours.text}px ${colours.font}`;
  pen.textAlign = 'center';
  pen.textBaseline = 'middle';
  pen.fillStyle = chosen ? colours.paper : colours.ink;
  pen.fillText(text, x + w * 0.38, top + h / 2 + 1);
}

/** Where the flags stand: the car rolls on with its speed at the key. @param {DrawContext} at @param {Staged} of @returns {number[]} px */
export function flagsOf(at, of) {
  const own = of.first?.get(of.press - 1)?.[1 + of.player]?.[of.player];
  return own ? of.flags.map((ms) => toX(at, own.x + (own.vx * ms) / 1000)) : [];
}

/** As drawn last, where one can be chosen. @type {{canvas: HTMLCanvasElement | null, xs: number[]}} */
let standing = { canvas: null, xs: [] };
const NEAR = 24; /* px */

/** The flag at a place of a view. @param {HTMLCanvasElement} canvas @param {number} x px @returns {number} -1: none */
export function flagAt(canvas, x) {
  if (canvas !== standing.canvas) return -1;
  const nearest = standing.xs.reduce((best, at, i) => (Math.abs(at - x) < Math.abs((standing.xs[best] ?? Infinity) - x) ? i : best), -1);
  return Math.abs((standing.xs[nearest] ?? Infinity) - x) < NEAR ? nearest : -1;
}

const FADED = 0.42;
/** The label of the band: its middle above the road's lower edge, px. */
export const LABEL = 12;

/** Reports where the car was when the key was pressed, and from where on it braked. @param {DrawContext} at @param {Staged} of
 * @param {Recorded | null} run @param {number} y px */
export function reportMoments(at, of, run, y) {
  const { press, brake } = moments(run, at.view, of, at.frame.tick),
    name = letter(of.player);
  if (Number.isFinite(press)) report(at.pen.canvas, `${name}.press`, toX(at, press), y, press);
  if (Number.isFinite(brake)) report(at.pen.canvas, `${name}.brake`, toX(at, brake), y, brake);
}

/** What lies on the road, below the cars. @param {DrawContext} at @param {Staged} of @param {Recorded | null} run @param {Road} road */
export function drawUnder(at, of, run, road) {
  const { pen, colours, frame, view } = at;
  const here = entitiesOf(frame, view)[of.player];
  if (!here || !run) return;
  const { press, brake } = moments(run, view, of, frame.tick),
    long = (road.size * LONG) / HIGH;
  if (Number.isFinite(brake)) drawTyres(at, toX(at, brake), toX(at, here.x) - long * 0.75, road);
  if (view > 0 && Number.isFinite(press) && Math.abs(here.x - press) * scaleX(at) > 8 && frame.tick >= of.press) {
    pen.globalAlpha = FADED;
    drawCar(pen, colours, of.player, toX(at, press) - long / 2, road.y, road.size);
    pen.globalAlpha = 1;
  }
}

/** What stands over the cars: flags, key, watch, words. @param {DrawContext} at @param {Staged} of @param {Recorded | null} run
 * @param {Road} road */
export function drawOver(at, of, run, road) {
  const { pen, colours, frame, view } = at;
  const here = entitiesOf(frame, view)[of.player];
  if (!here || of.press === 0 || !run) return;
  const { press, answer } = moments(run, view, of, frame.tick),
    hz = frame.time_s > 0 ? frame.tick / frame.time_s : 60;
  const nose = toX(at, here.x),
    size = Math.min(road.top - 4, colours.text * 2.6);
  if (view === 0) {
    const seen = entitiesOf(frame, 1 + of.player)[of.player],
      apart = seen ? here.x - seen.x : 0;
    const words =
      answer > 0 && frame.tick >= answer
        ? t('netgame.staged.brakes')
        : frame.tick < of.press || answer < 0
          ? ''
          : t('netgame.staged.knows');
    const right = nose + 10 + widthOf(pen, colours, words, true) < at.width,
      rear = nose - (road.size * LONG) / HIGH - 10;
    drawText(pen, colours, words, right ? nose + 10 : rear, road.y - road.size * 0.2, { bold: true, align: right ? 'left' : 'right' });
    if (of.step < 3 || !seen || Math.abs(apart) * scaleX(at) < 16) return;
    const from = toX(at, seen.x),
      y = road.y + road.size * 0.42;
    pen.strokeStyle = colours.ink;
    pen.lineWidth = colours.line;
    pen.setLineDash([4, 4]);
    pen.beginPath();
    pen.moveTo(from, road.top);
    pen.lineTo(from, road.bottom);
    pen.stroke();
    pen.setLineDash([]);
    pen.beginPath();
    pen.moveTo(from, y);
    pen.lineTo(nose, y);
    for (const [x, way] of /** @type {[number, number][]} */ ([
      [from, Math.sign(nose - from)],
      [nose, Math.sign(from - nose)],
    ])) {
      pen.moveTo(x + way * 7, y - 5);
      pen.lineTo(x, y);
      pen.lineTo(x + way * 7, y + 5);
    }
    pen.stroke();
    const left = Math.max(from, nose) + 10,
      m = { m: fixed(Math.abs(apart), 1) },
      way = `netgame.staged.${apart > 0 ? 'ahead' : 'behind'}`;
    const whole = left + widthOf(pen, colours, t(way, m), true) < at.width;
    drawText(pen, colours, t(whole ? way : `${way}.short`, m), left, y, { bold: true });
    return;
  }
  const flags = flagsOf(at, of),
    below = road.bottom - LABEL - colours.text * 0.9; /* there stands what the sentence is about */
  standing = { canvas: of.step === 1 ? pen.canvas : null, xs: flags };
  if (of.step === 1) {
    flags.forEach((x, i) => drawFlag(at, x, String(i + 1), road, i === of.chosen));
    const left = (flags.at(-1) ?? nose) + 14,
      words = t('netgame.staged.where');
    if (left + widthOf(pen, colours, words, true) + colours.text * 2 < at.width)
      drawText(pen, colours, words, left + colours.text * 2, road.top / 2 + 1, { bold: true, colour: colours.accent });
    if (left < at.width * 0.75) drawWatch(at, '? ms', left - 14, road, true);
  } else if (of.step < 5 && flags[of.chosen] !== undefined)
    drawFlag(at, flags[of.chosen] ?? 0, String(of.chosen + 1), { ...road, bottom: below }, true);
  if (!Number.isFinite(press)) return;
  const edge = toX(at, press) - 6,
    level = road.top / 2 + 1;
  drawKey(at, of.player, of.brake, edge, level, size);
  if (of.step === 1) {
    const words = t(`netgame.staged.press.${of.brake ? 'back' : 'ahead'}`);
    if (edge - size * 1.4 - widthOf(pen, colours, words, true) > 4)
      drawText(pen, colours, words, edge - size * 1.3 - 10, level, { align: 'right', bold: true });
    return;
  }
  if (answer < 0 || (answer === 0 && !run.has(frame.tick))) return; /* the run ended before that */
  const since = Math.max(0, Math.min(frame.tick + 1, answer > 0 ? answer : Infinity) - of.press);
  const right = drawWatch(at, `${fixed((since / hz) * 1000, 0)} ms`, nose, road);
  if (since > 0 || answer === 0) return;
  const words = t('netgame.staged.at_once'),
    wide = widthOf(pen, colours, words, true);
  if (right > nose && right + 12 + wide < at.width)
    drawText(pen, colours, words, right + 12, road.y, { bold: true, colour: colours.markText });
  else if (edge - size * 1.4 - wide > 4) drawText(pen, colours, words, edge - size * 1.3 - 8, level, { align: 'right', bold: true });
}
