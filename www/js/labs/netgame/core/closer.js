// What an inspector is: one technique in detail. Types alone; no page loads this.

/** @typedef {{pen: CanvasRenderingContext2D, width: number, height: number, colours: import('../../../draw/palette.js').Palette,
 *   frame: import('../../../stream/frame.js').Frame, memory: import('./memory.js').Memory, layout: import('./layout.js').Layout,
 *   player: number}} InspectorContext */

/**
 * @typedef {object} Inspector
 * @property {string} id       end of the key of its words, too
 * @property {boolean} players  shows one player, who can be chosen
 * @property {(frame: import('../../../stream/frame.js').Frame, params: any) => boolean} fits  whether the frame has data for it
 * @property {(at: InspectorContext) => void} draw
 * @property {(at: InspectorContext) => string} words  the same in words
 */

export {};
