// One line in the head of a lab: what can be done here, by key and by touch. It goes when that has been done.
import { html, nothing } from '../../vendor/lit-html.js';
import { signal } from '../../vendor/signals-core.js';
import { t } from '../base/words.js';
import { lab } from '../session/labs.js';
import { layout, readOnly } from '../session/state.js';

/** Games, or kinds, of which it has been read. @type {import('@preact/signals-core').Signal<Set<string>>} */
const done = signal(new Set());

/** What it says has been done, or need not be said. */
export function used() {
  const game = layout.peek()?.game ?? '';
  if (game !== '' && !done.peek().has(game)) done.value = new Set(done.peek()).add(game);
}

/** @returns {import('lit-html').TemplateResult | typeof nothing} */
export function hint() {
  const key = lab.value?.hint?.() ?? '';
  if (key === '' || readOnly.value || done.value.has(layout.value?.game ?? '')) return nothing;
  return html`<p class="howto" id="hint"><span class="by-key">${t(`hint.${key}`)}</span>
    <span class="by-touch">${t(`hint.${key}.touch`)}</span></p>`;
}

/** A view has been touched: what is to be done there is known. @param {Event} event */
function touched({ target }) {
  if (target instanceof HTMLCanvasElement && target.closest('.view')) used();
}
document.addEventListener('click', touched);
document.addEventListener('dragend', touched);
