// What the collide lab remembers of a run: energy and overlap over time.
import { Remembered } from '../../workbench/past.js';

/** @typedef {{t: number[], energy: number[], penetration: number[], tunnelled: number[]}} Track */
/** @typedef {Pick<import('./decode.js').World, 'status' | 'energy' | 'energy_start' | 'penetration' | 'tunnelled'>} Plotted */

const POINTS = 4000;
const GHOSTS = 32 /* places of a body that are kept */,
  BODIES = 60; /* more of them would hide each other */

/** @returns {Track} */
const track = () => ({ t: [], energy: [], penetration: [], tunnelled: [] });

/** One stretch of time; a track for each world. @extends {Remembered<Track>} */
export class Record extends Remembered {
  /** @param {number} generation */
  constructor(generation) {
    super(generation, track);
    /** Where fast bodies were at former ticks, by shape. @type {Map<number, import('./decode.js').Shape[]>} */
    this.places = new Map();
    this.tick = -1;
  }

  /** Keeps where bodies are that move by more than their size in a step: what lies between is swept. @param {number} tick
   * @param {import('./decode.js').Shape[]} shapes @param {number} dt s, of a step */
  sweep(tick, shapes, dt) {
    if (tick === this.tick) return;
    this.tick = tick;
    if (shapes.filter((s) => s.dynamic).length > BODIES) return;
    shapes.forEach((s, i) => {
      const list = this.places.get(i) ?? [],
        last = list.at(-1);
      const fast = Math.hypot(s.vx, s.vy) * dt > s.right - s.left;
      if (!s.dynamic || (!fast && (!last || Math.hypot(last.x - s.x, last.y - s.y) < s.right - s.left))) return;
      this.places.set(i, [...list.slice(1 - GHOSTS), s]);
    });
  }

  /** @param {number} time @param {Plotted[]} worlds */
  take(time, worlds) {
    worlds.forEach((one, i) => {
      const to = this.track(i);
      if (one.status !== 0) return;
      to.t.push(time);
      to.energy.push(one.energy - one.energy_start);
      to.penetration.push(one.penetration);
      to.tunnelled.push(one.tunnelled);
      if (to.t.length > POINTS) for (const list of Object.values(to)) list.splice(0, POINTS / 4);
    });
  }
}

/** The same, of rows of the trace: all worlds of a tick.
 * @param {import('../../workbench/past.js').Row[]} rows @param {number} worlds */
export function recordOf(rows, worlds) {
  const past = new Record(-1);
  for (let i = 0; i + worlds <= rows.length; i += worlds)
    past.take(
      Number(rows[i]?.time_s),
      rows.slice(i, i + worlds).map((row) => ({
        status: row.status === 'ok' ? 0 : 1,
        energy: Number(row.energy_J),
        energy_start: Number(row.energy_start_J),
        penetration: Number(row.penetration_m),
        tunnelled: Number(row.tunnelled),
      })),
    );
  return past;
}
