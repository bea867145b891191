// The keyboard from tables: those of the page, and those of the lab that is shown. The help dialog shows the same tables.
import { signal } from '../../vendor/signals-core.js';
import { lab } from '../session/labs.js';
import { showAddress } from '../session/params.js';
import { experiment, theme } from '../session/state.js';
import { nextSpeed, playOrPause, reset, restart, step } from '../session/time.js';
import { open } from '../workbench/dialog.js';
import { lessons } from './lessons.js';
import { toggle } from './presenting.js';

/** @typedef {import('../session/lab.js').Key} Key */

/** Kept in the browser, not in the address: a person's habit. */
export const singleKeys = signal(readSingleKeys());

function readSingleKeys() {
  try {
    return localStorage.getItem('laglab.keys') !== 'off';
  } catch {
    return true;
  }
}

/** @param {boolean} on */
export function setSingleKeys(on) {
  singleKeys.value = on;
  try {
    localStorage.setItem('laglab.keys', on ? 'on' : 'off');
  } catch {
    /* the choice then lasts as long as the page */
  }
}

/** @param {string} name */
export function setTheme(name) {
  theme.value = name;
  showAddress();
}

export function fullScreen() {
  if (document.fullscreenElement) document.exitFullscreen();
  else document.documentElement.requestFullscreen?.().catch(() => {});
}

/** @type {Key[]} */
const OF_TIME = [
  { code: 'Space', shown: 'Space', help: 'Play or pause', run: playOrPause },
  { code: 'KeyK', alt: true, shown: 'Alt + K', help: 'Play or pause, also with single keys off', run: playOrPause },
  { code: 'Period', repeat: true, shown: '.', help: 'One tick forward', run: () => void step(1) },
  { code: 'Comma', repeat: true, shown: ',', help: 'One tick back', run: () => void step(-1) },
  { code: 'BracketLeft', shown: '[', help: 'Slower', run: () => void nextSpeed(-1) },
  { code: 'BracketRight', shown: ']', help: 'Faster', run: () => void nextSpeed(1) },
  { code: 'KeyR', shown: 'R', help: 'Restart with the same seed', run: () => void restart() },
  { code: 'KeyR', alt: true, shown: 'Alt + R', help: 'Reset everything', run: () => void reset() },
];

/** @type {Key[]} */
const OF_PAGE = [
  { code: 'KeyV', everywhere: true, shown: 'V', help: 'Present: views and caption alone', run: () => void toggle() },
  { code: 'KeyF', everywhere: true, shown: 'F', help: 'Full screen', run: fullScreen },
  {
    code: 'KeyP',
    everywhere: true,
    shown: 'P',
    help: 'Projector colours',
    run: () => setTheme(theme.value === 'projector' ? 'auto' : 'projector'),
  },
  { code: 'Slash', shift: true, everywhere: true, shown: '?', help: 'This help', run: () => open({ kind: 'help' }) },
];

/** Those that do something now. */
export const keys = () => [...OF_TIME, ...(lab.value?.keys ?? []), ...OF_PAGE].filter((key) => experiment.value === null || key.everywhere);

/** Where letters are text, or keys have a meaning of their own. @param {EventTarget | null} target @param {string} code */
function belongsTo(target, code) {
  if (!(target instanceof HTMLElement)) return false;
  if (target.closest('dialog[open]')) return true;
  if (target instanceof HTMLSelectElement || target instanceof HTMLTextAreaElement || target.isContentEditable) return true;
  if (target instanceof HTMLInputElement) {
    return target.type === 'checkbox' ? code === 'Space' : true;
  }
  const pressed = target.closest('button, a, summary') !== null;
  return pressed && (code === 'Space' || code === 'Enter');
}

/** @param {KeyboardEvent} event */
function onDown(event) {
  if (event.defaultPrevented) return;
  if (singleKeys.value && lessons.value?.press(event)) return event.preventDefault();
  if (belongsTo(event.target, event.code)) return;
  if ((singleKeys.value || event.code === 'Escape') && lab.value?.press?.(event)) return;
  if (event.ctrlKey || event.metaKey) return;
  const key = keys().find((row) => row.code === event.code && !!row.alt === event.altKey && !!row.shift === event.shiftKey);
  if (!key || (!key.alt && !singleKeys.value) || (event.repeat && !key.repeat)) return;
  event.preventDefault();
  key.run();
}

export function listen() {
  document.addEventListener('keydown', onDown);
  document.addEventListener('keyup', (event) => lab.value?.release?.(event));
}
