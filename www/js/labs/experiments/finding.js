// What the points of an experiment show: lines over what was varied, what is fitted to them, and the sentences that this makes.
// All numbers of a sentence, and the mark in the chart, come from the points.
import { fixed } from '../../base/format.js';
import { t } from '../../base/words.js';
import { boundsOf, numberOf } from './columns.js';

/** @typedef {import('./shown.js').Cells} Cells */
/** A drawn point; old: of the run before, until its own comes.
 * @typedef {{x: number, y: number, low: number, high: number, index: number, old: boolean}} Place */
/** name: of the compared value, as the rows have it @typedef {{name: string, places: Place[]}} Series */
/** slope, start: of y over x; straight: how much of y is on that line, 0 to 1
 * @typedef {{slope: number, start: number, straight: number}} Fit */

/** @param {Cells[]} rows @param {string} x @param {string} by empty: one series @param {string} y @returns {Series[]} from left to right */
export function seriesIn(rows, x, by, y) {
  const names = by === '' ? [''] : [...new Set(rows.map((row) => String(row[by])))];
  return names.map((name) => ({
    name,
    places: rows
      .map((row, index) => ({ row, x: numberOf(row, x), y: numberOf(row, y), ...boundsOf(row, y), index, old: row.old === true }))
      .filter((p) => (by === '' || String(p.row[by]) === name) && Number.isFinite(p.x) && Number.isFinite(p.y))
      .map(({ row: _, ...place }) => place)
      .sort((a, b) => a.x - b.x || a.index - b.index),
  }));
}

/** A straight line by least squares. @param {Place[]} places @returns {Fit} */
export function fitOf(places) {
  const n = places.length,
    mean = (/** @type {(p: Place) => number} */ of) => places.reduce((sum, p) => sum + of(p), 0) / n;
  const x = mean((p) => p.x),
    y = mean((p) => p.y);
  const xx = mean((p) => (p.x - x) ** 2),
    xy = mean((p) => (p.x - x) * (p.y - y)),
    yy = mean((p) => (p.y - y) ** 2);
  const slope = xx > 0 ? xy / xx : 0;
  return { slope, start: y - slope * x, straight: xx > 0 && yy > 0 ? (xy * xy) / (xx * yy) : 0 };
}

/** @param {Series[]} all */
const spanOf = (all) => {
  const ys = all.flatMap(({ places }) => places.map((p) => p.y));
  return Math.max(...ys) - Math.min(...ys);
};
/** @param {Series | undefined} one @param {number} x */
export const placeAt = (one, x) => one?.places.find((p) => p.x === x);

/** Two lines of which none is seen next to the other. @param {Series} a @param {Series} b */
export function alike(a, b) {
  const least = 0.02 * spanOf([a, b]);
  return a.places.every((p) => Math.abs(p.y - (placeAt(b, p.x)?.y ?? Number.POSITIVE_INFINITY)) <= least);
}

/** Above another wherever both are. @param {Series} a @param {Series} b */
const above = (a, b) => a.places.every((p) => p.y > (placeAt(b, p.x)?.y ?? Number.POSITIVE_INFINITY));
/** @param {Series} one */
const falls = ({ places }) => places.every((p, i) => i === 0 || p.y < /** @type {Place} */ (places[i - 1]).y);

/** A number as a sentence has it, with at most three digits. @param {number} value @param {string} unit as it is read; may be empty
 * @param {number} [like] the number whose digits it has */
export function say(value, unit, like = value) {
  const size = Math.abs(like),
    number = fixed(value, size === 0 || size >= 10 || Number.isInteger(like) ? 0 : size >= 1 ? 1 : 2);
  return unit === '' ? number : `${number} ${unit}`;
}

/** Of a rate near a whole number that one. @param {number} value @param {string} unit */
function almost(value, unit) {
  const whole = Math.round(value);
  if (whole >= 1 && value < whole && value >= 0.88 * whole) return t('experiments.almost', { value: say(whole, unit) });
  return t('experiments.about', { value: say(value, unit) });
}

/** @param {number} slope of a time over a time */
function times(slope) {
  if (Math.abs(slope - 2) < 0.1) return t('experiments.twice');
  return Math.abs(slope - 1) < 0.05 ? t('experiments.once') : t('experiments.times', { n: say(slope, '') });
}

// ---- what is said of an experiment whose question is known ----

/** A metric of the points: its lines, and how its numbers are read.
 * @typedef {{path: string, series: Series[], name: string, unit: string}} Measured */
/** A sentence by its key, its values, and those that are in bold. @typedef {{key: string, values: Record<string, string>}} Said */
/** @typedef {{title: string, sentences: Said[]}} Finding  title: a key; empty where the points do not show it */

/** @param {string} key @param {Record<string, string>} values @returns {Said} */
const said = (key, values) => ({ key, values });

/** Of two lines with and without something; null where there are others.
 * @param {Measured | undefined} of @returns {[Series, Series] | null} */
function pairOf(of) {
  const off = of?.series.find(({ name }) => name === 'false'),
    on = of?.series.find(({ name }) => name === 'true');
  return off && on && of?.series.length === 2 && off.places.length > 1 && on.places.length > 1 ? [off, on] : null;
}

/** @type {Record<string, (measured: Measured[], at: number, x: string) => Finding | null>} */
const KNOWN = {
  lag(measured) {
    const [own, others] = measured,
      pair = pairOf(own),
      other = pairOf(others);
    if (!own || !others || !pair || !other) return null;
    const [off, on] = pair,
      fit = fitOf(off.places),
      rest = Math.max(...on.places.map((p) => p.y)),
      remote = fitOf(other[0].places);
    const cured = rest < 0.1 * Math.max(...off.places.map((p) => p.y)),
      same = alike(...other);
    if (!cured || !same || fit.straight < 0.95 || remote.straight < 0.95) return null;
    const more = 5 * Math.round(fit.start / 5);
    return {
      title: 'experiments.finding.lag',
      sentences: [
        said('experiments.see.lag.own', {
          times: times(fit.slope),
          more: say(more, own.unit),
          rest: rest < 0.5 ? t('experiments.nothing') : say(rest, own.unit),
        }),
        said('experiments.see.lag.others', { rate: almost(100 * remote.slope, others.unit) }),
      ],
    };
  },
  jitter(measured, at, x) {
    const [jumps, error] = measured,
      pair = pairOf(jumps),
      other = pairOf(error);
    if (!jumps || !error || !pair || !other) return null;
    const off = placeAt(pair[0], at),
      on = placeAt(pair[1], at);
    if (!off || !on || !above(...pair) || !above(other[1], other[0])) return null;
    const mean = (/** @type {Series} */ { places }) => places.reduce((sum, p) => sum + p.y, 0) / places.length;
    return {
      title: 'experiments.finding.jitter',
      sentences: [
        said('experiments.see.jitter.jumps', { at: x, off: say(off.y, jumps.unit), on: say(on.y, jumps.unit) }),
        said('experiments.see.jitter.error', { more: say(mean(other[1]) - mean(other[0]), error.unit) }),
      ],
    };
  },
  updates(measured) {
    const [error, bytes] = measured,
      pair = pairOf(error),
      other = pairOf(bytes);
    if (!error || !bytes || !pair || !other) return null;
    const ends = (/** @type {Series} */ { places }) =>
      [places[0], places[places.length - 1]].map((p) => say(p?.y ?? Number.NaN, error.unit));
    const [off, on] = pair,
      fit = fitOf(other[0].places);
    if (!falls(off) || !falls(on) || !alike(...other) || fit.straight < 0.95) return null;
    const [from = '', to = ''] = ends(on),
      [without_from = '', without_to = ''] = ends(off);
    return {
      title: 'experiments.finding.updates',
      sentences: [
        said('experiments.see.updates.error', { from, to, without_from, without_to }),
        said('experiments.see.updates.bytes', { rate: say(fit.slope, '') }),
      ],
    };
  },
};

/** @param {string} id of a question that is known; empty: none @param {Measured[]} measured @param {number} at x that is marked
 * @param {string} x the same in words @returns {Finding | null} null: the points show something else */
export const findingOf = (id, measured, at, x) => KNOWN[id]?.(measured, at, x) ?? null;

/** What is said of any other: how each line runs. @param {Measured[]} measured @param {(name: string) => string} nameOf a series
 * @param {(x: number) => string} xOf @returns {Said[]} */
export function plainly(measured, nameOf, xOf) {
  return measured.slice(0, 2).flatMap(({ series, name, unit }) => {
    const there = series.filter(({ places }) => places.length > 0).slice(0, 4),
      [first, second] = there;
    const joined = there.length === 2 && first && second && alike(first, second);
    const lines = joined && first ? [first] : there;
    return lines.map((one) => {
      const from = /** @type {Place} */ (one.places[0]),
        to = /** @type {Place} */ (one.places[one.places.length - 1]);
      const of = joined && second ? t('experiments.both', { a: nameOf(one.name), b: nameOf(second.name) }) : nameOf(one.name),
        whose = of === '' ? name : t('experiments.whose', { metric: name, series: of });
      if (spanOf([one]) <= 0.02 * spanOf(there)) return said('experiments.see.flat', { whose, value: say(from.y, unit) });
      return said('experiments.see.ends', { whose, from: say(from.y, unit), to: say(to.y, unit), x0: xOf(from.x), x1: xOf(to.x) });
    });
  });
}

// ---- what is marked ----

/** The mark at x: from one line to the other where there are two that part; else around a point.
 * @param {Measured} of @param {number} at @param {string} x in words
 * @returns {{x: number, from: number, to: number, value: string, text: string} | null} from and to are equal around a point */
export function markOf({ series, unit }, at, x) {
  const there = series.map((one) => placeAt(one, at)).filter((p) => p !== undefined),
    [a, b] = there;
  if (!a) return null;
  const [first, second] = series;
  if (b && there.length === 2 && first && second && !alike(first, second)) {
    const more = b.y - a.y,
      key = more > 0 ? 'experiments.mark.more' : unit === 'ms' ? 'experiments.mark.saved' : 'experiments.mark.less';
    return { x: at, from: a.y, to: b.y, value: say(Math.abs(more), unit), text: t(key, { at: x }) };
  }
  const half = (a.high - a.low) / 2,
    value = half > 0 ? `${say(a.y, '')} ± ${say(half, unit, a.y)}` : say(a.y, unit);
  return { x: at, from: a.y, to: a.y, value, text: t(there.length === 2 ? 'experiments.mark.either' : 'experiments.mark.at', { at: x }) };
}
