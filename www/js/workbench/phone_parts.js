// On a phone: the part of a lab that its one column shows. On larger screens all of them are seen.
import { html } from '../../vendor/lit-html.js';
import { signal } from '../../vendor/signals-core.js';
import { t } from '../base/words.js';

/** @typedef {'views' | 'settings' | 'numbers'} Part */

/** @type {import('@preact/signals-core').Signal<Part>} */
export const shownPart = signal('views');

/** @param {Part} part @returns {import('lit-html').TemplateResult} */
const tab = (part) =>
  html`<button type="button" aria-pressed=${shownPart.value === part} @click=${() => {
    shownPart.value = part;
  }}>${t(`workbench.${part}`)}</button>`;

/** @returns {import('lit-html').TemplateResult} */
export const partTabs = () =>
  html`<nav class="tabs" aria-label=${t('workbench.part')}>${tab('views')}${tab('settings')}${tab('numbers')}</nav>`;
