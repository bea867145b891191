// Speaks what changed, at most once in two seconds, and never per frame.
import { effect, untracked } from '../../vendor/signals-core.js';
import { FRAME_HZ, behind, connection, divisor, notice, status } from './state.js';
import { t } from '../base/words.js';

const REST_MS = 2000;
const SPOKEN = ['playing', 'paused', 'ended', 'failed'];

let spoken = 0;
let waiting = '';
/** @type {ReturnType<typeof setTimeout> | undefined} */
let timer;

/** @param {string} text */
export function speak(text) {
  waiting = text;
  clearTimeout(timer);
  timer = setTimeout(
    () => {
      spoken = performance.now();
      const region = document.getElementById('live');
      if (region) region.textContent = waiting;
    },
    Math.max(100, spoken + REST_MS - performance.now()),
  );
}

/** In the words of the moment: other words alone are nothing to speak of. */
export function listen() {
  effect(() => {
    if (notice.value !== '') speak(notice.value);
  });
  effect(() => {
    if (connection.value.state === 'lost' && connection.value.attempt === 1) speak(untracked(() => t('session.lost_spoken')));
  });
  effect(() => {
    const hz = Math.round(FRAME_HZ / divisor.value);
    if (divisor.value > 1) speak(untracked(() => t('session.slow_spoken', { hz })));
  });
  effect(() => {
    const now = behind.value && status.value === 'playing' ? 'replaying' : status.value;
    if (SPOKEN.includes(status.value)) speak(untracked(() => t(`session.${now}`)));
  });
}
