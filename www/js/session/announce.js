// Speaks what changed, at most once in two seconds, and never per frame. Of each subject the newest text waits, so that none hides another.
import { effect, untracked } from '../../vendor/signals-core.js';
import { FRAME_HZ, behind, connection, divisor, notice, status } from './state.js';
import { t } from '../base/words.js';

const REST_MS = 2000;
const SPOKEN = ['playing', 'paused', 'ended', 'failed'];

let spoken = 0;
/** @type {Map<string, string>} by subject */
const waiting = new Map();
/** @type {ReturnType<typeof setTimeout> | undefined} */
let timer;

/** @param {string} subject @param {string} text */
export function speak(subject, text) {
  waiting.delete(subject);
  waiting.set(subject, text);
  clearTimeout(timer);
  timer = setTimeout(
    () => {
      spoken = performance.now();
      const region = document.getElementById('live');
      if (region) region.textContent = [...waiting.values()].map((one) => one.replace(/\.$/, '')).join('. ');
      waiting.clear();
    },
    Math.max(100, spoken + REST_MS - performance.now()),
  );
}

/** In the words of the moment: other words alone are nothing to speak of. */
export function listen() {
  effect(() => {
    if (notice.value !== '') speak('notice', notice.value);
  });
  effect(() => {
    if (connection.value.state === 'lost' && connection.value.attempt === 1)
      speak(
        'connection',
        untracked(() => t('session.lost_spoken')),
      );
  });
  effect(() => {
    const hz = Math.round(FRAME_HZ / divisor.value);
    if (divisor.value > 1)
      speak(
        'pace',
        untracked(() => t('session.slow_spoken', { hz })),
      );
  });
  effect(() => {
    const now = behind.value && status.value === 'playing' ? 'replaying' : status.value;
    if (SPOKEN.includes(status.value))
      speak(
        'status',
        untracked(() => t(`session.${now}`)),
      );
  });
}
