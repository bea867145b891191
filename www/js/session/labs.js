// The labs: each shows the sessions of one kind of scenario. What differs between them goes through here.
import { computed, effect, signal } from '../../vendor/signals-core.js';
import { part } from '../base/api.js';
import { experiment, layout } from './state.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('../stream/frame.js').Frame} Frame */
/** A key of the keyboard; everywhere: also where no session is shown.
 * @typedef {{code: string, alt?: boolean, shift?: boolean, repeat?: boolean, everywhere?: boolean, shown: string, help: string,
 *   run: () => void}} Key */
/** What a dialog is about: `kind` says who shows it. @typedef {{kind: string, of?: any}} Dialog */

/** A button in the head of the page: `/#ID` opens the same scenario. Scenarios of the games or kinds that it shows belong to it.
 * @typedef {{id: string, name: string, scenario: string, shows: string[]}} Tab */

/** Experiments of a kind. A work-precision diagram has groups of axes, each with values that go together: a path and its values, all
 * choices where there are none; paths that a scenario lacks are left out. errors: metrics of the error, the best first; brief_s: what makes
 * a first experiment last seconds.
 * @typedef {{axes: [string, string][][], errors: RegExp, more: string[], repeats: string, brief_s?: number}} Study */

/**
 * What is known of a lab before it is read.
 * @typedef {object} About
 * @property {string} kind   of the scenarios that it shows
 * @property {boolean} [sessionless]  the Experiments view: it shows no session
 * @property {string} group  their heading in the list of scenarios
 * @property {Tab[]} tabs
 * @property {Record<string, string[]>} [elsewhere]  by the id of another lab's tab: what belongs to it all the same
 * @property {Record<string, number>} rates  of the channels to subscribe to, Hz
 * @property {Study} [study]
 * @property {() => Promise<Lab>} load
 */

/**
 * A lab. All but the template may be missing.
 * @typedef {object} Lab
 * @property {() => Template} template  what stands below the head of the page
 * @property {() => void} [rendered]    the template has been rendered
 * @property {(fresh: boolean) => void} [begin]  the stream has begun, and `layout` says of what; fresh: nothing of the session was drawn yet
 * @property {(frame: Frame) => void} [take]     a frame has come; not each is drawn
 * @property {(frame: Frame, settled: boolean, name: boolean) => void} [draw]  settled: no frame follows soon, so draw all of it; name: the
 *   drawings get their descriptions
 * @property {() => Record<string, number>} [rates]  other than those it begins with; 0 for a channel that is not wanted
 * @property {(now: any, before: any, asked: Record<string, unknown>) => string[]} [followed]  parameters that changed with those asked for
 * @property {() => PropertyDescriptorMap} [facts]  of window.laglab
 * @property {Key[]} [keys]
 * @property {(event: KeyboardEvent) => boolean} [press]  a key that is none of `keys`: whether it was one of the lab's
 * @property {(event: KeyboardEvent) => void} [release]
 * @property {() => Template} [help]  of the keys and views
 * @property {Record<string, (of: any) => [string, Template]>} [dialogs]  title and content, by kind
 * @property {() => Promise<Partial<Lab>>} [later]  reads what can wait until the first frame is drawn
 */

/** All of them; the first is shown until the session's kind is known. @type {import('@preact/signals-core').Signal<About[]>} */
export const labs = signal([]);
/** Those that are read, by kind. @type {import('@preact/signals-core').Signal<Map<string, Lab>>} */
const read = signal(new Map());
/** @type {Map<string, Promise<void>>} */
const reading = new Map();
const completed = new Set();

/** The kind that is shown. */
const kind = computed(() => {
  const now = layout.value?.kind,
    list = labs.value;
  if (experiment.value !== null) return list.find((one) => one.sessionless)?.kind;
  return list.some((one) => one.kind === now) ? now : list[0]?.kind;
});

/** The lab that is shown, once it is read. */
export const lab = computed(() => read.value.get(kind.value ?? ''));

/** @param {string} name @param {Partial<Lab>} found */
function put(name, found) {
  const known = read.peek().get(name);
  read.value = new Map(read.peek()).set(name, /** @type {Lab} */ ({ ...known, ...found }));
}

/** @param {About} about @returns {Promise<void>} once it is read */
export function load(about) {
  const now = reading.get(about.kind) ?? part(about.load).then((found) => put(about.kind, found));
  reading.set(about.kind, now);
  return now;
}

/** Reads each lab when it is first shown. @param {About[]} list */
export function register(list) {
  labs.value = list;
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
