// The page as a template: everything that changes seldom. What changes per frame is drawn by loop.js.
import { html, nothing, render } from '../../vendor/lit-html.js';
import { effect, signal } from '../../vendor/signals-core.js';
import { part } from '../base/api.js';
import { timeBar } from './bar.js';
import { sync } from '../workbench/controls.js';
import { fixed, letter } from '../base/format.js';
import { header } from './header.js';
import { icons } from '../workbench/icons.js';
import { mark, messagesPanel, nameOf, playerPanel, serverPanel } from '../labs/netgame/lab/panels.js';
import { pads } from '../labs/netgame/lab/pads.js';
import { side } from '../labs/netgame/lab/side.js';
import { experiment, layout, notice, open, overlays, params, tab } from '../session/state.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('../session/state.js').Tab} Tab */

/** The views from top to bottom: the first player, the server, the other players. @returns {number[]} */
export function order() {
  const players = layout.value?.players.length ?? 2;
  return [1, 0, ...Array.from({ length: Math.max(0, players - 1) }, (_, i) => 2 + i)];
}

/** @param {number} player @returns {string} */
function techniques(player) {
  const p = params.value?.players?.[player];
  if (!p) return '';
  const on = ['prediction', 'reconciliation', 'interpolation']
    .filter((name) => p[name])
    .map((name) => name.slice(0, name === 'prediction' ? 4 : name === 'reconciliation' ? 5 : 6));
  return `${fixed(p.lag_ms, 0)} ms${on.length > 0 ? ` · ${on.join(', ')}` : ' · plain'}`;
}

/** The line above a view on a phone: opens its settings. @param {number} view @returns {Template} */
function caption(view) {
  if (view === 0) {
    const server = params.value?.server;
    return html`<button type="button" class="caption" @click=${() => open({ kind: 'server' })}>
      <svg class="mark" data-player="server" viewBox="0 0 18 18" aria-hidden="true"><path d="M9 1l8 8-8 8-8-8z"></path></svg>
      <b>Server</b> <span>${server ? `${server.update_hz}/s · ${server.sync}` : ''}</span>${icons.settings}</button>`;
  }
  return html`<button type="button" class="caption" data-player=${(view - 1) % 8} @click=${() => open({ kind: 'player', player: view - 1 })}>
    ${mark(view - 1)} <b>${nameOf(view - 1)}</b> <span>${techniques(view - 1)}</span>${icons.settings}</button>`;
}

/** @param {number} view @returns {Template} */
function row(view) {
  const player = view - 1;
  const label = view === 0 ? 'View of the server' : `View of ${nameOf(player)}`;
  const keys = view === 0 ? '' : player === 0 ? ' Left and right arrow keys drive.' : player === 1 ? ' Keys A and D drive.' : '';
  return html`<section class="row" data-tab=${`view${view}`} aria-label=${view === 0 ? 'Server' : nameOf(player)}>
    <div class="gutter">${view === 0 ? serverPanel() : playerPanel(player)}</div>
    ${caption(view)}
    <div class="view" role="group" tabindex=${view > 0 ? '0' : nothing} data-drive=${view > 0 ? player : nothing} aria-label=${`${label}.${keys}`}>
      <canvas data-view=${view} role="img" aria-label=${label}></canvas></div>
    ${view > 0 ? pads(player) : nothing}
  </section>`;
}

/** @returns {Template} */
function messages() {
  return html`<section class="row lane" data-tab="messages" aria-label="Messages" ?hidden=${!overlays.value.messages}>
    <div class="gutter">${messagesPanel()}</div>
    <div class="view" role="group" tabindex="0" data-arrows="yes"
      aria-label="Messages between players and server. Left and right arrow keys select an input and show its path.">
      <canvas id="lane" role="img" aria-label="Messages over time"></canvas></div></section>`;
}

/** On a phone: what the one column shows. @returns {Template} */
function tabs() {
  const item = (/** @type {Tab} */ name, /** @type {string} */ label) => html`<button type="button" aria-pressed=${tab.value === name}
    @click=${() => {
      tab.value = name;
    }}>${label}</button>`;
  return html`<nav class="tabs" aria-label="Shown">${item('all', 'All')}
    ${order().map((view) => item(`view${view}`, view === 0 ? 'Server' : letter(view - 1)))}
    ${item('messages', 'Messages')}${item('charts', 'Charts')}</nav>`;
}

/** @returns {Template} */
function notes() {
  return html`<aside class="note" aria-label="Note" ?hidden=${notice.value === ''}><span>${notice.value}</span>
    <button type="button" class="small" @click=${() => {
      notice.value = '';
    }}>Close</button></aside>`;
}

/** @typedef {{lab: () => Template, draw: (frame: import('../labs/netgame/core/frame.js').Frame, settled: boolean, name: boolean) => void}} OwnLab */
/** Kinds of scenarios with a page of their own, which is read when it is first wanted. @type {Record<string, () => Promise<OwnLab>>} */
const OWN = {
  motion: () => import('../labs/motion/lab.js').then(({ stepLab, drawStep }) => ({ lab: stepLab, draw: drawStep })),
  rigid: () => import('../labs/rigid/lab.js').then(({ collideLab, drawCollide }) => ({ lab: collideLab, draw: drawCollide })),
  fluid: () => import('../labs/fluid/lab.js').then(({ fluidLab, drawFluid }) => ({ lab: fluidLab, draw: drawFluid })),
};
/** Those that were read, by kind. @type {import('@preact/signals-core').Signal<Map<string, OwnLab>>} */
const read = signal(new Map());
const asked = new Set();

/** The kind of the scenario, if it has its own lab page. */
const ownKind = () => Object.keys(OWN).find((kind) => layout.value?.[/** @type {'motion' | 'rigid' | 'fluid'} */ (kind)]);

/** The lab page, once it is loaded. @returns {OwnLab | undefined} */
export const ownLab = () => read.value.get(ownKind() ?? '');

/** @param {string} kind @returns {Template} */
function own(kind) {
  if (!asked.has(kind)) {
    asked.add(kind);
    part(/** @type {() => Promise<OwnLab>} */ (OWN[kind])).then((module) => {
      read.value = new Map(read.value).set(kind, module);
    });
  }
  return read.value.get(kind)?.lab() ?? html`<main id="views" tabindex="-1"></main>`;
}

/** The Experiments view, once it is read. @type {import('@preact/signals-core').Signal<typeof import('../labs/experiments/view.js') | null>} */
const sweeps = signal(null);

/** @returns {Template} */
function experiments() {
  if (!asked.has('experiments')) {
    asked.add('experiments');
    part(() => import('../labs/experiments/view.js')).then(async (module) => {
      await module.ready;
      module.begin();
      sweeps.value = module;
    });
  }
  return sweeps.value?.experimentsView() ?? html`<main id="views" tabindex="-1"></main>`;
}

/** @returns {Template} */
function page() {
  if (experiment.value !== null) return html`<a class="skip" href="#views">To the experiment</a>${header()}${experiments()}${notes()}`;
  const kind = ownKind();
  if (kind) return html`<a class="skip" href="#views">To the views</a>${header()}${own(kind)}${notes()}${timeBar()}`;
  return html`<a class="skip" href="#views">To the views</a>${header()}${tabs()}
    <main data-tab=${tab.value} data-rows=${order().length}>
      <div class="rows" id="views" tabindex="-1">${order().map(row)}${messages()}
        ${overlays.value.messages ? nothing : html`<div class="gutter lone">${messagesPanel()}</div>`}</div>
      ${side()}</main>
    ${notes()}${timeBar()}`;
}

/** @param {() => void} after every change of the page */
export function listen(after) {
  const root = /** @type {HTMLElement} */ (document.getElementById('app'));
  root.replaceChildren();
  effect(() => {
    render(page(), root);
    sync(root);
    if (experiment.value !== null) sweeps.value?.drawn();
    else after();
  });
}
