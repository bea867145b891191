// The collide lab: rigid bodies, what the phases of a step make of them, and solvers side by side from the same start.
import { html, nothing } from '../../../vendor/lit-html.js';
import { effect, signal } from '../../../vendor/signals-core.js';
import { fixed, localized, signed, typed } from '../../base/format.js';
import { find } from '../../base/schema.js';
import { change } from '../../session/params.js';
import { recall } from '../../workbench/past.js';
import { choose } from '../../session/session.js';
import { titleOf } from '../../session/scenario_words.js';
import { camera, firstRun, frame as shownFrame, layout, locked, look, params, scenarios, schema, session } from '../../session/state.js';
import { palette, paintOf } from '../../draw/palette.js';
import { drawPlot } from '../../draw/plot.js';
import { textTurn, touch } from '../../draw/redraw.js';
import { partTabs, shownPart } from '../../workbench/phone_parts.js';
import { aboutScenario } from '../../workbench/about.js';
import { said } from '../../workbench/said.js';
import { inTurn, onto, plotBox } from '../../workbench/canvas.js';
import { control } from '../../workbench/controls.js';
import { numberIn } from '../../workbench/number_field.js';
import { costs, forget as forgetMeasured, measure } from '../../workbench/measure.js';
import { opening } from '../../workbench/opening.js';
import { mark } from '../../workbench/player_mark.js';
import { PointerDrag } from '../../workbench/pointer_drag.js';
import { countChoice, difference, paramsOf, pathOf, renew as renewSideBySide } from '../../workbench/side_by_side.js';
import { tradeoffButton, workPrecisionButton } from '../../workbench/work_precision.js';
import { VOLUMES, sceneOf } from './decode.js';
import { drawWorld } from './drawing.js';
import { Record, recordOf } from './record.js';
import { called, inputOf, language, t } from '../../base/words.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('../../stream/frame.js').Frame} Frame */
/** @typedef {import('./decode.js').Scene} Scene */
/** @typedef {import('./decode.js').World} World */
/** @typedef {{scene: string, title: string, help: string, worlds: number, hz: number, view: number[],
 *   solvers: {name: string, help: string}[]}} RigidLayout  view: left, right, bottom, top in m */

let record = new Record(-1);

/** What is drawn over the bodies. @type {import('@preact/signals-core').Signal<import('./drawing.js').Shown>} */
const shown = signal({ volumes: false, boxes: false, pairs: false, contacts: true, paths: false, islands: false });
/** The volume of the overlay: that of the solver, or always the same; 0: all. */
const overlaid = signal(0);

/** @returns {RigidLayout | null} */
const rigid = () => layout.value?.given.rigid ?? null;
const drag = new PointerDrag(() => rigid()?.view ?? []);
const words = (/** @type {string} */ name) => called('rigid', name);
/** A setting's name within a sentence, where English has no capitals. @param {string} name */
const settingOf = (name) => (language.value === 'en' ? words(name) : (inputOf('rigid', `solver.${name}`)?.label ?? words(name)));
const worlds = () => Array.from({ length: rigid()?.worlds ?? 0 }, (_, i) => i);
/** @param {number} world */
const solverOf = (world) => paramsOf(world).solver ?? {};
/** @param {number} world */
const methodOf = (world) => String(solverOf(world).method ?? '');

/** Name of a world: the solver, or where it is the same the settings that differ. @param {number} world */
function nameOf(world) {
  const one = solverOf(world),
    method = words(methodOf(world));
  const alike = worlds()
    .filter((i) => i !== world && methodOf(i) === methodOf(world))
    .map(solverOf);
  const differ = Object.keys(one).filter((name) => alike.some((other) => one[name] !== other[name]));
  return [
    method,
    ...differ
      .slice(0, 2)
      .map((name) =>
        one[name] === true || one[name] === false
          ? t(one[name] ? 'rigid.on' : 'rigid.off', { name: settingOf(name) })
          : `${settingOf(name)} ${words(String(one[name]))}`,
      ),
  ].join(', ');
}

// ---- controls ----

/** What each solver does with its passes. */
const PASSES = /** @type {{[name: string]: string[]}} */ ({
  impulse: ['iterations'],
  pgs: ['iterations', 'baumgarte'],
  pgs_ngs: ['iterations', 'position_iterations', 'baumgarte'],
  soft_step: ['substeps', 'contact_hertz', 'contact_damping_ratio'],
  tgs_sticky: ['substeps'],
  xpbd: ['substeps'],
  avbd: ['iterations'],
});

/** @param {number} world @returns {Template} */
function solverPanel(world) {
  const at = `${pathOf(world)}solver`,
    own = PASSES[methodOf(world)] ?? [];
  return html`<fieldset class="panel method" data-player=${world} ?disabled=${locked.value !== ''} title=${locked.value || nothing}>
    <legend class="unseen">${worlds().length > 1 ? t('rigid.solver_n', { n: world + 1 }) : t('rigid.solver')}</legend>
    <div class="head"><h2>${mark(world)} ${nameOf(world)}</h2></div>
    ${control(`${at}.method`)}
    ${own.map((name) => control(`${at}.${name}`))}
    ${control(`${at}.continuous`)}
    ${control(`${at}.bounding_volume`)}
    <div class="toggles">${control(`${at}.warm_start`)}${control(`${at}.recycle`)}
      ${control(`${at}.sleep`)}</div>
    <details><summary>${t('workbench.more')}</summary>${[
      'contact_push_speed',
      'restitution_threshold',
      'joint_hertz',
      'joint_damping_ratio',
      'recycle_distance',
      'sleep_threshold',
      'simd',
    ].map((name) => control(`${at}.${name}`))}</details>
  </fieldset>`;
}

/** @param {{[path: string]: import('../../base/link.js').Value}} set @param {number} [count] of worlds */
function renew(set, count = worlds().length) {
  const list = Array.from({ length: count - 1 }, (_, i) => ({
    solver: difference(i + 1 < worlds().length ? solverOf(i + 1) : solverOf(0), solverOf(0)),
  }));
  renewSideBySide(set, list);
}

const GRAVITIES = [
  [0, -10, 'earth'],
  [0, -1.6, 'moon'],
  [0, -22, 'strong'],
  [0, 0, 'none'],
  [10, 0, 'right'],
];

/** @returns {Template} */
function gravity() {
  const now = params.value?.gravity ?? [0, 0];
  const known = GRAVITIES.findIndex(([x, y]) => x === now[0] && y === now[1]);
  return html`<label class="field choice"><span>${t('rigid.gravity')}</span><select id="gravity" @change=${(/** @type {Event} */ event) => {
    const one = GRAVITIES[Number(/** @type {HTMLSelectElement} */ (event.target).value)];
    if (one) change({ gravity: /** @type {any} */ ([one[0], one[1]]) });
  }}>${known < 0 ? html`<option value="-1" selected>${now.join(', ')} m/s²</option>` : nothing}
    ${GRAVITIES.map(
      ([, , name], i) => html`<option value=${i} .selected=${i === known}>${t(`rigid.gravity.${name}`)}</option>`,
    )}</select></label>`;
}

/** Parameter of a scene: a change creates another session. @param {string} name @returns {Template | typeof nothing} */
function sceneParameter(name) {
  const row = find(schema.value, `params.${name}`),
    value = params.value?.params?.[name],
    named = inputOf('rigid', `params.${name}`);
  if (!row || value === undefined) return nothing;
  return html`<label class="field" title=${named?.tip ?? row.help}><span>${named?.label ?? words(name)}</span><input class="number"
    inputmode="decimal" autocomplete="off" data-scene=${name} data-min=${row.min} data-max=${row.max}
    .value=${value === 0 ? '' : typed(Number(value))} placeholder=${t('rigid.default')}
    @change=${(/** @type {Event} */ event) => {
      const field = /** @type {HTMLInputElement} */ (event.target),
        given = field.value.trim() === '' ? 0 : numberIn(field, named?.label ?? words(name), row, Number(value));
      if (!Number.isNaN(given)) renew({ [`params.${name}`]: given });
    }}></label>`;
}

/** @returns {Template} */
function scenePanel() {
  const rows = scenarios.value.filter((row) => row.kind === 'rigid');
  return html`<fieldset class="panel server" ?disabled=${locked.value !== ''}><legend class="unseen">${t('workbench.scene')}</legend>
    <label class="field choice"><span>${t('workbench.scene')}</span><select id="scene"
      @change=${(/** @type {Event} */ event) => choose(/** @type {HTMLSelectElement} */ (event.target).value)}>
      ${rows.map(
        (row) => html`<option value=${row.id}
        .selected=${row.title === params.value?.title}>${titleOf(row)}</option>`,
      )}</select></label>
    ${countChoice(worlds().length, 'rigid.count', (wanted) => renew({}, wanted))}
    ${gravity()}
    ${control('broad_phase')}
    ${control('compare_volumes')}
    ${
      rigid()?.scene === 'none'
        ? nothing
        : html`<details><summary>${t('rigid.rebuild')}</summary>
      ${['size', 'ratio', 'offset', 'speed', 'friction'].map(sceneParameter)}</details>`
    }
  </fieldset>`;
}

/** @param {keyof import('./drawing.js').Shown} name @returns {Template} */
function overlay(name) {
  return html`<label class="toggle"><input type="checkbox" data-overlay=${name} .checked=${shown.value[name]} @change=${() => {
    shown.value = { ...shown.value, [name]: !shown.value[name] };
    touch();
  }}><span>${t(`rigid.overlay.${name}`)}</span></label>`;
}

/** @returns {Template} */
function overlayPanel() {
  const name = t('rigid.overlays');
  return html`<fieldset class="panel plainpanel"><legend class="unseen">${name}</legend><div class="head"><h2>${name}</h2></div>
    <div class="toggles">${overlay('contacts')}${overlay('islands')}${overlay('pairs')}
      ${overlay('boxes')}${overlay('paths')}${overlay('volumes')}</div>
    ${
      shown.value.volumes
        ? html`<label class="field choice"><span>${t('rigid.volume')}</span><select id="overlaid" @change=${(
            /** @type {Event} */ event,
          ) => {
            overlaid.value = Number(/** @type {HTMLSelectElement} */ (event.target).value);
            touch();
          }}>${[t('rigid.all_volumes'), ...VOLUMES.slice(1)].map(
            (name, i) => html`<option value=${i}
            .selected=${i === overlaid.value}>${name}</option>`,
          )}</select></label>`
        : nothing
    }
  </fieldset>`;
}

// ---- numbers ----

const NUMBERS = /** @type {[string, (w: World) => string][]} */ ([
  ['energy', (w) => joules(w.energy - w.energy_start)],
  ['penetration', (w) => fixed(1000 * w.penetration, 2)],
  ['worst', (w) => fixed(1000 * w.penetration_worst, 1)],
  ['sag', (w) => fixed(100 * w.sag, 1)],
  ['drift', (w) => fixed(100 * w.drift, 1)],
  ['tilt', (w) => fixed((180 / Math.PI) * w.tilt, 1)],
  ['joints', (w) => (w.joints > 0 ? fixed(1000 * w.joint_error, 1) : '–')],
  ['pairs', (w) => String(w.pairs)],
  ['contacts', (w) => String(w.touching)],
  ['recycled', (w) => String(w.recycled)],
  ['awake', (w) => t('rigid.of', { n: w.awake, all: w.bodies })],
  ['stopped', (w) => String(w.stopped)],
]);

/** @param {number} value */
const joules = (value) => (Math.abs(value) >= 1e5 ? localized(value.toExponential(1)) : signed(value, Math.abs(value) < 10 ? 3 : 1));

/** @returns {Template} */
function numbers() {
  return html`<div class="wide-table" tabindex="0" role="region" aria-label=${t('workbench.current')}><table class="data now"
    data-shows="table"><caption>${t('workbench.now')}</caption>
    <thead><tr><td></td>${worlds().map((i) => html`<th scope="col">${mark(i)} ${nameOf(i)}</th>`)}</tr></thead>
    <tbody>${NUMBERS.map(
      ([name]) => html`<tr><th scope="row">${t(`rigid.number.${name}`)}</th>
      ${worlds().map((i) => html`<td data-rigid=${`${i}/${name}`}>–</td>`)}</tr>`,
    )}</tbody></table></div>`;
}

/** How many bodies tunnelled, of all that fly. @returns {Template | typeof nothing} */
function tunnellingMeter() {
  if (!(Math.abs(params.value?.tunnel_x ?? 1e9) < 1e8)) return nothing;
  return html`<section class="meter" aria-label=${t('rigid.tunnelling')}><h3>${t('rigid.tunnelled')}</h3>
    ${worlds().map(
      (i) => html`<div class="passed">${mark(i)}<div class="track"><div class="fill" data-player=${i} data-fill=${i}></div></div>
      <span data-rigid=${`${i}/tunnelled`}>–</span></div>`,
    )}</section>`;
}

const JUDGED = ['hits', 'false', 'missed', 'gap'],
  JUDGED_HEADS = ['hits', 'false', 'missed', 'at', 'cost'];

/** Time of a volume for all pairs of a step. @param {number | undefined} ms */
const perStep = (ms) => (ms === undefined ? '–' : fixed(1000 * ms, 2));

/** @returns {Template | typeof nothing} */
function volumeTable() {
  if (!params.value?.compare_volumes) return nothing;
  const heads = JUDGED_HEADS.map((what) => html`<th scope="col">${t(`rigid.judged.${what}`)}</th>`);
  const row = (/** @type {string} */ name, /** @type {number} */ v) => html`<tr><th scope="row">${name}</th>
      ${JUDGED.map((what) => html`<td data-rigid=${`volume${v}/${what}`}>–</td>`)}<td
        data-volume=${name}>${perStep(costs.value[0]?.[`volume_${name}`])}</td></tr>`;
  return html`<table class="data judged"><caption>${t('rigid.bounding')}</caption><thead><tr><td></td>${heads}</tr></thead>
    <tbody>${VOLUMES.map(row)}</tbody></table>`;
}

const PHASES = ['broad', 'narrow', 'solve', 'continuous', 'finish', 'all'];

/** What the daemon's processor spends on a step, phase by phase. @returns {Template} */
function phases() {
  const most = Math.max(1e-9, ...costs.value.map((part) => part.all ?? 0));
  return html`<section class="plotbox" aria-label=${t('rigid.cost')}><div class="view phases" tabindex="0" role="group"
    aria-label=${t('rigid.cost')}><take-away data="phases" name=${t('rigid.cost')}></take-away><table
    class="data"><caption>${t('rigid.ms_per_step')}</caption>
    <tbody>${PHASES.map(
      (name) =>
        html`<tr><th scope="row">${t(`rigid.phase.${name}`)}</th>${worlds().map((i) => {
          const ms = costs.value[i]?.[name];
          return html`<td data-phase=${`${i}/${name}`}><span>${ms === undefined ? '–' : fixed(ms, 3)}</span><svg data-player=${i}
            viewBox="0 0 100 1" preserveAspectRatio="none" aria-hidden="true"><rect
        width=${ms === undefined ? 0 : Math.min(100, (100 * ms) / most)} height="1"></rect></svg></td>`;
        })}</tr>`,
    )}</tbody></table></div></section>`;
}

// ---- the page ----

/** @param {number} world @returns {Template} */
function drawing(world) {
  const label = `${t('rigid.world', { name: nameOf(world) })}. ${t('rigid.drag')}`;
  const canvas = html`<canvas id=${`world${world}`} role="img" aria-label=${t('rigid.world', { name: nameOf(world) })}></canvas><take-away
    name=${t('rigid.world', { name: nameOf(world) })}></take-away>`;
  return drag.box(world, 'drag', label, canvas);
}

/** @returns {Template} */
function template() {
  const used = rigid()?.solvers.filter((one) => worlds().some((i) => methodOf(i) === one.name)) ?? [];
  return html`${partTabs()}<main class="step collide" id="views" tabindex="-1" data-part=${shownPart.value}>
    <div class="methods" tabindex=${locked.value === '' ? nothing : 0} aria-label=${t('workbench.scene_and_solvers')}
      role="group">${scenePanel()}${worlds().map(solverPanel)}${overlayPanel()}</div>
    <div class="drawings" tabindex="0" role="region" aria-label=${t('workbench.views')}>
      ${opening(t('rigid.see'))}
      <section class="worlds" data-shows="positions walls tilt volumes path" aria-label=${t('rigid.worlds')}
        data-worlds=${worlds().length}>${worlds().map(drawing)}</section>
      <div class="plots">${plotBox('plot-energy', t('workbench.energy_t'), 'energy')}${plotBox(
        'plot-overlap',
        t('rigid.overlap_t'),
        'overlap',
      )}${phases()}</div>
    </div>
    <aside class="side" aria-label=${t('workbench.numbers')}>
      <div class="about">${aboutScenario()}</div>
      ${workPrecisionButton()}${tradeoffButton('contact_solvers')}${tunnellingMeter()}${numbers()}${volumeTable()}
      ${used.map((one) => html`<div class="about"><h3>${words(one.name)}</h3><p>${said(one.help)}</p></div>`)}
    </aside></main>`;
}

// ---- drawing ----

/** @param {string} name @param {string} text */
function put(name, text) {
  const cell = document.querySelector(`[data-rigid="${name}"]`);
  if (cell && cell.textContent !== text) cell.textContent = text;
}

/** @param {Scene} scene */
function showNumbers(scene) {
  scene.worlds.forEach((one, i) => {
    for (const [name, text] of NUMBERS) put(`${i}/${name}`, one.status === 1 && name === 'energy' ? t('workbench.diverged') : text(one));
    const flying = params.value?.scene === 'bullets_loose' ? one.dynamic / 2 : one.dynamic; /* there the walls can move too */
    put(`${i}/tunnelled`, t('rigid.of', { n: one.tunnelled, all: flying }));
    const fill = document.querySelector(`[data-fill="${i}"]`);
    if (fill instanceof HTMLElement) fill.style.width = `${flying > 0 ? (100 * one.tunnelled) / flying : 0}%`;
  });
  for (const one of scene.judged) {
    if (one.world !== 0) continue;
    put(`volume${one.volume}/hits`, String(one.hits));
    put(`volume${one.volume}/false`, String(one.false_hits));
    put(`volume${one.volume}/missed`, String(one.missed_hits));
    put(`volume${one.volume}/gap`, one.false_hits > 0 ? fixed(100 * one.gap_max, 1) : '–');
  }
}

/** What a world shows, in words. @param {World} w @param {number} i */
const describe = (w, i) =>
  w.status === 1
    ? t('rigid.summary_diverged', { name: nameOf(i) })
    : t('rigid.summary', {
        name: nameOf(i),
        bodies: w.bodies,
        awake: w.awake,
        contacts: w.touching,
        overlap: fixed(1000 * w.penetration, 1),
        energy: joules(w.energy - w.energy_start),
      });

const NARROW = 500; /* px */

/** As a lesson wants it: closer, around the middle. @param {number[]} view @param {number} width px */
function viewOf(view, width) {
  const [left = 0, right = 1, bottom = 0, top = 1] = view,
    wide = camera.value === null ? right - left : width < NARROW ? camera.value.narrow_m : camera.value.m,
    part = wide / (right - left) / 2;
  const x = (left + right) / 2,
    y = (bottom + top) / 2;
  return [x - part * (right - left), x + part * (right - left), y - part * (top - bottom), y + part * (top - bottom)];
}

const telling = textTurn(100);

/** @param {Frame} frame @param {boolean} settled @param {boolean} name the drawings get their descriptions */
function draw(frame, settled, name) {
  const at = rigid();
  if (!at) return;
  const scene = sceneOf(frame),
    colours = palette();
  if (record.generation !== frame.session.generation || record.time > frame.time_s) record = new Record(frame.session.generation);
  if (record.meet(frame.time_s, frame.tickHz)) record.take(frame.time_s, scene.worlds);
  recall(record, settled, 'worlds', (rows) => recordOf(rows, scene.worlds.length));
  record.sweep(frame.tick, scene.shapes, 1 / at.hz);
  measure(frame, false);
  const first = look.value?.step === 5 && firstRun.value !== null ? sceneOf(firstRun.value) : null;
  for (const i of worlds()) {
    const of = {
      world: i,
      view: at.view,
      shown: shown.value,
      volume: overlaid.value,
      dt: 1 / at.hz,
      beyond: params.value?.tunnel_x ?? 1e9,
      name: scene.worlds[i]?.status === 1 ? `${nameOf(i)}: ${t('workbench.diverged')}` : nameOf(i),
      first,
      places: [...record.places.values()].filter((places) => places[0]?.world === i),
      pointer: drag.pointer.value,
    };
    onto(`world${i}`, (surface) =>
      drag.cameras.set(i, drawWorld(surface, colours, scene, { ...of, view: viewOf(at.view, surface.width) })),
    );
  }
  if (telling(settled)) {
    showNumbers(scene);
  }
  const lines = (/** @type {'energy' | 'penetration'} */ what, /** @type {number} */ scale) =>
    record.tracks.map((track, i) => ({
      xs: track.t.slice(),
      ys: track[what].map((v) => v * scale),
      name: nameOf(i),
      colour: paintOf(colours, i).text,
      dash: paintOf(colours, i).dash,
    }));
  inTurn('plot-energy', settled, (s) =>
    drawPlot(s, colours, {
      lines: lines('energy', 1),
      x: 't (s)',
      y: t('rigid.energy_axis'),
      least: 0.01,
      empty: t('workbench.play_to_draw'),
    }),
  );
  inTurn('plot-overlap', settled, (s) =>
    drawPlot(s, colours, {
      lines: lines('penetration', 1000),
      x: 't (s)',
      y: t('rigid.overlap_axis'),
      least: 0.01,
      empty: t('workbench.play_to_draw'),
    }),
  );
  if (name) scene.worlds.forEach((w, i) => document.getElementById(`world${i}`)?.setAttribute('aria-label', describe(w, i)));
}

effect(() => {
  session.value;
  forgetMeasured();
});

/** Where bodies may pass a wall, their ways are drawn. @param {boolean} fresh */
function begin(fresh) {
  if (!fresh) return;
  const { tunnel_x = 1e9, compare_volumes = false } = layout.value?.params ?? {};
  shown.value = { ...shown.value, paths: Math.abs(tunnel_x) < 1e8, volumes: compare_volumes };
}

/** Contacts are most of what bodies are streamed with. */
const rates = () => ({ contacts: shown.value.contacts || shown.value.pairs ? 60 : 0 });

/** @type {import('../../session/lab.js').Lab} */
export const lab = {
  hint: () => 'drag',
  template,
  begin,
  draw,
  rates,
  facts: () => ({
    remembered: { get: () => record.tracks.map(({ t }) => t) },
    scene: { get: () => shownFrame.value && sceneOf(shownFrame.value) },
    drag: { value: drag },
  }),
  tables: async () => ({
    phases: () => ({
      columns: [{ name: 'part', unit: '' }, ...worlds().map((i) => ({ name: nameOf(i), unit: 'ms' }))],
      rows: PHASES.map((name) => [t(`rigid.phase.${name}`), ...worlds().map((i) => costs.value[i]?.[name] ?? null)]),
    }),
  }),
};
