// What a player meets, as one sentence and one number each, next to the field's term.
import { fixed, letter } from '../../../base/format.js';
import { PERSON, PREDICTION, RECONCILIATION } from '../core/frame.js';

/** @typedef {import('../core/frame.js').View} View */
/** @typedef {import('../core/memory.js').Memory} Memory */
/** value: empty while nothing was counted. @typedef {{term: string, before: string, value: string, after: string}} Sentence */

/** @param {View} view @param {number} player */
const subject = (view, player) => {
  const you = (view.flags & PERSON) !== 0;
  return {
    whose: you ? 'Your' : `${letter(player)}’s`,
    sees: you ? 'You see' : `${letter(player)} sees`,
    is: you ? 'You were' : `${letter(player)} was`,
  };
};

/** @param {View} view @param {number} player @param {Memory} memory @returns {Sentence} */
function latency(view, player, memory) {
  const { latency: ms } = memory.lately(player);
  const predicts = (view.flags & PREDICTION) !== 0,
    trip = fixed(2 * view.lag_ms, 0);
  return {
    term: 'Input latency',
    before: `${subject(view, player).whose} key shows after`,
    value: ms === null ? '' : `${fixed(ms, 0)} ms`,
    after: predicts ? `(without prediction at least ${trip})` : `(round trip ${trip})`,
  };
}

/** @param {View} view @param {number} player @param {number} players @returns {Sentence} */
function age(view, player, players) {
  const other = players === 2 ? letter(1 - player) : 'the others';
  return {
    term: 'View age',
    before: `${subject(view, player).sees} ${other} as ${players === 2 ? 'it was' : 'they were'}`,
    value: `${fixed(view.view_age_ms, 0)} ms`,
    after: 'ago',
  };
}

/** @param {View} view @param {number} player @param {Memory} memory @returns {Sentence} */
function corrections(view, player, memory) {
  const times = view.corrections === 1 ? '1 time' : `${view.corrections} times`,
    most = view.corrections === 0 ? '' : `, at most ${fixed(memory.largest[player] ?? 0, 2)} m`;
  return {
    term: 'Corrections',
    before: `${subject(view, player).is} pulled back`,
    value: times,
    after: `${most}${view.corrections > 0 && (view.flags & RECONCILIATION) === 0 ? ', without reconciliation' : ''}`,
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
  return late || players < 2 ? { ...latency(view, player, memory), after: '' } : age(view, player, players);
}
