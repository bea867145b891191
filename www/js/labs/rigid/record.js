// What the collide lab remembers of a run: energy and overlap over time.

/** @typedef {{t: number[], energy: number[], penetration: number[], tunnelled: number[]}} Track */

const POINTS = 4000;

/** One stretch of time; a track for each world. */
export class Record {
  /** @param {number} generation */
  constructor(generation) {
    this.generation = generation;
    /** @type {Track[]} */
    this.tracks = [];
    this.time = -1;
  }

  /** @param {number} time @param {import('./decode.js').World[]} worlds */
  take(time, worlds) {
    if (time <= this.time) return;
    this.time = time;
    worlds.forEach((one, i) => {
      const to = (this.tracks[i] ??= { t: [], energy: [], penetration: [], tunnelled: [] });
      if (one.status !== 0) return;
      to.t.push(time);
      to.energy.push(one.energy - one.energy_start);
      to.penetration.push(one.penetration);
      to.tunnelled.push(one.tunnelled);
      if (to.t.length > POINTS) for (const list of Object.values(to)) list.splice(0, POINTS / 4);
    });
  }
}
