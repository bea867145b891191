// The points of an experiment as a table.
import { html, nothing } from '../../../vendor/lit-html.js';
import { signal } from '../../../vendor/signals-core.js';
import { formatValue, identicalOf, meanOf, spreadOf } from './columns.js';
import { columns, front, fronted, select } from './plotted.js';
import { live, points, selected } from './shown.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('./shown.js').Cells} Cells */

export const many = (/** @type {number} */ n) => n.toLocaleString('en');
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

/** @param {string} name @param {string} label @returns {Template} */
function sortable(name, label) {
  const { by, down } = sorting.value,
    now = by === name;
  return html`<th scope="col" aria-sort=${now ? (down ? 'descending' : 'ascending') : 'none'}><button type="button" class="quiet"
    @click=${() => {
      sorting.value = { by: name, down: now && !down };
    }}><span>${label.split(/(?<=[._])/).map((part) => html`${part}<wbr>`)}</span>${
      now
        ? html`<svg class="sign" viewBox="0 0 12 12" aria-hidden="true"><path d=${down ? 'M1 3h10L6 10z' : 'M1 9h10L6 2z'}></path></svg>`
        : nothing
    }</button></th>`;
}

/** @returns {Template} */
export function table() {
  const order = sorted(),
    list = columns.value;
  return html`<div class="wide-table" tabindex="0" role="region" aria-label="Points"><table
    class="data points"><caption>Points: mean and its 95 % interval</caption>
    <thead><tr>${sortable('point', 'Point')}${list.map((column) => sortable(column.name, column.label))}<th
      scope="col">Runs</th>${fronted.value.length === 0 ? nothing : html`<th scope="col">Front</th>`}<td></td></tr></thead>
    <tbody>${order.slice(0, rowsShown.value).map((i) => {
      const row = /** @type {Cells} */ (points.value[i]);
      return html`<tr data-point=${row.point} aria-current=${i === selected.value ? 'true' : 'false'} @click=${() => select(i)}><th
        scope="row">${row.point}</th>
        ${list.map((column) =>
          column.kind === 'axis'
            ? html`<td>${formatValue(row[column.name])}</td>`
            : html`<td title=${spreadOf(row, column.name)}>${meanOf(row, column.name)}</td>`,
        )}<td>${row.runs}</td>
        ${fronted.value.length === 0 ? nothing : html`<td>${front.value.has(i) ? 'front' : ''}</td>`}
        <td><button type="button" class="small" aria-label=${`Open point ${row.point} as session`}
          @click=${(/** @type {Event} */ event) => {
            event.stopPropagation();
            live(row);
          }}>Open</button></td></tr>`;
    })}</tbody></table></div>
    ${
      identicalOf(points.value) > 0
        ? html`<p class="facts"
        id="identical">At ${identicalOf(points.value)} of ${points.value.length} points all repeats gave identical metrics:
      nothing random in this scenario reaches them, or what does is rare.</p>`
        : nothing
    }
    ${
      order.length > rowsShown.value
        ? html`<button type="button"
        @click=${() => {
          rowsShown.value += PAGE;
        }}>${many(order.length - rowsShown.value)} more points</button>`
        : nothing
    }`;
}

/** Another experiment. */
export function renewTable() {
  sorting.value = { by: 'point', down: false };
  rowsShown.value = PAGE;
}
