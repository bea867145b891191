// What a teacher needs seldom: another question, freezing, devices, the end. Behind one button, so that a class does not see it.
import { signal } from '../../vendor/signals-core.js';
import { html, nothing, render } from '../../vendor/lit-html.js';
import { deviceList } from './devices.js';
import { lessons, titleOf } from './lesson.js';
import { more } from './next.js';
import { seatList } from './seats.js';
import { now, part, room, secret, shows } from './state.js';
import { choices, choose, end, phase, set } from './teacher.js';
import { t } from '../base/words.js';

/** @typedef {import('lit-html').TemplateResult} Template */

const ending = signal(false);

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
      ${lessons.value.map((row) => html`<option value=${row.id} .selected=${row.id === lesson}>${titleOf(row)}</option>`)}`;
  return html`${choiceField(t('class.question'), (id) => choose(id), options)}
    ${lesson === '' ? choicesField() : act(t('class.again'), () => choose(lesson, true))}`;
}

/** Does it and closes. @param {string} text @param {() => unknown} what @returns {Template} */
const act = (text, what) =>
  html`<button type="button" @click=${() => {
    more.value = false;
    what();
  }}>${text}</button>`;

/** @param {'frozen' | 'together'} what @param {string} off key of what it does when it is pressed @param {string} on @returns {Template} */
function pressed(what, off, on) {
  const is = now.value?.[what] === true;
  return html`<button type="button" aria-pressed=${is} @click=${() => set({ [what]: !is })}>${t(is ? on : off)}</button>`;
}

/** @returns {Template} */
function ender() {
  if (!ending.value)
    return html`<button type="button" @click=${() => {
      ending.value = true;
    }}>${t('class.end')}</button>`;
  return html`${act(t('class.end_all'), end)}<button type="button" @click=${() => {
    ending.value = false;
  }}>${t('class.keep')}</button>`;
}

/** @returns {Template} */
function remote() {
  const at = room.value,
    base = new URL('./', at?.urls[0] ?? location.href);
  return html`<details><summary>${t('class.remote')}</summary>
    <label class="address"><span>${t('class.remote_tip')}</span><input readonly
      .value=${`${base.href}#class=${at?.code}&k=${secret.value}`}></label></details>`;
}

/** @returns {Template} */
function swap() {
  const to = shows.value === 'stage' ? 'workbench' : 'stage';
  return act(t(to === 'stage' ? 'class.to_stage' : 'class.to_workbench'), () => {
    shows.value = to;
  });
}

/** @returns {Template} */
function content() {
  const { phase: at = '', copies = 0 } = now.value ?? {};
  return html`<header><h2 id="class-more">${t('class.more')}</h2><button type="button" class="close" @click=${() => {
    more.value = false;
  }}>${t('shell.close')}</button></header>
    <section>${question()}${at === 'lobby' ? nothing : act(t('class.to_lobby'), () => phase('lobby'))}${swap()}</section>
    <section>${pressed('frozen', 'class.freeze', 'class.unfreeze')}${pressed('together', 'class.gather', 'class.release')}${
      at === 'free' ? nothing : act(t('class.do.free'), () => phase('free'))
    }</section>
    <section>${seatList(now.value?.seats ?? [])}
      ${copies > 0 ? html`<p>${t('class.copies', { n: copies, count: copies })}</p>` : nothing}</section>
    ${deviceList()}
    <section>${remote()}${ender()}</section>`;
}

const dialog = document.createElement('dialog');
dialog.className = 'classmore';
dialog.setAttribute('aria-labelledby', 'class-more');
dialog.addEventListener('close', () => {
  more.value = ending.value = false;
});
dialog.addEventListener('click', (event) => {
  if (event.target === dialog) dialog.close();
});

/** To be called in an effect, which follows what it reads. @param {HTMLElement} root */
export function draw(root) {
  if (!dialog.isConnected) root.append(dialog);
  const open = more.value && part.value === 'teacher';
  if (open) render(content(), dialog);
  if (open && !dialog.open) dialog.showModal();
  if (!open && dialog.open) dialog.close();
}
