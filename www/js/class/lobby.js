// The teacher's view of a class: what to type and to scan in large type, who has come, and what the teacher can do.
import { signal } from '../../vendor/signals-core.js';
import { html, nothing } from '../../vendor/lit-html.js';
import { results } from './ask.js';
import { deviceList, door } from './devices.js';
import { lessons } from './lesson.js';
import { qr } from '../workbench/qr.js';
import { seatList } from './seats.js';
import { now, room, secret, shows, told } from './state.js';
import { choices, choose, end, phase, set } from './teacher.js';
import { language, rich, t } from '../base/words.js';

/** @typedef {import('lit-html').TemplateResult} Template */

/** In the order of a lesson. */
const PHASES = ['predict', 'locked', 'run', 'stopped', 'explain', 'free'];
const ending = signal(false);

/** @returns {Template} */
function phases() {
  const at = PHASES.indexOf(now.value?.phase ?? '');
  return html`<div class="phases-row" role="group" aria-label=${t('class.phase')}>${PHASES.map(
    (name, i) => html`<button type="button" class=${i === at + 1 ? 'main' : ''} aria-pressed=${i === at}
      @click=${() => phase(name)}>${t(`class.do.${name}`)}</button>`,
  )}</div>`;
}

/** @param {string} label @param {(value: string) => void} put @param {unknown} options @returns {Template} */
const choiceField = (label, put, options) => html`<label class="field"><span>${label}</span><select aria-label=${label}
      @change=${(/** @type {Event} */ event) => put(/** @type {HTMLSelectElement} */ (event.target).value)}>${options}</select></label>`;

/** How many choices a question has that is asked aloud. @returns {Template} */
const choicesField = () =>
  choiceField(
    t('class.choices'),
    (given) => {
      choices.value = Number(given);
    },
    [2, 3, 4, 5, 6, 7, 8].map((n) => html`<option value=${n} .selected=${n === choices.value}>${n}</option>`),
  );

/** @returns {Template} */
function question() {
  const lesson = now.value?.lesson ?? '';
  const options = html`<option value="" .selected=${lesson === ''}>${t('class.aloud')}</option>
      ${lessons.value.map(({ id, title }) => html`<option value=${id} .selected=${id === lesson}>${title[language.value]}</option>`)}`;
  return html`${choiceField(t('class.question'), choose, options)}
    ${lesson === '' ? choicesField() : nothing}`;
}

/** @param {'frozen' | 'together'} what @param {string} off key of what it does when it is pressed @param {string} on @returns {Template} */
function pressed(what, off, on) {
  const is = now.value?.[what] === true;
  return html`<button type="button" aria-pressed=${is} @click=${() => set({ [what]: !is })}>${t(is ? on : off)}</button>`;
}

/** @returns {Template} */
const everyone = () => html`${pressed('frozen', 'class.freeze', 'class.unfreeze')}
    ${pressed('together', 'class.gather', 'class.release')}`;

/** @returns {Template} */
function ender() {
  if (!ending.value)
    return html`<button type="button" @click=${() => {
      ending.value = true;
    }}>${t('class.end')}</button>`;
  return html`<button type="button" class="bad" @click=${() => {
    ending.value = false;
    end();
  }}>${t('class.end_all')}</button><button type="button" @click=${() => {
    ending.value = false;
  }}>${t('class.keep')}</button>`;
}

/** @returns {Template} */
const counts = () => {
  const { n = 0, votes = 0, copies = 0, question: asked = null } = now.value ?? {};
  const voted = () => html`<span>${rich('class.voted', { n: html`<b>${votes}</b>` })}</span>`;
  return html`<p class="counts"><span>${rich('class.joined', { n: html`<b>${n}</b>` })}</span>${asked ? voted() : nothing}
    ${copies > 0 ? html`<span>${rich('class.copies', { n: copies, count: html`<b>${copies}</b>` })}</span>` : nothing}</p>`;
};

/** @returns {Template} */
function remote() {
  const at = room.value,
    base = new URL('./', at?.urls[0] ?? location.href);
  return html`<details><summary>${t('class.remote')}</summary>
    <label class="address"><span>${t('class.remote_tip')}</span><input readonly
      .value=${`${base.href}#class=${at?.code}&k=${secret.value}`}></label></details>`;
}

/** The address without the code, since what is typed is shorter so. @param {string} url */
const hostOf = (url) => {
  const { protocol, host } = new URL(url);
  return html`<span class="scheme">${protocol}//</span>${host}`;
};

/** @returns {Template} */
function addresses() {
  const { urls = [], local = true } = room.value ?? {};
  if (local) return html`<p class="reason">${rich('class.local', { command: html`<code>laglab serve --listen 0.0.0.0:8080</code>` })}</p>`;
  return html`<p class="step">${t('class.step_open')}</p><ul class="addresses">${urls
    .slice(0, 3)
    .map((url) => html`<li>${hostOf(url)}/</li>`)}</ul>`;
}

/** The code in large type, which is read out as letters. @param {string} code @returns {Template} */
const letters = (code) =>
  html`<p class="letters" aria-label=${`${t('class.code')} ${[...code].join(' ')}`} role="img">${[...code].map(
    (sign) => html`<span>${sign}</span>`,
  )}</p>`;

/** All that the teacher can do with the class. @returns {Template} */
const steer = () =>
  html`<section class="steer" aria-label=${t('class.controls')}>${phases()}${question()}${everyone()}${ender()}<span
      class="phase">${t(`class.at.${now.value?.phase ?? ''}`)}</span></section>`;

/** @returns {Template} */
export function lobby() {
  const { code = '', urls = [], local = true } = room.value ?? {};
  return html`<main class="lobby"><header><h1>${t('shell.class')}</h1><p>${t('class.lead')}</p>
      <button type="button" class="main" @click=${() => {
        shows.value = 'board';
      }}>${t('class.show_board')}</button></header>
    <div class="how"><div>${addresses()}<p class="step">${local ? t('class.code') : t('class.step_code')}</p>
      ${letters(code)}
      ${seatList(now.value?.seats ?? [])}</div>
      <div>${local ? nothing : qr(urls[0] ?? '')}${counts()}</div></div>
    ${steer()}
    ${deviceList()}
    ${results()}${remote()}
    <p role="status" class="reason">${told.value}</p></main>`;
}

/** The same controls above the board. @returns {Template} */
export function teacherStrip() {
  const toLobby = () => {
    shows.value = 'lobby';
  };
  const code = html`<span class="letters">${room.value?.code}</span>`;
  return html`<section class="strip" aria-label=${t('shell.class')}><h2>${rich('class.named', { code })}</h2>${counts()}
    ${phases()}${everyone()}${door()}<button type="button" @click=${toLobby}>${t('class.lobby')}</button></section>${results()}`;
}
