// What a person has chosen of the drawings, and what they remember.
import { signal } from '../../../../vendor/signals-core.js';
import { Memory } from './memory.js';

/** @typedef {'all' | 'charts' | 'messages' | `view${number}`} Tab */
/** @typedef {'ghosts' | 'messages' | 'dots' | 'labels' | 'pings'} Overlay */

/** @type {import('@preact/signals-core').Signal<Tab>} of a phone */
export const tab = signal('all');
/** @type {import('@preact/signals-core').Signal<'px' | 'm' | 'ms'>} */
export const unit = signal('m'); /* pixels differ from screen to screen */

/** Players above and below the server's line among the messages. @type {import('@preact/signals-core').Signal<[number, number]>} */
export const lanes = signal([0, 1]);

/** What is drawn over the views. */
export const overlays = signal({ ghosts: true, dots: false, labels: true, messages: true, pings: false });

/** @param {Overlay} name */
export function toggleOverlay(name) {
  overlays.value = { ...overlays.value, [name]: !overlays.value[name] };
}

/** What the packet view follows; null while it is closed. auto: the page chooses the input; number: 0 where none is chosen yet.
 * @type {import('@preact/signals-core').Signal<{player: number, number: number, auto: boolean} | null>} */
export const followed = signal(null);

export const scale = { pxPerMetre: 1 }; /* of the views, kept by the drawings */

/** What became of connections in this stretch of time, oldest first.
 * @type {import('@preact/signals-core').Signal<import('./memory.js').Happening[]>} */
export const connectionEvents = signal([]);

export let memory = new Memory(false, 0);

/** Another stream. @param {boolean} flights */
export function forget(flights) {
  memory = new Memory(flights, -1);
}

/** @param {import('../../../stream/frame.js').Frame} frame */
export function take(frame) {
  if (frame.session.generation !== memory.generation) memory = new Memory(memory.flights, frame.session.generation);
  memory.take(frame);
}
