// What the view shows now: rows, lines, the cheapest within both, what it is compared with.
import { computed, effect, signal } from '../../../vendor/signals-core.js';
import { move, place } from './place.js';
import { job, shippedAnswer, shownFamily } from './results.js';
import { cheapest, merged, namedOf, nearest, needed, opening, pointsOf, rivalOf, settingOf, toDigits, tried, truest } from './rule.js';
import { stillOf } from './names.js';

/** @typedef {import('./results.js').Row} Row */
/** @typedef {import('./rule.js').Lines} Lines */
/** @typedef {import('./rule.js').Point} Point */

/** What people know the winner by: the first that is not within both lines. @type {Record<string, string[]>} */
const PREFERRED = {
  integrators: ['rk4', 'velocity_verlet'],
  contact_solvers: ['xpbd'],
  pressure_solvers: ['gauss_seidel', 'pcg'],
  particles: ['pbf'],
  oceans: ['gerstner'],
  snapshots: ['full', 'linear', 'partial'],
  synchronisation: ['lockstep'],
  lag_compensation: ['rewind', 'none'],
};
/** What is paid, where that is not the second cost. @type {Record<string, string>} */
const PAID = { synchronisation: 'players.0.input_latency_ms.mean' };

const WORTH_S = 1; /* of standing still, which are worth a word */

/** Every method has its line, not those by name alone. */
export const all = signal(false);
/** The only method that is not pale; empty: none. */
export const dark = signal('');
/** A place in the rows; -1: none. */
export const selected = signal(-1);
/** Handles on their way; the others are where the address has them.
 * @type {import('@preact/signals-core').Signal<{budget?: number, enough?: number}>} */
export const held = signal({});

/** The number of the shown cost. */
export const shownCost = computed(() => {
  const costs = shownFamily.value?.costs ?? [],
    at = costs.findIndex(({ path }) => path === (place.value?.cost || PAID[shownFamily.value?.name ?? '']));
  return at >= 0 ? at : Math.min(1, costs.length - 1);
});
/** The number of the shown error. */
export const shownError = computed(() => Math.min(place.value?.error ?? 0, (shownFamily.value?.problems.length ?? 1) - 1));

const measuredRows = computed(() => job.value?.answer?.rows ?? []);
export const rows = computed(() => merged(shippedAnswer.value?.rows ?? [], measuredRows.value, shownCost.value === 0));
/** All that came to an end. */
const points = computed(() => pointsOf(rows.value, shownError.value, shownCost.value));
/** Shipped rows in whose place there are others. */
const former = computed(() => {
  const kept = new Set(rows.value.map(settingOf)),
    here = new Set(rows.value.filter((row) => row.here).map(settingOf));
  const left = (shippedAnswer.value?.rows ?? []).filter((row) => here.has(settingOf(row)) || !kept.has(settingOf(row)));
  return pointsOf(left, shownError.value, shownCost.value);
});

const choices = computed(() => (shippedAnswer.value?.choices ?? []).filter(({ problem }) => problem === shownError.value));
const first = computed(() => {
  const known = shippedAnswer.value?.rows ?? [];
  return namedOf(
    points.value,
    shownFamily.value?.first ?? [],
    choices.value.flatMap(({ row }) => (row === null || row < 0 ? [] : [known[row]?.method ?? ''])),
  );
});
const preferred = computed(() => PREFERRED[shownFamily.value?.name ?? ''] ?? []);

/** Where the lines are at first: by the rows of the program, so that they do not move while it is measured here, unless what is measured
 * leaves nothing within them. */
const begin = computed(() => {
  const levels = choices.value.filter(({ cost }) => cost === shownCost.value).map(({ level }) => level),
    known = pointsOf(shippedAnswer.value?.rows ?? [], shownError.value, shownCost.value);
  const at = opening(known, levels, first.value, preferred.value);
  return cheapest(points.value, at) ? at : opening(points.value, levels, first.value, preferred.value);
});
export const lines = computed(
  () =>
    /** @type {Lines} */ ({
      cost: held.value.budget ?? place.value?.budget ?? begin.value.cost,
      error: held.value.enough ?? place.value?.enough ?? begin.value.error,
    }),
);

/** All methods of the problem. */
export const methods = computed(() => {
  const own = [...(shippedAnswer.value?.rows ?? []), ...rows.value].filter(({ problem }) => problem === shownError.value);
  return [...new Set(own.map(({ method }) => method))];
});

/** @typedef {NonNullable<typeof now.value>} Now */
/** Null until there are rows. */
export const now = computed(() => {
  const family = shownFamily.value,
    error = family?.problems[shownError.value],
    cost = family?.costs[shownCost.value];
  if (!family || !error || !cost || points.value.length === 0) return null;
  const winner = cheapest(points.value, lines.value),
    best = winner ?? nearest(points.value, lines.value),
    named = best && !first.value.includes(best.method) ? [...first.value, best.method] : first.value;
  if (!best) return null;
  const rival = rivalOf(points.value, named, best, lines.value, preferred.value),
    wants = needed(points.value, rival, lines.value.error),
    tries = tried(rows.value, points.value, shownError.value, shownCost.value, rival, lines.value.cost),
    ever = truest(points.value, rival, Number.POSITIVE_INFINITY);
  const shown = all.value ? points.value : points.value.filter(({ method }) => named.includes(method));
  const leading = shown.reduce((low, point) => (point.error < low.error ? point : low), best),
    row = rows.value[leading.index],
    own = rows.value[best.index];
  const stood = (/** @type {Row | undefined} */ one) => {
    const time = one && stillOf(family, one);
    return time && time.still >= WORTH_S ? time : null;
  };
  return {
    family,
    error,
    cost,
    all: points.value,
    shown,
    former: former.value.filter(({ method }) => all.value || named.includes(method)),
    named,
    order: [...new Set([...named, ...methods.value])],
    winner,
    best,
    rival,
    wants,
    /** place in the rows */
    tries,
    triesAt: points.value.find(({ index }) => index === tries),
    ever,
    /** what the cost of the truest hides */
    hidden: cost.path === 'server.stalled_s' ? null : stood(row),
    still: stood(own),
  };
});

const SETTLE_MS = 300;
/** @type {ReturnType<typeof setTimeout> | undefined} */
let settling;
/** Moves a handle; the address has it when it rests. @param {'budget' | 'enough'} handle @param {number} value */
export function hold(handle, value) {
  held.value = { ...held.value, [handle]: toDigits(value) };
  clearTimeout(settling);
  settling = setTimeout(() => {
    const { budget, enough } = held.peek();
    move({ ...(budget === undefined ? {} : { budget }), ...(enough === undefined ? {} : { enough }) });
    held.value = {};
  }, SETTLE_MS);
}

/** Another family, error or cost has lines of its own. @param {Partial<import('./place.js').Place>} change */
export function show(change) {
  clearTimeout(settling);
  held.value = {};
  move({ ...change, budget: null, enough: null });
}

let before = '';
effect(() => {
  /* of other rows nothing is selected */
  const next = `${shownFamily.value?.name} ${shownError.value} ${shownCost.value}`;
  if (next === before) return;
  before = next;
  dark.value = '';
  selected.value = -1;
});
