// Texts of the lessons in the language that is shown.
import { computed, effect, signal } from '../../vendor/signals-core.js';
import { insist } from '../base/api.js';
import { lesson } from '../session/state.js';

/** @typedef {{en: string, de: string}} Text */
/** @typedef {'en' | 'de'} Language */

/** @type {Language[]} */
export const LANGUAGES = ['en', 'de'];
const PLACEHOLDER = /\{([^{}]*)\}/g;

/** A file of the page, as JSON. @param {string} path @returns {Promise<any>} */
export async function file(path) {
  const answer = await fetch(new URL(`../../${path}`, import.meta.url));
  if (!answer.ok) throw new Error(`${path}: ${answer.status}`);
  return answer.json();
}

/** That of the address, else the browser's. @type {import('@preact/signals-core').ReadonlySignal<Language>} */
export const language = computed(() => {
  const asked = lesson.value?.lang || navigator.language.slice(0, 2);
  return LANGUAGES.find((one) => one === asked) ?? 'en';
});

/** What www/words has for lessons, of the languages that were shown. @type {import('@preact/signals-core').Signal<Partial<Record<Language, Record<string, string>>>>} */
const read = signal({});
const asked = new Set();
effect(() => {
  const name = language.value;
  if (lesson.value === null || asked.has(name)) return;
  asked.add(name);
  insist(() => file(`lessons/words/${name}.json`)).then((words) => {
    read.value = { ...read.peek(), [name]: words };
  });
});

/** Whether the words of the language are there. */
export const ready = computed(() => read.value[language.value] !== undefined);

/** @param {number} value @param {number} least @param {number} most digits after the point @returns {string} */
function digits(value, least, most) {
  const text = value.toLocaleString(language.value, { minimumFractionDigits: least, maximumFractionDigits: most, useGrouping: false });
  return text.replace('-', '−');
}

/** A value with its unit. @param {number} value @param {Text} unit @returns {string} */
export function amount(value, unit) {
  const name = unit[language.value];
  return `${digits(value, 0, 3)}${name === '°' ? '' : ' '}${name}`;
}

/** Words of the page by their key. @param {string} key @param {Record<string, number>} [numbers] @returns {string} */
export function word(key, numbers = {}) {
  const text = read.value[language.value]?.[key] ?? '';
  return text.replace(PLACEHOLDER, (_, name) => digits(numbers[name] ?? Number.NaN, 0, 0));
}

/** A text of a lesson, with its numbers. @param {Text} text @param {Record<string, {value: number, digits: number}>} numbers @returns {string} */
export const filled = (text, numbers) =>
  text[language.value].replace(PLACEHOLDER, (all, name) => {
    const number = numbers[name];
    return number ? digits(number.value, number.digits, number.digits) : all;
  });
