// What a class sees on the projector: one stage for each phase, in type of the screen's size. The drawings of the board stand between.
import { html, nothing } from '../../vendor/lit-html.js';
import { slower } from '../base/format.js';
import { speed } from '../session/state.js';
import { qr } from '../workbench/qr.js';
import { allOf, answered, asked, compared, explained, hinted, measured, results, timeLine } from './ask.js';
import { choiceOf, lessonOf, sayOf, titleOf } from './lesson.js';
import { foot, nextButtons } from './next.js';
import { seatList } from './seats.js';
import { now, room, shows } from './state.js';
import { rich, t } from '../base/words.js';

/** @typedef {import('lit-html').TemplateResult} Template */

/** The address without the code, since what is typed is shorter so. @param {string} url */
const hostOf = (url) => {
  const { protocol, host } = new URL(url);
  return html`<span class="scheme">${protocol}//</span>${host}`;
};

/** The code, which is read out as letters. @param {string} code @returns {Template} */
const letters = (code) =>
  html`<p class="letters" aria-label=${`${t('class.code')} ${[...code].join(' ')}`} role="img">${[...code].map(
    (sign) => html`<span>${sign}</span>`,
  )}</p>`;

const theLesson = () => lessonOf(now.value?.lesson ?? '');

/** @returns {Template} */
function head() {
  const { code = '', urls = [], local = true } = room.value ?? {},
    lesson = theLesson();
  const at =
    now.value?.phase === 'lobby'
      ? nothing
      : html`${
          local
            ? nothing
            : html`<p class="joinat">${rich('class.join_at', {
                host: html`<b>${new URL(urls[0] ?? '').host}</b>`,
              })}</p>`
        }
      ${letters(code)}`;
  return html`<header class="stagehead"><img src="icon.svg" alt=""><p class="brand">laglab</p>
    <h1>${lesson === null ? t('shell.class') : titleOf(lesson)}</h1>${at}</header>`;
}

/** One dot a member, filled for who has answered. @param {number} done @param {number} all @returns {Template} */
const dots = (done, all) =>
  html`<div class="dots" aria-hidden="true">${Array.from({ length: all }, (_, i) => html`<i data-done=${i < done}></i>`)}</div>`;

/** @returns {Template} */
function joining() {
  const { code = '', urls = [], local = true } = room.value ?? {},
    n = now.value?.n ?? 0;
  const open = local
    ? html`<p class="reason">${rich('class.local', { command: html`<code>laglab serve --listen 0.0.0.0:8080</code>` })}</p>`
    : html`<p class="step">${t('class.step_open')}</p><ul class="addresses">${urls
        .slice(0, 3)
        .map((url) => html`<li>${hostOf(url)}/</li>`)}</ul>`;
  return html`<main class="joining"><div>${open}<p class="step">${local ? t('class.code') : t('class.step_code')}</p>${letters(code)}
      <p class="lead">${t('class.lead')}</p></div>
 <div>${local ? nothing : qr(urls[0] ?? '')}
    <p class="come" role="status">${rich('class.joined', { n: html`<b>${n}</b>` })}</p>${dots(n, n)}
    ${seatList(now.value?.seats ?? [])}</div></main>`;
}

/** How many have answered, never what. @returns {Template} */
function comers() {
  const { urls = [], local = true } = room.value ?? {},
    { n = 0, votes = 0 } = now.value ?? {};
  return html`<aside class="comers" aria-label=${t('class.votes')}>${local ? nothing : qr(urls[0] ?? '')}
    ${
      n === 0 && votes === 0
        ? html`<p class="reason">${t('class.devices_none')}</p>`
        : html`<p role="status" class="count">${answered()}</p>${dots(votes, allOf())}`
    }</aside>`;
}

/** @returns {Template} */
function choices() {
  const { question = null } = now.value ?? {},
    lesson = lessonOf(question?.lesson ?? '');
  const names = Array.from({ length: question?.choices ?? 0 }, (_, i) => choiceOf(lesson, i)),
    longest = Math.max(0, ...names.map(({ length }) => length)) * (names.length > 4 ? 1.25 : 1);
  return html`<ol class="choices" aria-label=${t('class.choices')} data-rows=${names.length > 5 ? 2 : 1} data-size=${
    longest > 14 ? 'small' : longest > 8 ? 'middle' : 'large'
  }>${names.map((name, i) => html`<li><span>${i + 1}</span><b>${name}</b>${hinted(lesson, i)}</li>`)}</ol>`;
}

/** @param {unknown} text @returns {Template} */
const caption = (text) => html`<div class="classwords" role="status">${text}</div>`;

/** What is under way while the board plays: what it shows is said when it stands. @returns {Template} */
function running() {
  const lesson = theLesson(),
    stands = now.value?.phase === 'stopped';
  const text = lesson === null ? t('class.at.run') : stands ? sayOf(lesson, 'observe') : `${t('class.watch_it')} ${slower(speed.value)}`;
  return caption(html`<p>${text}</p>`);
}

/** @returns {Template} */
function explaining() {
  const lesson = theLesson();
  if (lesson === null) return html`${asked()}${results()}`;
  return html`${measured(lesson)}${timeLine(lesson)}${results()}<div class="classwords">${explained(lesson)}</div>`;
}

/** @returns {Template} */
function changing() {
  const lesson = theLesson();
  return lesson === null ? running() : caption(html`<p>${sayOf(lesson, 'change')}</p>${compared(lesson)}`);
}

/** @type {Record<string, () => Template>} */
const STAGES = {
  predict: () => html`${asked()}${comers()}${choices()}`,
  locked: () => html`${asked()}${results()}`,
  run: running,
  stopped: running,
  explain: explaining,
  change: changing,
  free: () => caption(html`<p>${t('class.all_free')}</p>`),
};

/** @returns {Template} */
function words() {
  const at = STAGES[now.value?.phase ?? ''];
  return at ? html`<section class="words" aria-label=${t('shell.class')}>${at()}</section>` : joining();
}

/** @returns {Template} */
export const stage = () => html`${head()}${words()}${foot()}`;

/** Above the board with all its controls. @returns {Template} */
export function aboveWorkbench() {
  const code = html`<span class="letters">${room.value?.code}</span>`,
    { n = 0, votes = 0, question: open = null } = now.value ?? {};
  return html`<section class="strip" aria-label=${t('shell.class')}><h2>${rich('class.named', { code })}</h2><p class="counts"><span>${rich(
    'class.joined',
    { n: html`<b>${n}</b>` },
  )}</span>${open ? html`<span>${rich('class.voted', { n: html`<b>${votes}</b>` })}</span>` : nothing}</p>
    <button type="button" @click=${() => {
      shows.value = 'stage';
    }}>${t('class.to_stage')}</button>${nextButtons()}</section>`;
}
