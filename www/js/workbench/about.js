// What a scenario is: its title and its text.
import { html, nothing } from '../../vendor/lit-html.js';
import { paperName } from '../base/words.js';
import { shownWords } from '../session/scenario_words.js';

export function aboutScenario() {
  const { paper, title, text, lang } = shownWords();
  const place = paperName(paper);
  const before = paper === '' ? nothing : html`<span lang=${place.lang}>${place.text}</span>: `,
    below = text === '' ? nothing : html`<p lang=${lang}>${text}</p>`;
  return html`<h2 lang=${lang}>${before}${title}</h2>${below}`;
}
