// What the fluid lab remembers of a run: its numbers over time, in memory that does not grow.

const POINTS = 4000;

/** One stretch of time. */
export class Record {
  #count = 0;
  #t = new Float64Array(POINTS);
  /** By place in the layout. @type {Float64Array[]} */
  #numbers = [];

  /** @param {number} generation */
  constructor(generation) {
    this.generation = generation;
  }

  /** Of the newest numbers; -1: there are none. */
  get time() {
    return this.#t[this.#count - 1] ?? -1;
  }

  get times() {
    return Array.from(this.#t.subarray(0, this.#count));
  }

  /** @param {number} place in the layout */
  values(place) {
    return Array.from(this.#numbers[place]?.subarray(0, this.#count) ?? []);
  }

  /** @param {number} time @param {number[]} numbers */
  take(time, numbers) {
    if (time <= this.time) return;
    if (this.#count === POINTS) this.#forget(POINTS / 4);
    this.#t[this.#count] = time;
    numbers.forEach((value, i) => {
      this.#numbers[i] ??= new Float64Array(POINTS);
      this.#numbers[i][this.#count] = value;
    });
    this.#count++;
  }

  /** @param {number} oldest number of them */
  #forget(oldest) {
    for (const list of [this.#t, ...this.#numbers]) list.copyWithin(0, oldest);
    this.#count -= oldest;
  }
}
