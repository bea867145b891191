// Views and caption alone, for the back row of a room: sizes follow the screen's height. Read when it is first wanted.
import { html, nothing } from '../../vendor/lit-html.js';
import { effect } from '../../vendor/signals-core.js';
import { styleSheet } from '../base/api.js';
import { fixed, slower } from '../base/format.js';
import { language, t } from '../base/words.js';
import { renew } from '../draw/palette.js';
import { touch } from '../draw/redraw.js';
import { experiment, frame, lesson, params, place, presented, presenting, speed, status, tradeoff } from '../session/state.js';
import { showAddress } from '../session/params.js';
import { playOrPause } from '../session/time.js';
import { icons } from '../workbench/icons.js';
import { lessons } from './lessons.js';

/** @typedef {import('lit-html').TemplateResult} Template */

/** At 1080 px, and the least, px. @type {Record<string, [number, number]>} */
const SIZES = { '--draw-text': [36, 13], '--draw-axis': [26, 11], '--draw-line': [4.2, 2], '--draw-marker': [44, 20], '--base': [40, 17] };
/** The same around drawings that are a part of the page, as in a class. @type {typeof SIZES} */
const STAGED = {
  ...SIZES,
  '--draw-text': [28, 13],
  '--draw-axis': [26, 13],
  '--draw-line': [3.4, 2],
  '--draw-marker': [36, 20],
  '--base': [30, 15],
};
const HIGH = 1080,
  WIDE = 1500 /* px: a narrower screen has smaller type */,
  FULL = 1920;

/** The style is there: importers wait for it. */
export const ready = styleSheet('present');

function scale() {
  const { style, dataset } = document.documentElement,
    on = presented.peek();
  const staged = place.peek().staged === true,
    part = Math.min(innerHeight / HIGH, innerWidth / (staged ? FULL : WIDE));
  if (on) dataset.present = 'yes';
  else delete dataset.present;
  for (const [name, [size, least]] of Object.entries(staged ? STAGED : SIZES)) {
    if (on) style.setProperty(name, `${Math.max(least, size * part).toFixed(1)}${name === '--base' ? 'px' : ''}`);
    else style.removeProperty(name);
  }
  renew();
  touch();
}

/** @param {boolean} on */
export function present(on) {
  if (presenting.peek() === on) return;
  presenting.value = on;
  showAddress();
  if (on) document.documentElement.requestFullscreen?.().catch(() => {}); /* not everywhere allowed */
  else if (document.fullscreenElement) document.exitFullscreen().catch(() => {});
  queueMicrotask(() => document.getElementById(on ? 'views' : 'present')?.focus());
}

/** What the caption says. @returns {{title: string, text: string, lang: string}} */
function said() {
  if (experiment.value !== null)
    return { title: t(tradeoff.value === null ? 'session.experiments' : 'session.tradeoff'), text: '', lang: language.value };
  if (lesson.value === null) return { title: params.value?.title ?? '', text: params.value?.text ?? '', lang: 'en' };
  return lessons.value?.caption() ?? { title: '', text: '', lang: 'en' };
}

/** @returns {Template} */
function playButton() {
  const playing = status.value === 'playing';
  return html`<output class="slower">${slower(speed.value)}</output><output class="time" id="present-time" aria-live="off"></output>
    <button type="button" aria-label=${t(playing ? 'shell.pause' : 'shell.play')}
      @click=${() => playOrPause()}>${playing ? icons.pause : icons.play}</button>`;
}

/** What stands below the views. @returns {Template} */
export function caption() {
  const { title, text, lang } = said(),
    code = /^#class=(.+)$/.exec(place.value.at)?.[1] ?? '';
  return html`<footer class="foot" aria-label=${t('shell.caption')}><div class="said" lang=${lang}><h1>${title}</h1><p>${text}</p></div>
    ${code === '' ? nothing : html`<span class="letters">${code}</span>`}${experiment.value === null ? playButton() : nothing}
    <button type="button" id="leave" title="Esc" @click=${() => present(false)}>${t('shell.leave')}</button></footer>`;
}

document.addEventListener('keydown', (event) => {
  if (event.code !== 'Escape' || event.defaultPrevented || !presented.peek() || document.querySelector('dialog[open]')) return;
  present(false);
});
let full = false;
document.addEventListener('fullscreenchange', () => {
  /* a browser takes the key Esc for itself when it leaves full screen */
  if (full && document.fullscreenElement === null) present(false);
  full = document.fullscreenElement !== null;
});
effect(() => {
  const now = frame.value,
    clock = document.getElementById('present-time');
  if (now !== null && clock !== null) clock.textContent = `${fixed(now.time_s, 2)} s`;
});
addEventListener('resize', scale);
effect(() => {
  presented.value;
  place.value.staged;
  scale();
});
