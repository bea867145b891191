// Measurements on the daemon: started, polled until they end, cancelled. They go on while another family or a lab is shown; the tab keeps
// what came out.
import { computed, effect, signal, untracked } from '../../../vendor/signals-core.js';
import { Problem, call, insist, make } from '../../base/api.js';
import { t } from '../../base/words.js';
import { speak } from '../../session/announce.js';
import { notify } from '../../session/state.js';
import { move, place } from './place.js';

/** @typedef {[number | null, number | null, number | null]} Measured  value, and the bounds of its interval */
/** @typedef {{scenario: string, error: string, title: string}} Question */
/** @typedef {{name: string, title: string, text: string, problems: Question[], costs: {path: string, title: string}[]}} Family */
/** @typedef {{error: Measured, costs: Measured[], cpu_median_s: number | null, seed: number, seeds: number}} Values */
/** @typedef {Values & {problem: number, by: string, method: string, setting: string, value: number | null, status: string, random: boolean,
 *   front: boolean[], check: Values | null, set: string, link: string}} Row */
/** row, check_cheapest: places in `rows`
 * @typedef {{problem: number, cost: number, level: number, row: number | null, outcome: string, figures: string,
 * check_cheapest: number | null, as_cheap: string[]}} Choice */
/** @typedef {Family & {rows: Row[], choices: Choice[]}} Answer */
/** state: of the daemon; `gone`: it has it no more.
 * @typedef {{family: string, key: string, state: string, done: number, steps: number, error: string}} Job */
/** @typedef {{family: string, seeds?: number, duration_s?: number}} Order */

const POLL_MS = 500; /* the daemon suspends what is not polled for 0.8 s */
const KEPT = 'laglab.tradeoffs';

/** @type {import('@preact/signals-core').Signal<Family[]>} */
export const families = signal([]);
/** By id. @type {import('@preact/signals-core').Signal<Map<string, Job>>} */
export const jobs = signal(new Map());
/** By id. @type {import('@preact/signals-core').Signal<Map<string, Answer>>} */
const answers = signal(new Map());

export const shownFamily = computed(() => families.value.find(({ name }) => name === place.value?.family) ?? families.value[0]);
export const job = computed(() => jobs.value.get(place.value?.job ?? ''));
export const answer = computed(() => answers.value.get(place.value?.job ?? ''));
/** The last measurement of a family, in this tab. @param {string} family */
export const lastOf = (family) =>
  [...jobs.value].filter(([, one]) => one.family === family && !['gone', 'cancelled'].includes(one.state)).at(-1)?.[0] ?? '';

// ---- what the tab keeps ----

/** @returns {{id: string, family: string, key: string, answer: Answer | null}[]} the last of each family */
function kept() {
  try {
    const list = JSON.parse(sessionStorage.getItem(KEPT) ?? '[]');
    return Array.isArray(list) ? list : [];
  } catch {
    return []; /* then they last as long as the page */
  }
}

/** @param {string} id @param {string} family @param {string} key @param {Answer | null} found */
function keep(id, family, key, found) {
  const list = [...kept().filter((one) => one.family !== family), { id, family, key, answer: found }];
  for (let from = 0; from < list.length; from++) {
    try {
      sessionStorage.setItem(KEPT, JSON.stringify(list.slice(from)));
      return;
    } catch {
      /* there is no room: without the oldest */
    }
  }
}

for (const one of kept()) {
  const state = one.answer === null ? 'running' : 'done';
  jobs.value = new Map(jobs.peek()).set(one.id, { family: one.family, key: one.key, state, done: 0, steps: 0, error: '' });
  if (one.answer !== null) answers.value = new Map(answers.peek()).set(one.id, one.answer);
  else queueMicrotask(() => follow(one.id));
}

// ---- one measurement ----

/** @param {string} id @param {Partial<Job>} change */
function put(id, change) {
  const known = jobs.peek().get(id) ?? { family: '', key: '', state: 'running', done: 0, steps: 0, error: '' };
  jobs.value = new Map(jobs.peek()).set(id, { ...known, ...change });
}

/** @param {string} id @param {any} now as the daemon describes it */
function take(id, { state, done, steps, error, answer: found }) {
  if (found) {
    answers.value = new Map(answers.peek()).set(id, found);
    keep(id, found.name, jobs.peek().get(id)?.key ?? '', state === 'running' ? null : found);
  }
  put(id, { state, done, steps, error: error ?? '', ...(found ? { family: found.name } : {}) });
  const at = place.peek();
  if (found && at?.job === id && at.family !== found.name) move({ family: found.name });
  if (state !== 'running') speak('tradeoff', t(`tradeoff.spoken.${state}`));
}

/** Polls until it has ended. @param {string} id */
async function follow(id) {
  while (jobs.peek().get(id)?.state === 'running') {
    try {
      const now = await call('GET', `tradeoffs/${id}`);
      if (jobs.peek().get(id)?.state !== 'running') return; /* cancelled meanwhile */
      take(id, now);
    } catch (error) {
      if (error instanceof Problem && error.status === 404 && jobs.peek().get(id)?.state === 'running') put(id, { state: 'gone' });
    }
    await new Promise((done) => setTimeout(done, POLL_MS));
  }
}

/** @param {unknown} error */
const detailOf = (error) => (error instanceof Error ? error.message : t('session.no_answer_now'));

/** @param {Order} order */
export async function start(order) {
  try {
    const made = await make('tradeoffs', order);
    const key = made.owner_key ?? jobs.peek().get(made.id)?.key ?? ''; /* another client's measurement runs */
    put(made.id, { family: order.family, key });
    keep(made.id, order.family, key, null);
    follow(made.id);
    speak('tradeoff', t('tradeoff.spoken.started'));
    move({ family: order.family, job: made.id });
  } catch (error) {
    notify(t('session.not_done', { detail: detailOf(error) }), true);
  }
}

export async function cancel() {
  const id = place.value?.job ?? '',
    one = jobs.value.get(id);
  if (!one) return;
  put(id, { state: 'cancelled' });
  try {
    await call('DELETE', `tradeoffs/${id}`, { key: one.key });
  } catch (error) {
    if (!(error instanceof Problem) || error.status !== 404) notify(t('session.not_done', { detail: detailOf(error) }));
  }
}

/* An address may name a measurement that this tab does not know. */
effect(() => {
  const at = place.value;
  if (at === null || at.job === '') return;
  untracked(() => {
    if (jobs.value.has(at.job)) return;
    put(at.job, { family: at.family });
    follow(at.job);
  });
});

insist(() => call('GET', 'tradeoffs')).then((found) => {
  families.value = found.families;
});
