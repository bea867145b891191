// One dialog at a time, loaded after the first frame: help, links to share, and those of the lab that is shown.
import { html, nothing, render } from '../../vendor/lit-html.js';
import { effect } from '../../vendor/signals-core.js';
import { address } from '../base/api.js';
import { THEMES, writeQuery } from '../base/link.js';
import { lab } from '../session/labs.js';
import { link } from '../session/opening.js';
import { params, session, theme } from '../session/state.js';
import { sync } from '../workbench/controls.js';
import { dialog as open } from '../workbench/dialog.js';
import { keyRow } from '../workbench/key_row.js';
import { keys, setSingleKeys, setTheme, singleKeys } from './keys.js';
import { scenarioList } from './scenarios.js';
import { t } from '../base/words.js';

/** @typedef {import('lit-html').TemplateResult} Template */

/** @returns {Template} */
function help() {
  const onKeys = (/** @type {Event} */ event) => setSingleKeys(/** @type {HTMLInputElement} */ (event.target).checked);
  const themes = THEMES.map((name) => html`<option value=${name} ?selected=${name === theme.value}>${t(`shell.theme.${name}`)}</option>`);
  return html`<label class="toggle"><input type="checkbox" .checked=${singleKeys.value}
      @change=${onKeys}><span>${t('shell.single_keys')}</span></label>
    <label class="field choice"><span>${t('shell.colours')}</span><select .value=${theme.value}
      @change=${(/** @type {Event} */ event) => setTheme(/** @type {HTMLSelectElement} */ (event.target).value)}>
      ${themes}</select></label>
    <div class="columns"><table class="keys"><caption>${t('shell.keys')}</caption><tbody>${keys().map(keyRow)}</tbody></table>
    <div>${lab.value?.help?.() ?? nothing}</div></div>`;
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
  return html`${local ? html`<p class="reason">${t('shell.local')}</p>` : nothing}
    ${address_(t('shell.share_settings'), base + writeQuery(link))}
    ${address_(t('shell.share_session'), `${base}#s=${id}`)}
    <p><a href=${address(`sessions/${id}/trace`).href} download="laglab.csv">${t('shell.trace')}</a></p>
    ${
      params.value?.kind === 'netgame'
        ? html`<p><a href=${address(`sessions/${id}/packets`).href} download="laglab.pcapng">${t('shell.packets')}</a></p>`
        : nothing
    }
    <p>${t('shell.api')} <code>curl ${address(`sessions/${id}`).href}</code></p>`;
}

/** @param {import('../session/lab.js').Dialog} at @returns {[string, Template] | undefined} title and content */
function content({ kind, of }) {
  if (kind === 'help') return [t('shell.help'), help()];
  if (kind === 'scenarios') return scenarioList();
  if (kind === 'share') return [t('shell.share'), share()];
  return lab.value?.dialogs?.[kind]?.(of);
}

const dialog = document.createElement('dialog');
dialog.setAttribute('aria-labelledby', 'dialog-title');

/** @returns {boolean} whether there is something to show */
function draw() {
  const at = open.value;
  if (at === null) return false;
  const [title, body] = content(at) ?? [];
  if (title === undefined) return false; /* its lab is not read yet */
  render(
    html`<header><h2 id="dialog-title">${title}</h2><button type="button" class="close"
      @click=${() => dialog.close()}>${t('shell.close')}</button></header>
    <div class="body">${body}</div>`,
    dialog,
  );
  sync(dialog);
  return true;
}

export function listen() {
  document.body.append(dialog);
  dialog.addEventListener('close', () => {
    open.value = null;
  });
  dialog.addEventListener('click', (event) => {
    if (event.target === dialog) dialog.close();
  });
  effect(() => {
    const shown = draw();
    if (shown && !dialog.open) dialog.showModal();
    if (!shown && dialog.open) dialog.close(); /* it was of the lab before */
  });
}
