// A small drawing of each family, for its tab.
import { svg } from '../../../vendor/lit-html.js';

/** @typedef {import('lit-html').TemplateResult} Template */

const grid = (/** @type {number} */ columns, /** @type {number} */ rows, /** @type {(i: number, j: number) => unknown} */ draw) =>
  Array.from({ length: rows }, (_, j) => Array.from({ length: columns }, (_, i) => draw(i, j)));

/** @type {Record<string, () => unknown>} */
const PICTURES = {
  integrators: () => svg`<ellipse class="way" cx="32" cy="20" rx="23" ry="11"></ellipse><circle class="sun" cx="13" cy="20" r="5"></circle>
    <circle class="a" cx="54" cy="16" r="4"></circle>`,
  contact_solvers: () => svg`${[0, 1, 2, 3].map((k) => svg`<rect class="b" x="44" y=${28 - 8 * k} width="8" height="8"></rect>`)}
    ${[0, 1, 2, 3].map(
      (k) => svg`<rect class="c" x=${10 + 3.4 * k} y=${28 - 7.4 * k} width="8" height="8"
      transform=${`rotate(${9 * k} ${14 + 3.4 * k} ${32 - 7.4 * k})`}></rect>`,
    )}<path class="way" d="M4 36.5H60"></path>`,
  pressure_solvers: () =>
    grid(7, 4, (i, j) => svg`<rect class=${`cell d${(i * 3 + j * 5) % 4}`} x=${4 + 8 * i} y=${4 + 8 * j} width="7.4" height="7.4"></rect>`),
  particles: () =>
    grid(8, 3, (i, j) => svg`<circle class="a" cx=${8 + 6.6 * i + (j % 2) * 3} cy=${34 - 6 * j - (i < 3 ? 0 : 0)} r="3"></circle>`),
  oceans: () => svg`<path class="water" d="M2 20c6-8 12-8 18-1s12 6 18 0 12-7 24 1V38H2Z"></path>`,
  snapshots: () =>
    [0, 1, 2].map(
      (k) => svg`<g class="post" transform=${`translate(${6 + 17 * k} ${5 + 9 * k})`}><rect width="16" height="11" rx="1.5"></rect>
    <path d="M1 1.5 8 7l7-5.5"></path></g>`,
    ),
  synchronisation: () =>
    svg`${grid(
      5,
      3,
      (i, j) => svg`<rect class=${i > 2 ? 'gone' : `p${j}`} x=${7 + 10 * i} y=${5 + 10.5 * j} width="8" height="8" rx="2"></rect>`,
    )}<path class="wait" d="M37.5 2V38"></path>`,
  lag_compensation: () => svg`<path class="shot" d="M13 13H54"></path><circle class="gone" cx="11" cy="13" r="5.5"></circle>
    <circle class="p0" cx="11" cy="29" r="6"></circle><rect class="wall" x="32" y="18" width="6" height="20"></rect>
    <path class="p1" d="M60 13 50 8v10Z"></path>`,
};

/** @param {string} family @returns {Template} */
export const pictureOf = (family) => svg`${PICTURES[family]?.() ?? ''}`;
