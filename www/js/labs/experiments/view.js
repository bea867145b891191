// The Experiments view: the sentence of the experiment, what its points show, and behind buttons the rest of it.
import { html, nothing } from '../../../vendor/lit-html.js';
import { effect, untracked } from '../../../vendor/signals-core.js';
import { constant, styleSheet } from '../../base/api.js';
import { fixed } from '../../base/format.js';
import { message } from '../../base/messages.js';
import { t } from '../../base/words.js';
import { experiment, theme } from '../../session/state.js';
import { workPrecisionOf } from '../../workbench/work_precision.js';
import { addAxis } from './form/axes.js';
import { charts } from './charts.js';
import { notesOf } from './columns.js';
import { draft, estimate, measure, watch } from './form/draft.js';
import { drawer, drawerButton, openDrawer } from './form/drawers.js';
import { OWN } from './examples.js';
import { files, request } from './files.js';
import { form, library } from './form/form.js';
import { isOver } from './progress.js';
import { stateOf, wholeName } from './form/names.js';
import { chosen, lined, marked, measured, named } from './plotted.js';
import { redraw, scatter, tableOf } from './points_plot.js';
import { chooseButton, isChanged, order, sentenceForm } from './sentence.js';
import { POINTS_MAX, control, keyOf, look, missing, points, record, renewKept, scenario as whole, selected, way } from './shown.js';
import { headline, side } from './side.js';
import { many, renewTable, table } from './table.js';

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

/** How far it is, and what else there is of it. @returns {Template | typeof nothing} */
function foot() {
  const r = record.value;
  if (!r) return nothing;
  const over = isOver(r.state),
    reads = !over && keyOf(r.id) === '',
    seconds = Number(r.experiment.set?.duration_s ?? whole.value?.duration_s),
    runs = t('experiments.runs', { n: r.done, count: many(r.done) });
  return html`<section class="account progress" aria-label=${t('experiments.progress')} data-state=${r.state} data-way=${way.value}>
    ${
      over
        ? html`<p id="progress-text"><b>${stateOf(r.state)}</b> · ${t('experiments.runs_of', { runs, seconds })}
          <span class="facts">${t('experiments.each', { n: r.repeats })}
          ${points.value.some(hasInterval) ? t('experiments.bars') : ''}</span></p>`
        : html`<progress max=${r.runs} .value=${r.done} aria-label=${t('experiments.runs_done')}></progress>
          <p id="progress-text"><b>${stateOf(r.state)}</b> · ${t('experiments.done', {
            n: many(r.done),
            all: many(r.runs),
          })}${paceOf(r)}</p>${acts(r)}`
    }
    <span class="acts">${drawerButton('table', t('experiments.table_button'))}
      ${drawerButton('files', t('experiments.files_button'))}
      ${drawerButton('request', t('experiments.request_button'))}</span>
    ${r.experiment.text ? html`<p class="facts whole" lang="en">${r.experiment.text}</p>` : nothing}
    ${r.held_back ? html`<p class="facts whole" id="held-back">${r.held_back}</p>` : nothing}
    ${reads ? html`<p class="facts whole">${t('experiments.read_only')}</p>` : nothing}
    ${noticesOf(r).map((text) => html`<p class="facts whole" role="note">${text}</p>`)}</section>`;
}

/** @param {import('./shown.js').Cells} row */
const hasInterval = (row) => Object.keys(row).some((name) => name.endsWith('.ci95') && row[name] !== null);

/** @returns {Template} */
function graphs() {
  const r = record.value;
  if (missing.value !== '') return html`<p class="empty">${t(`experiments.${missing.value}`)}</p>`;
  if (lined.value) return charts();
  if (points.value.length > 0) return scatter();
  if (!r) return html`<p class="empty">${t(experiment.value === OWN ? 'experiments.not_run' : 'experiments.loading')}</p>`;
  if (r.points > POINTS_MAX) return html`<p class="empty">${t('experiments.too_many', { n: many(r.points) })}</p>`;
  return html`<p class="empty">${t(isOver(r.state) ? 'experiments.no_run_ended' : 'experiments.no_points')}</p>`;
}

/** All points, and any two of their columns. @returns {Template | typeof nothing} */
const rows = () => (points.value.length === 0 ? nothing : html`${lined.value ? scatter() : nothing}${table()}`);

/** @returns {Template} */
const more = () => html`<div class="further"><button type="button" id="another-axis" @click=${addAxis}>${t('experiments.axis.add')}</button>
  ${chooseButton('choose')}
  <button type="button" id="to-repeats" @click=${() => openDrawer('settings', '#repeats')}>${t('experiments.repeats_button', {
    n: draft.value.repeats,
  })}</button>
  ${drawerButton('settings', t('experiments.settings'))}
  <span class="facts">${t('experiments.select_point')}</span></div>`;

/** @returns {Template} */
function template() {
  const changed = record.value !== null && isChanged();
  return html`<main class="sweeps" id="views" tabindex="-1"><h1 id="headline">${headline()}</h1>${sentenceForm()}
    ${changed ? html`<p class="changed" role="note">${t('experiments.changed')}</p>` : nothing}
    <div class="finding" data-changed=${String(changed)}><div class="graphs">${graphs()}</div>${side()}</div>
    ${foot()}${more()}
    ${drawer('settings', t('experiments.settings'), form)}
    ${drawer('table', t('experiments.table_button'), rows)}
    ${drawer('files', t('experiments.results'), files)}
    ${drawer('request', t('experiments.api'), request)}</main>`;
}

effect(() => {
  measured.value;
  marked.value;
  selected.value;
  theme.value;
  redraw();
});
effect(() => {
  /* another experiment, another plot */
  experiment.value;
  chosen.value = { x: '', y: '', by: null, logX: null, logY: null };
  renewTable();
});
/** A work-precision diagram of a session's scenario runs at once, if it takes no longer than this, s of a core. */
const AT_ONCE_S = 120;
/** @param {any} wanted a scenario */
function runDiagram(wanted) {
  look(OWN);
  estimate.value = null;
  measure(wanted);
  const done = effect(() => {
    if (experiment.value !== OWN) setTimeout(() => done());
    else if (draft.value.cost !== '' && estimate.value !== null) {
      const { estimated_cpu_s: seconds } = estimate.value;
      setTimeout(() => done());
      if (seconds <= AT_ONCE_S) untracked(order);
    }
  });
}

let begun = false;
/** The first time that the view is wanted. */
export function begin() {
  if (begun) return;
  begun = true;
  if (experiment.value === OWN && draft.value.axes.length === 0) look(''); /* an address that was kept: what it was of is gone */
  watch();
  effect(() => {
    const wanted = workPrecisionOf.value;
    if (wanted === null) return;
    untracked(() => runDiagram(wanted));
    workPrecisionOf.value = null;
  });
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

/* A chart whose box has another size is drawn again: no frames of a session make it drawn. */
const sizes = new ResizeObserver(() => redraw());

/** @type {import('../../session/lab.js').Lab} */
export const lab = {
  template,
  rendered: () => {
    for (const view of document.querySelectorAll('.charts .view')) sizes.observe(view);
    redraw();
  },
  about,
  tables: async () => Object.fromEntries(['scatter', ...measured.value.map((_, i) => `chart-${i}`)].map((id) => [id, tableOf])),
};
