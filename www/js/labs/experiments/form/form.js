// The form of an experiment: scenario, axes, fixed values, replicates, metrics; errors appear at the field that the daemon names.
import { html, nothing } from '../../../../vendor/lit-html.js';
import { signal } from '../../../../vendor/signals-core.js';
import { call } from '../../../base/api.js';
import { t } from '../../../base/words.js';
import { axesPanel } from './axes.js';
import { draft, helpOf, metricAt, measure, metrics, own, scenario, start, variable, variables, write } from './draft.js';
import { helpOf as ruleHelp, valueOf, sentence, number, rangeOf, invalid, parameter } from './fields.js';
import { toggleMetric } from './kept.js';
import { metricName, metricTip, wholeName } from './names.js';
import { windowsPanel } from './windows.js';

/** @typedef {import('lit-html').TemplateResult} Template */

/** Experiments of the library. @type {import('@preact/signals-core').Signal<{id: string, title: string, text: string}[]>} */
export const library = signal([]);
const sought = signal('');

// ---- names ----

/** @param {string} path of a metric; empty: none */
const named = (path) =>
  path === '' ? t('experiments.none') : metricName(path, metricAt(scenario.value?.kind, path)?.unit, scenario.value);
/** @param {string} path */
const tipOf = (path) => metricTip(path, helpOf(path), scenario.value);
/** @param {string} path of a parameter */
const inputOf = (path) => wholeName(path, variable(path)?.row.unit, scenario.value);

/** The beginning of a panel: its name, and what stands next to it. @param {string} name @param {unknown} [more] */
const head = (name, more = nothing) => html`<legend class="unseen">${name}</legend><div class="head"><h2>${name}</h2>${more}</div>`;

// ---- the scenario ----

/** @returns {Template} */
function libraryChoice() {
  const begin = async (/** @type {Event} */ event) => {
    const id = valueOf(event);
    if (id !== '') start(await call('GET', `scenarios/${id}`));
  };
  return html`<label class="field choice"><span>${t('experiments.start_from')}</span><select id="library"
    @change=${begin}><option value="">${t('experiments.of_library')}</option>${library.value.map(
      (one) => html`<option
      value=${one.id}>${one.title}</option>`,
    )}</select></label>`;
}

/** @returns {Template} */
function scenarioPanel() {
  const d = draft.value;
  return html`<fieldset class="panel server">${head(t('experiments.scenario'))}
    ${libraryChoice()}
    <button type="button" id="trade"
      title=${t('experiments.diagram_tip')}
      ?disabled=${scenario.value === null}
        @click=${() =>
          measure(typeof d.scenario === 'string' && d.scenario !== '' ? d.scenario : scenario.value)}>${t('workbench.diagram')}</button>
    ${d.title === '' ? nothing : html`<p class="facts">${d.title}</p>`}</fieldset>`;
}

// ---- fixed values, replicates ----

const LIMIT = '100'; /* repeats: one run alone has no mean */

function toggleUntil() {
  const d = draft.value,
    on = !d.until.on;
  write({ until: { ...d.until, on }, repeats: on && Number(d.repeats) < Number(d.until.least) ? LIMIT : d.repeats });
}

/** The metric whose mean is to be known. @param {(path: string) => void} take @returns {Template} */
function untilMetric(take) {
  const { metrics: paths, error, until } = draft.value,
    bad = invalid('until.metric', 'until');
  const usual = t('experiments.until.error', { metric: named(error || (paths[0] ?? '')) });
  return html`<label class="field choice"><span>${t('experiments.until.mean')}</span><select id="until-metric"
      aria-invalid=${bad.is} aria-describedby=${bad.by}
      @change=${(/** @type {Event} */ event) => take(valueOf(event))}><option
        value="">${usual}</option>
      ${paths.map((path) => html`<option value=${path} .selected=${path === until.metric}>${named(path)}</option>`)}</select></label>`;
}

/** Runs of a point until its mean is known. @returns {Template} */
function untilPanel() {
  const d = draft.value,
    { until } = d,
    set = (/** @type {Partial<import('./draft.js').Until>} */ change) => write({ until: { ...until, ...change } }),
    ranges = { relative: rangeOf('until.relative'), least: rangeOf('until.least') };
  const toggle = html`<label class="toggle" title=${ruleHelp('until')}><input type="checkbox" id="until" .checked=${until.on}
    @change=${toggleUntil}><span>${t('experiments.until')}</span></label>`;
  if (!until.on) return html`${toggle}${sentence('until')}`;
  return html`${toggle}<div class="until" role="group" aria-label=${t('experiments.until.when')}>
    ${untilMetric((metric) => set({ metric }))}
    ${number({
      id: 'until-relative',
      field: 'until.relative',
      messageOf: 'until',
      label: t('experiments.until.relative'),
      value: until.relative,
      hint: t('experiments.until.no_rule'),
      take: (relative) => set({ relative }),
    })}
    ${number({
      id: 'until-half',
      field: 'until.half_width',
      messageOf: 'until',
      label: t('experiments.until.half'),
      value: until.half,
      hint: t('experiments.until.no_rule'),
      take: (half) => set({ half }),
    })}
    ${number({
      id: 'until-least',
      field: 'until.least',
      messageOf: 'until',
      label: t('experiments.until.least'),
      value: until.least,
      take: (least) => set({ least }),
    })}
    <p class="facts">${t('experiments.until.checked')}
      <small>${t('experiments.until.ranges', ranges)}</small></p></div>${sentence('until')}`;
}

/** A value with a path that is not fixed yet. */
function addFixed() {
  const { fixed } = draft.value;
  const paths = ['duration_s', ...variables.value.map((one) => one.path)];
  const path = paths.find((one) => variable(one) && !fixed.some((other) => other.path === one)) ?? '';
  write({ fixed: [...fixed, { path, value: String(own(path) ?? '') }] });
}

/** @param {import('./draft.js').Fixed} one @param {number} i its place @returns {Template} */
function fixedRow(one, i) {
  const { fixed } = draft.value,
    bad = invalid(`set.${one.path}`),
    name = inputOf(one.path);
  const set = (/** @type {Partial<import('./draft.js').Fixed>} */ change) =>
    write({ fixed: fixed.map((other, k) => (k === i ? { ...other, ...change } : other)) });
  return html`<div class="fixed">${parameter(
    one.path,
    t('experiments.fixed.parameter', { n: i + 1 }),
    (path) => set({ path, value: String(own(path) ?? '') }),
    bad,
  )}
        <input class="narrow" autocomplete="off" aria-label=${t('experiments.fixed.value', { name })} aria-invalid=${bad.is}
          aria-describedby=${bad.by} .value=${one.value}
          @input=${(/** @type {Event} */ event) => set({ value: valueOf(event) })}>
        <button type="button" class="small" aria-label=${t('experiments.fixed.remove', { name })}
          @click=${() => write({ fixed: fixed.filter((_, k) => k !== i) })}>${t('experiments.remove')}</button></div>
      ${sentence(`set.${one.path}`)}`;
}

/** @returns {Template} */
function fixedPanel() {
  const d = draft.value,
    bad = invalid('repeats');
  const add = html`
      <button type="button" class="small" @click=${addFixed}>${t('experiments.fixed.add')}</button>`;
  return html`<fieldset class="panel server">${head(t('experiments.fixed'), add)}
    ${d.fixed.map(fixedRow)}
    <label class="field"><span>${t(d.until.on ? 'experiments.repeats.most' : 'experiments.repeats')}</span><input id="repeats"
      class="narrow" inputmode="numeric" autocomplete="off" .value=${d.repeats} aria-invalid=${bad.is} aria-describedby=${bad.by}
      @input=${(/** @type {Event} */ event) => write({ repeats: valueOf(event) })}></label>
    ${sentence('repeats')}${untilPanel()}</fieldset>`;
}

// ---- metrics ----

const SHOWN_METRICS = 40;

/** The metrics of the front, in the order of the metrics. @param {string} path */
function toggleFront(path) {
  const d = draft.value,
    on = d.front.includes(path);
  write({ front: d.metrics.filter((one) => (one === path ? !on : d.front.includes(one))) });
}

/** @returns {Template} */
function frontPanel() {
  const d = draft.value;
  return html`<div class="frontof" role="group" aria-label=${t('experiments.front.of')}><p
    title=${t('experiments.front.tip')}>${t('experiments.front.of')} ${
      d.front.length === 0
        ? html`<small>${t('experiments.front.usual')}</small>`
        : html`<small>${t('experiments.front.count', { n: d.front.length })}</small>`
    }</p>
    ${d.metrics.map(
      (path) => html`<label class="toggle"><input type="checkbox" data-front=${path} .checked=${d.front.includes(path)}
      @change=${() => toggleFront(path)}><span title=${path}>${named(path)}</span></label>`,
    )}${sentence('front')}</div>`;
}

/** @returns {Template} */
function metricsPanel() {
  const d = draft.value,
    words = sought.value
      .toLowerCase()
      .split(/\s+/)
      .filter((word) => word !== '');
  const found = metrics.value.filter(
    (path) => !d.metrics.includes(path) && words.every((word) => `${path} ${named(path)} ${tipOf(path)}`.toLowerCase().includes(word)),
  );
  const item = (
    /** @type {string} */ path,
    /** @type {number} */ i,
  ) => html`<label class="toggle" title=${[tipOf(path), path].filter(Boolean).join(' · ')}><input type="checkbox"
    data-metric=${path} .checked=${d.metrics.includes(path)}
    aria-invalid=${invalid(`metrics.${i}`).is} @change=${() => toggleMetric(path)}><span>${named(path)}</span></label>`;
  const trade = (
    /** @type {'error' | 'cost'} */ side,
  ) => html`<label class="field choice"><span>${t(`experiments.side.${side}`)}</span><select id=${side}
      @change=${(/** @type {Event} */ event) => write({ [side]: valueOf(event) })}>
    <option value="">${named(d.metrics[side === 'error' ? 0 : 1] ?? '')}</option>${d.metrics.slice(0).map(
      (path) => html`<option value=${path}
        .selected=${path === d[side]}>${named(path)}</option>`,
    )}</select></label>`;
  const count = html`<small>${t('experiments.of', { n: d.metrics.length, all: metrics.value.length })}</small>`,
    left = found.length - SHOWN_METRICS;
  return html`<fieldset class="panel server metrics">${head(t('experiments.metrics'), count)}
    <div class="chosen">${d.metrics.map(item)}</div>${sentence('metrics')}
    <label class="field"><span>${t('experiments.find')}</span><input id="find-metric" type="search" autocomplete="off"
      .value=${sought.value} @input=${(/** @type {Event} */ event) => {
        sought.value = valueOf(event);
      }}></label>
    <div class="offered" tabindex="0" role="group"
      aria-label=${t('experiments.metrics.offered')}>${found.slice(0, SHOWN_METRICS).map((path) => item(path, -1))}
      ${left > 0 ? html`<p class="facts">${t('experiments.metrics.more', { n: left })}</p>` : nothing}</div>
    ${trade('error')}${sentence('error')}${trade('cost')}${sentence('cost')}
    ${d.metrics.length > 1 ? frontPanel() : nothing}</fieldset>`;
}

/** All that the sentence has no place for. @returns {Template} */
export function form() {
  return html`<form class="fields" aria-label=${t('experiments.specification')}
    @submit=${(/** @type {Event} */ event) => event.preventDefault()}>
    <div>${scenarioPanel()}${fixedPanel()}</div><div>${axesPanel()}</div><div>${metricsPanel()}</div><div>${windowsPanel()}</div></form>`;
}
