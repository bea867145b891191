// Pointer drag: a person drags a body or a fluid by mouse, touch or keys. Sent are the position and whether it is pressed.
import { html } from '../../vendor/lit-html.js';
import { effect, signal } from '../../vendor/signals-core.js';
import { touch } from '../draw/redraw.js';
import { send } from '../session/session.js';
import { locked, may, session, usable } from '../session/state.js';

/** @typedef {{x: number, y: number, held: boolean}} Pointer  m */
/** @typedef {{left: number, top: number, scale: number}} Camera */

const STEPS = /** @type {Record<string, number[]>} */ ({ ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] });
let requests = 0;

/** The pointer of a lab. */
export class PointerDrag {
  /** @param {(world: number) => number[]} viewOf of a drawing: left, right, bottom, top in m */
  constructor(viewOf) {
    this.viewOf = viewOf;
    /** Where the keys point, in m of the first drawing; null until used. @type {import('@preact/signals-core').Signal<Pointer | null>} */
    this.pointer = signal(null);
    /** Cameras of the last drawings, by world. @type {Map<number, Camera>} */
    this.cameras = new Map();
    this.sent = '';
    this.held = false;
    effect(() => {
      session.value; /* a new one has received no input yet */
      this.sent = '';
      this.held = false;
      this.pointer.value = null;
    });
    effect(() => {
      this.pointer.value;
      touch();
    });
  }

  /** Position of the key pointer in another drawing, at the same share of its sides. @param {number} world @returns {Pointer | null} */
  pointerIn(world) {
    const [left = 0, right = 1, bottom = 0, top = 1] = this.viewOf(0),
      [l = 0, r = 1, b = 0, t = 1] = this.viewOf(world),
      now = this.pointer.value;
    return now && { ...now, x: l + ((now.x - left) / (right - left)) * (r - l), y: b + ((now.y - bottom) / (top - bottom)) * (t - b) };
  }

  /** @param {number} x m @param {number} y m @param {boolean} hold @param {number} world that the place is of */
  send(x, y, hold, world) {
    const [left = 0, right = 1, bottom = 0, top = 1] = this.viewOf(world);
    const axis = (/** @type {number} */ v, /** @type {number} */ low, /** @type {number} */ high) =>
      Math.max(-1, Math.min(1, (2 * v - low - high) / (high - low)));
    const input = { player: 0, axes: [axis(x, left, right), axis(y, bottom, top)], buttons: hold ? 1 : 0 };
    const text = JSON.stringify(input);
    this.held = hold;
    if (locked.value !== '' || !may('pointer') || text === this.sent) return;
    this.sent = text;
    send({ input, id: ++requests });
  }

  /** @param {PointerEvent} event @returns {{x: number, y: number, world: number} | null} in m */
  pointAt(event) {
    const box = /** @type {HTMLElement} */ (event.currentTarget),
      frame = box.getBoundingClientRect();
    const world = Number(box.dataset.world),
      at = this.cameras.get(world);
    return at ? { world, x: at.left + (event.clientX - frame.left) / at.scale, y: at.top - (event.clientY - frame.top) / at.scale } : null;
  }

  press = (/** @type {PointerEvent} */ event) => {
    const point = this.pointAt(event);
    if (point === null || event.button !== 0 || !usable('pointer')) return;
    /** @type {HTMLElement} */ (event.currentTarget).setPointerCapture(event.pointerId);
    this.pointer.value = null;
    this.send(point.x, point.y, true, point.world);
  };

  move = (/** @type {PointerEvent} */ event) => {
    const point = this.pointAt(event);
    if (point !== null && this.held && this.pointer.value === null) this.send(point.x, point.y, true, point.world);
  };

  release = (/** @type {PointerEvent} */ event) => {
    const point = this.pointAt(event);
    if (point !== null && this.held && this.pointer.value === null) this.send(point.x, point.y, false, point.world);
  };

  /** Arrows move the pointer by a fiftieth of the drawing, with Shift by a tenth of that; Enter grabs and releases; Escape releases. */
  key = (/** @type {KeyboardEvent} */ event) => {
    const [left = 0, right = 1, bottom = 0, top = 1] = this.viewOf(0);
    const now = this.pointer.value ?? { x: (left + right) / 2, y: (bottom + top) / 2, held: false };
    const step = STEPS[event.key],
      size = (Math.min(right - left, top - bottom) / 50) * (event.shiftKey ? 0.1 : 1);
    let next = null;
    if (step) next = { ...now, x: now.x + (step[0] ?? 0) * size, y: now.y + (step[1] ?? 0) * size };
    else if (event.key === 'Enter') next = { ...now, held: !now.held };
    else if (event.key === 'Escape' && this.pointer.value !== null) next = { ...now, held: false };
    if (next === null || event.altKey || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    this.pointer.value = next;
    if (next.held || now.held) this.send(next.x, next.y, next.held, 0);
  };

  /** A drawing that is dragged in. @param {number} world @param {string} box its class @param {string} label
   * @param {import('lit-html').TemplateResult} canvas @returns {import('lit-html').TemplateResult} */
  box(world, box, label, canvas) {
    return html`<div class=${`view ${box}`} role="group" tabindex="0" data-world=${world} aria-label=${label} @pointerdown=${this.press}
      @pointermove=${this.move} @pointerup=${this.release} @pointercancel=${this.release} @keydown=${this.key}>${canvas}</div>`;
  }
}
