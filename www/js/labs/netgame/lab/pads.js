// Touch pads: held with a finger, they push like keys.
import { html, nothing } from '../../../../vendor/lit-html.js';
import { t } from '../../../base/words.js';
import { byPerson, push } from './drive.js';
import { icons } from '../../../workbench/icons.js';
import { aiming, nameOf, trigger } from './panels.js';
import { mayDrive, place } from '../../../session/state.js';
import { layout } from '../core/layout.js';

/** @typedef {import('lit-html').TemplateResult} Template */

/** @param {number} player @param {import('./drive.js').Push} way @param {string} key of its words @param {Template} icon
 * @param {string} [word] below it @returns {Template} */
function pad(player, way, key, icon, word = '') {
  const down = (/** @type {PointerEvent} */ event) => {
    /** @type {Element} */ (event.currentTarget).setPointerCapture(event.pointerId);
    push(player, way, true);
  };
  const up = () => push(player, way, false);
  return html`<button type="button" class="pad" aria-label=${t(key, { name: nameOf(player) })} ?disabled=${!mayDrive(player)}
    @pointerdown=${down} @pointerup=${up} @pointercancel=${up} @lostpointercapture=${up}>${icon}${
      word === '' ? nothing : html`<span>${word}</span>`
    }</button>`;
}

/** @param {number} player @returns {Template | typeof nothing} */
export function pads(player) {
  const { seat } = place.value;
  if (!byPerson(player) || (seat !== null && seat !== player)) return nothing;
  if (layout.value?.controls === 'aim') {
    return html`<fieldset class="pads" data-player=${player % 8} ?disabled=${!mayDrive(player)}>
      <legend class="unseen">${t('netgame.pad.cannon', { name: nameOf(player) })}</legend>${aiming(player)}${trigger(player)}</fieldset>`;
  }
  if (layout.value?.controls === 'plane') {
    return html`<div class="pads" data-player=${player % 8}>
      ${pad(player, 'back', 'netgame.pad.left', icons.left)}${pad(player, 'up', 'netgame.pad.up', icons.up)}
      ${pad(player, 'down', 'netgame.pad.down', icons.down)}${pad(player, 'ahead', 'netgame.pad.right', icons.right)}</div>`;
  }
  return html`<div class="pads" data-player=${player % 8}>
    ${pad(player, 'back', 'netgame.pad.brake', icons.left, t('netgame.pad.brake_word'))}
    ${pad(player, 'ahead', 'netgame.pad.throttle', icons.right, t('netgame.pad.throttle_word'))}</div>`;
}
