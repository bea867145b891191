// The page's words in one language: that of the address, of an earlier choice, or of the browser; else English. www/build.mjs divides
// www/words/LANGUAGE.json into parts: what is wanted first is read at once, a part of a lab or of a class with what shows it.
import { computed, signal } from '../../vendor/signals-core.js';
import { insist } from './insist.js';
import { file } from './place.js';

/** @typedef {'en' | 'de'} Language */
/** A text with {name} for its values; with a number `n` also one text for each form of the plural.
 * @typedef {string | {[form: string]: string}} Text */
/** @typedef {{label: string, tip: string}} Name  of a parameter or a metric; the tip is one line */
/** What www/words has for a part: names by the parameter's path; of choices by that and the choice.
 * @typedef {{words: Record<string, Text>, params?: Record<string, Name>, metrics?: Record<string, Name>, choices?: Record<string, string>,
 *   units?: Record<string, string>}} Part */

/** @type {Language[]} */
export const LANGUAGES = ['en', 'de'];
/** Parts that may be wanted first have one file together. */
const FIRST = ['page', 'lesson', 'netgame'];
const KEPT = 'laglab.language';
/** For who translates: `stringTest=double` shows each text twice, and so on (www/js/base/string_test.js). */
const TRIED = new URLSearchParams(location.search).get('stringTest');
const PLACEHOLDER = /\{([^{}]*)\}/;
/** A number that is written as it stands, without a format, whose making takes as long as a view of the first frame. */
const PLAIN = /^\d{1,15}(?:\.(\d+))?$/;

/** @param {string | null | undefined} name such as de-AT @returns {Language | undefined} */
const known = (name) => LANGUAGES.find((one) => one === name?.slice(0, 2).toLowerCase());

function kept() {
  try {
    return localStorage.getItem(KEPT);
  } catch {
    return null; // a browser that keeps nothing
  }
}

/** What the page opens with. @returns {Language} */
function first() {
  const asked = [location.hash.slice(1), location.search].map((text) => new URLSearchParams(text).get('lang'));
  return [...asked, kept(), ...navigator.languages].map(known).find((one) => one !== undefined) ?? 'en';
}

let wish = first();
/** @type {Set<string>} */
const wanted = new Set();
/** What is shown. @type {import('@preact/signals-core').Signal<{language: Language, words: Record<string, Text>,
 * parts: Record<string, Part>}>} */
const now = signal({ language: wish, words: {}, parts: {} });

export const language = computed(() => now.value.language);
/** Between whole number and fraction. */
export const decimalPoint = computed(() => (language.value === 'en' ? '.' : (1.5).toLocaleString(language.value).charAt(1)));
const plural = computed(() => new Intl.PluralRules(language.value));

/** @param {Language} name @param {string} part @returns {Promise<Part>} */
async function read(name, part) {
  const found = (await insist(() => file(`words/${name}/${FIRST.includes(part) ? 'first' : part}.json`)))[part];
  return TRIED === null ? found : (await import('./string_test.js')).stretched(found, TRIED);
}

/** Shows the wanted language once all wanted parts of it are read. @returns {Promise<void>} */
async function settle() {
  const name = wish,
    parts = await Promise.all([...wanted].map(async (part) => /** @type {const} */ ([part, await read(name, part)])));
  if (name !== wish) return settle();
  document.documentElement.lang = name;
  now.value = {
    language: name,
    words: Object.assign({}, now.peek().language === name ? now.peek().words : {}, ...parts.map(([, { words }]) => words)),
    parts: { ...(now.peek().language === name ? now.peek().parts : {}), ...Object.fromEntries(parts) },
  };
}

/** Reads a part, in every language that is shown from now on. @param {string} part @returns {Promise<void>} when its words are there */
export function need(part) {
  wanted.add(part);
  return settle();
}

/** Another language, at once for all that is shown. @param {string} name @param {boolean} keep as a person's choice, in this browser */
export function speakIn(name, keep) {
  const before = wish;
  wish = known(name) ?? wish;
  if (keep) {
    try {
      localStorage.setItem(KEPT, wish);
    } catch {
      /* the choice then lasts as long as the page */
    }
  }
  return wish === before ? Promise.resolve() : settle();
}

/** By language and digits: to make one takes as long as to draw a view. @type {Map<string, Intl.NumberFormat>} */
const formats = new Map();

/** @param {number} least @param {number} most digits after the point */
function formatOf(least, most) {
  const key = `${language.value} ${least} ${most}`;
  const format =
    formats.get(key) ??
    new Intl.NumberFormat(language.value, { minimumFractionDigits: least, maximumFractionDigits: most, useGrouping: false });
  formats.set(key, format);
  return format;
}

/** A number in a sentence. @param {number} value @param {number} least @param {number} most digits after the point @returns {string} */
export function digits(value, least, most) {
  const plain = PLAIN.exec(String(value)),
    after = plain?.[1]?.length ?? 0;
  if (plain && after >= least && after <= most) return after > 0 ? plain[0].replace('.', decimalPoint.value) : plain[0];
  return formatOf(least, most).format(value).replace('-', '−');
}

/** @typedef {Record<string, unknown>} Values */

/** @param {string} key @param {Values} values @returns {string} */
function textOf(key, values) {
  const found = now.value.words[key] ?? '';
  return typeof found === 'string' ? found : (found[plural.value.select(Number(values.n))] ?? found.other ?? '');
}

/** Texts in their pieces, of which every second is the name of a value. @type {Map<string, string[]>} */
const divided = new Map();

/** @param {string} text @returns {string[]} */
function piecesOf(text) {
  const known = divided.get(text);
  if (known) return known;
  const pieces = text.split(PLACEHOLDER);
  divided.set(text, pieces);
  return pieces;
}

/** @param {unknown} value */
const written = (value) => (typeof value === 'number' ? digits(value, 0, 3) : (value ?? ''));

/** Words by their key, with values in their places; empty while they are not read. With a number `n` in the right form of the plural.
 * @param {string} key @param {Values} [values] @returns {string} */
export function t(key, values = {}) {
  const pieces = piecesOf(textOf(key, values));
  let text = pieces[0] ?? '';
  for (let i = 1; i < pieces.length; i += 2) text += `${written(values[pieces[i] ?? ''])}${pieces[i + 1] ?? ''}`;
  return text;
}

/** The same with templates among the values: a list to render. @param {string} key @param {Values} values @returns {unknown[]} */
export function rich(key, values) {
  return piecesOf(textOf(key, values)).map((piece, i) => (i % 2 === 0 ? piece : written(values[piece])));
}

/** A place of the paper: its figures in the page's language, its sections by their titles. @param {string} paper
 * @returns {{text: string, lang: string}} */
export function paperName(paper) {
  const n = /^Figure (\d+)$/.exec(paper)?.[1];
  return n === undefined ? { text: paper, lang: 'en' } : { text: t('base.figure', { n }), lang: language.value };
}

/** Whether there are words for a key. @param {string} key */
export const has = (key) => now.value.words[key] !== undefined;

/** What a table of the parts of a kind has: of netgames there are several. @template {'params' | 'metrics' | 'choices'} T
 * @param {string} kind @param {T} table @param {string} path @returns {NonNullable<Part[T]>[string] | undefined} */
export function nameOf(kind, table, path) {
  for (const [name, part] of Object.entries(now.value.parts))
    if ((name === kind || name.startsWith(`${kind}_`)) && part[table]?.[path]) return /** @type {any} */ (part[table][path]);
  return undefined;
}

/** @param {string} path such as players.0.link.up.delay_ms @returns {string} players.*.link.*.delay_ms */
const keyOf = (path) =>
  path
    .replace(/^side_by_side\.\d+\./, '')
    .replace(/\.\d+(?=\.|$)/g, '.*')
    .replace(/\.link\.(?:up|down)\./, '.link.*.');

/** The name of a scenario's value. @param {string} kind of the scenario @param {string} path such as methods.0.dt_s */
export const inputOf = (kind, path) => nameOf(kind, 'params', keyOf(path));

/** The name of a scenario's value of any kind. @param {string} path such as players.1.lag_ms @returns {string | undefined} */
export function labelOfAny(path) {
  const key = keyOf(path);
  return Object.values(now.value.parts).find(({ params }) => params?.[key])?.params?.[key]?.label;
}

/** The name of what a kind has by a key: a method, a scene, a field. @param {string} kind @param {string} key @returns {string} */
export const called = (kind, key) => nameOf(kind, 'choices', key) ?? key.replaceAll('_', ' ');

/** The name of a choice of a scenario's value. @param {string} kind @param {string} path @param {string} choice @returns {string} */
export const choiceOf = (kind, path, choice) => nameOf(kind, 'choices', `${keyOf(path)}.${choice}`) ?? called(kind, choice);

/** The name of a unit of the tables. @param {string} unit @returns {string} */
export function unitName(unit) {
  for (const { units } of Object.values(now.value.parts)) if (units?.[unit]) return units[unit];
  return unit;
}

/** When the words of the page itself are there. */
export const ready = need('page');
