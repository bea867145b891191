// Two runs of one scenario from the same start: the page's session, and a second that is made from it and follows its time.
import { batch, effect, signal, untracked } from '../../../../vendor/signals-core.js';
import { Problem, address, call, make } from '../../../base/api.js';
import { ENDED, PLAYING } from '../../../stream/frame.js';
import { Stream } from '../../../stream/connection.js';
import { link } from '../../../session/opening.js';
import { change, showAddress } from '../../../session/params.js';
import { locked, notify, params, session } from '../../../session/state.js';
import { touch } from '../../../draw/redraw.js';
import { Memory } from '../core/memory.js';
import { layout } from '../core/layout.js';
import { memory } from '../core/state.js';
import { curvesOf, readTrace } from './curves.js';
import { Pair } from './pair.js';
import { say } from './words.js';

/** @typedef {import('../core/frame.js').Frame} Frame */
/** @typedef {import('../../../base/link.js').Value} Value */
/** @typedef {{id: string, key: string}} Run */

/** How long a comparison may be, s: a change computes all of it again. */
const LENGTHS_S = [10, 30, 60, 120, 300, 600];
const USUAL_S = 120;
const MOST_TICKS = 100000; /* of a trace */
const WISH = { session: 60, scene: 60, lanes: 60 };
const ATTEMPTS = 8; /* of a request that the daemon ends for its processor time, and which goes on from there */

/** Whether two runs are shown. */
export const active = signal(false);
/** Whether the daemon is at work for what was asked. */
export const working = signal(false);
/** How long the runs may be, s: the choices that their duration allows, the last of them the whole of it or the most.
 * @type {import('@preact/signals-core').Signal<number[]>} */
export const lengths = signal([]);
/** How much of them is compared, s. */
export const length = signal(0);
/** The parameters of the second run. @type {import('@preact/signals-core').Signal<any>} */
export const secondParams = signal(null);
/** @type {import('@preact/signals-core').Signal<[import('./curves.js').Trace | null, import('./curves.js').Trace | null]>} */
export const traces = signal([null, null]);

/** @type {Run | null} */
let first = null;
/** @type {Run | null} */
let second = null;
/** @type {Stream | null} */
let stream = null;
let pair = new Pair();
let other = new Memory(false, -1);
/** @type {[Frame, Frame] | null} */
let shown = null;
let met = 0; /* ms, when both last had a tick in common */
/** Of the second run; empty while there is none. */
export const idOf = () => second?.id ?? '';
/** The parameters of the first run that its curves were made with. */
let made = '';
let about = { hz: 60, end: 0 };

/** @param {Run} run @param {Record<string, unknown>} op */
const control = ({ id, key }, op) => call('POST', `sessions/${id}/control`, { body: op, key });

/** @type {Promise<unknown>} */
let last = Promise.resolve();
let waiting = 0;
/** One thing after the other. @param {() => Promise<unknown>} job */
function inTurn(job) {
  waiting++;
  working.value = true;
  last = last.then(job).catch((error) => {
    if (active.value) notify(say('not_done', { why: error instanceof Error ? error.message : say('no_answer') }));
  });
  return last.then(() => {
    waiting--;
    working.value = waiting > 0;
    touch();
  });
}

/** Runs to the end, and reads the trace. @param {0 | 1} side @param {Run} run */
async function read(side, run) {
  for (let attempt = 1; ; attempt++) {
    try {
      await control(run, { op: 'seek', tick: about.end });
      break;
    } catch (error) {
      if (attempt === ATTEMPTS || !(error instanceof Problem) || error.status !== 503) throw error;
    }
  }
  const answer = await fetch(address(`sessions/${run.id}/trace?to_s=${about.end / about.hz}`), { cache: 'no-store' });
  if (!answer.ok) throw new Problem(answer.status, null);
  const trace = readTrace(await answer.text(), about.hz, curvesOf(layout.value?.players.length ?? 0));
  if (side === 0) made = JSON.stringify(params.value);
  traces.value = side === 0 ? [trace, traces.value[1]] : [traces.value[0], trace];
}

/** Where the time is, of both. @returns {{tick: number, playing: boolean}} */
function now() {
  const frame = pair.newest(0);
  return { tick: Math.min(frame?.tick ?? 0, about.end), playing: frame !== null && (frame.flags & PLAYING) !== 0 };
}

/** Until frames of both show that tick; at most 0.4 s, since a page that is hidden gets none. @param {number} tick */
async function arrived(tick) {
  for (let tries = 0; tries < 20 && [0, 1].some((side) => pair.newest(/** @type {0 | 1} */ (side))?.tick !== tick); tries++)
    await new Promise((done) => setTimeout(done, 20));
}

/** Does something to runs at tick 0, reads their curves again, and returns both to where they were.
 * @param {(0 | 1)[]} sides @param {() => Promise<unknown>} job @param {{tick: number, playing: boolean}} to */
async function anew(sides, job, to) {
  const runs = /** @type {[Run, Run]} */ ([first, second]);
  await Promise.all(runs.map((run) => control(run, { op: 'pause' })));
  try {
    await job();
    await Promise.all(
      sides.map(async (side) => {
        await control(runs[side], { op: 'restart', reset: false });
        await read(side, runs[side]);
      }),
    );
  } finally {
    await Promise.all(runs.map((run) => control(run, { op: 'seek', tick: to.tick })));
    await arrived(to.tick);
    if (to.playing) await control(runs[0], { op: 'play' });
  }
}

/** Changes a setting of a run, from its start on. @param {0 | 1} side @param {Record<string, Value>} values by path */
export function set(side, values) {
  if (locked.value !== '') return Promise.resolve();
  return inTurn(async () => {
    const run = second;
    if (run === null) return;
    const job = async () => {
      if (side === 0) return change(values);
      secondParams.value = (await call('PATCH', `sessions/${run.id}/params`, { body: values, key: run.key })).params;
    };
    await anew([side], job, now());
  });
}

/** How much is compared where nothing is said. */
export const usual = () => lengths.value.filter((one) => one <= USUAL_S).pop() ?? lengths.value[0] ?? 0;

/** @param {number} seconds @param {number} hz */
const ticksOf = (seconds, hz) => Math.min(Math.floor(seconds * hz), MOST_TICKS - 1);

/** Compares another part of both runs. @param {number} seconds one of `lengths` */
export function lengthen(seconds) {
  return inTurn(async () => {
    if (second === null || seconds === length.value) return;
    const to = now();
    about.end = ticksOf(seconds, about.hz);
    length.value = seconds;
    await anew([0, 1], async () => {}, { ...to, tick: Math.min(to.tick, about.end) });
  });
}

/** @param {Run} run */
function listen(run) {
  stream = new Stream(
    run.id,
    run.key,
    {
      hello() {
        other = new Memory(layout.value?.controls === 'aim', -1);
        pair.rings[1].length = 0;
      },
      frame(frame) {
        if (frame.session.generation !== other.generation) other = new Memory(other.flights, frame.session.generation);
        other.take(frame);
        pair.take(1, frame);
        stream?.send({ ack: frame.seq });
        touch();
      },
      state() {},
      pace() {},
      gone() {
        notify(say('expired'));
        close();
      },
      refused() {},
    },
    undefined,
    WISH,
  );
}

/** Leaves the first run as it is, and deletes the second. @param {boolean} [leaving] the page */
export function close(leaving = false) {
  const run = second;
  stream?.close();
  stream = null;
  first = second = shown = null;
  pair = new Pair();
  if (run !== null) {
    const how = { method: 'DELETE', headers: { Authorization: `Bearer ${run.key}` }, keepalive: leaving };
    fetch(address(`sessions/${run.id}`), how).catch(() => {});
  }
  if (leaving) return;
  link.second = '';
  batch(() => {
    active.value = false;
    traces.value = [null, null];
    secondParams.value = null;
  });
  showAddress();
  touch();
}

/** A second run from the start of the present one. @param {Record<string, Value>} values what differs in it
 * @param {number} seconds how much is compared; 0 for as much as usual */
export function begin(values, seconds) {
  const of = session.value;
  if (active.value || of === null || locked.value !== '') return;
  active.value = true;
  first = { id: of.id, key: of.key };
  inTurn(async () => {
    const run = /** @type {Run} */ (first);
    const { tick_hz: hz, duration_s: duration, tick } = await call('GET', `sessions/${run.id}`);
    const most = Math.min(duration, LENGTHS_S[LENGTHS_S.length - 1] ?? 0, (MOST_TICKS - 1) / hz);
    lengths.value = [...LENGTHS_S.filter((one) => one < most), most];
    length.value = lengths.value.find((one) => one === seconds) ?? usual();
    about = { hz, end: ticksOf(length.value, hz) };
    await control(run, { op: 'pause' });
    const persons = (params.value?.players ?? []).flatMap((/** @type {any} */ player, /** @type {number} */ p) =>
      player.control === 'person' ? [[`players.${p}.control`, 'script']] : [],
    );
    if (persons.length > 0) await change(Object.fromEntries(persons));
    await control(run, { op: 'restart', reset: false });
    const copy = await make(`sessions/${run.id}/fork`);
    const next = { id: copy.id, key: copy.owner_key };
    if (!active.value || first !== run) {
      await call('DELETE', `sessions/${next.id}`, { key: next.key });
      return;
    }
    second = next;
    secondParams.value = (await call('GET', `sessions/${next.id}`)).params;
    listen(next);
    const job = async () => {
      if (Object.keys(values).length === 0) return;
      secondParams.value = (await call('PATCH', `sessions/${next.id}/params`, { body: values, key: next.key })).params;
    };
    await anew([0, 1], job, { tick: Math.min(tick, about.end), playing: false });
  }).then(() => {
    if (active.value && second === null) close();
  });
}

/** A frame of the first run has come. @param {Frame} frame */
export function take(frame) {
  pair.take(0, frame);
}

let steering = false;
/** The second run does what the first does. */
function follow() {
  const one = pair.newest(0),
    two = pair.newest(1),
    run = second;
  if (steering || working.value || !one || !two || !run) return;
  const playing = (one.flags & PLAYING) !== 0,
    also = (two.flags & PLAYING) !== 0;
  const { speed } = one.session;
  const far = Math.abs(one.tick - two.tick) > about.hz * 0.5 * Math.max(1, speed);
  /** @type {Record<string, unknown> | null} */
  let op = null;
  if (Math.abs(speed - two.session.speed) > 1e-6 * speed) op = { op: 'speed', speed: Number(speed.toPrecision(7)) };
  else if (playing ? far : also || one.tick !== two.tick) op = { op: 'seek', tick: one.tick };
  else if (playing && !also && (two.flags & ENDED) === 0) op = { op: 'play' };
  if (op === null) return;
  steering = true;
  control(run, op)
    .catch(() => {})
    .then(() => {
      steering = false;
      touch();
    });
}

/** The frames to draw: of one tick. With what is remembered of each.
 * @returns {{frames: [Frame, Frame], memories: [Memory, Memory]} | null} */
export function newest() {
  follow();
  if (!working.value) {
    const time = performance.now(),
      exact = pair.common(false);
    if (exact) met = time;
    shown = exact ?? (time - met > 250 ? pair.common(true) : null) ?? shown;
  }
  return shown === null ? null : { frames: shown, memories: [memory, other] };
}

effect(() => {
  const id = session.value?.id;
  if (active.peek() && first !== null && id !== first.id) untracked(() => close());
});
effect(() => {
  /* another page, or Reset, has changed the first run */
  const text = JSON.stringify(params.value);
  if (working.value || !active.peek() || made === '' || second === null || text === made) return;
  untracked(() => inTurn(() => anew([0], async () => {}, now())));
});
addEventListener('pagehide', () => {
  if (active.value) close(true);
});
