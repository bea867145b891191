// What a lesson adds to the drawings of a class: the key, the watch, the first run behind the second. The projector records the runs of the
// lesson; thirty phones do with the frames that they are sent.
import { compares, runsOf, stagedOf } from '../lessons/steps.js';
import { firstRun, session, staged } from '../session/state.js';
import { STEPS } from './lesson.js';

/** @typedef {import('./lesson.js').Lesson} Lesson */
/** @typedef {import('../session/state.js').Recorded} Recorded */

const CHANGE = 5;

/** The lesson and step that are shown, and who shows them. */
let shown = '',
  id = '';
/** Whether the runs come with the frames. */
let collects = false;
/** @type {Recorded} */
let run = new Map();
/** @type {Recorded | null} */
let first = null;
/** The session that it is of: the board is another one before the phase is. */
let board = '',
  last = 0;

/** Records what a projector shows. @param {Lesson} lesson @param {number} step */
async function recorded(lesson, step) {
  const mine = shown;
  try {
    const runs = await runsOf(lesson, step);
    if (mine === shown && staged.peek() !== null)
      staged.value = { .../** @type {import('../session/state.js').Staged} */ (staged.peek()), ...runs };
  } catch {
    /* then there is neither key nor first run */
  }
}

/** A phase of a lesson is shown. @param {Lesson | null} lesson null: nothing of one @param {string} phase @param {boolean} projector
 * @param {number} chosen @param {(choice: number) => void} plant */
export function stage(lesson, phase, projector, chosen, plant) {
  const step = STEPS[phase] ?? 0,
    next = lesson === null || step === 0 ? null : stagedOf(lesson, step, chosen, plant),
    name = lesson === null ? '' : `${lesson.id} ${step} ${projector}`;
  if (lesson?.id !== id || (name !== shown && step === 1)) {
    id = lesson?.id ?? '';
    firstRun.value = first = null;
    run = new Map();
    board = '';
  }
  const old = staged.peek();
  if (name === shown && old?.chosen === next?.chosen) return;
  if (name !== shown && step === CHANGE) {
    first = run;
    run = new Map();
    board = '';
  }
  collects = next !== null && !projector && (step !== CHANGE || (first?.size ?? 0) > 0); /* else it came after the first run */
  if (!collects && !projector) {
    shown = name;
    staged.value = null;
    return;
  }
  staged.value = next && {
    ...next,
    ...(collects ? { first: first ?? run, now: run } : { first: old?.first ?? null, now: old?.now ?? null }),
  };
  if (name === shown) return;
  shown = name;
  if (next !== null && lesson !== null && projector) recorded(lesson, step);
}

/** What is drawn now becomes a part of the run. @param {import('../stream/frame.js').Frame} frame */
function collect(frame) {
  const now = session.peek()?.id ?? '';
  board ||= now;
  if (now !== board) return;
  const { tick, views } = /** @type {any} */ (frame);
  if (run.has(tick)) return;
  if (tick < last) run.clear(); /* it runs once more */
  last = tick;
  run.set(
    tick,
    Array.from(views, (_, view) =>
      frame.where('entities', 'view', view).map((/** @type {any} */ { x, y, vx, age_ms, flags }) => ({ x, y, vx, age_ms, flags })),
    ),
  );
}

/** A frame of the board. @param {import('../stream/frame.js').Frame | null} frame @param {Lesson | null} lesson @param {string} phase */
export function keep(frame, lesson, phase) {
  if (frame === null || lesson === null) return;
  if (STEPS[phase] !== CHANGE && frame.tick === lesson.stop_tick && compares(lesson)) firstRun.value = frame;
  if (collects) collect(frame);
}
