// What spectators see: below the players' views one of each, with its link, how old it is, and how full its buffer is. Read where there
// are any.
import { html } from '../../../../vendor/lit-html.js';
import { fixed, letter } from '../../../base/format.js';
import { need, t } from '../../../base/words.js';
import { allowed, locked, params } from '../../../session/state.js';
import { SPECTATORS_STATE } from '../../../stream/names.js';
import { drawText, widthOf } from '../../../draw/marks.js';
import { control } from '../../../workbench/controls.js';
import { open } from '../../../workbench/dialog.js';
import { icons } from '../../../workbench/icons.js';
import { layout } from '../core/layout.js';
import { pill } from '../views/connection.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('../core/frame.js').Frame} Frame */
/** @typedef {import('../views/scene.js').DrawContext} DrawContext */
/** @typedef {import('../../../stream/rows.js').SpectatorsRow} Spectator */

await need('netgame_more');

const LATELY_S = 0.25; /* for this long a wait is shown */
const LEAST_BAR = 40; /* px: a shorter one says nothing */

/** @returns {{lag_ms: number, player: number, buffer_ticks: number, behind_ticks: number}[]} */
const settings = () => params.value?.spectators ?? [];

/** The view of the first: after the server's and the players'. */
const first = () => 1 + (layout.value?.players.length ?? 0);

/** @param {number} spectator */
const nameOf = (spectator) => t('netgame_more.spectator', { n: String(spectator + 1) });

/** The views, in the numbers of the others, and their names. @returns {{view: number, name: string}[]} */
export const views = () => settings().map((_, i) => ({ view: first() + i, name: nameOf(i) }));

// ---- the page ----

const EYE = html`<svg class="mark" viewBox="0 0 18 18" aria-hidden="true"><path
  d="M1 9q4-6 8-6t8 6q-4 6-8 6t-8-6zM9 6a3 3 0 1 0 .01 0z" fill-rule="evenodd"></path></svg>`;

/** @param {number} spectator @returns {string} */
function sender(spectator) {
  const player = settings()[spectator]?.player ?? -1;
  return player < 0 ? t('netgame_more.spectator.by_server') : t('netgame_more.spectator.by_player', { name: letter(player) });
}

/** @param {number} spectator @returns {Template} */
function panel(spectator) {
  const at = `spectators.${spectator}`,
    trip = t('netgame.rtt', { ms: fixed(2 * (settings()[spectator]?.lag_ms ?? 0), 0) });
  return html`<fieldset class="panel" ?disabled=${locked.value !== ''}>
    <legend class="unseen">${nameOf(spectator)}</legend>
    <div class="head"><h2>${EYE} ${nameOf(spectator)}</h2>
      <button type="button" class="quiet" aria-label=${t('netgame.settings_of', { name: nameOf(spectator) })} title=${t('netgame.settings')}
        @click=${() => open({ kind: 'spectator', of: spectator })}>${icons.settings}</button></div>
    <div class="lag">${control(`${at}.lag_ms`, { slider: true })}<span class="rtt">${trip}</span></div>
    <div class="pair minor">${control(`${at}.link.down.jitter_ms`, { label: t('netgame.jitter') })}
      ${control(`${at}.link.down.loss_pct`, { label: t('netgame.loss') })}</div>
    <p class="facts"><span>${sender(spectator)}</span> · <span data-counted=${spectator}>–</span></p>
  </fieldset>`;
}

/** Above the view on a phone and on a projector. @param {number} spectator @returns {Template} */
function caption(spectator) {
  const lag = fixed(settings()[spectator]?.lag_ms ?? 0, 0);
  return html`<button type="button" class="caption" ?disabled=${allowed.value !== null}
    @click=${() => open({ kind: 'spectator', of: spectator })}>
    ${EYE} <b>${nameOf(spectator)}</b> <span class="techniques">${lag} ms · ${sender(spectator)}</span><span class="sentence"
      data-watched=${spectator}></span>${icons.settings}</button>`;
}

/** @returns {Template[]} */
export const rows = () =>
  views().map(({ view, name }, i) => {
    const label = t('netgame.view.of', { name });
    return html`<section class="row" data-tab=${`view${view}`} aria-label=${name}>
      <div class="gutter">${panel(i)}</div>
      ${caption(i)}
      <div class="view" role="group" aria-label=${label}><canvas data-view=${view} role="img" aria-label=${label}></canvas><take-away
        name=${label}></take-away></div>
    </section>`;
  });

// ---- what it does ----

/** Of each spectator: the waits that are known of, and when the last of them was. @type {{waits: number, at: number}[]} */
const waited = [];

/** Whether it had no inputs for a next tick in the last moments. @param {Spectator} row @param {number} time s */
function waitsLately(row, time) {
  const before = waited[row.spectator],
    begun = before === undefined || row.waits < before.waits || time < before.at;
  const now = begun ? { waits: row.waits, at: -Infinity } : row.waits > before.waits ? { waits: row.waits, at: time } : before;
  waited[row.spectator] = now;
  return time - now.at < LATELY_S;
}

/** The end of the key of its words. @param {Spectator} row @param {number} time s */
function stateOf(row, time) {
  const waits = waitsLately(row, time);
  if (row.state === SPECTATORS_STATE.out) return 'out';
  if (row.state === SPECTATORS_STATE.catching_up) return 'catching_up';
  return waits ? 'waiting' : 'following';
}

/** @param {Spectator} row */
const ageOf = (row) =>
  Number.isNaN(row.age_ms) ? t('netgame_more.spectator.not_begun') : t('netgame_more.spectator.age', { ms: fixed(row.age_ms, 0) });

/** @param {Spectator} row */
const bufferOf = (row) =>
  t('netgame_more.spectator.buffer', { n: String(row.buffered), all: String(settings()[row.spectator]?.buffer_ticks ?? 0) });

/** @param {Spectator} row @param {number} time s */
const sayingOf = (row, time) => `${ageOf(row)} · ${t(`netgame_more.spectator.${stateOf(row, time)}`)}`;

/** @param {Frame} frame @param {number} view @returns {Spectator | undefined} */
const rowOf = (frame, view) => frame.spectators[view - first()];

/** What a view shows, in words. @param {Frame} frame @param {number} view @returns {string} */
export function words(frame, view) {
  const row = rowOf(frame, view);
  return row ? `${nameOf(row.spectator)}: ${sayingOf(row, frame.time_s)} · ${bufferOf(row)}` : '';
}

/** @param {string} place @param {string} text */
function put(place, text) {
  const element = document.querySelector(place);
  if (element && element.textContent !== text) element.textContent = text;
}

/** Next to the views. @param {Frame} frame */
export function tell(frame) {
  for (const row of frame.spectators) {
    put(`[data-watched="${row.spectator}"]`, sayingOf(row, frame.time_s));
    put(`[data-counted="${row.spectator}"]`, t('netgame_more.spectator.counted', { ticks: String(row.catch_up), n: row.falls }));
  }
}

// ---- drawing ----

/** How full the buffer is; from the mark on it catches up. @param {DrawContext} at @param {Spectator} row @param {number} left px
 * @param {number} width px @param {number} top px @param {number} height px */
function bar({ pen, colours }, row, left, width, top, height) {
  const { buffer_ticks: all = 1, behind_ticks: mark = 0 } = settings()[row.spectator] ?? {},
    x = (/** @type {number} */ ticks) => left + (Math.min(all, ticks) / all) * width;
  pen.setLineDash([]);
  pen.fillStyle = row.state === SPECTATORS_STATE.out ? colours.snap : colours.buffer;
  pen.globalAlpha = 0.5;
  pen.fillRect(left, top + 4, x(row.buffered) - left, height - 8);
  pen.globalAlpha = 1;
  pen.strokeStyle = colours.edge;
  pen.lineWidth = 1;
  pen.strokeRect(left + 0.5, top + 3.5, width, height - 7);
  pen.fillStyle = colours.ink;
  if (mark < all) pen.fillRect(Math.round(x(mark)), top + 1, 1.5, height - 2);
}

/** Over and below a view. @param {DrawContext} at @param {number} high of the strip below, px */
export function draw(at, high) {
  const row = rowOf(at.frame, at.view);
  if (!row) return;
  const { pen, colours, width, frame } = at,
    state = stateOf(row, frame.time_s);
  if (state === 'out') pill(at, t('netgame_more.spectator.out'));
  if (high === 0) return;
  const middle = at.height + high / 2,
    whole = sayingOf(row, frame.time_s),
    saying = widthOf(pen, colours, whole, true) > width - 16 ? ageOf(row) : whole,
    left = Math.max(width * 0.56, 8 + widthOf(pen, colours, saying, true) + 12);
  const bold = state !== 'following',
    colour = state === 'out' || state === 'waiting' ? colours.snap : colours.ink;
  drawText(pen, colours, saying, 8, middle, { bold, colour });
  const room = width - 8 - left - LEAST_BAR - 8;
  const buffer = [bufferOf(row), `${row.buffered}/${settings()[row.spectator]?.buffer_ticks ?? ''}`].find(
    (text) => widthOf(pen, colours, text) <= room,
  );
  if (buffer === undefined) return;
  const right = width - 8 - widthOf(pen, colours, buffer);
  drawText(pen, colours, buffer, right, middle, { colour: colours.faint });
  bar(at, row, left, right - 8 - left, at.height + 1, high - 2);
}
