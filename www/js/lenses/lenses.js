// What the lane below the views can show: messages, or a closer look at one technique.
import { buffers } from './buffers.js';
import { inputs } from './inputs.js';
import { shots } from './shots.js';
import { waits } from './waits.js';

/** @typedef {{pen: CanvasRenderingContext2D, width: number, height: number, colours: import('../theme.js').Palette,
 *   frame: import('../frame.js').Frame, memory: import('../memory.js').Memory, layout: import('../state.js').Layout, player: number}} LensPicture */

/**
 * @typedef {object} Lens
 * @property {string} id
 * @property {string} label
 * @property {boolean} players  looks at one player, who can be chosen
 * @property {(frame: import('../frame.js').Frame, params: any) => boolean} fits  whether there is something to see
 * @property {(at: LensPicture) => void} draw
 * @property {(at: LensPicture) => string} words  the same in words
 */

/** @type {Lens[]} */
export const LENSES = [buffers, inputs, waits, shots];
