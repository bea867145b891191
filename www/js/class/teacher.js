// What the teacher does to a class.
import { effect, signal, untracked } from '../../vendor/signals-core.js';
import { Problem, call } from '../base/api.js';
import { keep, keyOf } from '../session/opening.js';
import { show } from '../session/session.js';
import { notify, place, session } from '../session/state.js';
import { control } from '../session/time.js';
import { keepClass } from './kept.js';
import { readLesson, readLessons } from './lesson.js';
import { now, part, reason, room, say, secret, shows } from './state.js';
import { t } from '../base/words.js';

/** Of the next question that is not one of a lesson. */
export const choices = signal(4);

const HAND_OVER_MS = 15000 /* of several daemons, the one that has just made a session keeps it for 5 s */,
  AGAIN_MS = 500;

/** Shows a session on the board of a class; waits while another daemon hands it over to the one that has the class.
 * @param {string} id of the class @param {string} key the teacher's @param {import('../session/state.js').Session} shown
 * @returns {Promise<any>} */
export async function putBoard(id, key, shown) {
  const end = performance.now() + HAND_OVER_MS;
  for (;;) {
    try {
      return await call('PUT', `classes/${id}/board`, { body: { session: shown.id, owner_key: shown.key }, key });
    } catch (error) {
      if (!(error instanceof Problem) || error.status !== 503 || performance.now() > end) throw error;
      notify(t('class.preparing'));
      await new Promise((done) => setTimeout(done, AGAIN_MS));
    }
  }
}

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
  const lesson = id === '' ? null : await readLesson(id);
  if (lesson === null) return set({ lesson: '', phase: 'lobby', stop_tick: 0 });
  const made = await ask('PUT', '/board', { scenario: lesson.scenario, set: lesson.set, seed: lesson.seed });
  if (made === null) return;
  keep(made.id, made.owner_key, false);
  follow(made.id);
  await control({ op: 'speed', speed: lesson.speed });
  await set({ lesson: id, step: 0, stop_tick: lesson.stop_tick, phase: 'lobby' });
}

export const end = () => ask('DELETE', '');

/** The board as far as this page knows it, and the one before. */
let board = '',
  left = '';

/** Shows a session that is on the board. @param {string} id */
function follow(id) {
  if (id === board && session.peek()?.id === id) return;
  left = board;
  board = id;
  untracked(() => show(id, keyOf(id) || secret.peek(), false));
}

/** Puts the session that this page shows on the board. @param {import('../session/state.js').Session} shown */
async function put(shown) {
  left = board;
  board = shown.id;
  const made = await tried(() => putBoard(room.peek()?.id ?? '', secret.peek(), shown));
  if (!made?.owner_key) return;
  keep(made.id, made.owner_key, false); /* several daemons show a fork of it */
  follow(made.id);
}

/** From now on this page is the teacher's. @param {string} key @param {'lobby' | 'board'} first */
export function begin(key, first) {
  const at = `#class=${room.peek()?.code}`;
  board = session.peek()?.id ?? '';
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
  if (there === board) left = '';
  if (there !== board && there !== left) follow(there);
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
