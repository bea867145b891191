// Who is in the class, as its teacher sees it: devices by number, and what removes them. No names, no addresses.
import { signal } from '../../vendor/signals-core.js';
import { html, nothing } from '../../vendor/lit-html.js';
import { letter } from '../base/format.js';
import { mark } from '../workbench/player_mark.js';
import { devices, now } from './state.js';
import { freeSeats, remove, set } from './teacher.js';
import { language, t } from '../base/words.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('./state.js').Device} Device */

/** The number of the device that was pressed; 0: none. */
const chosen = signal(0);

/** The door, as a switch. @returns {Template} */
export function door() {
  const closed = now.value?.door === 'closed';
  return html`<button type="button" aria-pressed=${closed} @click=${() => set({ door: closed ? 'open' : 'closed' })}>${t(
    closed ? 'class.door_open' : 'class.door_close',
  )}</button>`;
}

/** @param {Device} device how many are at its address */
const alike = ({ group }) => devices.value.members.filter((other) => other.group === group).length;

/** @param {Device} device @returns {string} */
function partOf({ role, player }) {
  if (role === 'play' && player !== null) return t('class.device.play', { player: letter(player) });
  return t(`class.device.${role === 'copy' ? 'copy' : 'watch'}`);
}

/** @param {Device} device @returns {string} */
function about(device) {
  const time = new Date(device.joined_s * 1000).toLocaleTimeString(language.value, { hour: '2-digit', minute: '2-digit' });
  return [
    t('class.device', { n: device.number }),
    partOf(device),
    t(device.connected ? 'class.device.here' : 'class.device.away'),
    ...(device.voted ? [t('class.device.voted')] : []),
    t('class.device.since', { time }),
    ...(alike(device) > 1 ? [t('class.device.group', { group: device.group, n: alike(device) })] : []),
  ].join(', ');
}

/** @param {Device} device @returns {Template} */
function chip(device) {
  const is = chosen.value === device.number;
  return html`<li><button type="button" class="device" data-here=${device.connected} aria-expanded=${is}
    title=${about(device)} @click=${() => {
      chosen.value = is ? 0 : device.number;
    }}><span class="unseen">${about(device)}</span><span aria-hidden="true">${device.player === null ? nothing : mark(device.player)}<b>${
      device.number
    }</b>${alike(device) > 1 ? html`<small>${device.group}</small>` : nothing}</span></button></li>`;
}

/** What the press of a chip asks before it is done. @param {Device} device @returns {Template} */
function asks(device) {
  const later = devices.value.members.filter(({ number }) => number > device.number).length,
    of = alike(device);
  const act = (/** @type {'' | 'later' | 'address'} */ and, /** @type {string} */ text) => html`<button type="button" class="bad"
    @click=${() => {
      chosen.value = 0;
      remove(device.number, and);
    }}>${text}</button>`;
  return html`<div class="asks" role="group" aria-label=${t('class.device', { n: device.number })}>
    <p>${about(device)}. ${t('class.remove_tip')}</p>
    ${act('', t('class.remove', { n: device.number }))}
    ${later > 0 ? act('later', t('class.remove_later', { number: device.number, n: later })) : nothing}
    ${of > 1 && !device.home ? act('address', t('class.remove_group', { n: of, group: device.group })) : nothing}
    <button type="button" @click=${() => {
      chosen.value = 0;
    }}>${t('class.remove_none')}</button></div>`;
}

/** @returns {Template} */
export function deviceList() {
  const { most, members } = devices.value,
    device = members.find(({ number }) => number === chosen.value),
    held = now.value?.seats.some(({ state }) => state !== 'free') === true;
  return html`<section class="devices" aria-label=${t('class.devices')}><h2>${t('class.devices')}</h2>
    <p class="of">${t('class.devices_of', { n: members.length, most })}</p>${door()}
    ${held ? html`<button type="button" @click=${freeSeats}>${t('class.free_seats')}</button>` : nothing}
    ${members.length > 0 ? html`<ul>${members.map(chip)}</ul>` : html`<p class="reason">${t('class.devices_none')}</p>`}
    ${device ? asks(device) : nothing}</section>`;
}
