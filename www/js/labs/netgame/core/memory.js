// What a view shows of the past, gathered from the frames: messages, arrival dots, trails, corrections, curves.
import {
  APPLIED,
  CONNECTION,
  CORRECTION,
  DISCONNECTED,
  DROPPED,
  E_ACTIVE,
  INPUT,
  IS_PLAYING,
  IS_STALLED,
  RECONCILIATION,
  STATE,
  INPUT_RESULT,
  entitiesOf,
} from './frame.js';
import { fixed } from '../../../base/format.js';
import { t } from '../../../base/words.js';

/** @typedef {import('./frame.js').Frame} Frame */
/** @typedef {import('./frame.js').Event} Event */
/** index: among those of its type and player; lag_ms: of the player when it was met.
 * @typedef {Event & {index: number, lag_ms: number}} Met */
/** @typedef {{t: number, entity: number, n: number, x: number, y: number, type: number, player: number, number: number}} Dot
 *   n counts them; type, player and number are those of the event */
/** @typedef {{t: number, x: number, y: number, dx: number, replayed: boolean}} Correction */
/** @typedef {{x: number, y: number}[]} Trail */
/** Events that never came: there were too many while frames were skipped. @typedef {{from: number, to: number, count: number}} Gap */
/** What became of a player's connection; `what` is the end of a key of its words. late: it was at that time or
 * before, when events were missed. @typedef {{t: number, player: number, what: string, late: boolean}} Happening */
/** Means of the last moments; null where nothing was counted.
 * @typedef {{error: number | null, latency: number | null, lost: number | null}} Lately  m, ms, share of the changes of controls */

const EVENTS_S = 5; /* of messages */
const DOTS = 240; /* per view */
const CURVE_POINTS = 4000;
const CORRECTIONS_S = 1;
const TORN_S = 0.3; /* at the speed of real time: 3 frames a second */
const CONNECTION_EVENTS = 40;
export const LATELY_S = 10; /* that means are of */
const SAMPLE_S = 0.2;

/** Curves of one player over the common time axis. */
export class Curves {
  constructor() {
    /** @type {(number | null)[]} */ this.own = [];
    /** @type {(number | null)[]} */ this.remote = [];
    /** @type {(number | null)[]} */ this.ownAge = [];
    /** @type {(number | null)[]} */ this.remoteAge = [];
    /** @type {(number | null)[]} */ this.buffer = [];
  }
}

const listsOf = (/** @type {Curves} */ of) => [of.own, of.remote, of.ownAge, of.remoteAge, of.buffer];

const slotOf = (/** @type {number} */ type, /** @type {number} */ player) => type * 256 + player;

/** Of one stretch of time: where time jumps, a new one begins. */
export class Memory {
  /** @param {boolean} flights whether what flies is followed, and not the players @param {number} generation */
  constructor(flights, generation) {
    this.flights = flights;
    this.generation = generation;
    /** @type {Frame | null} */
    this.last = null;
    /** @type {Map<number, Met>} */
    this.events = new Map();
    /** @type {Map<number, Met[]>} the same by type and player, in the order of time */
    this.lists = new Map();
    /** @type {Map<number, number>} messages so far by type and player: thinning draws every k-th of them */
    this.counts = new Map();
    /** @type {Dot[][]} by view */
    this.dots = [];
    /** @type {Trail[][]} by view, by entity: of the present or last flight */
    this.trails = [];
    /** @type {Correction[][]} by player */
    this.corrections = [];
    /** @type {number[]} largest correction by player, m */
    this.largest = [];
    /** @type {Set<number>[]} refused inputs by player */
    this.refused = [];
    /** @type {number[]} */
    this.times = [];
    /** @type {Curves[]} by player */
    this.curves = [];
    /** @type {Gap[]} */
    this.gaps = [];
    this.heard = 0; /* s, until when events are known */
    /** @type {Happening[]} */
    this.connectionEvents = [];
    /** @type {{t: number, of: import('./frame.js').Measures[]}[]} */
    this.measures = [];
    this.highest = 0; /* m, of what has been drawn */
  }

  /** @param {Frame} frame */
  take(frame) {
    const players = frame.views.length - 1;
    for (let v = 0; v <= players; v++) {
      this.dots[v] ??= [];
      this.trails[v] ??= [];
    }
    for (let p = 0; p < players; p++) {
      this.corrections[p] ??= [];
      this.largest[p] ??= 0;
      this.refused[p] ??= new Set();
      this.curves[p] ??= new Curves();
    }
    this.miss(frame);
    for (const event of frame.events) {
      if (!this.events.has(event.id) && event.begin_s <= frame.time_s + 1e-6) this.meet(frame, event);
    }
    if (frame.lost > 0) this.conclude(frame);
    if (this.last === null || frame.time_s > this.last.time_s) {
      this.follow(frame);
      this.plot(frame);
      this.measure(frame);
    }
    this.forget(frame.time_s);
    this.last = frame;
  }

  /** @param {Frame} frame */
  miss(frame) {
    const to = frame.events[0]?.begin_s ?? frame.time_s;
    if (frame.lost > 0) this.gaps.push({ from: Math.min(this.heard, to), to, count: frame.lost });
    this.heard = frame.time_s;
  }

  /** Events of one type and player, the oldest first. @param {number} type @param {number} player @returns {Met[]} */
  of(type, player) {
    return this.lists.get(slotOf(type, player)) ?? [];
  }

  /** @param {Frame} frame @param {Event} event */
  meet(frame, event) {
    const slot = slotOf(event.type, event.player);
    const index = this.counts.get(slot) ?? 0;
    this.counts.set(slot, index + 1);
    const met = { ...event, index, lag_ms: frame.views[1 + event.player]?.lag_ms ?? 0 };
    this.events.set(event.id, met);
    const list = this.lists.get(slot);
    if (list) list.push(met);
    else this.lists.set(slot, [met]);
    const fresh = this.last !== null && event.begin_s > this.last.time_s - 0.001; /* else it is not known where it was drawn */
    if (event.type === APPLIED && fresh) this.dot(frame, 1 + event.player, event, index);
    if (event.type === INPUT_RESULT && fresh) this.dot(frame, 0, event, index);
    if (event.type === INPUT_RESULT && event.outcome === 1) this.refused[event.player]?.add(event.number);
    if (event.type === CONNECTION || event.type === DROPPED) this.happen(event);
    if (event.type === CORRECTION) {
      const view = frame.views[1 + event.player];
      const car = entitiesOf(frame, 1 + event.player)[event.player];
      this.largest[event.player] = Math.max(this.largest[event.player] ?? 0, Math.abs(event.value));
      if (view && car && fresh) {
        this.corrections[event.player]?.push({
          t: event.begin_s,
          x: car.x,
          y: car.y,
          dx: event.value,
          replayed: (view.flags & RECONCILIATION) !== 0,
        });
      }
    }
  }

  /** @param {Event} event */
  happen(event) {
    if (event.type === DROPPED) this.list({ t: event.begin_s, player: event.player, what: 'dropped', late: false });
    else this.become(event.player, event.outcome, event.begin_s, event.number <= 1, false);
  }

  /** What became of connections while events were missed: by the states before and after. @param {Frame} frame */
  conclude(frame) {
    frame.views.slice(1).forEach((now, player) => {
      const before = this.last?.views[1 + player];
      const known = frame.events.some((event) => event.player === player && (event.type === CONNECTION || event.type === DROPPED));
      if (!before || known || frame.time_s <= (this.last?.time_s ?? 0)) return;
      if (before.connected && !now.connected) this.list({ t: frame.time_s, player, what: 'dropped', late: true });
      if (before.connection !== now.connection) this.become(player, now.connection, frame.time_s, false, true);
    });
  }

  /** @param {number} player @param {number} state of its connection @param {number} t
   * @param {boolean} first whether it has not played before @param {boolean} late whether it may have been earlier */
  become(player, state, t, first, late) {
    let what = '';
    if (state === IS_STALLED) what = 'stalled';
    if (state === DISCONNECTED) what = 'disconnected';
    if (state === IS_PLAYING && t > 0) {
      const last = this.connectionEvents.filter((one) => one.player === player).at(-1)?.what;
      what = last === 'stalled' ? 'playing' : first ? 'joined' : 'joined_again';
    }
    if (what !== '') this.list({ t, player, what, late });
  }

  /** @param {Happening} one */
  list(one) {
    this.connectionEvents = [...this.connectionEvents.slice(1 - CONNECTION_EVENTS), one];
  }

  /** @param {Frame} frame @param {number} v @param {Event} event @param {number} n */
  dot(frame, v, event, n) {
    const dots = this.dots[v];
    if (!dots) return;
    entitiesOf(frame, v).forEach((e, entity) => {
      const wanted = this.flights ? (e.flags & E_ACTIVE) !== 0 : entity === event.player;
      if (wanted && (!this.flights || v > 0 || entity === event.player)) {
        dots.push({ t: event.begin_s, entity, n, x: e.x, y: e.y, type: event.type, player: event.player, number: event.number });
      }
    });
    if (dots.length > DOTS) dots.splice(0, dots.length - DOTS);
  }

  /** Description of a dot. @param {Dot} dot @returns {string} */
  describe(dot) {
    const type = dot.type === APPLIED ? STATE : INPUT;
    const text = t(type === STATE ? 'netgame.dot.snapshot' : 'netgame.dot.input', { n: String(dot.number), time: fixed(dot.t, 2) });
    for (const event of this.events.values()) {
      if (event.type === type && event.player === dot.player && event.number === dot.number)
        return text + t('netgame.dot.sent', { time: fixed(event.begin_s, 2), age: fixed((dot.t - event.begin_s) * 1000, 0) });
    }
    return text;
  }

  /** Whether frames were skipped before this one for so long that a straight line would not be what happened. @param {Frame} frame */
  torn(frame) {
    return this.last !== null && frame.time_s - this.last.time_s > TORN_S * Math.max(1, frame.session.speed);
  }

  /** Flights: a trail grows while its entity is active. @param {Frame} frame */
  follow(frame) {
    frame.views.forEach((_, v) =>
      entitiesOf(frame, v).forEach((e, i) => {
        this.highest = Math.max(this.highest, e.y);
        const trails = this.trails[v];
        if (!trails || (e.flags & E_ACTIVE) === 0) return;
        const before = this.last ? entitiesOf(this.last, v)[i] : undefined;
        if (!before || (before.flags & E_ACTIVE) === 0) {
          trails[i] = [];
          this.dots[v] = (this.dots[v] ?? []).filter((dot) => dot.entity !== i || dot.t >= frame.time_s - 0.02);
        }
        const trail = (trails[i] ??= []);
        const end = trail[trail.length - 1];
        if (this.torn(frame) && end) trail.push({ x: NaN, y: NaN });
        if (!end || end.x !== e.x || end.y !== e.y) trail.push({ x: e.x, y: e.y });
      }),
    );
  }

  /** @param {Frame} frame */
  plot(frame) {
    if (this.torn(frame)) {
      this.times.push(frame.time_s - TORN_S / 2); /* with no value */
      for (const curve of this.curves) for (const values of listsOf(curve)) values.push(null);
    }
    this.times.push(frame.time_s);
    this.curves.forEach((curve, p) => {
      const view = frame.views[1 + p];
      curve.own.push(view?.own_lead_m ?? 0);
      curve.remote.push(view?.remote_error_m ?? 0);
      curve.ownAge.push(entitiesOf(frame, 1 + p)[p]?.age_ms ?? 0);
      curve.remoteAge.push(view?.view_age_ms ?? 0);
      curve.buffer.push(view?.buffer_ms ?? null);
    });
    if (this.times.length > CURVE_POINTS) {
      const drop = CURVE_POINTS / 4;
      this.times.splice(0, drop);
      for (const curve of this.curves) for (const values of listsOf(curve)) values.splice(0, drop);
    }
  }

  /** @param {Frame} frame */
  measure(frame) {
    const newest = this.measures[this.measures.length - 1];
    if (newest && frame.time_s - newest.t < SAMPLE_S) return;
    this.measures.push({ t: frame.time_s, of: frame.measures });
    while ((this.measures[1]?.t ?? Infinity) <= frame.time_s - LATELY_S) this.measures.shift();
  }

  /** Means of the last LATELY_S. @param {number} player @returns {Lately} */
  lately(player) {
    const from = this.measures[0]?.of[player],
      to = this.last?.measures[player];
    if (!from || !to) return { error: null, latency: null, lost: null };
    const mean = (/** @type {number} */ sum, /** @type {number} */ count) => (count > 0 ? sum / count : null);
    return {
      error: mean(to.own_timeline_error_sum_m - from.own_timeline_error_sum_m, to.own_timeline_errors - from.own_timeline_errors),
      latency: mean(to.input_latency_sum_ms - from.input_latency_sum_ms, to.input_latencies - from.input_latencies),
      lost: mean(to.input_changes_lost - from.input_changes_lost, to.input_changes - from.input_changes),
    };
  }

  /** @param {number} now */
  forget(now) {
    for (const [id, event] of this.events) {
      if (Math.max(event.begin_s, event.end_s) >= now - EVENTS_S) break; /* ids are in the order of time */
      this.events.delete(id);
      this.lists.get(slotOf(event.type, event.player))?.shift();
    }
    while ((this.gaps[0]?.to ?? now) < now - EVENTS_S) this.gaps.shift();
    for (const list of this.corrections) {
      while (list.length > 0 && /** @type {Correction} */ (list[0]).t < now - CORRECTIONS_S) list.shift();
    }
    for (const set of this.refused) {
      for (const number of set) {
        if (set.size <= 64) break;
        set.delete(number);
      }
    }
  }
}
