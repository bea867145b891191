// The page as a template: everything that changes seldom. What changes per frame is drawn by loop.js.
import { html, render } from '../../vendor/lit-html.js';
import { effect, signal } from '../../vendor/signals-core.js';
import { part } from '../base/api.js';
import { lab } from '../session/labs.js';
import { link } from '../session/opening.js';
import { experiment, lesson, notice, picked, place, presented } from '../session/state.js';
import { touch } from '../draw/redraw.js';
import { sync } from '../workbench/controls.js';
import { timeBar } from './bar.js';
import { header } from './header.js';
import { lessons } from './lessons.js';
import { shown as presentation } from './presenting.js';
import { t } from '../base/words.js';

/** @typedef {import('lit-html').TemplateResult} Template */

/** @returns {Template} */
function notes() {
  return html`<aside class="note" aria-label=${t('shell.note')} ?hidden=${notice.value === ''}><span>${notice.value}</span>
    <button type="button" class="small" @click=${() => {
      notice.value = '';
    }}>${t('shell.close')}</button></aside>`;
}

/** Of a page in a frame of another. @type {import('@preact/signals-core').Signal<((content: Template) => Template) | null>} */
const embedded = signal(null);
if (link.embed)
  part(() => import('./embed.js')).then(({ page }) => {
    embedded.value = page;
  });

/** @returns {Template} */
function page() {
  const empty = html`<main id="views" tabindex="-1"><div class="reading"><p>laglab</p></div></main>`;
  const content = lab.value?.template() ?? empty;
  if (place.value.staged) return html`${content}${notes()}`;
  if (lesson.value?.id === '') return html`${header()}${content}${notes()}`;
  if (link.embed) return embedded.value?.((lesson.value && lessons.value?.page(content)) || content) ?? empty;
  const caption = presented.value ? presentation.value?.caption() : undefined;
  if (caption) return html`${lesson.value === null ? content : (lessons.value?.page(content) ?? content)}${notes()}${caption}`;
  if (lesson.value !== null) return html`${header()}${lessons.value?.page(content) ?? content}${notes()}${timeBar()}`;
  if (experiment.value !== null) return html`<a class="skip" href="#views">${t('shell.to_experiment')}</a>${header()}${content}${notes()}`;
  return html`<a class="skip" href="#views">${t('shell.to_views')}</a>${header()}${content}${notes()}${timeBar()}`;
}

export function listen() {
  const root = /** @type {HTMLElement} */ (document.getElementById('app'));
  root.replaceChildren();
  effect(() => {
    render(page(), root);
    sync(root);
    lab.value?.rendered?.();
    if (lesson.value) lessons.value?.light(root);
    picked.value?.(root);
    touch();
  });
}
