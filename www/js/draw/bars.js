// Sizes as bars of one scale, each with its words above it.
import { drawText } from './marks.js';
import { drawShown, place } from './shown.js';

const MARGIN = 8; /* px */

/** Reports where each ends: `bar_0` and so on. @param {{pen: CanvasRenderingContext2D, width: number, height: number}} surface
 * @param {import('./palette.js').Palette} colours @param {{text: string, value: number}[]} list */
export function drawBars({ pen, width, height }, colours, list) {
  const most = Math.max(1e-9, ...list.map(({ value }) => value)),
    each = (height - MARGIN) / Math.max(1, list.length),
    words = colours.text * 1.4;
  list.forEach(({ text, value }, i) => {
    const top = MARGIN / 2 + i * each,
      long = ((width - 2 * MARGIN) * value) / most;
    drawText(pen, colours, text, MARGIN, top + words / 2, { bold: true });
    pen.fillStyle = colours.accent;
    pen.fillRect(MARGIN, top + words, Math.max(1, long), Math.max(6, each - words - 4));
    place(pen.canvas, `bar_${i}`, MARGIN + long, top + words, value);
  });
  drawShown(pen, colours, height - MARGIN);
}
