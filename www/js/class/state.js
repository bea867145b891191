// What the page knows of its class, as signals.
import { computed, signal } from '../../vendor/signals-core.js';
import { notify } from '../session/state.js';
import { t } from '../base/words.js';

/** @typedef {{player: number, name: string, state: 'free' | 'held' | 'away' | 'script', rtt_ms: number | null, lag_ms: number}} Seat */
/** The state of a class, as its stream broadcasts it.
 * @typedef {{serial: number, phase: string, lesson: string, step: number, frozen: boolean, together: boolean, stop_tick: number,
 *   question: {lesson: string, step: number, choices: number} | null, votes: number, tally: number[] | null, seats: Seat[], n: number,
 *   copies: number, board: string | null, status: string | null, tick: number, door: 'open' | 'closed'}} State */
/** A member as its teacher sees it; group: the same for those of one address; home: where the class was opened.
 * @typedef {{number: number, role: 'watch' | 'play' | 'copy', player: number | null, connected: boolean, voted: boolean, group: string,
 *   home: boolean, joined_s: number}} Device */
/** @typedef {{number: number, role: 'watch' | 'play' | 'copy', player: number | null, choice: number | null,
 *   copy: string | null}} Member */
/** local: only this computer reaches the daemon. @typedef {{id: string, code: string, urls: string[], local: boolean}} Room */

/** @type {import('@preact/signals-core').Signal<Room | null>} */
export const room = signal(null);
/** @type {import('@preact/signals-core').Signal<State | null>} */
export const now = signal(null);
/** This page's part: the teacher's key, or a member's token; empty for who has neither yet. */
export const secret = signal('');
/** @type {import('@preact/signals-core').Signal<'' | 'teacher' | 'member'>} */
export const part = signal('');
/** What a member is. @type {import('@preact/signals-core').Signal<Member | null>} */
export const me = signal(null);
/** What only the teacher receives. @type {import('@preact/signals-core').Signal<{most: number, members: Device[]}>} */
export const devices = signal({ most: 0, members: [] });
/** The teacher has removed this device. */
export const out = signal(false);
/** What is shown: to the teacher the stage of the phase, or the board with all its controls; to a member the choice of a part, the board or
 * its copy. @type {import('@preact/signals-core').Signal<'choose' | 'stage' | 'workbench' | 'board' | 'copy'>} */
export const shows = signal('choose');
/** The page is a stage: drawings of the board with the words of the phase around them. */
export const staged = computed(
  () => (part.value === 'teacher' && shows.value === 'stage') || (part.value === 'member' && shows.value === 'board'),
);
/** Who holds a seat drives now: a lesson shows what its script does. */
export const driving = computed(() => now.value !== null && (now.value.lesson === '' || now.value.phase === 'free'));
/** Attempts to reach the class since its stream was lost; 0 while it is open. */
export const attempt = signal(0);
/** What a person must read where the page's own notes are hidden. */
export const told = signal('');

/** @param {string} text */
export function say(text) {
  told.value = text;
  if (text !== '') notify(text);
}

/** @param {unknown} error */
export const reason = (error) => (error instanceof Error && error.name !== 'TypeError' ? error.message : t('session.no_answer_now'));
