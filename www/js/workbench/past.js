// What a lab remembers of a run, and what it has missed of it: before a jump, where the page has joined late, or where frames were skipped.
// A curve breaks there, until time stands still and the rows of the daemon's trace have come.
import { call } from '../base/api.js';
import { touch } from '../draw/redraw.js';
import { session, speed } from '../session/state.js';

const MOST_S = 120; /* back in time */
const SKIPPED = 4.5; /* ticks: fewer are not seen in a curve */

/** The first columns are time_s and tick. @typedef {Record<string, number | string | null>} Row */
/** Values of a curve over time; a value of t that is none is a gap. @typedef {{t: number[]} & Record<string, number[]>} Curves */

/** One stretch of time. @template {Curves} T */
export class Remembered {
  /** @param {number} generation @param {() => T} fresh curves of one thing */
  constructor(generation, fresh) {
    this.generation = generation;
    this.fresh = fresh;
    /** @type {T[]} */
    this.tracks = [];
    this.time = -1;
    this.from = -1; /* s, of what is missing; -1: nothing is */
    this.to = -1;
  }

  /** The curves of a thing. @param {number} i */
  track(i) {
    return (this.tracks[i] ??= this.fresh());
  }

  /** A frame has come. @param {number} time @param {number} hz of ticks @returns {boolean} whether it is a later one */
  meet(time, hz) {
    if (time <= this.time) return false;
    if (time - Math.max(0, this.time) > (this.time < 0 ? 0.5 : SKIPPED * Math.max(1, speed.value)) / hz) {
      if (this.from < 0) this.from = Math.max(0, this.time);
      this.to = time;
      for (const of of this.tracks) for (const list of Object.values(of)) list.push(NaN);
    }
    this.time = time;
    return true;
  }

  /** What was missing. @param {Remembered<T>} past */
  fill(past) {
    past.tracks.forEach((missed, i) => {
      const to = this.track(i),
        before = to.t.flatMap((t, k) => (t < (missed.t[0] ?? 0) ? [k] : [])),
        after = to.t.flatMap((t, k) => (t > (missed.t.at(-1) ?? 0) ? [k] : []));
      for (const name of /** @type {(keyof T)[]} */ (Object.keys(to))) {
        const list = to[name];
        to[name] = /** @type {any} */ ([
          ...before.map((k) => list[k]),
          .../** @type {number[]} */ (missed[name]),
          ...after.map((k) => list[k]),
        ]);
      }
    });
    this.from = -1;
  }
}

/** Asks for what a run lacks, where time stands still. @template {Remembered<any>} T @param {T} of @param {boolean} settled
 * @param {string} record `ticks`, or a record of the stream @param {(rows: Row[]) => T} read */
export async function recall(of, settled, record, read) {
  const now = session.value,
    { from, to } = of;
  if (from < 0 || !settled || now === null) return;
  of.from = -1;
  try {
    const range = `from_s=${Math.max(0, from, to - MOST_S)}&to_s=${to}`;
    of.fill(read(await call('GET', `sessions/${now.id}/trace?of=${record}&${range}&format=json`)));
    touch();
  } catch {
    /* the curve stays broken */
  }
}
