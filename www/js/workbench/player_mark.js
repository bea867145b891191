// The mark of a player, a method, a solver or a fluid among the controls.
import { html } from '../../vendor/lit-html.js';

/** The player's mark as an image, or that of more methods than there are marks, by its shape and another colour.
 * @param {number} player @param {number} [colour] @returns {import('lit-html').TemplateResult} */
export function mark(player, colour = player) {
  const shapes = [
    'M9 1a8 8 0 1 0 .01 0z',
    'M2 1.5L17 9 2 16.5z',
    'M2 2h14v14H2z',
    'M9 1l8 6-3 10H4L1 7z',
    'M5 2h8l4 7-4 7H5L1 9z',
    'M1 2h16L9 17z',
    'M6 1h6l5 5v6l-5 5H6l-5-5V6z',
    'M3 4h12a2 2 0 0 1 2 2v6a2 2 0 0 1-2 2H3a2 2 0 0 1-2-2V6a2 2 0 0 1 2-2z',
  ];
  return html`<svg class="mark" data-player=${colour % 8} viewBox="0 0 18 18" aria-hidden="true"><path
    d=${shapes[player % 8]}></path></svg>`;
}
