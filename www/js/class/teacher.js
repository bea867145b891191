// What the teacher does to a class.
import { effect, signal, untracked } from '../../vendor/signals-core.js';
import { call } from '../base/api.js';
import { CHANGE, stopOf } from '../lessons/steps.js';
import { keep, keyOf } from '../session/opening.js';
import { show } from '../session/session.js';
import { params, place, session } from '../session/state.js';
import { keepClass } from './kept.js';
import { lessonOf, lessons, readLesson, readLessons } from './lesson.js';
import { now, part, reason, room, say, secret, shows } from './state.js';
import { language, t } from '../base/words.js';

/** @typedef {import('./lesson.js').Lesson} Lesson */

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
export async function phase(name) {
  const state = now.peek();
  if (state === null) return;
  const { lesson: id, step, question, phase: last } = state,
    lesson = id === '' ? null : await readLesson(id);
  if (name === 'explain' && lesson !== null) await stand(lesson.stop_tick);
  if (name === 'change' && lesson !== null) return change(lesson);
  if (name !== 'predict') return set({ phase: name });
  if (lesson !== null) return set({ phase: name, choices: lesson.choices.length });
  if (id !== '' && question?.lesson === id) return set({ phase: name, choices: question.choices });
  const asked = id === '' && question?.lesson === '' && question.step === step && last !== 'predict';
  return set({ phase: name, choices: choices.peek(), step: asked ? Math.min(999, step + 1) : step });
}

/** The board stands at the lesson's stop: what is explained is seen there. @param {number} tick */
async function stand(tick) {
  const { status, tick: at } = /** @type {import('./state.js').State} */ (now.peek());
  if (at === tick && status !== 'playing') return;
  const shown = session.peek();
  if (shown === null) return;
  for (const op of [{ op: 'pause' }, { op: 'seek', tick }])
    await tried(() => call('POST', `sessions/${shown.id}/control`, { body: op, key: shown.key }));
}

/** What a request for a lesson's board says. @param {Lesson} lesson @param {Record<string, unknown>} [changed] */
export const boardOf = ({ scenario, set: given, seed, workload }, changed = {}) => ({
  scenario,
  set: { ...given, ...changed },
  seed,
  ...(workload ? { workload } : {}),
});

/** A lesson's board at its start, at its speed. @param {Lesson} lesson @param {string} board @param {string} key */
export async function prepare({ speed, start_tick = 0 }, board, key) {
  for (const body of [{ op: 'speed', speed }, ...(start_tick > 0 ? [{ op: 'seek', tick: start_tick }] : [])])
    await call('POST', `sessions/${board}/control`, { body, key });
}

/** Another session on the board, which plays at the lesson's speed. @param {Lesson} lesson @param {boolean} [changed] with its change
 * @returns {Promise<boolean>} whether it is there, and nothing was chosen meanwhile */
async function renew(lesson, changed = false) {
  const mine = ++turn,
    { set: other, speed = lesson.speed } = lesson.change;
  const made = await ask('PUT', '/board', boardOf(lesson, changed ? other : {}));
  if (made === null) return false;
  keep(made.id, made.owner_key, false);
  if (mine !== turn) {
    left.add(made.id);
    return false;
  }
  follow(made.id);
  await tried(() => prepare(changed ? { ...lesson, speed } : lesson, made.id, made.owner_key));
  return mine === turn;
}

/** Runs a lesson once more, with its change. @param {Lesson} lesson */
async function change(lesson) {
  const stop = stopOf(lesson, CHANGE, Number(params.peek()?.hz ?? 60));
  if (await renew(lesson, true)) await set({ phase: 'change', stop_tick: stop });
}

/** Shows the scene of a lesson and prepares its question; empty for a question that the teacher asks aloud. @param {string} id
 * @param {boolean} [at_once] whether it is asked */
export async function choose(id, at_once = false) {
  const asked = ++questions;
  const lesson = id === '' ? null : await readLesson(id);
  if (asked !== questions) return;
  if (lesson === null) return set({ lesson: '', phase: 'lobby', stop_tick: 0 });
  if (!(await renew(lesson)) || asked !== questions) return;
  await set({ ...questionOf(lesson), ...(at_once ? { phase: 'predict', choices: lesson.choices.length } : { phase: 'lobby' }) });
}

/** What the class knows of a lesson. @param {Lesson} lesson */
export const questionOf = ({ id, stop_tick }) => ({ lesson: id, step: 0, stop_tick });

/** What comes next, by the phase: the words of the button, and what it does.
 * @returns {{says: string, values?: Record<string, unknown>, act: () => unknown}} */
export function next() {
  const { phase: at = 'lobby', lesson = '' } = now.value ?? {};
  const to = (/** @type {string} */ name, says = `class.next.${name}`) => ({ says, act: () => phase(name) });
  if (at === 'lobby') return to('predict');
  if (at === 'predict') return to('locked');
  if (at === 'locked') return to('run');
  if (at === 'run' || at === 'stopped') return to('explain');
  if (lesson === '') return to('predict', 'class.next.again');
  if (at === 'explain') {
    const says = lessonOf(lesson)?.change.says;
    return says ? { ...to('change', 'class.next.to'), values: { what: says[language.value] } } : to('change');
  }
  const following = lessons.value[lessons.value.findIndex(({ id }) => id === lesson) + 1];
  if (!following) return at === 'free' ? to('lobby') : to('free');
  const question = () => choose(following.id, true);
  if (following.order > 99) return { says: 'class.next.lesson', values: { title: following.title[language.value] }, act: question };
  return { says: 'class.next.question', values: { n: following.order }, act: question };
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

/** From now on this page is the teacher's. @param {string} key @param {'stage' | 'workbench'} first
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
