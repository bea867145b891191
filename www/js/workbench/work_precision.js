// Work-precision diagram of a session: writes an experiment with the current parameters, by the kind of the scenario.
import { html } from '../../vendor/lit-html.js';
import { signal } from '../../vendor/signals-core.js';
import { openExperiments } from '../session/session.js';
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
