// The cars of the first two players, seen from above, nose to the right; 96 x 44 units around their centre.
import { letter } from '../base/format.js';
import { paintOf } from './palette.js';
import { stamp } from './sprites.js';

/** @typedef {CanvasRenderingContext2D} Pen */
/** @typedef {import('./palette.js').Palette} Palette */

const BODIES = [
  new Path2D('M-45,-13Q-45,-20 -36,-20L10,-20Q48,-18 48,0Q48,18 10,20L-36,20Q-45,20 -45,13Z'),
  new Path2D('M-47,-19L-38,-20L-2,-19L48,-5Q53,0 48,5L-2,19L-38,20L-47,19L-44,0Z'),
];
/** Round or triangular, behind the letter. */
const BADGES = [new Path2D('M-24.5,0A13.5,13.5 0 1 0 2.5,0A13.5,13.5 0 1 0 -24.5,0Z'), new Path2D('M-30,-14.5L4,0L-30,14.5Z')];
/** Of the letter, units. */
const LETTERS = [
  { x: -11, units: 19 },
  { x: -20, units: 15 },
];
const GROWN = 1.7;
const GLASS = [new Path2D('M14,-13Q28,-11 28,0Q28,11 14,13Q19,0 14,-13Z'), new Path2D('M10,-8Q20,-6 22,0Q20,6 10,8Q13,0 10,-8Z')];
const WHEELS = new Path2D('M-34,-23h17v7h-17zM-34,16h17v7h-17zM12,-22h17v7h-17zM12,15h17v7h-17z');
const WING = new Path2D('M-57.5,-21h9v42h-9z');
export const LONG = 96,
  HIGH = 44; /* units */

/** Whether a player has a car; the others have their marks. @param {number} player */
export const hasCar = (player) => player % 8 < BODIES.length;

const REACH_X = 0.66 * LONG,
  REACH_Y = 0.6 * HIGH; /* units, with the edge */

/** @param {Pen} pen @param {string} key @param {number} x @param {number} y @param {number} size px, its height
 * @param {(pen: Pen, scale: number) => void} draw */
function at(pen, key, x, y, size, draw) {
  const scale = size / HIGH;
  stamp(pen, `${key} ${size}`, x, y, REACH_X * scale + 3, REACH_Y * scale + 3, (on) => {
    on.scale(scale, scale);
    on.lineJoin = 'round';
    draw(on, scale);
  });
}

/** @param {Pen} to @param {Palette} colours @param {number} player @param {number} x @param {number} y
 * @param {number} size px, its height */
export function drawCar(to, colours, player, x, y, size) {
  const k = player % 8;
  at(to, `car ${player}`, x, y, size, (pen, scale) => {
    pen.setLineDash([]);
    pen.strokeStyle = pen.fillStyle = colours.truth;
    pen.fill(WHEELS);
    pen.lineWidth = Math.max(1.5, colours.line) / scale;
    const body = /** @type {Path2D} */ (BODIES[k]);
    for (const part of k === 1 ? [WING, body] : [body]) {
      pen.fillStyle = paintOf(colours, player).fill;
      pen.fill(part);
      pen.stroke(part);
    }
    pen.fillStyle = '#1f2933';
    pen.fill(/** @type {Path2D} */ (GLASS[k]));
    const { x: middle, units } = /** @type {(typeof LETTERS)[number]} */ (LETTERS[k]),
      grown = Math.min(GROWN, Math.max(1, colours.text / (units * scale))); /* a small car has a letter that can be read */
    pen.translate(middle, 0);
    pen.scale(grown, grown);
    pen.translate(-middle, 0);
    pen.fillStyle = '#fff';
    pen.fill(/** @type {Path2D} */ (BADGES[k]));
    pen.fillStyle = '#16212b';
    pen.font = `700 ${units}px ${colours.font}`;
    pen.textAlign = 'center';
    pen.textBaseline = 'middle';
    pen.fillText(letter(player), middle, 1);
  });
}

/** Where the server has it: its outline, dashed, with a halo. @param {Pen} to @param {Palette} colours @param {number} player
 * @param {number} x @param {number} y @param {number} size */
export function drawCarGhost(to, colours, player, x, y, size) {
  const body = /** @type {Path2D} */ (BODIES[player % 8]);
  at(to, `ghost ${player % 8}`, x, y, size, (pen, scale) => {
    pen.setLineDash([]);
    pen.lineWidth = (colours.line * 2.3) / scale;
    pen.strokeStyle = colours.paper;
    pen.stroke(body);
    pen.lineWidth = colours.line / scale;
    pen.setLineDash([7 / scale, 5 / scale]);
    pen.strokeStyle = colours.truth;
    pen.stroke(body);
  });
}
