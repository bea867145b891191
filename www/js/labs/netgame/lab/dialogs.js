// The dialogs of a netgame, loaded after the first frame: all settings of a player or the server, a chart's table; and what the help says.
import { html, nothing } from '../../../../vendor/lit-html.js';
import { fixed, letter } from '../../../base/format.js';
import { find, grouped, livePaths, valueAt } from '../../../base/schema.js';
import { locked, params, schema } from '../../../session/state.js';
import { control } from '../../../workbench/controls.js';
import { dialog } from '../../../workbench/dialog.js';
import { keyRow } from '../../../workbench/key_row.js';
import { layout } from '../core/layout.js';
import { memory, scale, unit } from '../core/state.js';
import { bufferCurves, errorCurves, rowsOf } from '../views/curves.js';
import { DRIVING_HELP } from './keys.js';

/** @typedef {import('lit-html').TemplateResult} Template */

const FIRST = ['lag_ms', 'prediction', 'reconciliation', 'interpolation', 'control']; /* of a player, as on its panel */

/** @param {string} path @returns {Template} */
function settings(path) {
  const rank = (/** @type {string} */ p) => (FIRST.indexOf(p.slice(path.length + 1)) + FIRST.length + 1) % (FIRST.length + 1);
  const shown = (/** @type {string} */ p) => valueAt(params.value, p) !== undefined && find(schema.value, p)?.type !== 'text';
  const paths = livePaths(schema.value, path, true)
    .filter(shown)
    .sort((a, b) => rank(a) - rank(b));
  return html`<fieldset class="sheet" ?disabled=${locked.value !== ''}>
    <legend class="unseen">All settings</legend>
    ${locked.value ? html`<p class="reason">${locked.value}</p>` : nothing}
    ${grouped(path, paths).map((group) => html`<h3>${group.title}</h3>${group.paths.map(setting)}`)}</fieldset>`;
}

/** Shows a setting; one that is fixed during a run is disabled. @param {string} path @returns {Template} */
function setting(path) {
  const row = find(schema.value, path);
  const shown = control(path, { slider: row?.type === 'number' && row.unit === 'ms' && row.live });
  return html`<div class="setting">${row?.live ? shown : html`<fieldset disabled>${shown}</fieldset>`}<p>${row?.help ?? ''}${
    row?.live ? nothing : ' Fixed during a run: set it in the address or the scenario.'
  }</p></div>`;
}

/** @param {'error' | 'buffer'} which @returns {Template} */
function table(which) {
  const players = layout.value?.players.length ?? 0;
  const curves = which === 'error' ? errorCurves(players, unit.value, scale.pxPerMetre) : bufferCurves(players);
  const rows = rowsOf(memory, curves, 25);
  return html`<div class="scroll" tabindex="0" role="region" aria-label="Table"><table class="data"><thead><tr><th scope="col">Time (s)</th>
    ${curves.map((curve) => html`<th scope="col">${curve.label}</th>`)}</tr></thead>
    <tbody>${rows.map(
      (row) => html`<tr><th scope="row">${fixed(row.t, 2)}</th>
      ${row.values.map((value) => html`<td>${value === null ? '–' : fixed(value, unit.value === 'm' && which === 'error' ? 3 : 1)}</td>`)}</tr>`,
    )}
    </tbody></table></div>
    <button type="button" @click=${renew}>Refresh</button>`;
}

function renew() {
  dialog.value = dialog.value && { ...dialog.value };
}

/** @returns {Template} */
export function help() {
  return html`<table class="keys"><caption>Driving</caption><tbody>${DRIVING_HELP.map(keyRow)}</tbody></table>
    <h3>Reading the views</h3>
    <ul><li>Solid mark: what this player sees. Dashed hollow mark: where the server has it now.</li>
    <li>Spring with a cross: the server corrected the player's own car.</li>
    <li>Messages: a flatter line took longer. A cross: lost. Thin lines with a dot: connect and accept, and pings if
    switched on.</li>
    <li>A word over a view: the state of its player’s connection, unless it is playing.
    Faded, with the word away: a player who is not connected.</li>
    <li>Own, lead: distance from the drawn own car to the server’s present one; not an error.
    Own, error: distance to the server’s car at the drawn tick.</li>
    <li>Filled cells: inputs that the server has not acknowledged yet.</li>
    <li>α = (t − t0) / (t1 − t0): position of the render time t between two snapshots.</li>
    <li>Dots: one for each packet that arrived. Point at a dot for its times.</li></ul>`;
}

/** @type {NonNullable<import('../../../session/lab.js').Lab['dialogs']>} */
export const dialogs = {
  player: (player) => [`All settings of player ${letter(player)}`, settings(`players.${player}`)],
  server: () => ['Server and game', html`${settings('server')}${settings('params')}`],
  table: (which) => [which === 'error' ? `Drawn − server now (${unit.value})` : 'Interpolation buffer (ms)', table(which)],
};
