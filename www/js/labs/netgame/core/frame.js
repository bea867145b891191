// A frame as the netgame's lab reads it: the names of the tables for short, and rows that belong to one view, player or shot.
import {
  BUFFERS_STATE,
  ENTITIES_FLAGS,
  EVENTS_TYPE,
  INPUT_HISTORY_STATE,
  PEERS_DESYNC_FIELD,
  SHOTS_FLAGS,
  SHOTS_WEAPON,
  VIEWS_CONNECTION,
  VIEWS_FLAGS,
} from '../../../stream/names.js';

export const {
  prediction: PREDICTION,
  reconciliation: RECONCILIATION,
  interpolation: INTERPOLATION,
  underrun: UNDERRUN,
  stalled: STALLED,
  person: PERSON,
} = VIEWS_FLAGS;
export const {
  connecting: CONNECTING,
  synchronising: SYNCHRONISING,
  playing: IS_PLAYING,
  stalled: IS_STALLED,
  resynchronising: RESYNCHRONISING,
  disconnected: DISCONNECTED,
} = VIEWS_CONNECTION;
export const {
  finished: E_FINISHED,
  predicted: E_PREDICTED,
  interpolated: E_INTERPOLATED,
  held: E_HELD,
  active: E_ACTIVE,
  extrapolated: E_EXTRAPOLATED,
  away: E_AWAY,
  unknown: E_UNKNOWN,
} = ENTITIES_FLAGS;
export const {
  input: INPUT,
  state: STATE,
  refusal: REFUSAL,
  relay: RELAY,
  connect: CONNECT,
  accept: ACCEPT,
  ping: PING,
  pong: PONG,
  input_result: INPUT_RESULT,
  applied: APPLIED,
  correction: CORRECTION,
  step: STEP,
  stall: STALL,
  rollback: ROLLBACK,
  desync: DESYNC,
  connection: CONNECTION,
  dropped: DROPPED,
  display: DISPLAY,
  segment: SEGMENT,
  blocked: BLOCKED,
} = EVENTS_TYPE;
export const {
  newest: V_NEWEST,
  normal: V_NORMAL,
  catching_up: V_CATCHING_UP,
  slowing: V_SLOWING,
  starved: V_STARVED,
  extrapolating: V_EXTRAPOLATING,
} = BUFFERS_STATE;
export const { open: R_OPEN, acknowledged: R_ACKNOWLEDGED, refused: R_REFUSED, late: R_LATE, lost: R_LOST } = INPUT_HISTORY_STATE;
export const { hitscan: HITSCAN, projectile: PROJECTILE } = SHOTS_WEAPON;
export const { clamped: S_CLAMPED, view_time_rejected: S_DISTRUSTED, behind_cover: S_BEHIND_COVER } = SHOTS_FLAGS;
export const APPLIED_OK = 0,
  REFUSED = 1,
  LATE = 3; /* results of an input */
export const NOBODY = -1,
  NOT_YET = -2; /* what a shot hits, instead of a body */

/** States of a player's connection; the server's own is `playing`. */
export const CONNECTIONS = Object.keys(VIEWS_CONNECTION);
/** Fields of an entity, and the game's own part of the world: where two worlds differ. */
export const FIELDS = Object.keys(PEERS_DESYNC_FIELD);

/** @typedef {import('../../../stream/frame.js').Frame} Frame */
/** @typedef {import('../../../stream/rows.js').ViewsRow} View */
/** @typedef {import('../../../stream/rows.js').EntitiesRow} Entity */
/** @typedef {import('../../../stream/rows.js').EventsRow} Event */
/** @typedef {import('../../../stream/rows.js').PeersRow} Peer */
/** @typedef {import('../../../stream/rows.js').BuffersRow} Buffer */
/** @typedef {import('../../../stream/rows.js').BufferedRow} Buffered */
/** @typedef {import('../../../stream/rows.js').InputHistoryRow} InputHistoryEntry */
/** @typedef {import('../../../stream/rows.js').MeasuresRow} Measures */
/** @typedef {import('../../../stream/rows.js').ShotsRow} Shot */
/** @typedef {import('../../../stream/rows.js').ShotBodiesRow} ShotBody */
/** @typedef {import('../../../stream/rows.js').ShellsRow} Shell */

/** What is in a view: 0 the server's, 1 + p player p's. @param {Frame} frame @param {number} view @returns {Entity[]} */
export const entitiesOf = (frame, view) => frame.where('entities', 'view', view);

/** The game's own values of a player, in the order of the layout. @param {Frame} frame @param {number} player @returns {number[]} */
export const gameOf = (frame, player) => frame.where('game', 'player', player).map(({ value }) => value);

/** The bodies at the times of a shot; body i is entity i. @param {Frame} frame @param {Shot} shot @returns {ShotBody[]} */
export const bodiesOf = (frame, shot) =>
  frame.where('shot_bodies', 'player', shot.player).filter((body) => body.weapon === shot.weapon && body.tick === shot.tick);
