// Drawings of a run on a small canvas, by the kind of its scenario: what the method makes of it, and where that truly is.
import { gridStep } from '../../draw/axis.js';
import { drawCar, drawCarGhost, hasCar } from '../../draw/cars.js';
import { drawText } from '../../draw/marks.js';
import { paintOf } from '../../draw/palette.js';
import { letter } from '../../base/format.js';
import { ENTITIES_FLAGS, VIEWS_FLAGS } from '../../stream/names.js';
import { t } from '../../base/words.js';
import { fluidsOf } from '../fluid/decode.js';
import { drawScene } from '../fluid/drawing.js';
import { Scale } from '../fluid/scale.js';
import { sceneOf } from '../rigid/decode.js';
import { drawWorld } from '../rigid/drawing.js';
import { compare, factorOf } from './lens.js';
import { brief } from './names.js';
import { drawShot } from './shots.js';
import { STRIP_PX, STRIP_S, drawStrip } from './strip.js';

/** @typedef {import('./live.js').Run} Run */
/** @typedef {import('../../draw/palette.js').Palette} Palette */
/** @typedef {{pen: CanvasRenderingContext2D, width: number, height: number}} Surface */
/** @typedef {import('../../stream/rows.js').EntitiesRow} Entity */
/** fill: of the method's mark; line: of its letters and lines; peer: what runs next to it, in the same colours; lead: it chooses what both
 * show; error:
 * path of the metric
 * @typedef {{fill: string, line: string, peer: Run | null, lead: boolean, error: string}} Look */
/** px: between the two that are compared, as shown, 0 where nothing is; factor: of the lens, 1: there is none; 0: no lens is enough
 * @typedef {{px: number, factor: number}} Seen */

// ---- motion ----

/** @param {Float64Array[]} list @param {number} component @param {number} tick between two */
function between(list, component, tick) {
  const values = list[component],
    k = Math.floor(tick),
    a = values?.[k] ?? Number.NaN,
    b = values?.[k + 1] ?? a;
  return a + (b - a) * (tick - k);
}

/** The way of a body up to a tick: from each place to the next by their velocities too, so that a fast turn is round.
 * @param {CanvasRenderingContext2D} pen @param {Float64Array[]} list x, y, their velocities @param {number} tick @param {number} hz
 * @param {(x: number, y: number) => [number, number]} to */
function orbit(pen, list, tick, hz, to) {
  const [x, y, vx, vy] = list;
  if (!x || !y || !vx || !vy) return;
  const third = 1 / hz / 3;
  pen.beginPath();
  let open = false;
  for (let k = 0; k <= tick; k++) {
    const ax = x[k] ?? Number.NaN,
      ay = y[k] ?? Number.NaN;
    if (!Number.isFinite(ax) || Math.abs(ax) > 50 || Math.abs(ay) > 50) {
      open = false;
      continue;
    }
    if (open) {
      const px = x[k - 1] ?? ax,
        py = y[k - 1] ?? ay;
      pen.bezierCurveTo(
        ...to(px + (vx[k - 1] ?? 0) * third, py + (vy[k - 1] ?? 0) * third),
        ...to(ax - (vx[k] ?? 0) * third, ay - (vy[k] ?? 0) * third),
        ...to(ax, ay),
      );
    } else pen.moveTo(...to(ax, ay));
    open = true;
  }
  pen.stroke();
}

/** @param {Surface} surface @param {Palette} colours @param {Run} run @param {Look} look @returns {Seen} */
function plane(surface, colours, run, look) {
  const { pen, width, height } = surface,
    { exact, own, hz } = /** @type {import('./live.js').History} */ (run.history),
    { tick } = run;
  const xs = exact[0] ?? new Float64Array(),
    ys = exact[1] ?? new Float64Array();
  const [x0, x1, y0, y1] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
  const scale = Math.min((width - 40) / (x1 - x0), (height - 34) / (y1 - y0));
  const half = ((x1 - x0) * scale) / 2,
    left = Math.max(half + 14, Math.min(width * 0.55, width - half - 20)),
    to = (/** @type {number} */ x, /** @type {number} */ y) =>
      /** @type {[number, number]} */ ([left + (x - (x0 + x1) / 2) * scale, height / 2 - (y - (y0 + y1) / 2) * scale]);
  pen.lineJoin = 'round';
  pen.setLineDash([]);
  pen.strokeStyle = look.fill;
  pen.lineWidth = colours.line + 1.5;
  orbit(pen, own, tick, hz, to);
  pen.strokeStyle = colours.truth;
  pen.lineWidth = 1.5;
  pen.setLineDash([6, 4]);
  orbit(pen, exact, exact[0]?.length ?? 0, hz, to);
  pen.setLineDash([]);
  const [sunX, sunY] = to(0, 0);
  pen.fillStyle = colours.buffer;
  pen.beginPath();
  pen.arc(sunX, sunY, 8, 0, 2 * Math.PI);
  pen.fill();
  pen.strokeStyle = colours.truth;
  pen.lineWidth = 1.5;
  pen.stroke();
  const [ax, ay] = to(between(own, 0, tick), between(own, 1, tick)),
    [bx, by] = to(between(exact, 0, tick), between(exact, 1, tick));
  if (!Number.isFinite(ax)) {
    drawText(pen, colours, t('workbench.diverged'), width / 2, height - 14, { align: 'center', bold: true, colour: colours.snap });
    return { px: 0, factor: 1 };
  }
  /* one that is lost stays at the edge */
  const drawn = { x: Math.max(10, Math.min(width - 10, ax)), y: Math.max(10, Math.min(height - 10, ay)) },
    real = { x: bx, y: by };
  /* the lens is chosen for the end: it does not change while the run is watched */
  const last = (exact[0]?.length ?? 1) - 1,
    far = Math.hypot((own[0]?.[last] ?? 0) - (exact[0]?.[last] ?? 0), (own[1]?.[last] ?? 0) - (exact[1]?.[last] ?? 0));
  const factor = factorOf(far * scale),
    text = t('tradeoff.at_end', { figure: brief(far) });
  const shown = run.state === 'done' ? factor : 0;
  const px = compare(surface, colours, { drawn, real }, { text, fill: look.fill, at: 0, factor: shown });
  return { px: run.state === 'done' ? px : 0, factor };
}

/** Values over time: each component's solution dashed, the method's solid. @param {Surface} surface @param {Palette} colours
 * @param {Run} run @param {Look} look @returns {Seen} */
function curves(surface, colours, run, look) {
  const { pen, width, height } = surface,
    { exact, own } = /** @type {import('./live.js').History} */ (run.history),
    tick = Math.floor(run.tick),
    ticks = (exact[0]?.length ?? 1) - 1;
  const top = colours.text * 3.4,
    bottom = height - 12,
    toX = (/** @type {number} */ k) => 14 + (k / Math.max(1, ticks)) * (width - 28);
  const shown = exact.map((list, k) => ({ list, k, most: Math.max(...list.map(Math.abs)) })).filter(({ most }) => most > 1e-3);
  const toY = (/** @type {number} */ value) => bottom - Math.max(-0.1, Math.min(1.15, value)) * (bottom - top);
  const curve = (/** @type {Float64Array | undefined} */ list, /** @type {number} */ until) => {
    pen.beginPath();
    let open = false;
    for (let k = 0; k <= until; k++) {
      const value = list?.[k] ?? Number.NaN;
      if (!Number.isFinite(value)) {
        open = false;
        continue;
      }
      if (open) pen.lineTo(toX(k), toY(value));
      else pen.moveTo(toX(k), toY(value));
      open = true;
    }
    pen.stroke();
  };
  for (const { list, k } of shown) {
    pen.setLineDash([]);
    pen.strokeStyle = look.fill;
    pen.lineWidth = colours.line + 2;
    curve(own[k], tick);
    pen.setLineDash([6, 4]);
    pen.strokeStyle = colours.truth;
    pen.lineWidth = 1.5;
    curve(list, ticks);
  }
  pen.setLineDash([]);
  const values = own[shown[0]?.k ?? 0],
    lost = values ? values.findIndex((value) => !Number.isFinite(value)) : 0;
  if (lost >= 0 && lost <= tick)
    drawText(pen, colours, t('workbench.diverged'), width / 2, height / 2, { align: 'center', bold: true, colour: colours.snap });
  return { px: 0, factor: 1 };
}

/** @param {Surface} surface @param {Palette} colours @param {Run} run @param {Look} look @returns {Seen} */
function motion(surface, colours, run, look) {
  if (run.history === null) return { px: 0, factor: 1 };
  return run.history.exact.length === 4 ? plane(surface, colours, run, look) : curves(surface, colours, run, look);
}

// ---- bodies ----

const BARE = { volumes: false, boxes: false, pairs: false, contacts: false, paths: false, islands: false };

/** @param {Surface} surface @param {Palette} colours @param {Run} run @param {Look} look @returns {Seen} */
function rigid(surface, colours, run, look) {
  const frame = run.frame,
    first = run.first;
  if (!frame || !first || !run.layout) return { px: 0, factor: 1 };
  const scene = sceneOf(frame),
    before = (run.memory ??= sceneOf(first)).shapes;
  /** The body that has moved the most. */
  let most = -1,
    at = 0;
  scene.shapes.forEach((shape, i) => {
    const was = before[i];
    if (!shape.dynamic || !was) return;
    const far = Math.hypot(shape.x - was.x, shape.y - was.y);
    if (far > most) [most, at] = [far, i];
  });
  const moved = scene.shapes[at],
    was = before[at];
  /* all that can move, and some ground */
  const bodies = scene.shapes.filter(({ dynamic }) => dynamic),
    low = Math.min(...before.filter((/** @type {any} */ one) => one.dynamic).map((/** @type {any} */ one) => one.y + one.bottom)),
    high = Math.max(...before.filter((/** @type {any} */ one) => one.dynamic).map((/** @type {any} */ one) => one.y + one.top)),
    middle = bodies.reduce((sum, { x }) => sum + x, 0) / Math.max(1, bodies.length);
  const tall = (high - low) * 1.16,
    view = [middle - 1, middle + 1, low - tall * 0.06, high + tall * 0.08];
  const camera = drawWorld(surface, { ...colours, players: [{ fill: look.fill, text: look.line, dash: [] }] }, scene, {
    world: 0,
    view,
    shown: BARE,
    volume: 0,
    dt: 1 / 60,
    beyond: 1e9,
    name: '',
    places: [],
    pointer: null,
  });
  if (!moved || !was || scene.worlds[0]?.status === 1) return { px: 0, factor: 1 };
  const place = (/** @type {{x: number, y: number}} */ { x, y }) => ({
    x: (x - camera.left) * camera.scale,
    y: (camera.top - y) * camera.scale,
  });
  const factor = factorOf(most * camera.scale);
  const px = compare(
    surface,
    colours,
    { drawn: place(moved), real: place(was) },
    { text: `${brief(most)} m`, fill: look.fill, at: 1, factor },
  );
  return { px, factor };
}

// ---- fluids ----

/** @param {Surface} surface @param {Palette} colours @param {Run} run @param {Look} look @returns {Seen} */
function fluid(surface, colours, run, look) {
  const now = run.frame ? fluidsOf(run.frame)[0] : undefined,
    of = run.layout?.fluid;
  if (!now || !of || !run.frame) return { px: 0, factor: 1 };
  run.memory ??= { scale: new Scale('m/s'), seq: -1, most: 0 };
  const fields = of.layers.filter((/** @type {any} */ layer) => layer.shape === 'field'),
    shown = fields[Math.min(run.layout.params?.shown ?? 0, fields.length - 1)],
    water = /surface|height/.test(shown?.name ?? '');
  const { scale } = run.memory;
  if (run.memory.seq !== run.frame.seq) {
    run.memory.seq = run.frame.seq;
    if (now.field) scale.take(now.field);
    else {
      const { columns, values, count } = now.points[0] ?? { columns: 0, values: new Float32Array(), count: 0 },
        names = of.layers[now.points[0]?.layer ?? 0]?.columns ?? [],
        hue = names.findIndex((/** @type {string} */ name) => /speed|mps$/.test(name));
      let most = 0;
      for (let i = 0; i < count && hue >= 0; i++) most = Math.max(most, Math.abs(values[i * columns + hue] ?? 0));
      scale.follow(most, false);
    }
  }
  /* both have the colours of that which has more */
  const other = look.peer?.memory?.scale;
  const both = new Scale('m/s');
  both.follow(Math.max(scale.most, other?.most ?? 0), scale.signed || other?.signed === true);
  /* what floats is not compared */
  const compared = now.points.filter((list) => !of.layers[list.layer]?.columns?.includes('z_m'));
  const points = compared.map((list) => {
    const layer = of.layers[list.layer];
    return { of: list, columns: layer?.columns ?? [], line: layer !== undefined && /surface|height/.test(layer.name) };
  });
  drawScene(surface, colours, {
    view: of.view,
    field: now.field,
    points,
    scale: both,
    word: '',
    water,
    cells: false,
    relief: water,
    hand: null,
    still: run.state === 'done',
    note: now.state.status === 1 ? t('workbench.diverged') : '',
  });
  return { px: 0, factor: 1 };
}

// ---- games ----

const WIDE_M = 22 /* of the road or the ground that is shown */,
  NARROW_M = 11; /* where errors are of the past, which are small */
const KEEP_S = 1.5; /* the lens stays on one thing */

/** The view whose error it is: of the player that the error names. @param {Run} run */
const viewOf = (run) => 1 + Number(/players\.(\d)/.exec(run.memory?.error ?? '')?.[1] ?? 0);

/** Where the server had it at the time that is drawn. @param {Run} run @param {number} entity @param {number} time s
 * @returns {{x: number, y: number} | undefined} */
function trueAt(run, entity, time) {
  /** @type {{t: number, places: {x: number, y: number}[]}[]} */
  const list = run.memory.past;
  for (let i = list.length - 1; i > 0; i--) {
    const a = list[i - 1],
      b = list[i],
      from = a?.places[entity],
      to = b?.places[entity];
    if (!a || !b || !from || !to || a.t > time) continue;
    const share = b.t > a.t ? Math.min(1, (time - a.t) / (b.t - a.t)) : 1;
    return { x: from.x + (to.x - from.x) * share, y: from.y + (to.y - from.y) * share };
  }
  return undefined;
}

/** @param {Surface} surface @param {Palette} colours @param {Run} run @param {Look} look @returns {Seen} */
function netgame(surface, colours, run, look) {
  const { frame } = run,
    { error } = look;
  if (error.includes('.shots.')) return drawShot(surface, colours, run, look);
  if (!frame || !run.layout) return { px: 0, factor: 1 };
  run.memory ??= { error, past: [], seq: -1, pair: -1, since: 0, factor: 0, most: 0, gaps: [], each: [], high: 0 };
  const memory = run.memory,
    view = viewOf(run),
    drawn = /** @type {Entity[]} */ (frame.where('entities', 'view', view)),
    real = /** @type {Entity[]} */ (frame.where('entities', 'view', 0)),
    own = drawn[view - 1];
  if (!own) return { px: 0, factor: 1 };
  if (memory.seq !== frame.seq) {
    memory.seq = frame.seq;
    memory.fresh = true;
    memory.past.push({ t: frame.time_s, places: real.map(({ x, y }) => ({ x, y })) });
    if (memory.past.length > 240) memory.past.shift();
  }
  const late = error.includes('timeline');
  const truth = (/** @type {number} */ i) => (late ? trueAt(run, i, frame.time_s - (drawn[i]?.age_ms ?? 0) / 1000) : real[i]);
  const { pen, width } = surface,
    height = surface.height - STRIP_PX,
    shapes = run.layout.entities ?? [],
    track = shapes.length === 0;
  const rival = view === 1 ? 1 : 0 /* among the players */,
    foe = drawn[rival] ?? own;
  const wide = late ? NARROW_M : WIDE_M,
    scale = width / wide,
    focus = track ? foe : own;
  const levels = track ? [...new Set(real.map(({ y }) => y))].sort((a, b) => a - b) : [];
  const toX = (/** @type {number} */ x) => width * 0.42 + (x - focus.x) * scale;
  const toY = (/** @type {number} */ y) => {
    if (!track) return height / 2 - (y - focus.y) * scale;
    const lane = levels.length > 1 ? (y - (levels[0] ?? 0)) / ((levels.at(-1) ?? 1) - (levels[0] ?? 0)) : 0.5;
    return height * (0.2 + 0.6 * lane);
  };
  pen.fillStyle = track ? colours.road : colours.verge;
  pen.fillRect(0, 0, width, height);
  pen.strokeStyle = track ? colours.roadMarks : colours.grid;
  pen.lineWidth = 2;
  pen.setLineDash([]);
  const step = track ? 5 : gridStep(scale, 60);
  for (let i = Math.floor((focus.x - wide) / step); toX(i * step) < width; i++) {
    const x = toX(i * step);
    pen.beginPath();
    if (track)
      for (let lane = 1; lane < levels.length; lane++) {
        const y = (toY(levels[lane - 1] ?? 0) + toY(levels[lane] ?? 0)) / 2;
        pen.moveTo(x, y);
        pen.lineTo(x + scale * 2, y);
      }
    else {
      pen.moveTo(x, 0);
      pen.lineTo(x, height);
    }
    pen.stroke();
  }
  const size = Math.min(height * 0.2, 30);
  const seen = (/** @type {Entity} */ e, /** @type {number} */ i) =>
    (e.flags & ENTITIES_FLAGS.unknown) === 0 && (shapes[i]?.kind !== 'shell' || (e.flags & ENTITIES_FLAGS.active) !== 0);
  const inside = (/** @type {Entity} */ e) => toX(e.x) > 0 && toX(e.x) < width && toY(e.y) > 0 && toY(e.y) < height;
  const truer = (run.row.error[0] ?? Number.POSITIVE_INFINITY) <= (look.peer?.row.error[0] ?? Number.POSITIVE_INFINITY);
  let best = -1,
    far = Number.NEGATIVE_INFINITY,
    kept = 0,
    sum = 0,
    count = 0;
  for (let i = drawn.length - 1; i >= 0; i--) {
    const e = drawn[i],
      there = truth(i);
    if (!e || !seen(e, i)) continue;
    thing(pen, colours, { shape: shapes[i], i, x: toX(e.x), y: toY(e.y), angle: e.angle, scale, size, track });
    if (i === view - 1 || !there) continue;
    const gap = Math.hypot(there.x - e.x, there.y - e.y);
    sum += gap;
    count++;
    memory.each[i] = gap;
    if (!inside(e)) continue;
    /* that shows best how the two differ which the truer has near and the other far off */
    const other = look.peer?.memory?.each?.[i],
      apart = other === undefined ? gap : truer ? other - gap : gap - other;
    if (i === memory.pair) kept = apart;
    if (apart > far) [far, best] = [apart, i];
  }
  const time = frame.time_s;
  if (memory.fresh && count > 0 && time > (run.layout.params?.warmup_s ?? 0)) {
    const gap = sum / count;
    memory.fresh = false;
    memory.gaps.push({ t: time, gap });
    if (memory.gaps.length > STRIP_S * 60) memory.gaps.shift();
    memory.high = Math.max(memory.high, gap);
  }
  const led = look.lead ? -1 : (look.peer?.memory?.pair ?? -1),
    next = track ? rival : drawn[led] && inside(drawn[led]) ? led : best;
  const lost = !drawn[memory.pair] || !inside(drawn[memory.pair]);
  if (
    memory.pair !== next &&
    (memory.pair < 0 || next === led || time - memory.since > KEEP_S || kept < 0 || lost || run.state === 'done')
  ) {
    memory.pair = next;
    memory.since = time;
    memory.most = 0;
  }
  drawStrip(surface, colours, run, look.peer);
  const e = drawn[memory.pair],
    there = truth(memory.pair);
  if (!e || !there) return { px: 0, factor: 1 };
  const gap = Math.hypot(there.x - e.x, there.y - e.y);
  /* the largest of the last moments, of both: the lens does not breathe, and both have the same */
  memory.most = Math.max(memory.most, gap);
  const both = factorOf(Math.max(memory.most, look.peer?.memory?.pair === memory.pair ? look.peer?.memory?.most : 0) * scale);
  memory.factor = both === 1 ? factorOf(memory.most * scale) : both;
  if (frame.views.some(({ flags }) => flags & VIEWS_FLAGS.stalled))
    drawText(pen, colours, t('tradeoff.waits'), 8, height - 12, { bold: true, colour: colours.snap });
  if (track && hasCar(memory.pair)) drawCarGhost(pen, colours, memory.pair, toX(there.x), toY(there.y), size);
  if (memory.factor === 0) return { px: gap * scale, factor: 0 };
  const px = compare(
    { pen, width, height },
    colours,
    { drawn: { x: toX(e.x), y: toY(e.y) }, real: { x: toX(there.x), y: toY(there.y) } },
    {
      text: t('tradeoff.gap_now', { name: track ? letter(memory.pair) : '', figure: `${brief(gap)} m` }).trim(),
      fill: paintOf(colours, memory.pair).fill,
      at: 1,
      factor: memory.factor,
    },
  );
  return { px, factor: memory.factor };
}

/** @param {CanvasRenderingContext2D} pen @param {Palette} colours @param {{shape: any, i: number, x: number, y: number, angle: number,
 * scale: number, size: number, track: boolean}} of */
function thing(pen, colours, { shape, i, x, y, angle, scale, size, track }) {
  if (track && hasCar(i)) {
    drawCar(pen, colours, i, x, y, size);
    return;
  }
  const w = Math.max(5, (shape?.width_m ?? 1.2) * scale),
    h = Math.max(5, (shape?.height_m ?? 1.2) * scale),
    player = track || shape?.kind === 'player';
  pen.save();
  pen.translate(x, y);
  pen.rotate(-angle);
  pen.beginPath();
  if (shape?.round || track) pen.arc(0, 0, Math.max(w / 2, player ? 8 : 3), 0, 2 * Math.PI);
  else pen.rect(-w / 2, -h / 2, w, h);
  pen.fillStyle = player ? paintOf(colours, i).fill : colours.grid;
  pen.fill();
  pen.lineWidth = 1.2;
  pen.strokeStyle = player ? colours.truth : colours.edge;
  pen.stroke();
  pen.restore();
  if (player)
    drawText(pen, { ...colours, paper: paintOf(colours, i).fill, ink: colours.onFill }, letter(i), x, y + 1, {
      align: 'center',
      bold: true,
      size: 11,
    });
}

/** @type {Record<string, (surface: Surface, colours: Palette, run: Run, look: Look) => Seen>} */
const DRAWINGS = { motion, rigid, fluid, netgame };

/** Draws a run. @param {Surface} surface @param {Palette} colours @param {Run} run @param {Look} look @returns {Seen} */
export const drawRun = (surface, colours, run, look) => DRAWINGS[run.kind]?.(surface, colours, run, look) ?? { px: 0, factor: 1 };
