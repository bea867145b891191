// Two runs of a netgame that differ in a setting, from the same start: their views to one scale, one time, and the difference as a curve.
import { html, nothing } from '../../../../vendor/lit-html.js';
import { effect, signal, untracked } from '../../../../vendor/signals-core.js';
import { styleSheet } from '../../../base/api.js';
import { letter, typed } from '../../../base/format.js';
import { numberIn } from '../../../workbench/number_field.js';
import { toValue } from '../../../base/link.js';
import { find, valueAt } from '../../../base/schema.js';
import { link } from '../../../session/opening.js';
import { showAddress } from '../../../session/params.js';
import { locked, params, schema } from '../../../session/state.js';
import { seek } from '../../../session/time.js';
import { palette } from '../../../draw/palette.js';
import { touch } from '../../../draw/redraw.js';
import { onto } from '../../../workbench/canvas.js';
import { layout } from '../core/layout.js';
import { drawCannon } from '../views/cannon.js';
import { drawConnection } from '../views/connection.js';
import { drawField } from '../views/field.js';
import { drawRace } from '../views/race.js';
import { drawChart, spanOf } from './chart.js';
import { apart, curvesOf } from './curves.js';
import * as runs from './runs.js';
import { differing, settings } from './settings.js';
import { amount, choiceOf, nameOf, ready, say, settingOf, tipOf, tipOfCurve, valueOf, words } from './words.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('../core/frame.js').Frame} Frame */

export const { active, take } = runs;

const SIDES = /** @type {const} */ (['first', 'second']);
/** The setting that is offered for a change. */
const chosen = signal('');
/** The curve, by its column. */
const column = signal('');
/** The view: 0 of the server, 1 + p of player p. */
const view = signal(1);

const styled = styleSheet('compare');

const players = () => layout.value?.players.length ?? 0;

/** Curves that both runs have. */
function offered() {
  const [one, other] = runs.traces.value;
  return curvesOf(players()).filter((curve) => one?.columns.has(curve.column) && other?.columns.has(curve.column));
}

const curve = () => offered().find((one) => one.column === column.value) ?? offered()[0];

/** The values of both runs. @param {string} name @returns {[Float64Array, Float64Array] | null} */
function valuesOf(name) {
  const [one, other] = runs.traces.value.map((trace) => trace?.columns.get(name));
  return one && other ? [one, other] : null;
}

// ---- the address: compare=PATH:VALUE,...&curve=COLUMN&view=N&length=SECONDS ----

function remember() {
  const list = differing().map(({ path, values }) => `${path}:${encodeURIComponent(String(values[1]))}`);
  const more =
    `${column.value === '' ? '' : `&curve=${column.value}`}${view.value === 1 ? '' : `&view=${view.value}`}` +
    `${runs.length.value === runs.usual() ? '' : `&length=${runs.length.value}`}`;
  link.second = `compare${list.length > 0 ? `=${list.join(',')}` : ''}${more}`;
  showAddress();
}

function recall() {
  const given = new URLSearchParams(link.second);
  const values = (given.get('compare') ?? '').split(',').flatMap((item) => {
    const cut = item.indexOf(':');
    return cut > 0 ? [[item.slice(0, cut), toValue(item.slice(cut + 1))]] : [];
  });
  column.value = /^\w{1,64}$/.exec(given.get('curve') ?? '')?.[0] ?? '';
  view.value = Math.min(Number(/^\d$/.exec(given.get('view') ?? '')?.[0] ?? 1), players());
  chosen.value = String(values[0]?.[0] ?? 'players.0.lag_ms');
  return { values: Object.fromEntries(values), seconds: Number(/^\d{1,3}$/.exec(given.get('length') ?? '')?.[0] ?? 0) };
}

/** From the button, or from an address that says so. */
export async function begin() {
  await Promise.all([ready(), styled]);
  if (active.value) return;
  const { values, seconds } = recall();
  runs.begin(values, seconds);
}

effect(() => {
  if (active.value && runs.secondParams.value !== null && params.value !== null && !runs.working.value) untracked(remember);
});

// ---- controls ----

/** @param {number} side @returns {Template} */
const sample = (side) => html`<svg class="line" data-side=${side} viewBox="0 0 40 12" aria-hidden="true"><line x1="0" x2="40" y1="6" y2="6"
  stroke-dasharray=${side === 0 ? nothing : '7 5'}></line>${
    side === 0
      ? html`<svg><circle cx="20" cy="6" r="4.5"></circle></svg>`
      : html`<svg><rect x="15.5" y="1.5" width="9" height="9"></rect></svg>`
  }</svg>`;

/** @param {(value: string) => void} put */
const onChange = (put) => (/** @type {Event} */ event) => put(/** @type {HTMLSelectElement} */ (event.target).value);

/** The value of the chosen setting in a run. @param {0 | 1} side @returns {Template | typeof nothing} */
function valueField(side) {
  const path = chosen.value,
    row = find(schema.value, path),
    value = valueAt(side === 0 ? params.value : runs.secondParams.value, path);
  if (!row || value === undefined) return nothing;
  const put = (/** @type {any} */ given) => runs.set(side, { [path]: given });
  const label = html`<span>${sample(side)} ${say(SIDES[side])}</span>`;
  if (row.type === 'boolean' || row.type === 'choice') {
    const choices = row.type === 'boolean' ? ['true', 'false'] : row.choices;
    return html`<label class="field choice">${label}<select data-run=${side} @change=${onChange((given) =>
      put(row.type === 'boolean' ? given === 'true' : given),
    )}>${choices.map(
      (one) =>
        html`<option value=${one} .selected=${one === String(value)}>${
          row.type === 'boolean' ? say(one === 'true' ? 'on' : 'off') : choiceOf(path, one)
        }</option>`,
    )}</select></label>`;
  }
  return html`<label class="field">${label}<input class="number" inputmode="decimal" autocomplete="off" data-run=${side} data-min=${row.min}
    data-max=${row.max} .value=${typed(Number(value))} @change=${(/** @type {Event} */ event) => {
      const given = numberIn(/** @type {HTMLInputElement} */ (event.target), settingOf(path, true), row, Number(value));
      if (!Number.isNaN(given)) put(given);
    }}><span class="unit">${words.value?.units[row.unit] ?? row.unit}</span></label>`;
}

/** @param {string} at */
const partOf = (at) =>
  at.startsWith('players.') ? `${say('player')} ${letter(Number(at.slice(8)))}` : say(at === 'server' ? 'server' : 'game');

/** @returns {Template} */
function controls() {
  const choose = onChange((path) => {
    chosen.value = path;
  });
  const option = (/** @type {string} */ path) =>
    html`<option value=${path} .selected=${path === chosen.value}>${settingOf(path, true)}</option>`;
  return html`<fieldset class="change" ?disabled=${locked.value !== ''} title=${locked.value || nothing}>
    <legend class="unseen">${say('change')}</legend>
    <label class="field choice" title=${tipOf(chosen.value)}><span>${say('setting')}</span><select id="compare-setting"
      @change=${choose}>${settings().map(
        ({ at, paths }) => html`<optgroup label=${partOf(at)}>${paths.map(option)}</optgroup>`,
      )}</select></label>
    ${valueField(0)}${valueField(1)}
  </fieldset>`;
}

/** What is compared most, in one click: changes of the second run.
 * @returns {{name: string, values: Record<string, import('../../../base/link.js').Value>}[]} */
function common() {
  const can = settings().flatMap(({ paths }) => paths),
    predicts = can.filter((path) => path.endsWith('.prediction') && valueAt(params.value, path) === true);
  return [
    {
      name: 'lockstep',
      values: { 'server.sync': 'lockstep' },
      fits: can.includes('server.sync') && valueAt(params.value, 'server.sync') === 'free',
    },
    { name: 'no_prediction', values: Object.fromEntries(predicts.map((path) => [path, false])), fits: predicts.length > 0 },
  ].filter(({ fits }) => fits);
}

/** @param {ReturnType<typeof common>[number]} of @returns {Template} */
const readyButton = ({ name, values }) => html`<button type="button" class="small" data-ready=${name} ?disabled=${locked.value !== ''}
      @click=${() => runs.set(1, values)}>${say(`ready.${name}`)}</button>`;

/** A setting that differs, and what makes it equal again. @param {ReturnType<typeof differing>[number]} of @returns {Template} */
function differenceRow({ path, values }) {
  const unit = find(schema.value, path)?.unit ?? '',
    name = settingOf(path, true);
  return html`<tr><th scope="row" title=${tipOf(path)}>${name}</th>${values.map(
    (value) => html`<td>${valueOf(path, value, unit)}</td>`,
  )}<td><button type="button" class="small" ?disabled=${locked.value !== ''} aria-label=${`${say('equal')}: ${name}`}
        @click=${() => runs.set(1, { [path]: values[0] })}>${say('equal')}</button></td></tr>`;
}

/** @returns {Template} */
function differences() {
  const list = differing();
  if (list.length === 0)
    return html`<div class="differ" id="compare-differ"><p>${say('differ.none')}</p>${common().map(readyButton)}</div>`;
  return html`<div class="differ" id="compare-differ" tabindex="0" role="region" aria-label=${say('differ')}>
    <table class="data"><caption>${say('differ')}</caption>
    <thead><tr><td></td>${SIDES.map((name, side) => html`<th scope="col">${sample(side)} ${say(name)}</th>`)}<td></td></tr></thead>
    <tbody>${list.map(differenceRow)}</tbody></table></div>`;
}

/** @param {number} one */
const viewName = (one) => (one === 0 ? say('server') : `${say('player')} ${letter(one - 1)}`);

/** @returns {Template} */
function viewChoice() {
  const views = [...Array.from({ length: players() }, (_, p) => p + 1), 0];
  return html`<label class="field choice"><span>${say('view')}</span><select id="compare-view" @change=${onChange((value) => {
    view.value = Number(value);
    remember();
    touch();
  })}>${views.map((one) => html`<option value=${one} .selected=${one === view.value}>${viewName(one)}</option>`)}</select></label>`;
}

/** @returns {Template} */
function curveChoice() {
  const list = offered();
  const differs = (/** @type {string} */ name) => {
    const values = valuesOf(name);
    return values !== null && apart(...values).most > 0;
  };
  return html`<label class="field choice"><span>${say('curve')}</span><select id="compare-curve" @change=${onChange((value) => {
    column.value = value;
    remember();
    touch();
  })}>${Array.from({ length: players() }, (_, p) => p).map(
    (p) =>
      html`<optgroup label=${`${say('player')} ${letter(p)}`}>${list
        .filter(({ player }) => player === p)
        .map(
          (one) =>
            html`<option value=${one.column} .selected=${one.column === curve()?.column}>${nameOf(one, true)}${
              differs(one.column) ? '' : ` (${say('same')})`
            }</option>`,
        )}</optgroup>`,
  )}</select></label>`;
}

/** @returns {Template} */
function lengthChoice() {
  return html`<label class="field choice"><span>${say('length')}</span><select id="compare-length" ?disabled=${locked.value !== ''}
    @change=${onChange((value) => void runs.lengthen(Number(value)))}>${runs.lengths.value.map(
      (one) => html`<option value=${one} .selected=${one === runs.length.value}>${amount(one, one % 1 === 0 ? 0 : 1, 's')}</option>`,
    )}</select></label>`;
}

// ---- the page ----

/** @param {0 | 1} side @returns {Template} */
function sideView(side) {
  const name = say(SIDES[side]);
  return html`<section class="run" data-side=${side} aria-label=${name}>
    <div class="head"><h3>${sample(side)} ${name}</h3><output class="value" id=${`compare-value-${side}`} aria-live="off"></output></div>
    <div class="view"><canvas id=${`compare-view-${side}`} role="img"
      aria-label=${`${name}, ${viewName(view.value)}`}></canvas></div></section>`;
}

/** @param {PointerEvent} event */
function point(event) {
  const box = /** @type {HTMLElement} */ (event.currentTarget);
  const trace = runs.traces.value[0];
  if (trace === null || locked.value !== '' || runs.working.value || (event.type === 'pointermove' && event.buttons === 0)) return;
  if (event.type === 'pointerdown') box.setPointerCapture(event.pointerId);
  const { left, right } = spanOf(palette(), box.clientWidth);
  const part = Math.max(0, Math.min(1, (event.clientX - box.getBoundingClientRect().left - left) / (right - left)));
  seek(Math.round(part * (trace.ticks - 1)) / trace.hz);
}

/** @returns {Template} */
export function template() {
  const now = curve(),
    tip = now && tipOfCurve(now),
    hint = html`<p class="hint">${tip ? `${tip}. ` : nothing}${say('hint')}</p>`;
  return html`<main class="compare" id="views" tabindex="-1" data-fields=${layout.value?.entities.length ? 'yes' : 'no'}
    aria-busy=${runs.working.value ? 'true' : 'false'}>
    <div class="comparehead"><h2>${say('title')}</h2><p>${say('lead', { seed: String(params.value?.seed ?? 0) })}</p>
      <button type="button" id="compare-close" @click=${() => runs.close()}>${say('close')}</button></div>
    <div class="settings">${controls()}${differences()}</div>
    <div class="runs">${sideView(0)}${sideView(1)}</div>
    <section class="difference" aria-label=${say('difference')}>
      <div class="head">${viewChoice()}${curveChoice()}${lengthChoice()}${hint}</div>
      <div class="view" id="compare-time" @pointerdown=${point} @pointermove=${point}><canvas id="compare-chart" role="img"
        aria-label=${`${say('difference')}${now ? `: ${nameOf(now, true)}` : ''}`}></canvas></div>
      <p id="compare-sentence"></p>
    </section></main>`;
}

// ---- drawing ----

/** @param {number} side @param {Frame} frame @param {import('../core/memory.js').Memory} memory */
function drawSide(side, frame, memory) {
  const shape = layout.value;
  if (!shape || !frame.views[view.value]) return;
  onto(`compare-view-${side}`, (surface) => {
    /** @type {import('../views/scene.js').DrawContext} */
    const at = {
      pen: surface.pen,
      width: surface.width,
      height: surface.height,
      colours: palette(),
      frame,
      memory,
      layout: shape,
      view: view.value,
      overlays: { ghosts: true, dots: false, labels: true },
      unit: 'm',
      only: null,
      staged: null,
      run: null,
      first: null,
      picked: null,
    };
    if (shape.entities.length > 0) drawField(at);
    else if (shape.controls === 'aim') drawCannon(at);
    else drawRace(at);
    if (view.value > 0) drawConnection(at);
  });
}

/** The difference in words and numbers. @param {import('./curves.js').Curve} of @param {[Float64Array, Float64Array]} values
 * @param {number} tick @param {number} hz */
function sentence(of, values, tick, hz) {
  const { mean, most, at } = apart(...values),
    [one = NaN, other = NaN] = values.map((list) => list[tick]);
  const time = (/** @type {number} */ k) => amount(k / hz, 2, 's');
  const facts = {
    curve: nameOf(of, true),
    time: time(tick),
    end: amount((values[0].length - 1) / hz, 0, 's'),
    first: amount(one, of.digits, of.unit),
    second: amount(other, of.digits, of.unit),
    gap: amount(Math.abs(other - one), of.digits, of.unit),
    mean: amount(mean, Math.max(1, of.digits), of.unit),
    most: amount(most, of.digits, of.unit),
    at: time(at),
  };
  if (most === 0) return say(differing().length === 0 ? 'sentence.alike' : 'sentence.same', facts);
  if (!Number.isFinite(other - one)) return say('sentence.past', facts);
  return say(other > one ? 'sentence.more' : other < one ? 'sentence.less' : 'sentence.equal', facts);
}

/** @param {string} id @param {string} text */
function put(id, text) {
  const element = document.getElementById(id);
  if (element && element.textContent !== text) element.textContent = text;
}

const WORDS_MS = 120;
let told = 0;

/** @param {boolean} settled */
export function draw(settled) {
  const now = runs.newest();
  if (now === null) {
    put('compare-sentence', say('wait'));
    return;
  }
  now.frames.forEach((frame, side) => drawSide(side, frame, /** @type {import('../core/memory.js').Memory} */ (now.memories[side])));
  const of = curve(),
    values = of && valuesOf(of.column),
    hz = runs.traces.value[0]?.hz ?? 60,
    tick = now.frames[0].tick;
  if (!of || !values) return;
  const [one = NaN, other = NaN] = values.map((list) => list[tick]);
  onto('compare-chart', (surface) =>
    drawChart(surface, palette(), {
      values,
      hz,
      tick,
      number: (value) => amount(value, Math.abs(value) < 10 && of.digits > 0 && value !== 0 ? 1 : 0, of.unit),
      time: amount(tick / hz, 2, 's'),
      gap: one === other ? '' : say('gap', { gap: amount(Math.abs(other - one), of.digits, of.unit) }),
    }),
  );
  const time = performance.now();
  if (!settled && time - told < WORDS_MS) return;
  told = time;
  [one, other].forEach((value, side) => put(`compare-value-${side}`, `${nameOf(of, true)} ${amount(value, of.digits, of.unit)}`));
  put('compare-sentence', sentence(of, values, tick, hz));
}

/** What both views show now: for tests and for the curious. */
export function facts() {
  const now = runs.newest();
  return {
    active: active.value,
    working: runs.working.value,
    second: runs.idOf(),
    ticks: now?.frames.map(({ tick }) => tick) ?? [],
    params: structuredClone(runs.secondParams.value),
    traces: runs.traces.value.map((trace) => trace?.ticks ?? 0),
  };
}
