// Slow motion by itself where a thing takes a tenth of a second, and the normal speed after it. A speed that a person sets stays.
import { effect, untracked } from '../../vendor/signals-core.js';
import { frame, locked, speed, status } from '../session/state.js';
import { setSpeed, slowing } from '../session/time.js';

/* The stretches of time that were slowed and released. */
let slowed = -1,
  released = -1;

/** @param {import('../session/lab.js').Slow} slow @param {import('../stream/frame.js').Frame} now @param {number} pace */
function follow(slow, { time_s: time, session: { generation } }, pace) {
  if (time >= slow.until_s) {
    if (released !== generation && pace === slow.speed) setSpeed(1);
    released = generation;
  } else if (time >= slow.from_s && slowed !== generation) {
    slowed = generation;
    if (pace === 1) setSpeed(slow.speed);
  }
}

export function listen() {
  effect(() => {
    const now = frame.value,
      pace = speed.value;
    if (now === null || status.value !== 'playing' || locked.value !== '') return;
    untracked(() => {
      const slow = slowing();
      if (slow) follow(slow, now, pace);
    });
  });
}
