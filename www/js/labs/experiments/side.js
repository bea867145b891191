// Next to the charts: what one sees in them, the marked runs live, other finished experiments and one's own.
import { html, nothing, svg } from '../../../vendor/lit-html.js';
import { rich, t } from '../../base/words.js';
import { experiment } from '../../session/state.js';
import { tradeoffButton } from '../../workbench/work_precision.js';
import { findingOf, plainly, seriesIn } from './finding.js';
import { stateOf } from './form/names.js';
import { asked, atMark, inputValue, lined, lineSaid, marked, measured, valueSaid } from './plotted.js';
import { finished, kept, live, look, record, remove } from './shown.js';
import { many } from './table.js';

/** @typedef {import('lit-html').TemplateResult} Template */

/** What the points show, if they show what the question is about. */
const finding = () => findingOf(asked.value?.id ?? '', measured.value, marked.value, inputValue(lined.value?.xPath ?? '', marked.value));

/** What the experiment is called: what it shows, where it shows it. @returns {string} */
export function headline() {
  const found = finding(),
    r = record.value;
  return found ? t(found.title) : r?.title || r?.experiment.scenario?.title || t('experiments.experiment');
}

const PLAIN = /^(whose|x0|x1|at)$/;
/** What is measured is in bold. @param {import('./finding.js').Said} said */
const said = ({ key, values }) =>
  html`<p>${rich(
    key,
    Object.fromEntries(Object.entries(values).map(([name, text]) => [name, PLAIN.test(name) ? text : html`<b>${text}</b>`])),
  )}</p>`;

/** @returns {Template | typeof nothing} */
function seen() {
  const of = lined.value;
  if (!of) return nothing;
  const sentences = finding()?.sentences ?? plainly(measured.value, lineSaid, (x) => inputValue(of.xPath, x));
  return html`<section class="fact" id="seen"><h2>${t('experiments.see')}</h2>${sentences.map(said)}</section>`;
}

/** The marked points as live sessions. @returns {Template | typeof nothing} */
function alive() {
  const of = lined.value,
    rows = atMark.value;
  if (!of || rows.length === 0) return nothing;
  return html`<section class="fact" id="alive"><h2 aria-live="polite">${t('experiments.at', { x: inputValue(of.xPath, marked.value) })}</h2>
    <div class="acts">${rows.map(
      (row) => html`<button type="button" data-live=${row.point} @click=${() => live(row)}><svg class="sign" viewBox="0 0 12 12"
        aria-hidden="true"><path d="M2 1l9 5-9 5z"></path></svg>${
          of.by === '' ? t('experiments.alive') : t('experiments.alive_with', { line: valueSaid(String(row[of.by])) })
        }</button>`,
    )}</div></section>`;
}

/** A finished one in small: its first metric. @param {import('./examples.js').Example} one */
function small({ experiment: of, points }) {
  const lines = seriesIn(points, of.axes[0].path, of.axes[1].path, of.metrics[0]),
    all = lines.flatMap(({ places }) => places),
    [left, right] = [Math.min(...all.map((p) => p.x)), Math.max(...all.map((p) => p.x))],
    most = Math.max(...all.map((p) => p.y));
  const path = (/** @type {import('./finding.js').Series} */ { places }) =>
    places
      .map(
        (p, i) => `${i === 0 ? 'M' : 'L'}${(3 + (42 * (p.x - left)) / (right - left)).toFixed(1)} ${(25 - (22 * p.y) / most).toFixed(1)}`,
      )
      .join('');
  return html`<svg class="sketched" viewBox="0 0 48 28" aria-hidden="true">${lines.map(
    (line, i) => svg`<path data-line=${i} d=${path(line)}></path>`,
  )}</svg>`;
}

/** @returns {Template} */
function others() {
  return html`<section class="fact" id="others"><h2>${t('experiments.start_other')}</h2><ul>${finished.value
    .filter(({ id }) => id !== record.value?.ships)
    .map(
      (one) =>
        html`<li><button type="button" class="quiet" data-ships=${one.id} @click=${() => look(one.id)}>${small(one)}<span>${t(
          `experiments.ships.${one.id}`,
        )}</span></button></li>`,
    )}</ul>
    ${tradeoffButton('')}</section>`;
}

/** An experiment that this browser keeps. @param {(typeof kept.value)[number]} one @returns {Template} */
function keptRow({ id, title, state, done, runs }) {
  const facts = `${stateOf(state)} · ${t('experiments.of', { n: many(done), all: many(runs) })}`;
  return html`<li aria-current=${id === experiment.value ? 'true' : 'false'}>
      <button type="button" class="quiet" data-id=${id} @click=${() => look(id)}><span>${title}</span><small>${facts}</small></button>
      <button type="button" class="small" aria-label=${t('experiments.delete_one', { name: title })}
        @click=${() => remove(id)}>${t('experiments.delete')}</button></li>`;
}

/** @returns {Template | typeof nothing} */
const mine = () =>
  kept.value.length === 0
    ? nothing
    : html`<section class="fact" aria-label=${t('experiments.mine')}><h2>${t('experiments.mine')}</h2>
        <ul class="mine">${kept.value.map(keptRow)}</ul></section>`;

/** @returns {Template} */
export const side = () => html`<aside class="column" aria-label=${t('experiments.side')}>${seen()}${alive()}${others()}${mine()}</aside>`;
