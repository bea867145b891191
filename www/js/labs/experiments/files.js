// The results as files, and the same by program.
import { html } from '../../../vendor/lit-html.js';
import { address } from '../../base/api.js';
import { t } from '../../base/words.js';
import { notify } from '../../session/state.js';
import { draft, specification } from './form/draft.js';
import { record } from './shown.js';

/** @typedef {import('lit-html').TemplateResult} Template */

const FORMATS = /** @type {[string, string][]} */ ([
  ['csv', 'CSV'],
  ['ndjson', 'NDJSON'],
  ['json', 'JSON'],
  ['sqlite', 'SQLite'],
]);

/** @returns {Template} */
export function files() {
  const r = record.value;
  if (!r?.id) return html`<p class="facts">${t('experiments.files_after')}</p>`;
  const links = (/** @type {string} */ more, /** @type {string} */ name) => html`<p
      class="links">${FORMATS.map(
        ([format, label]) => html`<a href=${address(`experiments/${r.id}/results?format=${format}${more}`).href}
    download=${`${name}.${format}`}>${label}</a>`,
      )}</p>`;
  return html`<div class="files"><p class="links"><a id="report" href=${address(`experiments/${r.id}/report`).href} target="_blank"
      rel="noopener">${t('experiments.report')}</a></p>
    <h3>${t('experiments.row_per_run')}</h3>${links('', 'runs')}
    <h3>${t('experiments.row_per_point')}</h3>${links('&points=true', 'points')}</div>`;
}

/** As a shell takes it. @param {string} text */
const quoted = (text) => `'${text.replaceAll("'", "'\\''")}'`;

/** What is written, by program. @returns {string} */
function curl() {
  const at = address('experiments').href,
    id = record.value?.id || 'ID';
  return [
    `curl -d ${quoted(JSON.stringify(specification(draft.value)))} -H 'Content-Type: application/json' ${at}`,
    `curl ${at}/${id}`,
    `curl '${at}/${id}/results?format=csv'`,
  ].join('\n');
}

/** Also where the page is no secure context, which has no clipboard. */
async function copy() {
  const area = document.querySelector('textarea');
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

/** @returns {Template} */
export const request = () => html`<button type="button" class="small" id="copy" @click=${copy}>${t('experiments.copy')}</button>
  <textarea readonly rows="7" aria-label=${t('experiments.curl')} .value=${curl()}></textarea>`;
