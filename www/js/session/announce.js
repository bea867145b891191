// Speaks what changed, at most once in two seconds, and never per frame.
import { effect } from '../../vendor/signals-core.js';
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

export function listen() {
  effect(() => {
    if (notice.value !== '') speak(notice.value);
  });
  effect(() => {
    if (connection.value.state === 'lost' && connection.value.attempt === 1) speak(t('session.lost_spoken'));
  });
  effect(() => {
    if (divisor.value > 1) speak(t('session.slow_spoken', { hz: Math.round(FRAME_HZ / divisor.value) }));
  });
  effect(() => {
    const now = behind.value && status.value === 'playing' ? 'replaying' : status.value;
    if (SPOKEN.includes(status.value)) speak(t(`session.${now}`));
  });
}
