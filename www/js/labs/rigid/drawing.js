// One world of rigid bodies: shapes and, over them, what the phases of a step make of them.
import { drawText } from '../../draw/marks.js';
import { gridStep } from '../../draw/axis.js';
import { paintOf } from '../../draw/palette.js';
import { localized } from '../../base/format.js';
import { t } from '../../base/words.js';
import { drawShown, place as report, shows } from '../../draw/shown.js';

/** @typedef {import('./decode.js').Shape} Shape */
/** @typedef {import('./decode.js').Scene} Scene */
/** @typedef {{left: number, top: number, scale: number, width: number, height: number}} Camera  left and top in m; scale in px/m */
/** @typedef {{volumes: boolean, boxes: boolean, pairs: boolean, contacts: boolean, paths: boolean, islands: boolean}} Shown */
/** @typedef {CanvasRenderingContext2D} Pen */
/** @typedef {import('../../draw/palette.js').Palette} Palette */
/** @typedef {{pen: Pen, width: number, height: number}} Surface */

/** All of `view` (left, right, bottom, top in m), to one scale. @param {number[]} view @param {number} width @param {number} height
 * @returns {Camera} */
export function cameraOf(view, width, height) {
  const [left = 0, right = 1, bottom = 0, top = 1] = view;
  const scale = Math.min(width / (right - left), height / (top - bottom));
  return { left: (left + right) / 2 - width / scale / 2, top: (bottom + top) / 2 + height / scale / 2, scale, width, height };
}

/** @param {Camera} at @param {number} x */
const toX = (at, x) => (x - at.left) * at.scale;
/** @param {Camera} at @param {number} y */
const toY = (at, y) => (at.top - y) * at.scale;

/** A point of the body's frame in the drawing. @param {Camera} at @param {Shape} s @param {number} x @param {number} y */
function place(at, s, x, y) {
  const c = Math.cos(s.angle),
    n = Math.sin(s.angle);
  return [toX(at, s.x + c * x - n * y), toY(at, s.y + n * x + c * y)];
}

/** @param {Pen} pen @param {Camera} at @param {Shape} s @param {number[][]} points @param {boolean} closed */
function path(pen, at, s, points, closed) {
  pen.beginPath();
  points.forEach(([x = 0, y = 0], i) => {
    const [px = 0, py = 0] = place(at, s, x, y);
    if (i === 0) pen.moveTo(px, py);
    else pen.lineTo(px, py);
  });
  if (closed) pen.closePath();
}

/** @param {Pen} pen @param {Camera} at @param {Shape} s */
function outline(pen, at, s) {
  const { kind, radius, vertices } = s.geometry;
  if (kind === 0) {
    const [x = 0, y = 0] = place(at, s, vertices[0]?.[0] ?? 0, vertices[0]?.[1] ?? 0);
    pen.beginPath();
    pen.arc(x, y, Math.max(1, radius * at.scale), 0, 2 * Math.PI);
    pen.moveTo(x, y);
    pen.lineTo(x + radius * at.scale * Math.cos(s.angle), y - radius * at.scale * Math.sin(s.angle));
  } else if (kind === 1) {
    const [a = [], b = []] = vertices;
    const [ax = 0, ay = 0] = place(at, s, a[0] ?? 0, a[1] ?? 0),
      [bx = 0, by = 0] = place(at, s, b[0] ?? 0, b[1] ?? 0);
    const turn = Math.atan2(by - ay, bx - ax),
      r = Math.max(1, radius * at.scale);
    pen.beginPath();
    pen.arc(bx, by, r, turn - Math.PI / 2, turn + Math.PI / 2);
    pen.arc(ax, ay, r, turn + Math.PI / 2, turn + (3 * Math.PI) / 2);
    pen.closePath();
  } else {
    path(pen, at, s, kind >= 3 ? vertices.slice(0, 2) : vertices, kind === 2);
  }
}

/** By its world, or by its island. @param {Palette} colours @param {Shape} s @param {number} world @param {Shown} shown */
function paint(colours, s, world, shown) {
  if (!s.dynamic && !s.kinematic) return { fill: colours.grid, line: colours.edge };
  if (s.kinematic) return { fill: colours.edge, line: colours.ink };
  const own = paintOf(colours, shown.islands ? s.island * 5 : world);
  return { fill: own.fill, line: own.text };
}

/** @param {Pen} pen @param {Palette} colours @param {Camera} at */
function grid(pen, colours, at) {
  const step = gridStep(at.scale, 90);
  pen.setLineDash([]);
  pen.strokeStyle = colours.grid;
  pen.lineWidth = 1;
  pen.beginPath();
  for (let i = Math.ceil(at.left / step); toX(at, i * step) < at.width; i++) {
    pen.moveTo(Math.round(toX(at, i * step)) + 0.5, 0);
    pen.lineTo(Math.round(toX(at, i * step)) + 0.5, at.height);
  }
  pen.stroke();
}

/** @param {Pen} pen @param {Palette} colours @param {Camera} at */
function metres(pen, colours, at) {
  const step = gridStep(at.scale, 90);
  for (let i = Math.ceil(at.left / step); toX(at, i * step) < at.width - colours.text * 3; i++) {
    drawText(pen, colours, localized(`${Number((i * step).toPrecision(6))} m`), toX(at, i * step) + 3, at.height - colours.axis * 0.7, {
      size: colours.axis,
      colour: colours.faint,
    });
  }
}

/** @param {Pen} pen @param {Palette} colours @param {Camera} at @param {Shape[]} shapes @param {number} world @param {Shown} shown */
function bodies(pen, colours, at, shapes, world, shown) {
  pen.setLineDash([]);
  for (const s of shapes) {
    const { fill, line } = paint(colours, s, world, shown);
    outline(pen, at, s);
    if (s.geometry.kind < 3) {
      pen.globalAlpha = s.dynamic ? (s.awake ? 0.75 : 0.3) : 1;
      pen.fillStyle = fill;
      pen.fill();
      pen.globalAlpha = 1;
    }
    pen.strokeStyle = line;
    pen.lineWidth = s.geometry.kind >= 3 ? colours.line : 1;
    pen.stroke();
  }
}

/** The volume that collides in the shape's place, or the broad phase's box. @param {Pen} pen @param {Camera} at @param {Shape} s
 * @param {number} volume */
function volumeOf(pen, at, s, volume) {
  const { vertices, radius, circle, obb } = s.geometry;
  if (volume === 2) {
    const [x = 0, y = 0] = place(at, s, circle[0] ?? 0, circle[1] ?? 0);
    pen.beginPath();
    pen.arc(x, y, (circle[2] ?? 0) * at.scale, 0, 2 * Math.PI);
  } else if (volume === 3) {
    path(pen, at, s, obb, true);
  } else {
    const points = vertices.map(([x = 0, y = 0]) => place(at, s, x, y)),
      r = radius * at.scale;
    const xs = points.map((p) => p[0] ?? 0),
      ys = points.map((p) => p[1] ?? 0);
    const left = Math.min(...xs) - r,
      top = Math.min(...ys) - r;
    pen.beginPath();
    pen.rect(left, top, Math.max(...xs) + r - left, Math.max(...ys) + r - top);
  }
}

/** @param {Pen} pen @param {Palette} colours @param {Camera} at @param {Shape[]} shapes @param {number} volume 0: all three */
function volumes(pen, colours, at, shapes, volume) {
  const kinds = volume > 0 ? [volume] : [1, 2, 3];
  const dashes = [[], [6, 4], [2, 3], []];
  for (const s of shapes) {
    if (!s.dynamic && !s.kinematic) continue;
    for (const kind of kinds) {
      volumeOf(pen, at, s, kind);
      pen.strokeStyle = paintOf(colours, kind + 1).text;
      pen.setLineDash(dashes[kind] ?? []);
      pen.lineWidth = 1.5;
      pen.stroke();
    }
  }
}

/** @param {Pen} pen @param {Palette} colours @param {Camera} at @param {Shape[]} shapes */
function boxes(pen, colours, at, shapes) {
  pen.setLineDash([1, 3]);
  pen.strokeStyle = colours.faint;
  pen.lineWidth = 1;
  for (const s of shapes) {
    const [left = 0, bottom = 0, right = 0, top = 0] = s.box;
    pen.strokeRect(toX(at, s.x + left), toY(at, s.y + top), (right - left) * at.scale, (top - bottom) * at.scale);
  }
}

/** The way of the last step and the next. @param {Pen} pen @param {Palette} colours @param {Camera} at @param {Shape[]} shapes
 * @param {number} dt */
function paths(pen, colours, at, shapes, dt) {
  pen.setLineDash([]);
  pen.strokeStyle = colours.buffer;
  pen.lineWidth = colours.line;
  pen.beginPath();
  for (const s of shapes) {
    if (!s.dynamic) continue;
    pen.moveTo(toX(at, s.x - s.vx * dt), toY(at, s.y - s.vy * dt));
    pen.lineTo(toX(at, s.x + s.vx * dt), toY(at, s.y + s.vy * dt));
  }
  pen.stroke();
}

/** Where a body was at each of the last ticks, and the way between: a wall there was passed. @param {Pen} pen @param {Palette} colours
 * @param {Camera} at @param {Shape[]} places */
function swept(pen, colours, at, places) {
  pen.strokeStyle = colours.truth;
  pen.lineWidth = 1;
  pen.setLineDash([2, 4]);
  pen.beginPath();
  places.forEach((s, i) => (i === 0 ? pen.moveTo(toX(at, s.x), toY(at, s.y)) : pen.lineTo(toX(at, s.x), toY(at, s.y))));
  pen.stroke();
  pen.lineWidth = Math.min(colours.line, 2);
  for (const s of places) {
    pen.setLineDash((s.right - s.left) * at.scale < 16 ? [] : [4, 3]); /* dashes of a small one would fill it */
    outline(pen, at, s);
    pen.stroke();
  }
  pen.setLineDash([]);
}

/** @param {Pen} pen @param {Palette} colours @param {Camera} at @param {Scene} scene @param {number} world */
function pairs(pen, colours, at, scene, world) {
  /** @type {Map<number, Shape>} */
  const home = new Map();
  for (const s of scene.shapes) if (s.world === world && !home.has(s.body)) home.set(s.body, s);
  pen.strokeStyle = colours.snap;
  pen.lineWidth = 1;
  for (const c of scene.contacts) {
    const a = home.get(c.a),
      b = home.get(c.b);
    if (c.world !== world || !a || !b) continue;
    const from = a.dynamic || a.kinematic ? a : b,
      to = b.dynamic || b.kinematic ? b : a;
    const end = c.points[0] ?? { x: to.x, y: to.y };
    pen.setLineDash(c.points.length > 0 ? [] : [3, 3]);
    pen.beginPath();
    pen.moveTo(toX(at, from.x), toY(at, from.y));
    pen.lineTo(toX(at, from === to ? end.x : to.x), toY(at, from === to ? end.y : to.y));
    pen.stroke();
  }
}

/** Points, and arrows along the normals as long as the impulse is large. @param {Pen} pen @param {Palette} colours @param {Camera} at
 * @param {Scene} scene
 * @param {number} world */
function contacts(pen, colours, at, scene, world) {
  const all = scene.contacts.filter((c) => c.world === world);
  const most = Math.max(1e-9, ...all.flatMap((c) => c.points.map((p) => p.impulse)));
  const dot = Math.max(1, Math.min(3, 0.1 * at.scale)),
    arrow = Math.max(5, Math.min(30, 0.8 * at.scale));
  pen.setLineDash([]);
  pen.lineWidth = Math.min(1.5, dot);
  for (const c of all) {
    for (const p of c.points) {
      const x = toX(at, p.x),
        y = toY(at, p.y),
        long = arrow * (0.2 + 0.8 * Math.sqrt(Math.max(0, p.impulse) / most));
      pen.strokeStyle = pen.fillStyle = p.separation < -0.005 ? colours.snap : colours.accent;
      pen.beginPath();
      pen.moveTo(x, y);
      pen.lineTo(x + c.nx * long, y - c.ny * long);
      pen.stroke();
      pen.beginPath();
      if (c.recycled) pen.rect(x - dot, y - dot, 2 * dot, 2 * dot);
      else pen.arc(x, y, dot, 0, 2 * Math.PI);
      pen.fill();
    }
  }
}

/** @param {Pen} pen @param {Palette} colours @param {Camera} at @param {Scene} scene @param {number} world */
function joints(pen, colours, at, scene, world) {
  for (const j of scene.joints) {
    if (j.world !== world) continue;
    const mouse = j.type === 4;
    pen.strokeStyle = mouse ? colours.accent : colours.truth;
    pen.fillStyle = colours.paper;
    pen.lineWidth = mouse ? 2.5 : 1.5;
    pen.setLineDash(mouse ? [5, 3] : []);
    pen.beginPath();
    pen.moveTo(toX(at, j.ax), toY(at, j.ay));
    pen.lineTo(toX(at, j.bx), toY(at, j.by));
    pen.stroke();
    pen.setLineDash([]);
    pen.beginPath();
    pen.arc(toX(at, j.bx), toY(at, j.by), Math.min(3, 0.08 * at.scale), 0, 2 * Math.PI);
    if (at.scale > 15) pen.fill();
    pen.stroke();
  }
}

/** The plane behind which a body counts as passed. @param {Pen} pen @param {Palette} colours @param {Camera} at @param {number} x */
function plane(pen, colours, at, x) {
  if (!(Math.abs(x) < 1e8)) return;
  pen.setLineDash([8, 5]);
  pen.strokeStyle = colours.snap;
  pen.lineWidth = colours.line;
  pen.beginPath();
  pen.moveTo(toX(at, x), 0);
  pen.lineTo(toX(at, x), at.height);
  pen.stroke();
  drawText(pen, colours, t('rigid.passed'), toX(at, x) + 4, at.height - colours.text * 2.2, { colour: colours.snap });
}

/** Where the keys point. @param {Pen} pen @param {Palette} colours @param {Camera} at
 * @param {{x: number, y: number, held: boolean}} pointer */
function cross(pen, colours, at, pointer) {
  const x = toX(at, pointer.x),
    y = toY(at, pointer.y),
    r = pointer.held ? 6 : 10;
  pen.setLineDash([]);
  pen.strokeStyle = colours.accent;
  pen.lineWidth = 2.5;
  pen.beginPath();
  pen.moveTo(x - r, y);
  pen.lineTo(x + r, y);
  pen.moveTo(x, y - r);
  pen.lineTo(x, y + r);
  pen.stroke();
}

const TOLD = 100; /* bodies of which a lesson may say something */

/** Reports where bodies are that move: `b4` body 4, `b4.before` a step ago, `b4.other` in the next world, `b4.first` in a lesson's first
 * run; `b4.corner` its rightmost corner, `b4.box` that of its AABB above, `b4.sphere` its sphere's rightmost
 * point. @param {Pen} pen @param {Camera} at @param {Scene} scene @param {number} world
 * @param {Scene | null} first @param {number} dt s */
function tellPlaces(pen, at, scene, world, first, dt) {
  const tell = (/** @type {string} */ name, /** @type {number} */ x, /** @type {number} */ y) =>
    report(pen.canvas, name, toX(at, x), toY(at, y), shows.value?.along === 'y' ? y : x);
  const moving = (/** @type {Scene} */ of, /** @type {number} */ w) => of.shapes.filter((s) => s.world === w && s.dynamic);
  const own = moving(scene, world);
  if (own.length > TOLD) return;
  for (const s of own) {
    const corners = s.geometry.vertices.map(([x = 0, y = 0]) => place(at, s, x, y)),
      right = corners.sort((a, b) => (b[0] ?? 0) - (a[0] ?? 0))[0] ?? [0, 0],
      circle = s.geometry.circle;
    const px = (/** @type {string} */ name, /** @type {number} */ x, /** @type {number} */ y) =>
      report(pen.canvas, `b${s.body}.${name}`, x, y);
    px('corner', right[0] ?? 0, right[1] ?? 0);
    px('box', right[0] ?? 0, Math.min(...corners.map(([, y = 0]) => y)));
    px('sphere', toX(at, s.x) + (circle[2] ?? 0) * at.scale, toY(at, s.y));
    tell(`b${s.body}`, s.x, s.y);
    tell(`b${s.body}.before`, s.x - s.vx * dt, s.y - s.vy * dt);
  }
  for (const s of moving(scene, world === 0 ? 1 : 0)) tell(`b${s.body}.other`, s.x, s.y);
  if (first) for (const s of moving(first, world)) tell(`b${s.body}.first`, s.x, s.y);
}

/** The first run of a lesson, faded. @param {Pen} pen @param {Palette} colours @param {Camera} at @param {Scene} first
 * @param {number} world @param {Shown} shown */
function ghosts(pen, colours, at, first, world, shown) {
  pen.setLineDash([]);
  pen.lineWidth = 1;
  for (const s of first.shapes.filter((one) => one.world === world && one.dynamic)) {
    const { fill, line } = paint(colours, s, world, shown);
    outline(pen, at, s);
    pen.globalAlpha = 0.2;
    pen.fillStyle = fill;
    pen.fill();
    pen.globalAlpha = 0.5;
    pen.strokeStyle = line;
    pen.stroke();
    pen.globalAlpha = 1;
  }
}

/** @param {Surface} surface @param {Palette} colours @param {Scene} scene
 * @param {{world: number, view: number[], shown: Shown, volume: number, dt: number, beyond: number, name: string,
 *   places: Shape[][], first?: Scene | null, pointer: {x: number, y: number, held: boolean} | null}} of @returns {Camera} */
export function drawWorld(surface, colours, scene, of) {
  const { pen } = surface;
  const at = cameraOf(of.view, surface.width, surface.height);
  const shapes = scene.shapes.filter((s) => s.world === of.world);
  grid(pen, colours, at);
  if (of.first) ghosts(pen, colours, at, of.first, of.world, of.shown);
  bodies(pen, colours, at, shapes, of.world, of.shown);
  joints(pen, colours, at, scene, of.world);
  metres(pen, colours, at);
  if (of.shown.boxes) boxes(pen, colours, at, shapes);
  if (of.shown.volumes) volumes(pen, colours, at, shapes, of.volume);
  if (of.shown.pairs) pairs(pen, colours, at, scene, of.world);
  if (of.shown.paths) {
    paths(pen, colours, at, shapes, of.dt);
    for (const places of of.places) swept(pen, colours, at, places);
  }
  if (of.shown.contacts) contacts(pen, colours, at, scene, of.world);
  plane(pen, colours, at, of.beyond);
  if (of.pointer) cross(pen, colours, at, of.pointer);
  drawText(pen, colours, of.name, 8, colours.text, { bold: true, colour: paintOf(colours, of.world).text });
  tellPlaces(pen, at, scene, of.world, of.first ?? null, of.dt);
  drawShown(pen, colours);
  return at;
}
