// What the collide lab remembers of a run: energy and overlap over time.

/** @typedef {{t: number[], energy: number[], penetration: number[], tunnelled: number[]}} Track */

/** @typedef {Pick<import('./decode.js').World, 'status' | 'energy' | 'energy_start' | 'penetration' | 'tunnelled'>} Plotted */

const POINTS = 4000;
const GHOSTS = 32 /* places of a body that are kept */,
  BODIES = 60; /* more of them would hide each other */

/** One stretch of time; a track for each world. */
export class Record {
  /** @param {number} generation */
  constructor(generation) {
    this.generation = generation;
    /** @type {Track[]} */
    this.tracks = [];
    this.time = -1;
    this.first = -1;
    this.asked = false;
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

  /** What was before: rows of all worlds, tick by tick. @param {import('../../workbench/past.js').Row[]} rows */
  follow(rows) {
    const past = new Record(this.generation),
      count = this.tracks.length;
    for (let i = 0; i + count <= rows.length; i += count)
      past.take(
        Number(rows[i]?.time_s),
        rows.slice(i, i + count).map((row) => ({
          status: row.status === 'ok' ? 0 : 1,
          energy: Number(row.energy_J),
          energy_start: Number(row.energy_start_J),
          penetration: Number(row.penetration_m),
          tunnelled: Number(row.tunnelled),
        })),
      );
    past.tracks.forEach((before, i) => {
      const to = /** @type {Track} */ (this.tracks[i]);
      for (const name of /** @type {(keyof Track)[]} */ (Object.keys(to))) to[name] = [...before[name], ...to[name]];
    });
  }

  /** @param {number} time @param {Plotted[]} worlds */
  take(time, worlds) {
    if (time <= this.time) return;
    this.time = time;
    if (this.first < 0) this.first = time;
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
