// Icons as inline SVG: no font has to hold their glyphs.
import { html } from '../../vendor/lit-html.js';

/** @param {string} d @returns {import('lit-html').TemplateResult} */
const icon = (d) => html`<svg class="icon" viewBox="0 0 24 24" aria-hidden="true" focusable="false"><path d=${d}></path></svg>`;

export const icons = {
  play: icon('M6 4l14 8-14 8z'),
  pause: icon('M6 4h4v16H6zM14 4h4v16h-4z'),
  back: icon('M5 4h3v16H5zM20 4v16L9 12z'),
  forward: icon('M16 4h3v16h-3zM4 4l11 8-11 8z'),
  settings: icon('M3 6h10v2H3zM17 6h4v2h-4zM13 4h3v6h-3zM3 15h4v2H3zM11 15h10v2H11zM7 13h3v6H7z'),
  full: icon('M4 4h6v2H6v4H4zM14 4h6v6h-2V6h-4zM4 14h2v4h4v2H4zM18 14h2v6h-6v-2h4z'),
  present: icon('M2 3h20v13H2zM4 5v9h16V5zM8 20l3-4h2l3 4z'),
  left: icon('M15 4v16L5 12z'),
  right: icon('M9 4l10 8-10 8z'),
  up: icon('M4 15h16L12 5z'),
  down: icon('M4 9h16l-8 10z'),
  lock: icon('M7 10V7a5 5 0 0 1 10 0v3h2v11H5V10zM9 10h6V7a3 3 0 0 0-6 0z'),
  done: icon('M9 20l-8-8 3-3 5 5L20 3l3 3z'),
  fire: icon('M3 17l9-9 4 4-9 9H3zM17 3l2 2-2 2-2-2zM21 8l1 2-2 1-1-2zM13 2l2 1-1 2-2-1z'),
};
