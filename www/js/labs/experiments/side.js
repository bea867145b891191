// Next to the results: their files, the experiments that this browser keeps, and the same by program.
import { html, nothing } from '../../../vendor/lit-html.js';
import { address } from '../../base/api.js';
import { t } from '../../base/words.js';
import { experiment, notify } from '../../session/state.js';
import { tradeoffButton } from '../../workbench/work_precision.js';
import { draft, specification, start } from './draft.js';
import { stateOf } from './names.js';
import { kept, look, record, remove } from './shown.js';
import { many } from './table.js';

/** @typedef {import('lit-html').TemplateResult} Template */

const FORMATS = /** @type {[string, string][]} */ ([
  ['csv', 'CSV'],
  ['ndjson', 'NDJSON'],
  ['json', 'JSON'],
  ['sqlite', 'SQLite'],
]);

/** @param {any} r @returns {Template} */
function files(r) {
  const links = (/** @type {string} */ more, /** @type {string} */ name) => html`<p
      class="links">${FORMATS.map(
        ([format, label]) => html`<a href=${address(`experiments/${r.id}/results?format=${format}${more}`).href}
    download=${`${name}.${format}`}>${label}</a>`,
      )}</p>`;
  return html`<section class="about files" aria-label=${t('experiments.results')}><h2>${t('experiments.results')}</h2>
    <p class="links"><a id="report" href=${address(`experiments/${r.id}/report`).href} target="_blank"
      rel="noopener">${t('experiments.report')}</a></p>
    <h3>${t('experiments.row_per_run')}</h3>${links('', 'runs')}
    <h3>${t('experiments.row_per_point')}</h3>${links('&points=true', 'points')}</section>`;
}

/** As a shell takes it. @param {string} text */
const quoted = (text) => `'${text.replaceAll("'", "'\\''")}'`;

/** The same by program. @param {any} r the experiment shown, if any @returns {string} */
function curl(r) {
  const at = address('experiments').href,
    body = r ? r.experiment : specification(draft.value);
  /** @type {any} */
  const brief = { ...body };
  if (brief.scenario_id) {
    /* the library has it */
    brief.scenario = brief.scenario_id;
    delete brief.scenario_id;
  }
  const id = r ? r.id : 'ID';
  return [
    `curl -d ${quoted(JSON.stringify(brief))} -H 'Content-Type: application/json' ${at}`,
    `curl ${at}/${id}`,
    `curl '${at}/${id}/results?format=csv'`,
  ].join('\n');
}

/** Also where the page is no secure context, which has no clipboard. @param {Event} event */
async function copy(event) {
  const area = /** @type {HTMLElement} */ (event.currentTarget).parentElement?.parentElement?.querySelector('textarea');
  if (!area) return;
  area.select();
  const done = navigator.clipboard
    ? await navigator.clipboard.writeText(area.value).then(
        () => true,
        () => false,
      )
    : document.execCommand('copy');
  notify(t(done ? 'experiments.copied' : 'experiments.not_copied'));
}

/** An experiment that this browser keeps. @param {(typeof kept.value)[number]} one @returns {Template} */
function keptRow({ id, title, state, done, runs }) {
  const facts = `${stateOf(state)} · ${t('experiments.of', { n: many(done), all: many(runs) })}`;
  return html`<li aria-current=${id === experiment.value ? 'true' : 'false'}>
      <button type="button" class="quiet" data-id=${id} @click=${() => look(id)}><span>${title}</span><small>${facts}</small></button>
      <button type="button" class="small" aria-label=${t('experiments.delete_one', { name: title })}
        @click=${() => remove(id)}>${t('experiments.delete')}</button></li>`;
}

const newButton = () => html`<button type="button" class="small" id="new" @click=${() => look('')}>${t('experiments.mine.none')}</button>`;

/** @returns {Template} */
function list() {
  return html`<section class="about" aria-label=${t('experiments.mine')}><div class="head"><h2>${t('experiments.mine')}</h2>
      ${experiment.value ? newButton() : nothing}</div>
    ${
      kept.value.length === 0 ? html`<p>${t('experiments.mine.empty')}</p>` : html`<ul class="mine">${kept.value.map(keptRow)}</ul>`
    }</section>`;
}

/** @param {any} r the experiment shown, if any @returns {Template} */
const byProgram = (r) => html`<section class="about" aria-label=${t('experiments.api')}><div class="head"><h2>${t('experiments.api')}</h2>
        <button type="button" class="small" id="copy" @click=${copy}>${t('experiments.copy')}</button></div>
        <textarea readonly rows="7" aria-label=${t('experiments.curl')} .value=${curl(r)}></textarea></section>`;

/** @returns {Template} */
export function side() {
  const r = record.value;
  const again = () => html`<button type="button" id="again" @click=${() => start(r.experiment)}>${t('experiments.again')}</button>`;
  return html`<aside class="side" aria-label=${t('experiments.side')}>${r ? html`${files(r)}${again()}` : nothing}${list()}
      ${tradeoffButton('')}
      ${byProgram(r)}</aside>`;
}
