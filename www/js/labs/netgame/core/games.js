// What differs between games. A game that is not named here is driven by throttle and brake, and drawn as a track where it has no shapes.

/** Controls: `pedals` push along the track, `plane` pushes in two directions, `aim` has an angle, a speed and a trigger.
 * @typedef {'pedals' | 'plane' | 'aim'} Controls */
/** inspector: what is worth a closer look from the start. @typedef {{controls: Controls, inspector: string}} Traits */

/** @type {Record<string, Partial<Traits>>} */
const GAMES = {
  cannon: { controls: 'aim' },
  shooter: { inspector: 'shots' },
  crates: { controls: 'plane' },
  dam: { controls: 'plane' },
  stack: { controls: 'plane' },
};

/** @param {string | undefined} game @returns {Traits} */
export const traitsOf = (game) => ({ controls: 'pedals', inspector: 'messages', ...GAMES[game ?? ''] });
