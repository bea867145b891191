// Finished experiments that ship with the page, and the questions that they answer: docs/finished.mjs runs them.
import { insist } from '../../base/api.js';
import { placeOf } from '../../base/place.js';

/** at: the value of the first axis that is marked
 * @typedef {{id: string, at: number, experiment: any, points: Record<string, string | number | boolean | null>[]}} Example */

/** The one that the view opens on. */
export const FIRST = 'lag';
/** Their ids; an address has them in place of an experiment's. */
export const IDS = [FIRST, 'jitter', 'updates'];
/** Of an experiment that is being written, and has not run. */
export const OWN = 'new';

/** @type {Promise<Example[]> | undefined} */
let asked;
/** @returns {Promise<Example[]>} */
export const examples = () =>
  (asked ??= insist(async () => {
    const answer = await fetch(placeOf('finished.json'));
    if (!answer.ok) throw new Error(`finished.json: ${answer.status}`);
    return answer.json();
  }));

/** Paths of what is varied, and of what is measured. @param {any} experiment */
const pathsOf = ({ axes = [], metrics = [] }) =>
  JSON.stringify([axes.flatMap((/** @type {any} */ axis) => axis.zip ?? [axis]).map((/** @type {any} */ axis) => axis.path), metrics]);

/** The example whose question an experiment asks, with any values. @param {Example[]} all @param {any} experiment */
export const askedBy = (all, experiment) => all.find((one) => pathsOf(one.experiment) === pathsOf(experiment));
