// The drawing of each question's card. None shows the answer. What has a `data-part` moves: www/cards.json has the places.
import { html, nothing, svg } from '../../vendor/lit-html.js';

/** @typedef {import('lit-html').TemplateResult} Template */

const ROAD = svg`<path class="verge" d="M0 0h250v84H0z"/><path class="road" d="M0 8h250v68H0z"/>
  <path class="marks" d="M0 8h250M0 76h250"/><path class="marks dashes" data-part="road" d="M0 42h3000"/>`;
const PLANE = svg`<path class="plane" d="M0 0h250v84H0z"/>`;
const FLOOR = 74;
const GROUND = svg`<path class="ground" d=${`M0 ${FLOOR}h250v10H0z`}/><path class="ink" d=${`M0 ${FLOOR}h250`}/>`;
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

const SIDE = 11,
  BOX = 'M-5.5 -5.5h11v11h-11z';
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
const column = (x, count, side = SIDE, step = side) => Array.from({ length: count }, (_, i) => [x, FLOOR - side / 2 - step * i, 0]);
/** A high one that buckles: its middle goes one way, its top the other. @param {number} x @param {number} count */
const buckled = (x, count) =>
  column(x, count, 3.6, 7.2).map(([at = 0, y = 0], i) => [
    at + (60 * i * Math.sin((3 * i) / count)) / count,
    y,
    14 * Math.cos((3 * i) / count),
  ]);

/** The two things that a card compares are 60 units apart, a quarter of its width: 40 px on a phone.
 * @type {Record<string, import('lit-html').TemplateResult | import('lit-html').TemplateResult[]>} */
const DRAWINGS = {
  late_answer: svg`${ROAD}${car(132, 59, 'ghost')}${car(62, 59, 'a')}
    <path class="way" d="M50 20Q120 6 206 20"/><path class="way" d="M210 32Q170 52 120 56"/>
    <path class="solid" d="M222 8l14 14-14 14-14-14z"/><rect class="letter" x="10" y="8" width="36" height="24" rx="5"/>
    <path class="ink" d="M18 20h19m-7 -6l7 6-7 6"/>`,
  jump_back: svg`${ROAD}${car(180, 50, 'ghost', 'rest')}${car(76, 50, 'a')}<path class="back" d="M184 26Q130 4 84 26m2 -13l-3 14 14 1"/>`,
  in_the_past: svg`${ROAD}${car(198, 25, 'a')}${car(134, 59, 'ghost')}${car(50, 59, 'b')}`,
  who_waits: svg`${PLANE}${[0, 1, 2].map(
    (row) =>
      svg`<text x="22" y=${21 + row * 26}>${'ABC'[row]}</text>${[0, 1, 2, 3, 4, 5].map(
        (i) => svg`<rect class="ghost" x=${44 + i * 31} y=${6 + row * 26} width="23" height="20" rx="4"/>`,
      )}<rect class=${'abc'[row]} data-part=${'abc'[row]} width="23" height="20" rx="4"
        transform=${`translate(${row === 2 ? 168 : 106} ${6 + row * 26})`}/>`,
  )}<path class="back" data-part="step" transform="translate(102 2)" d="M0 0v80"/>`,
  behind_wall: svg`${PLANE}<rect class="wall" x="24" y="34" width="112" height="13"/>
    <circle class="ghost" data-part="seen" transform="translate(160 65)" r="13"/>
    <g data-part="a" transform="translate(64 65)"><circle class="a" r="13"/><text y="5">A</text></g>
    <path class="back shot" d="M170 52L206 24"/><path class="b" d="M200 30l14 -25 14 26z"/>`,
  keeps_energy: svg`${PLANE}<ellipse class="curve" cx="84" cy="42" rx="28" ry="22"/>
    <circle class="d" data-part="euler" transform="translate(112 42)" r="6"/>
    <circle class="c" data-part="verlet" transform="translate(112 42)" r="6"/>
    <path class="back" d="M112 42c0 30 -60 34 -62 0c0 -42 80 -44 84 0c2 52 -108 54 -110 0c-2 -44 76 -52 104 -28"/>
    <path class="ink" d="M190 80h48"/><path class="left" d="M196 60h15v20h-15z"/><path class="right" d="M217 4h15v76h-15z"/>`,
  bullet_through: svg`${PLANE}<path class="marks" d="M0 42h250"/><rect class="wall" x="118" y="6" width="12" height="72"/>
    ${[24, 88, 152].map((x) => svg`<circle class="ghost" cx=${x} cy="42" r="11"/>`)}
    <circle class="c" data-part="ball" transform="translate(216 42)" r="13"/>
    <path class="back" d="M90 24Q122 2 152 24m1 -13l0 14 -14 -3"/>`,
  falling_stack: svg`${PLANE}${GROUND}${boxes(
    [
      [62, 68.5, 0],
      [54, 57, 8],
      [72, 46, 24],
      [44, 37, 38],
      [84, 30, 52],
      [34, 56, 70],
      [96, 57, 30],
      [38, 22, 20],
    ],
    'c',
  )}${boxes(column(186, 6), 'd')}`,
  how_many_sweeps: svg`${PLANE}${GROUND}${boxes(buckled(60, 10), 'c small', PAIR)}${boxes(
    column(186, 10, 3.6, 7.2),
    'd small',
    PAIR,
  )}<text x="146" y="46">×?</text>`,
  what_a_cheat_gains: svg`${ROAD}${car(60, 42, 'ghost')}${car(138, 42, 'a')}
    <path class="solid" d="M226 6l13 13-13 13-13-13zM223 28h6v50h-6z"/>
    <rect class="letter" x="10" y="4" width="24" height="18" rx="4"/><rect class="letter" x="38" y="4" width="24" height="18" rx="4"/>
    <path class="ink" d="M16 13h11m-4 -4l4 4-4 4M44 13h11m-4 -4l4 4-4 4"/>`,
};

/** @param {string} id of a lesson @returns {Template} */
export function drawingOf(id) {
  return html`<svg class="sketch" viewBox="0 0 250 84" aria-hidden="true" preserveAspectRatio="xMidYMid slice">${
    DRAWINGS[id] ?? PLANE
  }</svg>`;
}

/** Cost along, error up, each with three methods: a sketch, with the two handles and the ring of the page that it leads to.
 * @returns {Template} */
export const tradeoffDrawing = () =>
  html`<svg class="sketch outlook" viewBox="0 0 250 104" aria-hidden="true"><path class="axes" d="M8 4v92h238"/>
    <path class="within" d="M8 58h116v38H8z"/><path class="handle" d="M124 4v92M8 58h238"/>
    <path class="back dashes" d="M36 10L222 50"/><path class="grey" d="M40 16L196 76"/><path class="curve" d="M56 20L138 88"/>
    <circle class="ring" cx="106" cy="62" r="9"/></svg>`;
