// What of a long track is shown where it is shown large: the cars, and room before and behind them.
import { entitiesOf } from '../core/frame.js';

/** @typedef {import('../core/layout.js').Layout} Layout */

const LEAST_M = 30; /* long enough for a car, its ghost and their label */
const STEP = 1.25; /* the part shown grows by this factor: its scale changes seldom */
const AHEAD = 0.55; /* where the foremost car is, from the left */

const BEFORE_M = 2.5; /* a car at the start is whole */

const NARROW = 500; /* px */

/** @param {Layout} layout @param {number} left m @param {number} wide m @returns {Layout} */
const part = (layout, left, wide) => ({ ...layout, scene: { ...layout.scene, x_min: left, x_max: left + wide, wraps: false } });

/** Places, and room before and behind them. @param {Layout} layout @param {number[]} xs m @param {number} least m @returns {Layout} */
function around(layout, xs, least) {
  const front = Math.max(...xs),
    needed = (front - Math.min(...xs)) / (AHEAD - 0.2);
  const wide = Math.max(least, least * STEP ** Math.ceil(Math.log(Math.max(needed, least) / least) / Math.log(STEP)));
  return part(layout, Math.max(layout.scene.x_min - BEFORE_M, front - wide * AHEAD), wide);
}

/** As a lesson wants it. @param {Layout} layout @param {import('../core/frame.js').Frame} frame
 * @param {import('../../../session/state.js').Camera | null} camera @param {number} width of the view, px @returns {Layout} */
export function framed(layout, frame, camera, width) {
  if (camera === null || layout.entities.length > 0) return layout;
  if (layout.controls === 'aim' && camera.from === undefined) return layout;
  const narrow = width < NARROW,
    wide = narrow ? camera.narrow_m : camera.m,
    from = narrow ? (camera.narrow_from ?? camera.from) : camera.from;
  if (from !== undefined) return part(layout, from, wide);
  const xs = entitiesOf(frame, 0)
    .filter((_, i) => camera.only?.includes(i) ?? true)
    .map((e) => e.x);
  return around(layout, xs, wide);
}

/** The layout with another part of its track: the same for all views of a frame, so that columns of metres can be compared.
 * @param {Layout} layout @param {import('../core/frame.js').Frame} frame @param {number} [least] m across @returns {Layout} */
export function followed(layout, frame, least = LEAST_M) {
  const { scene } = layout;
  const whole = scene.x_max - scene.x_min;
  if (layout.entities.length > 0 || layout.controls === 'aim' || whole <= least) return layout;
  const xs = entitiesOf(frame, 0).map((e) => e.x);
  if (xs.length === 0) return layout;
  const shown = around(layout, xs, least);
  return shown.scene.x_max - shown.scene.x_min >= whole ? layout : shown;
}
