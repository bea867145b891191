// Keys and pads of the race: A by the arrows and by the pads, B by a friend's A and D. They work wherever the focus is, but in fields.
import { signal } from '../../../../vendor/signals-core.js';
import { frame, status } from '../../../session/state.js';
import { control } from '../../../session/time.js';
import { entitiesOf } from '../core/frame.js';
import { push } from '../lab/drive.js';
import { befriend } from './opponent.js';

/** @typedef {'ahead' | 'back'} Way */

/** Of A; by: what was used last, and before that what a finger or a keyboard would use.
 * @type {import('@preact/signals-core').Signal<{ahead: boolean, back: boolean, by: 'keys' | 'pads'}>} */
export const held = signal({
  ahead: false,
  back: false,
  by: matchMedia('(pointer: coarse), (max-width: 43.99rem)').matches ? 'pads' : 'keys',
});
/** What A's driver changed and the daemon has not answered, in its order. @type {import('./felt.js').Change[]} */
export const changes = [];
/** Time of the session, s, when a person last drove; resting: it has been paused since. */
export const driven = { at: 0, resting: false };

/** @type {Record<string, {player: number, way: Way}>} */
const KEYS = {
  ArrowRight: { player: 0, way: 'ahead' },
  ArrowLeft: { player: 0, way: 'back' },
  KeyD: { player: 1, way: 'ahead' },
  KeyA: { player: 1, way: 'back' },
};

/** A race that rests goes on. */
function wake() {
  driven.at = frame.value?.time_s ?? 0;
  if (status.value === 'paused' || driven.resting) control({ op: 'play' });
  else if (status.value === 'ended') control({ op: 'restart', reset: false }).then(() => control({ op: 'play' }));
  driven.resting = false;
}

/** Both held are none, as it is sent. @returns {import('./felt.js').Held} */
const heldWay = () => (held.value.ahead === held.value.back ? '' : held.value.ahead ? 'ahead' : 'back');

/** @param {boolean} ahead @param {boolean} back @param {'keys' | 'pads'} by */
function change(ahead, back, by) {
  const before = heldWay(),
    time = frame.value?.time_s ?? 0;
  held.value = { ahead, back, by };
  const way = heldWay();
  if (way === before) return;
  const still = way === 'back' && frame.value !== null && entitiesOf(frame.value, 1)[0]?.vx === 0; /* a brake that shows nothing */
  const last = changes.at(-1),
    one = { way: still ? '' : way, time };
  if (last?.time !== time) changes.push(one);
  else changes[changes.length - 1] = { ...one, way: one.way || last.way }; /* in one tick: one change for the daemon */
}

/** @param {number} player @param {Way} way @param {boolean} down @param {'keys' | 'pads'} by */
function press(player, way, down, by) {
  if (down) wake();
  if (player === 1) befriend(frame.value?.time_s ?? 0);
  else if (held.value[way] !== down) {
    const now = { ...held.value, [way]: down };
    change(now.ahead, now.back, down ? by : now.by);
  }
  push(player, way, down);
}

/** A key went down. @param {KeyboardEvent} event @returns {boolean} whether it drives */
export function keyDown(event) {
  const row = KEYS[event.code];
  if (!row || event.altKey || event.ctrlKey || event.metaKey || event.shiftKey) return false;
  event.preventDefault();
  press(row.player, row.way, true, 'keys'); /* also repeated: another session may not have heard it */
  return true;
}

/** @param {KeyboardEvent} event */
export function keyUp(event) {
  const row = KEYS[event.code];
  if (row) press(row.player, row.way, false, 'keys');
}

export function letGo() {
  for (const { player, way } of Object.values(KEYS)) push(player, way, false);
  change(false, false, held.value.by);
}

/** A pad that is held by a finger, a mouse, or by Space or Enter. @param {Way} way */
export const hold = (way) => ({
  down: (/** @type {PointerEvent} */ event) => {
    /** @type {Element} */ (event.currentTarget).setPointerCapture(event.pointerId);
    press(0, way, true, 'pads');
  },
  up: () => {
    if (held.value[way]) press(0, way, false, 'keys');
  },
  key: (/** @type {KeyboardEvent} */ event) => {
    if (event.code !== 'Space' && event.code !== 'Enter') return;
    event.preventDefault();
    press(0, way, true, 'keys');
  },
});
