// What a member sees above the board or its copy: its part, what the class does, the question.
import { html, nothing } from '../../vendor/lit-html.js';
import { letter } from '../base/format.js';
import { connection } from '../session/state.js';
import { mark } from '../workbench/player_mark.js';
import { ballot, results } from './ask.js';
import { join, vote } from './member.js';
import { networkOf } from './seats.js';
import { attempt, me, now, room, shows } from './state.js';
import { t } from '../base/words.js';

/** @typedef {import('lit-html').TemplateResult} Template */

/** @returns {Template} */
function who() {
  const mine = me.value;
  if (shows.value === 'copy') return html`<p class="chip">${t('class.your_copy')}</p>`;
  if (mine?.role !== 'play' || mine.player === null) return html`<p class="chip">${t('class.you_watch')}</p>`;
  const seat = now.value?.seats.find(({ player }) => player === mine.player);
  const plays = t('class.you_play', { player: letter(mine.player) });
  return html`<p class="chip" title=${seat ? networkOf(seat) : nothing}>${mark(mine.player)}${plays}</p>`;
}

/** @returns {Template} */
function ways() {
  const mine = me.value,
    away = now.value?.together === true;
  const go = (/** @type {'choose' | 'board' | 'copy'} */ where) => () => {
    shows.value = where;
  };
  if (shows.value === 'copy') return html`<button type="button" @click=${go('board')}>${t('class.to_board')}</button>`;
  return html`${
    mine?.role === 'play'
      ? html`<button type="button" @click=${() => join('watch')}>${t('class.give_back')}</button>`
      : html`<button type="button" @click=${go('choose')}>${t('class.play_or_watch')}</button>`
  }
  ${
    mine?.copy
      ? html`<button type="button" ?disabled=${away} title=${away ? t('class.together_tip') : nothing}
      @click=${go('copy')}>${t('class.my_copy')}</button>`
      : nothing
  }`;
}

/** What the page must say before anything else. @returns {Template | typeof nothing} */
function state() {
  const tries = Math.max(attempt.value, connection.value.state === 'lost' ? connection.value.attempt : 0);
  if (tries > 0) return html`<p class="state" data-kind="lost">${t('class.lost', { tries })}</p>`;
  if (now.value?.frozen) return html`<p class="state" data-kind="frozen">${t('class.frozen')}</p>`;
  if (now.value?.board === null) return html`<p class="state">${t('class.no_board')}</p>`;
  return now.value?.together && me.value?.copy ? html`<p class="state">${t('class.together')}</p>` : nothing;
}

/** @returns {Template} */
export function memberStrip() {
  const mine = me.value,
    seat = mine?.role === 'play' ? now.value?.seats.find(({ player }) => player === mine.player) : undefined;
  const code = html`<span class="letters">${room.value?.code}</span>`;
  return html`<header class="strip"><h1><span class="unseen">${t('shell.class')} </span>${code}</h1>${who()}
    <span class="network"><span class="number" title=${t('class.number_tip')}>${t('class.number', { n: mine?.number ?? 0 })}</span>${
      seat && shows.value === 'board' ? `, ${networkOf(seat)}` : nothing
    }</span>${ways()}</header>
    <div role="status">${state()}</div>${ballot(vote)}${results()}`;
}
