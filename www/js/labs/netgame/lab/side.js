// The side column: the scenario's text, the charts, and the current values.
import { html, nothing } from '../../../../vendor/lit-html.js';
import { signal } from '../../../../vendor/signals-core.js';
import { INTERPOLATION } from '../core/frame.js';
import { part } from '../../../base/api.js';
import { fixed, letter, signed } from '../../../base/format.js';
import { LATELY_S } from '../core/memory.js';
import { lesson, locked, params } from '../../../session/state.js';
import { open } from '../../../workbench/dialog.js';
import { layout } from '../core/layout.js';
import { connectionEvents, memory, scale, unit } from '../core/state.js';
import { countOf, sentences, tell } from '../views/sentences.js';
import { FEW, bufferCurves, errorCurves } from '../views/curves.js';
import { workPrecisionButton } from '../../../workbench/work_precision.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('../core/frame.js').Frame} Frame */
/** @typedef {import('../core/frame.js').View} View */

const DASHES = ['', '6 3', '2 2', '8 3 2 3', '12 4', '1 3', '4 2 1 2', '10 2'];

/** @param {number} player @param {boolean} dotted @param {string} text @returns {Template} */
function sample(player, dotted, text) {
  return html`<span class="sample"><svg data-player=${player % 8} viewBox="0 0 28 8" aria-hidden="true"><line x1="0" x2="28" y1="4" y2="4"
    stroke-dasharray=${dotted ? '1.5 3' : DASHES[player % 8]}></line></svg>${text}</span>`;
}

/** @returns {Template} */
function units() {
  return html`<span class="units" role="group" aria-label="Unit of the distance">${(/** @type {const} */ (['px', 'm', 'ms'])).map(
    (name) => html`<button
    type="button" aria-pressed=${unit.value === name} @click=${() => {
      unit.value = name;
    }}>${name}</button>`,
  )}</span>`;
}

/** @param {'error' | 'buffer'} which @returns {Template} */
function tableButton(which) {
  const name = which === 'error' ? 'distance' : which,
    id = `${which}-chart`;
  return html`<take-away of=${id} data=${id} name=${name}></take-away><button type="button" class="small" aria-label=${`Table of the ${name}`}
    @click=${() => open({ kind: 'table', of: which })}>Table</button>`;
}

/**
 *
 * @typedef
 *  {{name: string, unit: string, help?: string, of: (view: View, player: number, lately: import('../core/memory.js').Lately) => string}}
 *  Row */

const MEAN = `mean of the last ${LATELY_S} s; a dash: nothing was counted`;
const LISTED = 6; /* events of connections */

/** @returns {Row[]} */
function rows() {
  const way = unit.value === 'm' ? 'm' : 'px';
  const size = way === 'm' ? 1 : scale.pxPerMetre;
  const apart = (/** @type {number} */ metres) => signed(metres * size, way === 'm' ? 2 : 0);
  return [
    {
      name: 'Input latency',
      unit: 'ms',
      help: `From a change of the controls to the first display that includes it: ${MEAN}`,
      of: (_, __, lately) => fixed(lately.latency ?? NaN, 0),
    },
    {
      name: 'Changes lost',
      unit: '%',
      help: `Changes of the controls that the server never applied: share of the last ${LATELY_S} s; a dash: there was none`,
      of: (_, __, lately) => fixed(100 * (lately.lost ?? NaN), 0),
    },
    {
      name: 'Own, error',
      unit: way,
      help: `Distance of the drawn own entity from the ground truth at the drawn tick: ${MEAN}`,
      of: (_, __, lately) => fixed((lately.error ?? NaN) * size, way === 'm' ? 2 : 1),
    },
    {
      name: 'Own, lead',
      unit: way,
      help: 'Drawn own entity minus the server’s present one: ahead with prediction, behind without. Not an error',
      of: (view) => apart(view.own_lead_m),
    },
    { name: 'Others, error', unit: way, of: (view) => apart(view.remote_error_m) },
    { name: 'Others, age', unit: 'ms', of: (view) => fixed(view.view_age_ms, 0) },
    { name: 'Buffer', unit: 'ms', of: (view) => (view.flags & INTERPOLATION ? fixed(view.buffer_ms, 0) : 'off') },
    { name: 'Unacknowledged inputs', unit: '', of: (view) => String(view.unacked) },
    { name: 'Corrections', unit: '', of: (view) => String(view.corrections) },
    { name: 'Refused inputs', unit: '', of: (view) => String(view.refused) },
    { name: 'Input lead', unit: 'ticks', of: (view) => signed(view.slack_ticks, 1) },
  ];
}

const NOTHING = { error: null, latency: null, lost: null };

/** Events of connections; hidden while all clients are playing. @returns {Template | typeof nothing} */
function connectionList() {
  const list = connectionEvents.value.slice(-LISTED);
  if (list.length === 0) return nothing;
  return html`<section class="happened" aria-label="Connections"><h3>Connections</h3><ol>${list.map(
    (one) => html`<li><span>${fixed(one.t, 1)} s</span>
    <b>${letter(one.player)}</b> ${one.what}</li>`,
  )}</ol></section>`;
}

/** @type {import('@preact/signals-core').Signal<typeof import('../compare/compare.js') | null>} */
const comparison = signal(null);

/** Two runs in place of the views, while they are compared. */
export const compared = () => (comparison.value?.active.value ? comparison.value : null);

export async function compare() {
  comparison.value = await part(() => import('../compare/compare.js'));
  comparison.value.begin();
}

export const compareButton = () =>
  lesson.value === null
    ? html`<button type="button" class="compare" ?disabled=${locked.value !== ''} title=${locked.value || nothing}
    @click=${compare}>Compare</button>`
    : nothing;

/** What each player meets, in words. @returns {Template | typeof nothing} */
function meets() {
  const players = layout.value?.players.length ?? 0;
  if (players === 0 || players > FEW) return nothing;
  return html`<section class="meets" aria-label="In words"><dl>${Array.from({ length: players }, (_, p) =>
    Array.from(
      { length: countOf(players) },
      (_, i) => html`<div data-player=${p}><dt data-term=${`${p}/${i}`}>–</dt><dd data-sentence=${`${p}/${i}`}>–</dd></div>`,
    ),
  )}</dl></section>`;
}

/** @param {Frame} frame */
function showMeets(frame) {
  const players = frame.views.length - 1;
  for (const place of document.querySelectorAll('[data-sentence]')) {
    const [p = 0, i = 0] = (place.getAttribute('data-sentence') ?? '').split('/').map(Number);
    const view = frame.views[1 + p],
      one = view && sentences(view, p, players, memory)[i];
    if (!one) continue;
    tell(place, one);
    const term = document.querySelector(`[data-term="${p}/${i}"]`);
    if (term && term.textContent !== one.term) term.textContent = one.term;
  }
}

/** @returns {Template} */
export function side() {
  const players = layout.value?.players ?? [];
  const p = params.value;
  return html`<aside class="side" aria-label="Charts and numbers">
    <div class="about"><h2>${p?.paper ? `${p.paper}: ` : ''}${p?.title ?? ''}</h2>${p?.text ? html`<p>${p.text}</p>` : nothing}
      ${(layout.value?.notices ?? []).map((text) => html`<p role="note"><strong>Nothing is measured.</strong> ${text}</p>`)}</div>
    ${connectionList()}
    ${meets()}
    ${compareButton()}${workPrecisionButton()}
    <section class="chart"><div class="head"><h3>Drawn − server now</h3>${units()}</div>
      <div class="plot" id="error-chart" role="img"
        aria-label="Curve of the distances from the server’s present over time; the table has the numbers"></div>
      <div class="key">${players.map((_, i) => sample(i, false, letter(i)))}<span>own lead</span>
        ${players.length <= FEW ? sample(7, true, 'others') : nothing}${tableButton('error')}</div></section>
    <section class="chart"><div class="head"><h3>Interpolation buffer (ms)</h3></div>
      <div class="plot" id="buffer-chart" role="img" aria-label="Curve of the buffers over time; the table has the numbers"></div>
      <div class="key">${players.map((_, i) => sample(i, false, letter(i)))}${tableButton('buffer')}</div></section>
    <div class="wide-table" tabindex=${players.length > FEW ? '0' : nothing} role=${players.length > FEW ? 'region' : nothing}
      aria-label=${players.length > FEW ? 'Current values' : nothing}>
    <table class="data now"><caption>Now</caption><thead><tr><td></td>${players.map(
      (_, i) => html`<th
      scope="col">${letter(i)}</th>`,
    )}<td></td></tr></thead>
      <tbody>${rows().map(
        (row) => html`<tr><th scope="row" title=${row.help ?? nothing}>${row.name}</th>${players.map(
          (_, i) => html`<td
          data-now=${`${row.name}/${i}`}>–</td>`,
        )}
        <td class="unit">${row.unit}</td></tr>`,
      )}</tbody></table></div>
  </aside>`;
}

/** @typedef {import('../views/chart.js').Chart} Chart */
/** @type {typeof import('../views/chart.js').Chart | null} */
let ChartOf = null;
/** @type {{error: Chart, buffer: Chart} | null} */
let charts = null;
let shown = 0;
const NOW_MS = 200;

/** Curves are plotted from now on: the library loads after the first frame. @param {typeof import('../views/chart.js').Chart} made */
export function plotBy(made) {
  ChartOf = made;
}

/** @param {Frame} frame @param {boolean} settled no frame follows soon: draw all of it */
export function showSide(frame, settled) {
  const error = document.getElementById('error-chart'),
    buffer = document.getElementById('buffer-chart');
  if (!error || !buffer) return;
  const players = frame.views.length - 1;
  if (ChartOf !== null) {
    if (charts?.error.box !== error)
      charts = {
        /* after a return to the page its boxes are new */
        error: new ChartOf(error, [-1, 1], () => errorCurves(layout.value?.players.length ?? 0, unit.value, scale.pxPerMetre)),
        buffer: new ChartOf(buffer, [0, 100], () => bufferCurves(layout.value?.players.length ?? 0)),
      };
    if (memory.curves.length === players) {
      charts.error.draw(memory, settled);
      charts.buffer.draw(memory, settled);
    }
  }
  const time = performance.now();
  if (!settled && time - shown < NOW_MS) return;
  shown = time;
  showMeets(frame);
  const lately = Array.from({ length: players }, (_, p) => memory.lately(p));
  for (const row of rows()) {
    for (let p = 0; p < players; p++) {
      const cell = document.querySelector(`[data-now="${row.name}/${p}"]`);
      const view = frame.views[1 + p];
      if (cell && view) cell.textContent = row.of(view, p, lately[p] ?? NOTHING);
    }
  }
}
