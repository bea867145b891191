// Frames of two runs: the newest tick that both have.

/** @typedef {import('../core/frame.js').Frame} Frame */

const KEPT = 120; /* frames of a run: two seconds */
const APART = 8; /* ticks: where frames are skipped the two may have no tick in common */

export class Pair {
  constructor() {
    /** @type {[Frame[], Frame[]]} */
    this.rings = [[], []];
  }

  /** @param {0 | 1} side @param {Frame} frame */
  take(side, frame) {
    const ring = this.rings[side],
      last = ring[ring.length - 1];
    if (last && (last.tick >= frame.tick || last.session.generation !== frame.session.generation)) ring.length = 0;
    ring.push(frame);
    if (ring.length > KEPT) ring.shift();
  }

  /** @param {0 | 1} side */
  newest(side) {
    return this.rings[side][this.rings[side].length - 1] ?? null;
  }

  /** @param {boolean} near whether neighbouring ticks will do @returns {[Frame, Frame] | null} */
  common(near) {
    const [firsts, seconds] = this.rings;
    let i = firsts.length - 1,
      j = seconds.length - 1;
    while (i >= 0 && j >= 0) {
      const one = /** @type {Frame} */ (firsts[i]),
        other = /** @type {Frame} */ (seconds[j]);
      if (one.tick === other.tick) return [one, other];
      if (one.tick > other.tick) i--;
      else j--;
    }
    const one = this.newest(0),
      other = this.newest(1);
    return near && one && other && Math.abs(one.tick - other.tick) <= APART ? [one, other] : null;
  }
}
