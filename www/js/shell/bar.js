// The time bar: play, step, speed, scrub, clock.
import { headOf } from '../stream/frame.js';
import { html, nothing } from '../../vendor/lit-html.js';
import { fixed, slower } from '../base/format.js';
import { icons } from '../workbench/icons.js';
import { fullScreen } from './keys.js';
import { toggle } from './presenting.js';
import { held, locked, may, speed, status } from '../session/state.js';
import { SPEEDS, playOrPause, reset, restart, seek, setSpeed, step } from '../session/time.js';
import { digits, t } from '../base/words.js';

/** @typedef {import('lit-html').TemplateResult} Template */

let scrubbing = false;
const LONG_S = 180; /* a longer session is scrubbed up to its head only */

/** Step again and again while the button is held: then the click of its release is no step. @param {number} ticks */
function hold(ticks) {
  /** @type {ReturnType<typeof setInterval> | undefined} */
  let timer;
  let repeated = false;
  const stop = () => clearInterval(timer);
  return {
    click: (/** @type {MouseEvent} */ { detail }) => {
      if (detail === 0 /* of a key */ || !repeated) step(ticks);
    },
    down: () => {
      stop();
      repeated = false;
      const from = performance.now();
      timer = setInterval(() => {
        if (performance.now() - from <= 400) return;
        repeated = true;
        step(ticks);
      }, 60);
    },
    stop,
  };
}
const back = hold(-1),
  forward = hold(1);

/** @param {Event} event */
function onScrub(event) {
  scrubbing = true;
  const value = /** @type {HTMLInputElement} */ (event.target).valueAsNumber;
  showClock(value, null);
  seek(value);
}

/** Again and again while it is held. @param {ReturnType<typeof hold>} of @param {string} name @param {string} key @param {Template} icon */
const stepButton = (of, name, key, icon) => html`<button type="button" class="big" aria-label=${name} title=${`${name} ( ${key} )`}
      ?disabled=${!may('time.step')} @click=${of.click}
      @pointerdown=${of.down} @pointerup=${of.stop} @pointerleave=${of.stop}>${icon}</button>`;

/** @returns {Template} */
function playButton() {
  const playing = status.value === 'playing',
    replay = status.value === 'ended',
    label = playing ? t('shell.pause') : replay ? t('shell.replay') : t('shell.play');
  return html`<button type="button" class="big play" id="play" aria-label=${label} title=${`${label} (${t('shell.space')})`}
      ?disabled=${!may('time.play')} @click=${() => playOrPause()}>
      ${playing ? icons.pause : icons.play}${replay ? html`<span>${label}</span>` : nothing}</button>`;
}

/** @returns {Template} */
function speedChoice() {
  const now = speed.value,
    speeds = SPEEDS.includes(now) ? SPEEDS : [...SPEEDS, now].sort((a, b) => a - b);
  return html`<label class="field choice speed"><span>${t('shell.speed')}</span><select aria-label=${t('shell.speed')}
      ?disabled=${!may('time.speed')}
      @change=${(/** @type {Event} */ event) => setSpeed(Number(/** @type {HTMLSelectElement} */ (event.target).value))}>
      ${speeds.map((s) => html`<option value=${s} .selected=${s === now}>${digits(s, 0, 7)}×</option>`)}</select></label>
    <output class="slower" id="slower">${slower(now)}</output>`;
}

const onScrubbed = () => {
  scrubbing = false;
};
const scrubber = () => html`<input type="range" class="scrub" id="scrub" ?disabled=${!may('time.seek')} aria-label=${t('shell.time_s')}
      min="0" max="1" step="any" value="0" @input=${onScrub} @change=${onScrubbed}>`;

/** @param {'restart' | 'reset'} name @param {string} keys @param {() => unknown} act */
const beginning = (name, keys, act) => html`<button type="button" class=${name} title=${`${t(`shell.${name}_tip`)} (${keys})`}
      ?disabled=${!may(`time.${name}`)} @click=${() => act()}>${t(`shell.${name}`)}</button>`;

/** @returns {Template} */
export function timeBar() {
  return html`<footer class="bar" title=${locked.value || nothing}>${held.value === '' ? nothing : html`<p class="held">${held.value}</p>`}
    <fieldset ?disabled=${locked.value !== ''}><legend class="unseen">${t('shell.time')}</legend>
    ${stepButton(back, t('shell.tick_back'), ',', icons.back)}
    ${playButton()}
    ${stepButton(forward, t('shell.tick_forward'), '.', icons.forward)}
    ${speedChoice()}
    ${scrubber()}
    <output class="clock" aria-live="off"><span id="clock"></span><span id="ticks"></span></output>
    ${beginning('restart', 'R', restart)}
    ${beginning('reset', 'Alt + R', reset)}
    </fieldset>
    <button type="button" class="wide quiet big" id="present" aria-label=${t('shell.present')} title=${`${t('shell.present_tip')} (V)`}
      @click=${() => void toggle()}>${icons.present}</button>
    <button type="button" class="wide quiet big" aria-label=${t('shell.full')} title=${`${t('shell.full')} (F)`}
      @click=${fullScreen}>${icons.full}</button>
  </footer>`;
}

/** @param {number} time @param {number | null} tick */
function showClock(time, tick) {
  const clock = document.getElementById('clock'),
    ticks = document.getElementById('ticks');
  if (clock) clock.textContent = t('shell.seconds', { s: fixed(time, 2) });
  if (ticks && tick !== null) ticks.textContent = ` · ${t('shell.tick', { n: tick })}`;
}

/** @param {import('../stream/frame.js').Frame} frame */
export function showTime(frame) {
  const scrub = document.getElementById('scrub');
  if (!(scrub instanceof HTMLInputElement)) return;
  if (scrubbing) return;
  showClock(frame.time_s, frame.tick);
  const end = frame.session.duration_s > 0 && frame.session.duration_s <= LONG_S ? frame.session.duration_s : Math.max(headOf(frame), 1);
  if (Number(scrub.max) !== end) scrub.max = String(end);
  scrub.valueAsNumber = frame.time_s;
  const text = t('shell.scrubbed', { s: fixed(frame.time_s, 1), end: fixed(end, 1) });
  if (frame.tick % 30 === 0 || scrub.getAttribute('aria-valuetext') === null) scrub.setAttribute('aria-valuetext', text);
}
