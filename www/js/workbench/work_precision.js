// From a lab to its methods' errors and costs: an experiment with the current parameters, by the kind of the scenario; the families of
// methods that the daemon measures.
import { html } from '../../vendor/lit-html.js';
import { signal } from '../../vendor/signals-core.js';
import { openExperiments, openTradeoff } from '../session/session.js';
import { params } from '../session/state.js';
import { t } from '../base/words.js';

/** The scenario of which it is wanted; null: none. @type {import('@preact/signals-core').Signal<any>} */
export const workPrecisionOf = signal(null);

function writeExperiment() {
  const scenario = structuredClone(params.value);
  scenario.timeline = [];
  scenario.expect = [];
  workPrecisionOf.value = scenario;
  openExperiments('');
}

/** @returns {import('lit-html').TemplateResult} */
export const workPrecisionButton = () => html`<button type="button" id="speed-against-error"
  title=${t('workbench.diagram_tip')} @click=${writeExperiment}>${t('workbench.diagram')}</button>`;

/** @param {string} family of GET /api/v1/tradeoffs @returns {import('lit-html').TemplateResult} */
export const tradeoffButton = (family) => html`<button type="button" id="to-tradeoff"
  @click=${() => openTradeoff(`#tradeoff=${family}`, true)}>${t('session.tradeoff')}</button>`;
