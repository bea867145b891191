// The step lab's record of a run: curves over time, trails in the plane, and refinement levels of error against cost.
import { Remembered } from '../../workbench/past.js';

/** @typedef {import('../../stream/rows.js').MotionRow & {state: number[]}} Motion */
/** @typedef {{t: number[], value: number[], speed: number[], error: number[], drift: number[], x: number[], y: number[]}} Track */
/** @typedef {{dt: number, error: number, work: number}} RefinementLevel */

const POINTS = 4000;

/** The same, of a row of the trace. @param {import('../../workbench/past.js').Row} row @param {string[]} components of the state
 * @param {number} methods how many @returns {Motion[]} */
export const motionsAt = (row, components, methods) =>
  ['solution', ...Array.from({ length: methods }, (_, i) => String(i))].map((name) => {
    const state = components.map((component) => row[`${name}_${component}`]);
    const known = state.every((value) => typeof value === 'number');
    return /** @type {Motion} */ ({
      status: known ? 0 : 2,
      t_s: Number(row.time_s),
      error: Number(row[`${name}_error`] ?? 0),
      energy_drift: Number(row[`${name}_energy_drift`] ?? 0),
      state: known ? state : [],
    });
  });

/** The components of a motion's state: 0 the solution, 1 + i method i. @param {import('../../stream/frame.js').Frame} frame
 * @param {number} i */
const stateOf = (frame, i) => frame.where('motion_state', 'motion', i).map(({ value }) => value);

/** The solution, then each method. @param {import('../../stream/frame.js').Frame} frame @returns {Motion[]} */
export const motionsOf = (frame) => frame.motion.map((one, i) => ({ ...one, state: stateOf(frame, i) }));

/** @returns {Track} */
const track = () => ({ t: [], value: [], speed: [], error: [], drift: [], x: [], y: [] });

/** One stretch of time; track 0 is the solution, 1 + i method i. @extends {Remembered<Track>} */
export class Record extends Remembered {
  /** @param {number} generation */
  constructor(generation) {
    super(generation, track);
  }

  /** @param {number} time @param {Motion[]} motion @param {number} component that is plotted @param {boolean} plane */
  take(time, motion, component, plane) {
    motion.forEach((one, i) => {
      const to = this.track(i);
      if (one.status !== 0) return;
      const half = one.state.length / 2;
      to.t.push(time);
      to.value.push(one.state[component] ?? 0);
      to.speed.push(one.state[(component + half) % one.state.length] ?? 0);
      to.error.push(one.error);
      to.drift.push(one.energy_drift);
      to.x.push(one.state[0] ?? 0);
      to.y.push(plane ? (one.state[1] ?? 0) : 0);
      if (to.t.length > POINTS) for (const list of Object.values(to)) list.splice(0, POINTS / 4);
    });
  }
}
