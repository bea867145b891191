// The same in tables, for those who read rather than point: who is the cheapest at three levels of error, every setting, a file.
import { html, nothing } from '../../../vendor/lit-html.js';
import { t } from '../../base/words.js';
import { costOf, csvOf, errorOf, measuredOf, methodOf, nameOf, numberOf } from './names.js';
import { liveLink } from './open.js';
import { job, shippedAnswer } from './results.js';
import { rows, shownCost, shownError } from './state.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('./results.js').Choice} Choice */
/** @typedef {import('./results.js').Family} Family */
/** @typedef {import('./results.js').Row} Row */

/** Whether it was so again. @param {Family} family @param {Row[]} list @param {Choice} choice @param {Row} row @returns {string} */
function again(family, list, { cost, level, check_cheapest: best }, { check }) {
  const other = best === null ? undefined : list[best];
  if (!check) return '';
  if (!((check.error[2] ?? Number.POSITIVE_INFINITY) <= level))
    return t('tradeoff.check.error', { error: numberOf(check.error[0]), most: numberOf(check.error[2]) });
  const own = numberOf(check.costs[cost]?.[0]);
  if (!other || other.check === check) return t('tradeoff.check.cheapest', { cost: own });
  return t('tradeoff.check.other', { name: nameOf(family, other), cost: numberOf(other.check?.costs[cost]?.[0]), mine: own });
}

/** A cell under the heading of its column: of text, or of a number. @param {string} column @param {unknown} content
 * @param {boolean} [text] */
const cell = (column, content, text = false) =>
  html`<td class=${text ? 'text' : nothing} data-label=${t(`tradeoff.column.${column}`)}>${content}</td>`;

/** The heading of a column. @param {string} column @param {boolean} [text] */
const heading = (column, text = false) => html`<th scope="col" class=${text ? 'text' : nothing}>${t(`tradeoff.column.${column}`)}</th>`;

/** @param {Family} family @param {Row[]} list @param {Choice} choice @returns {Template} */
function choiceRow(family, list, choice) {
  const row = choice.row === null ? undefined : list[choice.row];
  const level = html`<th scope="row" data-label=${t('tradeoff.column.level')}>${numberOf(choice.level)}</th>`;
  if (!row) return html`<tr data-outcome=${choice.outcome}>${level}<td colspan="5" class="text">${t('tradeoff.nothing')}</td></tr>`;
  const outcome = `tradeoff.outcome.${choice.outcome.replaceAll(' ', '_')}`;
  const tied = choice.as_cheap.map((method) => methodOf(family, method, row.by)).join(', ') || '–';
  return html`<tr data-outcome=${choice.outcome}>${level}${cell('cheapest', liveLink(row, nameOf(family, row)), true)}
    ${cell('error', measuredOf(row.error))}${cell('cost', measuredOf(row.costs[choice.cost]))}
    ${cell('check', html`<span><b>${t(outcome)}</b> ${again(family, list, choice, row)}</span>`, true)}
    ${cell('tied', tied, true)}</tr>`;
}

/** @param {Family} family @param {string} error @returns {Template} */
function winners(family, error) {
  const measured = job.value?.state === 'done' ? job.value.answer : null,
    of = measured ?? shippedAnswer.value,
    list = (of?.choices ?? []).filter((one) => one.problem === shownError.value && one.cost === shownCost.value);
  const label = `${t('tradeoff.winners')}: ${error}`;
  return html`<div class="wide-table" tabindex="0" role="region" aria-label=${label}><table
    class="data winners"><caption>${t('tradeoff.winners')}</caption>
    <thead><tr>${heading('level')}${heading('cheapest', true)}${heading('error')}
    ${heading('cost')}${heading('check', true)}${heading('tied', true)}</tr></thead>
    <tbody>${list.map((choice) => choiceRow(family, of?.rows ?? [], choice))}</tbody></table></div>`;
}

/** @param {Family} family @param {Row} row @returns {Template} */
function settingRow(family, row) {
  const error = row.status === 'ok' ? measuredOf(row.error) : t('workbench.diverged');
  return html`<tr><th scope="row">${liveLink(row, nameOf(family, row))}</th><td>${error}</td>
        <td>${measuredOf(row.costs[shownCost.value])}</td><td>${row.front[shownCost.value] ? t('tradeoff.yes') : ''}</td></tr>`;
}

/** @param {Family} family */
function download(family) {
  const blob = new Blob([csvOf(family, rows.value, `${location.origin}${location.pathname}`)], { type: 'text/csv;charset=utf-8' });
  const anchor = document.createElement('a');
  anchor.href = URL.createObjectURL(blob);
  anchor.download = `laglab-tradeoff-${family.name}.csv`;
  anchor.click();
  setTimeout(() => URL.revokeObjectURL(anchor.href), 10000);
}

/** @param {Family} family @returns {Template} */
export function tables(family) {
  const own = rows.value.filter((row) => row.problem === shownError.value),
    problem = family.problems[shownError.value],
    cost = family.costs[shownCost.value],
    error = problem ? errorOf(problem) : '',
    title = t('tradeoff.settings', { n: own.length });
  return html`<section class="listed" aria-label=${t('tradeoff.table_csv')}>
    <p><button type="button" id="csv" @click=${() => download(family)}>${t('tradeoff.csv')}</button> ${cost ? costOf(cost) : ''}</p>
    ${winners(family, error)}<h3>${title}</h3>
    <div class="scroll" tabindex="0" role="region" aria-label=${`${title}: ${error}`}><table class="data settings"><thead><tr>
      ${heading('setting', true)}${heading('error')}${heading('cost')}${heading('front')}</tr></thead>
      <tbody>${own.map((row) => settingRow(family, row))}</tbody></table></div><p class="facts">${t('tradeoff.explain')}</p></section>`;
}
