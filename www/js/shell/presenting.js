// The presentation, read when it is first wanted.
import { effect, signal } from '../../vendor/signals-core.js';
import { part } from '../base/api.js';
import { presented, presenting } from '../session/state.js';

/** @type {import('@preact/signals-core').Signal<typeof import('./present.js') | null>} */
export const shown = signal(null);
/** @type {Promise<typeof import('./present.js')> | null} */
let reading = null;

function read() {
  reading ??= part(() => import('./present.js')).then(async (one) => {
    await one.ready;
    shown.value = one;
    return one;
  });
  return reading;
}

export async function toggle() {
  (await read()).present(!presenting.value);
}

effect(() => {
  if (presented.value) read();
});
