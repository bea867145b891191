// The experiment as one sentence: in a scenario vary one thing, compare another, and measure. Each part opens its list; the rest of it
// stands in the settings.
import { html, nothing } from '../../../vendor/lit-html.js';
import { signal } from '../../../vendor/signals-core.js';
import { Problem } from '../../base/api.js';
import { localized, plain } from '../../base/format.js';
import { language, rich, t, unitName } from '../../base/words.js';
import { labs } from '../../session/labs.js';
import { fullTitleOf } from '../../session/scenario_words.js';
import { scenarios } from '../../session/state.js';
import {
  USUAL_METRICS,
  axisAround,
  checking,
  choose,
  draft,
  draftOf,
  estimate,
  listed,
  metricAt,
  metrics,
  refuse,
  refused,
  scenario,
  specification,
  unread,
  variable,
  variables,
  write,
} from './form/draft.js';
import { isOpen, openDrawer } from './form/drawers.js';
import { elsewhere, invalid, valueOf } from './form/fields.js';
import { toggleMetric } from './form/kept.js';
import { chosenName, inputName, metricName, placeOf, wholeName } from './form/names.js';
import { isOver } from './progress.js';
import { record, run } from './shown.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('./form/draft.js').Axis} Axis */
/** @typedef {import('./form/draft.js').Variable} Variable */

const beginning = signal(false);

// ---- which axis is which part ----

const isNumber = (/** @type {Variable | undefined} */ one) => one?.row.type === 'number' || one?.row.type === 'integer';
/** A choice, or a yes or no. */
const isChoice = (/** @type {Variable | undefined} */ one) => one?.row.type === 'boolean' || one?.row.type === 'choice';

/** Places of the axis across and of what is compared; -1: none. */
function parts() {
  const { axes } = draft.value,
    heads = axes.map((_, i) => i).filter((i) => i === 0 || !axes[i]?.joined);
  const across = heads.find((i) => isNumber(variable(axes[i]?.path ?? ''))) ?? heads[0] ?? -1;
  return { across, compared: heads.find((i) => i !== across) ?? -1 };
}

/** Puts another in the place of an axis and of those that go together with it. @param {number} at its place; -1: at the end
 * @param {string} path empty: none */
function put(at, path) {
  const { axes } = draft.value,
    next = at < 0 ? axes.length : at + 1,
    more = axes.slice(next).findIndex((axis) => !axis.joined),
    end = more < 0 ? axes.length : next + more;
  write({ axes: [...axes.slice(0, at < 0 ? axes.length : at), ...(path === '' ? [] : [axisAround(path)]), ...axes.slice(end)] });
}

/** What an axis is, in short words. @param {string} path */
const named = (path) => t(`experiments.input.${path}`) || wholeName(path, '', scenario.value);

/** With its values. @param {Axis | undefined} axis @returns {string} */
function axisSaid(axis) {
  if (!axis) return t('experiments.nothing');
  const found = variable(axis.path),
    values = listed(axis.values);
  if (isChoice(found)) {
    const names = values.slice(0, 3).map((value) => chosenName(axis.path, value, scenario.value) ?? value);
    return t('experiments.said.choices', {
      name: inputName(axis.path, '', scenario.value),
      values: names.join(' / ') + (values.length > 3 ? ' …' : ''),
    });
  }
  const unit = found?.row.unit ?? '',
    ends = axis.list ? [values[0] ?? '', values[values.length - 1] ?? ''] : [axis.from, axis.to];
  const [from, to] = ends.map((text) => localized(Number.isFinite(Number(text)) ? plain(Number(text)) : text));
  return t('experiments.said.range', { name: named(axis.path), from, to, unit: unit === '' ? '' : unitName(unit) });
}

// ---- the lists ----

/** @returns {Template} */
function scenarioList() {
  const d = draft.value,
    now = typeof d.scenario === 'string' ? d.scenario : '',
    bad = invalid('scenario');
  const group = (/** @type {string} */ label, /** @type {string} */ kind) => {
    const rows = scenarios.value.filter((row) => row.kind === kind);
    return rows.length === 0
      ? nothing
      : html`<optgroup label=${label}>${rows.map(
          (row) => html`<option value=${row.id} .selected=${row.id === now}>${fullTitleOf(row)}</option>`,
        )}</optgroup>`;
  };
  return html`<select id="of" class="clause" aria-label=${t('experiments.scenario')} aria-invalid=${bad.is} aria-describedby=${bad.by}
      @change=${(/** @type {Event} */ event) => choose(valueOf(event))}>
      ${now === '' ? html`<option value="" selected disabled>${scenario.value?.title || t('experiments.as_it_has')}</option>` : nothing}
      ${labs.value.map((lab) => group(t(lab.group), lab.kind))}</select>`;
}

/** @param {'across' | 'compared'} part @returns {Template} */
function axisList(part) {
  const places = parts(),
    at = places[part],
    now = draft.value.axes[at],
    other = draft.value.axes[places[part === 'across' ? 'compared' : 'across']]?.path;
  /** @type {Map<string, Variable[]>} */
  const groups = new Map();
  for (const one of variables.value) {
    if (one.path === other || one.path === now?.path || !(part === 'across' ? isNumber(one) : isChoice(one))) continue;
    const owner = placeOf(one.path, scenario.value);
    groups.set(owner, [...(groups.get(owner) ?? []), one]);
  }
  const change = (/** @type {Event} */ event) => {
    const value = valueOf(event);
    if (value === 'values') openDrawer('settings', `[data-axis-place="${Math.max(0, at)}"]`);
    else put(at, value);
    /** @type {HTMLSelectElement} */ (event.target).value = 'now';
  };
  return html`<select id=${part} class="clause" aria-label=${t(`experiments.part_of.${part}`)} @change=${change}>
      <option value="now" .selected=${true}>${axisSaid(now)}</option>
      <option value="values">${t('experiments.other_values')}</option>
      ${now && part === 'compared' ? html`<option value="">${t('experiments.nothing')}</option>` : nothing}
      ${[...groups].map(
        ([owner, list]) =>
          html`<optgroup label=${owner}>${list.map(
            ({ path, row }) => html`<option value=${path}>${inputName(path, row.unit, scenario.value)}</option>`,
          )}</optgroup>`,
      )}</select>`;
}

/** @param {string} path */
const metricNamed = (path) => metricName(path, metricAt(scenario.value?.kind, path)?.unit, scenario.value);

/** Opens within the page. @param {Event} event */
function fitIn(event) {
  const list = /** @type {HTMLDetailsElement} */ (event.currentTarget),
    picks = list.querySelector('.picks');
  if (!(picks instanceof HTMLElement)) return;
  const room = document.documentElement.clientWidth - 12 - list.getBoundingClientRect().left - picks.offsetWidth;
  picks.style.left = `${Math.min(0, room)}px`;
}

/** @param {KeyboardEvent} event */
function closeOnEscape(event) {
  const list = /** @type {HTMLDetailsElement} */ (event.currentTarget);
  if (event.key !== 'Escape' || !list.open) return;
  event.stopPropagation();
  list.open = false;
  list.querySelector('summary')?.focus();
}

/** @param {FocusEvent} event */
function closeWhenLeft(event) {
  const list = /** @type {HTMLDetailsElement} */ (event.currentTarget);
  if (event.relatedTarget instanceof Node && !list.contains(event.relatedTarget)) list.open = false;
}

/** @returns {Template} */
function metricList() {
  const { metrics: chosen } = draft.value,
    offered = [...new Set([...chosen, ...USUAL_METRICS.filter((path) => metrics.value.includes(path))])];
  return html`<details class="pick" @toggle=${fitIn} @keydown=${closeOnEscape} @focusout=${closeWhenLeft}><summary class="clause"
      id="measured">${t('experiments.said.numbers', { n: chosen.length })}</summary>
    <div class="picks">${offered.map(
      (path) => html`<label class="toggle"><input type="checkbox" data-pick=${path} .checked=${chosen.includes(path)}
        @change=${() => toggleMetric(path)}><span title=${path}>${t(`experiments.metric.${path}`) || metricNamed(path)}</span></label>`,
    )}${chooseButton('pick-more')}</div></details>`;
}

/** @param {string} id @returns {Template} */
export const chooseButton = (id) => html`<button type="button" id=${id}
  @click=${() => openDrawer('settings', '#find-metric')}>${t('experiments.choose_from', { n: metrics.value.length })}</button>`;

// ---- the run ----

/** Whether what is written differs from what is shown. */
export function isChanged() {
  const of = record.value?.experiment;
  return of !== undefined && JSON.stringify(specification(draftOf(of))) !== JSON.stringify(specification(draft.value));
}

/** Runs what is written. */
export async function order() {
  if (beginning.value) return;
  beginning.value = true;
  try {
    const d = draft.value;
    await run(specification(d), d.title || scenario.value?.title || t('experiments.experiment'), !isChanged());
  } catch (error) {
    refuse(error);
    if (!(error instanceof Problem)) throw error;
  } finally {
    beginning.value = false;
  }
}

/** @param {number} seconds */
function duration(seconds) {
  if (seconds < 1) return t('experiments.less_than_second');
  if (seconds < 120) return t('experiments.about', { value: `${Math.round(seconds)} s` });
  const value = seconds < 7200 ? `${Math.round(seconds / 60)} min` : `${localized(plain(Number((seconds / 3600).toPrecision(3))))} h`;
  return t('experiments.about', { value });
}

/** @returns {unknown} */
function estimated() {
  const e = estimate.value;
  const many = (/** @type {string} */ key, /** @type {number} */ n) => t(key, { n, count: n.toLocaleString(language.value) });
  if (!e) return t(!checking.value && refused.value.size > 0 ? 'experiments.incomplete' : 'experiments.counting');
  return rich('experiments.estimate', {
    runs: html`<b>${many('experiments.runs', e.runs)}</b>`,
    points: many('experiments.of_points', e.points),
    time: duration(e.estimated_cpu_s),
  });
}

/** @returns {Template} */
export function sentenceForm() {
  const running = record.value !== null && record.value.id !== '' && !isOver(record.value.state),
    again = record.value !== null && !isChanged();
  const problems = isOpen('settings') ? elsewhere() : [...refused.value.values()];
  return html`<form class="asked" aria-label=${t('experiments.form')} @submit=${(/** @type {Event} */ event) => event.preventDefault()}>
    <p class="clauses">${rich('experiments.sentence', {
      scenario: scenarioList(),
      across: axisList('across'),
      compared: axisList('compared'),
      numbers: metricList(),
    })}</p>
    <div class="order"><button type="button" id="run" class="primary" ?disabled=${beginning.value || estimate.value === null || running}
      @click=${order}><svg class="sign" viewBox="0 0 12 12" aria-hidden="true"><path
        d="M2 1l9 5-9 5z"></path></svg>${t(again ? 'experiments.run_again' : 'experiments.run')}</button><small
      id="estimate">${estimated()}</small></div>
    ${unread.value === '' ? nothing : html`<p class="wrong">${unread.value}</p>`}
    ${problems.map((detail) => html`<p class="wrong">${detail}</p>`)}</form>`;
}
