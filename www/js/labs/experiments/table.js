// The points of an experiment as a table.
import { html, nothing } from '../../../vendor/lit-html.js';
import { signal } from '../../../vendor/signals-core.js';
import { formatValue, identicalOf, meanOf, spreadOf } from './columns.js';
import { language, t } from '../../base/words.js';
import { columns, front, fronted, select } from './plotted.js';
import { live, points, scenario, selected } from './shown.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('./shown.js').Cells} Cells */

export const many = (/** @type {number} */ n) => n.toLocaleString(language.value);
const PAGE = 100;
const rowsShown = signal(PAGE);
/** @type {import('@preact/signals-core').Signal<{by: string, down: boolean}>} */
const sorting = signal({ by: 'point', down: false });

/** @returns {number[]} */
function sorted() {
  const { by, down } = sorting.value,
    rows = points.value;
  const order = rows.map((_, i) => i);
  const value = (/** @type {number} */ i) => rows[i]?.[by] ?? null;
  order.sort((a, b) => {
    const x = value(a),
      y = value(b);
    if (x === null || y === null) return (x === null ? 1 : 0) - (y === null ? 1 : 0); /* missing values come last */
    const way_ = typeof x === 'number' && typeof y === 'number' ? x - y : String(x).localeCompare(String(y));
    return (down ? -way_ : way_) || a - b;
  });
  return order;
}

/** @param {string} name @param {string} label @param {string} [path] @returns {Template} */
function sortable(name, label, path) {
  const { by, down } = sorting.value,
    now = by === name;
  const sort = () => {
    sorting.value = { by: name, down: now && !down };
  };
  const sign = () =>
    html`<svg class="sign" viewBox="0 0 12 12" aria-hidden="true"><path d=${down ? 'M1 3h10L6 10z' : 'M1 9h10L6 2z'}></path></svg>`;
  return html`<th scope="col" data-column=${name} title=${path ?? nothing}
    aria-sort=${now ? (down ? 'descending' : 'ascending') : 'none'}><button type="button" class="quiet"
    @click=${sort}><span>${label}</span>${now ? sign() : nothing}</button></th>`;
}

/** What stands above the columns. @param {import('./columns.js').Column[]} list @returns {Template} */
function headings(list) {
  const axesAndMetrics = list.map((column) => sortable(column.name, column.label, column.path)),
    onFront = () => html`<th scope="col" data-column="front">${t('experiments.front')}</th>`;
  return html`<tr>${sortable('point', t('experiments.point'))}${axesAndMetrics}<th
      scope="col" data-column="runs">${t('experiments.form')}</th>${fronted.value.length === 0 ? nothing : onFront()}<td></td></tr>`;
}

/** @returns {Template} */
export function table() {
  const order = sorted(),
    list = columns.value;
  return html`<div class="wide-table" tabindex="0" role="region" aria-label=${t('experiments.points')}><table
    class="data points"><caption>${t('experiments.table')}</caption>
    <thead>${headings(list)}</thead>
    <tbody>${order.slice(0, rowsShown.value).map((i) => {
      const row = /** @type {Cells} */ (points.value[i]);
      return html`<tr data-point=${row.point} aria-current=${i === selected.value ? 'true' : 'false'} @click=${() => select(i)}><th
        scope="row">${row.point}</th>
        ${list.map((column) =>
          column.kind === 'axis'
            ? html`<td>${formatValue(row[column.name], column.path, scenario.value)}</td>`
            : html`<td title=${spreadOf(row, column.name)}>${meanOf(row, column.name)}</td>`,
        )}<td>${row.runs}</td>
        ${fronted.value.length === 0 ? nothing : html`<td>${front.value.has(i) ? t('experiments.on_front') : ''}</td>`}
        <td><button type="button" class="small" aria-label=${t('experiments.open_point', { n: String(row.point) })}
          @click=${(/** @type {Event} */ event) => {
            event.stopPropagation();
            live(row);
          }}>${t('experiments.open')}</button></td></tr>`;
    })}</tbody></table></div>
    ${
      identicalOf(points.value) > 0
        ? html`<p class="facts"
        id="identical">${t('experiments.identical', { n: identicalOf(points.value), points: points.value.length })}</p>`
        : nothing
    }
    ${
      order.length > rowsShown.value
        ? html`<button type="button"
        @click=${() => {
          rowsShown.value += PAGE;
        }}>${t('experiments.points.more', { n: many(order.length - rowsShown.value) })}</button>`
        : nothing
    }`;
}

/** Another experiment. */
export function renewTable() {
  sorting.value = { by: 'point', down: false };
  rowsShown.value = PAGE;
}
