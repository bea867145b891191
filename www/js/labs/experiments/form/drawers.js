// What stays behind buttons until it is wanted: settings, table, files, request. Each is open as long as the view is used.
import { html } from '../../../../vendor/lit-html.js';
import { signal } from '../../../../vendor/signals-core.js';
import { t } from '../../../base/words.js';

/** @typedef {'settings' | 'table' | 'files' | 'request'} Drawer */

/** @type {import('@preact/signals-core').Signal<Drawer[]>} */
const opened = signal([]);
/** @param {Drawer} name */
export const isOpen = (name) => opened.value.includes(name);

/** @param {Drawer} name @param {boolean} [open] */
function turn(name, open = !isOpen(name)) {
  opened.value = [...opened.value.filter((one) => one !== name), ...(open ? [name] : [])];
}

const ABOVE_PX = 60;
/** Opens one, and shows a part of it when it is there. @param {Drawer} name @param {string} [at] selector of what has the keyboard then */
export function openDrawer(name, at) {
  turn(name, true);
  setTimeout(() => {
    const part = document.querySelector(at ?? `#drawer-${name}`);
    const view = part?.closest('main'); /* it alone scrolls: a page that does shows what is below it */
    if (part && view && view.scrollHeight > view.clientHeight)
      view.scrollTop += part.getBoundingClientRect().top - view.getBoundingClientRect().top - ABOVE_PX;
    else part?.scrollIntoView({ block: 'start' });
    if (at && part instanceof HTMLElement) part.focus({ preventScroll: true });
  }, 60); /* after the next drawing of the page */
}

/** @param {Drawer} name @param {string} label @returns {import('lit-html').TemplateResult} */
export const drawerButton = (name, label) => html`<button type="button" data-drawer=${name} aria-expanded=${String(isOpen(name))}
  aria-controls=${`drawer-${name}`} @click=${() => (isOpen(name) ? turn(name) : openDrawer(name))}>${label}</button>`;

/** @param {Drawer} name @param {string} label @param {() => unknown} content @returns {unknown} */
export const drawer = (name, label, content) =>
  isOpen(name)
    ? html`<section class="drawer" id=${`drawer-${name}`} aria-label=${label}><div class="head"><h2>${label}</h2><button type="button"
        class="small" @click=${() => turn(name)}>${t('experiments.close')}</button></div>${content()}</section>`
    : html`<span id=${`drawer-${name}`}></span>`;
