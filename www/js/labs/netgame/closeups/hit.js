// A hit twice, at one scale: what the shooter saw, and the victim's own screen when the server decides. Near the victim and its wall.
import { place } from '../../../draw/shown.js';
import { gridStep } from '../../../draw/axis.js';
import { cross, drawText, outline, widthOf } from '../../../draw/marks.js';
import { paintOf } from '../../../draw/palette.js';
import { fixed, letter } from '../../../base/format.js';
import { t } from '../../../base/words.js';
import { HITSCAN, bodiesOf, entitiesOf } from '../core/frame.js';

/** @typedef {import('../core/frame.js').Frame} Frame */
/** @typedef {import('../core/layout.js').Layout} Layout */
/** @typedef {import('../../../draw/palette.js').Palette} Palette */
/** @typedef {{x: number, y: number}} Point  m */
/** seen: where the shooter saw the victim; judged: where the server looked; own: on the victim's screen now; end: of the line from the
 * shooter to `own`, where scenery ends it; aim: the shot at the victim's x
 * @typedef {{seen: Point, judged: Point, own: Point, muzzle: Point, end: Point | null, aim: number, hit: boolean, age: number,
 *   back: number}} Hit  age, back: ms */
/** @typedef {{pen: CanvasRenderingContext2D, width: number, height: number, colours: Palette, frame: Frame, layout: Layout,
 *   victim: number, again: boolean}} Drawing  again: after a change, with the first run as a ghost */

const HELD_S = 0.24; /* a shot is shown for: the next one follows after 0.25 s */
const LEAST = 600; /* px: narrower drawings have the whole yard below, and less of it */
/** What is fitted, m: around the victim's column, up to behind the wall, and below and above its upper edge. */
const FIT = { before: 2.4, behind: 1.6, below: 3.2, above: 2.4 };

/** @param {number} victim */
const shooterOf = (victim) => (victim === 0 ? 1 : 0);

/** Where a line meets a box first; null where it does not. @param {Point} from @param {Point} to
 * @param {import('../core/layout.js').Layout['fixed'][0]} box @returns {number | null} part of the way */
function meets(from, to, box) {
  let first = 0,
    last = 1;
  for (const [start, way, middle, size] of [
    [from.x, to.x - from.x, box.x, box.width_m],
    [from.y, to.y - from.y, box.y, box.height_m],
  ]) {
    const low = middle - size / 2 - start,
      high = middle + size / 2 - start;
    if (way === 0) {
      if (low > 0 || high < 0) return null;
      continue;
    }
    first = Math.max(first, Math.min(low / way, high / way));
    last = Math.min(last, Math.max(low / way, high / way));
  }
  return first <= last ? first : null;
}

/** The newest shot at the victim, while it is shown. @param {Frame} frame @param {Layout} layout @param {number} victim
 * @returns {Hit | null} */
export function hitOf(frame, layout, victim) {
  const shooter = shooterOf(victim);
  const shot = frame.shots.find(
    (one) =>
      one.player === shooter && one.weapon === HITSCAN && one.client_view_hit === victim && frame.time_s - one.evaluated_at_s < HELD_S,
  );
  const body = shot && bodiesOf(frame, shot)[victim],
    own = entitiesOf(frame, 1 + victim)[victim];
  if (!shot || !body || !own) return null;
  const muzzle = { x: shot.x, y: shot.y },
    goal = { x: own.x, y: own.y };
  const parts = layout.fixed.map((box) => meets(muzzle, goal, box)).filter((part) => part !== null),
    part = parts.length > 0 ? Math.min(...parts) : null;
  return {
    seen: { x: body.seen_x, y: body.seen_y },
    judged: { x: body.looked_x, y: body.looked_y },
    own: goal,
    muzzle,
    end: part === null ? null : { x: muzzle.x + part * (goal.x - muzzle.x), y: muzzle.y + part * (goal.y - muzzle.y) },
    aim: shot.y + (shot.dy / shot.dx) * (body.seen_x - shot.x),
    hit: shot.compensated_hit === victim,
    age: (shot.pressed_s - shot.view_time_s) * 1000,
    back: (shot.evaluated_at_s - shot.rewound_to_s) * 1000,
  };
}

/** The scenery that the victim hides behind: the nearest on the shooter's side. @param {Layout} layout @param {Point} victim
 * @param {Point} shooter */
function wallOf({ fixed: all }, victim, shooter) {
  const way = Math.sign(shooter.x - victim.x);
  const before = all.filter((one) => way * (one.x - victim.x) > 0);
  return before.sort((a, b) => Math.abs(a.x - victim.x) - Math.abs(b.x - victim.x))[0] ?? null;
}

/** What of the yard is shown, and how: the same for both drawings of a size. @param {Drawing} at */
function cameraOf(at) {
  const { frame, layout, victim, width } = at;
  const own = entitiesOf(frame, 0)[victim] ?? { x: 0, y: 0 },
    other = entitiesOf(frame, 0)[shooterOf(victim)] ?? { x: layout.scene.x_max, y: 0 },
    wall = wallOf(layout, own, other);
  const way = other.x < own.x ? -1 : 1; /* the shooter's side is on the right */
  const far = wall === null ? 10 : Math.abs(wall.x - own.x) + wall.width_m / 2,
    top = wall === null ? own.y : wall.y + wall.height_m / 2;
  const height = at.height - mapHeight(at);
  const scale = Math.min(width / (FIT.before + far + FIT.behind), height / (FIT.below + FIT.above));
  const left = FIT.before + Math.max(0, Math.min(1, (width / scale - (FIT.before + far + FIT.behind)) / 4));
  return {
    scale,
    way,
    height,
    wall,
    x: (/** @type {number} */ m) => (left + way * (m - own.x)) * scale,
    y: (/** @type {number} */ m) => height / 2 - (m - top - (FIT.above - FIT.below) / 2) * scale,
    metres: (/** @type {number} */ px) => own.x + way * (px / scale - left),
  };
}

/** @typedef {ReturnType<typeof cameraOf>} Camera */

/** A narrow drawing has the whole yard below it; in a wide one it stands in a corner. @param {Drawing} at */
const mapHeight = (at) => (at.width < LEAST && at.pen.canvas.id === 'hit-seen' ? at.width / 5 : 0);

/** @param {Drawing} at @param {Camera} camera */
function yard(at, camera) {
  const { pen, colours, width, layout } = at,
    { x, y, height } = camera;
  pen.save();
  pen.beginPath();
  pen.rect(0, 0, width, height);
  pen.clip();
  const step = gridStep(camera.scale, 120);
  pen.fillStyle = colours.grid;
  const [a, b] = [camera.metres(0), camera.metres(width)];
  for (let i = Math.ceil(Math.min(a, b) / step); i * step <= Math.max(a, b); i++) pen.fillRect(Math.round(x(i * step)), 0, 1, height);
  for (const box of layout.fixed) {
    pen.beginPath();
    pen.rect(
      x(box.x) - (box.width_m / 2) * camera.scale,
      y(box.y + box.height_m / 2),
      box.width_m * camera.scale,
      box.height_m * camera.scale,
    );
    pen.fillStyle = colours.edge;
    pen.fill();
    pen.strokeStyle = colours.truth;
    pen.lineWidth = colours.line;
    pen.setLineDash([]);
    pen.stroke();
  }
  pen.restore();
  const { wall } = camera;
  if (wall !== null)
    drawText(pen, colours, t('netgame_more.hit.wall'), x(wall.x), height - colours.text, { align: 'center', colour: colours.faint });
}

/** The victim: as drawn, where it was, or where it truly is. @param {Drawing} at @param {Camera} camera @param {Point} where
 * @param {'now' | 'was' | 'judged'} kind */
function body(at, camera, where, kind) {
  const { pen, colours, layout, victim } = at;
  const r = Math.max(12, ((layout.entities[victim]?.width_m ?? 1.2) / 2) * camera.scale),
    px = camera.x(where.x),
    py = camera.y(where.y);
  pen.save();
  if (kind === 'was') pen.globalAlpha = 0.4;
  outline(pen, victim, px, py, 2 * r);
  pen.fillStyle = kind === 'judged' ? colours.paper : paintOf(colours, victim).fill;
  pen.fill();
  pen.lineWidth = colours.line;
  pen.setLineDash(kind === 'judged' ? [5, 4] : []);
  pen.strokeStyle = colours.truth;
  pen.stroke();
  pen.setLineDash([]);
  pen.font = `700 ${Math.round(r)}px ${colours.font}`;
  pen.textAlign = 'center';
  pen.textBaseline = 'middle';
  pen.fillStyle = kind === 'judged' ? colours.faint : colours.onFill;
  pen.fillText(letter(victim), px, py + 1);
  pen.restore();
  return { x: px, y: py, r };
}

/** Where a line from the shooter comes in. @param {Drawing} at @param {Camera} camera @param {Point} from @param {Point} to */
function entry(at, camera, from, to) {
  const x = at.width - 18,
    part = (camera.metres(x) - from.x) / (to.x - from.x || 1);
  return { x, y: camera.y(from.y + part * (to.y - from.y)) };
}

/** @param {Drawing} at @param {{x: number, y: number}} from px @param {{x: number, y: number}} to @param {string} colour
 * @param {number[]} [dash] @param {number} [wide] */
function line({ pen, colours }, from, to, colour, dash = [], wide = colours.line + 1.5) {
  pen.strokeStyle = colour;
  pen.lineWidth = wide;
  pen.setLineDash(dash);
  pen.beginPath();
  pen.moveTo(from.x, from.y);
  pen.lineTo(to.x, to.y);
  pen.stroke();
  pen.setLineDash([]);
}

/** @param {Drawing} at @param {{x: number, y: number}} end px, of a shot that hits @param {{x: number, y: number}} of what it hits */
function splash(at, { x, y }, of) {
  for (const turn of [-0.95, -0.35, 0.35, 0.95]) {
    const angle = turn + Math.atan2(y - of.y, x - of.x);
    const c = Math.cos(angle),
      s = Math.sin(angle);
    line(at, { x: x + 6 * c, y: y + 6 * s }, { x: x + 18 * c, y: y + 18 * s }, at.colours.snap, [], at.colours.line + 0.5);
  }
}

/** Where a level line from the right meets a body. @param {{x: number, y: number, r: number}} of px @param {number} y */
const edgeOf = ({ x, y: middle, r }, y) => ({ x: x + Math.sqrt(Math.max(0, r * r - (y - middle) ** 2)), y });

/** The shooter, whose place lies beyond the edge. @param {Drawing} at @param {Camera} camera @param {{x: number, y: number}} where
 * @param {Point} from m */
function shooter(at, camera, where, from) {
  const { pen, colours, victim, width } = at,
    who = shooterOf(victim);
  pen.save();
  pen.translate(where.x, where.y);
  pen.rotate(Math.PI);
  outline(pen, who, 0, 0, 22);
  pen.fillStyle = paintOf(colours, who).fill;
  pen.fill();
  pen.lineWidth = colours.line;
  pen.strokeStyle = colours.truth;
  pen.stroke();
  pen.restore();
  if (width < LEAST && pen.canvas.id !== 'hit-seen') return; /* the other drawing says it */
  const beyond = fixed(Math.abs(from.x - camera.metres(width)), 0);
  drawText(pen, colours, t('netgame_more.hit.beyond', { name: letter(who), m: beyond }), width - 6, where.y - 24, {
    align: 'right',
    bold: true,
  });
}

/** A text that stays within the drawing. @param {Drawing} at @param {string} text @param {number} x @param {number} y
 * @param {string} colour @param {boolean} [bold] */
function say(at, text, x, y, colour, bold = true) {
  const w = widthOf(at.pen, at.colours, text, bold);
  drawText(at.pen, at.colours, text, Math.max(4, Math.min(x, at.width - w - 6)), y, { colour, bold });
}

/** The whole yard, with a frame around what is shown large. @param {Drawing} at @param {Camera} camera @param {Hit | null} hit */
function map(at, camera, hit) {
  const { pen, colours, layout, frame, victim } = at,
    { x_min: x0, x_max: x1, y_min: y0, y_max: y1 } = layout.scene;
  const narrow = mapHeight(at) > 0,
    width = narrow ? at.width - 12 : Math.min(250, at.width * 0.26),
    scale = Math.min(width / (x1 - x0), (narrow ? mapHeight(at) - 8 : camera.height * 0.36) / (y1 - y0));
  const edge = camera.wall === null ? at.width : camera.x(camera.wall.x) - (camera.wall.width_m / 2) * camera.scale;
  const left = narrow ? (at.width - (x1 - x0) * scale) / 2 : edge - (x1 - x0) * scale - 14,
    top = at.height - (y1 - y0) * scale - (narrow ? 4 : 10);
  const x = (/** @type {number} */ m) => (camera.way > 0 ? left + (m - x0) * scale : left + (x1 - m) * scale),
    y = (/** @type {number} */ m) => top + (y1 - m) * scale;
  pen.fillStyle = colours.paper;
  pen.strokeStyle = colours.edge;
  pen.lineWidth = 1;
  pen.setLineDash([]);
  pen.beginPath();
  pen.roundRect(left, top, (x1 - x0) * scale, (y1 - y0) * scale, 4);
  pen.fill();
  pen.stroke();
  pen.save();
  pen.clip();
  pen.fillStyle = colours.edge;
  for (const box of layout.fixed)
    pen.fillRect(x(box.x) - (box.width_m / 2) * scale, y(box.y + box.height_m / 2), Math.max(2, box.width_m * scale), box.height_m * scale);
  const places = hit ? [hit.seen, hit.muzzle] : [victim, shooterOf(victim)].map((i) => entitiesOf(frame, 0)[i] ?? { x: 0, y: 0 });
  const [a, b] = places.map((one) => ({ x: x(one.x), y: y(one.y) }));
  if (hit) line(at, b, a, colours.snap, [], 1.5);
  for (const [who, where] of /** @type {[number, {x: number, y: number}][]} */ ([
    [victim, a],
    [shooterOf(victim), b],
  ])) {
    pen.beginPath();
    pen.arc(where.x, where.y, 4, 0, 2 * Math.PI);
    pen.fillStyle = paintOf(colours, who).fill;
    pen.fill();
    pen.strokeStyle = colours.truth;
    pen.lineWidth = 1;
    pen.stroke();
  }
  const [from, to] = [camera.metres(0), camera.metres(at.width)].map(x),
    [high, low] = [0, camera.height].map((px) => y(highest(camera, px)));
  pen.strokeStyle = colours.accent;
  pen.lineWidth = 2;
  pen.strokeRect(Math.max(left + 1, from), Math.max(top + 1, high), to - Math.max(left + 1, from), low - Math.max(top + 1, high));
  pen.restore();
  drawText(pen, colours, t('netgame_more.hit.yard', { m: fixed(x1 - x0, 0) }), left + (x1 - x0) * scale - 5, top + colours.axis * 0.8, {
    size: colours.axis,
    colour: colours.faint,
    align: 'right',
  });
}

/** @param {Camera} camera @param {number} px @returns {number} m */
const highest = (camera, px) => (camera.y(0) - px) / camera.scale;

/** What the shooter saw. @param {Drawing} at @param {Hit | null} hit */
export function drawSeen(at, hit) {
  const { pen, colours, frame, victim } = at,
    camera = cameraOf(at),
    who = shooterOf(victim);
  yard(at, camera);
  const drawn = entitiesOf(frame, 1 + who);
  if (hit === null) {
    const [a, b] = [drawn[victim], drawn[who]];
    if (a) body(at, camera, a, 'now');
    if (a && b) shooter(at, camera, entry(at, camera, b, a), b);
  } else {
    const a = body(at, camera, hit.seen, 'now'),
      from = entry(at, camera, hit.muzzle, { x: hit.seen.x, y: hit.aim }),
      end = edgeOf(a, camera.y(hit.aim));
    line(at, from, end, colours.snap);
    splash(at, end, a);
    shooter(at, camera, from, hit.muzzle);
    say(at, t('netgame_more.hit.open', { name: letter(victim) }), a.x + a.r + 12, a.y - a.r - 4, colours.ink);
    say(at, t('netgame_more.hit.passes', { name: letter(who) }), a.x + a.r + 26, end.y + colours.text * 1.3, colours.snap);
    place(pen.canvas, 'seen', a.x, a.y, hit.seen.y);
  }
  map(at, camera, hit);
}

/** The gap between where the server looked and where the victim is. @param {Drawing} at @param {{x: number, y: number, r: number}} from
 * @param {{x: number, y: number, r: number}} to @param {string[]} words
 * @param {number} lower px, than the middle, where the words stand next to the shot */
function gap(at, from, to, words, lower) {
  const { pen, colours } = at;
  const wide = Math.max(...words.map((text) => widthOf(pen, colours, text, true))),
    left = Math.min(from.x, to.x) - to.r - 8,
    outside = left - 22 - wide - 8 > 4; /* to the left, where there is room */
  const x = outside ? left - 22 : from.x + from.r + 20,
    low = Math.min(from.y, to.y),
    high = Math.max(from.y, to.y);
  pen.fillStyle = colours.mark;
  pen.fillRect(x, low, 22, high - low);
  pen.strokeStyle = colours.markLine;
  pen.lineWidth = 2.5;
  pen.setLineDash([]);
  pen.beginPath();
  for (const y of [low, high]) {
    pen.moveTo(outside ? x - 8 : from.x + from.r, y);
    pen.lineTo(outside ? left + 8 : x + 26, y);
  }
  pen.moveTo(x + 11, low + 4);
  pen.lineTo(x + 11, high - 4);
  for (const [y, way] of [
    [low + 3, 1],
    [high - 3, -1],
  ]) {
    pen.moveTo(x + 6, y + 7 * way);
    pen.lineTo(x + 11, y);
    pen.lineTo(x + 16, y + 7 * way);
  }
  pen.stroke();
  words.forEach((text, i) =>
    drawText(
      pen,
      colours,
      text,
      outside ? x - 8 : x + 32,
      (low + high) / 2 + (outside ? 0 : lower) + (i - (words.length - 1) / 2) * colours.text * 1.35,
      {
        align: outside ? 'right' : 'left',
        colour: colours.markText,
        bold: true,
      },
    ),
  );
}

/** The victim's screen when the server decides. @param {Drawing} at @param {Hit | null} hit */
export function drawDecided(at, hit) {
  const { pen, colours, frame, victim, again, width } = at,
    camera = cameraOf(at),
    who = shooterOf(victim);
  yard(at, camera);
  if (hit === null) {
    const drawn = entitiesOf(frame, 1 + victim),
      [a, b] = [drawn[victim], drawn[who]];
    if (a) body(at, camera, a, 'now');
    if (a && b) shooter(at, camera, entry(at, camera, b, a), b);
    return;
  }
  const from = entry(at, camera, hit.muzzle, { x: hit.seen.x, y: hit.aim }),
    goal = { x: camera.x(hit.own.x), y: camera.y(hit.own.y) };
  if (hit.end !== null) {
    const end = { x: camera.x(hit.end.x), y: camera.y(hit.end.y) },
      start = entry(at, camera, hit.muzzle, hit.own);
    line(at, start, end, colours.faint, [7, 5], colours.line);
    line(at, end, goal, colours.faint, [2, 5], colours.line);
    pen.strokeStyle = colours.ink;
    pen.lineWidth = colours.line + 2;
    cross(pen, end.x, end.y, 8);
    say(at, t('netgame_more.hit.stopped', { from: letter(who), to: letter(victim) }), end.x + 14, end.y + colours.text * 1.5, colours.ink);
  }
  const where = hit.hit ? hit.judged : hit.seen,
    there = body(at, camera, where, hit.hit ? 'judged' : 'was'),
    level = camera.y(hit.aim);
  const end = hit.hit ? edgeOf(there, level) : { x: 6, y: level };
  line(at, from, end, colours.snap, hit.hit ? [12, 6] : []);
  if (hit.hit) splash(at, end, there);
  else line(at, { x: 16, y: level - 6 }, end, colours.snap), line(at, { x: 16, y: level + 6 }, end, colours.snap);
  shooter(at, camera, from, hit.muzzle);
  const own = body(at, camera, hit.own, 'now');
  const text = hit.hit ? 'netgame_more.hit.rewound' : again ? 'netgame_more.hit.before' : 'netgame_more.hit.was';
  say(at, t(text, { name: letter(victim) }), there.x + there.r + 12, there.y - there.r - 4, hit.hit ? colours.snap : colours.faint);
  if (!hit.hit)
    say(
      at,
      t('netgame_more.hit.misses', { name: letter(who) }),
      width < LEAST ? own.x + own.r + 12 : there.x + there.r + 26,
      width < LEAST ? own.y + own.r + 6 + colours.text * 1.5 : level + colours.text * 1.5,
      colours.snap,
    );
  if (hit.end !== null) say(at, t('netgame_more.hit.behind', { name: letter(victim) }), own.x + own.r + 12, own.y + own.r + 6, colours.ink);
  const words = [`${fixed(Math.hypot(where.x - hit.own.x, where.y - hit.own.y), 1)} m`, ...(hit.hit ? [`${fixed(hit.back, 0)} ms`] : [])];
  gap(at, there, own, width < LEAST ? [words.join(' · ')] : words, (level - there.y) / 2);
  place(pen.canvas, 'judged', there.x, there.y, where.y);
  place(pen.canvas, 'own', own.x, own.y, hit.own.y);
}
