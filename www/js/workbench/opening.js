// What is to be seen in the scene that a lab opens on: one that fails next to one that holds.
import { html, nothing } from '../../vendor/lit-html.js';
import { labs } from '../session/labs.js';
import { link } from '../session/opening.js';
import { lesson, params, session } from '../session/state.js';

/** @param {string} text @returns {import('lit-html').TemplateResult | typeof nothing} nothing in every other scene */
export function opening(text) {
  const first = labs.value.find(({ kind }) => kind === params.value?.kind)?.tabs[0]?.scenario,
    shown = session.value?.own && lesson.value === null && link.scenario === first && Object.keys(link.set).length === 0;
  return shown ? html`<p class="see">${text}</p>` : nothing;
}
