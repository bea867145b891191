// What a panel is that can replace the messages below the views. Each shows one technique in detail.
import { computed, signal } from '../../../../vendor/signals-core.js';
import { frame, params } from '../../../session/state.js';

/** @typedef {import('./closer.js').InspectorContext} InspectorContext */
/** @typedef {import('./closer.js').Inspector} Inspector */

/** Content of the lower panel: `messages`, or the id of an inspector. */
export const inspector = signal('messages');

/** The inspectors that can be chosen, once they are loaded. @type {import('@preact/signals-core').Signal<Inspector[]>} */
export const inspectors = signal([]);

/** Ids of those that have something to show, joined: it changes seldom, though it is read with every frame. */
export const offered = computed(() => {
  const now = frame.value;
  return now === null
    ? ''
    : inspectors.value
        .filter((one) => one.fits(now, params.value))
        .map((one) => one.id)
        .join(' ');
});
