// The teacher's view of a class: what to type and to scan in large type, who has come, and what the teacher can do.
import { signal } from '../../vendor/signals-core.js';
import { html, nothing } from '../../vendor/lit-html.js';
import { results } from './ask.js';
import { LANGUAGE, lessons } from './lesson.js';
import { qr } from '../workbench/qr.js';
import { seatList } from './seats.js';
import { now, room, secret, shows, told } from './state.js';
import { choices, choose, end, phase, set } from './teacher.js';

/** @typedef {import('lit-html').TemplateResult} Template */

/** In the order of a lesson; the last is the name of its button. @type {[string, string][]} */
const PHASES = [
  ['predict', 'Predict'],
  ['locked', 'Lock'],
  ['run', 'Run'],
  ['stopped', 'Stop'],
  ['explain', 'Explain'],
  ['free', 'Free'],
];
const WORDS = /** @type {Record<string, string>} */ ({
  lobby: 'Waiting for the first question',
  predict: 'Votes are open',
  locked: 'Votes are locked',
  run: 'The board runs',
  stopped: 'The board is stopped',
  explain: 'Explaining',
  free: 'Free to try',
});
const ending = signal(false);

/** @param {Event} event */
const valueOf = (event) => /** @type {HTMLSelectElement} */ (event.target).value;

/** @returns {Template} */
function phases() {
  const at = PHASES.findIndex(([name]) => name === now.value?.phase);
  return html`<div class="phases-row" role="group" aria-label="Phase">${PHASES.map(
    ([name, label], i) => html`<button type="button" class=${i === at + 1 ? 'main' : ''} aria-pressed=${i === at}
      @click=${() => phase(name)}>${label}</button>`,
  )}</div>`;
}

/** @returns {Template} */
function question() {
  const lesson = now.value?.lesson ?? '';
  return html`<label class="field"><span>Question</span><select aria-label="Question" @change=${(/** @type {Event} */ event) => choose(valueOf(event))}>
      <option value="" .selected=${lesson === ''}>asked aloud</option>
      ${lessons.value.map(({ id, title }) => html`<option value=${id} lang=${LANGUAGE} .selected=${id === lesson}>${title[LANGUAGE]}</option>`)}</select></label>
    ${
      lesson === ''
        ? html`<label class="field"><span>Choices</span><select aria-label="Choices" @change=${(/** @type {Event} */ event) => {
            choices.value = Number(valueOf(event));
          }}>${[2, 3, 4, 5, 6, 7, 8].map((n) => html`<option value=${n} .selected=${n === choices.value}>${n}</option>`)}</select></label>`
        : nothing
    }`;
}

/** @returns {Template} */
function everyone() {
  const frozen = now.value?.frozen === true,
    together = now.value?.together === true;
  return html`<button type="button" aria-pressed=${frozen} @click=${() => set({ frozen: !frozen })}>${frozen ? 'Unfreeze' : 'Freeze all'}</button>
    <button type="button" aria-pressed=${together} @click=${() => set({ together: !together })}>${together ? 'Release from the board' : 'Bring all here'}</button>`;
}

/** @returns {Template} */
function ender() {
  if (!ending.value)
    return html`<button type="button" @click=${() => {
      ending.value = true;
    }}>End the class</button>`;
  return html`<button type="button" class="bad" @click=${() => {
    ending.value = false;
    end();
  }}>End it for all</button><button type="button" @click=${() => {
    ending.value = false;
  }}>Keep it</button>`;
}

/** @returns {Template} */
const counts = () => {
  const { n = 0, votes = 0, copies = 0, question: asked = null } = now.value ?? {};
  return html`<p class="counts"><span><b>${n}</b> joined</span>${asked ? html`<span><b>${votes}</b> voted</span>` : nothing}
    ${copies > 0 ? html`<span><b>${copies}</b> ${copies === 1 ? 'copy' : 'copies'}</span>` : nothing}</p>`;
};

/** @returns {Template} */
function remote() {
  const at = room.value,
    base = new URL('./', at?.urls[0] ?? location.href);
  return html`<details><summary>Steer from another device</summary>
    <label class="address"><span>Open this address there. It holds your key: do not show it to the class.</span><input readonly
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
  if (local)
    return html`<p class="reason">Only this computer reaches laglab, so no other device can join. Start it with <code>laglab serve --listen
      0.0.0.0:8080</code>.</p>`;
  return html`<p class="step">1 Open on your phone or laptop</p><ul class="addresses">${urls
    .slice(0, 3)
    .map((url) => html`<li>${hostOf(url)}/</li>`)}</ul>`;
}

/** @returns {Template} */
export function lobby() {
  const { code = '', urls = [], local = true } = room.value ?? {};
  return html`<main class="lobby"><header><h1>Class</h1><p>Same network as this computer. No name, no account.</p>
      <button type="button" class="main" @click=${() => {
        shows.value = 'board';
      }}>Show the board</button></header>
    <div class="how"><div>${addresses()}<p class="step">${local ? 'Code' : '2 Add the code to the address'}</p>
      <p class="letters" aria-label=${`Code ${[...code].join(' ')}`} role="img">${[...code].map((sign) => html`<span>${sign}</span>`)}</p>
      ${seatList(now.value?.seats ?? [])}</div>
      <div>${local ? nothing : qr(urls[0] ?? '')}${counts()}</div></div>
    <section class="steer" aria-label="Controls of the class">${phases()}${question()}${everyone()}${ender()}<span class="phase">${WORDS[now.value?.phase ?? ''] ?? ''}</span></section>
    ${results()}${remote()}
    <p role="status" class="reason">${told.value}</p></main>`;
}

/** The same controls above the board. @returns {Template} */
export function teacherStrip() {
  const toLobby = () => {
    shows.value = 'lobby';
  };
  return html`<section class="strip" aria-label="Class"><h2>Class <span class="letters">${room.value?.code}</span></h2>${counts()}
    ${phases()}${everyone()}<button type="button" @click=${toLobby}>Lobby</button></section>${results()}`;
}
