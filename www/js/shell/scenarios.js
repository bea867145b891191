// The scenarios: a button that says which one is shown, and a dialog with a search, groups and what each is about.
import { html, nothing } from '../../vendor/lit-html.js';
import { signal } from '../../vendor/signals-core.js';
import { constant, insist } from '../base/api.js';
import { language, t } from '../base/words.js';
import { labs } from '../session/labs.js';
import { fullTitleOf, textOf, titleOf } from '../session/scenario_words.js';
import { choose, shownScenario } from '../session/session.js';
import { scenarios } from '../session/state.js';
import { dialog, open } from '../workbench/dialog.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('../session/state.js').ScenarioRow} Row */

/** Their English texts are read when the list is wanted. */
let complete = false;
function readTexts() {
  if (complete) return;
  complete = true;
  insist(() => constant('scenarios')).then((answer) => {
    scenarios.value = answer.scenarios ?? scenarios.value;
  });
}

const sought = signal('');
/** Of the row that Enter chooses. */
const active = signal('');

/** @param {string} text */
const bare = (text) => text.normalize('NFD').replace(/\p{M}/gu, '').toLowerCase();

/** Whether it has all words that are sought. @param {Row} row */
function fits(row) {
  const text = bare([fullTitleOf(row), textOf(row), row.title, row.id].join(' '));
  return bare(sought.value)
    .split(/\s+/)
    .every((word) => text.includes(word));
}

/** By lab, and the paper's figures, in the order in which they are shown. @returns {{name: string, rows: Row[]}[]} */
function groups() {
  const rows = scenarios.value.filter(fits),
    isFigure = (/** @type {Row} */ row) => row.id.startsWith('paper/');
  return [
    ...labs.value.map(({ group, kind }) => ({ name: t(group), rows: rows.filter((row) => row.kind === kind && !isFigure(row)) })),
    { name: t('shell.figures'), rows: rows.filter(isFigure) },
  ].filter((group) => group.rows.length > 0);
}

/** @returns {Template} */
export function chooser() {
  const rows = scenarios.value,
    now = rows.find(({ id }) => id === shownScenario());
  const name = now ? fullTitleOf(now) : t(rows.length > 0 ? 'shell.not_library' : 'shell.loading');
  return html`<div class="field choice scenario"><span id="scenario-label">${t('shell.scenario')}</span><button type="button" id="scenario"
    aria-haspopup="dialog" aria-labelledby="scenario-label scenario-name" title=${name} @click=${() => {
      readTexts();
      sought.value = '';
      active.value = now?.id ?? '';
      open({ kind: 'scenarios' });
      requestAnimationFrame(() => document.querySelector('.options [aria-selected="true"]')?.scrollIntoView({ block: 'center' }));
    }}><span id="scenario-name">${name}</span></button></div>`;
}

/** @param {string} id */
function take(id) {
  dialog.value = null;
  choose(id);
}

const idOf = (/** @type {string} */ id) => `scenario-${id.replaceAll('/', '-')}`;

/** @param {KeyboardEvent} event */
function press(event) {
  const list = groups().flatMap(({ rows }) => rows),
    at = list.findIndex(({ id }) => id === active.value),
    way = event.key === 'ArrowDown' ? 1 : event.key === 'ArrowUp' ? -1 : event.key === 'PageDown' ? 8 : event.key === 'PageUp' ? -8 : 0;
  if (event.key === 'Enter' && at >= 0) {
    event.preventDefault();
    take(active.value);
  } else if (way !== 0 && list.length > 0) {
    event.preventDefault();
    active.value = list[at < 0 ? 0 : Math.max(0, Math.min(list.length - 1, at + way))]?.id ?? '';
    requestAnimationFrame(() => document.getElementById(idOf(active.value))?.scrollIntoView({ block: 'nearest' }));
  }
}

/** @param {Row} row @returns {Template} */
function option(row) {
  const text = textOf(row);
  return html`<div role="option" id=${idOf(row.id)} data-scenario=${row.id} aria-selected=${row.id === active.value}
    @click=${() => take(row.id)}><b>${row.paper ? html`<span lang="en">${row.paper}</span>: ` : nothing}${titleOf(row)}</b>${
      text === '' ? nothing : html`<small>${text}</small>`
    }</div>`;
}

/** The dialog. @returns {[string, Template]} title and content */
export function scenarioList() {
  const all = groups(),
    n = all.reduce((sum, { rows }) => sum + rows.length, 0);
  const search = (/** @type {Event} */ event) => {
    sought.value = /** @type {HTMLInputElement} */ (event.target).value;
    active.value = groups()[0]?.rows[0]?.id ?? '';
  };
  return [
    t('shell.scenario'),
    html`<div class="finder"><label><span>${t('shell.scenario.search')}</span><input type="search" autocomplete="off" autofocus
        role="combobox" aria-expanded="true" aria-controls="scenario-options" aria-autocomplete="list"
        aria-activedescendant=${n > 0 && active.value !== '' ? idOf(active.value) : nothing} .value=${sought.value}
        @input=${search} @keydown=${press}></label>
      <p class="faint" role="status">${t('shell.scenario.found', { n })}</p></div>
    <div class="options" id="scenario-options" role="listbox" aria-label=${t('shell.scenario')} lang=${language.value}>${all.map(
      ({ name, rows }, i) => html`<div role="group" aria-labelledby=${`scenario-group-${i}`}>
        <h3 id=${`scenario-group-${i}`} role="presentation">${name}</h3>${rows.map(option)}</div>`,
    )}</div>`,
  ];
}
