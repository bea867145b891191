// The head of the page: labs; below them the scenario, what can be done, and the state.
import { html, nothing } from '../../vendor/lit-html.js';
import { effect } from '../../vendor/signals-core.js';
import { part } from '../base/api.js';
import { fixed } from '../base/format.js';
import { headOf } from '../stream/frame.js';
import { labs, tabOf } from '../session/labs.js';
import { choose, fork, openExperiments, openLesson, openTradeoff, shownScenario } from '../session/session.js';
import {
  FRAME_HZ,
  behind,
  connection,
  divisor,
  experiment,
  failure,
  layout,
  lesson,
  place,
  readOnly,
  status,
  tradeoff,
} from '../session/state.js';
import { backToLive } from '../session/time.js';
import { open } from '../workbench/dialog.js';
import { hint } from './hint.js';
import { languages } from './language.js';
import { chooser } from './scenarios.js';
import { t } from '../base/words.js';

/** @typedef {import('lit-html').TemplateResult} Template */

let lastExperiment = ''; /* that was shown: the way back leads to it */
effect(() => {
  if (tradeoff.value === null) lastExperiment = experiment.value ?? lastExperiment;
});

/** @returns {Template} */
function tabs() {
  const asked = lesson.value;
  const shown = experiment.value === null && asked === null ? tabOf(layout.value?.game ?? '') : null;
  const inExperiments = experiment.value !== null && tradeoff.value === null;
  const tab = (/** @type {string} */ name, /** @type {boolean} */ current, /** @type {() => void} */ go) =>
    html`<button type="button" class="lab" aria-current=${current ? 'page' : 'false'} @click=${go}>${name}</button>`;
  const questions = tab(t('shell.questions'), asked !== null, () => {
    if (asked?.id !== '') openLesson({ id: '', step: 1, lang: asked?.lang ?? '' }, true);
  });
  return html`<nav aria-label=${t('shell.labs')}>${questions}${labs.value
    .flatMap((lab) => lab.tabs)
    .map(({ id, name, scenario }) =>
      tab(t(name), shown === id, () => {
        if (shown === null || shownScenario() !== scenario) choose(scenario);
      }),
    )}${tab(t('session.experiments'), inExperiments, () => {
    if (!inExperiments) openExperiments(lastExperiment);
  })}${tab(t('session.tradeoff'), tradeoff.value !== null, () => {
    if (tradeoff.value === null) openTradeoff('#tradeoff', true);
  })}</nav>`;
}

/** On a phone the labs do not all fit: the one that is shown does. When there is time, since asking where things are lays out the page. */
effect(() => {
  layout.value?.game;
  experiment.value;
  tradeoff.value;
  lesson.value;
  (globalThis.requestIdleCallback ?? setTimeout)(() => {
    const current = document.querySelector('.lab[aria-current="page"]'),
      row = current?.parentElement;
    if (row && current instanceof HTMLElement)
      row.scrollLeft = current.offsetLeft - row.offsetLeft - (row.clientWidth - current.offsetWidth) / 2;
  });
});

const SYMBOLS = {
  live: html`<svg class="sign" viewBox="0 0 12 12" aria-hidden="true"><circle cx="6" cy="6" r="5"></circle></svg>`,
  paused: html`<svg class="sign" viewBox="0 0 12 12" aria-hidden="true"><path d="M2 1h3v10H2zM7 1h3v10H7z"></path></svg>`,
  replay: html`<svg class="sign" viewBox="0 0 12 12" aria-hidden="true"><path d="M6 1v10L0 6zM12 1v10L6 6z"></path></svg>`,
  ended: html`<svg class="sign" viewBox="0 0 12 12" aria-hidden="true"><path d="M1 1h10v10H1z"></path></svg>`,
  lost: html`<svg class="sign" viewBox="0 0 12 12" aria-hidden="true"><path d="M6 0l6 11H0z"></path></svg>`,
};

/** @returns {Template} */
function state() {
  const { state: way, attempt } = connection.value;
  if (way === 'lost') return html`${SYMBOLS.lost}<span>${t('shell.lost', { attempt })}</span>`;
  if (status.value === 'waiting') return html`<span>${t('shell.connecting')}</span>`;
  if (status.value === 'failed') return html`${SYMBOLS.lost}<span>${t('shell.stopped', { why: failure.value })}</span>`;
  if (status.value === 'ended') return html`${SYMBOLS.ended}<span>${t('session.ended')}</span>`;
  if (behind.value) {
    const at = t(status.value === 'paused' ? 'shell.paused_at' : 'session.replaying');
    return html`${SYMBOLS.replay}<span>${at} <span id="replayed"></span></span>
      ${readOnly.value ? nothing : html`<button type="button" class="small" @click=${() => backToLive()}>${t('shell.to_live')}</button>`}`;
  }
  return status.value === 'paused'
    ? html`${SYMBOLS.paused}<span>${t('session.paused')}</span>`
    : html`${SYMBOLS.live}<span>${t('shell.live')}</span>`;
}

/** How often a frame comes, when that is less than it should be. @returns {Template | typeof nothing} */
function pace() {
  if (divisor.value === 1 || connection.value.state === 'lost') return nothing;
  return html`<span id="pace"
    title=${t('shell.slow_tip', { hz: FRAME_HZ })}>${t('shell.slow', { hz: fixed(FRAME_HZ / divisor.value, 0) })}</span>`;
}

/** Opens a class with a question: of the lesson that is shown, empty for the first; null: with the session that is shown.
 * @param {string | null} lesson @returns {Template} */
function classButton(lesson) {
  const open = () => part(() => import('../class/room.js')).then((room) => room.teach(lesson));
  return html`<button type="button" class="askclass" title=${t('shell.class_tip')} @click=${open}>${t(
    lesson ? 'shell.ask_class' : 'shell.class',
  )}</button>`;
}

/** To the class of the code that was typed: its part of the page is read there. @param {SubmitEvent} event */
function join(event) {
  event.preventDefault();
  const field = /** @type {HTMLInputElement} */ (/** @type {HTMLFormElement} */ (event.target).elements.namedItem('code'));
  const query = new URLSearchParams(location.search),
    lang = lesson.value?.lang;
  if (lang) query.set('lang', lang); /* that of `#questions` goes with it */
  location.assign(
    `${query.size > 0 ? `?${query}` : location.pathname}#class=${encodeURIComponent(field.value.replace(/\s/g, '').toUpperCase())}`,
  );
}

/** @returns {Template} */
function joining() {
  return html`<form class="joincode" @submit=${join}><label for="join-code">${t('shell.join_code')}</label>
    <input id="join-code" name="code" autocomplete="off" autocapitalize="characters" spellcheck="false" maxlength="12" size="5"
      placeholder=${t('shell.code')} required><button>${t('shell.join')}</button></form>`;
}

/** @returns {Template} */
export function header() {
  const help = html`<button type="button" class="help" aria-label=${t('shell.help')} title=${`${t('shell.help')} ( ? )`}
    @click=${() => open({ kind: 'help' })}>?</button>`;
  if (lesson.value !== null) {
    return html`<header class="top brief"><h1>laglab</h1>${tabs()}${lesson.value.id === '' ? joining() : nothing}${classButton(
      lesson.value.id,
    )}${languages()}${help}</header>`;
  }
  if (experiment.value !== null) return html`<header class="top brief"><h1>laglab</h1>${tabs()}${languages()}${help}</header>`;
  const kind = connection.value.state === 'lost' || status.value === 'failed' ? 'bad' : behind.value ? 'past' : status.value;
  return html`<header class="top"><h1>laglab</h1>${tabs()}${place.value.at === '' ? classButton(null) : nothing}${languages()}${help}
    <div class="under">${chooser()}${hint()}<div class="chip" id="chip" data-kind=${kind}>${state()}${pace()}</div>
    ${
      readOnly.value
        ? html`<div class="chip" id="reader"><span>${t('shell.read_only')}</span><button type="button" class="small"
      @click=${() => fork()}>${t('shell.copy')}</button></div>`
        : nothing
    }
    <button type="button" class="share" @click=${() => open({ kind: 'share' })}>${t('shell.share')}</button></div></header>`;
}

/** @param {import('../stream/frame.js').Frame} now */
export function showReplay(now) {
  const place = document.getElementById('replayed');
  if (place) place.textContent = t('shell.replayed', { s: fixed(now.time_s, 1), end: fixed(headOf(now), 1) });
}
