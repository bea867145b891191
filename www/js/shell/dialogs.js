// One dialog at a time, loaded after the first frame: help, all settings of a player or the server, links to share, a chart's table.
import { html, nothing, render } from '../../vendor/lit-html.js';
import { effect } from '../../vendor/signals-core.js';
import { address } from '../base/api.js';
import { control, sync } from '../workbench/controls.js';
import { link } from '../session/opening.js';
import { fixed, letter } from '../base/format.js';
import { DRIVING_HELP, KEYS, setTheme } from './keys.js';
import { memory } from '../session/session.js';
import { THEMES, writeQuery } from '../base/link.js';
import { find, grouped, livePaths, valueAt } from '../base/schema.js';
import {
  dialog as page,
  layout,
  locked,
  params,
  scale,
  schema,
  session,
  setSingleKeys,
  singleKeys,
  theme,
  unit,
} from '../session/state.js';
import { bufferCurves, errorCurves, rowsOf } from '../labs/netgame/views/curves.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @returns {Template} */
function help() {
  const row = (/** @type {{shown: string, help: string}} */ key) =>
    html`<tr><th scope="row"><kbd>${key.shown}</kbd></th><td>${key.help}</td></tr>`;
  return html`<label class="toggle"><input type="checkbox" .checked=${singleKeys.value}
      @change=${(/** @type {Event} */ event) => setSingleKeys(/** @type {HTMLInputElement} */ (event.target).checked)}><span>Single-key
      shortcuts</span></label>
    <label class="field choice"><span>Colours</span><select .value=${theme.value}
      @change=${(/** @type {Event} */ event) => setTheme(/** @type {HTMLSelectElement} */ (event.target).value)}>
      ${THEMES.map((name) => html`<option value=${name} ?selected=${name === theme.value}>${name}</option>`)}</select></label>
    <div class="columns"><table class="keys"><caption>Keys</caption><tbody>${KEYS.map(row)}</tbody></table>
    <div><table class="keys"><caption>Driving</caption><tbody>${DRIVING_HELP.map(row)}</tbody></table>
    <h3>Reading the views</h3>
    <ul><li>Solid mark: what this player sees. Dashed hollow mark: where the server has it now.</li>
    <li>Spring with a cross: the server corrected the player's own car.</li>
    <li>Messages: a flatter line took longer. A cross: lost. Thin lines with a dot: connect and accept, and pings if
    switched on.</li>
    <li>A word over a view: the state of its player’s connection, unless it is playing. Faded, with the word away: a player who is not connected.</li>
    <li>Own, lead: distance from the drawn own car to the server’s present one; not an error. Own, error: distance to the server’s car at the drawn tick.</li>
    <li>Filled cells: inputs that the server has not acknowledged yet.</li>
    <li>α = (t − t0) / (t1 − t0): position of the render time t between two snapshots.</li>
    <li>Dots: one for each packet that arrived. Point at a dot for its times.</li></ul></div></div>`;
}

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

/** @param {string} label @param {string} text @returns {Template} */
function address_(label, text) {
  return html`<label class="address"><span>${label}</span><input readonly .value=${text}
    @focus=${(/** @type {Event} */ event) => /** @type {HTMLInputElement} */ (event.target).select()}></label>`;
}

/** @returns {Template} */
function share() {
  const base = `${location.origin}${location.pathname}`;
  const id = session.value?.id ?? '';
  const local = /^(localhost|127\.|\[::1\])/.test(location.hostname);
  return html`${local ? html`<p class="reason">This address works on this computer only: others need its network address.</p>` : nothing}
    ${address_('The same settings, in a new session', base + (writeQuery(link) || '?scenario=race'))}
    ${address_('This session, read-only', `${base}#s=${id}`)}
    <p><a href=${address(`sessions/${id}/trace`).href} download="laglab.csv">Trace of this run as CSV</a></p>
    <p>API: <code>curl ${address(`sessions/${id}`).href}</code></p>`;
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
    <button type="button" @click=${() => draw()}>Refresh</button>`;
}

/** @param {import('../session/state.js').Dialog} at @returns {[string, Template]} */
function content(at) {
  switch (at.kind) {
    case 'help':
      return ['Help', help()];
    case 'player':
      return [`All settings of player ${letter(at.player)}`, settings(`players.${at.player}`)];
    case 'server':
      return ['Server and game', html`${settings('server')}${settings('params')}`];
    case 'share':
      return ['Share', share()];
    default:
      return [at.which === 'error' ? `Drawn − server now (${unit.value})` : 'Interpolation buffer (ms)', table(at.which)];
  }
}

const dialog = document.createElement('dialog');
dialog.setAttribute('aria-labelledby', 'dialog-title');

function draw() {
  const at = page.value;
  if (at === null) return;
  const [title, body] = content(at);
  render(
    html`<header><h2 id="dialog-title">${title}</h2><button type="button" class="close" @click=${() => dialog.close()}>Close</button></header>
    <div class="body">${body}</div>`,
    dialog,
  );
  sync(dialog);
}

export function listen() {
  document.body.append(dialog);
  dialog.addEventListener('close', () => {
    page.value = null;
  });
  dialog.addEventListener('click', (event) => {
    if (event.target === dialog) dialog.close();
  });
  effect(() => {
    draw();
    if (page.value !== null && !dialog.open) dialog.showModal();
  });
}
