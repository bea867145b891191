// The lesson that a class is asked: its texts in the language of the page, and what a step of it is about in the drawings.
import { signal } from '../../vendor/signals-core.js';
import { lookOf, shownAt } from '../lessons/steps.js';
import { amount, filled, language } from '../lessons/words.js';
import { file } from '../base/place.js';
import { touch } from '../draw/redraw.js';
import { shows } from '../draw/shown.js';
import { camera, look } from '../session/state.js';
import { t } from '../base/words.js';

/** @typedef {import('../lessons/steps.js').Lesson} Lesson */

/** Rows of the list, in its order. @type {import('@preact/signals-core').Signal<{id: string, title: import('../lessons/words.js').Text,
 * order: number, topic: string}[]>} */
export const lessons = signal([]);
/** @type {import('@preact/signals-core').Signal<Map<string, Lesson>>} */
const read = signal(new Map());

/** The list of lessons, for the teacher to choose from. */
export async function readLessons() {
  const list = await file('lessons/index.json').catch(() => []);
  lessons.value = list.sort((/** @type {any} */ a, /** @type {any} */ b) => a.order - b.order);
}

/** @param {string} id @returns {Promise<Lesson | null>} null where there is none of that name */
export async function readLesson(id) {
  const found = await file(`lessons/${id}.json`).catch(() => null);
  if (found === null) return null;
  const lesson = read.peek().get(id) ?? { ...found, id };
  if (!read.peek().has(id)) read.value = new Map(read.peek()).set(id, lesson);
  return lesson;
}

/** A lesson as far as it is read; asks for it. @param {string} id @returns {Lesson | null} */
export function lessonOf(id) {
  if (!/^[a-z0-9_]{1,64}$/.test(id)) return null;
  const found = read.value.get(id) ?? null;
  if (found === null) readLesson(id);
  return found;
}

/** With the number of a question. @param {Pick<Lesson, 'title' | 'order'>} lesson @returns {string} */
export const titleOf = ({ title, order }) => `${order < 100 ? `${order} · ` : ''}${title[language.value]}`;

/** @param {Lesson | null} lesson @returns {string} */
export const questionOf = (lesson) => (lesson === null ? t('class.expect') : sayOf(lesson, 'predict'));

/** @param {Lesson} lesson @param {'predict' | 'observe' | 'explain' | 'change'} step @returns {string} */
export const sayOf = (lesson, step) => filled(lesson.steps[step], lesson.numbers);

/** @param {Lesson | null} lesson @param {number} choice from 0 @returns {string} */
export function choiceOf(lesson, choice) {
  const found = lesson?.choices[choice];
  if (!lesson || !found) return t('class.choice', { n: choice + 1 });
  return found.label?.[language.value] ?? amount(found.value, lesson.answer.unit);
}

/** The same within a sentence. @param {Lesson | null} lesson @param {number} choice @returns {string} */
export const saidOf = (lesson, choice) => choiceOf(lesson, choice).replace(/\.$/, '');

/** Why one chooses it. @param {Lesson} lesson @param {number} choice @returns {string} */
export const whyOf = (lesson, choice) => (lesson.choices[choice] ? filled(lesson.choices[choice].why, lesson.numbers) : '');

/** @param {import('../lessons/steps.js').Answer} answer */
export const amountOf = ({ value, unit }) => amount(value, unit);

/** The steps of a lesson by the phases of a class. @type {Record<string, number>} */
export const STEPS = { predict: 1, locked: 1, run: 2, stopped: 3, explain: 4, change: 5 };

/** The drawings show what this phase of the lesson is about. @param {Lesson | null} lesson @param {string} phase */
export function point(lesson, phase) {
  const step = STEPS[phase] ?? 0;
  shows.value = lesson === null ? null : shownAt(lesson, step);
  camera.value = lesson !== null && step > 0 ? (lesson.camera ?? null) : null;
  look.value = lesson !== null && step > 1 ? lookOf(lesson, step) : null;
  touch();
}
