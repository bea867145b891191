// A plot as SVG: series of points over one axis, with levels to compare them with. For figures of results that documents show.

/** @typedef {{name: string, points: [number, number][], parts?: [number, number][][]}} Series parts: what is joined; default: all points
 * @typedef {{title: string, x: string, y: string, series: Series[], levels?: {at: number, name: string}[],
 * rings?: {at: [number, number], radius: number, colour: string}[],
 * logarithmic?: boolean, across?: boolean}} Figure logarithmic: up; across: the other axis, too */

export const WIDTH = 640,
  HEIGHT = 360;
const LEFT = 70,
  RIGHT = 170,
  TOP = 34,
  BOTTOM = 48;
const COLOURS = ['#0072B2', '#D55E00', '#009E73', '#CC79A7', '#8A6D00', '#56B4E9']; // of Okabe and Ito, the yellow darker

const escape = (/** @type {string} */ text) => text.replaceAll('&', '&amp;').replaceAll('<', '&lt;');
const short = (/** @type {number} */ value) => String(Number(value.toFixed(2)));

/** Steps of 1, 2 or 5 times a power of ten, about five. @param {number} high */
function ticksTo(high) {
  const rough = high / 5,
    power = 10 ** Math.floor(Math.log10(rough)),
    step = power * ([1, 2, 5, 10].find((factor) => factor * power >= rough) ?? 10);
  return Array.from({ length: Math.floor(high / step + 1e-9) + 1 }, (_, i) => i * step);
}

/** Powers of ten. @param {number} low @param {number} high */
const decades = (low, high) =>
  Array.from({ length: Math.round(Math.log10(high / low)) + 1 }, (_, i) => Number((low * 10 ** i).toPrecision(1)));

/** @param {Figure} figure @returns {string} */
export function drawFigure({ title, x, y, series, levels = [], rings = [], logarithmic = false, across: log = false }) {
  const all = series.flatMap(({ points }) => points),
    xs = all.map(([value]) => value),
    ys = [...all.map(([, value]) => value), ...levels.map(({ at }) => at)];
  const left = log ? 10 ** Math.floor(Math.log10(Math.min(...xs))) : 0,
    right = log ? 10 ** Math.ceil(Math.log10(Math.max(...xs))) : Math.max(...xs),
    low = logarithmic ? 10 ** Math.floor(Math.log10(Math.min(...ys))) : 0,
    high = logarithmic ? 10 ** Math.ceil(Math.log10(Math.max(...ys))) : 1.05 * Math.max(...ys);
  const across = (/** @type {number} */ value) =>
    LEFT + (log ? Math.log(value / left) / Math.log(right / left) : value / right) * (WIDTH - LEFT - RIGHT);
  const share = (/** @type {number} */ value) => (logarithmic ? Math.log(value / low) / Math.log(high / low) : value / high);
  const down = (/** @type {number} */ value) => HEIGHT - BOTTOM - share(value) * (HEIGHT - TOP - BOTTOM);
  const text = (/** @type {number} */ begin, /** @type {number} */ top, /** @type {string} */ words, more = '') =>
    `<text x="${short(begin)}" y="${short(top)}"${more}>${escape(words)}</text>`;
  const line = (/** @type {number[]} */ [x1, y1, x2, y2], /** @type {string} */ look) =>
    `<line x1="${short(x1)}" y1="${short(y1)}" x2="${short(x2)}" y2="${short(y2)}" ${look}/>`;
  const grid = 'stroke="#ddd"',
    end = WIDTH - RIGHT,
    bottom = HEIGHT - BOTTOM;
  const numbers = (/** @type {number} */ value) =>
    value >= 1000 && value < 1e6
      ? value.toLocaleString('en')
      : value > 0 && (value < 1e-3 || value >= 1e6)
        ? value.toExponential()
        : String(Number(value.toPrecision(3)));
  const lines = [
    ...(logarithmic ? decades(low, high) : ticksTo(high)).flatMap((value) => [
      line([LEFT, down(value), end, down(value)], grid),
      text(LEFT - 6, down(value) + 4, numbers(value), ' text-anchor="end"'),
    ]),
    ...(log ? decades(left, right) : ticksTo(right)).flatMap((value) => [
      line([across(value), bottom, across(value), bottom + 4], 'stroke="#333"'),
      text(across(value), bottom + 18, numbers(value), ' text-anchor="middle"'),
    ]),
    line([LEFT, bottom, end, bottom], 'stroke="#333"'),
    text(LEFT, 18, title, ' font-weight="bold"'),
    text((LEFT + end) / 2, HEIGHT - 10, x, ' text-anchor="middle"'),
    text(14, (TOP + bottom) / 2, y, ` text-anchor="middle" transform="rotate(-90 14 ${short((TOP + bottom) / 2)})"`),
  ];
  series.forEach(({ name, points, parts = [points] }, i) => {
    const colour = COLOURS[i % COLOURS.length],
      place = (point) => [across(point[0]), down(point[1])].map(short);
    lines.push(
      ...parts.map(
        (part) =>
          `<polyline fill="none" stroke="${colour}" stroke-width="2" points="${part.map((point) => place(point).join(',')).join(' ')}"/>`,
      ),
      ...points.map(place).map(([cx, cy]) => `<circle cx="${cx}" cy="${cy}" r="3" fill="${colour}"/>`),
      line([end + 12, TOP + 10 + 20 * i, end + 30, TOP + 10 + 20 * i], `stroke="${colour}" stroke-width="2"`),
      text(end + 36, TOP + 14 + 20 * i, name),
    );
  });
  for (const { at, radius, colour } of rings)
    lines.push(
      `<circle cx="${short(across(at[0]))}" cy="${short(down(at[1]))}" r="${radius}" fill="none" stroke="${colour}" stroke-width="1.5"/>`,
    );
  for (const { at, name } of levels)
    lines.push(
      line([LEFT, down(at), end, down(at)], 'stroke="#333" stroke-dasharray="5 4"'),
      text(end - 4, down(at) - 4, name, ' text-anchor="end"'),
    );
  return [
    `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${WIDTH} ${HEIGHT}" font-family="sans-serif" font-size="12">`,
    `<rect width="${WIDTH}" height="${HEIGHT}" fill="#fff"/>`,
    ...lines,
    '</svg>',
    '',
  ].join('\n');
}
