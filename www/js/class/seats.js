// The seats of a class in words: who plays, over what network.
import { html } from '../../vendor/lit-html.js';
import { fixed, letter } from '../base/format.js';
import { mark } from '../workbench/player_mark.js';

/** @typedef {import('./state.js').Seat} Seat */

/** Whether a member may take it. @param {Seat} seat */
export const isFree = ({ state }) => state === 'free' || state === 'script';

/** @param {Seat} seat @returns {string} */
export function stateOf({ state }) {
  if (state === 'free') return 'free';
  if (state === 'held') return 'taken';
  return state === 'away' ? 'taken: connection lost' : 'free: the script plays since its connection was lost';
}

/** The measured network next to the simulated one. @param {Seat} seat @returns {string} */
export function networkOf({ state, rtt_ms, lag_ms }) {
  const simulated = `simulated lag ${fixed(lag_ms, 0)} ms one way`;
  if (state !== 'held') return simulated;
  return `${rtt_ms === null ? 'round trip not measured yet' : `round trip ${fixed(rtt_ms, rtt_ms < 10 ? 1 : 0)} ms`}, ${simulated}`;
}

/** @param {Seat[]} seats */
export function seatList(seats) {
  return html`<ul class="seats">${seats.map(
    (seat) => html`<li data-state=${seat.state}>${mark(seat.player)}
    <b>Play ${letter(seat.player)}</b> <span>${stateOf(seat)}</span> <small>${networkOf(seat)}</small></li>`,
  )}</ul>`;
}
