// The keyboard from tables: those of the page, and those of the lab that is shown. The help dialog shows the same tables.
import { signal } from '../../vendor/signals-core.js';
import { lab } from '../session/labs.js';
import { showAddress } from '../session/params.js';
import { experiment, lesson, theme } from '../session/state.js';
import { nextSpeed, playOrPause, reset, restart, step } from '../session/time.js';
import { t } from '../base/words.js';
import { open } from '../workbench/dialog.js';
import { used } from './hint.js';
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

/** help: key of its words. @type {Key[]} */
const OF_TIME = [
  { code: 'Space', shown: 'Space', help: 'shell.play_pause', run: playOrPause },
  { code: 'KeyK', alt: true, shown: 'Alt + K', help: 'shell.play_pause_always', run: playOrPause },
  { code: 'Period', repeat: true, shown: '.', help: 'shell.tick_forward', run: () => void step(1) },
  { code: 'Comma', repeat: true, shown: ',', help: 'shell.tick_back', run: () => void step(-1) },
  { code: 'BracketLeft', shown: '[', help: 'shell.slower', run: () => void nextSpeed(-1) },
  { code: 'BracketRight', shown: ']', help: 'shell.faster', run: () => void nextSpeed(1) },
  { code: 'KeyR', shown: 'R', help: 'shell.restart_key', run: () => void restart() },
  { code: 'KeyR', alt: true, shown: 'Alt + R', help: 'shell.reset_key', run: () => void reset() },
];

/** As above. @type {Key[]} */
const OF_PAGE = [
  { code: 'KeyV', everywhere: true, shown: 'V', help: 'shell.present_tip', run: () => void toggle() },
  { code: 'KeyF', everywhere: true, shown: 'F', help: 'shell.full', run: fullScreen },
  {
    code: 'KeyP',
    everywhere: true,
    shown: 'P',
    help: 'shell.projector',
    run: () => setTheme(theme.value === 'projector' ? 'auto' : 'projector'),
  },
  { code: 'Slash', shift: true, everywhere: true, shown: '?', help: 'shell.this_help', run: () => open({ kind: 'help' }) },
];

const told = (/** @type {Key} */ key) => ({ ...key, shown: key.code === 'Space' ? t('shell.space') : key.shown, help: t(key.help) });
/** Those that do something now. The first page has no time of its own. */
export const keys = () =>
  [...OF_TIME.map(told), ...(lab.value?.keys ?? []), ...OF_PAGE.map(told)].filter(
    (key) => (experiment.value === null && lesson.value?.id !== '') || key.everywhere,
  );

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
  if ((singleKeys.value || event.code === 'Escape') && lab.value?.press?.(event)) return used();
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
