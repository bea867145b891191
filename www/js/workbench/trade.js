// From a session to its speed against error: an experiment with the parameters of now, written for its kind.
import { html } from '../../vendor/lit-html.js';
import { openExperiments } from '../lab.js';
import { params, traded } from '../state.js';

function trade() {
  const scenario = structuredClone(params.value);
  scenario.timeline = [];
  scenario.expect = [];
  traded.value = scenario;
  openExperiments('');
}

/** @returns {import('lit-html').TemplateResult} */
export const tradeButton = () => html`<button type="button" id="speed-against-error"
  title="Writes an experiment: every method, by its setting, with its error and the processor's time" @click=${trade}>Speed against error</button>`;
