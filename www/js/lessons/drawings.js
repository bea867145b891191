// The drawing of each question's card. None shows the answer. What has a `data-part` moves: www/cards.json has the places.
import { html, nothing, svg } from '../../vendor/lit-html.js';

/** @typedef {import('lit-html').TemplateResult} Template */

const ROAD = svg`<path class="verge" d="M0 0h250v128H0z"/><path class="road" d="M0 34h250v74H0z"/>
  <path class="marks" d="M0 34h250M0 108h250"/><path class="marks dashes" data-part="road" d="M0 71h3000"/>`;
const PLANE = svg`<path class="plane" d="M0 0h250v128H0z"/>`;
const GROUND = svg`<path class="ground" d="M0 112h250v16H0z"/><path class="ink" d="M0 112h250"/>`;
const BODY = 'M-42 -12Q-42 -18 -34 -18L10 -18Q44 -16 44 0Q44 16 10 18L-34 18Q-42 18 -42 12Z';
const WEDGE = 'M-42 -16L-34 -18L-2 -17L42 -4Q46 0 42 4L-2 17L-34 18L-42 16L-40 0Z';

/** A car. @param {number} x @param {number} y @param {'a' | 'b' | 'ghost'} who @param {string} [part] */
function car(x, y, who, part = who) {
  const path = who === 'b' ? WEDGE : BODY;
  return svg`<g data-part=${part} transform=${`translate(${x} ${y})`}>${
    who === 'ghost' ? nothing : svg`<path class="solid" d="M-30 -22h16v6h-16zM-30 16h16v6h-16zM14 -21h14v6h-14zM14 15h14v6h-14z"/>`
  }<path class=${who} d=${path}/>${
    who === 'ghost' ? nothing : svg`<circle class="badge" cx="-10" cy="0" r="12"/><text x="-10" y="5">${who.toUpperCase()}</text>`
  }</g>`;
}

const BOX = 'M-9 -9h18v18h-18z';
/** Two of a high column, drawn from the middle of the lower one. */
const PAIR = 'M-1.8 -5.4h3.6v7.2h-3.6zM-1.8 -1.8h3.6';

/** Boxes, a path each: middle, angle. @param {number[][]} list @param {string} name @param {string} [path] */
const boxes = (list, name, path = BOX) =>
  list.map(
    ([x, y, angle], i) =>
      svg`<path class=${name} data-part=${name.startsWith('c') ? `box${i}` : nothing} d=${path}
        transform=${`translate(${x} ${y}) rotate(${angle})`}/>`,
  );

/** A column that stands on the ground. @param {number} x @param {number} count @param {number} [side] @param {number} [step] */
const column = (x, count, side = 18, step = side) => Array.from({ length: count }, (_, i) => [x, 112 - side / 2 - step * i, 0]);
/** A high one that buckles: its middle goes one way, its top the other. @param {number} x @param {number} count */
const buckled = (x, count) =>
  column(x, count, 3.6, 7.2).map(([at = 0, y = 0], i) => [
    at + (14 * i * Math.sin((5.5 * i) / count)) / count,
    y,
    4 * Math.cos((5.5 * i) / count),
  ]);

/** @type {Record<string, import('lit-html').TemplateResult | import('lit-html').TemplateResult[]>} */
const DRAWINGS = {
  late_answer: svg`${ROAD}${car(60, 90, 'ghost')}${car(60, 90, 'a')}
    <path class="way" d="M60 52Q120 -6 198 30"/><path class="way" d="M198 42Q170 78 112 88"/>
    <path class="solid" d="M205 20l15 15-15 15-15-15z"/><rect class="letter" x="14" y="36" width="40" height="28" rx="5"/>
    <path class="ink" d="M24 50h20m-7 -6l7 6-7 6"/>`,
  jump_back: svg`${ROAD}${car(174, 71, 'ghost', 'rest')}${car(76, 71, 'a')}<path class="back" d="M180 40Q130 6 86 38m2 -14l-3 15 15 1"/>`,
  in_the_past: svg`${ROAD}${car(160, 53, 'a')}${car(176, 90, 'ghost')}${car(96, 90, 'b')}`,
  who_waits: svg`${PLANE}${[0, 1, 2].map(
    (row) =>
      svg`<text x="22" y=${33 + row * 36}>${'ABC'[row]}</text>${[0, 1, 2, 3, 4, 5].map(
        (i) => svg`<rect class="ghost" x=${44 + i * 31} y=${16 + row * 36} width="23" height="23" rx="4"/>`,
      )}<rect class=${'abc'[row]} data-part=${'abc'[row]} width="23" height="23" rx="4"
        transform=${`translate(${row === 2 ? 168 : 106} ${16 + row * 36})`}/>`,
  )}<path class="back" data-part="step" transform="translate(102 8)" d="M0 0v112"/>`,
  behind_wall: svg`${PLANE}<rect class="wall" x="92" y="58" width="18" height="64"/>
    <circle class="ghost" data-part="seen" transform="translate(62 52)" r="15"/>
    <g data-part="a" transform="translate(62 98)"><circle class="a" r="15"/><text y="5">A</text></g>
    <path class="back shot" d="M80 50L188 34"/><path class="b" d="M190 26l38 -8 -4 34z"/>`,
  keeps_energy: svg`${PLANE}<ellipse class="curve" cx="100" cy="64" rx="44" ry="36"/>
    <circle class="d" data-part="euler" transform="translate(144 64)" r="6"/>
    <circle class="c" data-part="verlet" transform="translate(144 64)" r="6"/>
    <path class="back" d="M100 64m0 -36c70 -2 72 76 0 80c-90 2 -92 -92 0 -94c108 0 108 106 4 108"/><path class="ink" d="M196 116h44"/>
    <path class="left" d="M201 82h14v34h-14z"/><path class="right" d="M221 40h14v76h-14z"/>`,
  bullet_through: svg`${PLANE}<path class="marks" d="M0 64h250"/><rect class="wall" x="118" y="14" width="12" height="100"/>
    ${[24, 86, 150].map((x) => svg`<circle class="ghost" cx=${x} cy="64" r="11"/>`)}
    <circle class="c" data-part="ball" transform="translate(212 64)" r="13"/>
    <path class="back" d="M88 44Q120 20 150 44m1 -13l0 14 -14 -3"/>`,
  falling_stack: svg`${PLANE}${GROUND}${boxes(
    [
      [62, 103, 0],
      [58, 84, 8],
      [70, 66, 24],
      [46, 52, 38],
      [80, 40, 52],
      [30, 82, 70],
      [104, 84, 30],
      [36, 26, 20],
    ],
    'c',
  )}${boxes(column(186, 6), 'd')}`,
  how_many_sweeps: svg`${PLANE}${GROUND}${boxes(buckled(76, 20), 'c small', PAIR)}${boxes(
    column(186, 20, 3.6, 7.2),
    'd small',
    PAIR,
  )}<path class="way" d="M112 24Q138 60 114 98"/><text x="146" y="66">×?</text>`,
  what_a_cheat_gains: svg`${ROAD}${car(66, 71, 'ghost')}${car(66, 71, 'a')}
    <path class="solid" d="M206 10l14 14-14 14-14-14zM203 34h6v88h-6z"/>${[136, 164].map(
      (x) => svg`<path class="letter" d=${`M${x} 44h22v15h-22zl11 8 11 -8`}/><path class="letter" d=${`M${x} 82h22v15h-22zl11 8 11 -8`}/>`,
    )}<rect class="letter" x="30" y="8" width="26" height="22" rx="4"/><rect class="letter" x="60" y="8" width="26" height="22" rx="4"/>
    <path class="ink" d="M37 19h12m-4 -4l4 4-4 4M67 19h12m-4 -4l4 4-4 4"/>`,
};

/** @param {string} id of a lesson @returns {Template} */
export function drawingOf(id) {
  return html`<svg class="sketch" viewBox="0 0 250 128" aria-hidden="true" preserveAspectRatio="xMidYMid slice">${
    DRAWINGS[id] ?? PLANE
  }</svg>`;
}
