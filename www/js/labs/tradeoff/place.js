// Where the view is: a family, which of its errors, a cost, the two lines, as the address has them.
import { computed } from '../../../vendor/signals-core.js';
import { showAddress } from '../../session/params.js';
import { tradeoff } from '../../session/state.js';

/** Empty or null where the address has none. error: its place in the family; cost: its path; budget, enough: where the lines are
 * @typedef {{family: string, error: number, cost: string, budget: number | null, enough: number | null}} Place */

/** @param {Place} at @returns {string} the fragment */
export function write({ family, error, cost, budget, enough }) {
  const parts = [
    `#tradeoff${family && `=${family}`}`,
    error > 0 ? `error=${error}` : '',
    cost && `cost=${cost}`,
    budget === null ? '' : `budget=${budget}`,
    enough === null ? '' : `enough=${enough}`,
  ];
  return parts.filter((part) => part !== '').join('&');
}

/** Null while something else is shown. @type {import('@preact/signals-core').ReadonlySignal<Place | null>} */
export const place = computed(() => {
  if (tradeoff.value === null) return null;
  const fragment = new URLSearchParams(tradeoff.value.slice(1));
  const part = (/** @type {string} */ name) => /^[a-z0-9_.]{1,64}$/.exec(fragment.get(name) ?? '')?.[0] ?? '';
  const number = (/** @type {string} */ name) => {
    const value = Number.parseFloat(fragment.get(name) ?? '');
    return Number.isFinite(value) && value >= 0 ? value : null;
  };
  return { family: part('tradeoff'), error: number('error') ?? 0, cost: part('cost'), budget: number('budget'), enough: number('enough') };
});

/** Another place, in the address too, without a step of the browser's history. @param {Partial<Place>} change */
export function move(change) {
  const now = place.peek();
  if (now === null) return;
  tradeoff.value = write({ ...now, ...change });
  showAddress();
}
