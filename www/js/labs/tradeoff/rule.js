// The rule of docs/tradeoff.md: of the settings whose upper bounds are within both lines the one of least cost. And what it is compared
// with, where the lines are at first, and which methods are named. Nothing of the page, so that a test can run it by itself.

/** @typedef {[number | null, number | null, number | null]} Measured  value, and the bounds of its interval */
/** @typedef {{error: Measured, costs: Measured[], cpu_median_s: number | null, seed: number, seeds: number}} Values */
/** @typedef {Values & {problem: number, by: string, method: string, setting: string, value: number | null, status: string, random: boolean,
 *   front: boolean[], check: Values | null, set: string, link: string}} Row */
/** A row with one of its costs. index: of the row; line: of a method by one of its settings; here: measured on this machine
 * @typedef {{index: number, method: string, line: string, cost: number, costs: Measured, error: number, errors: Measured, value: number,
 *   here: boolean}} Point */
/** cost: at most; error: at most @typedef {{cost: number, error: number}} Lines */

const NAMED = 6,
  CLEARLY = 1.5; /* times as much, which is worth a sentence */

/** What makes a row the same setting in two measurements: values have six digits in files. @param {Row} row */
export const settingOf = ({ problem, method, setting, value }) => `${problem} ${method} ${setting} ${value?.toPrecision(5)}`;

/** Rows of the program and of this machine as one list: what is measured here takes the place of the same setting. Times of two machines
 * do not compare, so that there are none of the program's once one of this machine's came to an end.
 * @param {Row[]} shipped @param {Row[]} measured @param {boolean} times whether the cost is the machine's
 * @returns {(Row & {here: boolean})[]} */
export function merged(shipped, measured, times) {
  const known = new Set(measured.map(settingOf)),
    problems = new Set(measured.filter(({ error }) => error[0] !== null).map(({ problem }) => problem));
  const kept = shipped.filter((row) => !known.has(settingOf(row)) && !(times && problems.has(row.problem)));
  return [...kept.map((row) => ({ ...row, here: false })), ...measured.map((row) => ({ ...row, here: true }))];
}

/** Of the rows of a problem, those that came to an end. @param {(Row & {here?: boolean})[]} rows @param {number} problem
 * @param {number} cost its place @returns {Point[]} */
export function pointsOf(rows, problem, cost) {
  return rows.flatMap((row, index) => {
    const costs = row.costs[cost] ?? [null, null, null],
      errors = row.error;
    if (row.problem !== problem || costs[0] === null || errors[0] === null) return [];
    return [
      {
        index,
        method: row.method,
        line: `${row.method} ${row.setting}`,
        cost: costs[0],
        costs,
        error: errors[0],
        errors,
        value: row.value ?? 0,
        here: row.here === true,
      },
    ];
  });
}

/** @param {Measured} measured */
const most = ([value, , high]) => high ?? value ?? Number.POSITIVE_INFINITY;

/** @param {Point} point @param {Lines} lines */
export const isWithin = ({ costs, errors }, lines) => most(errors) <= lines.error && most(costs) <= lines.cost;

/** The cheapest within both lines; of several that cost the same the truest. @param {Point[]} points @param {Lines} lines
 * @returns {Point | undefined} */
export function cheapest(points, lines) {
  /** @type {Point | undefined} */
  let best;
  for (const point of points) {
    if (!isWithin(point, lines)) continue;
    if (best === undefined || point.cost < best.cost || (point.cost === best.cost && point.error < best.error)) best = point;
  }
  return best;
}

/** By how many decades a value is beyond its line. @param {number} value @param {number} line */
const beyond = (value, line) => (value <= line ? 0 : Math.log10(value / Math.max(line, value * 1e-12)));

/** Where nothing is within both: what is beyond them by the fewest decades. @param {Point[]} points @param {Lines} lines
 * @returns {Point | undefined} */
export function nearest(points, lines) {
  let best,
    least = Number.POSITIVE_INFINITY;
  for (const point of points) {
    const far = beyond(most(point.costs), lines.cost) + beyond(most(point.errors), lines.error);
    if (far < least) [best, least] = [point, far];
  }
  return best;
}

/** What a method needs to be good enough. @param {Point[]} points @param {string} method @param {number} error */
export const needed = (points, method, error) =>
  cheapest(
    points.filter((point) => point.method === method),
    { cost: Number.POSITIVE_INFINITY, error },
  );

/** The truest that a method does within a budget. @param {Point[]} points @param {string} method @param {number} cost
 * @returns {Point | undefined} */
export function truest(points, method, cost) {
  const bought = points.filter((point) => point.method === method && most(point.costs) <= cost);
  return bought.length > 0 ? bought.reduce((best, point) => (point.error < best.error ? point : best)) : undefined;
}

/** What a method does with a budget: the truest; if none of that comes to an end, the dearest that does not; if the budget buys nothing,
 * its cheapest, of several the truest. @param {Row[]} rows @param {Point[]} points of them @param {number} problem
 * @param {number} cost its place @param {string} method @param {number} budget @returns {number} a place in the rows; -1: none */
export function tried(rows, points, problem, cost, method, budget) {
  const bought = truest(points, method, budget);
  if (bought) return bought.index;
  let found = -1,
    paid = -1;
  rows.forEach((row, index) => {
    const price = row.costs[cost]?.[0] ?? Number.NaN;
    if (row.problem === problem && row.method === method && row.error[0] === null && price <= budget && price > paid)
      [found, paid] = [index, price];
  });
  if (found >= 0) return found;
  const own = points.filter((point) => point.method === method);
  return (
    own.reduce(
      (/** @type {Point | undefined} */ best, point) =>
        best === undefined || point.cost < best.cost || (point.cost === best.cost && point.error < best.error) ? point : best,
      undefined,
    )?.index ?? -1
  );
}

/** Methods by name: what the family names, then what is the cheapest at some level, then the rest, six in all; only what came to an end.
 * @param {Point[]} points @param {string[]} first of the family @param {string[]} winners @returns {string[]} */
export function namedOf(points, first, winners) {
  const there = new Set(points.map(({ method }) => method));
  return [...new Set([...first, ...winners, ...there])].filter((method) => there.has(method)).slice(0, NAMED);
}

/** Whom the sentence compares the winner with, of those that are named: one that is not good enough at any cost comes last; of the others
 * that which needs the most times as much. With a preference, which a family has, that one, if it is not within both lines.
 * @param {Point[]} points @param {string[]} named @param {Point} winner @param {Lines} lines @param {string[]} preferred
 * @returns {string} empty: there is none */
export function rivalOf(points, named, winner, lines, preferred) {
  const others = named.filter((method) => method !== winner.method),
    loses = (/** @type {string} */ method) => {
      const point = needed(points, method, lines.error);
      return point === undefined || point.cost > Math.max(lines.cost, winner.cost * CLEARLY);
    };
  const wanted = preferred.find((method) => others.includes(method) && loses(method));
  if (wanted !== undefined) return wanted;
  let best = '',
    largest = 0;
  for (const method of others) {
    const point = needed(points, method, lines.error),
      times = point === undefined ? 0.5 : point.cost / Math.max(winner.cost, 1e-300);
    if (times > largest) [best, largest] = [method, times];
  }
  return best;
}

/** The largest of 1, 2, 5, 10, … that is not more. @param {number} value */
function roundDown(value) {
  const power = 10 ** Math.floor(Math.log10(value) + 1e-9),
    lead = value / power;
  return Number(((lead >= 5 ? 5 : lead >= 2 ? 2 : 1) * power).toPrecision(6));
}

/** Rounds to the digits that a handle shows. @param {number} value @param {(value: number) => number} [way] */
export function toDigits(value, way = Math.round) {
  if (!(value > 0)) return 0;
  const power = 10 ** (Math.floor(Math.log10(value) + 1e-9) - 1);
  return Number((way(value / power) * power).toPrecision(12));
}

/** Where the lines are at first: good enough is a level of the measurement; the budget lies halfway, in decades, from what is the cheapest
 * there to what its rival needs, so that one is within both and the other is not. @param {Point[]} points @param {number[]} levels
 * @param {string[]} named @param {string[]} preferred @returns {Lines} */
export function opening(points, levels, named, preferred) {
  const far = Number.POSITIVE_INFINITY,
    error = levels[0] ?? Math.max(...points.map((point) => most(point.errors)), 0),
    winner = cheapest(points, { cost: far, error });
  if (winner === undefined) return { cost: toDigits(Math.max(...points.map(({ cost }) => cost), 1)), error };
  const least = most(winner.costs);
  const rival = rivalOf(points, named, winner, { cost: least, error }, preferred),
    wants = needed(points, rival, error)?.cost ?? least * 9;
  if (!(least > 0)) return { cost: wants / 2, error };
  const middle = roundDown(Math.sqrt(least * Math.max(wants, least)));
  return { cost: middle >= least ? middle : toDigits(least * 1.05, Math.ceil), error };
}
