// The page as a template: everything that changes seldom. What changes per frame is drawn by loop.js.
import { html, render } from '../../vendor/lit-html.js';
import { effect } from '../../vendor/signals-core.js';
import { lab } from '../session/labs.js';
import { experiment, lesson, notice, presented } from '../session/state.js';
import { touch } from '../draw/redraw.js';
import { sync } from '../workbench/controls.js';
import { timeBar } from './bar.js';
import { header } from './header.js';
import { lessons } from './lessons.js';
import { shown as presentation } from './presenting.js';

/** @typedef {import('lit-html').TemplateResult} Template */

/** @returns {Template} */
function notes() {
  return html`<aside class="note" aria-label="Note" ?hidden=${notice.value === ''}><span>${notice.value}</span>
    <button type="button" class="small" @click=${() => {
      notice.value = '';
    }}>Close</button></aside>`;
}

/** @returns {Template} */
function page() {
  const empty = html`<main id="views" tabindex="-1"></main>`;
  if (lesson.value?.id === '') return html`${header()}${lessons.value?.door() ?? empty}${notes()}`;
  const content = lab.value?.template() ?? empty;
  const caption = presented.value ? presentation.value?.caption() : undefined;
  if (caption) return html`${lesson.value === null ? content : (lessons.value?.page(content) ?? content)}${notes()}${caption}`;
  if (lesson.value !== null) return html`${header()}${lessons.value?.page(content) ?? content}${notes()}${timeBar()}`;
  if (experiment.value !== null) return html`<a class="skip" href="#views">To the experiment</a>${header()}${content}${notes()}`;
  return html`<a class="skip" href="#views">To the views</a>${header()}${content}${notes()}${timeBar()}`;
}

export function listen() {
  const root = /** @type {HTMLElement} */ (document.getElementById('app'));
  root.replaceChildren();
  effect(() => {
    render(page(), root);
    sync(root);
    if (lesson.value?.id !== '') lab.value?.rendered?.();
    touch();
  });
}
