// The first page: ten questions, the other lessons, and the library.
import { html, nothing } from '../../vendor/lit-html.js';
import { signal } from '../../vendor/signals-core.js';
import { insist } from '../base/api.js';
import { writeLesson } from '../base/link.js';
import { paperName } from '../base/words.js';
import { labs } from '../session/labs.js';
import { titleOf } from '../session/scenario_words.js';
import { lesson, scenarios, theme } from '../session/state.js';
import { drawingOf } from './drawings.js';
import { file, language, ready, word } from './words.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('./words.js').Text} Text */
/** @typedef {{id: string, order: number, topic: string, title: Text, paper?: string, scenario: string, minutes: number,
 * hooks: string[]}} Row */

/** Of lessons/index.json, by their order. @type {import('@preact/signals-core').Signal<Row[]>} */
const rows = signal([]);
let reading = false;
/** Reads them when the list is first shown. */
function read() {
  if (reading) return;
  reading = true;
  insist(() => file('lessons/index.json')).then((/** @type {Row[]} */ list) => {
    rows.value = list.sort((a, b) => a.order - b.order);
  });
}

const sought = signal('');

/** Whether a text has all words that are sought. @param {...(string | undefined)} texts */
function fits(...texts) {
  const all = texts.join(' ').toLowerCase();
  return sought.value
    .toLowerCase()
    .split(/\s+/)
    .every((part) => all.includes(part));
}

/** @param {Row} row */
const fitting = (row) => fits(row.title.en, row.title.de, row.paper, row.scenario, ...row.hooks.map((hook) => word(`hooks.${hook}`)));

/** @param {Row} row */
const hrefOf = (row) => writeLesson({ id: row.id, step: 1, lang: lesson.value?.lang ?? '' });

/** @param {Row} row @returns {Template} */
function card(row) {
  return html`<li><a class="card" data-card=${row.id} href=${hrefOf(row)}>${drawingOf(row.id)}<span class="line"><span
    class="number">${row.order}</span>
    <b>${row.title[language.value]}</b></span><small>${word('door.minutes', { n: row.minutes })}</small></a></li>`;
}

/** Where in the paper. @param {string} paper @returns {Template} */
function inPaper(paper) {
  const { text, lang } = paperName(paper);
  return html`<span lang=${lang}>${text}</span>`;
}

/** The other lessons of a topic. @param {string} topic @returns {Template | typeof nothing} */
function others(topic) {
  const list = rows.value.filter((row) => row.topic === topic && fitting(row));
  if (list.length === 0) return nothing;
  return html`<section aria-labelledby=${`topic-${topic}`}><h3 id=${`topic-${topic}`}>${word(`topic.${topic}`)}</h3>
    <ul class="list">${list.map(
      (row) => html`<li><a href=${hrefOf(row)}>${row.title[language.value]}</a>
        <small>${row.paper ? html`${inPaper(row.paper)} · ` : nothing}${word('door.minutes', { n: row.minutes })}</small></li>`,
    )}</ul></section>`;
}

/** All scenarios, each in its lab. @returns {Template | typeof nothing} */
function library() {
  const found = scenarios.value.filter((row) => fits(row.id, row.title, titleOf(row), row.paper)),
    colours = theme.value === 'auto' ? '' : `&theme=${theme.value}`;
  if (found.length === 0) return nothing;
  return html`<details class="library" ?open=${sought.value !== ''}><summary>${word('door.library')} (${found.length})</summary>
    ${labs.value.map(({ group, kind }) => {
      const list = found.filter((row) => row.kind === kind);
      if (list.length === 0) return nothing;
      return html`<section aria-labelledby=${`kind-${kind}`}><h3 id=${`kind-${kind}`}>${word(group)}</h3>
        <ul class="list">${list.map(
          (row) => html`<li><a href=${`?scenario=${row.id}${colours}`}>${titleOf(row)}</a>
          ${row.paper ? html`<small>${inPaper(row.paper)}</small>` : nothing}</li>`,
        )}</ul></section>`;
    })}</details>`;
}

/** To the class of the code that was typed: its part of the page is read there. @param {SubmitEvent} event */
function join(event) {
  event.preventDefault();
  const field = /** @type {HTMLInputElement} */ (/** @type {HTMLFormElement} */ (event.target).elements.namedItem('code'));
  location.hash = `#class=${encodeURIComponent(field.value.replace(/\s/g, '').toUpperCase())}`;
}

/** @returns {Template} */
function joining() {
  return html`<form class="joining" @submit=${join}><label for="door-code">${word('door.join')}</label>
    <input id="door-code" name="code" autocomplete="off" autocapitalize="characters" spellcheck="false" maxlength="12" required>
    <button>${word('door.go')}</button></form>`;
}

/** @returns {Template} */
export function door() {
  read();
  if (!ready.value) return html`<main class="door" id="views" tabindex="-1"></main>`;
  const questions = rows.value.filter((row) => row.topic === 'questions' && fitting(row)),
    none =
      rows.value.length > 0 &&
      !rows.value.some(fitting) &&
      !scenarios.value.some((row) => fits(row.id, row.title, titleOf(row), row.paper));
  return html`<main class="door" id="views" tabindex="-1" lang=${language.value}>
    <div class="doorhead"><div><h2>${word('door.title')}</h2><p>${word('door.lead')}</p></div>
      ${joining()}
      <label class="seek"><span>${word('door.search')}</span><input type="search" autocomplete="off" .value=${sought.value}
        @input=${(/** @type {Event} */ event) => {
          sought.value = /** @type {HTMLInputElement} */ (event.target).value.trim();
        }}></label></div>
    <ul class="cards" aria-label=${word('topic.questions')}>${questions.map(card)}</ul>
    ${none ? html`<p role="status">${word('door.none')}</p>` : nothing}
    ${others('paper')}${others('techniques')}${library()}
    <ul class="list"><li><a href="#tradeoff">${word('session.tradeoff')}</a></li></ul></main>`;
}
