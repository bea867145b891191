// Texts of the lessons in the language that is shown.
import { computed, effect } from '../../vendor/signals-core.js';
import { digits, has, language, need, speakIn } from '../base/words.js';
import { lesson } from '../session/state.js';

export { file } from '../base/place.js';
export { language, t as word } from '../base/words.js';

/** @typedef {{en: string, de: string}} Text */
/** @typedef {Text & {one?: Text}} Unit  one: of a value of 1 */
const PLACEHOLDER = /\{([^{}]*)\}/g;

need('lesson');
effect(() => {
  const asked = lesson.value?.lang ?? '';
  if (asked !== '') speakIn(asked, false); /* the address names it */
});

/** Whether the words of the lessons are there. */
export const ready = computed(() => has('door.title'));

/** A value with its unit. @param {number} value @param {Unit} unit @returns {string} */
export function amount(value, unit) {
  const name = (value === 1 ? unit.one : undefined)?.[language.value] ?? unit[language.value];
  return `${digits(value, 0, 3)}${name === '°' ? '' : ' '}${name}`;
}

/** A text of a lesson, with its numbers. @param {Text} text @param {Record<string, {value: number, digits: number}>} numbers
 * @returns {string} */
export const filled = (text, numbers) =>
  text[language.value].replace(PLACEHOLDER, (all, name) => {
    const number = numbers[name];
    return number ? digits(number.value, number.digits, number.digits) : all;
  });
