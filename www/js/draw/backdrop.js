// What stays the same from frame to frame is drawn once and copied: lines and numbers of axes, scenery.
import { language } from '../base/words.js';
import { paletteVersion } from './palette.js';

/** @typedef {CanvasRenderingContext2D} Pen */

const MOST = 12; /* kept at a time */

/** @type {Map<string, {canvas: HTMLCanvasElement | null, frame: unknown}>} */
const kept = new Map();

/** Draws at the top left of a view. What is new is drawn in place, and kept from the next frame on: a camera that moves shows nothing
 * twice.
 * @param {Pen} pen @param {{width: number, height: number, frame: unknown}} at CSS px
 * @param {string} key all that the drawing depends on, but size, language and colours @param {(pen: Pen) => void} draw */
export function backdrop(pen, { width, height, frame }, key, draw) {
  const ratio = pen.getTransform().a;
  const whole = `${key}|${width}|${height}|${ratio}|${paletteVersion()}|${language.value}`;
  const known = kept.get(whole);
  if (known?.canvas) {
    pen.drawImage(known.canvas, 0, 0, width, height);
    return;
  }
  draw(pen);
  if (known === undefined) {
    const [oldest] = kept.keys();
    if (kept.size >= MOST && oldest !== undefined) kept.delete(oldest);
    kept.set(whole, { canvas: null, frame });
  } else if (known.frame !== frame) {
    const canvas = Object.assign(document.createElement('canvas'), {
      width: Math.max(1, Math.round(width * ratio)),
      height: Math.max(1, Math.round(height * ratio)),
    });
    const own = /** @type {Pen} */ (canvas.getContext('2d'));
    own.setTransform(ratio, 0, 0, ratio, 0, 0);
    draw(own);
    known.canvas = canvas;
  }
}
