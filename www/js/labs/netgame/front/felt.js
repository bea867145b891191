// What has been felt so far: the latency of the person's own presses, as the daemon measured it under the settings of that time; and
// the line that follows from it, which says what was felt and what to try next.

/** One-way lag, ms, and the two techniques. @typedef {{lag: number, predict: boolean, correct: boolean}} Settings */
/** @typedef {'none' | 'predict' | 'both'} Mode */
/** What was held: '' is nothing, so a release. @typedef {'' | 'ahead' | 'back'} Held */
/** latency: s; mode, lag: the settings of its time @typedef {{latency: number, lag: number, mode: Mode, way: Held}} Press */
/** A change of what is held, which the daemon has not answered yet; time: of the session, s @typedef {{way: Held, time: number}} Change */
/** The newest of each mode. @typedef {Partial<Record<Mode, Press>>} Felt */
/** key: of the words; lit: the control that comes next; done: how many of the three steps @typedef {{key: string, lit: '' | 'predict' |
 * 'correct', done: number}} Line */

/** @param {Settings} now @returns {Mode} */
export const modeOf = ({ predict, correct }) => (predict ? (correct ? 'both' : 'predict') : 'none');

/** @typedef {{input_latency_sum_ms: number, input_latencies: number, input_changes_lost: number}} Sums */
/** What was measured before @typedef {{sum: number, count: number, lost: number, reading: Felt, last: Press | null}} Meter */

const NEAR_MS = 20; /* less than that is not felt, and makes no gap that is seen */
const LOST_S = 2; /* a change that has no answer after that was never sent */

/** @returns {Meter} */
export const meter = () => ({ sum: 0, count: 0, lost: 0, reading: {}, last: null });

/** The newest press, if it was made under the current settings: what was felt at another lag is not what is seen.
 * @param {Press | null} last @param {Settings} now */
export const valid = (last, now) => (last !== null && last.lag === now.lag && last.mode === modeOf(now) ? last : null);

/** Reads the sums of the daemon: what was added since is the mean of the new changes, which are answered in their order. Counts if a
 * press is among them: a release is none. @param {Meter} of @param {Sums} measured
 * @param {Settings} now @param {Change[]} changes loses what is answered @param {number} time s @returns {boolean} whether one came */
export function read(of, measured, now, changes, time) {
  while (changes[0] && Math.abs(changes[0].time - time) > LOST_S) changes.shift();
  const count = measured.input_latencies - of.count;
  if (count < 0) Object.assign(of, meter()); /* time has jumped */
  changes.splice(0, Math.max(0, measured.input_changes_lost - of.lost)); /* the server had them too late */
  of.lost = measured.input_changes_lost;
  if (count <= 0) return false;
  const latency = (measured.input_latency_sum_ms - of.sum) / count / 1000,
    way = changes.splice(0, count).reduce((/** @type {Held} */ found, change) => change.way || found, ''),
    mode = modeOf(now);
  of.sum = measured.input_latency_sum_ms;
  of.count = measured.input_latencies;
  if (way === '') return false;
  of.last = { latency, lag: now.lag, mode, way };
  of.reading = { ...of.reading, [mode]: of.last };
  return true;
}

/** @param {Felt} felt @param {Settings} now @param {number} first the lag of the start, ms @returns {Line} */
export function lineOf(felt, now, first) {
  const mode = modeOf(now),
    fresh = felt[mode]?.lag === now.lag,
    done = felt.both ? 3 : felt.predict ? 2 : felt.none ? 1 : 0;
  if (done === 0 && mode === 'none') return { key: 'drive', lit: '', done };
  if (!fresh) return { key: mode === 'none' ? 'again' : `again_${mode}`, lit: '', done };
  if (now.lag < NEAR_MS) return { key: 'near', lit: '', done };
  if (mode === 'both') return { key: now.lag === first ? 'stays' : 'stays_at', lit: '', done };
  if (mode === 'predict') return { key: 'thrown', lit: 'correct', done };
  return { key: now.lag === first ? 'late' : 'late_at', lit: 'predict', done };
}
