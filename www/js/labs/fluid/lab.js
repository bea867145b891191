// The fluid lab: fluids side by side, their errors and costs; a person can drag them.
import { html, nothing } from '../../../vendor/lit-html.js';
import { effect, signal } from '../../../vendor/signals-core.js';
import { control } from '../../workbench/controls.js';
import { fixed, short } from '../../base/format.js';
import { choose } from '../../session/session.js';
import { touch } from '../netgame/lab/drawing.js';
import { mark } from '../netgame/lab/panels.js';
import { change } from '../../session/params.js';
import { find, labelOf, livePaths } from '../../base/schema.js';
import { drawPlot } from '../../draw/plot.js';
import { layout, locked, params, scenarios, schema, session } from '../../session/state.js';
import { palette, paintOf } from '../../draw/palette.js';
import { Surface } from '../../draw/surface.js';
import { countChoice, difference, paramsOf, pathOf, renew as renewSideBySide } from '../../workbench/side_by_side.js';
import { cameras, forget as forgetPointer, pointerIn, key, move, pointer, press, release } from '../../workbench/pointer_drag.js';
import { costs, forget as forgetMeasured, measure, profiles } from '../../workbench/measure.js';
import { fluidsOf } from './decode.js';
import { isSize, pick, rankOf, formatNumber, wordsOf } from './numbers.js';
import { drawScene } from './drawing.js';
import { Record } from './record.js';
import { Scale } from './scale.js';
import { workPrecisionButton } from '../../workbench/work_precision.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('../netgame/core/frame.js').Frame} Frame */
/** @typedef {import('../../session/state.js').FluidLayer} Layer */
/** @typedef {import('../../session/state.js').FluidLayout} FluidLayout */
/** @typedef {import('../../base/link.js').Value} Value */

const sheet = document.createElement('link');
sheet.rel = 'stylesheet';
sheet.href = new URL('../../../fluid.css', import.meta.url).href;
const styled = new Promise((done) => {
  sheet.onload = sheet.onerror = done;
});
document.head.append(sheet);
await styled;

/** @type {WeakMap<HTMLCanvasElement, Surface>} */
const surfaces = new WeakMap();
/** Of each fluid. @type {Record[]} */
let records = [];
/** By layer. @type {Map<string, Scale>} */
let scales = new Map();
/** How a field is drawn; null: as suits it. @type {import('@preact/signals-core').Signal<{cells: boolean, relief: boolean | null}>} */
const drawing = signal({ cells: false, relief: null });
/** Names of the numbers that are plotted; empty: as suits the scene. @type {import('@preact/signals-core').Signal<string[]>} */
const plotted = signal(['', '']);

const fluid = () => layout.value?.fluid ?? null;
/** The fluids side by side. @returns {FluidLayout[]} */
const fluids = () => (fluid() ? [/** @type {FluidLayout} */ (fluid()), ...(fluid()?.side_by_side ?? [])] : []);
const idOf = (/** @type {number} */ i) => (i === 0 ? 'fluid' : `fluid${i}`);
const words = (/** @type {string} */ name) => name.replaceAll('_', ' ');
/** @param {FluidLayout | undefined} of */
const fieldsOf = (of) => of?.layers.filter((layer) => layer.shape === 'field') ?? [];
/** The unit that the help of a layer ends with. @param {Layer} layer */
const unitOf = (layer) => /(?:^|: )((?:m|s|1|kg|N|J|Pa|rad)[\w/^²³*.]*?)\.?$/.exec(layer.help)?.[1] ?? '';
/** @param {Layer} layer */
const isSurface = (layer) => /surface|height/.test(layer.name);
/** Whether the colours are heights of water. @param {import('./decode.js').Fluid} now @param {number} i */
const isWater = (now, i) => {
  const layer = now.field && fluids()[i]?.layers[now.field.layer];
  return layer !== null && layer !== undefined && isSurface(layer);
};
/** The field that frames carry. @param {number} i @returns {Layer | undefined} */
function shownField(i) {
  const fields = fieldsOf(fluids()[i]);
  return fields[Math.min(paramsOf(i).shown ?? 0, fields.length - 1)];
}
/** @param {number} i */
function relief(i) {
  const field = shownField(i);
  return drawing.value.relief ?? (field !== undefined && isSurface(field));
}

/** How a further fluid differs from the first. @param {any} one @param {any} first */
const differencesOf = (one, first) =>
  one.scene === first.scene ? difference(one, first) : { scene: one.scene, params: one.params, solver: one.solver };

/** Name of a fluid: its scene, or the settings that differ. @param {number} i */
function nameOf(i) {
  const own = paramsOf(i),
    all = fluids(),
    first = String(own.solver?.method ?? own.solver?.pressure ?? own.scene ?? '');
  if (all.some((one) => one.scene !== all[0]?.scene)) return all[i]?.title ?? '';
  const other = all.findIndex((_, k) => k !== i && Object.keys(differencesOf(own, paramsOf(k))).length > 0);
  const { params: sizes = {}, solver = {} } = other < 0 ? {} : differencesOf(own, paramsOf(other));
  const differ = Object.entries({ ...solver, ...sizes })
    .filter(([name]) => name !== 'method')
    .slice(0, 2);
  const parts = differ.map(([name, value]) =>
    value === true
      ? words(name)
      : value === false
        ? `no ${words(name)}`
        : name === 'n' || name === 'size'
          ? `${name} = ${value}`
          : /^(advection|pressure|splitting)$/.test(name)
            ? words(String(value))
            : `${words(name)} ${words(String(value))}`,
  );
  return solver.method || parts.length === 0 ? [words(first), ...parts].join(', ') : parts.join(', ');
}

/** @param {{[path: string]: Value}} set of the first fluid @param {any[]} list of the further fluids, as wanted */
function renew(set, list) {
  const first = structuredClone({ scene: params.value.scene, params: params.value.params, solver: params.value.solver });
  for (const [path, value] of Object.entries(set)) if (path.startsWith('params.')) first.params[path.slice(7)] = value;
  renewSideBySide(
    set,
    list.map((one) => differencesOf(one, first)),
  );
}

/** The further fluids as they are. @returns {any[]} */
const others = () =>
  (params.value?.side_by_side ?? []).map((/** @type {any} */ one) =>
    structuredClone({ scene: one.scene, params: one.params, solver: one.solver }),
  );

// ---- controls ----

/** Parameter of a scene: a change creates another session. @param {number} i @param {string} name
 * @returns {Template | typeof nothing} */
function sceneParameter(i, name) {
  const path = `${pathOf(i)}params.${name}`,
    row = find(schema.value, path),
    value = paramsOf(i).params?.[name];
  if (!row || value === undefined) return nothing;
  const set = (/** @type {Value} */ given) => {
    const list = others();
    if (i === 0) renew({ [path]: given }, list);
    else
      renew(
        {},
        list.map((one, k) => (k === i - 1 ? { ...one, params: { ...one.params, [name]: given } } : one)),
      );
  };
  const id = i === 0 ? name : `${i}/${name}`;
  if (row.type === 'choice') {
    return html`<label class="field choice" title=${row.help}><span>${labelOf(path)}</span><select data-scene=${id}
      @change=${(/** @type {Event} */ event) => set(/** @type {HTMLSelectElement} */ (event.target).value)}>
      ${row.choices.map((one) => html`<option value=${one} .selected=${one === value}>${words(one)}</option>`)}</select></label>`;
  }
  return html`<label class="field" title=${row.help}><span>${name === 'n' ? 'Cells along a side' : name === 're' ? 'Reynolds number' : labelOf(path)}</span><input type="number"
    data-scene=${id} min=${row.min} max=${row.max} step=${row.type === 'integer' ? 1 : 'any'} .value=${String(value)}
    @change=${(/** @type {Event} */ event) => {
      const given = /** @type {HTMLInputElement} */ (event.target);
      if (given.value !== '' && given.reportValidity()) set(Number(given.value));
    }}><span class="unit">${row.unit}</span></label>`;
}

/** @returns {Template} */
function scenePanel() {
  const rows = scenarios.value.filter((row) => row.kind === 'fluid'),
    count = fluids().length;
  const set = (/** @type {number} */ wanted) => {
    const list = others();
    while (list.length < wanted - 1) list.push({ scene: params.value.scene, params: params.value.params, solver: params.value.solver });
    renew({}, list.slice(0, wanted - 1));
  };
  return html`<fieldset class="panel server" ?disabled=${locked.value !== ''}><legend class="unseen">Scene</legend>
    <label class="field choice"><span>Scene</span><select id="scene" @change=${(/** @type {Event} */ event) => choose(/** @type {HTMLSelectElement} */ (event.target).value)}>
      ${rows.map((row) => html`<option value=${row.id} .selected=${row.title === params.value?.title}>${row.title}</option>`)}</select></label>
    ${countChoice(count, 'fluid', set)}
    ${shownFields().length > 0 ? html`<div class="toggles">${toggle('cells', 'No smoothing', drawing.value.cells)}${toggle('relief', 'Relief', relief(0))}</div>` : nothing}
  </fieldset>`;
}

const shownFields = () => fluids().flatMap((_, i) => shownField(i) ?? []);

/** Settings that make the largest difference; the others stand below. */
const FIRST = [
  'method',
  'advection',
  'pressure',
  'splitting',
  'tolerance',
  'sweeps',
  'iterations',
  'viscosity',
  'viscosity_scale',
  'vorticity_confinement',
  'limiter',
];
const SOLVER_LABELS = /** @type {{[name: string]: string}} */ ({
  backtrace: 'Order of back-trace',
  cfl: 'CFL number',
  viscosity_scale: 'Viscosity ×',
});

/** The scene of a further fluid. @param {number} i @returns {Template} */
function sceneChoice(i) {
  const row = find(schema.value, `${pathOf(i)}scene`),
    now = paramsOf(i).scene;
  const set = (/** @type {Event} */ event) => {
    const scene = /** @type {HTMLSelectElement} */ (event.target).value;
    renew(
      {},
      others().map((one, k) => (k === i - 1 ? { scene } : one)),
    );
  };
  return html`<label class="field choice"><span>Scene</span><select data-scene=${`${i}/scene`} @change=${set}>
    ${(row?.choices ?? []).map((one) => html`<option value=${one} .selected=${one === now}>${words(one)}</option>`)}</select></label>`;
}

/** One fluid: parameters of its scene, its field, its solver. @param {number} i @returns {Template} */
function fluidPanel(i) {
  const at = pathOf(i),
    paths = livePaths(schema.value, `${at}solver`),
    ending = (/** @type {string} */ path) => path.slice(path.lastIndexOf('.') + 1);
  const one = (/** @type {string} */ path) =>
    SOLVER_LABELS[ending(path)] ? control(path, { label: SOLVER_LABELS[ending(path)] }) : control(path);
  const first = paths.filter((path) => FIRST.includes(ending(path))),
    rest = paths.filter((path) => !FIRST.includes(ending(path)));
  const several = fluids().length > 1;
  return html`<fieldset class="panel method" data-player=${several ? i : nothing} ?disabled=${locked.value !== ''} title=${locked.value || nothing}>
    <legend class="unseen">${several ? `Fluid ${i + 1}` : 'Fluid'}</legend>
    <div class="head"><h2>${several ? html`${mark(i)} <span>${nameOf(i)}</span>` : 'Solver'}</h2><small>${words(fluids()[i]?.method ?? '')}</small></div>
    ${i > 0 ? sceneChoice(i) : nothing}${Object.keys(paramsOf(i).params ?? {}).map((name) => sceneParameter(i, name))}${fieldChoice(i)}
    ${first.map(one)}${rest.length > 0 ? html`<details><summary>More</summary>${rest.map(one)}</details>` : nothing}</fieldset>`;
}

/** @param {'cells' | 'relief'} name @param {string} label @param {boolean} on @returns {Template} */
function toggle(name, label, on) {
  return html`<label class="toggle"><input type="checkbox" data-drawing=${name} .checked=${on} @change=${() => {
    drawing.value = { ...drawing.value, [name]: !on };
    touch();
  }}><span>${label}</span></label>`;
}

/** @param {number} i @returns {Template | typeof nothing} */
function fieldChoice(i) {
  const now = shownField(i);
  if (!now) return nothing;
  const show = (/** @type {Event} */ event) =>
    change({ [`${pathOf(i)}shown`]: Number(/** @type {HTMLSelectElement} */ (event.target).value) });
  return html`<label class="field choice" title=${now.help}><span>Field</span><select id=${i === 0 ? 'field' : `field${i}`} @change=${show}>
      ${fieldsOf(fluids()[i]).map((layer, k) => html`<option value=${k} .selected=${layer === now}>${words(layer.name)}</option>`)}</select></label>
    ${fluids().length === 1 ? html`<p class="facts">${now.help}</p>` : nothing}`;
}

// ---- numbers ----

/** Of all fluids, each name once, in the order of the first. */
const names = () => [...new Set(fluids().flatMap((one) => one.numbers))];
/** @param {number} i @param {string} name */
const cellOf = (i, name) => (i === 0 ? name : `${i}/${name}`);

/** @param {string} name @returns {Template} */
function row(name) {
  const { label, unit } = wordsOf(name);
  return html`<tr><th scope="row">${label}${unit ? ` (${unit})` : ''}</th>${fluids().map((_, i) => html`<td data-fluid=${cellOf(i, name)}>–</td>`)}</tr>`;
}

/** @param {string} caption @param {Template[]} rows @returns {Template | typeof nothing} */
function table(caption, rows) {
  if (rows.length === 0) return nothing;
  const heads =
    fluids().length > 1
      ? html`<thead><tr><td></td>${fluids().map((_, i) => html`<th scope="col"><span class="unseen">${nameOf(i)}</span>${mark(i)}</th>`)}</tr></thead>`
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
  const step = (/** @type {number} */ i) => costs.value[i]?.all;
  const pace = fluid()?.hz ?? 60;
  return html`${table('Cost', [
    html`<tr><th scope="row">step (ms)</th>${each((i) => (step(i) === undefined ? '–' : short(Number(step(i)))), 'step-ms')}</tr>`,
    html`<tr><th scope="row">processor per second (ms)</th>${each((i) => (step(i) === undefined ? '–' : short(Number(step(i)) * pace)), 'second-ms')}</tr>`,
    html`<tr><th scope="row">frames per second</th><td id="fps" colspan=${fluids().length}>–</td></tr>`,
  ])}
    ${table('Errors', of(0))}${table('Conserved and measured', of(1))}
    ${of(2).length > 0 ? html`<details><summary>More values</summary>${table('', of(2))}</details>` : nothing}`;
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
  const name = `${wordsOf(plottedName(i)).label} over time`;
  const set = (/** @type {Event} */ event) => {
    plotted.value = plotted.value.map((one, k) => (k === i ? /** @type {HTMLSelectElement} */ (event.target).value : one));
  };
  return html`<section class="plotbox" aria-label=${name}><div class="view"><canvas id=${`plot${i}`} role="img" aria-label=${name}></canvas>
    <select class="plotted" aria-label=${`Plot ${i + 1} shows`} @change=${set}>${names().map(
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
  const step = costs.value[i]?.all;
  const label = `${fluids()[i]?.title ?? 'Fluid'}${fluids().length > 1 ? `, ${nameOf(i)}` : ''}. Drag the fluid with the mouse or a finger. Arrow keys move a pointer, Enter presses and releases.`;
  return html`<figure class="drawing"><figcaption>${fluids().length > 1 ? html`${mark(i)} <b>${nameOf(i)}</b>` : nothing}
      <span>${wordsOf(errorOf(i)).label} <output data-error=${i}>–</output></span><span>${step === undefined ? '–' : short(step)} ms/step</span></figcaption>
    <div class="view stir" role="group" tabindex="0" data-world=${i} aria-label=${label}
      @pointerdown=${press} @pointermove=${move} @pointerup=${release} @pointercancel=${release} @keydown=${key}>
      <canvas id=${idOf(i)} role="img" aria-label="Fluid"></canvas></div></figure>`;
}

/** @returns {Template} */
export function fluidLab() {
  const at = fluid();
  return html`<main class="step fluid" id="views" tabindex="-1">
    <div class="methods" aria-label="Scene and solvers" role="group">${scenePanel()}${fluids().map((_, i) => fluidPanel(i))}</div>
    <div class="drawings" tabindex="0" role="region" aria-label="Views">
      <section class="stage" aria-label="Fluids" data-count=${fluids().length}>${fluids().map((_, i) => drawingOf(i))}</section>
      <div class="plots">${plot(0)}${plot(1)}${
        hasProfiles()
          ? html`<section class="plotbox" aria-label="Profiles"><div class="view">
        <canvas id="profiles" role="img" aria-label="Profiles"></canvas></div></section>`
          : nothing
      }</div>
    </div>
    <aside class="side" aria-label="Numbers">
      <div class="about"><h2>${params.value?.paper ? `${params.value.paper}: ` : ''}${params.value?.title ?? ''}</h2>
        ${params.value?.text ? html`<p>${params.value.text}</p>` : nothing}</div>
      ${workPrecisionButton()}${numbers()}
      <div class="about"><p>${at?.help ?? ''}</p>${at?.source ? html`<p>Reference: ${at.source}</p>` : nothing}
        ${(at?.notices ?? []).map((/** @type {string} */ text) => html`<p role="note"><strong>Warning.</strong> ${text}</p>`)}</div>
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
      const ys = records[i]?.numbers[one.numbers.indexOf(name)],
        own = paintOf(colours, several ? i : p);
      return ys
        ? [{ xs: records[i]?.t ?? [], ys: size ? ys.map(Math.abs) : ys, colour: own.text, ...(several ? { dash: own.dash } : {}) }]
        : [];
    });
    const empty = lines.some(({ ys }) => ys.length < 2 || ys.some((v) => v !== 0)) ? 'Play to draw' : 'all is 0';
    onto(`plot${p}`, (s) => drawPlot(s, colours, { lines, x: 't (s)', y: unit, logY: size, least: 1e-9, empty }));
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
    colour: paintOf(colours, several ? i : Math.max(0, own.indexOf(name.replace('_reference', '')))).text,
    ...(known ? { points: true, width: 1, dash: [2, 3] } : several ? { dash: paintOf(colours, i).dash } : {}),
  }));
  const known = shown.some((one) => one.known) ? '; dots: known' : '';
  onto('profiles', (s) => drawPlot(s, colours, { lines, x: 'place', y: `${own.join(', ')}${known}`, least: 1e-9, empty: '' }));
}

let numbered = 0,
  counted = 0,
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

/** @param {Frame} frame @param {import('./decode.js').Fluid} now @param {number} i @param {import('../../draw/palette.js').Palette} colours */
function drawOne(frame, now, i, colours) {
  const of = /** @type {FluidLayout} */ (fluids()[i]);
  const points = now.points.map((list) => {
    const layer = of.layers[list.layer];
    return { of: list, columns: layer?.columns ?? [], line: layer !== undefined && isSurface(layer) };
  });
  onto(idOf(i), (surface) => {
    cameras.set(
      i,
      drawScene(surface, colours, {
        view: of.view,
        field: now.field,
        points,
        ...coloured(now, i, frame.seq),
        water: isWater(now, i),
        cells: drawing.value.cells,
        relief: relief(i),
        hand: pointerIn(i),
        note: now.state.status === 1 ? 'Diverged and stopped' : '',
      }),
    );
  });
}

/** @param {FluidLayout} of @param {import('./decode.js').State} state @param {number} time */
function describe(of, { numbers: values, status }, time) {
  const wrong = of.numbers.flatMap((one, k) => (rankOf(one) === 0 ? [`${wordsOf(one).label} ${formatNumber(one, values[k] ?? NaN)}`] : []));
  return `${of.title} at ${fixed(time, 2)} s. ${[...(status === 1 ? ['Diverged and stopped'] : []), ...wrong].join(', ')}`;
}

/** @param {Frame} frame @param {boolean} settled @param {boolean} name the drawings get their descriptions */
export function drawFluid(frame, settled, name) {
  const all = fluidsOf(frame),
    at = fluids();
  if (all.length === 0 || all.length !== at.length) return;
  const colours = palette(),
    time = performance.now(),
    telling = settled || time - numbered > 120;
  measure(frame, true);
  showPace(time);
  all.forEach((now, i) => {
    const known = records[i];
    if (!known || known.generation !== frame.session.generation || known.time > frame.time_s)
      records[i] = new Record(frame.session.generation);
    if (now.state.status === 0) records[i]?.take(frame.time_s, now.state.numbers);
    drawOne(frame, now, i, colours);
    if (telling) showNumbers(i, now.state.numbers);
    if (name)
      document.getElementById(idOf(i))?.setAttribute('aria-label', describe(/** @type {FluidLayout} */ (at[i]), now.state, frame.time_s));
  });
  if (telling) {
    numbered = time;
    drawPlots(colours);
  }
}

effect(() => {
  session.value;
  forgetPointer();
  forgetMeasured();
  records = [];
  scales = new Map();
});
effect(() => {
  pointer.value;
  profiles.value;
  costs.value;
  touch();
});
