// The adviser's answers compared with brute force.
import assert from 'node:assert/strict';
import { ask, bruteForce, judge, limitOf, seeded } from '../../bench/advise/judge.mjs';
import { BINARY } from './daemon.mjs';

/** Whose brute force takes longest: advise.all.test.mjs has them. */
export const LONG = ['pyramid', 'inputs that come late'];
const SEEDS = 60; // of brute force, at every setting; the benchmark takes 200

/** @param {any} experiment @param {number} limit @param {string[]} [options] */
export const advise = async (experiment, limit, ...options) =>
  JSON.parse(await ask(BINARY, ['advise', '-', '--max-error', String(limit), ...options], experiment));

/** Within 2 % of the cheapest, and it holds on other seeds. @param {any} grid one of bench/advise/cases.mjs */
export async function checkAdvice(grid) {
  const truth = await bruteForce(BINARY, grid.experiment, SEEDS, { event: grid.event });
  for (const asked of grid.limits) {
    const limit = limitOf(asked, truth),
      answer = await advise(seeded(grid.experiment, 1), limit),
      found = judge(answer, truth, limit);
    assert.ok(found.regret <= 0.02, `${limit}: ${found.advised?.cost} for ${found.best}`);
    assert.ok(!found.surely_broken, `${limit}: ${found.advised?.error} +- ${found.advised?.half}`);
    if (grid.experiment.repeats === 1) assert.ok(!found.broken);
    if (found.best === Infinity && truth.every((p) => !(p.error <= limit))) assert.deepEqual([answer.holds, answer.advice], [false, null]);
  }
}
