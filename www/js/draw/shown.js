// What a sentence is about, seen in a drawing: drawings report places by name, and the yellow band between two of them, its posts and its
// label are drawn from these very places. Tests read them, so that sentence, drawing and test have one source.
import { signal } from '../../vendor/signals-core.js';
import { widthOf } from './marks.js';

/** CSS px in its view; value: the quantity there, in the unit of the drawing's axis, where it has one
 * @typedef {{x: number, y: number, value: number}} Place */
/** view: the drawing; from, to: names of places in it; along: in which direction they are apart, "line": both
 * @typedef {{view: string, from: string, to: string, along?: 'x' | 'y' | 'line', label: string}} Shows */
/** @typedef {import('./palette.js').Palette} Palette */

/** What the sentence that is shown is about. @type {import('@preact/signals-core').Signal<Shows | null>} */
export const shows = signal(null);

/** By view, with its size. @type {Map<string, {canvas: HTMLCanvasElement, width: number, height: number, places: Map<string, Place>}>} */
const told = new Map();

/** What a drawing is called: `server`, `player_0` and so on for the views of a netgame, else its id. @param {HTMLCanvasElement} canvas */
function nameOf({ dataset: { view }, id }) {
  if (view === undefined) return id;
  return view === '0' ? 'server' : `player_${Number(view) - 1}`;
}

/** A drawing begins again: nothing of it is known. @param {HTMLCanvasElement} canvas @param {number} width CSS px @param {number} height */
export function begin(canvas, width, height) {
  if (told.get(nameOf(canvas))?.canvas !== canvas) for (const [name, { canvas: of }] of told) if (!of.isConnected) told.delete(name);
  told.set(nameOf(canvas), { canvas, width, height, places: new Map() });
}

/** Reports where something is drawn. @param {HTMLCanvasElement} canvas @param {string} name @param {number} x CSS px @param {number} y
 * @param {number} [value] in the unit of the drawing's axis */
export function place(canvas, name, x, y, value = NaN) {
  told.get(nameOf(canvas))?.places.set(name, { x, y, value });
}

/** The two places in a drawing; null where the sentence is about another one, or they are not known.
 * @param {HTMLCanvasElement} canvas @returns {{from: Place, to: Place, along: 'x' | 'y' | 'line', label: string} | null} */
function pairOf(canvas) {
  const now = shows.value,
    name = nameOf(canvas);
  if (now?.view !== name) return null;
  const places = told.get(name)?.places,
    from = places?.get(now.from),
    to = places?.get(now.to);
  return from && to ? { from, to, along: now.along ?? 'x', label: now.label } : null;
}

const WIDE = 2.5; /* posts, px */

/** Where the arrow of places is that are one above the other. @param {{width: number}} at @param {Place} from @param {Place} to */
const besides = (at, from, to) => Math.min(at.width - 14, Math.max(from.x, to.x) + 18);

/** The band alone, for what lies below the things that it compares. @param {CanvasRenderingContext2D} pen @param {Palette} colours */
export function drawBand(pen, colours) {
  const pair = pairOf(pen.canvas),
    at = told.get(nameOf(pen.canvas));
  if (!pair || !at || pair.along === 'line') return;
  const { from, to, along } = pair;
  pen.fillStyle = colours.mark;
  if (along === 'x') pen.fillRect(Math.min(from.x, to.x), 0, Math.abs(to.x - from.x), at.height);
  else pen.fillRect(besides(at, from, to) - 11, Math.min(from.y, to.y), 22, Math.abs(to.y - from.y));
}

/** @param {CanvasRenderingContext2D} pen @param {number} x @param {number} y @param {number} turn rad */
function head(pen, x, y, turn) {
  for (const way of [2.6, -2.6]) {
    pen.moveTo(x, y);
    pen.lineTo(x + 9 * Math.cos(turn + way), y + 9 * Math.sin(turn + way));
  }
}

/** The label in its box, next to the pair, inside of the drawing. @param {CanvasRenderingContext2D} pen @param {Palette} colours
 * @param {string} text @param {number} left @param {number} right @param {number} y @param {number} width @param {number} height */
function drawLabel(pen, colours, text, left, right, y, width, height) {
  const w = widthOf(pen, colours, text, true) + 14,
    h = colours.text * 1.7;
  const x =
    right + 8 + w < width - 4 ? right + 8 : left - 8 - w > 4 ? left - 8 - w : Math.max(4, Math.min(width - 4 - w, (left + right - w) / 2));
  const top = Math.max(2, Math.min(height - h - 2, y - h / 2));
  pen.fillStyle = colours.mark;
  pen.strokeStyle = colours.markLine;
  pen.lineWidth = 1.5;
  pen.setLineDash([]);
  pen.beginPath();
  pen.roundRect(x, top, w, h, 6);
  pen.fill();
  pen.stroke();
  pen.font = `700 ${colours.text}px ${colours.font}`;
  pen.textAlign = 'center';
  pen.textBaseline = 'middle';
  pen.fillStyle = colours.markText;
  pen.fillText(text, x + w / 2, top + h / 2 + 1);
}

/** Where something was that is now elsewhere, and that the sentence is about: a name that ends in `.before` or `.first`.
 * @param {HTMLCanvasElement} canvas @returns {{x: number, y: number, name: string} | null} */
export function was(canvas) {
  const pair = pairOf(canvas),
    now = shows.value;
  if (!pair || !now) return null;
  const end = /\.(before|first)$/.test(now.from) ? 'from' : /\.(before|first)$/.test(now.to) ? 'to' : null;
  return end === null ? null : { x: pair[end].x, y: pair[end].y, name: now[end] };
}

/** Posts, arrow and label over what is drawn. @param {CanvasRenderingContext2D} pen @param {Palette} colours
 * @param {number} [level] of the arrow, where that is not the drawing's lower edge */
export function drawPosts(pen, colours, level) {
  const pair = pairOf(pen.canvas),
    at = told.get(nameOf(pen.canvas));
  if (!pair || !at) return;
  const { from, to, along, label } = pair;
  pen.strokeStyle = colours.markLine;
  pen.setLineDash([]);
  pen.lineWidth = WIDE;
  const y = level ?? at.height - 14,
    x = level ?? besides(at, from, to);
  const [a, b] =
    along === 'x'
      ? [
          { x: from.x, y },
          { x: to.x, y },
        ]
      : along === 'y'
        ? [
            { x, y: from.y },
            { x, y: to.y },
          ]
        : [from, to];
  const turn = Math.atan2(b.y - a.y, b.x - a.x);
  pen.beginPath();
  for (const end of [a, b]) {
    const near = end === a ? from : to;
    if (along === 'x') {
      pen.moveTo(end.x, 0);
      pen.lineTo(end.x, at.height);
    } else if (along === 'y') {
      pen.moveTo(Math.min(near.x - 12, end.x - 6), end.y);
      pen.lineTo(Math.max(near.x + 12, end.x + 6), end.y);
    } else {
      pen.moveTo(end.x - 10 * Math.sin(turn), end.y + 10 * Math.cos(turn));
      pen.lineTo(end.x + 10 * Math.sin(turn), end.y - 10 * Math.cos(turn));
    }
  }
  pen.moveTo(a.x, a.y);
  pen.lineTo(b.x, b.y);
  if (Math.hypot(b.x - a.x, b.y - a.y) > 16) {
    head(pen, a.x, a.y, turn + Math.PI);
    head(pen, b.x, b.y, turn);
  }
  pen.stroke();
  if (label === '') return;
  const middle = along === 'x' ? y : (a.y + b.y) / 2;
  drawLabel(pen, colours, label, Math.min(a.x, b.x), Math.max(a.x, b.x), middle, at.width, at.height);
}

/** All of it, where the drawing lets what lies below it shine through. @param {CanvasRenderingContext2D} pen @param {Palette} colours
 * @param {number} [level] */
export function drawShown(pen, colours, level) {
  if (shows.value === null) return;
  pen.save();
  pen.globalCompositeOperation = 'destination-over';
  drawBand(pen, colours);
  pen.restore();
  drawPosts(pen, colours, level);
}

/** What the sentence is about, as it was drawn: how far apart, in px and in hundredths of the view; null where it is not. */
export function shown() {
  const now = shows.value,
    at = now === null ? undefined : told.get(now.view),
    pair = at === undefined ? null : pairOf(at.canvas);
  if (now === null || at === undefined || pair === null || !at.canvas.isConnected) return null;
  const { from, to, along, label } = pair,
    dx = Math.abs(to.x - from.x),
    dy = Math.abs(to.y - from.y);
  const px = along === 'x' ? dx : along === 'y' ? dy : Math.hypot(dx, dy);
  const inside = [from, to].every(({ x, y }) => x >= -1 && x <= at.width + 1 && y >= -1 && y <= at.height + 1);
  const box = at.canvas.getBoundingClientRect();
  return {
    ...now,
    label,
    px,
    percent: (100 * px) / (along === 'y' ? at.height : at.width),
    inside,
    seen: box.width > 0 && Math.abs(box.width - at.width) < 4 && Math.abs(box.height - at.height) < 4 /* else drawn at another size */,
    value: Math.abs(to.value - from.value),
    names: [...at.places.keys()],
  };
}
