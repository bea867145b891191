// What a lesson shows in place of the views is read when a lesson wants it.
import { computed, effect, signal } from '../../../../vendor/signals-core.js';
import { insist } from '../../../base/api.js';
import { need } from '../../../base/words.js';
import { look } from '../../../session/state.js';

/** @type {import('@preact/signals-core').Signal<typeof import('../closeups/closeups.js') | null>} */
const read = signal(null);

const wanted = computed(() => {
  const { at, player } = look.value ?? { at: '' };
  return at === 'cover' || at === 'path' || (at === 'waiting' && player !== undefined); /* a player whose world waits */
});

/** Null where the views are shown. */
export const closeup = computed(() => (wanted.value ? read.value : null));

let asked = false;
effect(() => {
  if (!wanted.value || asked) return;
  asked = true;
  Promise.all([insist(() => import('../closeups/closeups.js')), need('netgame_more')]).then(([module]) => {
    read.value = module;
  });
});
