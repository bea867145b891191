// A canvas that fills its box, at no more than twice the CSS resolution.

const DPR_MAX = 2;

/** @typedef {CanvasRenderingContext2D} Pen */

export class Surface {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    this.pen = /** @type {Pen} */ (canvas.getContext('2d'));
    this.width = 0; /* CSS px */
    this.height = 0;
    this.ratio = 1;
  }

  /** Clears it and fits it to its box. Returns false when there is nothing to draw on. */
  begin() {
    const box = /** @type {HTMLElement} */ (this.canvas.parentElement);
    const width = box.clientWidth,
      height = box.clientHeight;
    const ratio = Math.min(DPR_MAX, window.devicePixelRatio || 1);
    if (width !== this.width || height !== this.height || ratio !== this.ratio) {
      this.width = width;
      this.height = height;
      this.ratio = ratio;
      this.canvas.width = Math.max(1, Math.round(width * ratio));
      this.canvas.height = Math.max(1, Math.round(height * ratio));
    }
    this.pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.pen.clearRect(0, 0, width, height);
    return width > 8 && height > 8;
  }
}
