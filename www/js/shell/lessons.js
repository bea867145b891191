// The lessons, read when the page first shows one or their list.
import { effect, signal } from '../../vendor/signals-core.js';
import { part } from '../base/api.js';
import { lesson } from '../session/state.js';

/** @type {import('@preact/signals-core').Signal<typeof import('../lessons/lessons.js') | null>} */
export const lessons = signal(null);
let reading = false;

effect(() => {
  if (lesson.value === null || reading) return;
  reading = true;
  part(() => import('../lessons/lessons.js')).then((read) => {
    lessons.value = read;
  });
});
