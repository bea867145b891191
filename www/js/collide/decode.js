// Decodes a frame's sections of rigid bodies, 32 to 37.

/** @typedef {{world: number, status: number, solver: number, dragging: boolean, bodies: number, awake: number, pairs: number, touching: number,
 *   points: number, recycled: number, tested: number, islands: number, passed: number, stopped: number, joints: number, energy: number,
 *   energyStart: number, kinetic: number, penetration: number, penetrationWorst: number, sag: number, drift: number, tilt: number,
 *   jointError: number, speedMax: number, dynamic: number}} World  status: 0 ok, 1 diverged */
/** In the frame of the centre of mass. kind: 0 circle, 1 capsule, 2 polygon, 3 segment, 4 link.
 * @typedef {{kind: number, radius: number, vertices: number[][], circle: number[], obb: number[][]}} Geometry */
/** @typedef {{body: number, geometry: Geometry, world: number, dynamic: boolean, kinematic: boolean, awake: boolean, x: number, y: number,
 *   angle: number, vx: number, vy: number, spin: number, box: number[], island: number}} Shape  box: left, bottom, right, top from x, y */
/** @typedef {{a: number, b: number, world: number, recycled: boolean, nx: number, ny: number,
 *   points: {x: number, y: number, separation: number, impulse: number}[]}} Contact  without points: the boxes overlap and that is all */
/** @typedef {{a: number, b: number, world: number, type: number, ax: number, ay: number, bx: number, by: number}} Joint */
/** @typedef {{world: number, volume: number, tests: number, hits: number, falseHits: number, missedHits: number, gapMean: number, gapMax: number}} Judged */
/** @typedef {{worlds: World[], shapes: Shape[], contacts: Contact[], joints: Joint[], judged: Judged[]}} Scene */
/** @typedef {import('../frame.js').Section} Section */

export const VOLUMES = ['exact', 'AABB', 'sphere', 'OBB'];

/** @template T @param {Section | undefined} section @param {number} least bytes of a record @param {(d: DataView, at: number) => T} read @returns {T[]} */
function all(section, least, read) {
  if (!section || section.stride < least) return [];
  return Array.from({ length: section.count }, (_, i) => read(section.bytes, i * section.stride));
}

/** @param {DataView} d @param {number} at @returns {World} */
function world(d, at) {
  const u = (/** @type {number} */ i) => d.getUint32(at + 4 + 4 * i, true), f = (/** @type {number} */ i) => d.getFloat64(at + 48 + 8 * i, true);
  return {
    world: d.getUint8(at), status: d.getUint8(at + 1), solver: d.getUint8(at + 2), dragging: d.getUint8(at + 3) === 1,
    bodies: u(0), awake: u(1), pairs: u(2), touching: u(3), points: u(4), recycled: u(5), tested: u(6), islands: u(7), passed: u(8),
    stopped: u(9), joints: u(10), energy: f(0), energyStart: f(1), kinetic: f(2), penetration: f(3), penetrationWorst: f(4), sag: f(5),
    drift: f(6), tilt: f(7), jointError: f(8), speedMax: f(9), dynamic: d.getUint32(at + 148, true),
  };
}

/** @param {DataView} d @param {number} at @returns {Geometry} */
function geometry(d, at) {
  const f = (/** @type {number} */ offset) => d.getFloat32(at + offset, true);
  const pairs = (/** @type {number} */ from, /** @type {number} */ count) => Array.from({ length: count }, (_, i) => [f(from + 8 * i), f(from + 8 * i + 4)]);
  return { kind: d.getUint8(at), radius: f(4), vertices: pairs(8, Math.min(8, d.getUint8(at + 1))), circle: [f(72), f(76), f(80)], obb: pairs(88, 4) };
}

/** @param {DataView} d @param {number} at @param {Geometry[]} geometries @returns {Shape} */
function shape(d, at, geometries) {
  const f = (/** @type {number} */ offset) => d.getFloat32(at + offset, true);
  const flags = d.getUint8(at + 7);
  return {
    body: d.getUint32(at, true), geometry: /** @type {Geometry} */ (geometries[d.getUint16(at + 4, true)]), world: d.getUint8(at + 6),
    dynamic: (flags & 1) !== 0, kinematic: (flags & 2) !== 0, awake: (flags & 4) !== 0, x: d.getFloat64(at + 8, true),
    y: d.getFloat64(at + 16, true), angle: f(24), vx: f(28), vy: f(32), spin: f(36), box: [f(40), f(44), f(48), f(52)],
    island: d.getUint32(at + 56, true),
  };
}

/** @param {DataView} d @param {number} at @returns {Contact} */
function contact(d, at) {
  const point = (/** @type {number} */ from) => ({
    x: d.getFloat64(from, true), y: d.getFloat64(from + 8, true), separation: d.getFloat32(from + 16, true), impulse: d.getFloat32(from + 20, true),
  });
  return {
    a: d.getUint32(at, true), b: d.getUint32(at + 4, true), world: d.getUint8(at + 8), recycled: d.getUint8(at + 10) === 1,
    nx: d.getFloat32(at + 12, true), ny: d.getFloat32(at + 16, true),
    points: Array.from({ length: Math.min(2, d.getUint8(at + 9)) }, (_, i) => point(at + 24 + 24 * i)),
  };
}

/** @param {DataView} d @param {number} at @returns {Joint} */
function joint(d, at) {
  const f = (/** @type {number} */ i) => d.getFloat64(at + 16 + 8 * i, true);
  return { a: d.getUint32(at, true), b: d.getUint32(at + 4, true), world: d.getUint8(at + 8), type: d.getUint8(at + 9), ax: f(0), ay: f(1), bx: f(2), by: f(3) };
}

/** @param {DataView} d @param {number} at @returns {Judged} */
function judged(d, at) {
  const f = (/** @type {number} */ i) => d.getFloat64(at + 8 + 8 * i, true);
  return { world: d.getUint8(at), volume: d.getUint8(at + 1), tests: f(0), hits: f(1), falseHits: f(2), missedHits: f(3), gapMean: f(4), gapMax: f(5) };
}

/** @param {import('../frame.js').Frame} frame @returns {Scene} */
export function sceneOf(frame) {
  const geometries = all(frame.own.get(33)?.[0], 120, geometry);
  return {
    worlds: all(frame.own.get(32)?.[0], 152, world), shapes: all(frame.own.get(34)?.[0], 64, (d, at) => shape(d, at, geometries)),
    contacts: all(frame.own.get(35)?.[0], 72, contact), joints: all(frame.own.get(36)?.[0], 48, joint), judged: all(frame.own.get(37)?.[0], 56, judged),
  };
}
