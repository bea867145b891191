// The side column: the scenario's text, the charts, and the current values.
import { html, nothing } from '../../../../vendor/lit-html.js';
import { signal } from '../../../../vendor/signals-core.js';
import { INTERPOLATION } from '../core/frame.js';
import { part } from '../../../base/api.js';
import { fixed, letter, signed } from '../../../base/format.js';
import { rich, t } from '../../../base/words.js';
import { panelTurn, textTurn } from '../../../draw/redraw.js';
import { LATELY_S } from '../core/memory.js';
import { lesson, locked } from '../../../session/state.js';
import { aboutScenario } from '../../../workbench/about.js';
import { said } from '../../../workbench/said.js';
import { open } from '../../../workbench/dialog.js';
import { layout } from '../core/layout.js';
import { connectionEvents, memory, scale, unit } from '../core/state.js';
import { countOf, sentences, tell } from '../views/sentences.js';
import { FEW, bufferCurves, errorCurves } from '../views/curves.js';
import { tradeoffButton, workPrecisionButton } from '../../../workbench/work_precision.js';

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
  return html`<span class="units" role="group" aria-label=${t('netgame.unit')}>${(/** @type {const} */ (['px', 'm', 'ms'])).map(
    (name) => html`<button
    type="button" aria-pressed=${unit.value === name} @click=${() => {
      unit.value = name;
    }}>${name}</button>`,
  )}</span>`;
}

/** @param {'error' | 'buffer'} which @returns {Template} */
function tableButton(which) {
  const id = `${which}-chart`;
  return html`<take-away of=${id} data=${id} name=${t(`netgame.chart.${which}`)}></take-away><button type="button" class="small"
    aria-label=${t(`netgame.chart.${which}.table`)} @click=${() => open({ kind: 'table', of: which })}>${t('netgame.table')}</button>`;
}

/** id: the end of the key of its words.
 * @typedef {{id: string, unit: string, of: (view: View, player: number, lately: import('../core/memory.js').Lately) => string}} Row */

const LISTED = 6; /* events of connections */

/** @returns {Row[]} */
function rows() {
  const way = unit.value === 'm' ? 'm' : 'px';
  const size = way === 'm' ? 1 : scale.pxPerMetre;
  const apart = (/** @type {number} */ metres) => signed(metres * size, way === 'm' ? 2 : 0);
  return [
    { id: 'latency', unit: 'ms', of: (_, __, lately) => fixed(lately.latency ?? NaN, 0) },
    { id: 'lost', unit: '%', of: (_, __, lately) => fixed(100 * (lately.lost ?? NaN), 0) },
    { id: 'error', unit: way, of: (_, __, lately) => fixed((lately.error ?? NaN) * size, way === 'm' ? 2 : 1) },
    { id: 'lead', unit: way, of: (view) => apart(view.own_lead_m) },
    { id: 'others', unit: way, of: (view) => apart(view.remote_error_m) },
    { id: 'age', unit: 'ms', of: (view) => fixed(view.view_age_ms, 0) },
    { id: 'buffer', unit: 'ms', of: (view) => (view.flags & INTERPOLATION ? fixed(view.buffer_ms, 0) : t('netgame.off')) },
    { id: 'unacked', unit: '', of: (view) => String(view.unacked) },
    { id: 'corrections', unit: '', of: (view) => String(view.corrections) },
    { id: 'refused', unit: '', of: (view) => String(view.refused) },
    { id: 'slack', unit: t('netgame.ticks'), of: (view) => signed(view.slack_ticks, 1) },
  ];
}

const NOTHING = { error: null, latency: null, lost: null };

/** @param {import('../core/memory.js').Happening} one */
export const happened = (one) => t(`netgame.happened.${one.what}`, { name: letter(one.player) });

/** Events of connections; hidden while all clients are playing. @returns {Template | typeof nothing} */
function connectionList() {
  const list = connectionEvents.value.slice(-LISTED);
  if (list.length === 0) return nothing;
  return html`<section class="happened" aria-label=${t('netgame.connections')}><h3>${t('netgame.connections')}</h3><ol>${list.map(
    (one) => html`<li><span>${one.late ? '≤ ' : ''}${fixed(one.t, 1)} s</span>
    ${rich(`netgame.happened.${one.what}`, { name: html`<b>${letter(one.player)}</b>` })}</li>`,
  )}</ol></section>`;
}

/** What stands below the scenario's text, once it is read.
 * @type {import('@preact/signals-core').Signal<(() => Template | typeof nothing) | null>} */
const notes = signal(null);

/** @param {() => Template | typeof nothing} made */
export function noteBy(made) {
  notes.value = made;
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
    @click=${compare}>${t('netgame.compare')}</button>`
    : nothing;

/** What each player meets, in words. @returns {Template | typeof nothing} */
function meets() {
  const players = layout.value?.players.length ?? 0;
  if (players === 0 || players > FEW) return nothing;
  return html`<section class="meets" aria-label=${t('netgame.in_words')}><dl>${Array.from({ length: players }, (_, p) =>
    Array.from(
      { length: countOf(players) },
      (_, i) => html`<div data-player=${p}><dt data-term=${`${p}/${i}`}>–</dt><dd data-sentence=${`${p}/${i}`}>–</dd></div>`,
    ),
  )}</dl></section>`;
}

/** @param {Frame} frame */
function showMeets(frame) {
  const views = frame.views.slice(1);
  for (const place of document.querySelectorAll('[data-sentence]')) {
    const [p = 0, i = 0] = (place.getAttribute('data-sentence') ?? '').split('/').map(Number);
    const view = views[p],
      one = view && sentences({ view, player: p, views }, memory)[i];
    if (!one) continue;
    tell(place, one);
    const term = document.querySelector(`[data-term="${p}/${i}"]`);
    if (term && term.textContent !== one.term) term.textContent = one.term;
  }
}

/** What holds now, a column per player. @param {number} n @returns {Template} */
function nowTable(n) {
  const players = Array.from({ length: n }, (_, i) => i);
  const nowRow = (/** @type {{id: string, unit: string}} */ { id, unit }) =>
    html`<tr><th scope="row" title=${t(`netgame.now.${id}.tip`, { s: LATELY_S })}>${t(`netgame.now.${id}`)}</th>${players.map(
      (i) => html`<td data-now=${`${id}/${i}`}>–</td>`,
    )}
        <td class="unit">${unit}</td></tr>`;
  return html`<div class="wide-table" tabindex="0" role="region" aria-label=${t('workbench.current')}>
    <table class="data now"><caption>${t('workbench.now')}</caption><thead><tr><td></td>${players.map(
      (i) => html`<th scope="col">${letter(i)}</th>`,
    )}<td></td></tr></thead>
      <tbody>${rows().map(nowRow)}</tbody></table></div>`;
}

/** @returns {Template} */
export function side() {
  const players = layout.value?.players ?? [];
  return html`<aside class="side" aria-label=${t('netgame.side')}>
    <div class="about">${aboutScenario()}
      ${(layout.value?.notices ?? []).map(
        (text) => html`<p role="note"><strong>${t('netgame.nothing_measured')}</strong> ${said(text)}</p>`,
      )}
      ${notes.value?.() ?? nothing}</div>
    ${connectionList()}
    ${meets()}
    ${compareButton()}${workPrecisionButton()}${tradeoffButton(layout.value?.family ?? '')}
    <section class="chart"><div class="head"><h3>${t('netgame.chart.drawn')}</h3>${units()}</div>
      <div class="plot" id="error-chart" role="img"
        aria-label=${t('netgame.chart.error.says')}></div>
      <div class="key">${players.map((_, i) => sample(i, false, letter(i)))}<span>${t('netgame.chart.own')}</span>
        ${players.length <= FEW ? sample(7, true, t('netgame.chart.others')) : nothing}${tableButton('error')}</div></section>
    <section class="chart"><div class="head"><h3>${t('netgame.chart.buffer_ms')}</h3></div>
      <div class="plot" id="buffer-chart" role="img" aria-label=${t('netgame.chart.buffer.says')}></div>
      <div class="key">${players.map((_, i) => sample(i, false, letter(i)))}${tableButton('buffer')}</div></section>
    ${nowTable(players.length)}
  </aside>`;
}

/** @typedef {import('../views/chart.js').Chart} Chart */
/** @type {typeof import('../views/chart.js').Chart | null} */
let ChartOf = null;
/** @type {{error: Chart, buffer: Chart} | null} */
let charts = null;
const numbers = textTurn(200),
  curves = { error: panelTurn(190, 500), buffer: panelTurn(190, 500) };

/** Curves are plotted from now on: the library loads after the first frame. @param {typeof import('../views/chart.js').Chart} made */
export function plotBy(made) {
  ChartOf = made;
}

/** The lab is left. */
export function end() {
  charts?.error.end();
  charts?.buffer.end();
  charts = null;
}

/** @param {Frame} frame @param {boolean} settled no frame follows soon: draw all of it */
export function showSide(frame, settled) {
  const error = document.getElementById('error-chart'),
    buffer = document.getElementById('buffer-chart');
  if (!error || !buffer) return;
  const players = frame.views.length - 1;
  if (ChartOf !== null) {
    if (charts?.error.box !== error) {
      end(); /* its boxes are new */
      charts = {
        error: new ChartOf(error, [-1, 1], () => errorCurves(layout.value?.players.length ?? 0, unit.value, scale.pxPerMetre)),
        buffer: new ChartOf(buffer, [0, 100], () => bufferCurves(layout.value?.players.length ?? 0)),
      };
    }
    const { error: errors, buffer: buffers } = charts;
    if (memory.curves.length === players) {
      curves.error(settled, () => errors.draw(memory));
      curves.buffer(settled, () => buffers.draw(memory));
    }
  }
  if (!numbers(settled)) return;
  showMeets(frame);
  const lately = Array.from({ length: players }, (_, p) => memory.lately(p));
  const known = new Map(rows().map((row) => [row.id, row]));
  for (const cell of document.querySelectorAll('td[data-now]')) {
    const [id = '', p = 0] = (cell.getAttribute('data-now') ?? '').split('/'),
      view = frame.views[1 + Number(p)];
    const text = view && known.get(id)?.of(view, Number(p), lately[Number(p)] ?? NOTHING);
    if (text !== undefined && cell.textContent !== text) cell.textContent = text;
  }
}
