// The lower part of the first page: ten questions, the other lessons, and the library.
import { html, nothing } from '../../vendor/lit-html.js';
import { signal } from '../../vendor/signals-core.js';
import { insist } from '../base/api.js';
import { writeLesson } from '../base/link.js';
import { paperName } from '../base/words.js';
import { labs } from '../session/labs.js';
import { readScenarios, titleOf } from '../session/scenario_words.js';
import { lesson, scenarios, theme } from '../session/state.js';
import { drawingOf, tradeoffDrawing } from './drawings.js';
import { file, language, word } from './words.js';

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

/** The lesson that follows in the list; undefined after the last. @param {{order: number}} of @returns {Row | undefined} */
export function next({ order }) {
  read();
  return rows.value.find((row) => row.order > order);
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
  return html`<li><a class="card" data-card=${row.id} href=${hrefOf(row)}>${drawingOf(row.id)}<span
    class="line"><b class="number">${row.order}</b> <b class="title">${row.title[language.value]}</b></span></a></li>`;
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

/** Scenarios, each in its lab. @param {import('../session/state.js').ScenarioRow[]} found @returns {Template} */
function scenes(found) {
  const colours = theme.value === 'auto' ? '' : `&theme=${theme.value}`;
  return html`${labs.value.map(({ group, kind }) => {
    const list = found.filter((row) => row.kind === kind);
    if (list.length === 0) return nothing;
    return html`<section aria-labelledby=${`kind-${kind}`}><h3 id=${`kind-${kind}`}>${word(group)}</h3>
        <ul class="list">${list.map(
          (row) => html`<li><a href=${`?scenario=${row.id}${colours}`}>${titleOf(row)}</a>
          ${row.paper ? html`<small>${inPaper(row.paper)}</small>` : nothing}</li>`,
        )}</ul></section>`;
  })}`;
}

/** What is shown below the questions. @type {import('@preact/signals-core').Signal<'' | 'lessons' | 'scenes'>} */
const more = signal('');

/** @param {'lessons' | 'scenes'} what @param {string} name @returns {Template} */
function moreButton(what, name) {
  return html`<button type="button" class="link" aria-expanded=${more.value === what} aria-controls="door-more" @click=${() => {
    more.value = more.value === what ? '' : what;
    sought.value = '';
    requestAnimationFrame(() => {
      const box = document.getElementById('door-more');
      box?.scrollIntoView({ block: 'nearest' });
      /** @type {HTMLElement | null | undefined} */ (box?.querySelector('input, a'))?.focus();
    });
  }}>${name}</button>`;
}

/** Lessons and scenarios that have all words that are sought. @returns {Template} */
function library() {
  readScenarios();
  const found = scenarios.value.filter((row) => fits(row.id, row.title, titleOf(row), row.paper)),
    some = found.length > 0 || rows.value.some(fitting);
  return html`<label class="seek"><span>${word('door.search')}</span><input type="search" autocomplete="off" .value=${sought.value}
      @input=${(/** @type {Event} */ event) => {
        sought.value = /** @type {HTMLInputElement} */ (event.target).value.trim();
      }}></label>
    ${some || rows.value.length === 0 ? nothing : html`<p role="status">${word('door.none')}</p>`}
    ${sought.value === '' ? nothing : html`${others('questions')}${others('paper')}${others('techniques')}`}
    ${scenes(found)}`;
}

/** The way to speed against error, with what it is about: what is cheap is wrong. @returns {Template} */
function tradeoffCard() {
  return html`<a class="offer" href="#tradeoff"><small>${word('session.tradeoff')}</small><b>${word('door.cost')}</b>
    ${tradeoffDrawing()}<small class="faint">${word('door.cost.measured')}</small></a>`;
}

/** The questions, with the ways to all else. @returns {Template} */
export function door() {
  read();
  const questions = rows.value.filter((row) => row.topic === 'questions');
  return html`<section class="questions" aria-labelledby="door-title" lang=${language.value}>
    <div class="doorhead"><h2 id="door-title">${word('door.title')}</h2><p>${word('door.lead')}</p>
      ${moreButton('lessons', word('door.all', { n: rows.value.length }))}${moreButton('scenes', word('door.library'))}</div>
    <div class="shelf"><ul class="cards" aria-label=${word('topic.questions')}>${questions.map(card)}</ul>${tradeoffCard()}</div>
    <div id="door-more" class=${more.value}>${
      more.value === 'lessons' ? html`${others('paper')}${others('techniques')}` : more.value === 'scenes' ? library() : nothing
    }</div></section>`;
}
