// What a panel is that can replace the messages below the views. Each shows one technique in detail.
import { computed, signal } from '../../../../vendor/signals-core.js';
import { frame, params } from '../../../session/state.js';

/** @typedef {{pen: CanvasRenderingContext2D, width: number, height: number, colours: import('../../../draw/palette.js').Palette,
 *   frame: import('../../../stream/frame.js').Frame, memory: import('./memory.js').Memory, layout: import('./layout.js').Layout,
 *   player: number}} InspectorContext */

/**
 * @typedef {object} Inspector
 * @property {string} id
 * @property {string} label
 * @property {boolean} players  shows one player, who can be chosen
 * @property {(frame: import('../../../stream/frame.js').Frame, params: any) => boolean} fits  whether the frame has data for it
 * @property {(at: InspectorContext) => void} draw
 * @property {(at: InspectorContext) => string} words  the same in words
 */

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
