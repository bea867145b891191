// Touch pads: held with a finger, they push like keys.
import { html, nothing } from '../../../../vendor/lit-html.js';
import { byPerson, push } from './drive.js';
import { icons } from '../../../workbench/icons.js';
import { aiming, nameOf, trigger } from './panels.js';
import { mayDrive, place } from '../../../session/state.js';
import { layout } from '../core/layout.js';

/** @typedef {import('lit-html').TemplateResult} Template */

/** @param {number} player @param {import('./drive.js').Push} way @param {string} label @param {Template} icon @returns {Template} */
function pad(player, way, label, icon) {
  const down = (/** @type {PointerEvent} */ event) => {
    /** @type {Element} */ (event.currentTarget).setPointerCapture(event.pointerId);
    push(player, way, true);
  };
  const up = () => push(player, way, false);
  return html`<button type="button" class="pad" aria-label=${label} ?disabled=${!mayDrive(player)} @pointerdown=${down} @pointerup=${up}
    @pointercancel=${up} @lostpointercapture=${up}>${icon}</button>`;
}

/** @param {number} player @returns {Template | typeof nothing} */
export function pads(player) {
  const { seat } = place.value;
  if (!byPerson(player) || (seat !== null && seat !== player)) return nothing;
  if (layout.value?.controls === 'aim') {
    return html`<fieldset class="pads" data-player=${player % 8} ?disabled=${!mayDrive(player)}>
      <legend class="unseen">Cannon of ${nameOf(player)}</legend>${aiming(player)}${trigger(player)}</fieldset>`;
  }
  if (layout.value?.controls === 'plane') {
    return html`<div class="pads" data-player=${player % 8}>
      ${pad(player, 'back', `Left, ${nameOf(player)}`, icons.left)}${pad(player, 'up', `Up, ${nameOf(player)}`, icons.up)}
      ${pad(player, 'down', `Down, ${nameOf(player)}`, icons.down)}${pad(player, 'ahead', `Right, ${nameOf(player)}`, icons.right)}</div>`;
  }
  return html`<div class="pads" data-player=${player % 8}>
    ${pad(player, 'back', `Brake, ${nameOf(player)}`, icons.left)}
    ${pad(player, 'ahead', `Throttle, ${nameOf(player)}`, icons.right)}</div>`;
}
