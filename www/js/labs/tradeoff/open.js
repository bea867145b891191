// A setting as a live session in its lab.
import { html } from '../../../vendor/lit-html.js';
import { lookOf, readLink } from '../../base/link.js';
import { link } from '../../session/opening.js';
import { choose } from '../../session/session.js';
import { theme } from '../../session/state.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('./results.js').Row} Row */

/** Its address. @param {Row} row */
const hrefOf = (row) => [row.link, ...lookOf({ ...link, theme: theme.value })].join('&');

/** @param {Row} row */
function live(row) {
  history.pushState(null, '', location.href);
  choose(new URLSearchParams(row.link).get('scenario') ?? '', readLink(row.link, '').set, false);
}

/** A link to it, which other tabs can open too. @param {Row} row @param {unknown} content @param {string} [kind] @returns {Template} */
export const liveLink = (row, content, kind = '') =>
  html`<a class=${kind} href=${hrefOf(row)} @click=${(/** @type {MouseEvent} */ event) => {
    if (event.ctrlKey || event.metaKey || event.shiftKey) return;
    event.preventDefault();
    live(row);
  }}>${content}</a>`;
