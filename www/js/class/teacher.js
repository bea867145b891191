// What the teacher does to a class.
import { effect, signal, untracked } from '../../vendor/signals-core.js';
import { call } from '../base/api.js';
import { keep, keyOf } from '../session/opening.js';
import { show } from '../session/session.js';
import { place, session } from '../session/state.js';
import { control } from '../session/time.js';
import { keepClass } from './kept.js';
import { readLesson, readLessons } from './lesson.js';
import { now, part, reason, room, say, secret, shows } from './state.js';
import { t } from '../base/words.js';

/** Of the next question that is not one of a lesson. */
export const choices = signal(4);

/** Shows a session on the board of a class. @param {string} id of the class @param {string} key the teacher's
 * @param {import('../session/state.js').Session} shown @returns {Promise<any>} */
export const putBoard = (id, key, shown) => call('PUT', `classes/${id}/board`, { body: { session: shown.id, owner_key: shown.key }, key });

/** @param {() => Promise<any>} request @returns {Promise<any>} null when it was refused */
async function tried(request) {
  try {
    return (await request()) ?? {};
  } catch (error) {
    say(t('session.not_done', { detail: reason(error) }));
    return null;
  }
}

/** @param {string} method @param {string} path below the class @param {unknown} [body] @returns {Promise<any>} null when it was refused */
const ask = (method, path, body) => tried(() => call(method, `classes/${room.peek()?.id}${path}`, { body, key: secret.peek() }));

/** @param {Record<string, unknown>} patch */
export async function set(patch) {
  const state = await ask('PATCH', '', patch);
  const known = now.peek();
  if (state !== null && (known === null || state.serial >= known.serial)) now.value = state;
}

/** Removes a device, and those that joined after it or are at its address. @param {number} number @param {'' | 'later' | 'address'} and */
export const remove = (number, and) => ask('DELETE', `/members/${number}${and === '' ? '' : `?and=${and}`}`);

/** Who holds a seat watches from now on. */
export const freeSeats = () =>
  Promise.all((now.peek()?.seats ?? []).filter(({ state }) => state !== 'free').map(({ player }) => ask('DELETE', `/seats/${player}`)));

/** Counted up when a board, or a question, is chosen: what still waits for an older one gives up. */
let turn = 0,
  questions = 0;

/** The board as far as this page knows it. */
let board = '';
/** The boards before it: the class may still report them until it reports that one. @type {Set<string>} */
const left = new Set();

/** @param {string} id of the board from now on */
function move(id) {
  left.add(board);
  left.delete(id);
  board = id;
}

/** The next phase. To predict once more is a new question, but for a lesson's, which keeps its votes. @param {string} name */
export function phase(name) {
  const state = now.peek();
  if (state === null) return;
  if (name !== 'predict') return set({ phase: name });
  const { lesson, step, question, phase: last } = state;
  if (lesson !== '' && question !== null && question.lesson === lesson) return set({ phase: name, choices: question.choices });
  if (lesson !== '') return readLesson(lesson).then((found) => set({ phase: name, choices: found?.choices.length ?? choices.peek() }));
  const asked = question !== null && question.lesson === '' && question.step === step && last !== 'predict';
  return set({ phase: name, choices: choices.peek(), step: asked ? Math.min(999, step + 1) : step });
}

/** Shows the scene of a lesson and prepares its question; empty for a question that the teacher asks aloud. @param {string} id */
export async function choose(id) {
  const asked = ++questions;
  const lesson = id === '' ? null : await readLesson(id);
  if (asked !== questions) return;
  if (lesson === null) return set({ lesson: '', phase: 'lobby', stop_tick: 0 });
  const mine = ++turn;
  const { scenario, set: settings, seed, workload } = lesson;
  const made = await ask('PUT', '/board', { scenario, set: settings, seed, ...(workload ? { workload } : {}) });
  if (made === null) return;
  keep(made.id, made.owner_key, false);
  if (mine !== turn) {
    left.add(made.id);
    return;
  }
  follow(made.id);
  if (asked !== questions) return;
  await control({ op: 'speed', speed: lesson.speed });
  if (lesson.start_tick) await control({ op: 'seek', tick: lesson.start_tick });
  await set({ lesson: id, step: 0, stop_tick: lesson.stop_tick, phase: 'lobby' });
}

export const end = () => ask('DELETE', '');

/** Shows a session that is on the board. @param {string} id */
function follow(id) {
  if (id === board && session.peek()?.id === id) return;
  move(id);
  untracked(() => show(id, keyOf(id) || secret.peek(), false));
}

/** Puts the session that this page shows on the board. @param {import('../session/state.js').Session} shown */
function put(shown) {
  turn++;
  move(shown.id);
  return tried(() => putBoard(room.peek()?.id ?? '', secret.peek(), shown));
}

/** From now on this page is the teacher's. @param {string} key @param {'lobby' | 'board'} first
 * @param {string} [shown] the board, where it is not what the page shows */
export function begin(key, first, shown = session.peek()?.id ?? '') {
  const at = `#class=${room.peek()?.code}`;
  turn++;
  left.clear();
  board = shown;
  place.value = { at, hz: 0, seat: null, reason: '', frozen: false, board: true };
  secret.value = key;
  part.value = 'teacher';
  shows.value = first;
  readLessons();
}

effect(() => {
  /* another scenario is chosen on this page */
  const shown = session.value;
  if (part.value !== 'teacher' || shown === null || shown.key === '' || shown.id === board) return;
  untracked(() => put(shown));
});
effect(() => {
  /* another device of the teacher has chosen one */
  const there = now.value?.board ?? null;
  if (part.value !== 'teacher' || there === null) return;
  if (left.has(there)) return;
  if (there !== board) follow(there);
  left.clear();
});
effect(() => {
  if (part.value !== 'teacher') return;
  const why = now.value?.frozen ? t('class.frozen_teacher') : '';
  if (place.peek().reason !== why) place.value = { ...place.peek(), reason: why };
});
effect(() => {
  const at = room.value,
    key = secret.value;
  if (part.value === 'teacher' && at !== null) keepClass({ id: at.id, secret: key, teacher: true, shows: shows.value });
});
