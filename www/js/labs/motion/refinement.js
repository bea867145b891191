// Error against step and cost: separate runs of each method with many steps. A few are made by themselves when their plots come into view;
// with a press all.
import { effect, signal } from '../../../vendor/signals-core.js';
import { call, make } from '../../base/api.js';
import { layout, locked, may, notify, params, session } from '../../session/state.js';
import { touch } from '../../draw/redraw.js';
import { t } from '../../base/words.js';

/** @typedef {import('./record.js').RefinementLevel} RefinementLevel */
/** What one of the separate runs has: the place of the method, and how often its step was halved. @typedef {{i: number, n: number}} Wish */

const FINEST = 16 /* halvings */,
  AT_ONCE = 8; /* methods of a session */
/** By themselves: from a 256th of the duration on. */
const FIRST = 4,
  FEW = 4,
  MANY = 8;
const REST_MS = 600; /* after a change */

/** By the method's place: what it was measured of, and what came out.
 * @type {import('@preact/signals-core').Signal<Map<number, {of: string, list: RefinementLevel[]}>>} */
const measured = signal(new Map());
export const measuring = signal(false);

/** All that a series depends on: not the method's own step. @param {number} i */
function keyOf(i) {
  const { problem, params: values, duration_s: duration, methods = [] } = params.value ?? {};
  const { dt_s: _, tolerance: __, shown: ___, ...method } = methods[i] ?? {};
  return JSON.stringify([problem, values, duration, method]);
}

/** Places of the methods that are shown. */
const places = () => (params.value?.methods ?? []).flatMap((/** @type {any} */ one, /** @type {number} */ i) => (one.shown ? [i] : []));

/** The series of what is shown now, by the method's place. @returns {[number, RefinementLevel[]][]} */
export const series = () =>
  places().flatMap((/** @type {number} */ i) => {
    const found = measured.value.get(i);
    return found?.of === keyOf(i) ? [[i, found.list]] : [];
  });

/** @param {number} i */
const isAdaptive = (i) => {
  const name = params.value?.methods?.[i]?.method;
  return layout.value?.given.methods?.some((/** @type {any} */ one) => one.method === name && one.adaptive) === true;
};

/** One session, whose methods are what is wished: each halving has half the step, or a tenth of the tolerance.
 * @param {Wish[]} wishes @returns {Promise<(RefinementLevel & Wish)[]>} */
async function measureOnce(wishes) {
  const scenario = structuredClone(params.value),
    { duration_s: duration, methods } = scenario;
  scenario.timeline = [];
  scenario.expect = [];
  scenario.methods = wishes.map(({ i, n }) => ({
    ...methods[i],
    shown: true,
    dt_s: duration / (16 * 2 ** n),
    tolerance: Math.max(1e-15, 10 ** (-1 - n)),
  }));
  const made = await make('sessions', { scenario, paused: true }, false);
  try {
    await call('POST', `sessions/${made.id}/control`, { body: { op: 'seek', time_s: duration }, key: made.owner_key });
    const { metrics } = await call('GET', `sessions/${made.id}/metrics`);
    return metrics.methods.flatMap((/** @type {any} */ one, /** @type {number} */ k) =>
      one.status === 'ok' && one.e_max > 0
        ? [{ .../** @type {Wish} */ (wishes[k]), dt: one.dt_s ?? duration / one.steps, error: one.e_max, work: one.evaluations }]
        : [],
    );
  } finally {
    call('DELETE', `sessions/${made.id}`, { key: made.owner_key }).catch(() => {});
  }
}

/** @param {Wish[]} wishes @param {boolean} aloud whether a failure is said */
async function measureAll(wishes, aloud) {
  if (measuring.value || wishes.length === 0) return;
  measuring.value = true;
  const keys = new Map(wishes.map(({ i }) => [i, keyOf(i)]));
  /** @type {Map<number, RefinementLevel[]>} */
  const lists = new Map([...keys.keys()].map((i) => [i, []]));
  try {
    for (let k = 0; k < wishes.length; k += AT_ONCE) {
      for (const { i, ...level } of await measureOnce(wishes.slice(k, k + AT_ONCE))) lists.get(i)?.push(level);
      if ([...keys].some(([i, of]) => keyOf(i) !== of)) break; /* something else is shown by now */
      const done = wishes.slice(k + AT_ONCE);
      const whole = [...lists].filter(([i]) => !done.some((wish) => wish.i === i));
      measured.value = new Map([
        ...measured.value,
        ...whole.map(([i, list]) => /** @type {const} */ ([i, { of: keys.get(i) ?? '', list }])),
      ]);
    }
  } catch (error) {
    if (aloud) notify(t('motion.not_measured', { why: error instanceof Error ? error.message : t('session.no_answer_now') }));
    else refused = JSON.stringify([...keys.values()]);
  }
  measuring.value = false;
  touch();
}

/** @param {number} i @param {number} from @param {number} count */
const levelsOf = (i, from, count) =>
  Array.from({ length: count }, (_, k) => ({ i, n: from + k })).filter(({ n }) => !isAdaptive(i) || n < 14);

/** Down to the finest steps, of all methods. */
export const measure = () =>
  measureAll(
    places().flatMap((/** @type {number} */ i) => levelsOf(i, 0, FINEST)),
    true,
  );

// ---- by itself ----

/** The series that the daemon refused: they are not asked for again and again. */
let refused = '';
const inView = signal(false);

const viewer = new IntersectionObserver((entries) => {
  inView.value = entries.some(({ isIntersecting }) => isIntersecting);
});
/** @type {Element | null} */
let watched = null;

/** The lab has been rendered. */
export function watch() {
  const plot = document.getElementById('plot-step');
  if (plot === watched) return;
  viewer.disconnect();
  watched = plot;
  if (plot) viewer.observe(plot);
  else inView.value = false;
}

function measureMissing() {
  const have = new Set(series().map(([i]) => i)),
    missing = places().filter((/** @type {number} */ i) => !have.has(i));
  const count = missing.length > 4 ? FEW : MANY;
  if (JSON.stringify(missing.map(keyOf)) === refused) return;
  measureAll(
    missing.flatMap((/** @type {number} */ i) => levelsOf(i, FIRST, count)),
    false,
  );
}

/** @type {ReturnType<typeof setTimeout> | undefined} */
let soon;
effect(() => {
  clearTimeout(soon);
  const wanted =
    inView.value &&
    !measuring.value &&
    session.value?.own === true &&
    locked.value === '' &&
    may('measure') &&
    params.value?.kind === 'motion';
  if (wanted && layout.value?.given.problem === params.value.problem) soon = setTimeout(measureMissing, REST_MS);
});
