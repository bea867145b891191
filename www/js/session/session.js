// The session of the page: joined, created, copied or created again; and its stream.
import { batch, effect, untracked } from '../../vendor/signals-core.js';
import { Problem, call, make } from '../base/api.js';
import { Stream } from '../stream/connection.js';
import { FAILED } from '../stream/frame.js';
import { readLink, readScenario } from '../base/link.js';
import { front, lab, labs } from './labs.js';
import { create, createFirst, keep, link, problems } from './opening.js';
import { seen, showAddress, stopReading } from './params.js';
import {
  FRAME_HZ,
  connection,
  divisor,
  experiment,
  failure,
  frame,
  held,
  layout,
  lesson,
  locked,
  notify,
  params,
  place,
  scenarios,
  session,
  stopTick,
  tradeoff,
} from './state.js';
import { ready, t } from '../base/words.js';

/** @typedef {import('../stream/frame.js').Frame} Frame */
/** @typedef {import('./lab.js').Lab} Lab */

/** Counted for tests and for the curious: see window.laglab. */
export const counts = { received: 0, drawn: 0, acked: 0, hellos: 0 };

/** @type {Stream | null} */
let stream = null;
/** The newest received frame, not yet drawn. @type {Frame | null} */
let newest = null;
let arrived = () => {};
/** The lab that follows the present stream. @type {Lab | null} */
let following = null;

/** @param {any} hello @returns {import('./state.js').Layout} */
function layoutOf({ layout: given = {}, params: now = {} }) {
  const kind = now.kind ?? '';
  return { kind, game: given.game ?? now.game ?? kind, given, params: now };
}

/** Begins the lab that is shown: after a hello, or once the lab is read. @param {boolean} fresh */
function follow(fresh) {
  following = lab.peek() ?? null;
  following?.begin?.(fresh);
}
effect(() => {
  const now = lab.value;
  if (now === undefined || layout.peek() === null || stream === null || following?.template === now.template) return;
  untracked(() => follow(true));
});

/** What is subscribed to, Hz by channel: of all labs, since the kind of a session is known after its hello. Another kind has none of
 * those channels. @returns {Record<string, number>} */
function wishOf() {
  const wish = Object.assign({ session: FRAME_HZ }, ...labs.value.map(({ rates }) => rates), lab.value?.rates?.());
  const most = place.value.hz || FRAME_HZ;
  return Object.fromEntries(
    Object.entries(wish)
      .filter(([, hz]) => hz > 0)
      .map(([channel, hz]) => [channel, Math.min(hz, most)]),
  );
}
/** Asks for what is wanted, where that is other than what was asked for. */
function ask() {
  const wish = wishOf();
  if (stream && JSON.stringify(wish) !== JSON.stringify(stream.wish)) stream.subscribe(wish);
}
effect(ask);

/** Closes the stream: no session is shown. */
function close() {
  stream?.close();
  stream = null;
  newest = null;
  session.value = null;
}

/** Deletes the session that the page made for itself. @param {import('./state.js').Session | null} which */
function drop(which) {
  if (!which?.own || !which.key) return;
  stopReading(which.id);
  call('DELETE', `sessions/${which.id}`, { key: which.key }).catch(() => {});
}

/** From the lessons to a lab: a step of the browser's history, so that Back returns. */
function leaveLesson() {
  if (lesson.value === null) return;
  history.pushState(null, '', location.href);
  batch(() => {
    lesson.value = null;
    held.value = '';
    stopTick.value = 0;
  });
}

/** The lesson's session goes on in its lab, with every setting. */
export function toSandbox() {
  leaveLesson();
  showAddress();
}

/** Shows the session of the first page, if that is still what is shown. @param {Promise<import('./opening.js').Opened>} made
 * @param {Promise<import('../stream/connection.js').Line>} [line] its stream */
export async function showFirst(made, line) {
  const { id, key } = await made,
    open = await line;
  if (lesson.value?.id !== '' || session.value !== null) drop({ id, key, own: true });
  else show(id, key, true, open);
}

/** Shows a place among the lessons. What a lesson needs of sessions it makes itself. @param {import('../base/link.js').LessonAt} at
 * @param {boolean} [step] whether it is a step of the browser's history */
export function openLesson(at, step = false) {
  if (step) history.pushState(null, '', location.href);
  if (at.id === '' || at.id !== lesson.value?.id) {
    const before = session.value;
    close();
    drop(before);
  }
  batch(() => {
    if (session.value === null) frame.value = null;
    experiment.value = null;
    tradeoff.value = null;
    lesson.value = at;
    held.value = '';
    stopTick.value = 0;
  });
  if (step) showAddress();
  const start = front()?.start;
  if (at.id === '' && start) showFirst(createFirst(start)).catch(failed);
}

/** A session of the lesson's own, paused at its start. @param {string} scenario
 * @param {Record<string, import('../base/link.js').Value>} set @param {number} seed @param {number} speed
 * @param {() => boolean} wanted asked when it is made: whether it is still to be shown @param {object | null} [workload] what players do */
export async function showForLesson(scenario, set, seed, speed, wanted, workload = null) {
  Object.assign(link, { scenario, set: { ...set }, seed, workload, session: '', problems: [] });
  const made = await create({ paused: true, speed }),
    next = { id: made.id, key: made.key, own: true };
  if (!wanted()) return drop(next);
  const before = session.value;
  show(made.id, made.key, true);
  drop(before);
  if (link.problems.length > 0) notify(problems(), true);
}

/** Shows the board of a class, in place of the list of questions or of a lesson. @param {string} id @param {string} key */
export function showBoard(id, key) {
  const before = session.value;
  leaveLesson();
  show(id, key, false);
  drop(before);
}

/** Leaves the session for the Experiments view. @param {string} id of the experiment; empty for none */
export function openExperiments(id) {
  const of = lesson.value === null ? null : session.value;
  leaveLesson();
  close();
  drop(of);
  batch(() => {
    experiment.value = id;
    tradeoff.value = null;
  });
  document.title = t('session.title', { name: t('session.experiments') });
  showAddress();
}

/** Leaves the session for speed against error. @param {string} at in the address
 * @param {boolean} [step] whether it is a step of the browser's history, which a link makes by itself */
export function openTradeoff(at, step = false) {
  const of = lesson.value === null ? null : session.value;
  if (step) history.pushState(null, '', location.href);
  close();
  drop(of);
  batch(() => {
    lesson.value = null;
    held.value = '';
    stopTick.value = 0;
    experiment.value = '';
    tradeoff.value = at;
  });
  document.title = t('session.title', { name: t('session.tradeoff') });
  showAddress();
}

/** Shows a session from now on. @param {string} id @param {string} key @param {boolean} own
 * @param {import('../stream/connection.js').Line} [line] its stream, when it is open
 * @param {() => void} [gone] of a class: what to do without the session; its many pages also wait longer between their attempts */
export function show(id, key, own, line, gone) {
  stream?.close();
  newest = null;
  batch(() => {
    experiment.value = null;
    tradeoff.value = null;
    session.value = { id, key, own };
    connection.value = { state: 'connecting', attempt: 0 };
    frame.value = null;
    failure.value = '';
  });
  seen.version = -1;
  following = null;
  let wasLost = false;
  stream = new Stream(
    id,
    key,
    {
      hello(hello) {
        counts.hellos++;
        divisor.value = 1;
        const next = layoutOf(hello);
        batch(() => {
          layout.value = next;
          if (hello.params) params.value = hello.params;
          seen.version = hello.params_version ?? -1; /* where they are older than a change that was answered, a frame says so */
          follow(frame.value === null);
        });
        ready.then(() => {
          if (lesson.value === null) document.title = t('session.title', { name: hello.params?.title || next.game });
        });
      },
      frame(next) {
        counts.received++;
        following?.take?.(next);
        newest = next;
        arrived();
        if (next.flags & FAILED && failure.value === '') why(id);
      },
      state(state, attempt) {
        connection.value = { state, attempt };
        if (state === 'open' && wasLost) notify(t('session.reconnected'));
        if (state === 'polled') notify(t('session.polled'), true);
        wasLost = state === 'lost';
      },
      pace(next) {
        divisor.value = next;
      },
      gone() {
        if (gone) {
          gone();
          return;
        }
        notify(t('session.expired_again'));
        again();
      },
      refused(detail) {
        notify(t('session.refused', { detail }));
      },
    },
    line,
    wishOf(),
    gone !== undefined,
  );
  ask(); /* of a line that is open its hello has been heard: it may have more to show */
  showAddress();
}

/** @param {string} id */
async function why(id) {
  failure.value = t('session.stopped');
  try {
    const now = await call('GET', `sessions/${id}`);
    failure.value = String(now.error?.detail ?? now.error?.title ?? failure.value);
  } catch {
    /* the plain sentence stays */
  }
}

/** @param {() => void} act when a frame to draw has come */
export function whenFrame(act) {
  arrived = act;
}

/** The next frame to draw: the newest, once. */
export function takeNewest() {
  const next = newest;
  newest = null;
  return next;
}

/** Reports to the daemon which frame was drawn. @param {number} seq */
export function drawn(seq) {
  counts.drawn++;
  counts.acked = seq;
  stream?.send({ ack: seq });
}

/** @param {unknown} message */
export function send(message) {
  stream?.send(message);
}

/** A new session from the address, after the former one was lost or another scenario was chosen. */
export async function again() {
  try {
    link.session = '';
    link.problems = [];
    const start = lesson.value?.id === '' ? front()?.start : undefined;
    const made = await (start ? createFirst(start) : create(lesson.value === null ? {} : { paused: true }));
    show(made.id, made.key, true);
    if (link.problems.length > 0) notify(problems(), true);
  } catch (error) {
    failed(error);
  }
}

/** A person who has just declined to give the key is not asked again. @param {unknown} error */
export function failed(error) {
  if (error instanceof Problem && error.declined) {
    notify(t('session.needs_key'), true);
    return;
  }
  notify(t('session.no_session', { detail: error instanceof Error ? error.message : t('session.no_answer_now') }));
  setTimeout(again, 1000 + Math.random() * 1000);
}

/** What was changed of each scenario that was left. @type {Map<string, Pick<typeof link, 'set' | 'seed' | 'workload'>>} */
const left = new Map();
const changes = () => Object.keys(link.set).length + (link.seed === null ? 0 : 1);

/** Another scenario, as it was left; what is changed of the present one stays in the browser's history and until it is chosen again.
 * @param {string} id @param {Record<string, import('../base/link.js').Value>} [set] in place of what was left of it
 * @param {boolean} [step] whether it is a step of the browser's history */
export async function choose(id, set, step = true) {
  const before = session.value,
    own = lesson.value === null && before?.own === true,
    count = own ? changes() : 0;
  if (count > 0) left.set(link.scenario, { set: link.set, seed: link.seed, workload: link.workload });
  else if (own) left.delete(link.scenario);
  if (lesson.value !== null) leaveLesson();
  else if (step && before !== null) history.pushState(null, '', location.href);
  const known = set === undefined ? left.get(id) : undefined;
  link.scenario = id;
  link.set = { ...(known?.set ?? set) };
  link.seed = known?.seed ?? null;
  link.workload = known?.workload ?? null;
  await again();
  drop(before);
  if (link.problems.length > 0) return;
  if (known) notify(t('session.changed_left', { n: changes() }));
  else if (count > 0) notify(t('session.changed_kept', { n: count }));
}

/** What the address says, after Back or Forward. */
export async function reopen() {
  const before = session.value,
    asked = readLink(location.search, location.hash);
  readScenario(
    asked,
    location.search,
    location.hash,
    labs.value.flatMap(({ tabs }) => tabs),
  );
  Object.assign(link, { scenario: asked.scenario, set: asked.set, seed: asked.seed, workload: asked.workload });
  await again();
  drop(before);
}

/** A copy of the session at this moment, under a key of one's own. */
export async function fork() {
  const now = session.value;
  if (now === null) return;
  try {
    const copy = await make(`sessions/${now.id}/fork`);
    keep(copy.id, copy.owner_key, false);
    show(copy.id, copy.owner_key, false);
    notify(t('session.copied'));
  } catch (error) {
    notify(t('session.no_copy', { detail: error instanceof Error ? error.message : t('session.no_answer_now') }));
  }
}

/** @returns {string} the id of the scenario shown, as far as it is known */
export function shownScenario() {
  const now = session.value;
  if (now?.own) return link.scenario;
  const title = params.value?.title;
  return scenarios.value.find((row) => row.title === title)?.id ?? '';
}

/** Read-only facts for tests and for the curious. */
export function hook() {
  const facts = {
    get frame() {
      return frame.value;
    },
    get session() {
      return session.value && { id: session.value.id, owner: session.value.key !== '' };
    },
    get params() {
      return structuredClone(params.value);
    },
    get connection() {
      return { ...connection.value };
    },
    get locked() {
      return locked.value;
    },
    get counts() {
      return { ...counts, patches: seen.patches };
    },
  };
  return Object.freeze(Object.defineProperties(facts, lab.value?.facts?.() ?? {}));
}
