// Brute force to judge the adviser, from outside: all rows come from `laglab sweep`, means and regret are made here.
import { spawn } from 'node:child_process';
import { once } from 'node:events';

/** @typedef {{point: number, runs: number, failed: number, error: number, half: number, cost: number}} Point */

/** Seeds of brute force: no search comes near them. */
export const FRESH_SEED = 50_000_000;

/** Runs laglab with an experiment on its standard input. */
export async function ask(laglab, args, experiment) {
  const child = spawn(laglab, args, { stdio: ['pipe', 'pipe', 'inherit'] });
  const parts = [];
  child.stdout.on('data', (part) => parts.push(part));
  child.stdin.end(JSON.stringify(experiment));
  const [code] = await once(child, 'close');
  if (code !== 0) throw new Error(`laglab ${args.join(' ')} ended with ${code}`);
  return Buffer.concat(parts).toString();
}

export const seeded = (experiment, seed) => ({ ...experiment, set: { ...experiment.set, seed } });

/** 97.5 % of Student's t, by Cornish and Fisher. */
function student(degrees) {
  const z = 1.959963984540054;
  return z + (z ** 3 + z) / (4 * degrees) + (5 * z ** 5 + 16 * z ** 3 + 3 * z) / (96 * degrees ** 2);
}

/** By how much a mean of rare events may be above what was counted, at 97.5 % (Poisson): k + 1.92 + 1.96 sqrt(k + 1) bounds it within 2
 * %. */
const rare = (mean, n, event) => (event * (1.92 + 1.96 * Math.sqrt((mean * n) / event + 1))) / n;

const FIRST = 24; // seeds of every setting, where brute force is a race
const FAR = 2; // half widths of 95 %: a setting that misses a limit, or costs more than one that holds, by this much gets no more seeds
const DEARER = 1.1;

/** @typedef {{errors: number[], costs: number[], failed: number, values: Record<string, any>}} Runs */

/** Rows of a sweep, added to the settings that they are of. */
async function sweep(laglab, experiment, jobs, runs, which) {
  const text = await ask(laglab, ['sweep', '-', '--format', 'ndjson', '--jobs', String(jobs)], experiment);
  const [error, cost] = experiment.metrics;
  for (const line of text.split('\n')) {
    if (!line) continue;
    const row = JSON.parse(line);
    const of = (runs[which ? which[row.point] : row.point] ??= { errors: [], costs: [], failed: 0, values: row });
    const good = (row.status === 'ok' || row.status === 'stopped') && Number.isFinite(row[error]) && Number.isFinite(row[cost]);
    if (good) {
      of.errors.push(Math.abs(row[error]));
      of.costs.push(Math.abs(row[cost]));
    } else of.failed++;
  }
}

const paths = (axes) => axes.flatMap((axis) => (axis.zip ?? [axis]).map((one) => one.path));

/** More seeds, up to `seeds`, of some of the settings: one axis has them all. */
async function extend(laglab, experiment, jobs, runs, which, seeds) {
  const made = which.length ? runs[which[0]].errors.length + runs[which[0]].failed : 0;
  if (!which.length || made >= seeds) return;
  const zip = paths(experiment.axes).map((path) => ({ path, values: which.map((point) => runs[point].values[path]) }));
  await sweep(laglab, { ...seeded(experiment, FRESH_SEED + made), repeats: seeds - made, axes: [{ zip }] }, jobs, runs, which);
}

/** Means of magnitudes. Where the error counts events, each of which adds `event` to that of a run, the interval is at least as wide as
 * theirs.
 * @returns {Point} */
function told({ errors, costs, failed }, point, event) {
  const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;
  const m = errors.length ? (errors.length > 1 ? mean(errors) : errors[0]) : NaN,
    n = errors.length;
  const variance = n > 1 ? errors.reduce((sum, value) => sum + (value - m) ** 2, 0) / (n - 1) : 0;
  return {
    point,
    runs: n,
    failed,
    error: m,
    half: n > 1 ? Math.max(student(n - 1) * Math.sqrt(variance / n), event > 0 && (m * n) / event < 30 ? rare(m, n, event) : 0) : 0,
    cost: costs.length ? mean(costs) : NaN,
  };
}

/** Settings that may be the cheapest within one of the limits. */
function contenders(truth, limits) {
  const near = truth.filter((p) => p.failed === 0);
  return near
    .filter((p) =>
      limits.some((limit) => {
        const best = near.reduce((found, q) => (q.error + FAR * q.half <= limit ? Math.min(found, q.cost) : found), Infinity);
        return p.cost <= DEARER * best && p.error - FAR * p.half <= limit;
      }),
    )
    .map((p) => p.point);
}

/** Mean magnitudes of error and cost at every setting of the grid, over `seeds` seeds (one where nothing is random). With `limits` it is a
 * race: all settings have 24 seeds, and those all that may be the cheapest within one of the limits; `complete` gives another all of them.
 * @returns {Promise<Point[] & {complete: (point: number) => Promise<void>}>} */
export async function bruteForce(laglab, experiment, seeds, { jobs = 1, event = 0, limits = [] } = {}) {
  const noisy = experiment.repeats > 1,
    race = noisy && limits.length > 0;
  /** @type {Runs[]} */
  const runs = [];
  await sweep(laglab, { ...seeded(experiment, FRESH_SEED), repeats: race ? FIRST : noisy ? seeds : 1 }, jobs, runs, null);
  const truth = runs.map((of, point) => told(of, point, event));
  const more = async (which) => {
    await extend(laglab, experiment, jobs, runs, which, seeds);
    for (const point of which) truth[point] = told(runs[point], point, event);
  };
  if (race) await more(contenders(truth, limits));
  return Object.assign(truth, { complete: async (/** @type {number} */ point) => (noisy ? more([point]) : undefined) });
}

/** A limit as a number: {rank} is exactly an error of the grid. */
export function limitOf(limit, truth) {
  if (typeof limit === 'number') return limit;
  const errors = truth
    .filter((p) => p.failed === 0)
    .map((p) => p.error)
    .sort((a, b) => a - b);
  return errors[Math.floor(limit.rank * errors.length)];
}

const TIE = 1 + 1e-9;

/** What brute force says of an answer. `sure` settings hold with the upper bound of their 95 % interval, `possible` ones with their
 * mean; without noise these are the same.
 * @param {any} answer @param {Point[]} truth @param {number} limit */
export function judge(answer, truth, limit) {
  const least = (/** @type {Point[]} */ points) => points.reduce((found, p) => Math.min(found, p.cost), Infinity);
  const sure = truth.filter((p) => p.failed === 0 && p.error + p.half <= limit),
    possible = truth.filter((p) => p.failed === 0 && p.error <= limit);
  const best = least(sure),
    bestPossible = least(possible);
  const advised = answer.advice ? truth[answer.advice.point] : null;
  if (!advised)
    return {
      advised,
      best,
      regret: sure.length ? Infinity : 0,
      regret_possible: possible.length ? Infinity : 0,
      broken: false,
      surely_broken: false,
      untied: false,
      missed: sure.length > 0,
    };
  const regret = (/** @type {number} */ cost) =>
    Number.isFinite(cost) ? (cost === advised.cost ? 0 : Math.max(0, advised.cost / cost - 1)) : 0;
  const tied = sure.filter((p) => p.runs === 1 && p.cost <= advised.cost * TIE && p.cost >= advised.cost / TIE && p.error < advised.error);
  return {
    advised,
    best,
    regret: regret(best),
    regret_possible: regret(bestPossible),
    missed: false,
    broken: !(advised.error <= limit) || advised.failed > 0,
    surely_broken: advised.error - advised.half > limit || advised.failed > 0.05 * (advised.runs + advised.failed),
    untied: tied.length > 0,
  };
}
