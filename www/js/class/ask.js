// The question of a class: choices to vote, and after the lock how many chose what.
import { html, nothing, svg } from '../../vendor/lit-html.js';
import { choiceOf, lessonOf, questionOf } from './lesson.js';
import { me, now } from './state.js';
import { t } from '../base/words.js';

/** @typedef {import('lit-html').TemplateResult} Template */

/** Votes are open. */
export const isOpen = () => now.value?.phase === 'predict' && now.value.question !== null;

/** @param {(choice: number) => void} vote @returns {Template | typeof nothing} */
export function ballot(vote) {
  const question = now.value?.question ?? null;
  if (!isOpen() || question === null) return nothing;
  const lesson = lessonOf(question.lesson),
    mine = me.value?.choice ?? -1,
    message = mine < 0 ? t('class.choose_one') : t('class.sent', { choice: choiceOf(lesson, mine) });
  return html`<section class="ask" aria-label=${t('class.question')}><fieldset class="answers"><legend>${questionOf(lesson)}</legend>
    ${Array.from(
      { length: question.choices },
      (_, i) => html`<label class="answer"><input type="radio" name="class-answer" .checked=${mine === i}
      @change=${() => vote(i)}><span>${choiceOf(lesson, i)}</span><kbd aria-hidden="true">${i + 1}</kbd></label>`,
    )}</fieldset>
    <p role="status">${message} ${t('class.may_change')}</p></section>`;
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
  if (!state?.question || state.tally === null || state.phase === 'lobby') return nothing;
  const { tally, question } = state,
    lesson = lessonOf(question.lesson),
    all = Math.max(
      1,
      tally.reduce((a, b) => a + b, 0),
    ),
    explained = state.phase === 'explain';
  const remark = (/** @type {number} */ i) =>
    (me.value?.choice === i ? t('class.yours') : '') + (explained && lesson?.choices[i]?.right ? ` ${t('class.right')}` : '');
  return html`<section class="tally" aria-label=${t('class.votes')}><p role="status">${sentence(tally, (i) => choiceOf(lesson, i))}</p>
    <ol>${tally.map(
      (votes, i) => html`<li><span>${choiceOf(lesson, i)}</span>
      ${bar((100 * votes) / all)}
      <b>${votes}</b><span class="why">${remark(i)}</span></li>`,
    )}</ol></section>`;
}
