// The labs: each shows the sessions of one kind of scenario, and is read when it is first shown.
import { computed, effect, signal } from '../../vendor/signals-core.js';
import { part } from '../base/api.js';
import { experiment, layout, lesson, tradeoff } from './state.js';

/** @typedef {import('./lab.js').About} About */
/** @typedef {import('./lab.js').Lab} Lab */

/** @type {import('@preact/signals-core').Signal<About[]>} */
export const labs = signal([]);
/** The one that is read before the session's kind is known. @type {import('@preact/signals-core').Signal<About | undefined>} */
const likely = signal(undefined);
/** Those that are read, by kind. @type {import('@preact/signals-core').Signal<Map<string, Lab>>} */
const read = signal(new Map());
/** @type {Map<string, Promise<void>>} */
const reading = new Map();
const completed = new Set();

/** The first page, which makes a session of its own. */
export const front = () => labs.value.find(({ start }) => start !== undefined);

/** The kind that is shown. */
const kind = computed(() => {
  const now = layout.value?.kind,
    list = labs.value;
  if (lesson.value?.id === '') return front()?.kind;
  if (experiment.value !== null) {
    const wanted = tradeoff.value === null ? 'experiments' : 'tradeoff';
    return list.find((one) => one.sessionless && one.kind === wanted)?.kind;
  }
  return list.some((one) => one.kind === now) ? now : likely.value?.kind;
});

/** The lab that is shown, once it is read. Only the first has something to show before a session is there. */
export const lab = computed(() =>
  layout.value === null && experiment.value === null && lesson.value?.id !== '' && likely.value !== labs.value[0]
    ? undefined
    : read.value.get(kind.value ?? ''),
);

/** @param {string} name @param {Partial<Lab>} found */
function put(name, found) {
  const known = read.peek().get(name);
  read.value = new Map(read.peek()).set(name, /** @type {Lab} */ ({ ...known, ...found }));
}

/** @param {About} about @returns {Promise<void>} once it is read */
export function load(about) {
  let now = reading.get(about.kind);
  if (!now) {
    now = part(about.load).then((found) => put(about.kind, found));
    reading.set(about.kind, now);
    now.catch(() => reading.delete(about.kind)); // it is read again when it is wanted again
  }
  return now;
}

/** Reads each lab when it is first shown, and ends it when it is left. @param {About[]} list @param {About} first */
export function register(list, first) {
  likely.value = first;
  labs.value = list;
  let before = '';
  effect(() => {
    const now = lab.value ? (kind.value ?? '') : '';
    if (now !== before) read.peek().get(before)?.end?.();
    before = now;
  });
  effect(() => {
    const about = list.find((one) => one.kind === kind.value);
    if (about) load(about);
  });
}

/** Reads the rest of the labs that are shown from now on. */
export function complete() {
  effect(() => {
    const name = kind.value ?? '',
      later = lab.value?.later;
    if (!later || completed.has(name)) return;
    completed.add(name);
    part(later).then((found) => put(name, found));
  });
}

/** The tab that a game or kind belongs to. @param {string} shown @returns {string} its id; empty for none */
export function tabOf(shown) {
  const own = labs.value.flatMap(({ tabs }) => tabs).find(({ shows }) => shows.includes(shown));
  if (own) return own.id;
  const entries = labs.value.flatMap(({ elsewhere }) => Object.entries(elsewhere ?? {}));
  return entries.find(([, shows]) => shows.includes(shown))?.[0] ?? '';
}
