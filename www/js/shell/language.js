// The choice of the language, in the head of every view.
import { html } from '../../vendor/lit-html.js';
import { LANGUAGES, language, speakIn, t } from '../base/words.js';
import { link } from '../session/opening.js';
import { showAddress } from '../session/params.js';
import { lesson } from '../session/state.js';

/** A person's choice: kept, and put into the address where that has one. @param {string} name */
function choose(name) {
  if (link.lang !== '') link.lang = name;
  if (lesson.value !== null) lesson.value = { ...lesson.value, lang: name };
  showAddress();
  speakIn(name, true);
}

/** @returns {import('lit-html').TemplateResult} */
export function languages() {
  return html`<div class="units languages" role="group" aria-label=${t('shell.language')}>${LANGUAGES.map(
    (name) => html`<button type="button" lang=${name} aria-pressed=${name === language.value}
      aria-label=${`${name.toUpperCase()}, ${t(`shell.language.${name}`)}`} @click=${() => choose(name)}>${name.toUpperCase()}</button>`,
  )}</div>`;
}
