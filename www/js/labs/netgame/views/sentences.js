// What a player meets, as one sentence and one number each, next to the field's term.
import { fixed, letter } from '../../../base/format.js';
import { t } from '../../../base/words.js';
import { PERSON, PREDICTION, RECONCILIATION } from '../core/frame.js';

/** @typedef {import('../core/frame.js').View} View */
/** @typedef {import('../core/memory.js').Memory} Memory */
/** value: empty while nothing was counted. @typedef {{term: string, before: string, value: string, after: string}} Sentence */

/** Of a person at this player, or of its letter. @param {View} view @param {string} key @param {number} player @param {import('../../../base/words.js').Values} [values] */
const of = (view, key, player, values) =>
  t(`netgame.says.${key}.${(view.flags & PERSON) !== 0 ? 'you' : 'one'}`, { name: letter(player), ...values });

/** @param {View} view @param {number} player @param {Memory} memory @returns {Sentence} */
function latency(view, player, memory) {
  const { latency: ms } = memory.lately(player);
  const predicts = (view.flags & PREDICTION) !== 0;
  return {
    term: t('netgame.says.latency'),
    before: of(view, 'latency', player),
    value: ms === null ? '' : `${fixed(ms, 0)} ms`,
    after: `${t('netgame.says.latency.after')} ${t(predicts ? 'netgame.says.latency.predicts' : 'netgame.says.latency.trip', {
      ms: fixed(2 * view.lag_ms, 0),
    })}`.trimStart(),
  };
}

/** @param {View} view @param {number} player @param {number} players @returns {Sentence} */
function age(view, player, players) {
  return {
    term: t('netgame.says.age'),
    before: players === 2 ? of(view, 'age', player, { other: letter(1 - player) }) : of(view, 'ages', player),
    value: `${fixed(view.view_age_ms, 0)} ms`,
    after: t(players === 2 ? 'netgame.says.age.after' : 'netgame.says.ages.after'),
  };
}

/** @param {View} view @param {number} player @param {Memory} memory @returns {Sentence} */
function corrections(view, player, memory) {
  const most = view.corrections === 0 ? '' : t('netgame.says.corrections.most', { size: fixed(memory.largest[player] ?? 0, 2) }),
    without = view.corrections > 0 && (view.flags & RECONCILIATION) === 0;
  return {
    term: t('netgame.says.corrections'),
    before: of(view, 'corrections', player),
    value: t('netgame.says.corrections.times', { n: view.corrections }),
    after: `${t('netgame.says.corrections.after')}${most}${without ? t('netgame.says.corrections.without') : ''}`,
  };
}

/** Puts a sentence into its place, the number bold. @param {Element} place @param {Pick<Sentence, 'before' | 'value' | 'after'>} one */
export function tell(place, one) {
  const text = `${one.before}\n${one.value}\n${one.after}`;
  if (place.getAttribute('data-text') === text) return;
  place.setAttribute('data-text', text);
  const number = document.createElement('b');
  number.textContent = one.value === '' ? '–' : one.value;
  const close = one.after === '' || one.after.startsWith(',') ? one.after : ` ${one.after}`;
  place.replaceChildren(`${one.before} `, number, close);
}

/** How many sentences a player has. @param {number} players */
export const countOf = (players) => (players > 1 ? 3 : 2);

/** All of a player. @param {View} view @param {number} player @param {number} players @param {Memory} memory @returns {Sentence[]} */
export function sentences(view, player, players, memory) {
  return [latency(view, player, memory), ...(players > 1 ? [age(view, player, players)] : []), corrections(view, player, memory)];
}

/** The one that matters most: a late own key, else the age of the others.
 * @param {View} view @param {number} player @param {number} players @param {Memory} memory @returns {Sentence} */
export function mainSentence(view, player, players, memory) {
  const late = (view.flags & PREDICTION) === 0 && memory.lately(player).latency !== null;
  return late || players < 2 ? { ...latency(view, player, memory), after: t('netgame.says.latency.after') } : age(view, player, players);
}
