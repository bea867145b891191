// Decodes a binary frame of the stream `laglab.v1.bin`.

export const PLAYING = 2, ENDED = 4, BEHIND = 8, FAILED = 16; /* flags of a frame */
export const PREDICTION = 1, RECONCILIATION = 2, INTERPOLATION = 4, UNDERRUN = 8, STALLED = 16, PERSON = 32; /* of a view */
const CONNECTION_SHIFT = 8, CONNECTION_MASK = 7, DROPPED_BY_SERVER = 2048;
/** States of a player's connection; the server's own is `playing`. */
export const CONNECTIONS = ['connecting', 'synchronising', 'playing', 'stalled', 'resynchronising', 'disconnected'];
export const CONNECTING = 0, SYNCHRONISING = 1, IS_PLAYING = 2, IS_STALLED = 3, RESYNCHRONISING = 4, DISCONNECTED = 5;
export const E_FINISHED = 1, E_PREDICTED = 2, E_INTERPOLATED = 4, E_HELD = 8, E_ACTIVE = 16, E_EXTRAPOLATED = 32; /* of an entity */
export const E_AWAY = 128; /* its player is not connected */
export const INPUT = 1, STATE = 2, REFUSAL = 3, RELAY = 4, CONNECT = 5, ACCEPT = 6, PING = 7, PONG = 8, VERDICT = 16, APPLIED = 17,
  CORRECTION = 18, STEP = 19, STALL = 20, ROLLBACK = 21, DESYNC = 22, CONNECTION = 23, DROPPED = 24; /* events */
export const APPLIED_OK = 0, REFUSED = 1; /* outcomes of a verdict */

/** Fields of an entity, and the game's own part of the world: where two worlds differ. */
export const FIELDS = ['x', 'y', 'vx', 'vy', 'angle', 'spin', 'flags', 'tail'];

/** @typedef {{x: number, y: number, vx: number, vy: number, angle: number, age: number, flags: number}} Entity */

/**
 * @typedef {object} View
 * @property {number} view  0 is the server, 1 + p player p
 * @property {number} flags
 * @property {number} connection   index into CONNECTIONS
 * @property {boolean} connected   the server has the player connected
 * @property {number} inputSeq
 * @property {number} ackedSeq
 * @property {number} unacked
 * @property {number} lag          ms, one way
 * @property {number} viewAge      ms, of the remote entities
 * @property {number} ownLead      m, drawn minus the server's now: ahead by prediction, no error
 * @property {number} remoteError  m, the largest
 * @property {number} buffer       ms, newest snapshot minus drawn time
 * @property {number} slack        ticks that an input arrives early; NaN: not known
 * @property {number} corrections
 * @property {number} correction   m, the last one
 * @property {number} refused
 * @property {number} alpha        between the two snapshots
 * @property {number} shown        s, server time of the remote entities as drawn
 * @property {Entity[]} entities
 */

/** @typedef {{status: number, t: number, error: number, errorMax: number, drift: number, evaluations: number, steps: number,
 *   rejected: number, weightedMax: number, state: number[]}} Motion  status: 0 ok, 1 diverged, 2 off, 3 failed */

/** @typedef {{id: number, type: number, player: number, fate: number, outcome: number, begin: number, end: number,
 *   number: number, value: number}} Event */

/** What is counted of a player's view from the warm-up on: a mean is the difference of two sums by that of their counts.
 * `ageOfInformation`: ms, now. `latencies`: changes of the controls that were felt, of `changes`, of which `lost` were never applied.
 * @typedef {{player: number, ageOfInformation: number, errorSum: number, latencySum: number, errors: number, latencies: number,
 *   changes: number, lost: number, visibleCorrections: number}} Measures */

export const V_NEWEST = 0, V_NORMAL = 1, V_CATCHING_UP = 2, V_SLOWING = 3, V_STARVED = 4, V_EXTRAPOLATING = 5; /* states of a buffer */

/** The buffer of a player's view; times in ms. `behind`: the drawn time behind the newest that could be known.
 * @typedef {{player: number, state: number, delay: number, behind: number, timeScale: number, dejitter: number,
 *   underruns: number, overruns: number, late: number}} Buffer */

export const R_OPEN = 0, R_ACKNOWLEDGED = 1, R_REFUSED = 2, R_LATE = 3, R_LOST = 4; /* states of an input */

/** One of the last inputs of a player who reconciles. `made`: ms from the frame's time on, negative. Where the input put the own
 * entity: `predictedX` by the client, `serverX` in the state that acknowledged it; null while unknown, as the difference.
 * @typedef {{player: number, state: number, seq: number, made: number, predictedX: number | null, serverX: number | null,
 *   correction: number | null}} Rung */

/** A state in a snapshot buffer (place 0) or a de-jitter buffer (1). `time`: its server time minus the drawn one; the others
 * count from the frame's time; ms.
 * @typedef {{player: number, place: number, tick: number, time: number, sent: number, arrived: number, due: number}} Buffered */

export const RIFLE = 0, SHELL = 1; /* weapons of a shot */
export const S_CLAMPED = 2, S_DISTRUSTED = 4, S_BEHIND_COVER = 8; /* flags of a shot */
export const NOBODY = -1, NOT_YET = -2; /* what a shot hits, instead of a body */

/** A body at the three times of a shot: as the shooter saw it, in the server's present, and where the server looked.
 * @typedef {{seenX: number, seenY: number, nowX: number, nowY: number, lookedX: number, lookedY: number}} ShotBody */

/**
 * @typedef {object} Shot       the last of a player and weapon that the server took
 * @property {number} player
 * @property {number} weapon
 * @property {number} flags
 * @property {number} tick      the server's step that it was meant for
 * @property {number} pressed   s
 * @property {number} seen      s, server time of the picture that the shooter acted on
 * @property {number} judged    s, the server's present
 * @property {number} looked    s, server time of the bodies that it was judged against
 * @property {number} x         m, the muzzle as pressed
 * @property {number} y
 * @property {number} dx        the aim, a unit vector
 * @property {number} dy
 * @property {number} serverX   m, the muzzle where the server had it
 * @property {number} serverY
 * @property {number} viewHit     the body that is hit in the shooter's pictures
 * @property {number} nowHit      in the server's present, without compensation
 * @property {number} serverHit   by the server's policy
 * @property {number} perfectHit  on a network without delay
 * @property {ShotBody[]} bodies  body i is entity i
 */

/** A shell in flight as a view has it. `from...`: at the start of its flight; `flown`: s since.
 * @typedef {{view: number, player: number, number: number, flown: number, x: number, y: number, vx: number, vy: number,
 *   fromX: number, fromY: number, fromVx: number, fromVy: number}} Shell */

/**
 * @typedef {object} Peer       a client with a world of its own
 * @property {number} confirmed  tick up to which everybody's inputs have come
 * @property {number} tick       that is drawn
 * @property {number} desyncTick  first that differs from the server's, -1: none
 * @property {number} waiting    bit p: stalls for the input of player p
 * @property {number} stalls
 * @property {number} stalled    s
 * @property {number} rollbacks
 * @property {number} rollbackTicks
 * @property {number} desyncEntity  -1: the game's tail
 * @property {number} desyncField   index into FIELDS
 * @property {number} desyncDistance  m, now
 * @property {number} desyncUlps    of that field at that tick
 */

/**
 * @typedef {object} Frame
 * @property {number} flags
 * @property {number} seq
 * @property {number} time      s
 * @property {number} head      s, the furthest time of the log
 * @property {number} duration  s
 * @property {number} tick
 * @property {number} speed
 * @property {number} paramsVersion
 * @property {number} generation
 * @property {number} viewers
 * @property {View[]} views
 * @property {Event[]} events
 * @property {number[][]} game  the game's own values by player
 * @property {Peer[]} peers     by player; empty unless sync is deterministic or rollback
 * @property {Buffer[]} buffers  of the players' views
 * @property {Buffered[]} buffered  the states in them
 * @property {Rung[]} ladder    by player, oldest first
 * @property {Measures[]} measures  by player
 * @property {Motion[]} motion  of a motion: the solution, then the methods
 * @property {Shot[]} shots         in a game with weapons; otherwise empty, as shells
 * @property {Shell[]} shells       in flight, of all views
 * @property {Map<number, Section[]>} own  sections that only a lab of its own decodes, by type
 */

/** `bytes` begins with the first of `count` records. @typedef {{bytes: DataView, count: number, stride: number}} Section */

const HEADER = 80, SECTION = 8, VIEW = 64, ENTITY = 32, EVENT = 32, PEER = 64, BUFFER = 32, BUFFERED = 24, RUNG = 24, MOTION = 72,
  SHOT = 80, SHOT_BODY = 24, SHELL_RECORD = 40, MEASURES = 48;

/** @param {DataView} d @param {number} at @param {number} stride @returns {View} */
function view(d, at, stride) {
  const count = Math.min(d.getUint8(at + 1), Math.floor((stride - VIEW) / ENTITY));
  const entities = [];
  for (let i = 0; i < count; i++) {
    const e = at + VIEW + i * ENTITY;
    entities.push({
      x: d.getFloat32(e, true), y: d.getFloat32(e + 4, true), vx: d.getFloat32(e + 8, true),
      vy: d.getFloat32(e + 12, true), angle: d.getFloat32(e + 16, true), age: d.getFloat32(e + 24, true),
      flags: d.getUint32(e + 28, true),
    });
  }
  const flags = d.getUint16(at + 2, true);
  return {
    view: d.getUint8(at), flags, connection: (flags >> CONNECTION_SHIFT) & CONNECTION_MASK, connected: (flags & DROPPED_BY_SERVER) === 0,
    inputSeq: d.getUint32(at + 4, true), ackedSeq: d.getUint32(at + 8, true), unacked: d.getUint32(at + 12, true), lag: d.getFloat32(at + 16, true),
    viewAge: d.getFloat32(at + 20, true), ownLead: d.getFloat32(at + 24, true), remoteError: d.getFloat32(at + 28, true),
    buffer: d.getFloat32(at + 32, true), slack: d.getFloat32(at + 36, true), corrections: d.getUint32(at + 40, true),
    correction: d.getFloat32(at + 44, true), refused: d.getUint32(at + 48, true), alpha: d.getFloat32(at + 52, true),
    shown: d.getFloat64(at + 56, true), entities,
  };
}

/** @param {DataView} d @param {number} at @returns {Event} */
function event(d, at) {
  return {
    id: d.getUint32(at, true), type: d.getUint8(at + 4), player: d.getUint8(at + 5), fate: d.getUint8(at + 6),
    outcome: d.getUint8(at + 7), begin: d.getFloat64(at + 8, true), end: d.getFloat64(at + 16, true),
    number: d.getUint32(at + 24, true), value: d.getFloat32(at + 28, true),
  };
}

/** @param {DataView} d @param {number} at @returns {Peer} */
function peer(d, at) {
  return {
    confirmed: Number(d.getBigInt64(at, true)), tick: Number(d.getBigInt64(at + 8, true)),
    desyncTick: Number(d.getBigInt64(at + 16, true)), waiting: d.getUint32(at + 24, true), stalls: d.getUint32(at + 28, true),
    stalled: d.getFloat32(at + 32, true), rollbacks: d.getUint32(at + 36, true), rollbackTicks: d.getUint32(at + 40, true),
    desyncEntity: d.getInt32(at + 44, true), desyncField: d.getUint32(at + 48, true),
    desyncDistance: d.getFloat32(at + 52, true), desyncUlps: d.getFloat64(at + 56, true),
  };
}

/** @param {DataView} d @param {number} at @returns {Buffer} */
function buffer(d, at) {
  return {
    player: d.getUint8(at), state: d.getUint8(at + 1), delay: d.getFloat32(at + 4, true), behind: d.getFloat32(at + 8, true),
    timeScale: d.getFloat32(at + 12, true), dejitter: d.getFloat32(at + 16, true), underruns: d.getUint32(at + 20, true),
    overruns: d.getUint32(at + 24, true), late: d.getUint32(at + 28, true),
  };
}

/** @param {DataView} d @param {number} at @returns {Buffered} */
function buffered(d, at) {
  return {
    player: d.getUint8(at), place: d.getUint8(at + 1), tick: d.getUint32(at + 4, true), time: d.getFloat32(at + 8, true),
    sent: d.getFloat32(at + 12, true), arrived: d.getFloat32(at + 16, true), due: d.getFloat32(at + 20, true),
  };
}

/** @param {DataView} d @param {number} at @returns {Rung} */
function rung(d, at) {
  const known = d.getUint8(at + 2);
  return {
    player: d.getUint8(at), state: d.getUint8(at + 1), seq: d.getUint32(at + 4, true), made: d.getFloat32(at + 8, true),
    predictedX: known & 1 ? d.getFloat32(at + 12, true) : null, serverX: known & 2 ? d.getFloat32(at + 16, true) : null,
    correction: known === 3 ? d.getFloat32(at + 20, true) : null,
  };
}

/** @param {DataView} d @param {number} at @returns {Measures} */
function measures(d, at) {
  return {
    player: d.getUint8(at), ageOfInformation: d.getFloat32(at + 4, true), errorSum: d.getFloat64(at + 8, true),
    latencySum: d.getFloat64(at + 16, true), errors: d.getUint32(at + 24, true), latencies: d.getUint32(at + 28, true),
    changes: d.getUint32(at + 32, true), lost: d.getUint32(at + 36, true), visibleCorrections: d.getUint32(at + 40, true),
  };
}

/** @param {DataView} d @param {number} at @param {number} stride @returns {Motion} */
function motion(d, at, stride) {
  const count = Math.min(d.getUint16(at + 2, true), (stride - MOTION) / 8);
  const f = (/** @type {number} */ offset) => d.getFloat64(at + offset, true);
  return {
    status: d.getUint8(at + 1), t: f(8), error: f(16), errorMax: f(24), drift: f(32), evaluations: f(40), steps: f(48), rejected: f(56), weightedMax: f(64),
    state: Array.from({ length: count }, (_, k) => f(MOTION + 8 * k)),
  };
}

/** @param {DataView} d @param {number} at @param {number} stride @returns {Shot} */
function shot(d, at, stride) {
  const f = (/** @type {number} */ offset) => d.getFloat32(at + offset, true);
  const bodies = [];
  for (let b = SHOT, count = d.getUint8(at + 2); bodies.length < count && b + SHOT_BODY <= stride; b += SHOT_BODY) {
    bodies.push({ seenX: f(b), seenY: f(b + 4), nowX: f(b + 8), nowY: f(b + 12), lookedX: f(b + 16), lookedY: f(b + 20) });
  }
  return {
    player: d.getUint8(at), weapon: d.getUint8(at + 1), flags: d.getUint8(at + 3), tick: d.getUint32(at + 4, true),
    pressed: d.getFloat64(at + 8, true), seen: d.getFloat64(at + 16, true), judged: d.getFloat64(at + 24, true),
    looked: d.getFloat64(at + 32, true), x: f(40), y: f(44), dx: f(48), dy: f(52), serverX: f(56), serverY: f(60),
    viewHit: d.getInt32(at + 64, true), nowHit: d.getInt32(at + 68, true), serverHit: d.getInt32(at + 72, true),
    perfectHit: d.getInt32(at + 76, true), bodies,
  };
}

/** @param {DataView} d @param {number} at @returns {Shell} */
function shell(d, at) {
  const f = (/** @type {number} */ offset) => d.getFloat32(at + offset, true);
  return {
    view: d.getUint8(at), player: d.getUint8(at + 1), number: d.getUint16(at + 2, true), flown: f(4), x: f(8), y: f(12),
    vx: f(16), vy: f(20), fromX: f(24), fromY: f(28), fromVx: f(32), fromVy: f(36),
  };
}

/** @param {ArrayBuffer} bytes @returns {Frame | null} null when the bytes are no frame */
export function decode(bytes) {
  const d = new DataView(bytes);
  if (bytes.byteLength < HEADER || d.getUint16(0, true) !== 1) return null;
  /** @type {Frame} */
  const frame = {
    flags: d.getUint16(2, true), seq: d.getUint32(4, true), time: d.getFloat64(8, true), head: d.getFloat64(16, true),
    duration: d.getFloat64(24, true), tick: Number(d.getBigInt64(32, true)), speed: d.getFloat64(40, true),
    paramsVersion: d.getUint32(56, true), generation: d.getUint32(60, true), viewers: d.getUint32(64, true),
    views: [], events: [], game: [], peers: [], buffers: [], buffered: [], ladder: [], measures: [], motion: [], shots: [], shells: [],
    own: new Map(),
  };
  let at = HEADER;
  for (let sections = d.getUint32(68, true); sections > 0; sections--) {
    if (at + SECTION > bytes.byteLength) return null;
    const type = d.getUint16(at, true), count = d.getUint16(at + 2, true), size = d.getUint32(at + 4, true);
    at += SECTION;
    if (at + size > bytes.byteLength) return null;
    const stride = count > 0 ? size / count : 0;
    if (type === 1 && stride >= VIEW) {
      for (let i = 0; i < count; i++) frame.views.push(view(d, at + i * stride, stride));
    } else if (type === 2 && stride >= EVENT) {
      for (let i = 0; i < count; i++) frame.events.push(event(d, at + i * stride));
    } else if (type === 3) {
      for (let i = 0; i < count; i++) {
        const values = [];
        for (let k = 0; k + 8 <= stride; k += 8) values.push(d.getFloat64(at + i * stride + k, true));
        frame.game.push(values);
      }
    } else if (type === 5 && stride >= PEER) {
      for (let i = 0; i < count; i++) frame.peers.push(peer(d, at + i * stride));
    } else if (type === 6 && stride >= BUFFER) {
      for (let i = 0; i < count; i++) frame.buffers.push(buffer(d, at + i * stride));
    } else if (type === 7 && stride >= RUNG) {
      for (let i = 0; i < count; i++) frame.ladder.push(rung(d, at + i * stride));
    } else if (type === 8 && stride >= BUFFERED) {
      for (let i = 0; i < count; i++) frame.buffered.push(buffered(d, at + i * stride));
    } else if (type === 16 && stride >= MOTION) {
      for (let i = 0; i < count; i++) frame.motion.push(motion(d, at + i * stride, stride));
    } else if (type === 4 && stride >= SHOT) {
      for (let i = 0; i < count; i++) frame.shots.push(shot(d, at + i * stride, stride));
    } else if (type === 9 && stride >= SHELL_RECORD) {
      for (let i = 0; i < count; i++) frame.shells.push(shell(d, at + i * stride));
    } else if (type === 10 && stride >= MEASURES) {
      for (let i = 0; i < count; i++) frame.measures.push(measures(d, at + i * stride));
    } else if (type > 16) {
      frame.own.set(type, [...(frame.own.get(type) ?? []), { bytes: new DataView(bytes, at, size), count, stride }]);
    }
    at += size;
  }
  return frame;
}
