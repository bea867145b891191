// The controls next to each view.
import { html, nothing } from '../../../../vendor/lit-html.js';
import { control } from '../../../workbench/controls.js';
import { numberIn } from '../../../workbench/number_field.js';
import { aim, byPerson, fire, setAim } from './drive.js';
import { follow } from './follow.js';
import { fixed, letter, typed } from '../../../base/format.js';
import { t } from '../../../base/words.js';
import { icons } from '../../../workbench/icons.js';
import { locked, params } from '../../../session/state.js';
import { open } from '../../../workbench/dialog.js';
import { mark } from '../../../workbench/player_mark.js';
import { inspector, inspectors, offered } from '../core/inspector.js';
import { layout } from '../core/layout.js';
import { lanes, overlays, toggleOverlay } from '../core/state.js';

/** @typedef {import('lit-html').TemplateResult} Template */

const COLOURS = ['green', 'red', 'sky', 'pink', 'orange', 'yellow', 'blue', 'grey'];
/** @param {number} player */
const colourOf = (player) => html`<small>(${t(`netgame.colour.${COLOURS[player % 8]}`)})</small>`;

/** @param {number} player @returns {string} */
export function nameOf(player) {
  const name = layout.value?.players[player]?.name ?? letter(player);
  return name.length === 1 ? t('netgame.player_n', { name }) : name;
}

/** Angle and speed of the aim. @param {number} player @returns {Template} */
export function aiming(player) {
  const [angle = 0, speed = 0] = aim.value[player] ?? [];
  const top = Number(params.value?.params?.muzzle_speed_mps ?? 30);
  const set = (/** @type {'angle' | 'speed'} */ what) => (/** @type {Event} */ event) => {
    const isAngle = what === 'angle',
      row = { min: 0, max: isAngle ? 90 : top, unit: isAngle ? '°' : 'm/s' },
      now = isAngle ? Math.round(angle * 90) : Number((speed * top).toFixed(1));
    const value = numberIn(/** @type {HTMLInputElement} */ (event.target), t(`netgame.${what}`), row, now);
    if (Number.isNaN(value)) return;
    if (isAngle) setAim(player, value / 90, speed);
    else setAim(player, angle, value / top);
  };
  return html`<div class="pair aim">
    <label class="field"><span>${t('netgame.angle')}</span><input class="number" inputmode="decimal" autocomplete="off"
      data-min="0" data-max="90" .value=${fixed(angle * 90, 0)} @change=${set('angle')}><span class="unit">°</span></label>
    <label class="field"><span>${t('netgame.speed')}</span><input class="number" inputmode="decimal" autocomplete="off"
      data-min="0" data-max=${top}
      .value=${typed(Number((speed * top).toFixed(1)))} @change=${set('speed')}><span class="unit">m/s</span></label>
    </div>`;
}

/** @param {number} player @returns {Template} */
export function trigger(player) {
  return html`<button type="button" class="fire" @click=${() => fire(player)}>${icons.fire}<span>${t('netgame.fire')}</span></button>`;
}

/** @param {number} player @returns {Template} */
export function playerPanel(player) {
  const at = `players.${player}`;
  const lag = params.value?.players?.[player]?.lag_ms;
  const shooting = layout.value?.controls === 'aim' && byPerson(player);
  return html`<fieldset class="panel" data-player=${player % 8} ?disabled=${locked.value !== ''} title=${locked.value || nothing}>
    <legend class="unseen">${nameOf(player)}</legend>
    <div class="head"><h2>${mark(player)} ${nameOf(player)} ${shooting ? nothing : colourOf(player)}</h2>
      ${shooting ? trigger(player) : nothing}
      <button type="button" class="quiet" aria-label=${t('netgame.settings_of', { name: nameOf(player) })} title=${t('netgame.settings')}
        @click=${() => open({ kind: 'player', of: player })}>${icons.settings}</button></div>
    <div class="lag">${control(`${at}.lag_ms`, { slider: true })}<span
      class="rtt">${t('netgame.rtt', { ms: lag === undefined ? '–' : fixed(2 * lag, 0) })}</span></div>
    <div class="toggles">${control(`${at}.prediction`)}${control(`${at}.interpolation`)}${control(`${at}.reconciliation`, {
      label: t('netgame.reconciliation'),
    })}
      ${control(`${at}.control`, { label: t('netgame.input') })}</div>
    ${
      shooting
        ? aiming(player)
        : html`<div class="pair minor">
      ${control(`${at}.link.up.jitter_ms`, { also: `${at}.link.down.jitter_ms`, label: t('netgame.jitter') })}
      ${control(`${at}.link.up.loss_pct`, { also: `${at}.link.down.loss_pct`, label: t('netgame.loss') })}</div>`
    }
  </fieldset>`;
}

/** @returns {Template} */
export function serverPanel() {
  return html`<fieldset class="panel server" ?disabled=${locked.value !== ''} title=${locked.value || nothing}>
    <legend class="unseen">${t('netgame.server')}</legend>
    <div class="head"><h2><svg class="mark" data-player="server" viewBox="0 0 18 18" aria-hidden="true"><path
      d="M9 1l8 8-8 8-8-8z"></path></svg>
      ${t('netgame.server_truth')}</h2>
      <button type="button" class="quiet" aria-label=${t('netgame.settings_server')} title=${t('netgame.settings')}
        @click=${() => open({ kind: 'server' })}>${icons.settings}</button></div>
    <div class="lag">${control('server.update_hz', { slider: true })}</div>
    ${control('server.sync')}
    <p class="facts" id="facts"></p>
  </fieldset>`;
}

/** The player whose messages are shown. @param {0 | 1} place @param {string} label @returns {Template} */
function which(place, label) {
  const set = (/** @type {Event} */ event) => {
    const chosen = Number(/** @type {HTMLSelectElement} */ (event.target).value);
    lanes.value = place === 0 ? [chosen, lanes.value[1]] : [lanes.value[0], chosen];
  };
  return html`<label class="field choice"><span>${label}</span><select @change=${set}>${layout.value?.players.map(
    (_, p) => html`<option
    value=${p} .selected=${p === lanes.value[place]}>${letter(p)}</option>`,
  )}</select></label>`;
}

/** @returns {Template} */
export function messagesPanel() {
  const now = overlays.value;
  const box = (/** @type {import('../core/state.js').Overlay} */ name) => html`<label class="toggle"><input type="checkbox"
    .checked=${now[name]} @change=${() => toggleOverlay(name)}><span>${t(`netgame.overlay.${name}`)}</span></label>`;
  const ids = offered.value.split(' ');
  const chosen = inspectors.value.find((one) => one.id === inspector.value);
  const inspect = (/** @type {Event} */ event) => {
    inspector.value = /** @type {HTMLSelectElement} */ (event.target).value;
  };
  return html`<div class="panel plainpanel"><div class="head"><h2>${t('netgame.marks')}</h2><take-away of="lane" data
      name=${t('netgame.messages')}></take-away></div>
    <div class="lookrow"><label class="field choice" title=${t('netgame.lower')}><select aria-label=${t('netgame.lower_content')}
      @change=${inspect}><option value="messages" .selected=${inspector.value === 'messages'}>${t('netgame.messages')}</option>
      ${inspectors.value
        .filter((one) => ids.includes(one.id))
        .map(
          (one) => html`<option value=${one.id}
        .selected=${one.id === inspector.value}>${t(`netgame_more.inspector.${one.id}`)}</option>`,
        )}</select></label>${box('pings')}<button type="button"
      class="small" id="follow" @click=${() => follow()}>${t('netgame.packet')}</button></div>
    <div
      class="toggles">${box('ghosts')}${box('dots')}${box('labels')}${box('messages')}</div>
    ${
      chosen?.players
        ? which(0, t('netgame.player'))
        : (layout.value?.players.length ?? 0) > 2
          ? html`<div
      class="pair">${which(0, t('netgame.above'))}${which(1, t('netgame.below'))}</div>`
          : nothing
    }
    <p class="facts" id="lane-facts"></p></div>`;
}
