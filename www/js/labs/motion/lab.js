// The step lab: one problem, several methods side by side, error against step and cost.
import { html, nothing } from '../../../vendor/lit-html.js';
import { signal } from '../../../vendor/signals-core.js';
import { fixed, localized } from '../../base/format.js';
import { find } from '../../base/schema.js';
import { MOTION_STATUS } from '../../stream/names.js';
import { change } from '../../session/params.js';
import { recall } from '../../workbench/past.js';
import { choose } from '../../session/session.js';
import { firstRun, layout, locked, look, may, params, schema } from '../../session/state.js';
import { palette, paintOf } from '../../draw/palette.js';
import { drawPlot } from '../../draw/plot.js';
import { textTurn } from '../../draw/redraw.js';
import { partTabs, shownPart } from '../../workbench/phone_parts.js';
import { aboutScenario } from '../../workbench/about.js';
import { said } from '../../workbench/said.js';
import { inTurn, onto, plotBox } from '../../workbench/canvas.js';
import { control } from '../../workbench/controls.js';
import { opening } from '../../workbench/opening.js';
import { mark } from '../../workbench/player_mark.js';
import { tradeoffButton } from '../../workbench/work_precision.js';
import { drawScene, isPlane } from './drawing.js';
import { ERRATA, METHOD_ERRATA } from './paper.js';
import { Record, motionsAt, motionsOf } from './record.js';
import { measure, measuring, series, watch } from './refinement.js';
import { called, t } from '../../base/words.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('../../stream/frame.js').Frame} Frame */
/** @typedef {import('./record.js').RefinementLevel} RefinementLevel */
/** @typedef {{problem: string, help: string, mechanical: boolean, energy: boolean, components: string[],
 *   methods: {method: string, order: number, adaptive: boolean}[]}} MotionLayout */

let record = new Record(-1);
const component = signal(0);

/** @returns {MotionLayout | null} */
const motion = () => (layout.value?.given.problem ? layout.value.given : null);
/** @param {number} i */
const nameOf = (i) => String(params.value?.methods?.[i]?.method ?? '');
const words = (/** @type {string} */ name) => called('motion', name);
/** @param {number} i */
const isAdaptive = (i) => motion()?.methods.some((one) => one.method === nameOf(i) && one.adaptive) === true;
/** The order of method `i` on this problem: forces that depend on velocities lower that of some. @param {number} i */
const orderOf = (i) => motion()?.methods.find((one) => one.method === nameOf(i))?.order;
const places = () => Array.from({ length: params.value?.methods?.length ?? 0 }, (_, i) => i);
const unitOf = (/** @type {string} */ name) => {
  const unit = /_(m|mps|rad|radps)$/.exec(name)?.[1] ?? '';
  return unit === '' ? '' : ` ${unit.replace('mps', 'm/s').replace('radps', 'rad/s')}`;
};

/** A component of the state with its unit: of vx_mps, vx (m/s). @param {string} name */
const componentName = (name) => {
  const unit = unitOf(name),
    letter = (unit === '' ? name : name.slice(0, name.lastIndexOf('_'))).replace('omega', 'ω').replace('theta', 'θ');
  return unit === '' ? letter : `${letter} (${unit.trim()})`;
};

// ---- controls ----

/** @param {number} i @param {number} factor */
function scaleStep(i, factor) {
  const now = params.value?.methods?.[i],
    adaptive = isAdaptive(i);
  const name = adaptive ? 'tolerance' : 'dt_s';
  const row = find(schema.value, `methods.${i}.${name}`);
  const value = Number(((now?.[name] ?? 0.01) * (adaptive ? (factor > 1 ? 10 : 0.1) : factor)).toPrecision(6));
  if (row) change({ [`methods.${i}.${name}`]: Math.min(row.max, Math.max(row.min, value)) });
}

/** @param {number} i @returns {Template} */
function methodPanel(i) {
  const at = `methods.${i}`,
    adaptive = isAdaptive(i);
  const scale = (/** @type {number} */ factor, /** @type {string} */ sign) =>
    html`<button type="button" aria-label=${`${sign} ${t(adaptive ? 'motion.tolerance_of' : 'motion.step_of', { n: i + 1 })}`}
        @click=${() => scaleStep(i, factor)}>${sign}</button>`;
  return html`<fieldset class="panel method" data-player=${i % 8} ?disabled=${locked.value !== ''} title=${locked.value || nothing}>
    <legend class="unseen">${t('motion.method', { n: i + 1 })}</legend>
    <div class="head"><h2>${mark(i)} ${words(nameOf(i))}</h2>${control(`${at}.shown`)}</div>
    ${control(`${at}.method`)}
    <p class="facts" data-order=${i}>${orderOf(i) === undefined ? nothing : t('motion.order', { order: String(orderOf(i)) })}</p>
    <div class="pair">${control(adaptive ? `${at}.tolerance` : `${at}.dt_s`)}
      <span class="units">${scale(0.5, adaptive ? '÷10' : '½')}${scale(2, adaptive ? '×10' : '×2')}</span></div>
    <details><summary>${t('motion.stepping')}</summary>${control(`${at}.steps`)}${control(`${at}.clock`)}
      ${control(`${at}.precision`)}${control(`${at}.origin_offset_m`)}</details>
  </fieldset>`;
}

/** @param {Event} event */
function chooseProblem(event) {
  choose('motion/general', { problem: /** @type {HTMLSelectElement} */ (event.target).value });
}

/** @returns {Template} */
function problemPanel() {
  const at = motion(),
    choices = find(schema.value, 'problem')?.choices ?? [];
  const names = Object.keys(params.value?.params ?? {});
  return html`<fieldset class="panel server" ?disabled=${locked.value !== ''}><legend class="unseen">${t('motion.problem')}</legend>
    <label class="field choice"><span>${t('motion.problem')}</span><select id="problem" @change=${chooseProblem}>
      ${choices.map((name) => html`<option value=${name} .selected=${name === at?.problem}>${words(name)}</option>`)}</select></label>
    <p class="facts">${said(at?.help ?? '')}</p>
    ${names.map((name) => control(`params.${name}`))}
    ${control('reverse')}
    <details><summary>${t('motion.frames')}</summary>${control('frames')}
      ${control('frame_s')}${control('frame_jitter')}</details></fieldset>`;
}

// ---- the page ----

/** @returns {Template | typeof nothing} */
function errata() {
  const list = [
    ...(ERRATA[params.value?.paper ?? ''] ?? []),
    ...(params.value?.methods ?? []).flatMap((/** @type {any} */ m) => (m.shown && METHOD_ERRATA.includes(m.method) ? [m.method] : [])),
  ];
  if (list.length === 0) return nothing;
  return html`<table class="data errata"><caption>${t('motion.errata')}</caption><thead><tr><th scope="col">${t('motion.paper')}</th><th
    scope="col">${t('motion.lab')}</th></tr></thead>
    <tbody>${list.map(
      (one) => html`<tr><td>${t(`motion.paper_says.${one}`)}</td><td>${t(`motion.lab_shows.${one}`)}</td></tr>`,
    )}</tbody></table>`;
}

/** @returns {Template} */
function template() {
  const at = motion();
  return html`${partTabs()}<main class="step" id="views" tabindex="-1" data-part=${shownPart.value}>
    <div class="methods" tabindex=${locked.value === '' ? nothing : 0} role="group"
      aria-label=${t('motion.problem_and_methods')}>${problemPanel()}${places().map(methodPanel)}</div>
    <div class="drawings" tabindex="0" role="region" aria-label=${t('workbench.views')}>
      ${opening(t('motion.see'))}
      <section class="row motion" aria-label=${t('shell.group.motion')}><div class="view" data-shows="positions path"><canvas
        id="motion" role="img" aria-label=${t('shell.group.motion')}></canvas><take-away
        name=${t('shell.group.motion')}></take-away></div></section>
      <div class="plots">
        ${plotBox('plot-value', t('motion.position_t'))}${plotBox('plot-error', t('motion.error_t'), 'error')}
        ${at?.energy ? plotBox('plot-energy', t('workbench.energy_t'), 'energy') : nothing}
        ${at?.mechanical ? plotBox('plot-phase', t('motion.phase')) : nothing}
        ${plotBox('plot-step', t('motion.error_step'))}${plotBox('plot-work', t('motion.error_cost'))}</div>
    </div>
    <aside class="side" aria-label=${t('workbench.numbers')}>
      <div class="about">${aboutScenario()}</div>
      <label class="field choice"><span>${t('motion.plotted')}</span><select @change=${(/** @type {Event} */ event) => {
        component.value = Number(/** @type {HTMLSelectElement} */ (event.target).value);
        record = new Record(-1);
      }}>${(at?.components ?? []).map(
        (name, k) => html`<option value=${k}
        .selected=${k === component.value}>${componentName(name)}</option>`,
      )}</select></label>
      <button type="button" ?disabled=${measuring.value || locked.value !== '' || !may('measure')}
        @click=${() => measure()}>${measuring.value ? t('motion.measuring') : t('motion.measure')}</button>
      ${tradeoffButton('integrators')}
      ${nowTable()}
      ${errata()}
    </aside></main>`;
}

/** What holds now, of the solution and of each method. @returns {Template} */
function nowTable() {
  const weighted = html`<abbr title=${t('motion.weighted_tip')}>${t('motion.weighted')}</abbr>`,
    plottedName = componentName(motion()?.components[component.value] ?? '');
  const columns = ['t (s)', plottedName, t('motion.error'), t('motion.largest'), weighted];
  return html`<div class="wide-table" tabindex="0" role="region" aria-label=${t('workbench.current')}><table
        class="data now" data-shows="table"><caption>${t('workbench.now')}</caption>
        <thead><tr><td></td>${columns.map((column) => html`<th scope="col">${column}</th>`)}</tr></thead>
        <tbody><tr><th scope="row">${t('motion.solution')}</th>${cells(0)}</tr>
        ${places().map((i) => html`<tr><th scope="row">${mark(i)} ${words(nameOf(i))}</th>${cells(i + 1)}</tr>`)}</tbody></table></div>`;
}

/** @param {number} row @returns {Template[]} */
function cells(row) {
  return ['t', 'value', 'error', 'largest', 'weighted'].map((name) => html`<td data-motion=${`${row}/${name}`}>–</td>`);
}

// ---- drawing ----

/** @param {number} value */
const exact = (value) =>
  value === 0
    ? '0'
    : Math.abs(value) < 1e-3 || Math.abs(value) >= 1e6
      ? localized(value.toExponential(1))
      : fixed(value, Math.abs(value) < 1 ? 4 : 3);

/** @param {Frame} frame */
function showNumbers(frame) {
  motionsOf(frame).forEach((one, row) => {
    const off = row > 0 && one.status === MOTION_STATUS.off;
    const values = {
      t: fixed(one.t_s, 3),
      value: fixed(one.state[component.value] ?? 0, 6),
      error: row === 0 ? '' : exact(one.error),
      largest: row === 0 ? '' : exact(one.error_max),
      weighted: row === 0 ? '' : exact(one.error_max_weighted),
    };
    for (const [name, text] of Object.entries(values)) {
      const cell = document.querySelector(`[data-motion="${row}/${name}"]`);
      const failed =
        one.status === MOTION_STATUS.diverged ? t('workbench.diverged') : one.status === MOTION_STATUS.failed ? t('motion.failed') : '';
      if (cell)
        cell.textContent = off
          ? '–'
          : failed && name === 'error'
            ? failed
            : failed && (name === 'largest' || name === 'weighted')
              ? ''
              : text;
    }
  });
}

/** What rows of the trace have. @param {import('../../workbench/past.js').Row[]} rows @param {MotionLayout} at */
function remembered(rows, at) {
  const past = new Record(-1);
  for (const row of rows)
    past.take(Number(row.time_s), motionsAt(row, at.components, places().length), component.value, isPlane(at.problem));
  return past;
}

const telling = textTurn(100);

/** @param {Frame} frame @param {boolean} settled @param {boolean} name the drawings get their descriptions */
function draw(frame, settled, name) {
  const at = motion();
  if (!at || frame.motion.length === 0) return;
  const motions = motionsOf(frame);
  if (record.generation !== frame.session.generation || record.time > frame.time_s) record = new Record(frame.session.generation);
  if (record.meet(frame.time_s, frame.tickHz)) record.take(frame.time_s, motions, component.value, isPlane(at.problem));
  recall(record, settled, 'ticks', (rows) => remembered(rows, at));
  const colours = palette(),
    shown = componentName(at.components[component.value] ?? '');
  const unit = unitOf(at.components[0] ?? '');
  const colourOf = (/** @type {number} */ i) => (i === 0 ? colours.truth : paintOf(colours, i - 1).text);
  const dashOf = (/** @type {number} */ i) => (i === 0 ? [5, 4] : paintOf(colours, i - 1).dash);
  const trackName = (/** @type {number} */ i) => (i === 0 ? t('motion.solution') : words(nameOf(i - 1)));
  const lines = (/** @type {'t' | 'value'} */ x, /** @type {'value' | 'speed' | 'error' | 'drift'} */ y, /** @type {number} */ from) =>
    record.tracks
      .slice(from)
      .map((track, k) => ({ xs: track[x], ys: track[y], name: trackName(k + from), colour: colourOf(k + from), dash: dashOf(k + from) }));
  const first = look.value?.step === 5 && firstRun.value !== null ? motionsOf(firstRun.value) : null;
  onto('motion', (surface) =>
    drawScene(surface, colours, record, motions, { problem: at.problem, names: places().map((i) => words(nameOf(i))), unit, first }),
  );
  if (telling(settled)) {
    showNumbers(frame);
    drawRefinementSeries(colours);
  }
  inTurn('plot-value', settled, (s) =>
    drawPlot(s, colours, { lines: lines('t', 'value', 0), x: 't (s)', y: shown, empty: t('workbench.play_to_draw') }),
  );
  inTurn('plot-error', settled, (s) =>
    drawPlot(s, colours, { lines: lines('t', 'error', 1), x: 't (s)', y: t('motion.error'), logY: true, empty: t('motion.no_error') }),
  );
  inTurn('plot-energy', settled, (s) =>
    drawPlot(s, colours, { lines: lines('t', 'drift', 1), x: 't (s)', y: t('motion.energy_drift'), empty: t('workbench.play_to_draw') }),
  );
  inTurn('plot-phase', settled, (s) =>
    drawPlot(s, colours, {
      lines: lines('value', 'speed', 0),
      x: shown,
      y: componentName(at.components[component.value + at.components.length / 2] ?? ''),
      empty: t('workbench.play_to_draw'),
    }),
  );
  if (name) {
    const list = frame.motion
      .slice(1)
      .map((one, i) => t('motion.summary', { name: words(nameOf(i)), error: exact(one.error) }))
      .join('; ');
    document.getElementById('motion')?.setAttribute('aria-label', t('motion.summary_at', { s: fixed(frame.time_s, 2), list }));
  }
}

/** Guides of slope 1, 2 and 4 through the middle of the measured points. @param {import('../../draw/palette.js').Palette} colours
 * @param {RefinementLevel[]} all */
function guides(colours, all) {
  const dts = all.map((one) => one.dt),
    errors = all.map((one) => one.error);
  if (all.length < 2) return [];
  const x0 = Math.min(...dts),
    x1 = Math.max(...dts),
    top = Math.max(...errors);
  return [1, 2, 4].map((order) => ({ xs: [x0, x1], ys: [top * (x0 / x1) ** order, top], colour: colours.grid, dash: [2, 3], width: 1.5 }));
}

/** @param {import('../../draw/palette.js').Palette} colours */
function drawRefinementSeries(colours) {
  const of = series().map(([i, list]) => ({ i, list }));
  const line = (/** @type {'dt' | 'work'} */ x) =>
    of.map(({ i, list }) => ({
      xs: list.map((one) => one[x]),
      ys: list.map((one) => one.error),
      name: words(nameOf(i)),
      colour: paintOf(colours, i).text,
      dash: paintOf(colours, i).dash,
      points: true,
    }));
  const floor = of.flatMap(({ list }) => list).filter((one) => one.error > 1e-14);
  const empty = measuring.value ? t('motion.measuring_plot') : t('motion.unmeasured');
  onto('plot-step', (s) =>
    drawPlot(s, colours, {
      lines: [...guides(colours, floor), ...line('dt')],
      x: t('motion.step_axis'),
      y: t('motion.largest_error'),
      logX: true,
      logY: true,
      empty,
    }),
  );
  onto('plot-work', (s) =>
    drawPlot(s, colours, { lines: line('work'), x: t('motion.evaluations'), y: t('motion.largest_error'), logX: true, logY: true, empty }),
  );
}

/** @type {import('../../session/lab.js').Lab} */
export const lab = {
  hint: () => 'motion',
  template,
  rendered: watch,
  draw,
  facts: () => ({
    refinement: { get: () => Object.fromEntries(series()) },
    remembered: { get: () => record.tracks.map(({ t }) => t) },
  }),
};
