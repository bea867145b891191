// The keys of a netgame: techniques, overlays, and those that drive.
import { change } from '../../../session/params.js';
import { mayDrive, params, place, usable } from '../../../session/state.js';
import { t } from '../../../base/words.js';
import { layout } from '../core/layout.js';
import { toggleOverlay } from '../core/state.js';
import { byPerson, drive, fire, push } from './drive.js';
import { toggle as togglePacket } from './follow.js';

/** @param {number} player @param {string} name */
function toggle(player, name) {
  const now = params.value?.players?.[player]?.[name];
  if (typeof now === 'boolean') change({ [`players.${player}.${name}`]: !now });
}

const TECHNIQUES = ['prediction', 'reconciliation', 'interpolation'];
const technique = (/** @type {number} */ player) =>
  TECHNIQUES.map((name, i) => ({
    code: `Digit${i + 1}`,
    shift: player === 1,
    get shown() {
      return player === 1 ? t('netgame.key.shift', { key: i + 1 }) : String(i + 1);
    },
    get help() {
      return t('netgame.key.technique', { name: t(`netgame.${name}`), player: player === 0 ? 'A' : 'B' });
    },
    run: () => toggle(player, name),
  }));

/** A key by its letter. @param {string} code @param {string} name @param {() => void} run */
const key = (code, name, run) => ({
  code,
  shown: code.slice(3),
  run,
  get help() {
    return t(`netgame.key.${name}`);
  },
});

/** @type {import('../../../session/lab.js').Key[]} */
export const KEYS = [
  ...technique(0),
  ...technique(1),
  key('KeyG', 'ghosts', () => void (usable('view.ghosts') && toggleOverlay('ghosts'))),
  key('KeyM', 'messages', () => void (usable('view.messages') && toggleOverlay('messages'))),
  key('KeyN', 'packet', togglePacket),
];

/** Driving keys: they work wherever the focus is, but in fields.
 * @type {{code: string, player: number, push: import('./drive.js').Push}[]} */
const DRIVING = [
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
/** The player whose view has the focus; -1 when none has. @param {EventTarget | null} target */
function focusedPlayer(target) {
  const view = target instanceof HTMLElement ? target.closest('[data-drive]') : null;
  return view instanceof HTMLElement ? Number(view.dataset.drive) : -1;
}

/** @type {Map<string, {player: number, push: import('./drive.js').Push}>} held driving keys */
const down = new Map();

/** Whether a key takes a player whom its script drives, wherever the focus is: one that scrolls the page does not where others do.
 * @param {import('./drive.js').Push} way */
const takes = (way) => (layout.value?.controls === 'pedals' ? way === 'ahead' || way === 'back' : way !== 'fire');

/** @param {KeyboardEvent} event @returns {boolean} */
function driving(event) {
  if (event.altKey || event.ctrlKey || event.metaKey || event.shiftKey) return false;
  const { seat } = place.value;
  const found = DRIVING.find((key) => key.code === event.code);
  const row = found && seat !== null ? { ...found, player: seat } : found; /* with a seat, both sets of keys are its own */
  const players = layout.value?.players.length ?? 0;
  if (!row || row.player < 0 || row.player >= players) return false;
  const focused = focusedPlayer(event.target);
  const lane = event.target instanceof HTMLElement && event.target.closest('[data-arrows]') !== null;
  if (lane || !mayDrive(row.player)) return false;
  if (focused !== row.player && !byPerson(row.player) && !takes(row.push)) return false;
  if (row.push === 'fire' && layout.value?.controls !== 'aim') return false;
  if (!event.repeat && row.push === 'fire') {
    fire(row.player);
  } else if (row.push !== 'fire' && (!event.repeat || layout.value?.controls === 'aim')) {
    down.set(event.code, row);
    push(row.player, row.push, true);
  }
  return true;
}

/** Escape: no person drives any more. @param {KeyboardEvent} event */
function stopDriving(event) {
  const players = layout.value?.players.map((_, p) => p).filter(byPerson) ?? [];
  for (const player of players) drive(player, false);
  if (players.length > 0 && event.target instanceof HTMLElement) event.target.blur();
}

/** @param {KeyboardEvent} event @returns {boolean} whether it was a key of this lab */
export function press(event) {
  if (event.code === 'Escape') stopDriving(event);
  else if (!driving(event)) return false;
  else event.preventDefault();
  return true;
}

/** @param {KeyboardEvent} event */
export function release(event) {
  const row = down.get(event.code);
  if (!row) return;
  down.delete(event.code);
  push(row.player, row.push, false);
}
