// Operations on a session's time. One seek at a time: while dragging, the last place wins.
import { headOf } from '../stream/frame.js';
import { call, Problem } from '../base/api.js';
import { link, slowOf } from './opening.js';
import { reread, showAddress } from './params.js';
import { behind, frame, lesson, locked, notify, session, speed, startTick, status, stopTick, usable } from './state.js';
import { t } from '../base/words.js';

export const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5, 10];

/** @param {Record<string, unknown>} op @returns {Promise<any>} null when it was refused */
export async function control(op) {
  const now = session.value;
  if (now === null || locked.value !== '') return null;
  try {
    return await call('POST', `sessions/${now.id}/control`, { body: op, key: now.key });
  } catch (error) {
    notify(t('session.not_done', { detail: error instanceof Problem ? error.message : t('session.no_answer') }));
    return null;
  }
}

/** Plays on, as far as the next stop of a lesson. */
export function play() {
  return control({ op: 'play', ...(stopTick.value > (frame.value?.tick ?? 0) ? { until_tick: stopTick.value } : {}) });
}

export function playOrPause() {
  if (!usable('time.play')) return null;
  return status.value === 'playing' ? control({ op: 'pause' }) : play();
}

/** @type {Promise<any> | null} */
let stepping = null;
/** Ticks of one that was asked for meanwhile: its frame comes before the answer. */
let waiting = 0;

/** @param {number} ticks */
export function step(ticks) {
  if (!usable('time.step')) return null;
  if (stepping) waiting = ticks;
  stepping ??= control({ op: 'step', ticks }).finally(() => {
    const next = waiting;
    stepping = null;
    waiting = 0;
    if (next !== 0) step(next);
  });
  return stepping;
}

/** @param {number} value */
export function setSpeed(value) {
  return usable('time.speed') ? control({ op: 'speed', speed: value }) : null;
}

/** @param {number} direction */
export function nextSpeed(direction) {
  const place = SPEEDS.reduce(
    (best, s, i) => (Math.abs(Math.log(s / speed.value)) < Math.abs(Math.log((SPEEDS[best] ?? 1) / speed.value)) ? i : best),
    0,
  );
  const value = SPEEDS[Math.max(0, Math.min(SPEEDS.length - 1, place + direction))] ?? 1;
  return setSpeed(value);
}

/** What slows the session that is shown. */
export const slowing = () => (session.value?.own && lesson.value === null ? slowOf() : undefined);

/** From the start: the same seed, scenario and inputs. */
export async function restart() {
  if (!usable('time.restart')) return null;
  if (lesson.value !== null && startTick.value > 0) return control({ op: 'seek', tick: startTick.value });
  const slow = slowing();
  if (slow?.from_s === 0) await setSpeed(slow.speed);
  return control({ op: 'restart', reset: false });
}

/** Everything as the scenario has it, speed too. */
export async function reset() {
  if (!usable('time.reset') || (await control({ op: 'restart', reset: true })) === null) return;
  link.set = {};
  const slow = slowing();
  await setSpeed(slow?.from_s === 0 ? slow.speed : 1);
  if (frame.value) await reread(-2); /* the parameters differ now, for every version */
  showAddress();
}

export async function backToLive() {
  const now = frame.value;
  if (now === null || !behind.value) return;
  const head = headOf(now);
  if ((await control({ op: 'seek', time_s: head })) !== null) await control({ op: 'play' });
}

let goal = -1;
let seeking = false;

/** @param {number} time s */
export async function seek(time) {
  if (!usable('time.seek')) return;
  goal = time;
  if (seeking) return;
  seeking = true;
  while (goal >= 0) {
    const next = goal;
    goal = -1;
    await control({ op: 'seek', time_s: next });
  }
  seeking = false;
}
