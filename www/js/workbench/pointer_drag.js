// Pointer drag: a person drags a body or a fluid by mouse, touch or keys. Sent are the position and whether it is pressed.
import { signal } from '../../vendor/signals-core.js';
import { send } from '../session/session.js';
import { layout, locked } from '../session/state.js';

/** Where the keys point, in m of the first drawing; null until used. @type {import('@preact/signals-core').Signal<{x: number, y: number, held: boolean} | null>} */
export const pointer = signal(null);
/** Cameras of the last drawings, by world. @type {Map<number, {left: number, top: number, scale: number}>} */
export const cameras = new Map();

/** Of a drawing: left, right, bottom, top in m. Bodies have one for all worlds. @param {number} world @returns {number[]} */
const viewOf = (world) =>
  (layout.value?.rigid ?? (world === 0 ? layout.value?.fluid : layout.value?.fluid?.side_by_side?.[world - 1]))?.view ?? [];
const view = () => viewOf(0);

let requests = 0;
let lastSent = '';
let held = false;

/** Position of the key pointer in another drawing, at the same share of its sides. @param {number} world
 * @returns {{x: number, y: number, held: boolean} | null} */
export function pointerIn(world) {
  const [left = 0, right = 1, bottom = 0, top = 1] = view(),
    [l = 0, r = 1, b = 0, t = 1] = viewOf(world),
    now = pointer.value;
  return now && { ...now, x: l + ((now.x - left) / (right - left)) * (r - l), y: b + ((now.y - bottom) / (top - bottom)) * (t - b) };
}

/** @param {number} x m @param {number} y m @param {boolean} hold @param {number} world that the place is of */
function sendPointer(x, y, hold, world) {
  const [left = 0, right = 1, bottom = 0, top = 1] = viewOf(world);
  const axis = (/** @type {number} */ v, /** @type {number} */ low, /** @type {number} */ high) =>
    Math.max(-1, Math.min(1, (2 * v - low - high) / (high - low)));
  const input = { player: 0, axes: [axis(x, left, right), axis(y, bottom, top)], buttons: hold ? 1 : 0 };
  const text = JSON.stringify(input);
  held = hold;
  if (locked.value !== '' || text === lastSent) return;
  lastSent = text;
  send({ input, id: ++requests });
}

/** @param {PointerEvent} event @returns {{x: number, y: number, world: number} | null} in m */
function pointAt(event) {
  const box = /** @type {HTMLElement} */ (event.currentTarget),
    frame = box.getBoundingClientRect();
  const world = Number(box.dataset.world),
    at = cameras.get(world);
  return at ? { world, x: at.left + (event.clientX - frame.left) / at.scale, y: at.top - (event.clientY - frame.top) / at.scale } : null;
}

/** @param {PointerEvent} event */
export function press(event) {
  const point = pointAt(event);
  if (point === null || event.button !== 0) return;
  /** @type {HTMLElement} */ (event.currentTarget).setPointerCapture(event.pointerId);
  pointer.value = null;
  sendPointer(point.x, point.y, true, point.world);
}

/** @param {PointerEvent} event */
export function move(event) {
  const point = pointAt(event);
  if (point !== null && held && pointer.value === null) sendPointer(point.x, point.y, true, point.world);
}

/** @param {PointerEvent} event */
export function release(event) {
  const point = pointAt(event);
  if (point !== null && held && pointer.value === null) sendPointer(point.x, point.y, false, point.world);
}

const STEPS = /** @type {Record<string, number[]>} */ ({ ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] });

/** Arrows move the pointer by a fiftieth of the drawing, with Shift by a tenth of that; Enter grabs and releases; Escape releases.
 * @param {KeyboardEvent} event */
export function key(event) {
  const [left = 0, right = 1, bottom = 0, top = 1] = view();
  const now = pointer.value ?? { x: (left + right) / 2, y: (bottom + top) / 2, held: false };
  const step = STEPS[event.key],
    size = (Math.min(right - left, top - bottom) / 50) * (event.shiftKey ? 0.1 : 1);
  let next = null;
  if (step) next = { ...now, x: now.x + (step[0] ?? 0) * size, y: now.y + (step[1] ?? 0) * size };
  else if (event.key === 'Enter') next = { ...now, held: !now.held };
  else if (event.key === 'Escape' && pointer.value !== null) next = { ...now, held: false };
  if (next === null || event.altKey || event.ctrlKey || event.metaKey) return;
  event.preventDefault();
  pointer.value = next;
  if (next.held || now.held) sendPointer(next.x, next.y, next.held, 0);
}

/** A new session has received no input yet. */
export function forget() {
  lastSent = '';
  held = false;
  pointer.value = null;
}
