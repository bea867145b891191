// The panels that can replace the messages below the views; each shows one technique in detail.
import { buffers } from './buffers.js';
import { inputs } from './inputs.js';
import { shots } from './shots.js';
import { waits } from './waits.js';

/** @typedef {{pen: CanvasRenderingContext2D, width: number, height: number, colours: import('../../../draw/palette.js').Palette,
 *   frame: import('../core/frame.js').Frame, memory: import('../core/memory.js').Memory, layout: import('../../../session/state.js').Layout, player: number}} InspectorContext */

/**
 * @typedef {object} Inspector
 * @property {string} id
 * @property {string} label
 * @property {boolean} players  shows one player, who can be chosen
 * @property {(frame: import('../core/frame.js').Frame, params: any) => boolean} fits  whether the frame has data for it
 * @property {(at: InspectorContext) => void} draw
 * @property {(at: InspectorContext) => string} words  the same in words
 */

/** @type {Inspector[]} */
export const INSPECTORS = [buffers, inputs, waits, shots];
