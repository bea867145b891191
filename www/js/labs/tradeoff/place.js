// Where the view is: a family, a cost, a measurement, as the address has them.
import { computed } from '../../../vendor/signals-core.js';
import { showAddress } from '../../session/params.js';
import { tradeoff } from '../../session/state.js';

/** Each is empty where the address has none; cost: its path; job: an id. @typedef {{family: string, cost: string, job: string}} Place */

/** @param {Place} at @returns {string} the fragment */
export const write = ({ family, cost, job }) => `#tradeoff${family && `=${family}`}${cost && `&cost=${cost}`}${job && `&job=${job}`}`;

/** Null while something else is shown. */
export const place = computed(() => {
  if (tradeoff.value === null) return null;
  const fragment = new URLSearchParams(tradeoff.value.slice(1));
  const part = (/** @type {string} */ name) => /^[a-z0-9_.]{1,64}$/.exec(fragment.get(name) ?? '')?.[0] ?? '';
  return { family: part('tradeoff'), cost: part('cost'), job: part('job') };
});

/** Another place, in the address too, without a step of the browser's history. @param {Partial<Place>} change */
export function move(change) {
  const now = place.peek();
  if (now === null) return;
  tradeoff.value = write({ ...now, ...change });
  showAddress();
}
