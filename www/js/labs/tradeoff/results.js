// What was measured: the rows that came with the program, and those of this machine, which the daemon has and all clients see.
import { computed, effect, signal, untracked } from '../../../vendor/signals-core.js';
import { Problem, call, insist, make } from '../../base/api.js';
import { t } from '../../base/words.js';
import { speak } from '../../session/announce.js';
import { notify } from '../../session/state.js';
import { place } from './place.js';

/** @typedef {import('./rule.js').Measured} Measured */
/** @typedef {import('./rule.js').Row} Row */
/** @typedef {{scenario: string, error: string, title: string}} Question */
/** job: the newest measurement of this daemon; shipped: the address of the rows that came with the program
 * @typedef {{job: string | null, shipped: string}} Results */
/** first: methods by name, which are measured first
 * @typedef {{name: string, title: string, text: string, problems: Question[], costs: {path: string, title: string}[],
 *   first: string[], results: Results}} Family */
/** row, check_cheapest: places in `rows`
 * @typedef {{problem: number, cost: number, level: number, row: number | null, outcome: string, figures: string,
 * check_cheapest: number | null, as_cheap: string[]}} Choice */
/** machine: its processors; date: as RFC 3339; version: a commit
 * @typedef {{rows: Row[], choices: Choice[], machine?: string, date?: string, version?: string}} Answer */
/** @typedef {{id: string, state: string, done: number, steps: number, error: string, date: string, answer: Answer | null}} Job */

const POLL_MS = 700,
  LOOK_MS = 4000; /* for what others have begun */

/** @type {import('@preact/signals-core').Signal<Family[]>} */
export const families = signal([]);
/** By family. @type {import('@preact/signals-core').Signal<Map<string, Answer>>} */
const shipped = signal(new Map());
/** By family. @type {import('@preact/signals-core').Signal<Map<string, Job>>} */
const jobs = signal(new Map());
/** Of measurements that this page has started, by their ids. @type {import('@preact/signals-core').Signal<Map<string, string>>} */
const keys = signal(new Map());

export const shownFamily = computed(() => families.value.find(({ name }) => name === place.value?.family) ?? families.value[0]);
export const shippedAnswer = computed(() => shipped.value.get(shownFamily.value?.name ?? ''));
export const job = computed(() => jobs.value.get(shownFamily.value?.name ?? ''));
/** Whether this page may end the measurement. */
export const mine = computed(() => keys.value.has(job.value?.id ?? ''));

/** @param {string} family @param {Job} next */
function put(family, next) {
  jobs.value = new Map(jobs.peek()).set(family, next);
}

/** @type {Set<string>} families whose measurement is followed */
const followed = new Set();

/** @param {string} id @returns {Promise<Job | null>} null: the daemon has it no more */
async function read(id) {
  try {
    const { state, done, steps, error, date, answer } = await call('GET', `tradeoffs/${id}`);
    return { id, state, done, steps, error: error ?? '', date: date ?? '', answer: answer ?? null };
  } catch (error) {
    if (error instanceof Problem && error.status === 404) return null;
    throw error;
  }
}

const pause = (/** @type {number} */ ms) => new Promise((done) => setTimeout(done, ms));

/** Until it has ended, or another takes its place. @param {string} family @param {string} id */
async function follow(family, id) {
  if (followed.has(id)) return;
  followed.add(id);
  for (let wait = POLL_MS; ; ) {
    try {
      const now = await read(id);
      if (now === null) {
        if (jobs.peek().get(family)?.id === id) {
          const left = new Map(jobs.peek());
          left.delete(family);
          jobs.value = left;
        }
        break;
      }
      const before = jobs.peek().get(family);
      put(family, { ...now, answer: now.answer ?? (before?.id === id ? before.answer : null) });
      if (now.state !== 'running') {
        if (before?.id === id && before.state === 'running') speak('tradeoff', t(`tradeoff.spoken.${now.state}`));
        break;
      }
      wait = place.peek() === null || document.hidden ? LOOK_MS : POLL_MS;
    } catch {
      /* the daemon is away: it goes on when it is back */
    }
    await pause(wait);
  }
  followed.delete(id);
}

/** What others have begun. @param {Family[]} found */
function look(found) {
  for (const { name, results } of found)
    if (results.job !== null && results.job !== jobs.peek().get(name)?.id && name === shownFamily.peek()?.name) follow(name, results.job);
}

/** @param {unknown} error */
const detailOf = (error) => (error instanceof Error ? error.message : t('session.no_answer_now'));

/** Measures here. @param {string} family @param {string[] | 'all'} [methods] none: those by name */
export async function start(family, methods) {
  try {
    const made = await make('tradeoffs', { family, ...(methods ? { methods } : {}) });
    if (made.owner_key) keys.value = new Map(keys.peek()).set(made.id, made.owner_key);
    speak('tradeoff', t('tradeoff.spoken.started'));
    follow(family, made.id);
  } catch (error) {
    notify(t('session.not_done', { detail: detailOf(error) }), true);
  }
}

export async function cancel() {
  const id = job.value?.id ?? '';
  try {
    await call('DELETE', `tradeoffs/${id}`, { key: keys.value.get(id) ?? '' });
  } catch (error) {
    if (!(error instanceof Problem) || error.status !== 404) notify(t('session.not_done', { detail: detailOf(error) }));
  }
}

let looking = false;
/** The families, now and again while the view is open. */
async function watch() {
  if (looking) return;
  looking = true;
  while (place.peek() !== null) {
    if (!document.hidden || families.peek().length === 0) {
      const found = await insist(() => call('GET', 'tradeoffs'));
      if (families.peek().length === 0) families.value = found.families;
      look(found.families);
    }
    await pause(LOOK_MS);
  }
  looking = false;
}
effect(() => {
  if (place.value !== null) untracked(watch);
});

/** Families whose rows are read or asked for. @type {Set<string>} */
const asked = new Set();
effect(() => {
  const family = shownFamily.value;
  if (place.value === null || family === undefined) return;
  untracked(() => {
    look([family]);
    if (asked.has(family.name)) return;
    asked.add(family.name);
    insist(async () => (await fetch(new URL(family.results.shipped, document.baseURI))).json()).then((answer) => {
      shipped.value = new Map(shipped.peek()).set(family.name, answer);
    });
  });
});
