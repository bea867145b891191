// Canvases of a lab, by their ids.
import { html } from '../../vendor/lit-html.js';
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

/** A box with a canvas for a plot. @param {string} id @param {string} name @param {string} [shows] what a lesson highlights there
 * @returns {import('lit-html').TemplateResult} */
export function plotBox(id, name, shows = '') {
  return html`<section class="plotbox" aria-label=${name} data-shows=${shows}><div class="view"><canvas id=${id} role="img"
    aria-label=${name}></canvas><take-away data name=${name}></take-away></div></section>`;
}
