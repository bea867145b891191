// What the page knows, as signals. Modules read and write these; nothing else is shared.
import { computed, signal } from '../../vendor/signals-core.js';
import { schemaOf } from '../base/schema.js';
import { BEHIND, ENDED, FAILED, PLAYING } from '../stream/frame.js';
import { link } from './opening.js';
import { t } from '../base/words.js';

/** @typedef {import('../stream/frame.js').Frame} Frame */
/** What the hello says of the simulation. `given` is the layout of its kind.
 * @typedef {{kind: string, game: string, given: any, params: any}} Layout  game: the kind itself where there is none; params: at that time
 *  */
/** @typedef {{id: string, key: string, own: boolean}} Session  key is empty for a reader; own: made from the query */
/** @typedef {{id: string, title: string, paper: string, kind: string, text?: string}} ScenarioRow */
/** @type {import('@preact/signals-core').Signal<Session | null>} */
export const session = signal(null);
/** The whole scenario with its present values. @type {import('@preact/signals-core').Signal<any>} */
export const params = signal(null);
/** @type {import('@preact/signals-core').Signal<Layout | null>} */
export const layout = signal(null);
/** As the daemon gives it, by kind: of those that were asked for. @type {import('@preact/signals-core').Signal<Map<string, any>>} */
export const schemas = signal(new Map());

/** Of the session's scenario. */
export const schema = computed(() => (params.value ? schemaOf(schemas.value.get(params.value.kind), params.value) : null));
/** @type {import('@preact/signals-core').Signal<ScenarioRow[]>} */
export const scenarios = signal([]);
/** @type {import('@preact/signals-core').Signal<{state: import('../stream/handlers.js').State, attempt: number}>} */
export const connection = signal({ state: 'connecting', attempt: 0 });
export const FRAME_HZ = 60; /* requested rate of frames */
/** By which the daemon divides that, since frames are not drawn in time. */
export const divisor = signal(1);
/** The newest drawn frame. @type {import('@preact/signals-core').Signal<Frame | null>} */
export const frame = signal(null);
/** Why the session stopped by itself. */
export const failure = signal('');
/** What a person must read now; empty when there is nothing. */
export const notice = signal('');
/** The experiment that the Experiments view shows: empty for none; null while a session is shown.
 * @type {import('@preact/signals-core').Signal<string | null>} */
export const experiment = signal(link.experiment);
/** Speed against error is shown, where `experiment` is empty: what the address has for it; null: it is not.
 * @type {import('@preact/signals-core').Signal<string | null>} */
export const tradeoff = signal(link.tradeoff);
/** Where among the lessons the page is; null while a lab is shown.
 * @type {import('@preact/signals-core').Signal<import('../base/link.js').LessonAt | null>} */
export const lesson = signal(link.lesson);
/** before: the pace of another run, and what that was
 * @typedef {{at: string, player?: number, step: number, before: {rate: number, text: string} | null}} Look */
/** What the lesson that is shown is about, and its step. @type {import('@preact/signals-core').Signal<Look | null>} */
export const look = signal(null);
/** How large a lesson shows a track: metres across, on a narrow view too; from: the left edge, without it the cars are followed; only:
 * the players that are drawn, all without it.
 * @typedef {{m: number, narrow_m: number, from?: number, narrow_from?: number, only?: number[]}} Camera */
/** Of the lesson that is shown; null: the whole track. @type {import('@preact/signals-core').Signal<Camera | null>} */
export const camera = signal(null);
/** An entity as a screen had it at a tick. @typedef {{x: number, y: number, vx: number, age_ms: number, flags: number}} Once */
/** By tick, view and entity. @typedef {Map<number, Once[][]>} Recorded */
/** What a lesson adds to the drawings. press: the first tick with the key that it is about; brake: whether that is back, or ahead; first,
 * now: the first run and the one that is shown, as far as they are recorded; flags: choices, in ms after the key, empty where they have no
 * place on the road; chosen: one of them; plant: chooses; step: of the lesson; line: the parts of its time line, ms; none without one
 * @typedef {{player: number, press: number, brake: boolean, first: Recorded | null, now: Recorded | null, flags: number[], chosen: number,
 *   plant: (i: number) => void, step: number, line: number[]}} Staged */
/** @type {import('@preact/signals-core').Signal<Staged | null>} */
export const staged = signal(null);
/** Sizes that a lesson compares as bars. @type {import('@preact/signals-core').Signal<{text: string, value: number}[]>} */
export const bars = signal([]);
/** The tick at which a lesson's run begins. */
export const startTick = signal(0);
/** The first run of a lesson at its stop, which its last step compares with.
 * @type {import('@preact/signals-core').Signal<import('../stream/frame.js').Frame | null>} */
export const firstRun = signal(null);
/** What a lesson's step leaves to be used, settings by path; null: everything.
 * @type {import('@preact/signals-core').Signal<Set<string> | null>} */
export const allowed = signal(null);
/** Why a lesson holds time and settings; empty when it does not. */
export const held = signal('');
/** The tick at which Play stops, when it lies ahead; 0: none. */
export const stopTick = signal(0);
export const theme = signal(link.theme);
/** Views and caption alone, for the back row of a room. */
export const presenting = signal(link.present);
/** @type {import('@preact/signals-core').Signal<import('./lab.js').Place>} */
export const place = signal({ at: '', hz: 0, seat: null, reason: '', frozen: false });
/** The list of questions has no views. */
export const presented = computed(() => (presenting.value || place.value.staged === true) && lesson.value?.id !== '');
/** @typedef {'waiting' | 'playing' | 'paused' | 'ended' | 'failed'} Status */

export const status = computed(() => {
  /** @type {Status} */
  let now = 'waiting';
  const flags = frame.value?.flags;
  if (flags !== undefined) {
    now = flags & FAILED ? 'failed' : flags & ENDED ? 'ended' : flags & PLAYING ? 'playing' : 'paused';
  }
  return now;
});
export const behind = computed(() => frame.value !== null && (frame.value.flags & BEHIND) !== 0);
/** To seven digits, as the stream has it: 0.1, not its nearest float. */
export const speed = computed(() => Number((frame.value?.session?.speed ?? 1).toPrecision(7)));
export const readOnly = computed(() => session.value !== null && session.value.key === '');

/** Of a class: hides of the page, once it is rendered, all but the drawing of the moment.
 * @type {import('@preact/signals-core').Signal<((root: HTMLElement) => void) | null>} */
export const picked = signal(null);

/** Why nothing can be changed now; empty when it can. */
export const locked = computed(() => {
  if (session.value === null) return t('session.none_yet');
  if (connection.value.state === 'lost') return t('session.lost_controls');
  if (place.value.reason !== '') return place.value.reason;
  return readOnly.value ? t('session.read_only') : held.value;
});

/** Whether a step leaves a control to be used. @param {string} name */
export const may = (name) => allowed.value?.has(name) ?? true;

/** The same for what a person has just done: if not, that is said. @param {string} name */
export function usable(name) {
  if (!may(name)) notify(t('use.blocked'));
  return may(name);
}

/** Whether a person at this page may drive a player. @param {number} player */
export function mayDrive(player) {
  const { seat, frozen } = place.value;
  if (!may(`players.${player}.control`)) return false;
  if (seat === null) return locked.value === '';
  return seat === player && !frozen && session.value !== null && connection.value.state !== 'lost';
}

const NOTICE_MS = 15000;
/** @type {ReturnType<typeof setTimeout> | undefined} */
let fading;

/** Shows a message, and announces it. News disappears by itself; a rejected change stays until it is closed.
 * @param {string} text @param {boolean} [stays] */
export function notify(text, stays = false) {
  clearTimeout(fading);
  notice.value = text;
  if (!stays)
    fading = setTimeout(() => {
      notice.value = '';
    }, NOTICE_MS);
}
