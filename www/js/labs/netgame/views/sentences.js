// What a player meets, as one sentence and one number each, next to the field's term.
import { fixed, letter } from '../../../base/format.js';
import { t } from '../../../base/words.js';
import { place } from '../../../session/state.js';
import { PERSON, PREDICTION, RECONCILIATION } from '../core/frame.js';

/** @typedef {import('../core/frame.js').View} View */
/** @typedef {import('../core/memory.js').Memory} Memory */
/** value: empty while nothing was counted; `before` is the whole sentence then.
 * @typedef {{term: string, before: string, value: string, after: string}} Sentence */

/** Who a sentence is about. views: of all players; player: from 0 @typedef {{view: View, player: number, views: View[]}} Who */

/** Whether the person at this page is this player: a player's own device has its seat; the board of a class is of no player; any other page
 * belongs to the only person. @param {Who} who */
export function isYou({ view, player, views }) {
  const { seat, board } = place.value;
  if (seat !== null) return seat === player;
  return !board && (view.flags & PERSON) !== 0 && views.filter(({ flags }) => (flags & PERSON) !== 0).length === 1;
}

/** Of the person at this page, or of a player's letter. @param {Who} who @param {string} key
 * @param {import('../../../base/words.js').Values} [values] */
const of = (who, key, values) => t(`netgame.says.${key}.${isYou(who) ? 'you' : 'one'}`, { name: letter(who.player), ...values });

/** @param {Who} who @param {Memory} memory @returns {Sentence} */
function latency(who, memory) {
  const { view, player } = who;
  const { latency: ms } = memory.lately(player);
  const predicts = (view.flags & PREDICTION) !== 0;
  if (ms === null) return { term: t('netgame.says.latency'), before: of(who, 'latency.none'), value: '', after: '' };
  return {
    term: t('netgame.says.latency'),
    before: of(who, 'latency'),
    value: `${fixed(ms, 0)} ms`,
    after: `${t('netgame.says.latency.after')} ${t(predicts ? 'netgame.says.latency.predicts' : 'netgame.says.latency.trip', {
      ms: fixed(2 * view.lag_ms, 0),
    })}`.trimStart(),
  };
}

/** @param {Who} who @returns {Sentence} */
function age(who) {
  const { view, player, views } = who,
    players = views.length;
  return {
    term: t('netgame.says.age'),
    before: players === 2 ? of(who, 'age', { other: letter(1 - player) }) : of(who, 'ages'),
    value: `${fixed(view.view_age_ms, 0)} ms`,
    after: t(players === 2 ? 'netgame.says.age.after' : 'netgame.says.ages.after'),
  };
}

/** @param {Who} who @param {Memory} memory @returns {Sentence} */
function corrections(who, memory) {
  const { view, player } = who;
  const most = view.corrections === 0 ? '' : t('netgame.says.corrections.most', { size: fixed(memory.largest[player] ?? 0, 2) }),
    without = view.corrections > 0 && (view.flags & RECONCILIATION) === 0;
  return {
    term: t('netgame.says.corrections'),
    before: of(who, 'corrections'),
    value: t('netgame.says.corrections.times', { n: view.corrections }),
    after: `${t('netgame.says.corrections.after')}${most}${without ? t('netgame.says.corrections.without') : ''}`,
  };
}

/** Puts a sentence into its place, the number bold. @param {Element} place @param {Pick<Sentence, 'before' | 'value' | 'after'>} one */
export function tell(place, one) {
  const text = `${one.before}\n${one.value}\n${one.after}`;
  if (place.getAttribute('data-text') === text) return;
  place.setAttribute('data-text', text);
  if (one.value === '') return place.replaceChildren(one.before);
  const number = document.createElement('b');
  number.textContent = one.value;
  const close = one.after === '' || one.after.startsWith(',') ? one.after : ` ${one.after}`;
  place.replaceChildren(`${one.before} `, number, close);
}

/** How many sentences a player has. @param {number} players */
export const countOf = (players) => (players > 1 ? 3 : 2);

/** All of a player. @param {Who} who @param {Memory} memory @returns {Sentence[]} */
export function sentences(who, memory) {
  return [latency(who, memory), ...(who.views.length > 1 ? [age(who)] : []), corrections(who, memory)];
}

/** The one that matters most: a late own key, else the age of the others. @param {Who} who @param {Memory} memory @returns {Sentence} */
export function mainSentence(who, memory) {
  const late = (who.view.flags & PREDICTION) === 0 && memory.lately(who.player).latency !== null;
  return late || who.views.length < 2 ? { ...latency(who, memory), after: t('netgame.says.latency.after') } : age(who);
}
