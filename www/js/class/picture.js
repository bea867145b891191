// Which drawing of a lab a stage shows: that of the sentence, or the scene.
import { shows } from '../draw/shown.js';
import { staged } from '../session/state.js';

/** @typedef {import('./lesson.js').Lesson} Lesson */

const NARROW = 700; /* px: then there is room for one drawing */

/** The parts of a page that are shown or hidden as one. */
const PARTS = '.row, .part, .plotbox, .worlds, .stage, .wide-table';

/** What a lesson points at. @param {ParentNode} root @param {Lesson} lesson @returns {Element | null | undefined} */
function pointed(root, { look: { at, player } }) {
  const view = shows.value?.view ?? '',
    place = view === 'server' ? '0' : /^player_(\d+)$/.exec(view)?.[1];
  if (view !== '')
    return root.querySelector(place === undefined ? `#${view}` : `canvas[data-view="${view === 'server' ? 0 : Number(place) + 1}"]`);
  return [...root.querySelectorAll('[data-shows]')].find(
    (element) =>
      element instanceof HTMLElement &&
      element.dataset.shows?.split(' ').includes(at) &&
      (element.dataset.of === undefined || element.dataset.of === String(player ?? 'server')),
  );
}

/** The scene, in the view of the player whom the lesson is about. @param {ParentNode} root @param {Lesson | null} lesson */
const scene = (root, lesson) =>
  root.querySelector(`.row [data-of="${lesson?.look.player ?? 0}"], .worlds, .stage, .row.motion`) ?? root.querySelector('.row canvas');

/** @param {ParentNode} root */
const server = (root) => root.querySelector('.row:has(> [data-of="server"])');

/** Shows all of it. @param {HTMLElement} root */
export function release(root) {
  for (const element of root.querySelectorAll('[data-aside]')) element.removeAttribute('data-aside');
  for (const element of root.querySelectorAll('[data-kept]')) element.removeAttribute('data-kept');
}

/** There is room for two plots: the one that a sentence is about is among them. @param {Element | null | undefined} of */
function keep(of) {
  const plot = of?.closest('.plotbox');
  if (!plot) return;
  plot.toggleAttribute('data-kept', true);
  for (const other of plot.parentElement?.querySelectorAll('.plotbox:not(:first-child)') ?? [])
    if (other !== plot) other.toggleAttribute('data-aside', true);
}

/** Leaves one part of the page. @param {Lesson | null} lesson @param {string} phase @param {number | null} driver the player that drives at
 * this page @returns {(root: HTMLElement) => void} */
export const pick = (lesson, phase, driver) => (root) => {
  release(root);
  const own = driver === null ? null : root.querySelector(`.row [data-of="${driver}"]`),
    whole = !['predict', 'locked', 'explain'].includes(phase) || (root.querySelector('.closeups') !== null && innerWidth > NARROW),
    wanted =
      own ?? (whole ? null : phase === 'explain' && lesson !== null ? (pointed(root, lesson) ?? scene(root, lesson)) : scene(root, lesson));
  let at = wanted?.closest(PARTS) ?? null;
  for (; at !== null && at.parentElement !== null && at !== root; at = at.parentElement)
    for (const other of at.parentElement.children) if (other !== at) other.toggleAttribute('data-aside', true);
  if (lesson !== null && ['stopped', 'explain', 'change'].includes(phase)) keep(pointed(root, lesson));
  if (phase === 'change' && (staged.peek()?.press ?? 0) > 0)
    server(root)?.toggleAttribute('data-aside', true); /* it does the same in both runs */
};
