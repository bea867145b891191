// Cards that move: each plays a few seconds of its run, recorded by docs/cards.mjs, when it comes into view, and again as long as the
// pointer or the keyboard is on it. What was recorded is read after the list is drawn; not where motion is not wanted.
import { file } from './words.js';

/** Of each part of a drawing where it is: [x, y] or [x, y, degrees], at equal times. @typedef {Record<string, number[][]>} Parts */

const PLAYED_MS = 4000,
  SEEN = 0.9;
/** @type {Record<string, Parts>} */
let recorded = {};
/** @type {Promise<void> | null} */
let reading = null;
/** What cards play, once there is time. */
function read() {
  reading ??= new Promise((done) => (globalThis.requestIdleCallback ?? setTimeout)(done))
    .then(() => file('cards.json'))
    .then((all) => {
      recorded = all;
    });
  return reading;
}

/** @type {WeakMap<Element, Animation[]>} */
const playing = new WeakMap();
/** @type {WeakSet<Element>} */
const watched = new WeakSet();

/** @param {number[]} place */
const frameOf = ([x = 0, y = 0, degrees = 0]) => ({ transform: `translate(${x}px, ${y}px) rotate(${degrees}deg)` });

/** @param {Element} card */
function stop(card) {
  for (const one of playing.get(card) ?? []) one.cancel();
  playing.delete(card);
}

/** @param {Element} card @param {number} times */
function play(card, times) {
  stop(card);
  const started = Object.entries(recorded[card.getAttribute('data-card') ?? ''] ?? {}).flatMap(([name, places]) =>
    [...card.querySelectorAll(`[data-part="${name}"]`)].map((part) =>
      part.animate(places.map(frameOf), { duration: PLAYED_MS, iterations: times }),
    ),
  );
  playing.set(card, started);
}

/** Out of view nothing moves. */
const viewer = new IntersectionObserver(
  (entries) => {
    for (const { target, isIntersecting, intersectionRatio } of entries) {
      if (!isIntersecting) stop(target);
      else if (intersectionRatio >= SEEN && !playing.has(target)) play(target, 1);
    }
  },
  { threshold: [0, SEEN] },
);

/** @param {ParentNode} root */
export async function watch(root) {
  await read();
  for (const card of root.querySelectorAll('[data-card]')) {
    if (watched.has(card)) continue;
    watched.add(card);
    viewer.observe(card);
    for (const begin of ['pointerenter', 'focus']) card.addEventListener(begin, () => play(card, Number.POSITIVE_INFINITY));
    for (const end of ['pointerleave', 'blur']) card.addEventListener(end, () => stop(card));
  }
}
