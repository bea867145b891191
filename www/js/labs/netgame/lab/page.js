// The views of server and players, each with its controls, above their messages; the side column.
import { html, nothing } from '../../../../vendor/lit-html.js';
import { fixed, letter } from '../../../base/format.js';
import { choiceOf, t } from '../../../base/words.js';
import { allowed, bars, camera, lesson, params, staged } from '../../../session/state.js';
import { open } from '../../../workbench/dialog.js';
import { icons } from '../../../workbench/icons.js';
import { mark } from '../../../workbench/player_mark.js';
import { layout } from '../core/layout.js';
import { followed, overlays, tab } from '../core/state.js';
import { follow, view } from './follow.js';
import { pads } from './pads.js';
import { closeup } from './closeup.js';
import { messagesPanel, nameOf, playerPanel, serverPanel } from './panels.js';
import { compareButton, side } from './side.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('../core/state.js').Tab} Tab */

/** The views from top to bottom: the first player, the server, the other players. @returns {number[]} */
function order() {
  const players = layout.value?.players.length ?? 2;
  const all = [1, 0, ...Array.from({ length: Math.max(0, players - 1) }, (_, i) => 2 + i)],
    only = camera.value?.only;
  return only ? all.filter((view) => view === 0 || only.includes(view - 1)) : all;
}

/** @param {number} player @returns {string} */
function techniques(player) {
  const p = params.value?.players?.[player];
  if (!p) return '';
  const on = ['prediction', 'reconciliation', 'interpolation'].filter((name) => p[name]).map((name) => t(`netgame.short.${name}`));
  const said = on.length === 3 ? t('netgame.short.all') : on.length > 0 ? on.join(', ') : t('netgame.short.none');
  return `${fixed(p.lag_ms, 0)} ms · ${said}`;
}

const serverMark = html`<svg class="mark" data-player="server" viewBox="0 0 18 18" aria-hidden="true"><path
  d="M9 1l8 8-8 8-8-8z"></path></svg>`;

/** The line above a view on a phone: opens its settings. @param {number} view @returns {Template} */
function caption(view) {
  const press = staged.value?.press ?? 0;
  if (press > 0)
    return html`<div class="caption" data-player=${view > 0 ? view - 1 : nothing}>${view > 0 ? mark(view - 1) : serverMark}
      <b>${t(view > 0 ? 'workbench.since.screen' : 'netgame.server')}</b> <span
        class="techniques">${view > 0 ? '' : t('netgame.staged.truth')}</span></div>`;
  if (view === 0) {
    const server = params.value?.server,
      rule = server ? `${server.update_hz}/s · ${choiceOf('netgame', 'server.sync', server.sync)}` : '';
    return html`<button type="button" class="caption" ?disabled=${allowed.value !== null} @click=${() => open({ kind: 'server' })}>
      ${serverMark}
      <b>${t('netgame.server')}</b> <span class="techniques">${rule}</span><span class="sentence"
        data-main="0"></span>${icons.settings}</button>`;
  }
  const player = view - 1;
  return html`<button type="button" class="caption" data-player=${player % 8} ?disabled=${allowed.value !== null}
    @click=${() => open({ kind: 'player', of: player })}>
    ${mark(player)} <b>${nameOf(player)}</b> <span class="techniques">${techniques(player)}</span><span class="sentence"
      data-main=${view}></span>${icons.settings}</button>`;
}

/** What a lesson highlights in a view: `at` of api/lesson.schema.json. */
const SHOWS = [
  'own_entity',
  'other_entity',
  'server_entity',
  'correction',
  'waiting',
  'shot',
  'cover',
  'arrivals',
  'buffer',
  'refusals',
  'desync',
  'path',
  'size',
  'gap',
  'positions',
].join(' ');

/** @param {number} view @returns {Template} */
function row(view) {
  const player = view - 1;
  const label = view === 0 ? t('netgame.view.server') : t('netgame.view.of', { name: nameOf(player) });
  const keys = player === 0 ? ` ${t('netgame.view.arrows')}` : player === 1 ? ` ${t('netgame.view.letters')}` : '';
  return html`<section class="row" data-tab=${`view${view}`} aria-label=${view === 0 ? t('netgame.server') : nameOf(player)}>
    <div class="gutter">${view === 0 ? serverPanel() : playerPanel(player)}</div>
    ${caption(view)}
    <div class="view" role="group" tabindex=${view > 0 ? '0' : nothing} data-drive=${view > 0 ? player : nothing} data-shows=${SHOWS}
      data-of=${view > 0 ? player : 'server'}
      aria-label=${`${label}.${keys}`}>
      <canvas data-view=${view} role="img" aria-label=${label}></canvas><take-away name=${label}></take-away></div>
    ${view > 0 ? pads(player) : nothing}
  </section>`;
}

/** The first run of a lesson, above the second. @returns {Template} */
function first() {
  return html`<section class="row first" data-tab="first" aria-label=${t('netgame.staged.first')}>
    <div class="caption"><b>${t('netgame.staged.first')}</b> <span class="techniques">${t('netgame.staged.kept')}</span></div>
    <div class="view"><canvas id="first" role="img" aria-label=${t('netgame.staged.first')}></canvas></div></section>`;
}

/** Time since the key of a lesson. @returns {Template} */
function sinceKey() {
  return html`<section class="row pressed" aria-label=${t('workbench.since')}><div class="caption"><b>${t('workbench.since')}</b></div>
    <div class="view" id="since"></div></section>`;
}

/** Sizes that a lesson compares. @returns {Template} */
function sizes() {
  return html`<section class="row lane sizes" aria-label=${t('netgame.staged.sizes')}><div class="gutter"></div><div class="view"
    data-shows="bars"><canvas id="bars" role="img" aria-label=${bars.value.map(({ text }) => text).join('. ')}></canvas></div></section>`;
}

/** Views, and what a lesson puts between them. @returns {Template} */
function rows() {
  const of = staged.value,
    [own = 1, ...others] = order();
  const road = (layout.value?.entities.length ?? 0) === 0 && layout.value?.controls !== 'aim';
  if (of === null || camera.value === null || !road) return html`${order().map(row)}${bars.value.length > 0 ? sizes() : messages()}`;
  if (of.step === 5)
    return html`${first()}${row(own)}${others.map(row)}<p class="legend">${of.press > 0 ? t('netgame.staged.legend') : nothing}</p>`;
  return html`${row(own)}${of.line.length > 0 ? sinceKey() : nothing}${others.map(row)}${of.line.length > 0 ? nothing : messages()}`;
}

/** @returns {Template} */
function messages() {
  return html`<section class="row lane" data-tab="messages" aria-label=${t('netgame.messages')} ?hidden=${!overlays.value.messages}>
    <div class="gutter">${messagesPanel()}</div>
    <div class="view" role="group" tabindex="0" data-arrows="yes" data-shows="message inputs"
      aria-label=${t('netgame.lane.keys')}>
      <canvas id="lane" role="img" aria-label=${t('netgame.lane.over_time')}></canvas></div></section>`;
}

/** On a phone: what the one column shows. @returns {Template} */
function tabs() {
  const item = (
    /** @type {Tab} */ name,
    /** @type {string} */ label,
  ) => html`<button type="button" aria-pressed=${followed.value === null && tab.value === name}
    @click=${() => {
      followed.value = null;
      tab.value = name;
    }}>${label}</button>`;
  return html`<nav class="tabs" aria-label=${t('netgame.shown')}>${item('all', t('netgame.all'))}
    ${order().map((view) => item(`view${view}`, view === 0 ? t('netgame.server') : letter(view - 1)))}
    ${item('messages', t('netgame.messages'))}<button type="button" aria-pressed=${followed.value !== null}
      @click=${() => follow()}>${t('netgame.packet')}</button>
    ${item('charts', t('netgame.charts'))}${compareButton()}</nav>`;
}

/** @returns {Template} */
export function template() {
  if (followed.value !== null)
    return html`${tabs()}<main data-tab="packet"><div class="rows" id="views" tabindex="-1">${
      lesson.value === null ? nothing : row(1 + followed.value.player)
    }${view.value?.template() ?? nothing}</div>${side()}</main>`;
  const instead = closeup.value;
  if (instead !== null && !instead.views.value) return instead.template();
  const shape = (layout.value?.entities.length ?? 0) > 0 ? 'field' : 'track';
  return html`${tabs()}
    <main data-tab=${tab.value} data-rows=${order().length} data-shape=${shape}>
      <div class="rows" id="views" tabindex="-1">${rows()}
        ${overlays.value.messages ? nothing : html`<div class="gutter lone">${messagesPanel()}</div>`}</div>
      ${side()}${instead?.back() ?? nothing}</main>`;
}
