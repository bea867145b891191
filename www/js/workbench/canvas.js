// Canvases of a lab, by their ids.
import { html } from '../../vendor/lit-html.js';
import { panelTurn } from '../draw/redraw.js';
import { Surface } from '../draw/surface.js';

/** @type {WeakMap<HTMLCanvasElement, Surface>} */
const surfaces = new WeakMap();

/** @param {HTMLCanvasElement} canvas */
export function surfaceOf(canvas) {
  const known = surfaces.get(canvas) ?? new Surface(canvas);
  surfaces.set(canvas, known);
  return known;
}

/** Draws on a canvas, if it is there and has a size. @param {string} id @param {(surface: Surface) => void} draw */
export function onto(id, draw) {
  const canvas = document.getElementById(id);
  if (!(canvas instanceof HTMLCanvasElement)) return;
  const surface = surfaceOf(canvas);
  if (surface.begin()) draw(surface);
}

const LEAST_MS = 90,
  MOST_MS = 400; /* between two drawings of a plot, where there is time for it and where there is none */
/** By the canvas. @type {Map<string, ReturnType<typeof panelTurn>>} */
const turns = new Map();

/** The same of a plot, in its turn. @param {string} id @param {boolean} settled no frame follows soon
 * @param {(surface: Surface) => void} draw */
export function inTurn(id, settled, draw) {
  const turn = turns.get(id) ?? panelTurn(LEAST_MS, MOST_MS);
  turns.set(id, turn);
  turn(settled, () => onto(id, draw));
}

/** A box with a canvas for a plot. @param {string} id @param {string} name @param {string} [shows] what a lesson highlights there
 * @returns {import('lit-html').TemplateResult} */
export function plotBox(id, name, shows = '') {
  return html`<section class="plotbox" aria-label=${name} data-shows=${shows}><div class="view"><canvas id=${id} role="img"
    aria-label=${name}></canvas><take-away data name=${name}></take-away></div></section>`;
}
