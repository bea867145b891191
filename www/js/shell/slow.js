// Slow motion by itself where a thing takes a tenth of a second, and the normal speed after it. A speed that a person sets stays.
import { effect, untracked } from '../../vendor/signals-core.js';
import { frame, locked, speed, status } from '../session/state.js';
import { setSpeed, slowing } from '../session/time.js';

let generation = -1; /* the stretch of time that was slowed or left alone */
let ours = false; /* whether the present speed was set here */
let asked = 0; /* the speed that is on its way */

/** @param {number} to */
function go(to) {
  asked = to;
  setSpeed(to);
}

/** @param {import('../stream/frame.js').Frame} now @param {import('../session/lab.js').Slow} slow @param {number} pace */
function follow(now, slow, pace) {
  if (now.session.generation !== generation && now.time_s < slow.until_s) {
    generation = now.session.generation;
    ours = pace === slow.speed;
    asked = 0;
  }
  if (asked !== 0 && pace !== asked) return;
  asked = 0;
  if (ours && pace !== slow.speed) ours = false;
  if (now.time_s >= slow.until_s) {
    if (ours) go(1);
    ours = false;
  } else if (!ours && pace === 1 && now.time_s >= slow.from_s && generation === now.session.generation) {
    ours = true;
    generation = now.session.generation;
    go(slow.speed);
  }
}

export function listen() {
  effect(() => {
    const now = frame.value,
      pace = speed.value;
    if (now === null || status.value !== 'playing' || locked.value !== '') return;
    untracked(() => {
      const slow = slowing();
      if (slow) follow(now, slow, pace);
    });
  });
}
