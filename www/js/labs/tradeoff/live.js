// A setting that runs: a session of its own on the daemon, freed once it has run or is left. A motion is read tick by tick, so that its
// path is round on every machine; what has more to draw than that comes as a stream.
import { signal } from '../../../vendor/signals-core.js';
import { address, call, make } from '../../base/api.js';
import { readLink } from '../../base/link.js';
import { Stream } from '../../stream/connection.js';
import { ENDED, FAILED } from '../../stream/frame.js';
import { kindOf } from './names.js';

/** @typedef {import('./results.js').Row} Row */
/** @typedef {import('../../stream/frame.js').Frame} Frame */
/** What a motion was at each tick: `exact` and `own` have a number for each component.
 * @typedef {{hz: number, exact: Float64Array[], own: Float64Array[]}} History */

const DIVERGENCE = 4; /* the field of a grid's fluid */
const PLAY_S = 7; /* a motion is shown in that time, however long it is */
/** Channels by kind, Hz. @type {Record<string, Record<string, number>>} */
const CHANNELS = {
  rigid: { session: 30, bodies: 30 },
  fluid: { session: 20, field: 20, points: 20 },
  netgame: { session: 60, scene: 60 },
};

const calm = () => matchMedia('(prefers-reduced-motion: reduce)').matches;

/** A table of `motion_state`, as CSV. @param {string} text @returns {History} */
function historyOf(text) {
  const lines = text.split('\n'),
    ticks = lines.length,
    /** @type {Float64Array[][]} */
    lists = [[], []];
  let most = 0,
    until = 0,
    last = 0;
  for (let i = 1; i < ticks; i++) {
    const [time, tick, motion, component, value] = (lines[i] ?? '').split(',').map(Number);
    if (tick === undefined || motion === undefined || component === undefined || value === undefined || motion > 1) continue;
    const list = /** @type {Float64Array[]} */ (lists[motion]);
    list[component] ??= new Float64Array(Math.ceil(ticks / 2)).fill(Number.NaN);
    /** @type {Float64Array} */ (list[component])[tick] = value;
    if (tick > most) [most, until] = [tick, time ?? 0];
    last = Math.max(last, tick);
  }
  const cut = (/** @type {Float64Array[]} */ list) => list.map((one) => one.subarray(0, last + 1));
  return { hz: until > 0 ? most / until : 60, exact: cut(lists[0] ?? []), own: cut(lists[1] ?? []) };
}

/** One run, of the winner or of what it is compared with. */
export class Run {
  /** @param {Row} row @param {{scenario: string, error: string}} problem @param {() => void} changed there is something new to draw */
  constructor(row, { scenario, error }, changed) {
    this.row = row;
    this.scenario = scenario;
    this.error = error; /* path of the metric */
    this.kind = kindOf(scenario);
    this.changed = changed;
    /** @type {'waiting' | 'running' | 'done' | 'failed'} */
    this.state = 'waiting';
    /** @type {Stream | null} */
    this.stream = null;
    /** @type {{id: string, owner_key: string} | null} */
    this.session = null;
    this.left = false;
    /** @type {History | null} */
    this.history = null;
    /** What the hello says of the session. @type {any} */
    this.layout = null;
    /** @type {Frame | null} */
    this.frame = null;
    /** The first frame. @type {Frame | null} */
    this.first = null;
    this.from = 0; /* ms, when a motion was begun */
    /** What a drawing of it remembers from frame to frame. @type {any} */
    this.memory = null;
    this.start();
  }

  /** Where a motion is, in ticks. */
  get tick() {
    const ticks = (this.history?.exact[0]?.length ?? 1) - 1;
    return this.state === 'done' ? ticks : Math.min(ticks, ((performance.now() - this.from) / 1000 / PLAY_S) * ticks);
  }

  async start() {
    const asked = readLink(this.row.link, '');
    try {
      const made = await make(
        'sessions',
        {
          scenario: this.scenario,
          set: { ...asked.set, ...(this.error.startsWith('divergence') ? { shown: DIVERGENCE } : {}) },
          ...(asked.seed === null ? {} : { seed: asked.seed }),
          ...(this.kind === 'motion' || calm() ? { paused: true } : {}),
        },
        false,
      );
      this.session = made;
      if (this.left) this.free();
      else if (this.kind === 'motion') await this.readMotion();
      else await this.listen();
    } catch {
      if (!this.left) this.end('failed');
    }
  }

  /** @param {Record<string, unknown>} op */
  control(op) {
    return call('POST', `sessions/${this.session?.id}/control`, { body: op, key: this.session?.owner_key ?? '' });
  }

  /** To the end of the scenario. */
  async toEnd() {
    const { duration_s, tick_hz } = await call('GET', `sessions/${this.session?.id}`);
    await this.control({ op: 'seek', tick: Math.round(duration_s * tick_hz) });
  }

  async readMotion() {
    await this.toEnd();
    const answer = await fetch(address(`sessions/${this.session?.id}/trace?of=motion_state&format=csv`), { cache: 'no-store' });
    const text = await answer.text();
    this.free();
    if (this.left) return;
    this.history = historyOf(text);
    this.replay();
  }

  /** A motion from its start. */
  replay() {
    this.from = performance.now();
    this.state = calm() ? 'done' : 'running';
    states.value++;
    this.changed();
    if (this.state === 'running')
      setTimeout(() => {
        if (performance.now() - this.from >= PLAY_S * 1000 - 50) this.end('done');
      }, PLAY_S * 1000);
  }

  async listen() {
    const { id = '', owner_key: key = '' } = this.session ?? {};
    if (calm()) await this.toEnd();
    if (this.left) return this.free();
    const stream = new Stream(
      id,
      key,
      {
        hello: ({ layout, params }) => {
          this.layout = { ...layout, params };
          states.value++;
        },
        frame: (frame) => {
          this.first ??= frame;
          this.frame = frame;
          if (this.state === 'waiting') {
            this.state = 'running';
            states.value++;
          }
          requestAnimationFrame(() => stream.send({ ack: frame.seq }));
          this.changed();
          if (frame.flags & FAILED) this.end('failed');
          else if (frame.flags & ENDED || (calm() && frame.tick > 0)) this.end('done');
        },
        state: () => {},
        pace: () => {},
        gone: () => this.end('done'),
        refused: () => {},
      },
      undefined,
      { ...CHANNELS[this.kind], ...(this.error.includes('.shots.') ? { shots: 60 } : {}) },
    );
    this.stream = stream;
  }

  /** @param {'done' | 'failed'} state what was drawn last stays */
  end(state) {
    this.state = state;
    this.free();
    if (this.left) return;
    states.value++;
    this.changed();
  }

  /** The session is of no more use. */
  free() {
    this.stream?.close();
    this.stream = null;
    const { id, owner_key: key } = this.session ?? {};
    this.session = null;
    if (id) call('DELETE', `sessions/${id}`, { key: key ?? '' }).catch(() => {});
  }

  leave() {
    this.left = true;
    this.free();
  }
}

const SETTLE_MS = 250; /* a handle that is dragged passes many settings */

/** @type {import('@preact/signals-core').Signal<(Run | null)[]>} */
export const runs = signal([null, null]);
/** Grows with what there is to draw. */
export const changes = signal(0);
/** Grows where a run has begun, or has ended. */
export const states = signal(0);

/** @type {ReturnType<typeof setTimeout> | undefined} */
let settling;
let wanted = '';

/** @param {Row | undefined} row */
const keyOf = (row) => (row ? row.link : '');

/** Runs these, once they have been wanted for a moment; those that run already go on. @param {(Row | undefined)[]} rows
 * @param {(row: Row) => import('./results.js').Question} problemOf */
export function want(rows, problemOf) {
  const key = rows.map(keyOf).join(' ');
  if (key === wanted) return;
  const first = wanted === '';
  wanted = key;
  clearTimeout(settling);
  settling = setTimeout(
    () => {
      runs.value = rows.map((row, place) => {
        const before = runs.peek()[place] ?? null;
        if (before && row && keyOf(before.row) === keyOf(row)) return before;
        before?.leave();
        return row ? new Run(row, problemOf(row), () => changes.value++) : null;
      });
    },
    first ? 0 : SETTLE_MS,
  );
}

/** All of them from the start. */
export function again() {
  runs.value = runs.peek().map((run) => {
    if (run === null) return null;
    if (run.history) {
      run.replay();
      return run;
    }
    run.leave();
    return new Run(run.row, run, run.changed);
  });
}

/** Nothing runs. */
export function leaveAll() {
  clearTimeout(settling);
  wanted = '';
  for (const run of runs.peek()) run?.leave();
  runs.value = [null, null];
}
addEventListener('pagehide', leaveAll);
