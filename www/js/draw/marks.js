// The players' marks differ in shape, letter and dash; colour only helps.
import { letter } from '../base/format.js';
import { paintOf } from './palette.js';
import { stamp } from './sprites.js';

/** @typedef {CanvasRenderingContext2D} Pen */
/** @typedef {import('./palette.js').Palette} Palette */

/** @param {Pen} pen @param {number} x @param {number} y @param {number} r @param {number} corners @param {number} turn */
function polygon(pen, x, y, r, corners, turn) {
  for (let i = 0; i < corners; i++) {
    const angle = turn + (i * 2 * Math.PI) / corners;
    pen.lineTo(x + r * Math.cos(angle), y + r * Math.sin(angle));
  }
  pen.closePath();
}

/** The outline of a player's mark, of diameter `size`. @param {Pen} pen @param {number} player @param {number} x
 * @param {number} y @param {number} size */
export function outline(pen, player, x, y, size) {
  const r = size / 2;
  pen.beginPath();
  switch (player % 8) {
    case 0:
      pen.arc(x, y, r, 0, 2 * Math.PI);
      break;
    case 1 /* a triangle pointing forward */:
      pen.moveTo(x - r, y - r * 0.92);
      pen.lineTo(x + r * 1.3, y);
      pen.lineTo(x - r, y + r * 0.92);
      pen.closePath();
      break;
    case 2:
      pen.rect(x - r * 0.9, y - r * 0.9, r * 1.8, r * 1.8);
      break;
    case 3:
      polygon(pen, x, y, r * 1.1, 5, -Math.PI / 2);
      break;
    case 4:
      polygon(pen, x, y, r * 1.05, 6, 0);
      break;
    case 5:
      polygon(pen, x, y, r * 1.2, 3, Math.PI / 2);
      break;
    case 6:
      polygon(pen, x, y, r * 1.1, 8, Math.PI / 8);
      break;
    default:
      pen.roundRect(x - r * 1.2, y - r * 0.7, r * 2.4, r * 1.4, r * 0.5);
  }
}

/** @param {Pen} to @param {Palette} colours @param {number} player @param {number} x @param {number} y @param {number} size */
export function drawMark(to, colours, player, x, y, size) {
  stamp(to, `mark ${player} ${size}`, x, y, 0.75 * size + 3, 0.75 * size + 3, (pen) => markAtOrigin(pen, colours, player, size));
}

/** @param {Pen} pen @param {Palette} colours @param {number} player @param {number} size */
function markAtOrigin(pen, colours, player, size) {
  outline(pen, player, 0, 0, size);
  pen.setLineDash([]);
  pen.fillStyle = paintOf(colours, player).fill;
  pen.fill();
  pen.lineWidth = Math.max(1.5, colours.line);
  pen.strokeStyle = colours.truth;
  pen.stroke();
  if (size < 14) return;
  pen.fillStyle = colours.onFill;
  pen.font = `700 ${Math.round(Math.max(11, size * 0.5, Math.min(colours.text, size * 0.8)))}px ${colours.font}`;
  pen.textAlign = 'center';
  pen.textBaseline = 'middle';
  pen.fillText(letter(player), player % 8 === 1 ? -size * 0.12 : 0, 1);
}

/** Where the server has it: hollow and dashed. @param {Pen} to @param {Palette} colours @param {number} player
 * @param {number} x @param {number} y @param {number} size */
export function drawGhost(to, colours, player, x, y, size) {
  stamp(to, `hollow ${player % 8} ${size}`, x, y, 0.75 * size + 3, 0.75 * size + 3, (pen) => {
    outline(pen, player, 0, 0, size);
    pen.setLineDash([4, 3]);
    pen.lineWidth = colours.line;
    pen.strokeStyle = colours.truth;
    pen.stroke();
  });
}

/** Widths by font, of texts that differ in their digits only: those of a font are equally wide. @type {Map<string, Map<string, number>>} */
const widths = new Map();
const MOST = 2000;
/** @type {number[]} */
const SOLID = [];

/** Lets the browser measure what is new alone, which takes longer than drawing it. @param {Pen} pen @param {Palette} colours
 * @param {string} text @param {boolean} [bold] @returns {number} px */
export function widthOf(pen, colours, text, bold = false) {
  const font = `${bold ? '700 ' : ''}${colours.text}px ${colours.font}`;
  let known = widths.get(font);
  if (known === undefined || known.size > MOST) widths.set(font, (known = new Map()));
  const like = text.replace(/\d/g, '0');
  let width = known.get(like);
  if (width === undefined) {
    pen.font = font;
    width = pen.measureText(like).width;
    known.set(like, width);
  }
  return width;
}

/** @param {Pen} pen @param {Palette} colours @param {string} text @param {number} x @param {number} y
 * @param {{align?: CanvasTextAlign, colour?: string, bold?: boolean, baseline?: CanvasTextBaseline, size?: number}} [more] */
export function drawText(pen, colours, text, x, y, more = {}) {
  const size = more.size ?? colours.text;
  pen.font = `${more.bold ? '700 ' : ''}${size}px ${colours.font}`;
  pen.textAlign = more.align ?? 'left';
  pen.textBaseline = more.baseline ?? 'middle';
  pen.setLineDash(SOLID);
  pen.lineWidth = Math.max(4, size / 5);
  pen.lineJoin = 'round';
  pen.strokeStyle = colours.paper;
  pen.strokeText(text, x, y);
  pen.fillStyle = more.colour ?? colours.ink;
  pen.fillText(text, x, y);
}

/** @param {Pen} pen @param {number} x @param {number} y @param {number} r */
export function cross(pen, x, y, r) {
  pen.beginPath();
  pen.moveTo(x - r, y - r);
  pen.lineTo(x + r, y + r);
  pen.moveTo(x - r, y + r);
  pen.lineTo(x + r, y - r);
  pen.stroke();
}

/** A zigzag between two points on one level. @param {Pen} pen @param {number} x0 @param {number} x1 @param {number} y */
export function spring(pen, x0, x1, y) {
  const turns = Math.max(2, Math.min(12, Math.round(Math.abs(x1 - x0) / 6)));
  pen.beginPath();
  pen.moveTo(x0, y);
  for (let i = 1; i < turns; i++) pen.lineTo(x0 + ((x1 - x0) * i) / turns, y + (i % 2 === 0 ? -4 : 4));
  pen.lineTo(x1, y);
  pen.stroke();
}
