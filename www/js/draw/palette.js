// Colours and sizes of the drawings: read from the style sheet, so that a theme is one place.
import { effect } from '../../vendor/signals-core.js';
import { theme } from '../session/state.js';

/** @typedef {{fill: string, text: string, dash: number[]}} Paint */

/**
 * @typedef {object} Palette
 * @property {Paint[]} players
 * @property {string} paper
 * @property {string} ink
 * @property {string} faint    text of second rank
 * @property {string} grid
 * @property {string} edge
 * @property {string} truth
 * @property {string} snap
 * @property {string} buffer
 * @property {string} bufferText
 * @property {string} accent
 * @property {string} mark     of what the sentence is about, and of nothing else
 * @property {string} markLine its edge, and lines that mark
 * @property {string} markText on it, and on paper
 * @property {string} verge
 * @property {string} road
 * @property {string} roadMarks
 * @property {string} onFill   letters inside the players' shapes
 * @property {number} line     px
 * @property {number} marker   px, least diameter
 * @property {number} text     px, of labels
 * @property {number} axis     px, of the numbers at an axis
 * @property {string} font
 */

const DASHES = [[], [6, 3], [2, 2], [8, 3, 2, 3], [12, 4], [1, 3], [4, 2, 1, 2], [10, 2]];

/** @type {Palette | null} */
let cached = null;
let version = 0;

/** @returns {Palette} */
export function palette() {
  if (cached) return cached;
  const style = getComputedStyle(document.documentElement);
  const read = (/** @type {string} */ name) => style.getPropertyValue(name).trim();
  cached = {
    players: DASHES.map((dash, p) => ({ fill: read(`--p${p}-fill`), text: read(`--p${p}-text`), dash })),
    paper: read('--paper'),
    ink: read('--ink'),
    faint: read('--faint'),
    grid: read('--grid'),
    edge: read('--edge'),
    truth: read('--truth'),
    snap: read('--snap'),
    buffer: read('--buffer'),
    bufferText: read('--buffer-text'),
    accent: read('--accent'),
    mark: read('--mark'),
    markLine: read('--mark-line'),
    markText: read('--mark-text'),
    verge: read('--verge'),
    road: read('--road'),
    roadMarks: read('--road-marks'),
    onFill: '#101418',
    line: Number(read('--draw-line')),
    marker: Number(read('--draw-marker')),
    text: Number(read('--draw-text')),
    axis: Number(read('--draw-axis') || read('--draw-text')),
    font: read('--font'),
  };
  return cached;
}

/** @param {Palette} colours @param {number} player @returns {Paint} */
export function paintOf(colours, player) {
  return /** @type {Paint} */ (colours.players[player % colours.players.length]);
}

/** Grows when colours may have changed. */
export function paletteVersion() {
  return version;
}

/** Colours or sizes have changed. */
export function renew() {
  cached = null;
  version++;
}

matchMedia('(prefers-color-scheme: dark)').addEventListener('change', renew);
matchMedia('(max-width: 43.99rem)').addEventListener('change', renew);
effect(() => {
  document.documentElement.dataset.theme = theme.value;
  renew();
});
