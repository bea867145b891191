// The page in a frame of a course's page: the views, what they show, play and scrub, and the way to all of it.
import { html, nothing } from '../../vendor/lit-html.js';
import { writeLesson, writeQuery } from '../base/link.js';
import { t } from '../base/words.js';
import { link } from '../session/opening.js';
import { shownWords } from '../session/scenario_words.js';
import { experiment, lesson, notice, params } from '../session/state.js';
import { timeBar } from './bar.js';

/** @typedef {import('../../vendor/lit-html.js').TemplateResult} Template */

document.documentElement.dataset.embed = 'yes';

/** The same without the frame. */
const whole = () =>
  location.pathname + (lesson.value === null ? writeQuery({ ...link, embed: false }) + location.hash : writeLesson(lesson.value));

/** @param {Template} content @returns {Template} */
export function page(content) {
  const now = params.value,
    { title, text, lang } = shownWords();
  return html`${content}
    <section class="embedfoot" aria-label=${t('shell.about')}>${
      lesson.value === null && now !== null
        ? html`<div id="embed-caption"><h1 lang=${lang}>${title}</h1><p lang=${lang}>${text}</p></div>`
        : html`<h1>laglab</h1>`
    }<a id="whole" href=${whole()} target="_blank" rel="noopener">${t('shell.open_whole')}</a></section>
    ${notice.value === '' ? nothing : html`<aside class="note" aria-label=${t('shell.note')}><span>${notice.value}</span></aside>`}
    ${experiment.value === null ? timeBar() : nothing}`;
}
