// Titles and texts of the library's scenarios in the page's language. The daemon has them in English; words/scenarios has the others.
import { effect, signal } from '../../vendor/signals-core.js';
import { language } from '../base/words.js';
import { params, scenarios } from './state.js';

/** By the scenario's id. @type {import('@preact/signals-core').Signal<Record<string, {title: string, text?: string}>>} */
const translated = signal({});

effect(() => {
  const name = language.value;
  translated.value = {};
  if (name !== 'en')
    fetch(new URL(`../../words/scenarios/${name}.json`, import.meta.url))
      .then((answer) => (answer.ok ? answer.json() : {}))
      .then(
        (all) => {
          if (name === language.peek()) translated.value = all;
        },
        () => {}, // they stay in English
      );
});

/** @param {{id: string, title: string}} row @returns {string} */
export const titleOf = ({ id, title }) => translated.value[id]?.title ?? title;

/** With the figure of the paper that it shows. @param {{id: string, title: string, paper: string}} row @returns {string} */
export const fullTitleOf = (row) => (row.paper ? `${row.paper}: ${titleOf(row)}` : titleOf(row));

/** Of the scenario shown; `paper` is English, as the paper is. It has the library's words as long as it has its title. */
export function shownWords() {
  const { title = '', text = '', paper = '' } = params.value ?? {};
  const id = scenarios.value.find((row) => row.title === title)?.id ?? '',
    own = translated.value[id];
  return { paper, title: own?.title ?? title, text: own?.text ?? text, lang: own ? language.value : 'en' };
}
