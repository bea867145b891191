// The question of a class: choices to vote; after the lock how many chose what; and what explains it.
import { html, nothing, svg } from '../../vendor/lit-html.js';
import { amountOf, choiceOf, lessonOf, questionOf, saidOf, sayOf, whyOf } from './lesson.js';
import { since } from '../workbench/since.js';
import { me, now } from './state.js';
import { language, rich, t } from '../base/words.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('./lesson.js').Lesson} Lesson */

/** Votes are open. */
export const isOpen = () => now.value?.phase === 'predict' && now.value.question !== null;

/** How many members there are to answer, as far as the class knows. */
export const allOf = () => Math.max(now.value?.n ?? 0, now.value?.votes ?? 0);

/** @returns {Template} */
export const answered = () => html`${rich('class.answered', { n: html`<b>${now.value?.votes ?? 0}</b>`, all: allOf() })}`;

const LONG = 95,
  MIDDLE = 55; /* characters of a question that are set smaller */

/** The last sentence of a question, and what stands before it. */
const PARTS = /^(.*[.!:])\s+([^.!]*\?)$/s;

/** What is asked, in the largest letters that have room, below what one must know for it. @returns {Template} */
export function asked() {
  const text = questionOf(lessonOf(now.value?.question?.lesson ?? now.value?.lesson ?? '')),
    [, before = '', question = text] = PARTS.exec(text) ?? [],
    size = question.length > LONG ? 'small' : question.length > MIDDLE ? 'middle' : 'large';
  return html`<div class="asked" data-size=${size}>${before === '' ? nothing : html`<p>${before}</p>`} <h2>${question}</h2></div>`;
}

/** What a choice means, in a few words. @param {Lesson | null} lesson @param {number} choice @returns {Template | typeof nothing} */
export function hinted(lesson, choice) {
  const hint = lesson?.choices[choice]?.hint;
  return hint ? html`<small>${hint[language.value]}</small>` : nothing;
}

/** @param {(choice: number) => void} vote @returns {Template} */
export function ballot(vote) {
  const { question = null } = now.value ?? {},
    lesson = lessonOf(question?.lesson ?? ''),
    mine = me.value?.choice ?? -1;
  return html`<fieldset class="answers"><legend class="unseen">${questionOf(lesson)}</legend>
    ${Array.from(
      { length: question?.choices ?? 0 },
      (_, i) => html`<label class="answer"><input type="radio" name="class-answer" .checked=${mine === i}
      @change=${() => vote(i)}><span>${choiceOf(lesson, i)}</span>${hinted(lesson, i)}<kbd aria-hidden="true">${i + 1}</kbd></label>`,
    )}</fieldset>`;
}

/** In one sentence, for who does not see the bars. @param {number[]} tally @param {(choice: number) => string} name */
function sentence(tally, name) {
  const all = tally.reduce((a, b) => a + b, 0),
    most = Math.max(...tally);
  if (all === 0) return t('class.no_votes');
  const first = tally.flatMap((votes, i) => (votes === most ? [name(i)] : []));
  return t('class.tally', { most, all, choices: first.join(t('class.as_many')) });
}

/** @param {number} share % */
const bar = (share) =>
  html`<svg viewBox="0 0 100 10" preserveAspectRatio="none" aria-hidden="true">${svg`<rect width=${share} height="10"></rect>`}</svg>`;

/** Bars of the votes; the right choice is marked only when it is explained. @returns {Template | typeof nothing} */
export function results() {
  const state = now.value;
  if (!state?.question || state.tally === null) return nothing;
  const { tally, question } = state,
    lesson = lessonOf(question.lesson),
    most = Math.max(1, ...tally),
    explained = state.phase === 'explain' || state.phase === 'change';
  const row = (/** @type {number} */ votes, /** @type {number} */ i) => {
    const right = explained && lesson?.choices[i]?.right === true;
    return html`<li data-right=${right}><span>${choiceOf(lesson, i)}</span>${bar((100 * votes) / most)}<b>${votes}</b><span
      class="remark">${me.value?.choice === i ? html`<i>${t('class.yours')}</i> ` : nothing}${
        right ? html`<em>${t('class.right')}</em>` : nothing
      }</span></li>`;
  };
  return html`<section class="tally" aria-label=${t('class.votes')}><p role="status"
    class="unseen">${sentence(tally, (i) => saidOf(lesson, i))}</p>
    <h2>${t('class.answers')}<span>${t('class.of', { n: state.votes, all: allOf() })}</span></h2>
    <ol>${tally.map(row)}</ol></section>`;
}

/** What the lesson measures, in yellow. @param {Lesson} lesson @returns {Template} */
export function measured(lesson) {
  const { says } = lesson.answer,
    right = lesson.choices.findIndex((one) => one.right),
    named = !says && lesson.choices[right]?.label ? `${saidOf(lesson, right)}: ` : '';
  return html`<p class="measured"><span>${says?.[language.value] ?? t('class.was')}</span>
    <b>${named}${amountOf(lesson.answer)}</b></p>`;
}

/** Where a lesson's number comes from, as a line of time; it stands in place of the board's drawings. @param {Lesson} lesson
 * @returns {Template | typeof nothing} */
export const timeLine = ({ line = [], numbers }) =>
  line.length === 0
    ? nothing
    : html`<div class="timeline">${since({ parts: line.map((name) => numbers[name]?.value ?? 0), now: Infinity, asked: false })}</div>`;

/** The number without and with the change. @param {Lesson} lesson @returns {Template} */
export const compared = (lesson) => html`<dl class="compared"><div><dt>${t('class.before')}</dt><dd>${amountOf(lesson.answer)}</dd></div>
    <div class="after"><dt>${t('class.after')}</dt><dd>${amountOf(lesson.change.answer)}</dd></div></dl>`;

/** The choice that most have taken, as far as it is known; -1: none. */
export function mostChosen() {
  const tally = now.value?.tally ?? [],
    most = Math.max(0, ...tally);
  return most === 0 ? -1 : tally.indexOf(most);
}

/** The wrong choice that most have taken; -1: none. @param {Lesson} lesson @param {number[]} tally */
function mostWrong({ choices }, tally) {
  const wrong = tally.map((votes, i) => (choices[i]?.right ? 0 : votes)),
    most = Math.max(0, ...wrong);
  return most === 0 ? -1 : wrong.indexOf(most);
}

/** The lesson's sentence, and the reason of the most chosen wrong answer, or of this member's own. @param {Lesson} lesson
 * @returns {Template} */
export function explained(lesson) {
  const tally = now.value?.tally ?? [],
    mine = me.value?.choice ?? null,
    wrong = mostWrong(lesson, tally),
    about = mine ?? (me.value === null ? wrong : -1);
  const who = () =>
    mine === null
      ? t('class.said_most', { n: tally[about] ?? 0, choice: saidOf(lesson, about) })
      : t('class.you_said', { choice: saidOf(lesson, mine) });
  return html`<p>${sayOf(lesson, 'explain')}</p>
    ${about < 0 ? nothing : html`<p class="reasoned"><b>${who()}</b> ${whyOf(lesson, about)}</p>`}`;
}
