// The dialogs of a netgame, loaded when one is wanted: all settings of a player or the server, a chart's table; and what the help says.
import { html, nothing } from '../../../../vendor/lit-html.js';
import { effect } from '../../../../vendor/signals-core.js';
import { constant, insist } from '../../../base/api.js';
import { fixed, letter } from '../../../base/format.js';
import { inputOf, language, t } from '../../../base/words.js';
import { find, grouped, livePaths, valueAt } from '../../../base/schema.js';
import { locked, params, schema, schemas } from '../../../session/state.js';
import { control } from '../../../workbench/controls.js';
import { dialog } from '../../../workbench/dialog.js';
import { keyRow } from '../../../workbench/key_row.js';
import { layout } from '../core/layout.js';
import { memory, scale, unit } from '../core/state.js';
import { bufferCurves, errorCurves, rowsOf } from '../views/curves.js';

/** @typedef {import('lit-html').TemplateResult} Template */

/** Settings of the scenario that belong with those of another place. @type {Record<string, string[]>} */
const BESIDE = { server: ['bucket_delay_ms'] };
const FIRST = ['lag_ms', 'prediction', 'reconciliation', 'interpolation', 'control']; /* of a player, as on its panel */

/** @param {string} path @returns {Template} */
function settings(path) {
  const rank = (/** @type {string} */ p) => (FIRST.indexOf(p.slice(path.length + 1)) + FIRST.length + 1) % (FIRST.length + 1);
  const shown = (/** @type {string} */ p) => valueAt(params.value, p) !== undefined && find(schema.value, p)?.type !== 'text';
  const paths = [...livePaths(schema.value, path, true), ...(BESIDE[path] ?? [])].filter(shown).sort((a, b) => rank(a) - rank(b));
  return html`<fieldset class="sheet" ?disabled=${locked.value !== ''}>
    <legend class="unseen">${t('netgame.settings')}</legend>
    ${locked.value ? html`<p class="reason">${locked.value}</p>` : nothing}
    ${grouped(path, paths).map((group) => html`<h3>${group.title}</h3>${group.paths.map(setting)}`)}</fieldset>`;
}

/** The dialogs that explain each setting. */
const EXPLAINED = ['player', 'server'];
let explained = false;
effect(() => {
  /* the schema with its descriptions, when one of them is first shown in their language */
  if (explained || language.value !== 'en' || !EXPLAINED.includes(dialog.value?.kind ?? '')) return;
  explained = true;
  insist(() => constant('schema?kind=netgame')).then((answer) => {
    schemas.value = new Map(schemas.value).set('netgame', answer);
  });
});

/** What a setting is: the daemon's help is English. @param {string} path @param {string} [help] */
const helpOf = (path, help = '') => (language.value === 'en' ? help : (inputOf('netgame', path)?.tip ?? help));

/** Shows a setting; one that is fixed during a run is disabled. @param {string} path @returns {Template} */
function setting(path) {
  const row = find(schema.value, path);
  const shown = control(path, { slider: row?.type === 'number' && row.unit === 'ms' && row.live });
  return html`<div class="setting">${row?.live ? shown : html`<fieldset disabled>${shown}</fieldset>`}<p>${helpOf(path, row?.help)}${
    row?.live ? nothing : ` ${t('netgame_more.fixed')}`
  }</p></div>`;
}

/** @param {'error' | 'buffer'} which @returns {Template} */
function table(which) {
  const players = layout.value?.players.length ?? 0;
  const curves = which === 'error' ? errorCurves(players, unit.value, scale.pxPerMetre) : bufferCurves(players);
  const rows = rowsOf(memory, curves, 25);
  const decimals = unit.value === 'm' && which === 'error' ? 3 : 1;
  return html`<div class="scroll" tabindex="0" role="region" aria-label=${t('netgame.table')}><table class="data">
    <thead><tr><th scope="col">${t('netgame_more.time')} (s)</th>
    ${curves.map((curve) => html`<th scope="col">${curve.name} (${curve.unit})</th>`)}</tr></thead>
    <tbody>${rows.map(
      (row) => html`<tr><th scope="row">${fixed(row.t, 2)}</th>
      ${row.values.map((value) => html`<td>${value === null ? '–' : fixed(value, decimals)}</td>`)}</tr>`,
    )}
    </tbody></table></div>
    <button type="button" @click=${renew}>${t('netgame_more.refresh')}</button>`;
}

function renew() {
  dialog.value = dialog.value && { ...dialog.value };
}

/** How players are driven, by the keys that do it. */
const DRIVING = ['left_right', 'a_d', 'up_down', 'enter_e', 'arrows', 'shift', 'escape'];
const READING = ['marks', 'spring', 'messages', 'word', 'own', 'cells', 'alpha', 'dots'];

/** @returns {Template} */
export function help() {
  const driving = DRIVING.map((name) => ({ shown: t(`netgame_more.keys.${name}`), help: t(`netgame_more.drive.${name}`) }));
  return html`<table class="keys"><caption>${t('netgame_more.driving')}</caption><tbody>${driving.map(keyRow)}</tbody></table>
    <h3>${t('netgame_more.reading')}</h3>
    <ul>${READING.map((name) => html`<li>${t(`netgame_more.reading.${name}`)}</li>`)}</ul>`;
}

/** @type {NonNullable<import('../../../session/lab.js').Lab['dialogs']>} */
export const dialogs = {
  player: (player) => [
    t('netgame.settings_of', { name: t('netgame_more.of_player', { name: letter(player) }) }),
    settings(`players.${player}`),
  ],
  server: () => [t('netgame_more.server_and_game'), html`${settings('server')}${settings('peers')}${settings('params')}`],
  table: (which) => [which === 'error' ? `${t('netgame.chart.drawn')} (${unit.value})` : t('netgame.chart.buffer_ms'), table(which)],
};
