// The points as a scatter plot: what its axes are, the drawing, its key, and the selected point in words.
import { html, nothing } from '../../../vendor/lit-html.js';
import { effect, signal } from '../../../vendor/signals-core.js';
import { address } from '../../base/api.js';
import { t } from '../../base/words.js';
import { palette } from '../../draw/palette.js';
import { theme } from '../../session/state.js';
import { onto } from '../../workbench/canvas.js';
import { mark } from '../../workbench/player_mark.js';
import { drawCharts } from './charts.js';
import { boundsOf, formatValue, meanOf, numberOf, spreadOf } from './columns.js';
import { chosen, columns, front, labelOf, named, plotsErrorAndCost, plotted, positive, select } from './plotted.js';
import { SERIES_MAX, drawScatter, nearest, seriesOf } from './scatter.js';
import { live, points, record, runOf, scenario as whole, selected } from './shown.js';
import { many } from './table.js';

/** @typedef {import('lit-html').TemplateResult} Template */

const valueOf = (/** @type {Event} */ event) => /** @type {HTMLSelectElement} */ (event.target).value;

/** @type {import('./scatter.js').Spot[]} */
let spots = [];
/** Points that lie under others. */
const covered = signal(0);

/** @param {PointerEvent} event */
function press(event) {
  const box = /** @type {HTMLElement} */ (event.currentTarget).getBoundingClientRect();
  const index = nearest(spots, event.clientX - box.left, event.clientY - box.top),
    row = points.value[index];
  if (!row) return;
  if (selected.value === index) live(row);
  else select(index);
}

/** @param {PointerEvent} event */
function hover(event) {
  const box = /** @type {HTMLElement} */ (event.currentTarget).getBoundingClientRect();
  const far = nearest(spots, event.clientX - box.left, event.clientY - box.top) < 0;
  /** @type {HTMLElement} */ (event.currentTarget).style.cursor = far ? 'default' : 'pointer';
}

/** @param {KeyboardEvent} event */
function key(event) {
  const row = points.value[selected.value];
  if (event.key === 'Enter' && row) {
    event.preventDefault();
    live(row);
    return;
  }
  const way_ = ['ArrowRight', 'ArrowUp'].includes(event.key) ? 1 : ['ArrowLeft', 'ArrowDown'].includes(event.key) ? -1 : 0;
  if (way_ === 0 || spots.length === 0) return;
  event.preventDefault();
  const at = spots.findIndex((spot) => spot.index === selected.value);
  select(spots[at < 0 ? 0 : Math.max(0, Math.min(spots.length - 1, at + way_))]?.index ?? -1);
}

/** @param {'x' | 'y'} which @param {import('./columns.js').Column[]} list @returns {Template} */
function axisChoice(which, list) {
  const log = which === 'x' ? 'logX' : 'logY',
    name = plotted.value[which],
    label = t(`experiments.plot.${which}`);
  const plot = (/** @type {Event} */ event) => {
    chosen.value = { ...chosen.value, [which]: valueOf(event), [log]: null };
  };
  const toggle = () => {
    chosen.value = { ...chosen.value, [log]: !plotted.value[log] };
  };
  return html`<span class="axischoice"><label class="field choice"><span>${label}</span><select id=${`plot-${which}`} @change=${plot}>
    ${list.map((column) => html`<option value=${column.name} .selected=${column.name === name}>${column.label}</option>`)}</select></label>
    <label class="toggle"><input type="checkbox" id=${`log-${which}`} aria-label=${t('experiments.plot.logarithmic', { axis: label })}
      .checked=${plotted.value[log]} ?disabled=${!positive(name)} @change=${toggle}><span>log</span></label></span>`;
}

/** The selected point, in words. @returns {string} */
function words() {
  const row = points.value[selected.value];
  if (!row) return '';
  const axes = columns.value
    .filter((column) => column.kind === 'axis')
    .map((column) => `${column.label} ${formatValue(row[column.name], column.path, whole.value)}`);
  const values = record.value.experiment.metrics.map(
    (/** @type {string} */ name) => `${named(name)} ${meanOf(row, name)}${numberOf(row, 'runs') > 1 ? `, ${spreadOf(row, name)}` : ''}`,
  );
  return t(front.value.has(selected.value) ? 'experiments.says.front' : 'experiments.says', {
    n: String(row.point),
    values: [...axes, ...values].join('; '),
  });
}

/** The marks of the series; none where there are too many of them. @returns {Template[]} */
function seriesKeys() {
  const { by } = plotted.value,
    names = seriesOf(points.value, by),
    path = columns.value.find((column) => column.name === by)?.path;
  if (by === '' || names.length > SERIES_MAX) return [];
  const valueIn = (/** @type {string} */ name) => formatValue(Number.isNaN(Number(name)) ? name : Number(name), path, whole.value);
  return names.map((name, s) => html`<span class="sample">${mark(s)} ${valueIn(name)}</span>`);
}

const frontKey = () =>
  html`<span class="sample"><svg class="mark frontmark" viewBox="0 0 18 18" aria-hidden="true"><circle cx="9" cy="9"
      r="7"></circle></svg>${t('experiments.plot.front')}</span>`;

/** @returns {Template} */
function coveredKey() {
  const counts = { n: many(covered.value), points: many(points.value.length) };
  return html`<span class="sample" id="covered">${t('experiments.plot.covered', counts)}</span>`;
}

/** @returns {Template} */
const legend = () => html`<div class="key">${seriesKeys()}
    ${plotsErrorAndCost.value ? frontKey() : nothing}
    ${covered.value > 0 ? coveredKey() : nothing}</div>`;

/** @returns {Template} */
export function scatter() {
  const row = points.value[selected.value],
    numbers = columns.value.filter((column) => column.numbers);
  const splits = columns.value.filter((column) => column.kind === 'axis' && seriesOf(points.value, column.name).length <= SERIES_MAX);
  return html`<section class="scatter" aria-label=${t('experiments.scatter')}><div
    class="choices">${axisChoice('y', numbers)}${axisChoice('x', numbers)}
      <label class="field choice"><span>${t('experiments.plot.series')}</span><select id="plot-by"
        @change=${(/** @type {Event} */ event) => {
          chosen.value = { ...chosen.value, by: valueOf(event) };
        }}>
        <option value="">${t('experiments.none')}</option>${splits.map(
          (column) => html`<option value=${column.name}
          .selected=${column.name === plotted.value.by}>${column.label}</option>`,
        )}</select></label></div>
    <div class="view" role="group" tabindex="0" id="scatter-box"
      aria-label=${t('experiments.plot.keys')}
      @pointerdown=${press} @pointermove=${hover} @keydown=${key}><canvas id="scatter" role="img"
        aria-label=${
          t('experiments.plot.says', { n: points.value.length, y: labelOf(plotted.value.y), x: labelOf(plotted.value.x) }) +
          (plotsErrorAndCost.value ? t('experiments.plot.says.front', { n: front.value.size }) : '')
        }></canvas><take-away data name=${t('experiments.points')}></take-away></div>
    ${legend()}
    <div class="looked"><output id="point"
      aria-live="polite">${row ? words() : t('experiments.plot.select')}</output>
      ${
        row
          ? html`<span class="acts"><button type="button" id="open-live" @click=${() => live(row)}>${t('experiments.open_live')}</button>
        <a class="button" href=${address(`experiments/${record.value.id}/runs/${runOf(row)}/trace`).href}
          download=${`run${runOf(row)}.csv`}>${t('experiments.trace')}</a></span>`
          : nothing
      }</div></section>`;
}

// ---- drawing ----

function draw() {
  drawCharts(palette());
  onto('scatter', (surface) => {
    const drawn = drawScatter(
      surface,
      palette(),
      points.value,
      plotted.value,
      plotsErrorAndCost.value ? front.value : new Set(),
      selected.value,
      { x: labelOf(plotted.value.x), y: labelOf(plotted.value.y), empty: t('experiments.plot.empty') },
    );
    spots = drawn.spots;
    covered.value = drawn.covered;
  });
}
let asked = false;
/** In the next frame. */
export function redraw() {
  if (asked) return;
  asked = true;
  requestAnimationFrame(() => {
    asked = false;
    draw();
  });
}

effect(() => {
  points.value;
  plotted.value;
  selected.value;
  theme.value;
  redraw();
});
addEventListener('resize', redraw);
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);

/** What is plotted, for files that are saved of it. */
export const tableOf = () => ({
  columns: [
    t('experiments.column.point'),
    ...columns.value.flatMap(({ name, kind }) =>
      kind === 'axis' ? [name] : [name, t('experiments.column.from', { name }), t('experiments.column.to', { name })],
    ),
  ].map((name) => ({ name, unit: '' })),
  rows: points.value.map((row) => [
    row.point ?? null,
    ...columns.value.flatMap(({ name, kind }) => {
      const { low, high } = boundsOf(row, name);
      return kind === 'axis'
        ? [row[name] ?? null]
        : [numberOf(row, name), low, high].map((value) => (Number.isFinite(value) ? value : null));
    }),
  ]),
});
