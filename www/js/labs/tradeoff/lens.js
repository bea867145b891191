// Two places that a sentence compares: with a band between them where they are far enough apart to be seen, through a lens where not.
import { drawText } from '../../draw/marks.js';
import { localized } from '../../base/format.js';
import { t } from '../../base/words.js';

/** @typedef {import('../../draw/palette.js').Palette} Palette */
/** Where it is drawn, and where it truly is, px. @typedef {{drawn: {x: number, y: number}, real: {x: number, y: number}}} Pair */

export const SEEN_PX = 40;
const WIDE_PX = 52; /* between the two, in a lens */
const MOST = 300; /* times: what needs more is in its place for all that can be seen */

/** By how much a lens enlarges a distance: a round number. @param {number} px @returns {number} 1: none is needed; 0: none is enough */
export function factorOf(px) {
  if (px >= SEEN_PX) return 1;
  if (!(px > 0)) return 0;
  const least = WIDE_PX / px,
    power = 10 ** Math.floor(Math.log10(least)),
    lead = least / power,
    factor = (lead <= 1.2 ? 1.2 : lead <= 1.5 ? 1.5 : lead <= 2 ? 2 : lead <= 3 ? 3 : lead <= 5 ? 5 : 10) * power;
  const round = Number(factor.toPrecision(2));
  return round > MOST ? 0 : Math.max(2, Math.ceil(round));
}

/** The band between two places, with its posts. @param {CanvasRenderingContext2D} pen @param {Palette} colours @param {Pair} pair */
function band(pen, colours, { drawn, real }) {
  const angle = Math.atan2(real.y - drawn.y, real.x - drawn.x),
    long = Math.hypot(real.x - drawn.x, real.y - drawn.y);
  pen.save();
  pen.translate(drawn.x, drawn.y);
  pen.rotate(angle);
  pen.fillStyle = colours.mark;
  pen.globalAlpha = 0.85;
  pen.fillRect(0, -11, long, 22);
  pen.globalAlpha = 1;
  pen.strokeStyle = colours.markLine;
  pen.setLineDash([]);
  pen.lineWidth = 2;
  for (const x of [0, long]) {
    pen.beginPath();
    pen.moveTo(x, -14);
    pen.lineTo(x, 14);
    pen.stroke();
  }
  pen.restore();
}

/** A disc for where it is drawn, a dashed one for where it truly is. @param {CanvasRenderingContext2D} pen @param {Palette} colours
 * @param {Pair} pair @param {string} fill */
export function discs(pen, colours, { drawn, real }, fill) {
  pen.lineWidth = colours.line;
  pen.strokeStyle = colours.truth;
  pen.setLineDash([4, 3]);
  pen.beginPath();
  pen.arc(real.x, real.y, 9, 0, 2 * Math.PI);
  pen.stroke();
  pen.setLineDash([]);
  pen.fillStyle = fill;
  pen.beginPath();
  pen.arc(drawn.x, drawn.y, 9, 0, 2 * Math.PI);
  pen.fill();
  pen.stroke();
}

/** @param {{pen: CanvasRenderingContext2D, width: number, height: number}} surface @param {Palette} colours @param {Pair} pair
 * @param {{text: string, fill: string, at: number, factor: number}} of what the distance is; at: where a lens has room, 0 left, 1 right;
 *   factor: of the lens, as `factorOf` had it @returns {number} the distance as it is shown, px */
export function compare({ pen, width, height }, colours, pair, { text, fill, at: share, factor }) {
  const { drawn, real } = pair,
    px = Math.hypot(real.x - drawn.x, real.y - drawn.y);
  const words = (/** @type {number} */ x, /** @type {number} */ y) =>
    drawText(pen, colours, text, x, y, { align: 'center', bold: true, colour: colours.markText });
  if (factor === 1) {
    band(pen, colours, pair);
    discs(pen, colours, pair, fill);
    const middle = (drawn.x + real.x) / 2;
    words(Math.max(text.length * 4, Math.min(width - text.length * 4, middle)), Math.max(12, Math.min(drawn.y, real.y) - 26));
    return px;
  }
  if (factor === 0) {
    discs(pen, colours, pair, fill);
    return px;
  }
  const radius = Math.min(54, (height - 12) / 2),
    at = { x: radius + 8 + share * (width - 2 * radius - 16), y: height - radius - 6 };
  const angle = px > 0 ? Math.atan2(real.y - drawn.y, real.x - drawn.x) : 0,
    half = (px * factor) / 2;
  pen.strokeStyle = colours.ink;
  pen.lineWidth = 1.2;
  pen.setLineDash([]);
  for (const side of [-1, 1]) {
    pen.beginPath();
    pen.moveTo(drawn.x, drawn.y + side * 9);
    pen.lineTo(at.x, at.y + side * radius);
    pen.stroke();
  }
  pen.beginPath();
  pen.arc(at.x, at.y, radius, 0, 2 * Math.PI);
  pen.fillStyle = colours.paper;
  pen.fill();
  pen.save();
  pen.clip();
  const shown = {
    drawn: { x: at.x - half * Math.cos(angle), y: at.y - half * Math.sin(angle) },
    real: { x: at.x + half * Math.cos(angle), y: at.y + half * Math.sin(angle) },
  };
  band(pen, colours, shown);
  discs(pen, colours, shown, fill);
  pen.restore();
  pen.lineWidth = 2.5;
  pen.beginPath();
  pen.arc(at.x, at.y, radius, 0, 2 * Math.PI);
  pen.stroke();
  drawText(pen, colours, t('tradeoff.lens', { times: localized(String(factor)) }), at.x, at.y - radius + 13, {
    align: 'center',
    size: colours.axis,
  });
  /* next to a band that is upright, below one that is not and has room */
  if (Math.abs(Math.sin(angle)) > 0.6 || pen.measureText(text).width > 2 * radius - 18)
    words(at.x - radius - pen.measureText(text).width / 2 - 8, at.y);
  else words(at.x, at.y + radius - 14);
  return px * factor;
}
