// The fluid lab: fluids side by side, their errors and costs; a person can drag them.
import { html, nothing } from '../../../vendor/lit-html.js';
import { effect, signal } from '../../../vendor/signals-core.js';
import { fixed, short } from '../../base/format.js';
import { firstRun, frame as shownFrame, locked, look, session } from '../../session/state.js';
import { palette, paintOf } from '../../draw/palette.js';
import { drawPlot } from '../../draw/plot.js';
import { textTurn, touch } from '../../draw/redraw.js';
import { partTabs, shownPart } from '../../workbench/phone_parts.js';
import { aboutScenario } from '../../workbench/about.js';
import { said } from '../../workbench/said.js';
import { onto } from '../../workbench/canvas.js';
import { costs, forget as forgetMeasured, measure, profiles } from '../../workbench/measure.js';
import { opening } from '../../workbench/opening.js';
import { mark } from '../../workbench/player_mark.js';
import { PointerDrag } from '../../workbench/pointer_drag.js';
import { tradeoffButton, workPrecisionButton } from '../../workbench/work_precision.js';
import { fluidsOf } from './decode.js';
import { drawScene } from './drawing.js';
import { drawing, familyOf, fluid, fluids, isSurface, nameOf, relief, words } from './fluids.js';
import { isSize, pick, rankOf, formatNumber, wordsOf } from './numbers.js';
import { fluidPanel, scenePanel } from './panels.js';
import { Record } from './record.js';
import { Scale } from './scale.js';
import { t } from '../../base/words.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('../../stream/frame.js').Frame} Frame */
/** @typedef {import('./fluids.js').Layer} Layer */
/** @typedef {import('./fluids.js').FluidLayout} FluidLayout */

/** Of each fluid. @type {Record[]} */
let records = [];
/** By layer. @type {Map<string, Scale>} */
let scales = new Map();
/** Names of the numbers that are plotted; empty: as suits the scene. @type {import('@preact/signals-core').Signal<string[]>} */
const plotted = signal(['', '']);

const drag = new PointerDrag((world) => fluids()[world]?.view ?? []);
const idOf = (/** @type {number} */ i) => (i === 0 ? 'fluid' : `fluid${i}`);
/** The unit that the help of a layer ends with. @param {Layer} layer */
const unitOf = (layer) => /(?:^|: )((?:m|s|1|kg|N|J|Pa|rad)[\w/^²³*.]*?)\.?$/.exec(layer.help)?.[1] ?? '';
/** Whether the colours are heights of water. @param {import('./decode.js').Fluid} now @param {number} i */
const isWater = (now, i) => {
  const layer = now.field && fluids()[i]?.layers[now.field.layer];
  return layer !== null && layer !== undefined && isSurface(layer);
};

// ---- numbers ----

/** Of all fluids, each name once, in the order of the first. */
const names = () => [...new Set(fluids().flatMap((one) => one.numbers))];
/** @param {number} i @param {string} name */
const cellOf = (i, name) => (i === 0 ? name : `${i}/${name}`);

/** @param {string} name @returns {Template} */
function row(name) {
  const { label, unit } = wordsOf(name);
  return html`<tr><th scope="row">${label}${unit ? ` (${unit})` : ''}</th>${fluids().map(
    (_, i) => html`<td
    data-fluid=${cellOf(i, name)}>–</td>`,
  )}</tr>`;
}

/** @param {string} caption @param {Template[]} rows @returns {Template | typeof nothing} */
function table(caption, rows) {
  if (rows.length === 0) return nothing;
  const heads =
    fluids().length > 1
      ? html`<thead><tr><td></td>${fluids().map(
          (_, i) => html`<th scope="col"><span
        class="unseen">${nameOf(i)}</span>${mark(i)}</th>`,
        )}</tr></thead>`
      : nothing;
  return html`<table class="data now">${caption ? html`<caption>${caption}</caption>` : nothing}${heads}<tbody>${rows}</tbody></table>`;
}

/** @returns {Template} */
function numbers() {
  const of = (/** @type {number} */ rank) =>
    names()
      .filter((name) => rankOf(name) === rank)
      .map(row);
  const each = (/** @type {(i: number) => string} */ text, /** @type {string} */ id) =>
    fluids().map((_, i) => html`<td id=${i === 0 ? id : `${id}${i}`}>${text(i)}</td>`);
  const steps = (/** @type {number} */ n) => (/** @type {number} */ i) => {
    const ms = costs.value[i]?.all;
    return ms === undefined ? '–' : short(ms * n);
  };
  const pace = fluid()?.hz ?? 60;
  return html`${table(t('fluid.cost'), [
    html`<tr><th scope="row">${t('fluid.step_ms')}</th>${each(steps(1), 'step-ms')}</tr>`,
    html`<tr><th
      scope="row">${t('fluid.second_ms')}</th>${each(steps(pace), 'second-ms')}</tr>`,
    html`<tr><th scope="row">${t('fluid.fps')}</th><td id="fps" colspan=${fluids().length}>–</td></tr>`,
  ])}
    ${table(t('fluid.errors'), of(0))}${table(t('fluid.conserved'), of(1))}
    ${of(2).length > 0 ? html`<details><summary>${t('fluid.more_values')}</summary>${table('', of(2))}</details>` : nothing}`;
}

// ---- the page ----

/** The number that plot `i` shows. @param {number} i @returns {string} */
function plottedName(i) {
  const all = names(),
    chosen = plotted.value[i] ?? '';
  if (all.includes(chosen)) return chosen;
  return all[pick(all, i === 0 ? [/error/, /energy/, /water_at/] : [/^divergence/, /density.*max/, /mass_change/, /mass/])] ?? '';
}

/** @param {number} i @returns {Template} */
function plot(i) {
  const name = t('fluid.over_time', { name: wordsOf(plottedName(i)).label });
  const set = (/** @type {Event} */ event) => {
    plotted.value = plotted.value.map((one, k) => (k === i ? /** @type {HTMLSelectElement} */ (event.target).value : one));
  };
  const shows = /energy|error|divergence/.exec(plottedName(i))?.[0] ?? '';
  return html`<section class="plotbox" aria-label=${name} data-shows=${shows}><div class="view"><canvas id=${`plot${i}`} role="img"
    aria-label=${name}></canvas><take-away data name=${name}></take-away>
    <select class="plotted" aria-label=${t('fluid.plot_shows', { n: i + 1 })} @change=${set}>${names().map(
      (one) => html`<option value=${one}
      .selected=${one === plottedName(i)}>${wordsOf(one).label}</option>`,
    )}</select></div></section>`;
}

const hasProfiles = () => (profiles.value ?? []).some((one) => Object.keys(one).length > 0);

/** The metric that shows a fluid's error best. @param {number} i */
const errorOf = (i) => {
  const all = fluids()[i]?.numbers ?? [];
  return all[pick(all, [/error.*max|^error|front_error/, /error/, /^divergence/, /numerical|overshoot/, /energy/])] ?? '';
};

/** @param {number} i @returns {Template} */
function drawingOf(i) {
  const step = costs.value[i]?.all,
    cost = t('fluid.per_step', { ms: step === undefined ? '–' : short(step) });
  const name = `${fluids()[i]?.title ?? t('shell.tab.fluid')}${fluids().length > 1 ? `, ${nameOf(i)}` : ''}`;
  const label = `${name}. ${t('fluid.drag')}`;
  return html`<figure class="drawing"><figcaption>${fluids().length > 1 ? html`${mark(i)} <b>${nameOf(i)}</b>` : nothing}
      <span>${wordsOf(errorOf(i)).label} <output
        data-error=${i}>–</output></span><span>${cost}</span></figcaption>
    ${drag.box(
      i,
      'stir',
      label,
      html`<canvas id=${idOf(i)} role="img" aria-label=${t('shell.tab.fluid')}></canvas><take-away
      name=${name}></take-away>`,
    )}</figure>`;
}

/** @returns {Template} */
const profilePlot = () =>
  html`<section class="plotbox" aria-label=${t('fluid.profiles')}><div class="view">
        <canvas id="profiles" role="img" aria-label=${t('fluid.profiles')}></canvas><take-away data
          name=${t('fluid.profiles')}></take-away></div></section>`;

/** What a fluid is, and what its scene warns of. @param {FluidLayout | null} at @returns {Template} */
function aboutFluid(at) {
  const source = at?.source ? html`<p>${t('fluid.reference')} <span lang="en">${at.source}</span></p>` : nothing;
  const notices = (at?.notices ?? []).map(
    (/** @type {string} */ text) => html`<p role="note"><strong>${t('fluid.warning')}</strong> ${said(text)}</p>`,
  );
  return html`<div class="about"><p>${said(at?.help ?? '')}</p>${source}
        ${notices}</div>`;
}

/** @returns {Template} */
function template() {
  const at = fluid();
  return html`${partTabs()}<main class="step fluid" id="views" tabindex="-1" data-part=${shownPart.value}>
    <div class="methods" tabindex=${locked.value === '' ? nothing : 0} aria-label=${t('workbench.scene_and_solvers')}
      role="group">${scenePanel()}${fluids().map((_, i) => fluidPanel(i))}</div>
    <div class="drawings" tabindex="0" role="region" aria-label=${t('workbench.views')}>
      ${opening(t('fluid.see'))}
      <section class="stage" data-shows="smoke positions volumes" aria-label=${t('shell.group.fluid')}
        data-count=${fluids().length}>${fluids().map((_, i) => drawingOf(i))}</section>
      <div class="plots">${plot(0)}${plot(1)}${hasProfiles() ? profilePlot() : nothing}</div>
    </div>
    <aside class="side" aria-label=${t('workbench.numbers')}>
      <div class="about">${aboutScenario()}</div>
      ${workPrecisionButton()}${tradeoffButton(familyOf(at))}${numbers()}
      ${aboutFluid(at)}
    </aside></main>`;
}

// ---- drawing ----

/** @param {string} name @param {string} unit */
function scaleOf(name, unit) {
  const known = scales.get(name) ?? new Scale(unit);
  scales.set(name, known);
  return known;
}

/** Of each fluid. @type {number[]} */
const newest = [];

/** The present colour scale. @param {import('./decode.js').Fluid} now @param {number} i @param {number} seq of the frame
 * @returns {{scale: Scale | null, word: string}} */
function coloured(now, i, seq) {
  const layers = fluids()[i]?.layers ?? [],
    fresh = seq !== newest[i];
  newest[i] = seq;
  if (now.field) {
    const layer = layers[now.field.layer],
      unit = layer ? unitOf(layer) : '';
    const scale = scaleOf(layer?.name ?? '', unit);
    if (fresh) scale.take(now.field);
    return { scale, word: `${words(layer?.name ?? '')}${unit ? ` (${unit})` : ''}` };
  }
  for (const list of now.points) {
    const columns = layers[list.layer]?.columns ?? [],
      hue = columns.findIndex((name) => /speed|mps$/.test(name));
    if (hue < 0) continue;
    const { label, unit } = wordsOf(columns[hue] ?? ''),
      scale = scaleOf(label, unit);
    let most = 0;
    for (let k = hue; k < list.values.length; k += list.columns) most = Math.max(most, list.values[k] ?? 0);
    if (fresh) scale.follow(most, false);
    return { scale, word: `${label}${unit ? ` (${unit})` : ''}` };
  }
  return { scale: null, word: '' };
}

/** @param {string} place @param {string} text */
function put(place, text) {
  const cell = document.querySelector(place);
  if (cell && cell.textContent !== text) cell.textContent = text;
}

/** @param {number} i @param {number[]} values */
function showNumbers(i, values) {
  fluids()[i]?.numbers.forEach((name, k) => {
    const text = formatNumber(name, values[k] ?? NaN);
    put(`[data-fluid="${cellOf(i, name)}"]`, text);
    if (name === errorOf(i)) put(`[data-error="${i}"]`, text);
  });
}

/** @param {import('../../draw/palette.js').Palette} colours */
function drawPlots(colours) {
  const several = fluids().length > 1;
  for (const p of [0, 1]) {
    const name = plottedName(p),
      size = isSize(name),
      { unit } = wordsOf(name);
    const lines = fluids().flatMap((one, i) => {
      const ys = records[i]?.values(one.numbers.indexOf(name)),
        own = paintOf(colours, several ? i : p);
      return ys
        ? [
            {
              xs: records[i]?.times ?? [],
              ys: size ? ys.map(Math.abs) : ys,
              name: several ? nameOf(i) : wordsOf(name).label,
              colour: own.text,
              ...(several ? { dash: own.dash } : {}),
            },
          ]
        : [];
    });
    const logY = size && lines.some(({ ys }) => ys.some((v) => v > 0)), // what is 0 throughout is a line at 0
      empty = t('workbench.play_to_draw');
    onto(`plot${p}`, (s) => drawPlot(s, colours, { lines, x: 't (s)', y: unit, logY, least: 1e-9, empty }));
  }
  if (!hasProfiles()) return;
  const curves = (profiles.value ?? []).flatMap((one, i) =>
    Object.entries(one).map(([name, pairs]) => ({ name, i, pairs, known: name.endsWith('_reference') })),
  );
  const shown = curves.filter(({ i, known }) => !known || i === 0),
    own = [...new Set(shown.filter(({ known }) => !known).map(({ name }) => name))];
  const lines = shown.map(({ name, i, pairs, known }) => ({
    xs: pairs.map(([x = 0]) => x),
    ys: pairs.map(([, y = 0]) => y),
    name: several && !known ? `${name}, ${nameOf(i)}` : name,
    colour: paintOf(colours, several ? i : Math.max(0, own.indexOf(name.replace('_reference', '')))).text,
    ...(known ? { points: true, width: 1, dash: [2, 3] } : several ? { dash: paintOf(colours, i).dash } : {}),
  }));
  const known = shown.some((one) => one.known) ? t('fluid.dots_known') : '';
  onto('profiles', (s) => drawPlot(s, colours, { lines, x: t('fluid.place'), y: `${own.join(', ')}${known}`, least: 1e-9, empty: '' }));
}

const telling = textTurn(100);
let counted = 0,
  countedFrom = 0;

/** @param {number} time ms */
function showPace(time) {
  counted++;
  if (time - countedFrom < 1000) return;
  const cell = document.getElementById('fps');
  if (cell) cell.textContent = countedFrom > 0 && time - countedFrom < 3000 ? fixed((1000 * counted) / (time - countedFrom), 0) : '–';
  counted = 0;
  countedFrom = time;
}

/** @param {Frame} frame @param {import('./decode.js').Fluid} now @param {number} i
 * @param {import('../../draw/palette.js').Palette} colours @param {boolean} still no frame follows soon */
function drawOne(frame, now, i, colours, still) {
  const of = /** @type {FluidLayout} */ (fluids()[i]);
  const points = now.points.map((list) => {
    const layer = of.layers[list.layer];
    return { of: list, columns: layer?.columns ?? [], line: layer !== undefined && isSurface(layer) };
  });
  onto(idOf(i), (surface) => {
    drag.cameras.set(
      i,
      drawScene(surface, colours, {
        view: of.view,
        field: now.field,
        first: look.value?.step === 5 && firstRun.value !== null ? (fluidsOf(firstRun.value)[i]?.field ?? null) : null,
        points,
        ...coloured(now, i, frame.seq),
        water: isWater(now, i),
        cells: drawing.value.cells,
        relief: relief(i),
        hand: drag.pointerIn(i),
        still,
        note: now.state.status === 1 ? t('fluid.diverged') : '',
      }),
    );
  });
}

/** @param {FluidLayout} of @param {import('./decode.js').State} state @param {number} time */
function describe(of, { numbers: values, status }, time) {
  const wrong = of.numbers.flatMap((one, k) => (rankOf(one) === 0 ? [`${wordsOf(one).label} ${formatNumber(one, values[k] ?? NaN)}`] : []));
  return t('fluid.summary', {
    title: of.title,
    s: fixed(time, 2),
    list: [...(status === 1 ? [t('fluid.diverged')] : []), ...wrong].join(', '),
  });
}

/** @param {Frame} frame @param {boolean} settled @param {boolean} name the drawings get their descriptions */
function draw(frame, settled, name) {
  const all = fluidsOf(frame),
    at = fluids();
  if (all.length === 0 || all.length !== at.length) return;
  const colours = palette(),
    time = performance.now(),
    tells = telling(settled);
  measure(frame, true);
  showPace(time);
  all.forEach((now, i) => {
    const known = records[i];
    if (!known || known.generation !== frame.session.generation || known.time > frame.time_s)
      records[i] = new Record(frame.session.generation);
    if (now.state.status === 0) records[i]?.take(frame.time_s, now.state.numbers);
    drawOne(frame, now, i, colours, settled);
    if (tells) showNumbers(i, now.state.numbers);
    if (name)
      document.getElementById(idOf(i))?.setAttribute('aria-label', describe(/** @type {FluidLayout} */ (at[i]), now.state, frame.time_s));
  });
  if (tells) drawPlots(colours);
}

effect(() => {
  session.value;
  forgetMeasured();
  records = [];
  scales = new Map();
});
effect(() => {
  profiles.value;
  costs.value;
  touch();
});

/** @type {import('../../session/lab.js').Lab} */
export const lab = {
  hint: () => 'stir',
  template,
  draw,
  facts: () => ({
    fluids: { get: () => shownFrame.value && fluidsOf(shownFrame.value) },
    profiles: { get: () => profiles.value },
    view: { get: () => fluids()[0]?.view },
    drag: { value: drag },
  }),
};
