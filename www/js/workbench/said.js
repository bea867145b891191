// A text of the daemon's tables or one of its notices, in the page's language where www/words/messages has it.
import { html } from '../../vendor/lit-html.js';
import { message } from '../base/messages.js';

/** @param {string} english @returns {import('lit-html').TemplateResult} */
export function said(english) {
  const { text, lang } = message(english);
  return html`<span lang=${lang ?? document.documentElement.lang}>${text}</span>`;
}
