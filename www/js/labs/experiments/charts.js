// What was measured over what was varied: a chart for each metric, with a line for each compared value, its 95 % intervals, the lines'
// names next to them, and the mark of what the sentences are about.
import { html } from '../../../vendor/lit-html.js';
import { t } from '../../base/words.js';
import { drawText, outline } from '../../draw/marks.js';
import { paintOf } from '../../draw/palette.js';
import { drawPlot } from '../../draw/plot.js';
import { onto } from '../../workbench/canvas.js';
import { alike, fitOf, markOf } from './finding.js';
import { drawn, inputLabel, inputValue, lined, lineSaid, marked, valueSaid, measured, select, tried } from './plotted.js';
import { nearest } from './scatter.js';
import { live, points, selected } from './shown.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('../../draw/palette.js').Palette} Palette */
/** @typedef {import('./finding.js').Series} Series */
/** @typedef {{pen: CanvasRenderingContext2D, width: number, height: number}} Surface */
/** Where values are. @typedef {{toX: (v: number) => number, toY: (v: number) => number}} Scale */
/** @typedef {{x: number, y: number}} At */

export const CHARTS_MAX = 4;
/** Colours of lines, by their players: two that differ in brightness come first. */
const PAINTS = [3, 2, 0, 1, 4, 5, 6, 7];
const DASH = [7, 5];
export const paintAt = (/** @type {number} */ s) => /** @type {number} */ (PAINTS[s % PAINTS.length]);

/** Drawn points of each chart. @type {Map<string, import('./scatter.js').Spot[]>} */
const spots = new Map();

/** The point that is drawn at an index, if it is one of this run. @param {number} index @returns {number} its place; -1: none */
function placeOf(index) {
  const row = drawn.value[index];
  return row === undefined || row.old === true ? -1 : points.value.findIndex(({ point }) => point === row.point);
}

/** @param {PointerEvent} event @param {string} id @returns {number} */
function pointAt(event, id) {
  const box = /** @type {HTMLElement} */ (event.currentTarget).getBoundingClientRect();
  return placeOf(nearest(spots.get(id) ?? [], event.clientX - box.left, event.clientY - box.top));
}

/** A mouse that is over a point marks it, a press opens it; a finger marks it first. @param {PointerEvent} event @param {string} id */
function press(event, id) {
  const place = pointAt(event, id),
    row = points.value[place];
  if (!row) return;
  if (event.pointerType === 'mouse' || selected.value === place) live(row);
  else select(place);
}

/** @param {PointerEvent} event @param {string} id */
function hover(event, id) {
  if (event.pointerType !== 'mouse') return;
  const place = pointAt(event, id);
  /** @type {HTMLElement} */ (event.currentTarget).style.cursor = place < 0 ? 'default' : 'pointer';
  if (place >= 0 && place !== selected.value) select(place);
}

/** @param {KeyboardEvent} event @param {import('./finding.js').Measured} of */
function key(event, { series }) {
  const now = points.value[selected.value],
    all = tried.value;
  if (event.key === 'Enter' && now) {
    event.preventDefault();
    live(now);
    return;
  }
  const across = { ArrowRight: 1, ArrowLeft: -1 }[event.key] ?? 0,
    up = { ArrowUp: -1, ArrowDown: 1 }[event.key] ?? 0;
  if (across === 0 && up === 0) return;
  event.preventDefault();
  const line = Math.max(
    0,
    series.findIndex(({ places }) => places.some((p) => placeOf(p.index) === selected.value)),
  );
  const next = series[Math.max(0, Math.min(series.length - 1, line + up))],
    x = all[Math.max(0, Math.min(all.length - 1, all.indexOf(marked.value) + across))];
  select(placeOf(next?.places.find((p) => p.x === x)?.index ?? -1));
}

/** @param {import('./finding.js').Measured} of @param {number} i @returns {Template} */
function chart(of, i) {
  const id = `chart-${i}`,
    xPath = lined.value?.xPath ?? '';
  const says = { y: of.name, x: inputLabel(xPath), lines: of.series.map(({ name }) => lineSaid(name)).join(', ') };
  return html`<section class="chart-panel" aria-label=${of.name}><h2 title=${of.path}>${of.name}</h2><div class="view" role="group"
    tabindex="0" aria-label=${t('experiments.plot.keys')} @pointerdown=${(/** @type {PointerEvent} */ event) => press(event, id)}
    @pointermove=${(/** @type {PointerEvent} */ event) => hover(event, id)}
    @keydown=${(/** @type {KeyboardEvent} */ event) => key(event, of)}><canvas id=${id} role="img" data-x=${xPath} data-y=${of.path}
      aria-label=${t('experiments.chart.says', says)}></canvas><take-away data name=${of.name}></take-away></div></section>`;
}

/** @returns {Template} */
export const charts = () => html`<div class="charts">${measured.value.slice(0, CHARTS_MAX).map(chart)}</div>`;

// ---- drawing ----

/** @param {Surface} surface @param {Scale} scale @param {Series} one @param {string} colour */
function band({ pen }, { toX, toY }, { places }, colour) {
  const bounded = places.filter((p) => p.low < p.high);
  pen.setLineDash([]);
  if (bounded.length === places.length && places.length > 1) {
    pen.globalAlpha = 0.18;
    pen.fillStyle = colour;
    pen.beginPath();
    for (const p of places) pen.lineTo(toX(p.x), toY(p.high));
    for (const p of [...places].reverse()) pen.lineTo(toX(p.x), toY(p.low));
    pen.fill();
    pen.globalAlpha = 1;
  }
  pen.strokeStyle = colour;
  pen.lineWidth = 1.5;
  for (const p of bounded) {
    pen.globalAlpha = p.old ? 0.3 : 1;
    pen.beginPath();
    for (const y of [p.low, p.high]) {
      pen.moveTo(toX(p.x) - 4, toY(y));
      pen.lineTo(toX(p.x) + 4, toY(y));
    }
    pen.moveTo(toX(p.x), toY(p.low));
    pen.lineTo(toX(p.x), toY(p.high));
    pen.stroke();
  }
  pen.globalAlpha = 1;
}

/** Places along lines, which texts keep away from. @param {Series[]} series @param {Scale} scale @returns {At[]} */
function along(series, { toX, toY }) {
  return series.flatMap(({ places }) =>
    places.flatMap((p, i) => {
      const next = places[i + 1] ?? p,
        x = toX(p.x),
        y = toY(p.y),
        steps = Math.max(1, Math.ceil(Math.hypot(toX(next.x) - x, toY(next.y) - y) / 6));
      return Array.from({ length: steps }, (_, k) => ({
        x: x + ((toX(next.x) - x) * k) / steps,
        y: y + ((toY(next.y) - y) * k) / steps,
      }));
    }),
  );
}

/** @typedef {{x0: number, x1: number, y0: number, y1: number}} Box */

/** How much of what is drawn lies under a box; what is outside the chart is worst.
 * @param {Box} box @param {At[]} ink @param {Surface} surface */
const under = (box, ink, surface) =>
  (box.x0 < 48 || box.x1 > surface.width - 4 || box.y0 < 8 || box.y1 > surface.height - 36 ? 1e4 : 0) +
  ink.filter((p) => p.x > box.x0 && p.x < box.x1 && p.y > box.y0 && p.y < box.y1).length;

/** A box, and how far it is from what it is about. @typedef {Box & {far: number}} Place */

/** The box with the least under it, and near.
 * @param {Place[]} boxes @param {At[]} ink @param {Surface} surface @returns {Place | undefined} */
function freest(boxes, ink, surface) {
  let best,
    least = Number.POSITIVE_INFINITY;
  for (const box of boxes) {
    const now = 40 * under(box, ink, surface) + box.far;
    if (now < least) [best, least] = [box, now];
  }
  return best;
}

/** Places in a box, which later texts keep away from. @param {Box} box @returns {At[]} */
function filling({ x0, x1, y0, y1 }) {
  const found = [];
  for (let x = x0; x <= x1; x += 8) for (let y = y0; y <= y1; y += 8) found.push({ x, y });
  return found;
}

/** @param {Surface} surface @param {Palette} colours @param {Scale} scale @param {NonNullable<ReturnType<typeof markOf>>} mark
 * @param {At[]} ink */
function drawMarked(surface, colours, { toX, toY }, mark, ink) {
  const { pen } = surface,
    x = toX(mark.x),
    [y0, y1] = [toY(mark.from), toY(mark.to)],
    ring = mark.from === mark.to,
    narrow = surface.width < 380,
    big = colours.text * (narrow ? 1.3 : 1.45),
    small = colours.text * (narrow ? 0.95 : 1.05);
  pen.setLineDash([]);
  pen.strokeStyle = colours.markLine;
  pen.lineWidth = 3;
  pen.beginPath();
  if (ring) pen.arc(x, y0, 15, 0, 2 * Math.PI);
  else {
    pen.moveTo(x, y0);
    pen.lineTo(x, y1);
  }
  pen.stroke();
  pen.font = `700 ${big}px ${colours.font}`;
  const wide = pen.measureText(mark.value).width;
  pen.font = `700 ${small}px ${colours.font}`;
  const width = Math.max(wide, pen.measureText(mark.text).width) + 8,
    height = big + small + 10,
    middle = (y0 + y1) / 2;
  const offsets = ring ? [46, 60, 74, 88, 102, -46, -60, -74, -88, -102] : [0, 14, 28, 42, 56, 70, 84, -14, -28, -42, -56, -70, -84];
  const boxes = offsets.flatMap((dy) =>
    (ring ? [-10, -width / 2, 10 - width, 14, -width - 14] : [8, -width - 8]).map((dx, i) => ({
      x0: x + dx,
      x1: x + dx + width,
      y0: middle + dy - height / 2,
      y1: middle + dy + height / 2,
      far: Math.abs(dy) / 4 + i + (dy < 0 ? 2 : 0),
    })),
  );
  if (!ring) ink.push(...Array.from({ length: Math.ceil(Math.abs(y1 - y0) / 6) }, (_, k) => ({ x, y: Math.min(y0, y1) + 6 * k })));
  else ink.push(...filling({ x0: x - 15, x1: x + 15, y0: y0 - 15, y1: y0 + 15 }));
  const box = freest(boxes, ink, surface);
  if (!box) return;
  if (ring) {
    const below = box.y0 > y0,
      to = Math.max(box.x0 + 8, Math.min(box.x1 - 8, x + 14));
    pen.beginPath();
    pen.moveTo(x + (to - x) * 0.4, y0 + (below ? 15 : -15));
    pen.lineTo(to, below ? box.y0 : box.y1);
    pen.stroke();
  }
  drawText(pen, colours, mark.value, box.x0 + 4, box.y0 + big / 2 + 2, { size: big, bold: true, colour: colours.markText });
  drawText(pen, colours, mark.text, box.x0 + 4, box.y0 + big + small / 2 + 6, { size: small, bold: true, colour: colours.markText });
  ink.push(...filling(box));
}

/** The lines' names next to them.
 * @param {Surface} surface @param {Palette} colours @param {Scale} scale @param {Series[]} series @param {At[]} ink */
function drawNames(surface, colours, { toX, toY }, series, ink) {
  const { pen } = surface,
    size = colours.text * 1.1,
    [a, b] = series;
  const same = series.length === 2 && a && b && alike(a, b);
  const names = same
    ? [{ one: a, text: t('experiments.the_same', { lines: [a, b].map(({ name }) => valueSaid(name)).join(', ') }), colour: colours.ink }]
    : series.map((one, s) => ({ one, text: lineSaid(one.name), colour: paintOf(colours, paintAt(s)).text }));
  for (const { one, text, colour } of names) {
    if (text === '' || one.places.length === 0) continue;
    pen.font = `700 ${size}px ${colours.font}`;
    const width = pen.measureText(text).width + 6,
      rises = fitOf(one.places).slope > 0;
    const boxes = one.places.flatMap((p) =>
      [16, 26, 40, 56].flatMap((far) =>
        [-far, far].flatMap((dy) =>
          (rises === dy < 0 ? [-width, -width / 2, 0] : [0, -width / 2, -width]).map((dx) => ({
            x0: toX(p.x) + dx,
            x1: toX(p.x) + dx + width,
            y0: toY(p.y) + dy - size / 2 - 3,
            y1: toY(p.y) + dy + size / 2 + 3,
            far: far + Math.abs(dx + width / 2) / 20,
          })),
        ),
      ),
    );
    const box = freest(boxes, ink, surface);
    if (!box) continue;
    drawText(pen, colours, text, box.x0 + 3, (box.y0 + box.y1) / 2, { size, bold: true, colour });
    ink.push(...filling(box));
  }
}

/** @param {Surface} surface @param {Palette} colours @param {import('./finding.js').Measured} of @param {string} id */
function drawChart(surface, colours, of, id) {
  const { pen } = surface,
    { series } = of,
    xPath = lined.value?.xPath ?? '';
  const all = series.flatMap(({ places }) => places),
    left = Math.min(...all.map((p) => p.x));
  const scale = drawPlot(surface, colours, {
    lines: [
      { xs: all.map((p) => p.x).concat(left, left), ys: all.map((p) => (p.high > p.y ? p.high : p.y)).concat(0, 0), colour: 'transparent' },
      ...series
        .map(({ name, places }, s) => ({
          xs: places.map((p) => p.x),
          ys: places.map((p) => p.y),
          name: lineSaid(name),
          colour: paintOf(colours, paintAt(s)).text,
          dash: s % 2 === 0 && series.length > 1 ? DASH : [],
          width: 2.5,
        }))
        .reverse() /* the dashed one on top of the whole one: both are seen where they are the same */,
    ],
    x: inputLabel(xPath),
    y: '',
    empty: '',
  });
  if (!scale) return;
  const { toX, toY } = scale;
  series.forEach((one, s) => band(surface, scale, one, paintOf(colours, paintAt(s)).text));
  const found = [...series.entries()].reverse().flatMap(([s, one]) =>
    one.places.map((p) => {
      const x = toX(p.x),
        y = toY(p.y),
        colour = paintOf(colours, paintAt(s)).text,
        now = placeOf(p.index) === selected.value && selected.value >= 0;
      pen.globalAlpha = p.old ? 0.35 : 1;
      pen.setLineDash([]);
      outline(pen, s % 2 === 0 ? 2 : 0, x, y, now ? 13 : 9);
      pen.fillStyle = s % 2 === 0 && series.length > 1 ? colours.paper : colour;
      pen.fill();
      pen.lineWidth = 2.2;
      pen.strokeStyle = colour;
      pen.stroke();
      pen.globalAlpha = 1;
      return { index: p.index, x, y };
    }),
  );
  spots.set(id, found);
  const ink = along(series, scale),
    mark = markOf(of, marked.value, inputValue(xPath, marked.value));
  if (mark) {
    pen.canvas.dataset.mark = `${Math.round(toX(mark.x))} ${Math.round(toY(mark.from))} ${Math.round(toY(mark.to))}`;
    pen.canvas.dataset.says = `${mark.value} ${mark.text}`;
    drawMarked(surface, colours, scale, mark, ink);
  }
  drawNames(surface, colours, scale, series, ink);
}

/** All charts that are there. @param {Palette} colours */
export function drawCharts(colours) {
  for (const [i, of] of measured.value.slice(0, CHARTS_MAX).entries())
    onto(`chart-${i}`, (surface) => drawChart(surface, colours, of, `chart-${i}`));
}
