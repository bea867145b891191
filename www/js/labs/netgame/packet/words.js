// Words of the packet view in the page's language.
import { computed, effect, signal } from '../../../../vendor/signals-core.js';
import { insist } from '../../../base/insist.js';
import { file } from '../../../base/place.js';
import { digits, language } from '../../../base/words.js';

export { language };

/** @type {import('@preact/signals-core').Signal<Record<string, Record<string, string>>>} */
const read = signal({});
const asked = new Set();
effect(() => {
  const name = language.value;
  if (asked.has(name)) return;
  asked.add(name);
  insist(() => file(`words/packet/${name}.json`)).then((words) => {
    read.value = { ...read.peek(), [name]: words };
  });
});

/** Whether the words of the language are there. */
export const ready = computed(() => read.value[language.value] !== undefined);

/** @param {number} value @param {number} places @returns {string} */
export const number = (value, places) => digits(value, places, places);

/** A word by its key, with what stands for {names}. @param {string} key @param {Record<string, string | number>} [given]
 * @returns {string} */
export const word = (key, given = {}) =>
  (read.value[language.value]?.[key] ?? '').replace(/\{([^{}]*)\}/g, (_, name) => String(given[name] ?? ''));
