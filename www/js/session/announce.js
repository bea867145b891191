// Speaks what changed, at most once in two seconds, and never per frame.
import { effect } from '../../vendor/signals-core.js';
import { FRAME_HZ, behind, connection, divisor, notice, status } from './state.js';

const REST_MS = 2000;
const WORDS = /** @type {Record<string, string>} */ ({
  playing: 'Playing',
  paused: 'Paused',
  ended: 'Ended',
  failed: 'Stopped by an error',
});

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
    if (connection.value.state === 'lost' && connection.value.attempt === 1) speak('Connection lost, retrying');
  });
  effect(() => {
    if (divisor.value > 1) speak(`Slow connection, ${Math.round(FRAME_HZ / divisor.value)} frames a second`);
  });
  effect(() => {
    const word = WORDS[status.value];
    if (word) speak(behind.value && status.value === 'playing' ? 'Replaying' : word);
  });
}
