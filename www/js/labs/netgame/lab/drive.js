// A person at the controls: held keys and pads become axes, sent over the stream when they change.
import { effect, signal } from '../../../../vendor/signals-core.js';
import { send } from '../../../session/session.js';
import { change } from '../../../session/params.js';
import { locked, mayDrive, params, session } from '../../../session/state.js';
import { layout } from '../core/layout.js';

/** @typedef {'ahead' | 'back' | 'up' | 'down' | 'fire'} Push */

/** Which players' keys work wherever the focus is. @type {import('@preact/signals-core').Signal<boolean[]>} */
export const driven = signal([]);
/** Angle and speed of each player's cannon, 0 to 1. */
export const aim = signal(Array.from({ length: 8 }, () => [0.5, 0.8]));

/** @type {Map<number, Set<Push>>} */
const held = new Map();
/** @type {Map<number, string>} the last sent input, by player */
const sent = new Map();
let asked = 0;

/** @param {number} player @returns {boolean} */
export function byPerson(player) {
  return params.value?.players?.[player]?.control === 'person';
}

/** @param {number} player @param {boolean} on */
export async function drive(player, on) {
  if (locked.value !== '') return;
  release(player);
  if (byPerson(player) !== on) await change({ [`players.${player}.control`]: on ? 'person' : 'script' });
  submit(player);
}

/** @param {number} player @returns {{axes: number[], buttons: number}} */
function action(player) {
  const pushes = held.get(player) ?? new Set();
  if (layout.value?.controls === 'aim') {
    return { axes: [...(aim.value[player] ?? [0.5, 0.8])], buttons: pushes.has('fire') ? 1 : 0 };
  }
  const push = (/** @type {Push} */ one, /** @type {Push} */ other) => (pushes.has(one) ? 1 : 0) - (pushes.has(other) ? 1 : 0);
  if (layout.value?.controls === 'plane') return { axes: [push('ahead', 'back'), push('up', 'down')], buttons: 0 };
  return { axes: [(pushes.has('ahead') || pushes.has('up') ? 1 : 0) - (pushes.has('back') || pushes.has('down') ? 1 : 0), 0], buttons: 0 };
}

/** @param {number} player */
function submit(player) {
  if (!byPerson(player) || !mayDrive(player)) return;
  const input = { player, ...action(player) };
  const text = JSON.stringify(input);
  if (sent.get(player) === text) return;
  sent.set(player, text);
  send({ input, id: ++asked });
}

/** @param {number} player @param {Push} key @param {boolean} down */
export async function push(player, key, down) {
  const pushes = held.get(player) ?? new Set();
  held.set(player, pushes);
  if (down) pushes.add(key);
  else pushes.delete(key);
  if (down && !byPerson(player)) await change({ [`players.${player}.control`]: 'person' });
  if (down && layout.value?.controls === 'aim' && key !== 'fire') turn(player, key);
  submit(player);
}

/** @param {number} player @param {Push} key */
function turn(player, key) {
  const [angle = 0.5, speed = 0.8] = aim.value[player] ?? [];
  if (key === 'up' || key === 'down') setAim(player, angle + (key === 'up' ? 1 : -1) / 90, speed);
  else setAim(player, angle, speed + (key === 'ahead' ? 0.02 : -0.02));
}

/** @param {number} player @param {number} angle @param {number} speed */
export function setAim(player, angle, speed) {
  const bound = (/** @type {number} */ x) => Math.max(0, Math.min(1, x));
  aim.value = aim.value.map((old, p) => (p === player ? [bound(angle), bound(speed)] : old));
  submit(player);
}

/** Lets everything go. @param {number} player */
export function release(player) {
  held.get(player)?.clear();
  submit(player);
}

export function releaseAll() {
  for (const player of held.keys()) release(player);
}

/** Fires once: the button goes down and up again, each as a separate change. @param {number} player */
export async function fire(player) {
  await push(player, 'fire', true);
  setTimeout(() => push(player, 'fire', false), 250);
}

addEventListener('blur', releaseAll);
document.addEventListener('visibilitychange', () => {
  if (document.hidden) releaseAll();
});
effect(() => {
  session.value; /* another session has heard nothing yet */
  sent.clear();
  held.clear();
});
