// What differs between games. A game that is not named here is driven by throttle and brake, and drawn as a track where it has no shapes.

/** Controls: `pedals` push along the track, `plane` pushes in two directions, `aim` has an angle, a speed and a trigger.
 * @typedef {'pedals' | 'plane' | 'aim'} Controls */
/** inspector: what is worth a closer look from the start; family: of which speed against error is the question
 * @typedef {{controls: Controls, inspector: string, family: string}} Traits */

/** @type {Record<string, Partial<Traits>>} */
const GAMES = {
  cannon: { controls: 'aim' },
  shooter: { inspector: 'shots', family: 'lag_compensation' },
  crates: { controls: 'plane', family: 'snapshots' },
  dam: { controls: 'plane' },
  stack: { controls: 'plane' },
  swarm: { family: 'snapshots' },
};

/** @param {string | undefined} game @returns {Traits} */
export const traitsOf = (game) => ({ controls: 'pedals', inspector: 'messages', family: 'synchronisation', ...GAMES[game ?? ''] });
