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

/** Step again and again while the button is held. @param {number} ticks */
function hold(ticks) {
  /** @type {ReturnType<typeof setInterval> | undefined} */
  let timer;
  const stop = () => clearInterval(timer);
  return {
    click: () => void step(ticks),
    down: () => {
      stop();
      const from = performance.now();
      timer = setInterval(() => {
        if (performance.now() - from > 400) step(ticks);
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

/** @returns {Template} */
export function timeBar() {
  const off = locked.value !== '';
  const playing = status.value === 'playing';
  const replay = status.value === 'ended',
    label = playing ? t('shell.pause') : replay ? t('shell.replay') : t('shell.play');
  const now = speed.value;
  const speeds = SPEEDS.includes(now) ? SPEEDS : [...SPEEDS, now].sort((a, b) => a - b);
  return html`<footer class="bar" title=${locked.value || nothing}>${held.value === '' ? nothing : html`<p class="held">${held.value}</p>`}
    <fieldset ?disabled=${off}><legend class="unseen">${t('shell.time')}</legend>
    <button type="button" class="big" aria-label=${t('shell.tick_back')} ?disabled=${!may('time.step')} title=${`${t('shell.tick_back')} ( , )`} @click=${back.click} @pointerdown=${back.down}
      @pointerup=${back.stop} @pointerleave=${back.stop}>${icons.back}</button>
    <button type="button" class="big play" id="play" ?disabled=${!may('time.play')} aria-label=${label} title=${`${label} (${t('shell.space')})`} @click=${() => playOrPause()}>
      ${playing ? icons.pause : icons.play}${replay ? html`<span>${label}</span>` : nothing}</button>
    <button type="button" class="big" aria-label=${t('shell.tick_forward')} ?disabled=${!may('time.step')} title=${`${t('shell.tick_forward')} ( . )`} @click=${forward.click}
      @pointerdown=${forward.down} @pointerup=${forward.stop} @pointerleave=${forward.stop}>${icons.forward}</button>
    <label class="field choice speed"><span>${t('shell.speed')}</span><select aria-label=${t('shell.speed')} ?disabled=${!may('time.speed')}
      @change=${(/** @type {Event} */ event) => setSpeed(Number(/** @type {HTMLSelectElement} */ (event.target).value))}>
      ${speeds.map((s) => html`<option value=${s} .selected=${s === now}>${digits(s, 0, 7)}×</option>`)}</select></label>
    <output class="slower" id="slower">${slower(now)}</output>
    <input type="range" class="scrub" id="scrub" ?disabled=${!may('time.seek')} aria-label=${t('shell.time_s')} min="0" max="1" step="any" value="0" @input=${onScrub}
      @change=${() => {
        scrubbing = false;
      }}>
    <output class="clock" aria-live="off"><span id="clock"></span><span id="ticks"></span></output>
    <button type="button" class="restart" ?disabled=${!may('time.restart')} title=${`${t('shell.restart_tip')} (R)`} @click=${() => restart()}>${t('shell.restart')}</button>
    <button type="button" class="reset" title=${`${t('shell.reset_tip')} (Alt + R)`} ?disabled=${!may('time.reset')} @click=${() => reset()}>${t('shell.reset')}</button>
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
