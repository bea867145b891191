// The colour scale: a range that follows the shown values, in round numbers, so that the view does not flicker.

const ROUND = [1, 1.5, 2, 3, 4, 5, 6, 8, 10];
const EASE = 0.03; /* of the excess, per frame */
const SHARE = 0.985; /* of the cells lie within; the few beyond have the last colour */

/** @param {number} value @returns {number} the least round number that is not less */
function roundUp(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return (ROUND.find((lead) => lead * power >= value * (1 - 1e-9)) ?? 10) * power;
}

/** One for each layer that is shown. */
export class Scale {
  /** @param {string} unit none: a share, from 0 to 1 */
  constructor(unit) {
    this.unit = unit;
    this.signed = false;
    this.most = 0;
  }

  /** @param {number} most @param {boolean} signed */
  follow(most, signed) {
    this.signed ||= signed;
    this.most = most > this.most ? most : this.most + (most - this.most) * EASE;
  }

  /** @param {import('./decode.js').Field} field */
  take(field) {
    const counts = new Uint32Array(256),
      cells = field.width * field.height;
    for (let i = 0; i < cells; i++) counts[field.bytes[i] ?? 255]++;
    const step = (field.high - field.low) / 254,
      wanted = (cells - (counts[255] ?? 0)) * (1 - SHARE);
    const valueOf = (/** @type {number} */ byte) => Math.abs(field.low + byte * step);
    let low = 0,
      high = 254;
    for (let left = wanted; low < high; ) {
      /* drops the larger end while there are few enough cells in it */
      const end = valueOf(low) > valueOf(high) ? low : high;
      left -= counts[end] ?? 0;
      if (left < 0) break;
      if (end === low) low++;
      else high--;
    }
    this.follow(Math.max(valueOf(low), valueOf(high)), field.low < -0.1 * Math.abs(field.high));
  }

  /** Least and most. @returns {[number, number]} */
  range() {
    const most = this.unit === '' && this.most <= 1.5 && !this.signed ? 1 : this.most > 0 ? roundUp(this.most) : 1;
    return [this.signed ? -most : 0, most];
  }
}
