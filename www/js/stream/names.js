// Written by docs/generate.mjs from `laglab schema stream`: the tables are in C, and changed there.

export const EVENTS_TYPE = Object.freeze({ input: 1, state: 2, refusal: 3, relay: 4, connect: 5, accept: 6, ping: 7, pong: 8, input_result: 16, applied: 17, correction: 18, step: 19, stall: 20, rollback: 21, desync: 22, connection: 23, dropped: 24, display: 25, segment: 26, blocked: 27 });
export const EVENTS_FATE = Object.freeze({ delivered: 0, lost: 1, overflow: 2, corrupted: 3 });
export const VIEWS_FLAGS = Object.freeze({ prediction: 1, reconciliation: 2, interpolation: 4, underrun: 8, stalled: 16, person: 32 });
export const VIEWS_CONNECTION = Object.freeze({ connecting: 0, synchronising: 1, playing: 2, stalled: 3, resynchronising: 4, disconnected: 5 });
export const ENTITIES_FLAGS = Object.freeze({ finished: 1, predicted: 2, interpolated: 4, held: 8, active: 16, extrapolated: 32, unsettled: 64, away: 128, unknown: 256 });
export const BUFFERS_STATE = Object.freeze({ newest: 0, normal: 1, catching_up: 2, slowing: 3, starved: 4, extrapolating: 5 });
export const PEERS_DESYNC_FIELD = Object.freeze({ x: 0, y: 1, vx: 2, vy: 3, angle: 4, angular_velocity: 5, flags: 6, tail: 7 });
export const INPUT_HISTORY_STATE = Object.freeze({ open: 0, acknowledged: 1, refused: 2, late: 3, lost: 4 });
export const BUFFERED_PLACE = Object.freeze({ snapshot: 0, dejitter: 1 });
export const SHOTS_WEAPON = Object.freeze({ hitscan: 0, projectile: 1 });
export const SHOTS_FLAGS = Object.freeze({ taken: 1, clamped: 2, view_time_rejected: 4, behind_cover: 8 });
export const SHOT_BODIES_WEAPON = Object.freeze({ hitscan: 0, projectile: 1 });
export const TRAFFIC_MESSAGE = Object.freeze({ input: 1, state: 2, refusal: 3, relay: 4, connect: 5, accept: 6, ping: 7, pong: 8 });
export const MOTION_STATUS = Object.freeze({ ok: 0, diverged: 1, off: 2, failed: 3 });
export const WORLDS_STATUS = Object.freeze({ ok: 0, diverged: 1, off: 2, failed: 3 });
export const WORLDS_SOLVER = Object.freeze({ impulse: 0, pgs: 1, pgs_ngs: 2, soft_step: 3, tgs_sticky: 4, xpbd: 5, avbd: 6 });
export const GEOMETRIES_KIND = Object.freeze({ circle: 0, capsule: 1, polygon: 2, segment: 3, link: 4 });
export const SHAPES_FLAGS = Object.freeze({ dynamic: 1, kinematic: 2, awake: 4 });
export const JOINTS_TYPE = Object.freeze({ distance: 0, revolute: 1, prismatic: 2, weld: 3, mouse: 4, motor: 5, friction: 6 });
export const VOLUMES_VOLUME = Object.freeze({ exact: 0, aabb: 1, sphere: 2, obb: 3 });
export const FLUID_STATUS = Object.freeze({ ok: 0, diverged: 1, off: 2, failed: 3 });
