// What is said of the lines, of the cheapest within both, and of what it is compared with.
import { html, nothing } from '../../../vendor/lit-html.js';
import { rich, t } from '../../base/words.js';
import * as name from './names.js';
import { lines, rows } from './state.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('./state.js').Now} Now */
/** @typedef {'budget' | 'enough'} Handle */

/** @param {Now} at @param {string} method */
export const methodOf = ({ family }, method) => name.methodOf(family, method, rows.value.find((row) => row.method === method)?.by ?? '');

/** What the rival needs for the same. @param {Now} at @returns {unknown[]} */
function rivalWords(at) {
  const { best, rival, wants, ever, cost, error } = at;
  if (rival === '' || !ever) return [];
  const known = { name: methodOf(at, rival) },
    bold = (/** @type {string} */ text) => html`<b>${text}</b>`;
  if (!wants) return rich('tradeoff.never', { ...known, off: bold(name.offOf(error, ever.error)), paid: name.paidOf(cost, ever.cost) });
  if (best.cost > 0 && wants.cost <= best.cost * 1.02) return rich('tradeoff.same', known);
  const paid = bold(name.paidOf(cost, wants.cost));
  return best.cost > 0
    ? rich(name.ownKey('tradeoff.needs', at.family), { ...known, paid, times: name.timesOf(wants.cost / best.cost) })
    : rich('tradeoff.needs_some', { ...known, paid });
}

/** What the cheapest does not say of itself. @param {Now} at */
function but({ best, still }) {
  const key = `tradeoff.but.${best.method}`;
  if (still) return t('tradeoff.but_still', { still: name.brief(still.still), of: name.brief(still.of) });
  return t(key);
}

/** The cheapest within both lines, or what is nearest to that. @param {Now} at @returns {string} */
export const winnerWords = (at) =>
  t(name.ownKey(at.winner ? 'tradeoff.wins' : 'tradeoff.nearest', at.family), {
    name: methodOf(at, at.best.method),
    off: name.offOf(at.error, at.best.error),
    paid: name.paidOf(at.cost, at.best.cost),
  });

/** The sentence. @param {Now} at @returns {Template} */
export function sentence(at) {
  const more = but(at);
  return html`<section class="said" aria-label=${t('tradeoff.answer')}><p role="status" aria-live="polite" id="tradeoff-said">
    <span class="lead">${t(name.ownKey(at.winner ? 'tradeoff.inside' : 'tradeoff.nothing_inside', at.family))}</span>
    <strong>${winnerWords(at)}</strong>
    ${at.winner ? html`<span>${rivalWords(at)}</span>` : nothing}${more ? html`<span class="but">${more}</span>` : nothing}</p></section>`;
}

/** @param {Now} at @param {Handle} handle @returns {string} */
export function handleWords({ cost, error }, handle) {
  return handle === 'budget'
    ? t('tradeoff.budget', { figure: name.priceOf(cost.path, lines.value.cost) })
    : t('tradeoff.enough', { figure: name.missOf(error, lines.value.error) });
}
