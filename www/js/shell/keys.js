// The keyboard from one table; the help dialog shows the same table.
import { byPerson, drive, fire, push } from '../labs/netgame/lab/drive.js';
import { nextSpeed, playOrPause, reset, restart, step } from '../session/time.js';
import { change } from '../session/params.js';
import { experiment, layout, open, overlays, params, singleKeys, theme } from '../session/state.js';
import { showAddress } from '../session/params.js';

/** @typedef {{code: string, alt?: boolean, shift?: boolean, repeat?: boolean, everywhere?: boolean, shown: string, help: string, run: () => void}} Key  everywhere: also where no session is shown */

/** @param {number} player @param {string} name */
function toggle(player, name) {
  const now = params.value?.players?.[player]?.[name];
  if (typeof now === 'boolean') change({ [`players.${player}.${name}`]: !now });
}

/** @param {'ghosts' | 'messages' | 'dots' | 'labels' | 'pings'} name */
export function toggleOverlay(name) {
  overlays.value = { ...overlays.value, [name]: !overlays.value[name] };
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

const TECHNIQUES = ['prediction', 'reconciliation', 'interpolation'];
const technique = (/** @type {number} */ player) =>
  TECHNIQUES.map((name, i) => ({
    code: `Digit${i + 1}`,
    shift: player === 1,
    shown: `${player === 1 ? 'Shift + ' : ''}${i + 1}`,
    help: `${name.charAt(0).toUpperCase()}${name.slice(1)} of ${player === 0 ? 'A' : 'B'}`,
    run: () => toggle(player, name),
  }));

/** @type {Key[]} */
export const KEYS = [
  { code: 'Space', shown: 'Space', help: 'Play or pause', run: playOrPause },
  { code: 'KeyK', alt: true, shown: 'Alt + K', help: 'Play or pause, also with single keys off', run: playOrPause },
  { code: 'Period', repeat: true, shown: '.', help: 'One tick forward', run: () => void step(1) },
  { code: 'Comma', repeat: true, shown: ',', help: 'One tick back', run: () => void step(-1) },
  { code: 'BracketLeft', shown: '[', help: 'Slower', run: () => void nextSpeed(-1) },
  { code: 'BracketRight', shown: ']', help: 'Faster', run: () => void nextSpeed(1) },
  { code: 'KeyR', shown: 'R', help: 'Restart with the same seed', run: () => void restart() },
  { code: 'KeyR', alt: true, shown: 'Alt + R', help: 'Reset everything', run: () => void reset() },
  ...technique(0),
  ...technique(1),
  { code: 'KeyG', shown: 'G', help: 'Ghosts of the ground truth', run: () => toggleOverlay('ghosts') },
  { code: 'KeyM', shown: 'M', help: 'Messages', run: () => toggleOverlay('messages') },
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

/** Driving keys: while a view has the focus, or the player is driven by a person.
 * @type {{code: string, player: number, push: import('../labs/netgame/lab/drive.js').Push}[]} */
export const DRIVING = [
  { code: 'ArrowRight', player: 0, push: 'ahead' },
  { code: 'ArrowLeft', player: 0, push: 'back' },
  { code: 'ArrowUp', player: 0, push: 'up' },
  { code: 'ArrowDown', player: 0, push: 'down' },
  { code: 'Enter', player: 0, push: 'fire' },
  { code: 'KeyD', player: 1, push: 'ahead' },
  { code: 'KeyA', player: 1, push: 'back' },
  { code: 'KeyW', player: 1, push: 'up' },
  { code: 'KeyS', player: 1, push: 'down' },
  { code: 'KeyE', player: 1, push: 'fire' },
];
export const DRIVING_HELP = [
  { shown: 'Left, Right', help: 'Drive A: brake, throttle (cannon: speed). In its view, or if a person controls it' },
  { shown: 'A, D', help: 'Drive B in the same way' },
  { shown: 'Up, Down and W, S', help: 'Cannon: angle of A and of B' },
  { shown: 'Enter and E', help: 'Cannon: fire for A and for B' },
  { shown: 'Arrows and W, A, S, D', help: 'Crates: direction of A and of B' },
  { shown: 'Shift + Left, Right', help: 'In a view: describe the previous or next arrival dot' },
  { shown: 'Esc', help: 'Stop driving: the script takes over; close a dialog' },
];

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

/** The player whose view has the focus; -1 when none has. @param {EventTarget | null} target */
function focusedPlayer(target) {
  const view = target instanceof HTMLElement ? target.closest('[data-drive]') : null;
  return view instanceof HTMLElement ? Number(view.dataset.drive) : -1;
}

/** @type {Map<string, {player: number, push: import('../labs/netgame/lab/drive.js').Push}>} held driving keys */
const down = new Map();

/** @param {KeyboardEvent} event @returns {boolean} */
function driving(event) {
  if (event.altKey || event.ctrlKey || event.metaKey || event.shiftKey) return false;
  const row = DRIVING.find((key) => key.code === event.code);
  const players = layout.value?.players.length ?? 0;
  if (!row || row.player >= players) return false;
  const focused = focusedPlayer(event.target);
  const lane = event.target instanceof HTMLElement && event.target.closest('[data-arrows]') !== null;
  if (lane || (focused !== row.player && !byPerson(row.player))) return false;
  if (row.push === 'fire' && layout.value?.game !== 'cannon') return false;
  if (!event.repeat && row.push === 'fire') {
    fire(row.player);
  } else if (row.push !== 'fire' && (!event.repeat || layout.value?.game === 'cannon')) {
    down.set(event.code, row);
    push(row.player, row.push, true);
  }
  return true;
}

/** @param {KeyboardEvent} event */
function onDown(event) {
  if (event.defaultPrevented || belongsTo(event.target, event.code)) return;
  if (event.code === 'Escape') {
    let any = false;
    for (let p = 0; p < (layout.value?.players.length ?? 0); p++) {
      if (byPerson(p)) {
        drive(p, false);
        any = true;
      }
    }
    if (any && event.target instanceof HTMLElement) event.target.blur();
    return;
  }
  if (singleKeys.value && driving(event)) {
    event.preventDefault();
    return;
  }
  if (event.ctrlKey || event.metaKey) return;
  const key = KEYS.find((row) => row.code === event.code && !!row.alt === event.altKey && !!row.shift === event.shiftKey);
  if (experiment.value !== null && !key?.everywhere) return;
  if (!key || (!key.alt && !singleKeys.value) || (event.repeat && !key.repeat)) return;
  event.preventDefault();
  key.run();
}

/** @param {KeyboardEvent} event */
function onUp(event) {
  const row = down.get(event.code);
  if (!row) return;
  down.delete(event.code);
  push(row.player, row.push, false);
}

export function listen() {
  document.addEventListener('keydown', onDown);
  document.addEventListener('keyup', onUp);
}
