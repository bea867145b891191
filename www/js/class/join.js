// How a student joins: by the code, then as a player, a watcher, or with a copy of the board.
import { html, nothing } from '../../vendor/lit-html.js';
import { letter } from '../base/format.js';
import { mark } from '../workbench/player_mark.js';
import { join } from './member.js';
import { isFree, stateOf } from './seats.js';
import { me, now, part, room, shows, told } from './state.js';

/** @typedef {import('lit-html').TemplateResult} Template */

/** As codes are written: capital letters, no spaces. @param {string} text */
export const tidy = (text) => text.replace(/\s/g, '').toUpperCase();

/** @param {(code: string) => void} find @returns {Template} */
function codeField(find) {
  const submit = (/** @type {SubmitEvent} */ event) => {
    event.preventDefault();
    const field = /** @type {HTMLInputElement} */ (/** @type {HTMLFormElement} */ (event.target).elements.namedItem('code'));
    find(tidy(field.value));
  };
  return html`<form class="code" @submit=${submit}><label for="class-code">Code on the board</label>
    <input id="class-code" name="code" autocomplete="off" autocapitalize="characters" spellcheck="false" maxlength="8" required
      aria-invalid=${told.value === '' ? nothing : 'true'} aria-describedby="class-answer">
    <button class="main">Join</button></form>`;
}

/** @param {import('./state.js').Seat} seat @returns {Template} */
function seatButton(seat) {
  const own = me.value?.role === 'play' && me.value.player === seat.player;
  const free = own || isFree(seat);
  const why = own ? 'yours' : free ? stateOf(seat) : `${stateOf(seat)}: another device plays ${letter(seat.player)}`;
  return html`<button type="button" class="part" ?disabled=${!free} aria-describedby=${`class-seat-${seat.player}`}
    @click=${() => join('play', seat.player)}>${mark(seat.player)}<b>Play ${letter(seat.player)}</b></button>
    <p class="why" id=${`class-seat-${seat.player}`}>${why}</p>`;
}

/** @returns {Template} */
function parts() {
  const seats = now.value?.seats ?? [],
    board = now.value?.board ?? null;
  return html`<p>${seats.length > 0 ? 'No name, no account. Play with your own keys or thumbs, or watch.' : 'No name, no account.'}</p>
    <div class="parts">${seats.map(seatButton)}
    <button type="button" class="part" aria-describedby="class-watch" @click=${() => join('watch')}><b>Watch</b></button>
    <p class="why" id="class-watch">the board, as the teacher shows it; you vote all the same</p>
    <button type="button" class="part" ?disabled=${board === null} aria-describedby="class-copy"
      @click=${() => join('copy')}><b>My own copy</b></button>
    <p class="why" id="class-copy">${board === null ? 'nothing is on the board yet' : 'of what is on the board, to change and to drive'}</p></div>
    ${
      part.value === 'member'
        ? html`<button type="button" @click=${() => {
            shows.value = 'board';
          }}>Back to the board</button>`
        : nothing
    }`;
}

/** @param {(code: string) => void} find @returns {Template} */
export function joinView(find) {
  const at = room.value;
  return html`<main class="join"><h1>${at ? html`Class <span class="letters">${at.code}</span>` : 'Join a class'}</h1>
    ${at ? parts() : codeField(find)}
    <p id="class-answer" role="status" class="reason">${told.value}</p></main>`;
}
