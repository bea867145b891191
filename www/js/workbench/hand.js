// A person drags a body, or stirs a fluid: by mouse, by touch, or by keys. What is sent is where the hand is and whether it holds.
import { signal } from '../../vendor/signals-core.js';
import { send } from '../lab.js';
import { layout, locked } from '../state.js';

/** Where the keys point, in m of the first picture; null until they are used. @type {import('@preact/signals-core').Signal<{x: number, y: number, held: boolean} | null>} */
export const pointer = signal(null);
/** Of the pictures as drawn last, by world. @type {Map<number, {left: number, top: number, scale: number}>} */
export const cameras = new Map();

/** Of a picture: left, right, bottom, top in m. Bodies have one for all worlds. @param {number} world @returns {number[]} */
const viewOf = (world) => (layout.value?.rigid ?? (world === 0 ? layout.value?.fluid : layout.value?.fluid?.side_by_side?.[world - 1]))?.view ?? [];
const view = () => viewOf(0);

let asked = 0;
let said = '';
let held = false;

/** Where the keys point in a picture that may be of another place: at the same share of its sides. @param {number} world
 * @returns {{x: number, y: number, held: boolean} | null} */
export function handIn(world) {
  const [left = 0, right = 1, bottom = 0, top = 1] = view(), [l = 0, r = 1, b = 0, t = 1] = viewOf(world), now = pointer.value;
  return now && { ...now, x: l + ((now.x - left) / (right - left)) * (r - l), y: b + ((now.y - bottom) / (top - bottom)) * (t - b) };
}

/** @param {number} x m @param {number} y m @param {boolean} hold @param {number} world that the place is of */
function say(x, y, hold, world) {
  const [left = 0, right = 1, bottom = 0, top = 1] = viewOf(world);
  const axis = (/** @type {number} */ v, /** @type {number} */ low, /** @type {number} */ high) => Math.max(-1, Math.min(1, (2 * v - low - high) / (high - low)));
  const input = { player: 0, axes: [axis(x, left, right), axis(y, bottom, top)], buttons: hold ? 1 : 0 };
  const text = JSON.stringify(input);
  held = hold;
  if (locked.value !== '' || text === said) return;
  said = text;
  send({ input, id: ++asked });
}

/** @param {PointerEvent} event @returns {{x: number, y: number, world: number} | null} in m */
function pointAt(event) {
  const box = /** @type {HTMLElement} */ (event.currentTarget), frame = box.getBoundingClientRect();
  const world = Number(box.dataset.world), at = cameras.get(world);
  return at ? { world, x: at.left + (event.clientX - frame.left) / at.scale, y: at.top - (event.clientY - frame.top) / at.scale } : null;
}

/** @param {PointerEvent} event */
export function press(event) {
  const point = pointAt(event);
  if (point === null || event.button !== 0) return;
  /** @type {HTMLElement} */ (event.currentTarget).setPointerCapture(event.pointerId);
  pointer.value = null;
  say(point.x, point.y, true, point.world);
}

/** @param {PointerEvent} event */
export function move(event) {
  const point = pointAt(event);
  if (point !== null && held && pointer.value === null) say(point.x, point.y, true, point.world);
}

/** @param {PointerEvent} event */
export function release(event) {
  const point = pointAt(event);
  if (point !== null && held && pointer.value === null) say(point.x, point.y, false, point.world);
}

const STEPS = /** @type {Record<string, number[]>} */ ({ ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] });

/** Arrows move the hand by a fiftieth of the picture, with Shift by a tenth of that; Enter takes and lets go; Escape lets go.
 * @param {KeyboardEvent} event */
export function key(event) {
  const [left = 0, right = 1, bottom = 0, top = 1] = view();
  const now = pointer.value ?? { x: (left + right) / 2, y: (bottom + top) / 2, held: false };
  const step = STEPS[event.key], size = (Math.min(right - left, top - bottom) / 50) * (event.shiftKey ? 0.1 : 1);
  let next = null;
  if (step) next = { ...now, x: now.x + (step[0] ?? 0) * size, y: now.y + (step[1] ?? 0) * size };
  else if (event.key === 'Enter') next = { ...now, held: !now.held };
  else if (event.key === 'Escape' && pointer.value !== null) next = { ...now, held: false };
  if (next === null || event.altKey || event.ctrlKey || event.metaKey) return;
  event.preventDefault();
  pointer.value = next;
  if (next.held || now.held) say(next.x, next.y, next.held, 0);
}

/** Another session has heard nothing yet. */
export function forget() {
  said = '';
  held = false;
  pointer.value = null;
}
