// The Experiments view: the runs and their progress, the points as a scatter plot and a table, and the downloads.
import { html, nothing } from '../../../vendor/lit-html.js';
import { effect, signal, untracked } from '../../../vendor/signals-core.js';
import { address, call } from '../../base/api.js';
import { fixed } from '../../base/format.js';
import { mark } from '../../workbench/player_mark.js';
import { link } from '../../session/opening.js';
import { experiment, notify, theme } from '../../session/state.js';
import { palette } from '../../draw/palette.js';
import { onto } from '../../workbench/canvas.js';
import { workPrecisionOf } from '../../workbench/work_precision.js';
import { boundsOf, formatValue, meanOf, notesOf, numberOf, spreadOf } from './columns.js';
import { choose, draft, measure, scenario, specification, start, watch } from './draft.js';
import { form, library } from './form.js';
import { isOver } from './progress.js';
import { chosen, columns, front, plotsErrorAndCost, plotted, positive, select } from './plotted.js';
import { SERIES_MAX, drawScatter, nearest, seriesOf } from './scatter.js';
import { POINTS_MAX, control, kept, keyOf, live, look, missing, points, record, remove, renewKept, runOf, selected, way } from './shown.js';
import { many, renewTable, table } from './table.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('./shown.js').Cells} Cells */

const sheet = document.createElement('link');
sheet.rel = 'stylesheet';
sheet.href = new URL('../../../experiments.css', import.meta.url).href;
const styled = new Promise((done) => {
  sheet.onload = sheet.onerror = done;
});
document.head.append(sheet);
/** Importers wait for it. */
export const ready = styled;

const valueOf = (/** @type {Event} */ event) => /** @type {HTMLSelectElement} */ (event.target).value;

// ---- the head of the results ----

const STATES = /** @type {Record<string, string>} */ ({
  running: 'Running',
  paused: 'Paused',
  cancelled: 'Cancelled',
  done: 'Done',
  failed: 'Failed',
});

/** @param {number} seconds */
const left = (seconds) =>
  seconds < 100 ? `${Math.ceil(seconds)} s` : seconds < 5400 ? `${Math.round(seconds / 60)} min` : `${fixed(seconds / 3600, 1)} h`;

/** @param {any} r @returns {Template} */
function progressPanel(r) {
  const mine = keyOf(r.id) !== '',
    over = isOver(r.state);
  const why = mine ? nothing : 'Read-only: only the owner of this experiment can control it';
  return html`<section class="progress" aria-label="Progress" data-state=${r.state} data-way=${way.value}>
    <div class="head"><h2 id="shown-title">${r.title || r.experiment.scenario?.title || 'Experiment'}</h2>
      ${
        over
          ? nothing
          : html`<span class="acts">${
              r.state === 'paused'
                ? html`<button type="button" id="resume" ?disabled=${!mine} title=${why} @click=${() => control('resume')}>Resume</button>`
                : html`<button type="button" id="pause" ?disabled=${!mine} title=${why} @click=${() => control('pause')}>Pause</button>`
            }
        <button type="button" id="cancel" ?disabled=${!mine} title=${why} @click=${() => control('cancel')}>Cancel</button></span>`
      }</div>
    ${r.experiment.text ? html`<p class="facts">${r.experiment.text}</p>` : nothing}
    <progress max=${r.runs} .value=${r.done} aria-label="Runs done"></progress>
    <p id="progress-text"><b>${STATES[r.state] ?? r.state}</b> · ${many(r.done)} of ${many(r.runs)} runs${
      r.state === 'running' && r.rate_per_s > 0
        ? ` · ${r.rate_per_s >= 10 ? many(Math.round(r.rate_per_s)) : fixed(r.rate_per_s, 1)} runs/s${
            r.left_s === null ? '' : ` · ${left(r.left_s)} left`
          }`
        : ''
    }</p>
    ${r.held_back ? html`<p class="facts" id="held-back">${r.held_back}</p>` : nothing}
    ${!mine && !over ? html`<p class="facts">${why}</p>` : nothing}
    ${[...(r.notices ?? []), ...notesOf(r.experiment, points.value)].map(
      (/** @type {string} */ text) => html`<p class="facts"
      role="note">${text}</p>`,
    )}
    ${
      r.points > POINTS_MAX
        ? html`<p class="facts">${many(r.points)} points are too many to draw here: the report and the files have them.</p>`
        : nothing
    }</section>`;
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

/** @param {'x' | 'y'} which @param {string} label @param {import('./columns.js').Column[]} list @returns {Template} */
function axisChoice(which, label, list) {
  const log = which === 'x' ? 'logX' : 'logY',
    name = plotted.value[which];
  return html`<span class="axischoice"><label class="field choice"><span>${label}</span><select id=${`plot-${which}`}
    @change=${(/** @type {Event} */ event) => {
      chosen.value = { ...chosen.value, [which]: valueOf(event), [log]: null };
    }}>
    ${list.map((column) => html`<option value=${column.name} .selected=${column.name === name}>${column.label}</option>`)}</select></label>
    <label class="toggle"><input type="checkbox" id=${`log-${which}`} aria-label=${`${label}: logarithmic`} .checked=${plotted.value[log]}
      ?disabled=${!positive(name)}
      @change=${() => {
        chosen.value = { ...chosen.value, [log]: !plotted.value[log] };
      }}><span>log</span></label></span>`;
}

/** The selected point, in words. @returns {string} */
function words() {
  const row = points.value[selected.value];
  if (!row) return '';
  const axes = columns.value.filter((column) => column.kind === 'axis').map((column) => `${column.label} ${formatValue(row[column.name])}`);
  const values = record.value.experiment.metrics.map(
    (/** @type {string} */ name) => `${name} ${meanOf(row, name)}${numberOf(row, 'runs') > 1 ? `, ${spreadOf(row, name)}` : ''}`,
  );
  return `Point ${row.point}${front.value.has(selected.value) ? ', on the front' : ''}: ${[...axes, ...values].join('; ')}`;
}

/** @returns {Template} */
function legend() {
  const { by } = plotted.value,
    names = seriesOf(points.value, by);
  return html`<div class="key">${
    by === '' || names.length > SERIES_MAX
      ? nothing
      : names.map(
          (name, s) => html`<span class="sample">${mark(s)} ${formatValue(Number.isNaN(Number(name)) ? name : Number(name))}</span>`,
        )
  }
    ${
      plotsErrorAndCost.value
        ? html`<span class="sample"><svg class="mark frontmark" viewBox="0 0 18 18" aria-hidden="true"><circle cx="9" cy="9"
      r="7"></circle></svg>thick edge, joined: Pareto front of cost and error</span>`
        : nothing
    }
    ${
      covered.value > 0
        ? html`<span class="sample" id="covered">${many(covered.value)} of ${many(points.value.length)} points
      lie under others and are not drawn</span>`
        : nothing
    }</div>`;
}

/** @returns {Template} */
function scatter() {
  const row = points.value[selected.value],
    numbers = columns.value.filter((column) => column.numbers);
  const splits = columns.value.filter((column) => column.kind === 'axis' && seriesOf(points.value, column.name).length <= SERIES_MAX);
  return html`<section class="scatter" aria-label="Scatter"><div
    class="choices">${axisChoice('y', 'Up', numbers)}${axisChoice('x', 'Across', numbers)}
      <label class="field choice"><span>Series</span><select id="plot-by"
        @change=${(/** @type {Event} */ event) => {
          chosen.value = { ...chosen.value, by: valueOf(event) };
        }}>
        <option value="">none</option>${splits.map(
          (column) => html`<option value=${column.name}
          .selected=${column.name === plotted.value.by}>${column.label}</option>`,
        )}</select></label></div>
    <div class="view" role="group" tabindex="0" id="scatter-box"
      aria-label="Points. Left and right arrow keys pick one, Enter opens it as a live session."
      @pointerdown=${press} @pointermove=${hover} @keydown=${key}><canvas id="scatter" role="img"
        aria-label=${`Scatter of ${points.value.length} points: ${plotted.value.y} over ${plotted.value.x}${
          plotsErrorAndCost.value ? `, ${front.value.size} on the front` : ''
        }`}></canvas><take-away data name="Points"></take-away></div>
    ${legend()}
    <div class="looked"><output id="point"
      aria-live="polite">${row ? words() : 'Select a point to read it; select it again, or press Enter, to open it as a live session.'}</output>
      ${
        row
          ? html`<span class="acts"><button type="button" id="open-live" @click=${() => live(row)}>Open as session</button>
        <a class="button" href=${address(`experiments/${record.value.id}/runs/${runOf(row)}/trace`).href}
          download=${`run${runOf(row)}.csv`}>Trace</a></span>`
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
  return html`<section class="about files" aria-label="Results"><h2>Results</h2>
    <p class="links"><a id="report" href=${address(`experiments/${r.id}/report`).href} target="_blank"
      rel="noopener">Standalone report</a></p>
    <h3>One row per run</h3>${links('', 'runs')}<h3>One row per point</h3>${links('&points=true', 'points')}</section>`;
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
  notify(done ? 'Copied' : 'Not copied: select the text and copy it');
}

/** @returns {Template} */
function list() {
  return html`<section class="about" aria-label="My experiments"><div class="head"><h2>My experiments</h2>
      ${experiment.value ? html`<button type="button" class="small" id="new" @click=${() => look('')}>None</button>` : nothing}</div>
    ${
      kept.value.length === 0
        ? html`<p>None yet. Experiments of this browser are listed here.</p>`
        : html`<ul class="mine">${kept.value.map(
            (one) => html`<li aria-current=${one.id === experiment.value ? 'true' : 'false'}>
      <button type="button" class="quiet" data-id=${one.id}
        @click=${() => look(one.id)}><span>${one.title}</span><small>${
          STATES[one.state] ?? one.state
        } · ${many(one.done)} of ${many(one.runs)}</small></button>
      <button type="button" class="small" aria-label=${`Delete ${one.title}`}
        @click=${() => remove(one.id)}>Delete</button></li>`,
          )}</ul>`
    }</section>`;
}

/** @returns {Template} */
function results() {
  const r = record.value;
  if (missing.value !== '') return html`<p class="empty">${missing.value}</p>`;
  if (experiment.value && !r) return html`<p class="empty">Loading</p>`;
  if (!r) {
    return html`<div class="empty"><h2>No runs yet</h2><p>Choose the parameters to vary and the metrics to keep; the runs are counted as
      you write. Run makes every combination and shows the points here as they come.</p></div>`;
  }
  return html`${progressPanel(r)}${
    points.value.length > 0
      ? html`${scatter()}${table()}`
      : html`<p class="empty">${r.points > POINTS_MAX ? '' : isOver(r.state) ? 'No run has ended' : 'No points yet'}</p>`
  }`;
}

/** @returns {Template} */
function template() {
  const r = record.value;
  return html`<main class="step sweeps" id="views" tabindex="-1">${form()}
    <div class="outcome"><div class="drawings" tabindex="0" role="region" aria-label="Experiment">${results()}</div>
    <aside class="side" aria-label="Results and list">${
      r ? html`${files(r)}<button type="button" id="again" @click=${() => start(r.experiment)}>Change and run again</button>` : nothing
    }${list()}
      <section class="about" aria-label="API request"><div class="head"><h2>API request</h2><button type="button" class="small" id="copy"
        @click=${copy}>Copy</button></div>
        <textarea readonly rows="7" aria-label="The same with curl" .value=${curl(r)}></textarea></section></aside></div></main>`;
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
      'nothing to draw on these axes',
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
  const varied = (of.axes ?? [])
    .flatMap((/** @type {any} */ axis) => axis.zip ?? [axis])
    .map((/** @type {any} */ axis) =>
      axis.values ? `${axis.path} = ${axis.values.join(', ')}` : `${axis.path} = ${axis.from} to ${axis.to}, ${axis.count} values`,
    );
  const fixedAt = Object.entries(of.set ?? {}).map(
    ([path, value]) => `${path} = ${typeof value === 'object' ? JSON.stringify(value) : value}`,
  );
  return {
    title: r?.title || of.scenario?.title || 'Experiment',
    settings: [
      `Scenario ${of.scenario_id ?? (typeof of.scenario === 'string' ? of.scenario : (of.scenario?.title ?? ''))}`,
      ...fixedAt,
      ...varied,
    ].join('; '),
    moment: `Seed ${of.seed ?? of.scenario?.seed ?? 1} · ${r?.done ?? 0} of ${r?.runs ?? 0} runs`,
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
        'point',
        ...columns.value.flatMap(({ label, kind }) => (kind === 'axis' ? [label] : [label, `${label}, 95 % from`, `${label}, 95 % to`])),
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
