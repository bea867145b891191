// The comparison of two runs, read when it is wanted; it then stands in the place of the views.
import { html, nothing } from '../../../../vendor/lit-html.js';
import { signal } from '../../../../vendor/signals-core.js';
import { part } from '../../../base/api.js';
import { lesson, locked } from '../../../session/state.js';

/** @type {import('@preact/signals-core').Signal<typeof import('../compare/compare.js') | null>} */
const read = signal(null);

/** The comparison, while it is shown. */
export const beside = () => (read.value?.active.value ? read.value : null);

export async function compare() {
  read.value = await part(() => import('../compare/compare.js'));
  read.value.begin();
}

/** @returns {import('lit-html').TemplateResult | typeof nothing} */
export const compareButton = () =>
  lesson.value === null
    ? html`<button type="button" class="compare" ?disabled=${locked.value !== ''} title=${locked.value || 'The same start with one setting changed'}
    @click=${compare}>Compare</button>`
    : nothing;
