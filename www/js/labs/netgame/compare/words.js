// Words of the comparison in the browser's language: www/words has them, with the names of settings and curves.
import { computed, effect, signal } from '../../../../vendor/signals-core.js';
import { letter } from '../../../base/format.js';
import { insist } from '../../../base/insist.js';
import { file } from '../../../base/place.js';
import { language as spoken } from '../../../base/words.js';

/** @typedef {{label: string, tip: string}} Entry */
/** @typedef {{params: Record<string, Entry>, metrics: Record<string, Entry>, choices: Record<string, string>, units: Record<string,
 * string>, compare: Record<string, string>}} Words */

/** @type {import('@preact/signals-core').Signal<Words | null>} null until they are read */
export const words = signal(null);

/** @param {string} language @returns {Promise<void>} */
async function read(language) {
  const all = await insist(() => file(`words/${language}.json`));
  if (language === spoken.peek()) words.value = all;
}

const reading = computed(() => read(spoken.value));
effect(() => void reading.value); // again in each language that is shown
/** @returns {Promise<void>} when the words are there */
export const ready = () => reading.value;

/** @param {string} key @param {Record<string, string>} [values] @returns {string} */
export const say = (key, values = {}) => (words.value?.compare[key] ?? '').replace(/\{(\w+)\}/g, (all, name) => values[name] ?? all);

/** @param {number} value @param {number} digits after the point @param {string} [unit] @returns {string} */
export function amount(value, digits, unit = '') {
  if (!Number.isFinite(value)) return '–';
  const size = Math.abs(value).toLocaleString(spoken.value, {
    minimumFractionDigits: digits,
    maximumFractionDigits: digits,
    useGrouping: false,
  });
  const name = unit === '' ? '' : ` ${words.value?.units[unit] ?? unit}`;
  return `${value < 0 && /[1-9]/.test(size) ? '−' : ''}${size}${name}`;
}

/** The key of a setting among the words. @param {string} path */
const keyOf = (path) => path.replace(/^players\.\d+\./, 'players.*.').replace(/\.link\.(?:up|down)\./, '.link.*.');

/** A setting's name. @param {string} path @param {boolean} whole with its player @returns {string} */
export function settingOf(path, whole) {
  const player = /^players\.(\d+)\./.exec(path)?.[1],
    way = /\.link\.(up|down)\./.exec(path)?.[1];
  const label = words.value?.params[keyOf(path)]?.label ?? path;
  return `${whole && player !== undefined ? `${letter(Number(player))}: ` : ''}${label}${way ? `, ${say(way)}` : ''}`;
}

/** @param {string} path */
export const tipOf = (path) => words.value?.params[keyOf(path)]?.tip ?? '';

/** A choice's name. @param {string} path @param {string} choice @returns {string} */
export const choiceOf = (path, choice) => words.value?.choices[`${keyOf(path)}.${choice}`] ?? choice;

/** A setting's value. @param {string} path @param {any} value @param {string} unit @returns {string} */
export function valueOf(path, value, unit) {
  if (typeof value === 'boolean') return say(value ? 'on' : 'off');
  if (typeof value !== 'number') return choiceOf(path, String(value));
  const text = value.toLocaleString(spoken.value, { maximumSignificantDigits: 6, useGrouping: false }).replace('-', '−');
  return unit === '' ? text : `${text} ${words.value?.units[unit] ?? unit}`;
}

/** @param {import('./curves.js').Curve} curve @param {boolean} whole with its player @returns {string} */
export function nameOf(curve, whole) {
  const name = words.value?.metrics[curve.words]?.label ?? say(curve.words);
  return whole ? `${letter(curve.player)}: ${name}` : name;
}

/** What a curve shows. @param {import('./curves.js').Curve} curve @returns {string} */
export const tipOfCurve = (curve) => words.value?.metrics[curve.words]?.tip ?? say(`${curve.words}.tip`);
