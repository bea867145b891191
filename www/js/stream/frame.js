// What frames of every kind have.
export { BEHIND, ENDED, FAILED, PLAYING } from './decode.js';

/** @typedef {import('./decode.js').Frame} Frame */

/** The furthest time of the log, s. @param {Frame} frame */
export const headOf = (frame) => (frame.tick + frame.session.behind_ticks) / frame.tickHz;
