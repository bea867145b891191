// A canvas that fills its box, at no more than twice the CSS resolution. The size of a box, and whether it can be seen, come from
// observers: to ask in a frame makes the browser lay the page out.
import { hurry, touch } from './redraw.js';
import { begin } from './shown.js';

const DPR_MAX = 2;
const NEAR = '96px'; /* around the screen: drawn before it is scrolled there */

/** Device pixels per CSS px that a drawing has at least: more while an image is taken of it. */
export const finest = { ratio: 1 };

/** @typedef {CanvasRenderingContext2D} Pen */
/** CSS px; seen: on the screen or near it, as far as is known. @typedef {{width: number, height: number, seen: boolean}} Box */

/** @type {WeakMap<Element, Box>} */
const boxes = new WeakMap();

const sizes = new ResizeObserver((list) => {
  for (const { target } of list) measure(target);
  touch();
});
const places = new IntersectionObserver(
  (list) => {
    for (const { target, isIntersecting } of list) Object.assign(boxOf(target), { seen: isIntersecting });
    hurry();
  },
  { rootMargin: NEAR },
);

/** @param {Element} element */
function measure(element) {
  Object.assign(boxOf(element), { width: element.clientWidth, height: element.clientHeight });
}

/** The present size of an element, kept up to date. @param {Element} element @returns {Box} */
export function boxOf(element) {
  const known = boxes.get(element);
  if (known) return known;
  const made = { width: 0, height: 0, seen: true };
  boxes.set(element, made);
  measure(element);
  sizes.observe(element);
  places.observe(element);
  return made;
}

export class Surface {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    this.pen = /** @type {Pen} */ (canvas.getContext('2d'));
    this.width = 0; /* CSS px */
    this.height = 0;
    this.ratio = 1;
  }

  /** Clears it and fits it to its box. Returns false when there is nothing to draw on, or where it cannot be seen. */
  begin() {
    const { width, height, seen } = boxOf(/** @type {HTMLElement} */ (this.canvas.parentElement));
    if (!seen || width <= 8 || height <= 8) return false;
    const ratio = Math.max(finest.ratio, Math.min(DPR_MAX, window.devicePixelRatio || 1));
    if (width !== this.width || height !== this.height || ratio !== this.ratio) {
      this.width = width;
      this.height = height;
      this.ratio = ratio;
      this.canvas.width = Math.max(1, Math.round(width * ratio));
      this.canvas.height = Math.max(1, Math.round(height * ratio));
    }
    this.pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.pen.clearRect(0, 0, width, height);
    begin(this.canvas, width, height);
    return true;
  }
}
