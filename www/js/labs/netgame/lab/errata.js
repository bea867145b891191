// Where the paper says one thing of a network and the lab shows another, below the text of the scenario in which it arises.
import { html, nothing } from '../../../../vendor/lit-html.js';
import { t } from '../../../base/words.js';
import { params } from '../../../session/state.js';

/** By the figure or section, in small letters: ends of the keys of their texts. @type {Record<string, string[]>} */
const ERRATA = {
  network_physics: ['distance'],
  figure_6: ['lag'],
  figure_8: ['faster'],
  figure_10: ['lag'],
  figure_11: ['lag', 'in_sync'],
  dejittering_buffer: ['arrival'],
  interpolation: ['guess'],
  interpolation_when_the_server_is_down: ['guess'],
  deterministic_lockstep: ['ignored'],
};

/** @returns {import('lit-html').TemplateResult | typeof nothing} */
export function errata() {
  const place = String(params.value?.paper ?? '').toLowerCase(),
    list = ERRATA[place.replace(/[^a-z0-9]+/g, '_')] ?? [];
  if (list.length === 0) return nothing;
  return html`<table class="data errata"><caption>${t('netgame_more.errata')}</caption>
    <thead><tr><th scope="col">${t('netgame_more.paper')}</th><th scope="col">${t('netgame_more.lab')}</th></tr></thead><tbody>${list.map(
      (one) => html`<tr><td>${t(`netgame_more.paper_says.${one}`)}</td><td>${t(`netgame_more.lab_shows.${one}`)}</td></tr>`,
    )}</tbody></table>`;
}
