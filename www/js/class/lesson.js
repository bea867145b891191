// Questions of the library of lessons: their text and choices, in the language of the page.
import { signal } from '../../vendor/signals-core.js';
import { fixed } from '../base/format.js';
import { file } from '../base/place.js';
import { digits, language, t } from '../base/words.js';

/** @typedef {{en: string, de: string}} Text */
/** As api/lesson.schema.json has it. @typedef {{title: Text, scenario: string, set: Record<string, unknown>, seed: number,
 * workload?: unknown, start_tick?: number, stop_tick: number, speed: number, steps: {predict: Text},
 *   choices: {value: number, label?: Text, right?: true}[], answer: {unit: Text},
 *   numbers: Record<string, {value: number, digits: number}>}} Lesson */

/** @type {import('@preact/signals-core').Signal<{id: string, title: Text, order: number}[]>} */
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
  if (found && !read.peek().has(id)) read.value = new Map(read.peek()).set(id, found);
  return found;
}

/** A lesson as far as it is read; asks for it. @param {string} id @returns {Lesson | null} */
export function lessonOf(id) {
  if (!/^[a-z0-9_]{1,64}$/.test(id)) return null;
  const found = read.value.get(id) ?? null;
  if (found === null) readLesson(id);
  return found;
}

/** What is asked. @param {Lesson | null} lesson @returns {string} */
export function questionOf(lesson) {
  if (lesson === null) return t('class.expect');
  return lesson.steps.predict[language.value].replace(/\{(\w+)\}/g, (whole, name) => {
    const number = lesson.numbers[name];
    return number ? fixed(number.value, number.digits) : whole;
  });
}

/** @param {Lesson | null} lesson @param {number} choice from 0 @returns {string} */
export function choiceOf(lesson, choice) {
  const found = lesson?.choices[choice];
  if (!lesson || !found) return t('class.choice', { n: choice + 1 });
  return found.label?.[language.value] ?? `${digits(found.value, 0, 20)} ${lesson.answer.unit[language.value]}`;
}
