// What the hello says of a netgame.
import { computed } from '../../../../vendor/signals-core.js';
import { letter } from '../../../base/format.js';
import { layout as given } from '../../../session/state.js';
import { traitsOf } from './games.js';

/** @typedef {{x_min: number, x_max: number, y_min: number, y_max: number, wraps: boolean, finish_m: number,
 *   target_x: number, target_y: number, target_radius: number, entity_length_m: number}} Scene */
/** @typedef {{kind: string, width_m: number, height_m: number, round: boolean}} Shape */
/** @typedef {import('./games.js').Traits & {players: {name: string}[], game_values: string[], scene: Scene, entities: Shape[],
 *   fixed: (Shape & {x: number, y: number})[],
 *   notices: string[]}} Layout  entities: how each is drawn, none in a game that has a drawing of
 *   its own */

const SCENE = {
  x_min: 0,
  x_max: 100,
  y_min: 0,
  y_max: 1,
  wraps: false,
  finish_m: 0,
  target_x: 0,
  target_y: 0,
  target_radius: 0,
  entity_length_m: 1,
};

/** @param {import('../../../session/state.js').Layout} now @returns {Layout} */
function layoutOf({ game, given, params }) {
  const players = given.players ?? params.players ?? [];
  return {
    ...traitsOf(game),
    players: players.map((/** @type {any} */ player, /** @type {number} */ p) => ({ name: player.name || letter(p) })),
    game_values: given.game_values ?? [],
    scene: { ...SCENE, ...given.scene },
    entities: given.entities ?? [],
    fixed: given.fixed ?? [],
    notices: given.notices ?? [],
  };
}

/** Null until it is known. */
export const layout = computed(() => (given.value === null ? null : layoutOf(given.value)));
