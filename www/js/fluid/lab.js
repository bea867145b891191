// The fluid lab: scenes of fluids, what is wrong with them and what they cost, stirred by a person.
import { html, nothing } from '../../vendor/lit-html.js';
import { effect, signal } from '../../vendor/signals-core.js';
import { cameras, forget as forgetHand, key, move, pointer, press, release } from '../workbench/hand.js';
import { control } from '../controls.js';
import { link } from '../early.js';
import { fixed, short } from '../format.js';
import { again, choose } from '../lab.js';
import { touch } from '../loop.js';
import { change } from '../params.js';
import { find, labelOf, livePaths } from '../schema.js';
import { drawPlot } from '../step/plot.js';
import { layout, locked, params, scenarios, schema, session } from '../state.js';
import { palette, paintOf } from '../theme.js';
import { Surface } from '../views/surface.js';
import { fluidOf } from './decode.js';
import { cost, forget as forgetMeasured, measure, profiles } from './measure.js';
import { isSize, pick, rankOf, told, wordsOf } from './numbers.js';
import { drawPicture } from './picture.js';
import { Record } from './record.js';
import { Scale } from './scale.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('../frame.js').Frame} Frame */
/** @typedef {import('../state.js').FluidLayer} Layer */

const sheet = document.createElement('link');
sheet.rel = 'stylesheet';
sheet.href = new URL('../../fluid.css', import.meta.url).href;
const styled = new Promise((done) => { sheet.onload = sheet.onerror = done; });
document.head.append(sheet);
await styled;

/** @type {WeakMap<HTMLCanvasElement, Surface>} */
const surfaces = new WeakMap();
let record = new Record(-1);
/** By layer. @type {Map<string, Scale>} */
let scales = new Map();
/** How a field is drawn; null: as suits it. @type {import('@preact/signals-core').Signal<{cells: boolean, relief: boolean | null}>} */
const drawing = signal({ cells: false, relief: null });
/** Places of the numbers that are plotted; -1: as suits the scene. @type {import('@preact/signals-core').Signal<number[]>} */
const plotted = signal([-1, -1]);

const fluid = () => layout.value?.fluid ?? null;
const words = (/** @type {string} */ name) => name.replaceAll('_', ' ');
const fields = () => fluid()?.layers.filter((layer) => layer.shape === 'field') ?? [];
/** The unit that the help of a layer ends with. @param {Layer} layer */
const unitOf = (layer) => /(?:^|: )((?:m|s|1|kg|N|J|Pa|rad)[\w/^²³*.]*?)\.?$/.exec(layer.help)?.[1] ?? '';
/** @param {Layer} layer */
const isSurface = (layer) => /surface|height/.test(layer.name);
/** The field that frames carry. @returns {Layer | undefined} */
const shownField = () => fields()[Math.min(params.value?.shown ?? 0, fields().length - 1)];
const relief = () => drawing.value.relief ?? (shownField() !== undefined && isSurface(/** @type {Layer} */ (shownField())));

// ---- controls ----

/** What varies in a scene is laid out with it: another value is another session. @param {string} name @returns {Template | typeof nothing} */
function sceneParameter(name) {
  const path = `params.${name}`, row = find(schema.value, path), value = params.value?.params?.[name];
  if (!row || value === undefined) return nothing;
  const renew = (/** @type {import('../link.js').Value} */ given) => {
    link.set = { ...link.set, [path]: given };
    again();
  };
  if (row.type === 'choice') {
    return html`<label class="field choice" title=${row.help}><span>${labelOf(path)}</span><select data-scene=${name}
      @change=${(/** @type {Event} */ event) => renew(/** @type {HTMLSelectElement} */ (event.target).value)}>
      ${row.choices.map((one) => html`<option value=${one} .selected=${one === value}>${words(one)}</option>`)}</select></label>`;
  }
  return html`<label class="field" title=${row.help}><span>${name === 'n' ? 'Cells along a side' : name === 're' ? 'Reynolds number' : labelOf(path)}</span><input type="number"
    data-scene=${name} min=${row.min} max=${row.max} step=${row.type === 'integer' ? 1 : 'any'} .value=${String(value)}
    @change=${(/** @type {Event} */ event) => {
      const given = /** @type {HTMLInputElement} */ (event.target);
      if (given.value !== '' && given.reportValidity()) renew(Number(given.value));
    }}><span class="unit">${row.unit}</span></label>`;
}

/** @returns {Template} */
function scenePanel() {
  const rows = scenarios.value.filter((row) => row.kind === 'fluid');
  return html`<fieldset class="panel server" ?disabled=${locked.value !== ''}><legend class="unseen">Scene</legend>
    <label class="field choice"><span>Scene</span><select id="scene" @change=${(/** @type {Event} */ event) => choose(/** @type {HTMLSelectElement} */ (event.target).value)}>
      ${rows.map((row) => html`<option value=${row.id} .selected=${row.title === params.value?.title}>${row.title}</option>`)}</select></label>
    ${Object.keys(params.value?.params ?? {}).map(sceneParameter)}</fieldset>`;
}

/** Settings that make the largest difference; the others stand below. */
const FIRST = ['method', 'advection', 'pressure', 'splitting', 'tolerance', 'sweeps', 'iterations', 'viscosity', 'viscosity_scale', 'confinement', 'clamp'];
const SOLVER_LABELS = /** @type {{[name: string]: string}} */ ({ backtrace: 'Order of back-trace', cfl: 'CFL number', viscosity_scale: 'Viscosity ×' });

/** @returns {Template} */
function solverPanel() {
  const paths = livePaths(schema.value, 'solver'), nameOf = (/** @type {string} */ path) => path.slice(path.lastIndexOf('.') + 1);
  const one = (/** @type {string} */ path) => (SOLVER_LABELS[nameOf(path)] ? control(path, { label: SOLVER_LABELS[nameOf(path)] }) : control(path));
  const first = paths.filter((path) => FIRST.includes(nameOf(path))), rest = paths.filter((path) => !FIRST.includes(nameOf(path)));
  return html`<fieldset class="panel method" ?disabled=${locked.value !== ''} title=${locked.value || nothing}><legend class="unseen">Solver</legend>
    <div class="head"><h2>Solver</h2><small>${words(fluid()?.method ?? '')}</small></div>
    ${first.map(one)}${rest.length > 0 ? html`<details><summary>More</summary>${rest.map(one)}</details>` : nothing}</fieldset>`;
}

/** @param {'cells' | 'relief'} name @param {string} label @param {boolean} on @returns {Template} */
function toggle(name, label, on) {
  return html`<label class="toggle"><input type="checkbox" data-drawing=${name} .checked=${on} @change=${() => {
    drawing.value = { ...drawing.value, [name]: !on };
    touch();
  }}><span>${label}</span></label>`;
}

/** @returns {Template | typeof nothing} */
function fieldPanel() {
  const list = fields(), now = shownField();
  if (!now) return nothing;
  const show = (/** @type {Event} */ event) => change({ shown: Number(/** @type {HTMLSelectElement} */ (event.target).value) });
  return html`<fieldset class="panel plainpanel" ?disabled=${locked.value !== ''}><legend class="unseen">Field</legend>
    <label class="field choice"><span>Field</span><select id="field" @change=${show}>
      ${list.map((layer, i) => html`<option value=${i} .selected=${layer === now}>${words(layer.name)}</option>`)}</select></label>
    <p class="facts">${now.help}</p>
    <div class="toggles">${toggle('cells', 'Sharp cells', drawing.value.cells)}${toggle('relief', 'Relief', relief())}</div></fieldset>`;
}

// ---- numbers ----

/** @param {string} name @returns {Template} */
function row(name) {
  const { label, unit } = wordsOf(name);
  return html`<tr><th scope="row">${label}${unit ? ` (${unit})` : ''}</th><td data-fluid=${name}>–</td></tr>`;
}

/** @returns {Template} */
function numbers() {
  const names = fluid()?.numbers ?? [];
  const of = (/** @type {number} */ rank) => names.filter((name) => rankOf(name) === rank);
  return html`<table class="data now"><caption>Cost</caption><tbody>
      <tr><th scope="row">step (ms)</th><td id="step-ms">${cost.value ? short(cost.value.step) : '–'}</td></tr>
      <tr><th scope="row">processor per second (ms)</th><td>${cost.value ? short(cost.value.second) : '–'}</td></tr>
      <tr><th scope="row">pictures per second</th><td id="fps">–</td></tr></tbody></table>
    ${of(0).length > 0 ? html`<table class="data now"><caption>What is wrong</caption><tbody>${of(0).map(row)}</tbody></table>` : nothing}
    ${of(1).length > 0 ? html`<table class="data now"><caption>What is there</caption><tbody>${of(1).map(row)}</tbody></table>` : nothing}
    ${of(2).length > 0 ? html`<details><summary>More numbers</summary><table class="data now"><tbody>${of(2).map(row)}</tbody></table></details>` : nothing}`;
}

// ---- the page ----

/** The number that plot `i` shows. @param {number} i @returns {number} its place */
function placeOf(i) {
  const names = fluid()?.numbers ?? [], chosen = plotted.value[i] ?? -1;
  if (chosen >= 0 && chosen < names.length) return chosen;
  return pick(names, i === 0 ? [/error/, /energy/] : [/^divergence/, /density.*max/, /mass_change/, /mass/]);
}

/** @param {number} i @returns {Template} */
function plot(i) {
  const names = fluid()?.numbers ?? [], name = `${wordsOf(names[placeOf(i)] ?? '').label} over time`;
  const set = (/** @type {Event} */ event) => {
    plotted.value = plotted.value.map((one, k) => (k === i ? Number(/** @type {HTMLSelectElement} */ (event.target).value) : one));
  };
  return html`<section class="plotbox" aria-label=${name}><div class="view"><canvas id=${`plot${i}`} role="img" aria-label=${name}></canvas>
    <select class="plotted" aria-label=${`Plot ${i + 1} shows`} @change=${set}>${names.map((one, k) => html`<option value=${k}
      .selected=${k === placeOf(i)}>${wordsOf(one).label}</option>`)}</select></div></section>`;
}

const hasProfiles = () => Object.keys(profiles.value ?? {}).length > 0;

/** @returns {Template} */
export function fluidLab() {
  const at = fluid();
  const label = `${at?.title ?? 'Fluid'}. Drag to stir, with the mouse or a finger. Arrow keys move a hand, Enter takes hold and lets go.`;
  return html`<main class="step fluid" id="views" tabindex="-1">
    <div class="methods" aria-label="Scene and solver" role="group">${scenePanel()}${fieldPanel()}${solverPanel()}</div>
    <div class="pictures" tabindex="0" role="region" aria-label="Pictures">
      <section class="stage" aria-label="Fluid"><div class="view stir" role="group" tabindex="0" data-world="0" aria-label=${label}
        @pointerdown=${press} @pointermove=${move} @pointerup=${release} @pointercancel=${release} @keydown=${key}>
        <canvas id="fluid" role="img" aria-label="Fluid"></canvas></div></section>
      <div class="plots">${plot(0)}${plot(1)}${hasProfiles() ? html`<section class="plotbox" aria-label="Profiles"><div class="view">
        <canvas id="profiles" role="img" aria-label="Profiles"></canvas></div></section>` : nothing}</div>
    </div>
    <aside class="side" aria-label="Numbers">
      <div class="about"><h2>${params.value?.paper ? `${params.value.paper}: ` : ''}${params.value?.title ?? ''}</h2>
        ${params.value?.text ? html`<p>${params.value.text}</p>` : nothing}</div>
      ${numbers()}
      <div class="about"><p>${at?.help ?? ''}</p>${at?.source ? html`<p>Reference: ${at.source}</p>` : nothing}</div>
    </aside></main>`;
}

// ---- drawing ----

/** @param {string} id @param {(surface: Surface) => void} draw */
function onto(id, draw) {
  const canvas = document.getElementById(id);
  if (!(canvas instanceof HTMLCanvasElement)) return;
  const surface = surfaces.get(canvas) ?? new Surface(canvas);
  surfaces.set(canvas, surface);
  if (surface.begin()) draw(surface);
}

/** @param {string} name @param {string} unit */
function scaleOf(name, unit) {
  const known = scales.get(name) ?? new Scale(unit);
  scales.set(name, known);
  return known;
}

let newest = -1;

/** What the colours stand for now. @param {import('./decode.js').Fluid} now @param {number} seq of the frame
 * @returns {{scale: Scale | null, word: string}} */
function coloured(now, seq) {
  const layers = fluid()?.layers ?? [], fresh = seq !== newest;
  newest = seq;
  if (now.field) {
    const layer = layers[now.field.layer], unit = layer ? unitOf(layer) : '';
    const scale = scaleOf(layer?.name ?? '', unit);
    if (fresh) scale.take(now.field);
    return { scale, word: `${words(layer?.name ?? '')}${unit ? ` (${unit})` : ''}` };
  }
  for (const list of now.points) {
    const columns = layers[list.layer]?.columns ?? [], hue = columns.findIndex((name) => /speed|mps$/.test(name));
    if (hue < 0) continue;
    const { label, unit } = wordsOf(columns[hue] ?? ''), scale = scaleOf(label, unit);
    let most = 0;
    for (let k = hue; k < list.values.length; k += list.columns) most = Math.max(most, list.values[k] ?? 0);
    if (fresh) scale.follow(most, false);
    return { scale, word: `${label}${unit ? ` (${unit})` : ''}` };
  }
  return { scale: null, word: '' };
}

/** @param {number[]} values */
function showNumbers(values) {
  fluid()?.numbers.forEach((name, i) => {
    const cell = document.querySelector(`[data-fluid="${name}"]`), text = told(name, values[i] ?? NaN);
    if (cell && cell.textContent !== text) cell.textContent = text;
  });
}

/** @param {import('../theme.js').Palette} colours */
function drawPlots(colours) {
  const names = fluid()?.numbers ?? [];
  for (const i of [0, 1]) {
    const place = placeOf(i), name = names[place] ?? '', size = isSize(name), { unit } = wordsOf(name);
    const ys = record.numbers[place] ?? [], some = ys.some((v) => v !== 0);
    const lines = [{ xs: record.t, ys: size ? ys.map(Math.abs) : ys, colour: paintOf(colours, i).text }];
    onto(`plot${i}`, (s) => drawPlot(s, colours, { lines, x: 't (s)', y: unit, logY: size, least: 1e-9, empty: some || ys.length < 2 ? 'Play to draw' : 'all is 0' }));
  }
  const curves = Object.entries(profiles.value ?? {}), own = curves.filter(([name]) => !name.endsWith('_reference'));
  const lines = curves.map(([name, pairs]) => {
    const known = name.endsWith('_reference'), place = own.findIndex(([one]) => one === name.replace('_reference', ''));
    return { xs: pairs.map(([x = 0]) => x), ys: pairs.map(([, y = 0]) => y), colour: paintOf(colours, Math.max(0, place)).text,
      ...(known ? { points: true, width: 1, dash: [2, 3] } : {}) };
  });
  const known = curves.length > own.length ? '; dots: known' : '';
  onto('profiles', (s) => drawPlot(s, colours, { lines, x: 'place', y: `${own.map(([name]) => name).join(', ')}${known}`, least: 1e-9, empty: '' }));
}

let numbered = 0, counted = 0, countedFrom = 0;

/** @param {number} time ms */
function showPace(time) {
  counted++;
  if (time - countedFrom < 1000) return;
  const cell = document.getElementById('fps');
  if (cell) cell.textContent = countedFrom > 0 && time - countedFrom < 3000 ? fixed((1000 * counted) / (time - countedFrom), 0) : '–';
  counted = 0;
  countedFrom = time;
}

/** @param {Frame} frame @param {boolean} settled @param {boolean} name the pictures get their words */
export function drawFluid(frame, settled, name) {
  const at = fluid(), now = fluidOf(frame);
  if (!at || !now.state) return;
  const colours = palette(), time = performance.now(), { numbers: values, status } = now.state;
  if (record.generation !== frame.generation || record.time > frame.time) record = new Record(frame.generation);
  record.take(frame.time, values);
  measure(frame);
  showPace(time);
  const points = now.points.map((of) => {
    const layer = at.layers[of.layer];
    return { of, columns: layer?.columns ?? [], line: layer !== undefined && isSurface(layer) };
  });
  const note = status === 1 ? 'It diverged and was stopped' : '';
  onto('fluid', (surface) => {
    cameras.set(0, drawPicture(surface, colours, { view: at.view, field: now.field, points, ...coloured(now, frame.seq), cells: drawing.value.cells,
      relief: relief(), hand: pointer.value, note }));
  });
  if (settled || time - numbered > 120) {
    numbered = time;
    showNumbers(values);
    drawPlots(colours);
  }
  if (name) {
    const wrong = at.numbers.flatMap((one, i) => (rankOf(one) === 0 ? [`${wordsOf(one).label} ${told(one, values[i] ?? NaN)}`] : []));
    document.getElementById('fluid')?.setAttribute('aria-label', `${at.title} at ${fixed(frame.time, 2)} s. ${[note, ...wrong].filter((text) => text !== '').join(', ')}`);
  }
}

effect(() => {
  session.value;
  forgetHand();
  forgetMeasured();
  record = new Record(-1);
  scales = new Map();
});
effect(() => {
  pointer.value;
  profiles.value;
  touch();
});
