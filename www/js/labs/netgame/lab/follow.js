// The packet view is read when it is first opened: by a button, a key, or a lesson about a packet.
import { effect, signal, untracked } from '../../../../vendor/signals-core.js';
import { insist } from '../../../base/api.js';
import { look, usable } from '../../../session/state.js';
import { followed, lanes } from '../core/state.js';

/** @type {import('@preact/signals-core').Signal<typeof import('../packet/packet.js') | null>} */
export const view = signal(null);

let picked = { player: 0, number: 0 };

/** An input was chosen among the messages; number 0: none is. @param {number} player @param {number} number */
export function pick(player, number) {
  picked = { player, number };
}

const ENTER_FRAMES = 300; /* until it is given up: the view has to be read first */

/** The keyboard goes into the view, once that is there. @param {number} left frames */
function enter(left) {
  const title = document.getElementById('packet-title');
  if (title) title.focus();
  else if (left > 0 && followed.value !== null) requestAnimationFrame(() => enter(left - 1));
}

/** Opens the view: of the input that was chosen among the messages; where none was, the page chooses. */
export function follow() {
  if (!usable('view.packet')) return;
  const { player, number } = picked;
  followed.value = number > 0 ? { player, number, auto: false } : { player: lanes.value[0], number: 0, auto: true };
  enter(ENTER_FRAMES);
}

export const toggle = () => (followed.value === null ? follow() : void (usable('view.packet') && (followed.value = null)));

let asked = false;
effect(() => {
  if (followed.value === null || asked) return;
  asked = true;
  insist(() => import('../packet/packet.js')).then((read) => {
    view.value = read;
  });
});
let lessons = false;
effect(() => {
  const { at: of, player = 0, step = 0 } = look.value ?? { at: '' },
    at = step > 1 ? of : '';
  untracked(() => {
    if (at === 'packet' && !lessons) followed.value = { player, number: 0, auto: true };
    else if (at !== 'packet' && lessons) followed.value = null;
    lessons = at === 'packet';
  });
});
