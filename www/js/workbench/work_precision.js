// Work-precision diagram of a session: writes an experiment with the current parameters, by the kind of the scenario.
import { html } from '../../vendor/lit-html.js';
import { openExperiments } from '../session/session.js';
import { params, workPrecisionOf } from '../session/state.js';

function writeExperiment() {
  const scenario = structuredClone(params.value);
  scenario.timeline = [];
  scenario.expect = [];
  workPrecisionOf.value = scenario;
  openExperiments('');
}

/** @returns {import('lit-html').TemplateResult} */
export const workPrecisionButton = () => html`<button type="button" id="speed-against-error"
  title="Writes an experiment: error and processor time of every method, over its settings" @click=${writeExperiment}>Work-precision diagram</button>`;
