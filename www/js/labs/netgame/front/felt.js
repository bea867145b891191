// What has been felt so far: the latency of the person's own presses, as the daemon measured it under the settings of that time; and
// the line that follows from it, which says what was felt and what to try next.

/** One-way lag, ms, and the two techniques. @typedef {{lag: number, predict: boolean, correct: boolean}} Settings */
/** @typedef {'none' | 'predict' | 'both'} Mode */
/** latency: s @typedef {{latency: number, lag: number}} Press */
/** The newest of each mode. @typedef {Partial<Record<Mode, Press>>} Felt */
/** key: of the words; lit: the control that comes next; done: how many of the three steps @typedef {{key: string, lit: '' | 'predict' |
 * 'correct', done: number}} Line */

/** @param {Settings} now @returns {Mode} */
export const modeOf = ({ predict, correct }) => (predict ? (correct ? 'both' : 'predict') : 'none');

/** What was measured before @typedef {{sum: number, count: number, reading: Felt, last: Press | null}} Meter */

/** @returns {Meter} */
export const meter = () => ({ sum: 0, count: 0, reading: {}, last: null });

/** Reads the sums of the daemon: what was added since is the mean of the new presses. @param {Meter} of
 * @param {{input_latency_sum_ms: number, input_latencies: number}} measured @param {Settings} now @param {boolean} held whether a key is
 * held, and not only released: what shows at once is to be seen @returns {boolean} whether one came */
export function read(of, measured, now, held) {
  const count = measured.input_latencies - of.count;
  if (count < 0) Object.assign(of, meter()); /* time has jumped */
  if (count <= 0) return false;
  of.last = { latency: (measured.input_latency_sum_ms - of.sum) / count / 1000, lag: now.lag };
  if (held || modeOf(now) === 'none') of.reading = { ...of.reading, [modeOf(now)]: of.last };
  of.sum = measured.input_latency_sum_ms;
  of.count = measured.input_latencies;
  return true;
}

/** @param {Felt} felt @param {Settings} now @param {number} first the lag of the start, ms @returns {Line} */
export function lineOf(felt, now, first) {
  const mode = modeOf(now),
    fresh = felt[mode]?.lag === now.lag,
    done = felt.both ? 3 : felt.predict ? 2 : felt.none ? 1 : 0;
  if (done === 0 && mode === 'none') return { key: 'drive', lit: '', done };
  if (!fresh) return { key: mode === 'none' ? 'again' : `again_${mode}`, lit: '', done };
  if (mode === 'both') return { key: now.lag === first ? 'stays' : 'stays_at', lit: '', done };
  if (mode === 'predict') return { key: 'thrown', lit: 'correct', done };
  return { key: now.lag === first ? 'late' : 'late_at', lit: 'predict', done };
}
