// What the fluid lab remembers of a run: its numbers over time.

const POINTS = 4000;

/** One stretch of time. */
export class Record {
  /** @param {number} generation */
  constructor(generation) {
    this.generation = generation;
    /** @type {number[]} */
    this.t = [];
    /** By place in the layout. @type {number[][]} */
    this.numbers = [];
  }

  get time() {
    return this.t[this.t.length - 1] ?? -1;
  }

  /** @param {number} time @param {number[]} numbers */
  take(time, numbers) {
    if (time <= this.time) return;
    this.t.push(time);
    numbers.forEach((value, i) => (this.numbers[i] ??= []).push(value));
    if (this.t.length > POINTS) for (const list of [this.t, ...this.numbers]) list.splice(0, POINTS / 4);
  }
}
