// The dialog that is open: one at a time.
import { signal } from '../../vendor/signals-core.js';

/** @typedef {import('../session/lab.js').Dialog} Dialog */

/** @type {import('@preact/signals-core').Signal<Dialog | null>} */
export const dialog = signal(null);

/** @param {Dialog} next */
export function open(next) {
  dialog.value = next;
}
