// The Experiments view: the form, the runs and their progress, what is known of the points, and the side column.
import { html, nothing } from '../../../vendor/lit-html.js';
import { effect, untracked } from '../../../vendor/signals-core.js';
import { constant, styleSheet } from '../../base/api.js';
import { fixed } from '../../base/format.js';
import { t } from '../../base/words.js';
import { link } from '../../session/opening.js';
import { experiment } from '../../session/state.js';
import { workPrecisionOf } from '../../workbench/work_precision.js';
import { notesOf } from './columns.js';
import { choose, draft, measure, scenario, watch } from './draft.js';
import { form, library } from './form.js';
import { isOver } from './progress.js';
import { stateOf, wholeName } from './names.js';
import { chosen, named } from './plotted.js';
import { redraw, scatter, tableOf } from './points_plot.js';
import { POINTS_MAX, control, keyOf, missing, points, record, renewKept, scenario as whole, way } from './shown.js';
import { side } from './side.js';
import { many, renewTable, table } from './table.js';
import { message } from '../../base/messages.js';

/** @typedef {import('lit-html').TemplateResult} Template */

/** Importers wait for it. */
export const ready = styleSheet('experiments');

/** @param {number} seconds */
const left = (seconds) =>
  seconds < 100 ? `${Math.ceil(seconds)} s` : seconds < 5400 ? `${Math.round(seconds / 60)} min` : `${fixed(seconds / 3600, 1)} h`;

/** What its owner may do while it runs. @param {any} r @returns {Template} */
function acts(r) {
  const mine = keyOf(r.id) !== '',
    why = mine ? nothing : t('experiments.read_only');
  const act = (/** @type {'pause' | 'resume' | 'cancel'} */ op, /** @type {string} */ label) =>
    html`<button type="button" id=${op} ?disabled=${!mine} title=${why} @click=${() => control(op)}>${label}</button>`;
  return html`<span class="acts">${r.state === 'paused' ? act('resume', t('experiments.resume')) : act('pause', t('experiments.pause'))}
        ${act('cancel', t('base.cancel'))}</span>`;
}

/** How fast, and how long still; empty while that is not known. @param {any} r @returns {string} */
function paceOf(r) {
  if (r.state !== 'running' || r.rate_per_s <= 0) return '';
  const rate = r.rate_per_s >= 10 ? many(Math.round(r.rate_per_s)) : fixed(r.rate_per_s, 1);
  return ` · ${t('experiments.rate', { rate })}${r.left_s === null ? '' : ` · ${t('experiments.left', { time: left(r.left_s) })}`}`;
}

/** What the daemon and the experiment itself have to say. @param {any} r @returns {string[]} */
const noticesOf = (r) => [
  ...(r.notices ?? []).map((/** @type {string} */ text) => message(text).text),
  ...notesOf(r.experiment, points.value, named),
];

/** @param {any} r @returns {Template} */
function progressPanel(r) {
  const reads = keyOf(r.id) === '' && !isOver(r.state);
  return html`<section class="progress" aria-label=${t('experiments.progress')} data-state=${r.state} data-way=${way.value}>
    <div class="head"><h2 id="shown-title">${r.title || r.experiment.scenario?.title || t('experiments.experiment')}</h2>
      ${isOver(r.state) ? nothing : acts(r)}</div>
    ${r.experiment.text ? html`<p class="facts" lang="en">${r.experiment.text}</p>` : nothing}
    <progress max=${r.runs} .value=${r.done} aria-label=${t('experiments.runs_done')}></progress>
    <p id="progress-text"><b>${stateOf(r.state)}</b> · ${t('experiments.done', { n: many(r.done), all: many(r.runs) })}${paceOf(r)}</p>
    ${r.held_back ? html`<p class="facts" id="held-back">${r.held_back}</p>` : nothing}
    ${reads ? html`<p class="facts">${t('experiments.read_only')}</p>` : nothing}
    ${noticesOf(r).map((text) => html`<p class="facts" role="note">${text}</p>`)}
    ${r.points > POINTS_MAX ? html`<p class="facts">${t('experiments.too_many', { n: many(r.points) })}</p>` : nothing}</section>`;
}

/** @returns {Template} */
function results() {
  const r = record.value;
  if (missing.value !== '') return html`<p class="empty">${t(`experiments.${missing.value}`)}</p>`;
  if (experiment.value && !r) return html`<p class="empty">${t('experiments.loading')}</p>`;
  if (!r) {
    return html`<div class="empty"><h2>${t('experiments.empty')}</h2><p>${t('experiments.empty.text')}</p></div>`;
  }
  return html`${progressPanel(r)}${
    points.value.length > 0
      ? html`${scatter()}${table()}`
      : html`<p class="empty">${r.points > POINTS_MAX ? '' : t(isOver(r.state) ? 'experiments.no_run_ended' : 'experiments.no_points')}</p>`
  }`;
}

/** @returns {Template} */
function template() {
  return html`<main class="step sweeps" id="views" tabindex="-1">${form()}
    <div class="outcome"><div class="drawings" tabindex="0" role="region" aria-label=${t('experiments.experiment')}>${results()}</div>
    ${side()}</div></main>`;
}

effect(() => {
  /* another experiment, another plot */
  experiment.value;
  chosen.value = { x: '', y: '', by: null, logX: null, logY: null };
  renewTable();
});
let begun = false;
/** The first time that the view is wanted. */
export function begin() {
  if (begun) return;
  begun = true;
  watch();
  effect(() => {
    const wanted = workPrecisionOf.value;
    if (wanted === null) return;
    untracked(() => measure(wanted));
    workPrecisionOf.value = null;
  });
  if (scenario.value === null && typeof draft.value.scenario === 'string') choose(link.first);
  renewKept();
  constant('experiments/library').then(
    (answer) => {
      library.value = answer.experiments;
    },
    () => {},
  );
}

/** What is shown, for files that are saved of it. @returns {ReturnType<NonNullable<import('../../session/lab.js').Lab['about']>>} */
function about() {
  const r = record.value,
    of = r?.experiment ?? {};
  const nameOf = (/** @type {string} */ path) => wholeName(path, '', whole.value);
  const varied = (of.axes ?? [])
    .flatMap((/** @type {any} */ axis) => axis.zip ?? [axis])
    .map((/** @type {any} */ axis) =>
      axis.values
        ? `${nameOf(axis.path)} = ${axis.values.join(', ')}`
        : t('experiments.about.axis', { name: nameOf(axis.path), from: axis.from, to: axis.to, n: axis.count ?? 0 }),
    );
  const fixedAt = Object.entries(of.set ?? {}).map(
    ([path, value]) => `${nameOf(path)} = ${typeof value === 'object' ? JSON.stringify(value) : value}`,
  );
  return {
    title: r?.title || of.scenario?.title || t('experiments.experiment'),
    settings: [
      `${t('experiments.scenario')} ${of.scenario_id ?? (typeof of.scenario === 'string' ? of.scenario : (of.scenario?.title ?? ''))}`,
      ...fixedAt,
      ...varied,
    ].join('; '),
    moment: t('experiments.about.moment', { seed: of.seed ?? of.scenario?.seed ?? 1, n: r?.done ?? 0, all: r?.runs ?? 0 }),
    version: r?.version ?? '',
  };
}

/** @type {import('../../session/lab.js').Lab} */
export const lab = {
  template,
  rendered: redraw,
  about,
  tables: async () => ({
    scatter: tableOf,
  }),
};
