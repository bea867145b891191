// What the daemon says, in the page's language: a table of www/words/messages, read when it is first needed; English is as it comes, with
// the names of parameters in place of their paths.
import { computed, effect, signal } from '../../vendor/signals-core.js';
import { letter } from './format.js';
import { insist } from './insist.js';
import { file } from './place.js';
import { translator } from './sentences.js';
import { labelOfAny, language } from './words.js';

/** @type {import('@preact/signals-core').Signal<Record<string, Record<string, string>>>} by language */
const tables = signal({});

/** @param {string} name @returns {Promise<void>} */
async function read(name) {
  const table = await insist(() => file(`words/messages/${name}.json`));
  if (tables.peek()[name] === undefined) tables.value = { ...tables.peek(), [name]: table };
}

/** When what the daemon says can be said in the page's language. @returns {Promise<void>} */
export const ready = async () => {
  if (language.peek() !== 'en') await read(language.peek());
};

/** What the page calls a parameter, with its player; the path where it has no name. @param {string} path @returns {string} */
function namedAnywhere(path) {
  const label = labelOfAny(path),
    player = /^players\.(\d+)\./.exec(path)?.[1];
  return label === undefined ? path : `${player === undefined ? '' : `${letter(Number(player))}: `}${label}`;
}

const LEADING = /^([a-z_]+(?:\.\w+)*): /;
const translated = computed(() => {
  const table = tables.value[language.value];
  return table ? translator(table, namedAnywhere) : null;
});

/** In English a path at the beginning alone has its name. @param {string} text */
const named = (text) => text.replace(LEADING, (all, path) => (namedAnywhere(path) === path ? all : `${namedAnywhere(path)}: `));

/** A sentence of the daemon, with the language that it is in now.
 * @param {string} english @returns {{text: string, lang: 'en' | undefined}} lang: where it is not the page's */
export function message(english) {
  if (language.value === 'en') return { text: named(english), lang: undefined };
  if (tables.value[language.value] === undefined) void read(language.value);
  const text = translated.value?.(english);
  return typeof text === 'string' ? { text, lang: undefined } : { text: english, lang: 'en' };
}

/** @param {string} english @returns {string} */
export const said = (english) => message(english).text;

/** A page that is German has the table before the first refusal. */
export function prepare() {
  effect(() => {
    if (language.value !== 'en') void read(language.value).catch(() => {});
  });
}
