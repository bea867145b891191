// Who drives B while no friend does: it stays next to A, now a little ahead and now behind, so that it is seen.
import { entitiesOf } from '../core/frame.js';
import { push } from '../lab/drive.js';

/** @typedef {import('../../../stream/frame.js').Frame} Frame */

const B = 1;
const FRIEND_S = 3; /* after a friend's last key B is the computer's again */
export const APART_M = 1.6;
const EACH_S = 7; /* from behind to ahead and back */
const FAST_MPS = 0.4; /* of difference that a metre of distance is worth a correction */

let friend = -Infinity; /* s, of the session: when a friend last pressed */
/** What it holds. @type {'ahead' | 'back' | ''} */
let held = '';

/** @param {'ahead' | 'back' | ''} way */
function hold(way) {
  if (way === held) return;
  if (held !== '') push(B, held, false);
  held = way;
  if (held !== '') push(B, held, true);
}

/** A friend has pressed a key of B. @param {number} time s */
export function befriend(time) {
  hold('');
  friend = time;
}

/** Another session. */
export function forget() {
  held = '';
  friend = -Infinity;
}

/** @param {Frame} frame */
export function drive(frame) {
  const [a, b] = entitiesOf(frame, 0);
  if (!a || !b || frame.time_s < friend + FRIEND_S) return;
  const wanted = a.x + APART_M * Math.sin((2 * Math.PI * frame.time_s) / EACH_S),
    ahead = (b.x - wanted) * FAST_MPS * 2 + (b.vx - a.vx);
  if (a.vx < 0.1 && b.vx < 0.5) hold('');
  else hold(ahead < -0.15 ? 'ahead' : ahead > 0.6 ? 'back' : '');
}
