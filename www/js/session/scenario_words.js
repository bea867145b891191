// Titles and texts of the library's scenarios in the page's language. The daemon has them in English; words/scenarios has the others.
import { effect, signal } from '../../vendor/signals-core.js';
import { constant, insist } from '../base/api.js';
import { file } from '../base/place.js';
import { language } from '../base/words.js';
import { params, scenarios } from './state.js';

/** By the scenario's id. @type {import('@preact/signals-core').Signal<Record<string, {title: string, text?: string}>>} */
const translated = signal({});

/** @param {string} name @returns {Promise<void>} */
async function read(name) {
  translated.value = {};
  if (name === 'en') return;
  try {
    const all = await file(`words/scenarios/${name}.json`);
    if (name === language.peek()) translated.value = all;
  } catch {
    /* they stay in English */
  }
}

let reading = false;
/** Reads the list of scenarios, and their words in every language that is shown from now on: nothing of them is shown before the list. */
export async function readScenarios() {
  if (reading) return;
  reading = true;
  let now = Promise.resolve();
  effect(() => {
    now = read(language.value);
  });
  const [answer] = await Promise.all([insist(() => constant('scenarios?brief=true')), now]);
  scenarios.value = answer.scenarios ?? [];
}

/** @param {{id: string, title: string}} row @returns {string} */
export const titleOf = ({ id, title }) => translated.value[id]?.title ?? title;

/** What it is about; empty where nothing is said. @param {{id: string, text?: string}} row @returns {string} */
export const textOf = ({ id, text = '' }) => translated.value[id]?.text ?? text;

/** With the figure of the paper that it shows. @param {{id: string, title: string, paper: string}} row @returns {string} */
export const fullTitleOf = (row) => (row.paper ? `${row.paper}: ${titleOf(row)}` : titleOf(row));

/** Of the scenario shown; `paper` is English, as the paper is. It has the library's words as long as it has its title. */
export function shownWords() {
  const { title = '', text = '', paper = '' } = params.value ?? {};
  const id = scenarios.value.find((row) => row.title === title)?.id ?? '',
    own = translated.value[id];
  return { paper, title: own?.title ?? title, text: own?.text ?? text, lang: own ? language.value : 'en' };
}
