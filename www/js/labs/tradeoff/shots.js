// A shot and where it counts: where the one who fires saw the other, where that is when the server decides, and what it decides. Of two
// runs the same shot is shown, one that they decide differently.
import { cross, drawText, outline, widthOf } from '../../draw/marks.js';
import { paintOf } from '../../draw/palette.js';
import { brief } from './names.js';
import { letter } from '../../base/format.js';
import { SHOTS_WEAPON } from '../../stream/names.js';
import { t } from '../../base/words.js';

/** @typedef {import('./live.js').Run} Run */
/** @typedef {import('../../draw/palette.js').Palette} Palette */
/** @typedef {{pen: CanvasRenderingContext2D, width: number, height: number}} Surface */
/** @typedef {{x: number, y: number}} Place  m */
/** at: s, of the press; hit: it counts; seen: where it was seen; own:
 * where it is when the server decides; aim: height of the shot there
 * @typedef {{at: number, hit: boolean, seen: Place, own: Place, aim: number}} Shot */

const VICTIM = 0,
  FIRES = 1;
const SAME_S = 0.02; /* two runs have pressed at the same time */
const HOLD_S = 2.5; /* a shot is shown for, while others come */
/** What is fitted, m: before the victim, above and below its two places, and in all at least. */
const FIT = { before: 3.2, around: 0.9, least: 3.4 };

/** What B saw hit, in the order of the presses. @param {Run} run @returns {Shot[]} */
function shotsOf(run) {
  const { frame } = run;
  run.memory ??= { seq: -1, shots: [] };
  /** @type {{seq: number, shots: Shot[]}} */
  const memory = run.memory;
  if (!frame || memory.seq === frame.seq) return memory.shots;
  memory.seq = frame.seq;
  const bodies = frame.where('shot_bodies', 'player', FIRES),
    screen = frame.where('entities', 'view', 1 + VICTIM)[VICTIM];
  for (const shot of frame.shots) {
    if (shot.player !== FIRES || shot.weapon !== SHOTS_WEAPON.hitscan || shot.client_view_hit !== VICTIM) continue;
    const body = bodies.find((one) => one.weapon === shot.weapon && one.tick === shot.tick && one.body === VICTIM);
    if (!body || memory.shots.some(({ at }) => at === shot.pressed_s)) continue;
    const soon = screen !== undefined && frame.time_s - shot.evaluated_at_s < 0.1;
    memory.shots.push({
      at: shot.pressed_s,
      hit: shot.compensated_hit === VICTIM,
      seen: { x: body.seen_x, y: body.seen_y },
      own: soon ? { x: screen.x, y: screen.y } : { x: body.now_x, y: body.now_y },
      aim: shot.y + (shot.dy / shot.dx) * (body.seen_x - shot.x),
    });
  }
  memory.shots.sort((a, b) => a.at - b.at);
  return memory.shots;
}

/** The shot that is shown: of those that the two runs decide differently the newest, each for a while, rather one at one that has gone
 * behind the wall; without one the newest. @param {Shot[]} own @param {Shot[]} other @returns {Shot | undefined} */
export function shownOf(own, other) {
  const differ = own.filter((shot) => other.some(({ at, hit }) => Math.abs(at - shot.at) < SAME_S && hit !== shot.hit)),
    gone = differ.filter(({ seen, own: now }) => now.y < seen.y);
  let found,
    until = Number.NEGATIVE_INFINITY;
  for (const shot of gone.length > 0 ? gone : differ) {
    if (shot.at < until) continue;
    found = shot;
    until = shot.at + HOLD_S;
  }
  return found ?? own.at(-1);
}

/** @param {Surface} surface @param {Palette} colours @param {Run} run @param {{peer: Run | null}} look
 * @returns {{px: number, factor: number}} */
export function drawShot(surface, colours, run, { peer }) {
  const { pen, width, height } = surface,
    { frame } = run;
  const there = frame?.where('entities', 'view', 1 + VICTIM) ?? [],
    [a, b] = [there[VICTIM], there[FIRES]];
  if (!frame || !run.layout || !a || !b) return { px: 0, factor: 1 };
  const shots = shotsOf(run),
    shot = shownOf(shots, peer?.kind === 'netgame' ? shotsOf(peer) : []);
  const walls = run.layout.fixed ?? [],
    between = walls.filter((/** @type {Place} */ wall) => wall.x > a.x && wall.x < b.x),
    wall = between.sort((/** @type {Place} */ one, /** @type {Place} */ other) => one.x - other.x)[0];
  const places = shot ? [shot.seen.y, shot.own.y] : [wall ? wall.y + wall.height_m / 2 : a.y],
    low = Math.min(...places) - FIT.around,
    high = Math.max(...places) + FIT.around,
    tall = Math.max(FIT.least, high - low),
    top = (high + low + tall) / 2,
    scale = height / tall;
  const x = (/** @type {number} */ m) => (m - a.x + FIT.before) * scale,
    y = (/** @type {number} */ m) => (top - m) * scale;
  pen.fillStyle = colours.verge;
  pen.fillRect(0, 0, width, height);
  for (const one of walls) {
    pen.fillStyle = colours.edge;
    pen.fillRect(x(one.x - one.width_m / 2), y(one.y + one.height_m / 2), one.width_m * scale, one.height_m * scale);
  }
  const radius = Math.max(9, ((run.layout.entities?.[VICTIM]?.width_m ?? 1.2) / 2) * scale);
  const body = (/** @type {Place} */ at, /** @type {boolean} */ pale) => {
    pen.globalAlpha = pale ? 0.4 : 1;
    outline(pen, VICTIM, x(at.x), y(at.y), 2 * radius);
    pen.fillStyle = paintOf(colours, VICTIM).fill;
    pen.fill();
    pen.setLineDash([]);
    pen.lineWidth = colours.line;
    pen.strokeStyle = colours.truth;
    pen.stroke();
    pen.globalAlpha = 1;
    const words = { ...colours, paper: paintOf(colours, VICTIM).fill, ink: colours.onFill };
    if (!pale) drawText(pen, words, letter(VICTIM), x(at.x), y(at.y) + 1, { align: 'center', bold: true });
  };
  const level = shot ? y(shot.aim) : y(b.y);
  let px = 0;
  if (shot) {
    const from = y(shot.seen.y),
      to = y(shot.own.y),
      left = x(shot.own.x) - radius - 24;
    px = Math.hypot(from - to, x(shot.seen.x) - x(shot.own.x));
    pen.fillStyle = colours.mark;
    pen.fillRect(left, Math.min(from, to), 16, Math.abs(to - from));
    pen.strokeStyle = colours.markLine;
    pen.lineWidth = 2;
    pen.setLineDash([]);
    for (const post of [from, to]) {
      pen.beginPath();
      pen.moveTo(left - 4, post);
      pen.lineTo(left + 20, post);
      pen.stroke();
    }
    const gap = `${brief(Number(Math.hypot(shot.seen.x - shot.own.x, shot.seen.y - shot.own.y).toFixed(1)))} m`;
    drawText(pen, colours, gap, left - 6, (from + to) / 2, { align: 'right', bold: true, colour: colours.markText });
    body(shot.seen, true);
    /* what counts hits; what does not goes on, crossed out */
    const end = shot.hit ? x(shot.seen.x) + radius : x(shot.seen.x) - radius - 30;
    pen.strokeStyle = colours.snap;
    pen.lineWidth = colours.line + 1;
    pen.setLineDash(shot.hit ? [] : [7, 5]);
    pen.beginPath();
    pen.moveTo(width - 22, level);
    pen.lineTo(end, level);
    pen.stroke();
    pen.setLineDash([]);
    pen.beginPath();
    for (const turn of shot.hit ? [-0.9, -0.3, 0.3, 0.9] : []) {
      pen.moveTo(end + 5 * Math.cos(turn), level + 5 * Math.sin(turn));
      pen.lineTo(end + 15 * Math.cos(turn), level + 15 * Math.sin(turn));
    }
    pen.stroke();
    if (!shot.hit) cross(pen, x(shot.seen.x) + radius + 8, level, 7);
  }
  body(shot?.own ?? a, false);
  pen.save();
  pen.translate(width - 14, level);
  pen.rotate(Math.PI);
  outline(pen, FIRES, 0, 0, 20);
  pen.fillStyle = paintOf(colours, FIRES).fill;
  pen.fill();
  pen.lineWidth = colours.line;
  pen.strokeStyle = colours.truth;
  pen.stroke();
  pen.restore();
  drawText(pen, colours, letter(FIRES), width - 14, level + (level > height / 2 ? -17 : 17), { align: 'center', bold: true });
  if (shot) {
    /* on the side of the shot that has room */
    const step = (level > height / 2 ? -1.3 : 1.3) * colours.text,
      says = t(shot.hit ? 'tradeoff.shot.counts' : 'tradeoff.shot.not'),
      where = t(shot.own.y < shot.seen.y ? 'tradeoff.shot.covered' : 'tradeoff.shot.open');
    drawText(pen, colours, says, width - 32, level + step, { align: 'right', bold: true, colour: colours.snap });
    if (widthOf(pen, colours, where) < width - x(a.x) - radius - 50)
      drawText(pen, colours, where, width - 32, level + 2 * step, { align: 'right' });
  }
  const counted = shots.filter(({ hit }) => hit).length,
    tally = t('tradeoff.shot.tally', { seen: String(shots.length), counted: String(counted) });
  if (shots.length > 0) drawText(pen, colours, tally, x(a.x) + radius + 14, height - colours.text * 0.9, { colour: colours.faint });
  return { px, factor: 1 };
}
