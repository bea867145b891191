// The time bar: play, step, speed, scrub, clock.
import { headOf } from '../stream/frame.js';
import { html, nothing } from '../../vendor/lit-html.js';
import { fixed, slower } from '../base/format.js';
import { icons } from '../workbench/icons.js';
import { fullScreen } from './keys.js';
import { toggle } from './presenting.js';
import { held, locked, speed, status } from '../session/state.js';
import { SPEEDS, playOrPause, reset, restart, seek, setSpeed, step } from '../session/time.js';

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
  const label = playing ? 'Pause' : status.value === 'ended' ? 'Replay' : 'Play';
  const now = speed.value;
  const speeds = SPEEDS.includes(now) ? SPEEDS : [...SPEEDS, now].sort((a, b) => a - b);
  return html`<footer class="bar" title=${locked.value || nothing}>${held.value === '' ? nothing : html`<p class="held">${held.value}</p>`}
    <fieldset ?disabled=${off}><legend class="unseen">Time</legend>
    <button type="button" class="big" aria-label="One tick back" title="One tick back ( , )" @click=${back.click} @pointerdown=${back.down}
      @pointerup=${back.stop} @pointerleave=${back.stop}>${icons.back}</button>
    <button type="button" class="big play" id="play" aria-label=${label} title=${`${label} (Space)`} @click=${() => playOrPause()}>
      ${playing ? icons.pause : icons.play}${label === 'Replay' ? html`<span>Replay</span>` : nothing}</button>
    <button type="button" class="big" aria-label="One tick forward" title="One tick forward ( . )" @click=${forward.click}
      @pointerdown=${forward.down} @pointerup=${forward.stop} @pointerleave=${forward.stop}>${icons.forward}</button>
    <label class="field choice speed"><span>Speed</span><select aria-label="Speed"
      @change=${(/** @type {Event} */ event) => setSpeed(Number(/** @type {HTMLSelectElement} */ (event.target).value))}>
      ${speeds.map((s) => html`<option value=${s} .selected=${s === now}>${s}×</option>`)}</select></label>
    <output class="slower" id="slower">${slower(now)}</output>
    <input type="range" class="scrub" id="scrub" aria-label="Time in seconds" min="0" max="1" step="any" value="0" @input=${onScrub}
      @change=${() => {
        scrubbing = false;
      }}>
    <output class="clock" aria-live="off"><span id="clock"></span><span id="ticks"></span></output>
    <button type="button" class="restart" title="Start again with the same seed (R)" @click=${() => restart()}>Restart</button>
    <button type="button" title="Restore the scenario (Alt + R)" @click=${() => reset()}>Reset</button>
    </fieldset>
    <button type="button" class="wide quiet big" id="present" aria-label="Present" title="Present: views and caption alone (V)"
      @click=${() => void toggle()}>${icons.present}</button>
    <button type="button" class="wide quiet big" aria-label="Full screen" title="Full screen (F)"
      @click=${fullScreen}>${icons.full}</button>
  </footer>`;
}

/** @param {number} time @param {number | null} tick */
function showClock(time, tick) {
  const clock = document.getElementById('clock'),
    ticks = document.getElementById('ticks');
  if (clock) clock.textContent = `${fixed(time, 2)} s`;
  if (ticks && tick !== null) ticks.textContent = ` · tick ${tick}`;
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
  const text = `${fixed(frame.time_s, 1)} of ${fixed(end, 1)} seconds`;
  if (frame.tick % 30 === 0 || scrub.getAttribute('aria-valuetext') === null) scrub.setAttribute('aria-valuetext', text);
}
