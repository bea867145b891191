// Marks and cars are drawn many times alike: their outlines are filled once for each place within a pixel, and copied.
import { paletteVersion } from './palette.js';

/** @typedef {CanvasRenderingContext2D} Pen */

const PHASES = 4; /* places within a pixel along each axis, so that slow motion stays even */
const MOST = 600;

/** Null for one that was seen once: a size that changes with every frame is not kept. @type {Map<string, HTMLCanvasElement | null>} */
const kept = new Map();

/** @param {number} reachX device px on each side @param {number} reachY @param {number} ratio @param {number} dx part of a pixel
 * @param {number} dy @param {(pen: Pen) => void} draw */
function made(reachX, reachY, ratio, dx, dy, draw) {
  const canvas = Object.assign(document.createElement('canvas'), { width: 2 * reachX + 1, height: 2 * reachY + 1 });
  const pen = /** @type {Pen} */ (canvas.getContext('2d'));
  pen.setTransform(ratio, 0, 0, ratio, reachX + dx, reachY + dy);
  draw(pen);
  return canvas;
}

/** Draws something around a point. @param {Pen} pen @param {string} key all that it depends on, but colours and resolution
 * @param {number} x px @param {number} y @param {number} reachX px on each side of the point @param {number} reachY
 * @param {(pen: Pen) => void} draw around the origin */
export function stamp(pen, key, x, y, reachX, reachY, draw) {
  const { a: ratio, b, c, d, e, f } = pen.getTransform();
  if (ratio === d && b === 0 && c === 0 && e === 0 && f === 0) {
    const px = Math.floor(x * ratio * PHASES + 0.5),
      py = Math.floor(y * ratio * PHASES + 0.5);
    const left = Math.floor(px / PHASES),
      top = Math.floor(py / PHASES);
    const whole = `${key}|${px - left * PHASES}${py - top * PHASES}|${ratio}|${paletteVersion()}`;
    let canvas = kept.get(whole);
    if (canvas === null) {
      canvas = made(Math.ceil(reachX * ratio) + 1, Math.ceil(reachY * ratio) + 1, ratio, px / PHASES - left, py / PHASES - top, draw);
      kept.set(whole, canvas);
    }
    if (canvas) {
      const { width, height } = canvas;
      pen.drawImage(canvas, (left - (width - 1) / 2) / ratio, (top - (height - 1) / 2) / ratio, width / ratio, height / ratio);
      return;
    }
    if (kept.size >= MOST) kept.clear();
    kept.set(whole, null);
  }
  pen.save();
  pen.translate(x, y);
  draw(pen);
  pen.restore();
}
