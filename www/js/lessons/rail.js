// A lesson: its steps next to the lab's views.
import { html, nothing } from '../../vendor/lit-html.js';
import { part } from '../base/api.js';
import { digits } from '../base/words.js';
import { openLesson, toSandbox } from '../session/session.js';
import { frame, lesson, params, status } from '../session/state.js';
import { control } from '../session/time.js';
import { next } from './door.js';
import { highlighted, lock, settings } from './controls.js';
import {
  CHANGE,
  SKIPPED,
  STEPS,
  choice,
  choose,
  ended,
  go,
  headingOf,
  jump,
  missing,
  opened,
  printing,
  reached,
  restart,
  run,
  runAgain,
  textOf,
  unlocked,
} from './steps.js';
import { amount, filled, language, ready, word } from './words.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('./steps.js').Lesson} Lesson */

const print = () => part(() => import('./paper.js')).then((paper) => paper.print());

/** @param {Lesson} of @param {import('./steps.js').Choice} one @returns {string} */
const labelOf = (of, one) => one.label?.[language.value] ?? amount(one.value, of.answer.unit);

/** @param {number} step @returns {Template} */
function bars(step) {
  return html`<ol class="steps">${STEPS.map(
    (name, i) => html`<li><button type="button" aria-current=${step === i + 1 ? 'step' : nothing} data-done=${i < step ? 'yes' : 'no'}
      ?disabled=${i + 1 > reached.value} @click=${() => go(i + 1)}>${word(`steps.${name}`)}</button></li>`,
  )}</ol>`;
}

/** @param {Lesson} of @returns {Template} */
function predict(of) {
  return html`<p>${textOf(of, 1)}</p>
    <div class="options" role="radiogroup" aria-label=${word('predict.group')}>${of.choices.map(
      (one, i) => html`<label class="option"><input type="radio" name="answer" value=${i} .checked=${choice.value === i}
        @change=${() => choose(i)}><b>${labelOf(of, one)}</b><kbd aria-hidden="true">${i + 1}</kbd></label>`,
    )}</div>
    <button type="button" class="main" id="lock-in" ?disabled=${choice.value === null} @click=${() => run()}>${
      choice.value === null ? word('predict.first') : word('predict.go')
    }</button>
    <button type="button" class="link" @click=${() => {
      choose(SKIPPED);
      run();
    }}>${word('predict.skip')}</button>`;
}

/** What was predicted. @param {Lesson} of @returns {string} */
function said(of) {
  const one = of.choices[choice.value ?? SKIPPED];
  return one ? labelOf(of, one) : word('explain.none');
}

/** @param {Lesson} of @returns {Template} */
function running(of) {
  return html`<p>${textOf(of, 2)}</p>
    <dl class="pair"><div><dt>${word('explain.said')}</dt><dd>${said(of)}</dd></div></dl>
    ${status.value === 'playing' ? nothing : html`<button type="button" class="main" @click=${() => run()}>${word('run.go')}</button>`}
    <button type="button" class="link" @click=${() => jump()}>${word('run.jump')}</button>`;
}

/** Other ticks at which the same happens. @param {Lesson} of @returns {Template | typeof nothing} */
function moments({ moments: all }) {
  if (!all) return nothing;
  const { ticks, text } = all,
    now = frame.value?.tick ?? 0,
    at = Math.max(0, ticks.filter((tick) => tick <= now).length - 1);
  const to = (/** @type {number} */ i) => html`<button type="button" aria-label=${word(i < at ? 'moments.before' : 'moments.next')}
    ?disabled=${ticks[i] === undefined} @click=${() => control({ op: 'seek', tick: ticks[i] })}>${i < at ? '◂' : '▸'}</button>`;
  return html`<div class="moments" role="group" aria-label=${text[language.value]}><span>${text[language.value]}</span>${to(at - 1)}<span
    aria-live="polite">${word('moments.at', { n: at + 1, of: ticks.length })}</span>${to(at + 1)}</div>`;
}

/** What was predicted, and what it was. @param {Lesson} of @returns {Template} */
function answers(of) {
  const right = of.choices.find((one) => one.right),
    label = right?.label ? `${right.label[language.value]} ` : '';
  return html`<dl class="pair"><div><dt>${word('explain.said')}</dt><dd>${said(of)}</dd></div>
      <div class="result"><dt>${word('explain.was')}</dt><dd id="answer">${label}${amountOf(of.answer)}</dd></div></dl>`;
}

/** @param {Lesson} of @returns {Template} */
function observe(of) {
  return html`${of.line ? answers(of) : nothing}<p>${textOf(of, 3)}</p>${highlighted()}${moments(of)}
    <button type="button" class="main" @click=${() => go(4)}>${word('steps.explain')}</button>`;
}

/** @param {import('./steps.js').Answer} one */
const amountOf = ({ value, unit }) => amount(value, unit);

/** @param {Lesson} of @returns {Template} */
function explain(of) {
  const mine = of.choices[choice.value ?? SKIPPED] ?? of.choices.find((one) => one.right);
  return html`${answers(of)}
    ${mine ? html`<p class="why">${filled(mine.why, of.numbers)}</p>` : nothing}
    <p>${textOf(of, 4)}</p>${highlighted()}${moments(of)}
    ${of.erratum ? html`<p class="faint" id="erratum"><b>${word('erratum')}</b> ${filled(of.erratum, of.numbers)}</p>` : nothing}
    <button type="button" class="main" @click=${() => go(5)}>${word('steps.change')}</button>`;
}

/** @param {Lesson} of @returns {Template} */
function change(of) {
  const following = next(of),
    to = (/** @type {string} */ id) => openLesson({ id, step: 1, lang: lesson.value?.lang ?? '' }, true);
  const done = ended(of);
  return html`<p>${textOf(of, 5)}</p>
    <dl class="pair"><div><dt>${word('change.before')}</dt><dd>${amountOf(of.answer)}</dd></div>
      <div class="result"><dt>${word('change.after')}</dt><dd id="changed">${amountOf(of.change.answer)}</dd></div></dl>
    ${settings(of)}
    <p class="faint seed">${
      of.change.stop_tick === undefined || of.change.speed === undefined
        ? word('change.seed', { seed: of.seed })
        : word('change.seed_to', { seed: of.seed, time: digits(of.change.stop_tick / Number(params.value?.tick_hz ?? 60), 0, 1) })
    }</p>
    ${
      status.value === 'playing'
        ? nothing
        : html`<button type="button" class="main" id=${done ? 'next' : nothing} @click=${() => (done ? to(following?.id ?? '') : run())}>${
            !done ? word('change.go') : following ? word('next', { title: following.title[language.value] }) : word('all')
          }</button>`
    }
    <div class="after">${
      done ? html`<button type="button" class="link" @click=${() => runAgain()}>${word('change.again')}</button>` : nothing
    }<button type="button" class="link" @click=${() => toSandbox()}>${word('free')}</button>
      <button type="button" class="link" @click=${() => restart()}>${word('again')}</button>
      ${done && !following ? nothing : html`<button type="button" class="link" @click=${() => to('')}>${word('all')}</button>`}</div>`;
}

const BODIES = [predict, running, observe, explain, change];

/** What is said below the views where they are shown alone. @returns {{title: string, text: string, lang: string}} */
export function caption() {
  const now = opened.value,
    step = lesson.value?.step ?? 1;
  return { title: now?.title[language.value] ?? '', text: now === null || !ready.value ? '' : textOf(now, step), lang: language.value };
}

/** The question, where another heading has its place. @param {Lesson} of @param {number} step */
const asked = ({ title, headings }, step) =>
  headings?.[/** @type {'observe'} */ (STEPS[step - 1])] ? html`<small class="faint asked">${title[language.value]}</small>` : nothing;

/** @param {Template} views of the lab @returns {Template} */
export function page(views) {
  const now = opened.value,
    step = lesson.value?.step ?? 1,
    body = BODIES[step - 1];
  return html`<div class="teach" data-step=${step} data-at=${now?.look.at ?? ''} data-look=${now?.look.player ?? ''}
    data-locked=${unlocked.value ? 'no' : 'yes'}>
    <section class="rail" id="rail" aria-labelledby="lesson-step" lang=${language.value}>
    ${
      now === null || !ready.value || !body
        ? html`<h2 id="lesson-step">${missing.value ? word('failed') : word('loading') || '…'}</h2>`
        : html`${bars(step)}<h2 id="lesson-step" tabindex="-1">${headingOf(now, step)}</h2>
          ${asked(now, step)}
          ${body(now)}${step === CHANGE ? nothing : settings(now)}
          ${lock(
            html`<button type="button" class="link" id="print" ?disabled=${printing.value} @click=${print}>${word('paper.print')}</button>`,
          )}`
    }</section>${views}</div>`;
}
