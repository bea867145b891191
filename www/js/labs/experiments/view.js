// The Experiments view: the runs and their progress, the points as a scatter plot and a table, and the downloads.
import { html, nothing } from '../../../vendor/lit-html.js';
import { effect, signal, untracked } from '../../../vendor/signals-core.js';
import { address, call, styleSheet } from '../../base/api.js';
import { fixed } from '../../base/format.js';
import { t } from '../../base/words.js';
import { mark } from '../../workbench/player_mark.js';
import { link } from '../../session/opening.js';
import { experiment, notify, theme } from '../../session/state.js';
import { palette } from '../../draw/palette.js';
import { onto } from '../../workbench/canvas.js';
import { tradeoffButton, workPrecisionOf } from '../../workbench/work_precision.js';
import { boundsOf, formatValue, meanOf, notesOf, numberOf, spreadOf } from './columns.js';
import { choose, draft, measure, scenario, specification, start, watch } from './draft.js';
import { form, library } from './form.js';
import { isOver } from './progress.js';
import { wholeName } from './names.js';
import { chosen, columns, front, labelOf, named, plotsErrorAndCost, plotted, positive, select } from './plotted.js';
import { SERIES_MAX, drawScatter, nearest, seriesOf } from './scatter.js';
import {
  POINTS_MAX,
  control,
  kept,
  keyOf,
  live,
  look,
  missing,
  points,
  record,
  remove,
  renewKept,
  runOf,
  scenario as whole,
  selected,
  way,
} from './shown.js';
import { many, renewTable, table } from './table.js';
import { message } from '../../base/messages.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('./shown.js').Cells} Cells */

/** Importers wait for it. */
export const ready = styleSheet('experiments');

const valueOf = (/** @type {Event} */ event) => /** @type {HTMLSelectElement} */ (event.target).value;

// ---- the head of the results ----

/** @param {string} state */
const stateOf = (state) => t(`experiments.state.${state}`) || state;

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

// ---- scatter ----

/** @type {import('./scatter.js').Spot[]} */
let spots = [];
/** Points that lie under others. */
const covered = signal(0);

/** @param {PointerEvent} event */
function press(event) {
  const box = /** @type {HTMLElement} */ (event.currentTarget).getBoundingClientRect();
  const index = nearest(spots, event.clientX - box.left, event.clientY - box.top),
    row = points.value[index];
  if (!row) return;
  if (selected.value === index) live(row);
  else select(index);
}

/** @param {PointerEvent} event */
function hover(event) {
  const box = /** @type {HTMLElement} */ (event.currentTarget).getBoundingClientRect();
  const far = nearest(spots, event.clientX - box.left, event.clientY - box.top) < 0;
  /** @type {HTMLElement} */ (event.currentTarget).style.cursor = far ? 'default' : 'pointer';
}

/** @param {KeyboardEvent} event */
function key(event) {
  const row = points.value[selected.value];
  if (event.key === 'Enter' && row) {
    event.preventDefault();
    live(row);
    return;
  }
  const way_ = ['ArrowRight', 'ArrowUp'].includes(event.key) ? 1 : ['ArrowLeft', 'ArrowDown'].includes(event.key) ? -1 : 0;
  if (way_ === 0 || spots.length === 0) return;
  event.preventDefault();
  const at = spots.findIndex((spot) => spot.index === selected.value);
  select(spots[at < 0 ? 0 : Math.max(0, Math.min(spots.length - 1, at + way_))]?.index ?? -1);
}

/** @param {'x' | 'y'} which @param {import('./columns.js').Column[]} list @returns {Template} */
function axisChoice(which, list) {
  const log = which === 'x' ? 'logX' : 'logY',
    name = plotted.value[which],
    label = t(`experiments.plot.${which}`);
  const plot = (/** @type {Event} */ event) => {
    chosen.value = { ...chosen.value, [which]: valueOf(event), [log]: null };
  };
  const toggle = () => {
    chosen.value = { ...chosen.value, [log]: !plotted.value[log] };
  };
  return html`<span class="axischoice"><label class="field choice"><span>${label}</span><select id=${`plot-${which}`} @change=${plot}>
    ${list.map((column) => html`<option value=${column.name} .selected=${column.name === name}>${column.label}</option>`)}</select></label>
    <label class="toggle"><input type="checkbox" id=${`log-${which}`} aria-label=${t('experiments.plot.logarithmic', { axis: label })}
      .checked=${plotted.value[log]} ?disabled=${!positive(name)} @change=${toggle}><span>log</span></label></span>`;
}

/** The selected point, in words. @returns {string} */
function words() {
  const row = points.value[selected.value];
  if (!row) return '';
  const axes = columns.value
    .filter((column) => column.kind === 'axis')
    .map((column) => `${column.label} ${formatValue(row[column.name], column.path, whole.value)}`);
  const values = record.value.experiment.metrics.map(
    (/** @type {string} */ name) => `${named(name)} ${meanOf(row, name)}${numberOf(row, 'runs') > 1 ? `, ${spreadOf(row, name)}` : ''}`,
  );
  return t(front.value.has(selected.value) ? 'experiments.says.front' : 'experiments.says', {
    n: String(row.point),
    values: [...axes, ...values].join('; '),
  });
}

/** The marks of the series; none where there are too many of them. @returns {Template[]} */
function seriesKeys() {
  const { by } = plotted.value,
    names = seriesOf(points.value, by),
    path = columns.value.find((column) => column.name === by)?.path;
  if (by === '' || names.length > SERIES_MAX) return [];
  const valueIn = (/** @type {string} */ name) => formatValue(Number.isNaN(Number(name)) ? name : Number(name), path, whole.value);
  return names.map((name, s) => html`<span class="sample">${mark(s)} ${valueIn(name)}</span>`);
}

const frontKey = () =>
  html`<span class="sample"><svg class="mark frontmark" viewBox="0 0 18 18" aria-hidden="true"><circle cx="9" cy="9"
      r="7"></circle></svg>${t('experiments.plot.front')}</span>`;

/** @returns {Template} */
function coveredKey() {
  const counts = { n: many(covered.value), points: many(points.value.length) };
  return html`<span class="sample" id="covered">${t('experiments.plot.covered', counts)}</span>`;
}

/** @returns {Template} */
const legend = () => html`<div class="key">${seriesKeys()}
    ${plotsErrorAndCost.value ? frontKey() : nothing}
    ${covered.value > 0 ? coveredKey() : nothing}</div>`;

/** @returns {Template} */
function scatter() {
  const row = points.value[selected.value],
    numbers = columns.value.filter((column) => column.numbers);
  const splits = columns.value.filter((column) => column.kind === 'axis' && seriesOf(points.value, column.name).length <= SERIES_MAX);
  return html`<section class="scatter" aria-label=${t('experiments.scatter')}><div
    class="choices">${axisChoice('y', numbers)}${axisChoice('x', numbers)}
      <label class="field choice"><span>${t('experiments.plot.series')}</span><select id="plot-by"
        @change=${(/** @type {Event} */ event) => {
          chosen.value = { ...chosen.value, by: valueOf(event) };
        }}>
        <option value="">${t('experiments.none')}</option>${splits.map(
          (column) => html`<option value=${column.name}
          .selected=${column.name === plotted.value.by}>${column.label}</option>`,
        )}</select></label></div>
    <div class="view" role="group" tabindex="0" id="scatter-box"
      aria-label=${t('experiments.plot.keys')}
      @pointerdown=${press} @pointermove=${hover} @keydown=${key}><canvas id="scatter" role="img"
        aria-label=${
          t('experiments.plot.says', { n: points.value.length, y: labelOf(plotted.value.y), x: labelOf(plotted.value.x) }) +
          (plotsErrorAndCost.value ? t('experiments.plot.says.front', { n: front.value.size }) : '')
        }></canvas><take-away data name=${t('experiments.points')}></take-away></div>
    ${legend()}
    <div class="looked"><output id="point"
      aria-live="polite">${row ? words() : t('experiments.plot.select')}</output>
      ${
        row
          ? html`<span class="acts"><button type="button" id="open-live" @click=${() => live(row)}>${t('experiments.open_live')}</button>
        <a class="button" href=${address(`experiments/${record.value.id}/runs/${runOf(row)}/trace`).href}
          download=${`run${runOf(row)}.csv`}>${t('experiments.trace')}</a></span>`
          : nothing
      }</div></section>`;
}

// ---- side column ----

const FORMATS = /** @type {[string, string][]} */ ([
  ['csv', 'CSV'],
  ['ndjson', 'NDJSON'],
  ['json', 'JSON'],
  ['parquet', 'Parquet'],
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
      rel="noopener">${t('experiments.report')}</a>${
        r.state === 'done'
          ? html`<a id="archive" href=${address(`experiments/${r.id}/archive`).href} download=${`${r.id}.tar`}
      title=${t('experiments.archive_tip')}>${t('experiments.archive')}</a>`
          : nothing
      }</p>
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

/** @param {any} r the experiment shown, if any @returns {Template} */
const byProgram = (r) => html`<section class="about" aria-label=${t('experiments.api')}><div class="head"><h2>${t('experiments.api')}</h2>
        <button type="button" class="small" id="copy" @click=${copy}>${t('experiments.copy')}</button></div>
        <textarea readonly rows="7" aria-label=${t('experiments.curl')} .value=${curl(r)}></textarea></section>`;

/** @returns {Template} */
function template() {
  const r = record.value;
  const again = () => html`<button type="button" id="again" @click=${() => start(r.experiment)}>${t('experiments.again')}</button>`;
  return html`<main class="step sweeps" id="views" tabindex="-1">${form()}
    <div class="outcome"><div class="drawings" tabindex="0" role="region" aria-label=${t('experiments.experiment')}>${results()}</div>
    <aside class="side" aria-label=${t('experiments.side')}>${r ? html`${files(r)}${again()}` : nothing}${list()}
      ${tradeoffButton('')}
      ${byProgram(r)}</aside></div></main>`;
}

// ---- drawing ----

function draw() {
  onto('scatter', (surface) => {
    const drawn = drawScatter(
      surface,
      palette(),
      points.value,
      plotted.value,
      plotsErrorAndCost.value ? front.value : new Set(),
      selected.value,
      { x: labelOf(plotted.value.x), y: labelOf(plotted.value.y), empty: t('experiments.plot.empty') },
    );
    spots = drawn.spots;
    covered.value = drawn.covered;
  });
}
let asked = false;
function redraw() {
  if (asked) return;
  asked = true;
  requestAnimationFrame(() => {
    asked = false;
    draw();
  });
}

effect(() => {
  points.value;
  plotted.value;
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
addEventListener('resize', redraw);
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);

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
  call('GET', 'experiments/library').then(
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
    scatter: () => ({
      columns: [
        t('experiments.column.point'),
        ...columns.value.flatMap(({ name, kind }) =>
          kind === 'axis' ? [name] : [name, t('experiments.column.from', { name }), t('experiments.column.to', { name })],
        ),
      ].map((name) => ({ name, unit: '' })),
      rows: points.value.map((row) => [
        row.point ?? null,
        ...columns.value.flatMap(({ name, kind }) => {
          const { low, high } = boundsOf(row, name);
          return kind === 'axis'
            ? [row[name] ?? null]
            : [numberOf(row, name), low, high].map((value) => (Number.isFinite(value) ? value : null));
        }),
      ]),
    }),
  }),
};
