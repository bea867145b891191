// The seats of a class in words: who plays, over what network.
import { html } from '../../vendor/lit-html.js';
import { fixed, letter } from '../base/format.js';
import { mark } from '../workbench/player_mark.js';
import { t } from '../base/words.js';

/** @typedef {import('./state.js').Seat} Seat */

/** Whether a member may take it. @param {Seat} seat */
export const isFree = ({ state }) => state === 'free' || state === 'script';

/** @param {Seat} seat @returns {string} */
export function stateOf({ state }) {
  if (state === 'free') return t('class.free');
  if (state === 'held') return t('class.taken');
  return state === 'away' ? t('class.taken_away') : t('class.free_script');
}

/** The measured network next to the simulated one. @param {Seat} seat @returns {string} */
export function networkOf({ state, rtt_ms, lag_ms }) {
  const simulated = t('class.simulated', { ms: fixed(lag_ms, 0) });
  if (state !== 'held') return simulated;
  return `${rtt_ms === null ? t('class.no_rtt') : t('class.rtt', { ms: fixed(rtt_ms, rtt_ms < 10 ? 1 : 0) })}, ${simulated}`;
}

/** @param {Seat[]} seats */
export function seatList(seats) {
  return html`<ul class="seats">${seats.map(
    (seat) => html`<li data-state=${seat.state}>${mark(seat.player)}
    <b>${t('class.play', { player: letter(seat.player) })}</b> <span>${stateOf(seat)}</span> <small>${networkOf(seat)}</small></li>`,
  )}</ul>`;
}
