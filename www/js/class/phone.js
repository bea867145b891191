// What a member sees above and below the board or its copy: its part, and in each phase what the projector shows, in the same words.
import { html, nothing } from '../../vendor/lit-html.js';
import { letter } from '../base/format.js';
import { connection, status } from '../session/state.js';
import { mark } from '../workbench/player_mark.js';
import { answered, asked, ballot, compared, explained, isOpen, measured, results, timeLine } from './ask.js';
import { choiceOf, lessonOf, saidOf, sayOf, titleOf } from './lesson.js';
import { join, vote } from './member.js';
import { networkOf } from './seats.js';
import { attempt, driving, me, now, room, shows } from './state.js';
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
  if (now.value?.together && me.value?.copy) return html`<p class="state">${t('class.together')}</p>`;
  if (shows.value === 'copy' || !driving.value || status.value !== 'paused') return nothing;
  const { phase = '' } = now.value ?? {};
  return phase === 'free' || phase === 'run' ? html`<p class="state">${t('class.paused')}</p>` : nothing;
}

/** @param {string} text @returns {Template} */
const note = (text) => html`<p class="after" role="status">${text}</p>`;

/** How the holder of a seat drives, and over what network; empty for others. @returns {string} */
function drives() {
  const seat = me.value?.role === 'play' ? now.value?.seats.find(({ player }) => player === me.value?.player) : undefined;
  return seat && driving.value ? `${t('class.you_drive')} ${networkOf(seat)}` : '';
}

/** A seat drives later, and this page says so. @returns {string} */
const later = () => (me.value?.role === 'play' && !driving.value ? ` ${t('class.drive_later')}` : ` ${drives()}`);

/** @returns {Template} */
function predicting() {
  const mine = me.value?.choice ?? null,
    lesson = lessonOf(now.value?.question?.lesson ?? '');
  const sent = mine === null ? t('class.choose_one') : t('class.sent', { choice: saidOf(lesson, mine) });
  return html`${asked()}<section class="ask" aria-label=${t('class.question')}>${ballot(vote)}</section>
    <p class="after"><span role="status"><b>${sent}</b></span> ${answered()}. ${t('class.may_change')}</p>`;
}

/** @returns {Template} */
function explaining() {
  const lesson = lessonOf(now.value?.lesson ?? ''),
    mine = me.value?.choice ?? null;
  if (lesson === null) return html`${asked()}${results()}`;
  return html`<h2 class="asked" data-size="small">${titleOf(lesson)}</h2>
    <div class="pair"><p class="mine"><span>${t('class.said')}</span>
      <b>${mine === null ? t('class.nothing') : choiceOf(lesson, mine)}</b></p>${measured(lesson)}</div>${timeLine(lesson)}
    <div class="classwords">${explained(lesson)}</div>${results()}`;
}

/** @param {import('./lesson.js').Lesson | null} lesson @param {Template} text @param {string} after */
const watching = (lesson, text, after) =>
  html`${
    lesson === null ? nothing : html`<h2 class="asked" data-size="small">${titleOf(lesson)}</h2>`
  }<div class="classwords">${text}</div>${note(after)}`;

/** @returns {Template} */
function running() {
  const lesson = lessonOf(now.value?.lesson ?? ''),
    stands = now.value?.phase === 'stopped';
  const text = stands && lesson !== null ? sayOf(lesson, 'observe') : t('class.look_up');
  return watching(lesson, html`<p>${text}</p>`, stands ? t('class.stands') : later());
}

/** @returns {Template} */
function changing() {
  const lesson = lessonOf(now.value?.lesson ?? '');
  return watching(lesson, lesson === null ? html`` : html`<p>${sayOf(lesson, 'change')}</p>${compared(lesson)}`, t('class.look_up'));
}

/** @type {Record<string, () => Template>} */
const STAGES = {
  lobby: () => watching(lessonOf(now.value?.lesson ?? ''), html`<p>${t('class.are_in')}</p>`, t('class.waits') + later()),
  predict: predicting,
  locked: () => html`${asked()}${results()}${note(t('class.locked'))}`,
  run: running,
  stopped: running,
  explain: explaining,
  change: changing,
  free: () => note(drives() || t('class.all_free')),
};

/** Phases in which a member changes its part. */
const STILL = new Set(['lobby', 'free', 'run', 'stopped']);

/** Next to a copy of one's own a question is asked, too. */
const copied = () => (isOpen() ? predicting() : nothing);

/** @returns {Template} */
export function phone() {
  const at = now.value?.phase ?? '';
  const code = html`<span class="letters">${room.value?.code}</span>`;
  return html`<header class="strip"><h1><span class="unseen">${t('shell.class')} </span>${code}</h1>${who()}
    <span class="network number" title=${t('class.number_tip')}>${t('class.number', { n: me.value?.number ?? 0 })}</span>${
      shows.value === 'copy' || STILL.has(at) ? ways() : nothing
    }</header>
    <section class="words" aria-label=${t('shell.class')}><div class="states" role="status">${state()}</div>${
      shows.value === 'copy' ? copied() : (STAGES[at]?.() ?? nothing)
    }</section>`;
}
