// The steps of a lesson, and the session that each needs.
import { batch, effect, signal, untracked } from '../../vendor/signals-core.js';
import { call } from '../base/api.js';
import { LESSON_STEPS } from '../base/link.js';
import { speak } from '../session/announce.js';
import { seen, showAddress } from '../session/params.js';
import { showForLesson } from '../session/session.js';
import { touch } from '../draw/redraw.js';
import { shows } from '../draw/shown.js';
import {
  allowed,
  bars,
  camera,
  firstRun,
  frame,
  held,
  lesson,
  look,
  may,
  notify,
  params,
  session,
  staged,
  startTick,
  status,
  stopTick,
} from '../session/state.js';
import { control, play } from '../session/time.js';
import { record } from './recorded.js';
import { file, filled, ready, word } from './words.js';

/** @typedef {import('./words.js').Text} Text */
/** @typedef {import('./words.js').Unit} Unit */
/** @typedef {import('../base/link.js').Value} Value */
/** @typedef {{value: number, label?: Text, hint?: Text, right?: true, why: Text}} Choice */
/** @typedef {{value: number, unit: Unit}} Answer */
/** @typedef {{set: Record<string, Value>, answer: Answer, says?: Text, stop_tick?: number, speed?: number}} Changed */
/** @typedef {{view: string, from: string, to: string, along?: 'x' | 'y' | 'line', label?: Text}} ShownOf */
/**
 * A file of www/lessons; docs/lessons.md explains its members.
 * @typedef {{id: string, title: Text, erratum?: Text, order: number, scenario: string, set: Record<string, Value>, seed: number,
 * workload?: {inputs: {tick: number, player: number, axes: number[]}[]}, start_tick?: number, line?: string[],
 * stop_tick: number, speed: number, look: {at: string, player?: number, before?: {number: string, text: Text}},
 * moments?: {text: Text, ticks: number[]}, camera?: import('../session/state.js').Camera,
 *   headings?: Partial<Record<'observe' | 'change', Text>>, bars?: Record<'observe' | 'change', {text: Text, number: string}[]>,
 *   shows?: Partial<Record<'observe' | 'change', ShownOf>>, steps: Record<'predict' | 'observe' | 'explain' | 'change', Text>,
 *   choices: Choice[], answer: Answer & {says?: Text}, change: Changed,
 *   controls?: Partial<Record<StepName, string[]>>, numbers: Record<string, {value: number, digits: number}>, minutes: number, age: number,
 * hooks: string[], misconceptions: Text[]}} Lesson
 */

/** @typedef {'predict' | 'run' | 'observe' | 'explain' | 'change'} StepName */
/** @type {StepName[]} */
export const STEPS = ['predict', 'run', 'observe', 'explain', 'change'];
const RUN = 2,
  OBSERVE = 3,
  EXPLAIN = 4;
export const CHANGE = 5;
/** Controls of a step that does not name its own; `change` has the settings of the change, too. @type {Record<StepName, string[]>} */
const CONTROLS = {
  predict: ['time.play'],
  run: ['time.play', 'time.speed'],
  observe: ['time.step', 'time.seek'],
  explain: ['time.step', 'time.seek'],
  change: ['time.play', 'time.step', 'time.seek', 'time.speed', 'time.restart'],
};
export const SKIPPED = -1;

/** @type {import('@preact/signals-core').Signal<Lesson | null>} */
export const opened = signal(null);
/** The lesson of the address could not be read. */
export const missing = signal(false);
/** Index of the chosen answer; SKIPPED; null while there is none. @type {import('@preact/signals-core').Signal<number | null>} */
export const choice = signal(null);
/** While the session is taken to other ticks for their images, no step follows. */
export const printing = signal(false);
/** A person has unlocked every control, until another lesson. */
export const unlocked = signal(false);
/** The farthest step so far. */
export const reached = signal(1);

/** Which session is shown: of the lesson, or of its change; empty for none. @type {'' | 'plain' | 'changed'} */
let variant = '';
/** The step that the session stands at, by lesson. */
let settled = '';
/** Settings that a person gave the shown session when it was made. @type {Record<string, Value>} */
let given = {};
let patched = 0; /* of `seen.patches`, when it was made */
let plainHz = 60; /* ticks a second without the change */
let returning = false;
let first = true; /* the lesson that the page was opened with keeps its answer */

/** @param {string} id */
const keyOf = (id) => `laglab.lesson.${id}`;

/** @param {string} id @returns {number | null} */
function kept(id) {
  try {
    const text = sessionStorage.getItem(keyOf(id));
    return text === null ? null : Number(text);
  } catch {
    return null;
  }
}

/** Chooses an answer, or skips the question. @param {number | null} next */
export function choose(next) {
  const now = opened.value;
  if (now === null) return;
  choice.value = next;
  try {
    if (next === null) sessionStorage.removeItem(keyOf(now.id));
    else sessionStorage.setItem(keyOf(now.id), String(next));
  } catch {
    /* the answer then lasts as long as the page */
  }
}

/** Where the session of a step stops. @param {Lesson} of @param {number} step @param {number} [first] ticks a second without the change */
export function stopOf(of, step, first = plainHz) {
  const hz = Number(of.change.set.hz ?? 0);
  if (step === CHANGE && of.change.stop_tick !== undefined) return of.change.stop_tick;
  return step === CHANGE && hz > 0 ? Math.round((of.stop_tick * hz) / first) : of.stop_tick;
}

/** What a step leaves to be used. @param {Lesson} of @param {number} step @returns {string[]} */
export function controlsOf(of, step) {
  const name = STEPS[step - 1] ?? 'predict';
  return of.controls?.[name] ?? [...CONTROLS[name], ...(step === CHANGE ? Object.keys(of.change.set) : [])];
}

/** What stands above the words of a step. @param {Lesson} of @param {number} step @returns {string} */
export function headingOf(of, step) {
  const name = /** @type {'observe'} */ (STEPS[step - 1]);
  return filled(of.headings?.[name] ?? of.title, of.numbers);
}

/** Whether the run with the change stands at its end. @param {Lesson} of */
export const ended = (of) => variant === 'changed' && status.value !== 'playing' && (frame.value?.tick ?? 0) >= stopOf(of, CHANGE);

/** What a step says. @param {Lesson} of @param {number} step @returns {string} */
export function textOf(of, step) {
  const name = STEPS[step - 1] ?? '';
  if (step === RUN) return word('run.text', { tick: of.stop_tick });
  return filled(of.steps[/** @type {'predict'} */ (name)], of.numbers);
}

/** @param {number} step */
function say(step) {
  const now = opened.value;
  if (now === null) return;
  const name = `${word('step', { n: step, of: LESSON_STEPS })}: ${word(`steps.${STEPS[step - 1]}`)}.`;
  queueMicrotask(() => speak('status', `${name} ${textOf(now, step)}`)); /* after what the session's state says */
}

/** The step is shown, its session stands. @param {number} step */
function settle(step) {
  const at = lesson.value;
  if (at === null) return;
  const inside = document.getElementById('rail')?.contains(document.activeElement) ?? false;
  settled = `${at.id} ${step}`;
  batch(() => {
    reached.value = Math.max(reached.value, step);
    lesson.value = { ...at, step };
  });
  showAddress();
  say(step);
  if (inside) document.getElementById('lesson-step')?.focus();
  reveal(step);
}

const ARRIVAL_MS = 2000;
const NARROW = 976; /* px: where steps are above the views, as in lessons.css */

/** Until a frame of the tick is drawn: what follows from a tick must not follow from an older frame. @param {number} tick */
export function drawn(tick) {
  return new Promise((done) => {
    const timer = setTimeout(done, ARRIVAL_MS);
    const stop = effect(() => {
      if (frame.value?.tick !== tick) return;
      clearTimeout(timer);
      queueMicrotask(() => {
        stop();
        done(null);
      });
    });
  });
}

/** A new session. @param {Lesson} of @param {Record<string, Value>} own */
function begin(of, own) {
  const wanted = variant,
    set = { ...of.set, ...(wanted === 'changed' ? of.change.set : {}), ...own };
  given = own;
  patched = seen.patches;
  const speed = (wanted === 'changed' ? of.change.speed : undefined) ?? of.speed;
  return showForLesson(of.scenario, set, of.seed, speed, () => opened.value?.id === of.id && variant === wanted, of.workload);
}

/** Moves the session, also while a question holds it. @param {number} tick */
async function moveTo(tick) {
  const now = session.value;
  if (now === null) return;
  await call('POST', `sessions/${now.id}/control`, { body: { op: 'seek', tick }, key: now.key });
  await drawn(tick);
}

/** Where the run of a lesson begins. @param {Lesson} of */
export const startOf = (of) => of.start_tick ?? 0;

/** Whether a step stands at the stop. @param {number} step */
export const stands = (step) => step === OBSERVE || step === OBSERVE + 1;

/** Another session of the same seed: for a setting that one takes only when it is made, and for any where time stands at the stop, which
 * it then does again. @param {string} path @param {Value} value */
export async function remake(path, value) {
  const now = opened.value;
  if (now === null || variant === '' || !may(path)) return;
  try {
    await begin(now, { ...given, [path]: value });
    const goal = stands(lesson.value?.step ?? 0) ? now.stop_tick : startOf(now);
    if (goal > 0) await moveTo(goal);
    stage();
  } catch (error) {
    notify(error instanceof Error ? error.message : String(error), true);
  }
}

/** Whether the last step compares with a frame of the first run. @param {Lesson} of */
export const compares = ({ shows: of }) => [of?.change?.from, of?.change?.to].some((name) => name?.endsWith('.first'));

/** Brings the session to where a step begins. @param {Lesson} of @param {number} step @returns {Promise<boolean>} whether it is there */
async function place(of, step) {
  const wanted = step === CHANGE ? 'changed' : 'plain',
    goal = stands(step) ? of.stop_tick : startOf(of);
  if (step === CHANGE && compares(of) && firstRun.value === null && !(await place(of, OBSERVE))) return false;
  let tick = frame.value?.tick ?? 0;
  const touched = Object.keys(given).length > 0 || seen.patches !== patched;
  if (variant !== wanted || touched) {
    if (variant === 'plain') plainHz = Number(params.value?.hz ?? plainHz);
    variant = wanted;
    await begin(of, {});
    if (variant !== wanted) return false; /* another step was opened meanwhile */
    tick = 0;
  } else if (status.value === 'playing') await control({ op: 'pause' });
  if (opened.value?.id !== of.id) return false;
  if (tick === goal) return true;
  await moveTo(goal);
  return opened.value?.id === of.id;
}

/** Another step, asked for by a person. @param {number} step */
export async function go(step) {
  const now = opened.value;
  if (now === null || !(await prepared(now, step))) return;
  settle(step);
}

/** The session is on its way to a step, where the first run may be made, too. */
let preparing = Promise.resolve(true);

/** @param {Lesson} of @param {number} step */
function prepared(of, step) {
  preparing = prepare(of, step);
  return preparing;
}

/** @param {Lesson} of @param {number} step @returns {Promise<boolean>} */
async function prepare(of, step) {
  try {
    return await place(of, step);
  } catch (error) {
    variant = '';
    notify(error instanceof Error ? error.message : String(error), true);
    return false;
  }
}

/** Runs to the stop; where motion is not wanted, it is there at once. */
export async function run() {
  await preparing;
  if ((lesson.value?.step ?? 1) === CHANGE) reveal(CHANGE);
  else if (innerWidth < NARROW) document.getElementById('views')?.scrollIntoView({ block: 'start' }); /* below the steps there */
  if (matchMedia('(prefers-reduced-motion: reduce)').matches) return jump();
  await play();
}

/** The run with the change, from its start. */
export async function runAgain() {
  const now = opened.value;
  if (now !== null && (await control({ op: 'seek', tick: startOf(now) })) !== null) await run();
}

/** What a step is about comes into view where the steps are above it. @param {number} step */
function reveal(step) {
  const now = opened.value,
    one = now && shownAt(now, step);
  if (innerWidth >= NARROW || !now || !one) return;
  requestAnimationFrame(() =>
    requestAnimationFrame(() => {
      const all = document.getElementById('views'),
        view = one.view === 'server' ? '0' : String(Number(one.view.replace('player_', '')) + 1),
        about = step === EXPLAIN && now.line ? 'since' : one.view;
      const canvas = document.getElementById(about) ?? document.querySelector(`canvas[data-view="${view}"]`),
        fits = step === CHANGE && all !== null && all.offsetHeight < (all.closest('.teach')?.clientHeight ?? 0);
      (fits ? all : canvas?.closest('.row, .part, .view'))?.scrollIntoView({ block: 'nearest' });
    }),
  );
}

/** Goes to the stop without playing. */
export async function jump() {
  const now = opened.value,
    step = lesson.value?.step ?? 1;
  if (now === null) return;
  if (status.value === 'playing') await control({ op: 'pause' });
  if ((await control({ op: 'seek', tick: stopOf(now, step) })) !== null && step <= RUN) settle(OBSERVE);
}

/** From the first step, with the question open again. */
export async function restart() {
  await go(1);
  choose(null);
  reached.value = 1;
}

/** The address names a lesson, or another step of it. @param {import('../base/link.js').LessonAt | null} at */
async function arrive(at) {
  if (at === null || at.id === '') {
    opened.value = null;
    variant = settled = '';
    first = false;
    return;
  }
  if (opened.value?.id !== at.id) {
    batch(() => {
      opened.value = firstRun.value = null;
      missing.value = unlocked.value = false;
    });
    variant = '';
    try {
      const read = await file(`lessons/${at.id}.json`);
      if (lesson.value?.id !== at.id) return;
      const before = first || at.step > 1 ? kept(at.id) : null;
      batch(() => {
        choice.value = before ?? (at.step > 1 ? SKIPPED : null);
        reached.value = at.step;
        opened.value = { ...read, id: at.id };
      });
      first = false;
    } catch {
      missing.value = true;
      return;
    }
  } else if (settled === `${at.id} ${at.step}`) return;
  const now = opened.value;
  settled = `${at.id} ${at.step}`;
  if (now === null || !(await prepared(now, at.step))) return;
  say(at.step);
  reveal(at.step);
}

const RECORDED_TICKS = 600; /* before the stop */
let stagings = 0;

/** What a lesson adds to the drawings at a step, without its runs; null: nothing. @param {Lesson} of @param {number} step
 * @param {number} chosen @param {(choice: number) => void} plant @returns {import('../session/state.js').Staged | null} */
export function stagedOf(of, step, chosen, plant) {
  const named = JSON.stringify(of.shows ?? {}); /* the other labs record their own */
  if (!/"view":"(server|player_\d|first)"/.test(named) || (of.camera === undefined && !/\.(first|before)"/.test(named))) return null;
  const key = of.workload?.inputs.at(-1);
  return {
    player: of.look.player ?? 0,
    press: key ? key.tick + 1 : 0,
    brake: (key?.axes[0] ?? 0) < 0,
    first: null,
    now: null,
    flags: key && of.answer.unit.en === 'ms' ? of.choices.map(({ value }) => value) : [],
    chosen,
    plant,
    step,
    line: (of.line ?? []).map((name) => of.numbers[name]?.value ?? 0),
  };
}

/** The runs of a lesson tick by tick: the first one, and that of a step. @param {Lesson} of @param {number} step
 * @param {Record<string, Value>} [own] settings of a person */
export async function runsOf(of, step, own = {}) {
  const to = stopOf(of, CHANGE),
    from = Math.max(startOf(of), to - (of.camera ? RECORDED_TICKS : 1));
  const first = await record(of, of.set, from, to);
  return { first, now: step === CHANGE ? await record(of, { ...of.set, ...of.change.set, ...own }, from, to) : first };
}

/** What the lesson that is shown adds to the drawings: at once what is known, then its runs. */
export async function stage() {
  const now = opened.value,
    mine = ++stagings,
    step = lesson.value?.step ?? 1,
    next = now === null ? null : stagedOf(now, step, choice.value ?? SKIPPED, choose);
  staged.value = next === null ? null : { ...next, first: staged.value?.first ?? null };
  if (now === null || next === null) return;
  try {
    const runs = await runsOf(now, step, given);
    if (mine === stagings) staged.value = { ...next, ...runs };
  } catch (error) {
    if (mine === stagings) notify(error instanceof Error ? error.message : String(error));
  }
}

/** The bars of a step. @param {Lesson} of @param {number} step */
const barsAt = (of, step) =>
  (step === CHANGE ? of.bars?.change : step > RUN ? of.bars?.observe : undefined)?.map(({ text, number }) => ({
    text: filled(text, of.numbers),
    value: of.numbers[number]?.value ?? 0,
  })) ?? [];

/** What the sentence of a step is about. @param {Lesson} of @param {number} step @returns {import('../draw/shown.js').Shows | null} */
export function shownAt(of, step) {
  const one = step === CHANGE ? of.shows?.change : step > RUN ? of.shows?.observe : undefined;
  return one === undefined ? null : { ...one, label: one.label ? filled(one.label, of.numbers) : '' };
}

/** What a step is about. @param {Lesson} of @param {number} step */
export function lookOf({ look: { before, ...rest }, numbers, answer }, step) {
  const changed = step === CHANGE;
  return {
    ...rest,
    step,
    before: before
      ? {
          rate: changed ? answer.value : (numbers[before.number]?.value ?? 0),
          text: changed ? word('change.first') : filled(before.text, numbers),
        }
      : null,
  };
}

export function listen() {
  effect(() => {
    const at = lesson.value,
      now = opened.value;
    shows.value = at === null || now === null ? null : shownAt(now, at.step);
    camera.value = at === null ? null : (now?.camera ?? null);
    bars.value = at === null || now === null ? [] : barsAt(now, at.step);
    startTick.value = at === null || now === null ? 0 : startOf(now);
    choice.value; /* its flag */
    untracked(() => void stage());
    touch();
  });
  effect(() => {
    const at = lesson.value;
    untracked(() => void arrive(at));
  });
  effect(() => {
    const now = opened.value,
      at = frame.value;
    if (now !== null && variant === 'plain' && at?.tick === now.stop_tick && Object.keys(given).length === 0 && compares(now))
      firstRun.value = at;
  });
  effect(() => {
    /* what the question holds */
    const at = lesson.value,
      now = opened.value;
    const free = unlocked.value;
    const open = at !== null && at.id !== '' && !free && (now === null || (at.step === 1 && choice.value === null));
    const stop = at === null || now === null ? 0 : stopOf(now, at.step);
    const shown = at === null || now === null ? null : lookOf(now, at.step);
    const reason = open ? word('predict.first') || '…' : '';
    untracked(() => {
      held.value = reason;
      allowed.value = at === null || at.id === '' || free ? null : new Set(now === null ? [] : controlsOf(now, at.step));
      stopTick.value = stop;
      look.value = shown;
    });
  });
  effect(() => {
    /* from question to run when it plays, and on when it has stopped */
    const at = lesson.value,
      now = opened.value,
      tick = frame.value?.tick ?? -1;
    if (at === null || now === null || !ready.value || variant !== 'plain' || printing.value) return;
    const playing = status.value === 'playing';
    const past = tick >= now.stop_tick;
    if (at.step === 1 && playing && choice.value !== null) untracked(() => settle(RUN));
    else if (at.step <= RUN && !playing && past && choice.value !== null) untracked(() => settle(OBSERVE));
    else if (at.step === RUN && playing && tick > now.stop_tick && !returning) {
      /* it was restarted or moved meanwhile, which ends the order to stop */
      returning = true;
      untracked(() =>
        jump().finally(() => {
          returning = false;
        }),
      );
    }
  });
}
