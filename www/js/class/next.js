// The teacher's bar: what the class does now, and one button that says what comes next.
import { signal } from '../../vendor/signals-core.js';
import { html } from '../../vendor/lit-html.js';
import { now, part, told } from './state.js';
import { next } from './teacher.js';
import { t } from '../base/words.js';

/** @typedef {import('lit-html').TemplateResult} Template */

/** The rest of what a teacher can do is shown. */
export const more = signal(false);

/** What is under way: a second press waits for it. */
const busy = signal(false);

async function go() {
  if (busy.value) return;
  busy.value = true;
  try {
    await next().act();
  } finally {
    busy.value = false;
  }
}

/** @returns {Template} */
export function nextButtons() {
  const { says, values } = next();
  return html`<button type="button" class="next" aria-disabled=${busy.value} title=${t('class.next_tip')} @click=${go}>${t(
    says,
    values,
  )}</button>
    <button type="button" class="more" aria-haspopup="dialog" aria-label=${t('class.more')} title=${t('class.more')} @click=${() => {
      more.value = true;
    }}>…</button>`;
}

/** @returns {Template} */
export function foot() {
  const phase = now.value?.phase ?? 'lobby',
    news = told.value;
  return html`<footer class="classbar" aria-label=${t('class.controls')}><p><b>${t(`class.at.${phase}`)}</b>
    <span>${news || t(`class.phones.${phase}`)}</span></p>${nextButtons()}</footer>`;
}

/** A presenter’s remote control sends this key. */
document.addEventListener('keydown', (event) => {
  if (event.code !== 'PageDown' || part.peek() !== 'teacher' || event.repeat || document.querySelector('dialog[open]')) return;
  event.preventDefault();
  go();
});
