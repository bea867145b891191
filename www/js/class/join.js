// How a student joins: by the code, then as a player, a watcher, or with a copy of the board.
import { html, nothing } from '../../vendor/lit-html.js';
import { letter } from '../base/format.js';
import { mark } from '../workbench/player_mark.js';
import { isOpen } from './ask.js';
import { join } from './member.js';
import { isFree, stateOf } from './seats.js';
import { me, now, out, part, room, shows, told } from './state.js';
import { rich, t } from '../base/words.js';

/** @typedef {import('lit-html').TemplateResult} Template */

/** As codes are written: capital letters, no spaces, `-` after the name of a shard. Such a name has no I, L and O, which are read for 1
 * and 0. @param {string} text */
export function tidy(text) {
  const letters = text.replace(/[\s-]/g, '').toUpperCase(),
    name = letters.slice(0, -4).replace(/[IL]/g, '1').replace(/O/g, '0');
  return name === '' ? letters : `${name}-${letters.slice(-4)}`;
}

/** @param {(code: string) => void} find @returns {Template} */
function codeField(find) {
  const submit = (/** @type {SubmitEvent} */ event) => {
    event.preventDefault();
    const field = /** @type {HTMLInputElement} */ (/** @type {HTMLFormElement} */ (event.target).elements.namedItem('code'));
    find(tidy(field.value));
  };
  return html`<form class="code" @submit=${submit}><label for="class-code">${t('class.code_on_board')}</label>
    <input id="class-code" name="code" autocomplete="off" autocapitalize="characters" spellcheck="false" maxlength="12" required
      aria-invalid=${told.value === '' ? nothing : 'true'} aria-describedby="class-answer">
    <button class="main">${t('class.join')}</button></form>`;
}

/** @param {import('./state.js').Seat} seat @returns {Template} */
function seatButton(seat) {
  const own = me.value?.role === 'play' && me.value.player === seat.player;
  const free = own || isFree(seat);
  const why = own ? t('class.yours') : free ? stateOf(seat) : t('class.another', { state: stateOf(seat), player: letter(seat.player) });
  return html`<button type="button" class="part" ?disabled=${!free} aria-describedby=${`class-seat-${seat.player}`}
    @click=${() => join('play', seat.player)}>${mark(seat.player)}<b>${t('class.play', { player: letter(seat.player) })}</b></button>
    <p class="why" id=${`class-seat-${seat.player}`}>${why}</p>`;
}

/** @returns {Template} */
function parts() {
  const seats = now.value?.seats ?? [],
    board = now.value?.board ?? null;
  if (now.value?.door === 'closed' && part.value === '') return html`<p class="reason">${t('class.door_shut')}</p>`;
  return html`${isOpen() ? html`<p class="open" role="status">${t('class.open_now')}</p>` : nothing}
    <p>${seats.length > 0 ? t('class.no_account_play') : t('class.no_account')}</p>
    <div class="parts">${seats.map(seatButton)}
    <button type="button" class="part" aria-describedby="class-watch" @click=${() => join('watch')}><b>${t('class.watch')}</b></button>
    <p class="why" id="class-watch">${t('class.watch_tip')}</p>
    <button type="button" class="part" ?disabled=${board === null} aria-describedby="class-copy"
      @click=${() => join('copy')}><b>${t('class.own_copy')}</b></button>
    <p class="why" id="class-copy">${board === null ? t('class.no_board_tip') : t('class.own_copy_tip')}</p></div>
    ${
      part.value === 'member'
        ? html`<button type="button" @click=${() => {
            shows.value = 'board';
          }}>${t('class.back_to_board')}</button>`
        : nothing
    }`;
}

/** What a device reads that the teacher has removed. @param {string} code @returns {Template} */
const outView = (code) => html`<main class="join"><h1 role="alert">${t('class.out')}</h1>
    <p>${rich('class.out_tip', { code: html`<span class="letters">${code}</span>` })}</p></main>`;

/** @param {(code: string) => void} find @returns {Template} */
export function joinView(find) {
  const at = room.value;
  if (at !== null && out.value) return outView(at.code);
  const title = at ? rich('class.named', { code: html`<span class="letters">${at.code}</span>` }) : t('class.join_one');
  return html`<main class="join"><h1>${title}</h1>
    ${at ? parts() : codeField(find)}
    <p id="class-answer" role="status" class="reason">${told.value}</p></main>`;
}
