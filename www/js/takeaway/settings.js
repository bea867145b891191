// The settings that differ from the scenario's, in words: for captions and headers of files.
import { call } from '../base/api.js';
import { letter } from '../base/format.js';
import { file } from '../base/place.js';
import { find, labelOf, valueAt } from '../base/schema.js';
import { link } from '../session/opening.js';
import { shownScenario } from '../session/session.js';
import { layout, params, schema } from '../session/state.js';

/** Of www/words. @typedef {{units: Record<string, string>, params: Record<string, {label: string}>, choices: Record<string, string>,
 *   labs: Record<string, Record<string, {label: string}>>, takeaway: Record<string, string>}} Words */

/** Of a scenario, but no setting of it. */
const NOT_SHOWN = new Set(['kind', 'title', 'paper', 'text', 'seed', 'timeline', 'expect', 'game']);

/** @param {string} language @returns {Promise<Words>} */
export const wordsOf = (language) => file(`words/${language}.json`);

/** Paths of all values below an object, with those of lists of objects. @param {any} at @param {string} path
 * @returns {[string, unknown][]} */
function leaves(at, path = '') {
  return Object.entries(at).flatMap(([name, value]) => {
    const here = path === '' ? name : `${path}.${name}`;
    if (path === '' && NOT_SHOWN.has(name)) return [];
    const nested = value !== null && typeof value === 'object' && (!Array.isArray(value) || typeof value[0] === 'object');
    return nested ? leaves(value, here) : [[here, value]];
  });
}

/** As the scenario has it: its own value, else (of one side by side) that of the first, else that of the table.
 * @param {any} scenario @param {string} path */
const originOf = (scenario, path) =>
  valueAt(scenario, path) ?? valueAt(scenario, path.replace(/^side_by_side\.\d+\./, '')) ?? find(schema.value, path)?.byDefault;

/** Whether a value is another than the scenario's. A preset of a link decides its parameters. @param {any} scenario @param {string} path
 * @param {unknown} value */
function differs(scenario, path, value) {
  const origin = originOf(scenario, path);
  if (path in link.set) return JSON.stringify(origin) !== JSON.stringify(value);
  if (origin === undefined) return false;
  const preset = /^(players\.\d+\.link)\.(?:up|down)\./.exec(path)?.[1];
  if (preset && valueAt(params.value, `${preset}.preset`) !== undefined && valueAt(scenario, path) === undefined) return false;
  return JSON.stringify(origin) !== JSON.stringify(value);
}

/** Whose setting it is. @param {string} path @param {Words} words @returns {string} */
function ownerOf(path, words) {
  const [first = '', index = ''] = path.split('.'),
    place = Number(index);
  if (first === 'players') return `${words.takeaway.player} ${layout.value?.given.players?.[place]?.name || letter(place)}`;
  if (first === 'server') return words.takeaway.server ?? '';
  if (first === 'methods') return `${place + 1}`;
  if (first === 'side_by_side') return `${place + 2}`;
  return '';
}

/** @param {string} path @param {Words} words */
function nameOf(path, words) {
  const key = path.replace(/\.\d+(?=\.|$)/g, '.*').replace(/\.link\.(?:up|down)\./, '.link.*.'),
    kind = String(params.value?.kind ?? '');
  const label = words.params[key]?.label ?? words.labs[kind]?.[key]?.label ?? labelOf(kind, path);
  const way = /\.link\.(up|down)\./.exec(path)?.[1] ?? '';
  const owner = ownerOf(path, words);
  return `${owner}${owner && ': '}${label}${way && ` (${words.takeaway[way]})`}`;
}

/** @param {string} path @param {unknown} value @param {Words} words @param {string} language */
function textOf(path, value, words, language) {
  if (typeof value === 'boolean') return words.takeaway[value ? 'on' : 'off'] ?? '';
  if (typeof value === 'number') {
    const unit = find(schema.value, path)?.unit ?? '',
      digits = value.toLocaleString(language, { maximumSignificantDigits: 7, useGrouping: false });
    return unit === '' ? digits : `${digits} ${words.units[unit] ?? unit}`;
  }
  const key = path.replace(/\.\d+(?=\.|$)/g, '.*').replace(/\.link\.(?:up|down)\./, '.link.*.');
  return typeof value === 'string' ? (words.choices[`${key}.${value}`] ?? value.replaceAll('_', ' ')) : JSON.stringify(value);
}

/** The session's settings that are not the scenario's, each as `Player A: One-way lag 99 ms`. Where the scenario is none of the library:
 * those that are not the tables'. @param {Words} words @param {string} language @returns {Promise<string[]>} */
export async function changedSettings(words, language) {
  const now = params.value,
    id = shownScenario();
  if (now === null) return [];
  const scenario = id === '' ? {} : await call('GET', `scenarios/${id}`);
  return leaves(now)
    .filter(([path, value]) => differs(scenario, path, value))
    .map(([path, value]) => `${nameOf(path, words)} ${textOf(path, value, words, language)}`);
}
