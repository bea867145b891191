// The race of the first page: two views, three controls, and one line that says what was felt and what to try next.
import { html, nothing } from '../../../../vendor/lit-html.js';
import { signal } from '../../../../vendor/signals-core.js';
import { fixed } from '../../../base/format.js';
import { writeLesson } from '../../../base/link.js';
import { rich, t } from '../../../base/words.js';
import { lesson, locked, params } from '../../../session/state.js';
import { icons } from '../../../workbench/icons.js';
import { mark } from '../../../workbench/player_mark.js';
import { START } from './start.js';
import { lineOf, valid } from './felt.js';
import { held, hold } from './pedals.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('./felt.js').Settings} Settings */

const FIRST_MS = Number(START.set['players.0.lag_ms']);

/** What has been felt, and the newest press of it. @type {import('@preact/signals-core').Signal<{felt: import('./felt.js').Felt,
 * last: import('./felt.js').Press | null}>} */
export const measured = signal({ felt: {}, last: null });
/** s: how old the other car is. */
export const age = signal(0);

/** @returns {Settings} */
export function settings() {
  const { lag_ms: lag = FIRST_MS, prediction: predict = false, reconciliation: correct = false } = params.value?.players?.[0] ?? {};
  return { lag, predict, correct };
}

/** The line that holds now. */
export const line = () => lineOf(measured.value.felt, settings(), FIRST_MS);

const SECONDS = 2; /* digits after the point */

/** As the driver knows it. @param {'ahead' | 'back'} way */
const nameOf = (way) => (held.value.by === 'pads' ? t(way === 'ahead' ? 'front.go' : 'front.brake') : way === 'ahead' ? '→' : '←');

/** @returns {Template} */
function said() {
  const { key, done } = line(),
    { felt, last } = measured.value,
    { lag } = settings();
  const values = {
    s: fixed(last?.latency ?? 0, SECONDS),
    lag: fixed(lag, 0),
    age: fixed(age.value, SECONDS),
    key: nameOf('ahead'),
    held: nameOf(last?.way || 'ahead'),
  };
  const again = t(held.value.ahead || held.value.back ? 'front.release' : 'front.hold', values);
  const next = key.startsWith('stays')
    ? html` <a href=${writeLesson({ id: 'in_the_past', step: 1, lang: lesson.value?.lang ?? '' })}>${t('front.why')}</a>`
    : nothing;
  const steps = [felt.none, felt.predict, felt.both];
  return html`<ol class="beads" aria-label=${t('front.steps', { n: done, of: steps.length })}>${steps.map(
    (one, i) => html`<li data-done=${one ? 'yes' : 'no'} aria-hidden="true">${one ? icons.done : i + 1}</li>`,
  )}</ol>
    <div role="status" aria-live="polite" id="front-line" data-line=${key}><p>${t(`front.${key}.was`, values)}</p>
      <p class="do">${t(`front.${key}.do`, { ...values, again })}${next}</p></div>`;
}

/** @param {'prediction' | 'reconciliation'} name @param {string} key of its words @param {boolean} lit @param {boolean} off
 * @returns {Template} */
function technique(name, key, lit, off) {
  const needs = off ? html`<span class="needs">${icons.lock}${t('front.needs')}</span>` : nothing;
  return html`<label class="technique" data-lit=${lit ? 'yes' : 'no'} data-off=${off ? 'yes' : 'no'}><input type="checkbox" role="switch"
      data-path=${`players.0.${name}`} ?disabled=${off || locked.value !== ''}><span class="switch" aria-hidden="true"></span>
    <span class="named"><b>${t(`front.${key}`)}</b><small>${t(`front.${key}.says`)}</small></span>
    ${lit ? html`<span class="try">${t('front.try')}</span>` : needs}</label>`;
}

const PLACES = ['front.lag.room', 'front.lag.earth', 'front.lag.satellite', 'front.lag.most']; /* where, the style sheet says */

/** @returns {Template} */
function lag() {
  const { lag: now } = settings();
  return html`<div class="lagrow"><label for="front-lag">${t('front.lag')}</label><output>${fixed(now, 0)} <small>ms</small></output>
    <input id="front-lag" type="range" min="0" max="500" step="1" data-path="players.0.lag_ms" ?disabled=${locked.value !== ''}
      aria-valuetext=${`${fixed(now, 0)} ms`} @pointerup=${
        (/** @type {Event} */ event) => /** @type {HTMLElement} */ (event.currentTarget).blur() /* the arrows then drive again */
      }>
    <div class="places" aria-hidden="true">${PLACES.map((key) => html`<span>${t(key)}</span>`)}</div></div>`;
}

/** @param {'back' | 'ahead'} way @param {string} key @param {Template} icon @returns {Template} */
function pedal(way, key, icon) {
  const on = hold(way);
  return html`<button type="button" class="pedal" data-way=${way} aria-pressed=${held.value[way]} ?disabled=${locked.value !== ''}
    @pointerdown=${on.down} @pointerup=${on.up} @pointercancel=${on.up} @lostpointercapture=${on.up}
    @keydown=${on.key} @keyup=${on.up} @blur=${on.up} @contextmenu=${(/** @type {Event} */ event) => event.preventDefault()}>
    ${icon}<span>${t(key)}</span></button>`;
}

/** @param {number} view @param {Template} head @returns {Template} */
const screen = (view, head) => html`<section class="screen" data-of=${view === 0 ? 'server' : 'you'}><div class="name">${head}</div>
    <div class="view"><canvas data-view=${view} role="img" aria-label=${t(view === 0 ? 'front.server' : 'front.yours')}></canvas></div>
  </section>`;

/** @returns {Template} */
export function race() {
  const { lit } = line(),
    { predict, correct } = settings(),
    last = valid(measured.value.last, settings());
  const answered = html`<span class="answer"><span>${t('front.answered')}</span> <output id="front-latency">${
    last === null ? '–' : `${fixed(last.latency, SECONDS)} s`
  }</output> <span class="late">${t('front.answered.short')}</span></span>`;
  return html`<section class="drive" aria-labelledby="drive-title">
    <h2 id="drive-title">${t('front.title')}</h2>
    <div class="saying">${said()}</div>
    <div class="screens">
      ${screen(1, html`<h3>${mark(0)} ${t('front.yours')}</h3><small>${t('front.yours.keys')}</small>${answered}`)}
      ${screen(
        0,
        html`<h3><svg class="mark" data-player="server" viewBox="0 0 18 18" aria-hidden="true"><path d="M9 1l8 8-8 8-8-8z"></path></svg>
          ${t('front.server')}</h3><small>${t('front.server.says')}</small>`,
      )}
    </div>
    <div class="controls">${lag()}
      ${technique('prediction', 'predict', lit === 'predict', false)}
      ${technique('reconciliation', 'correct', lit === 'correct', !predict && !correct)}
      <div class="pedals">${pedal('back', 'front.brake', icons.left)}${pedal('ahead', 'front.go', icons.right)}
        <p>${rich('front.friend', { a: html`<kbd>A</kbd>`, d: html`<kbd>D</kbd>` })}</p></div>
    </div></section>`;
}
