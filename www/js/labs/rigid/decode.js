// What a frame has of rigid bodies, put together: shapes with their geometries, contacts with their points.
import { SHAPES_FLAGS, VOLUMES_VOLUME } from '../../stream/names.js';

/** @typedef {import('../../stream/rows.js').WorldsRow} World  status: 0 ok, 1 diverged */
/** @typedef {import('../../stream/rows.js').JointsRow} Joint */
/** @typedef {import('../../stream/rows.js').VolumesRow} Judged */
/** In the frame of the centre of mass.
 * @typedef {{kind: number, radius: number, vertices: number[][], circle: number[], obb: number[][]}} Geometry */
/**
 * @typedef
 *  {Omit<import('../../stream/rows.js').ShapesRow, 'geometry'> & {geometry: Geometry, dynamic: boolean, kinematic: boolean, awake: boolean,
 *   box: number[]}} Shape  box: left, bottom, right, top from x, y */
/** @typedef {import('../../stream/rows.js').ContactsRow & {points: {x: number, y: number, separation: number, impulse: number}[]}} Contact
 *   without points: the boxes overlap and that is all */
/** @typedef {{worlds: World[], shapes: Shape[], contacts: Contact[], joints: Joint[], judged: Judged[]}} Scene */

export const VOLUMES = Object.keys(VOLUMES_VOLUME);

/** @param {import('../../stream/frame.js').Frame} frame @returns {Geometry[]} */
const geometriesOf = (frame) =>
  frame.geometries.map((g, i) => ({
    kind: g.kind,
    radius: g.radius,
    circle: [g.circle_x, g.circle_y, g.circle_radius],
    obb: [
      [g.obb_x0, g.obb_y0],
      [g.obb_x1, g.obb_y1],
      [g.obb_x2, g.obb_y2],
      [g.obb_x3, g.obb_y3],
    ],
    vertices: frame.where('vertices', 'geometry', i).map(({ x, y }) => [x, y]),
  }));

/** @param {import('../../stream/rows.js').ContactsRow} c @returns {Contact} */
function contact(c) {
  const points = [
    { x: c.x0, y: c.y0, separation: c.separation0, impulse: c.impulse0 },
    { x: c.x1, y: c.y1, separation: c.separation1, impulse: c.impulse1 },
  ];
  return { ...c, points: points.slice(0, c.count) };
}

/** @param {import('../../stream/frame.js').Frame} frame @returns {Scene} */
export function sceneOf(frame) {
  const geometries = geometriesOf(frame);
  return {
    worlds: frame.worlds,
    shapes: frame.shapes.map((s) => ({
      ...s,
      geometry: /** @type {Geometry} */ (geometries[s.geometry]),
      dynamic: (s.flags & SHAPES_FLAGS.dynamic) !== 0,
      kinematic: (s.flags & SHAPES_FLAGS.kinematic) !== 0,
      awake: (s.flags & SHAPES_FLAGS.awake) !== 0,
      box: [s.left, s.bottom, s.right, s.top],
    })),
    contacts: frame.contacts.map(contact),
    joints: frame.joints,
    judged: frame.volumes,
  };
}
