// What a lesson shows in place of the views, where they do not show what its sentences are about: a hit, and worlds that wait.
import { html } from '../../../../vendor/lit-html.js';
import { signal } from '../../../../vendor/signals-core.js';
import { fixed, letter } from '../../../base/format.js';
import { t } from '../../../base/words.js';
import { palette } from '../../../draw/palette.js';
import { look, params } from '../../../session/state.js';
import { onto } from '../../../workbench/canvas.js';
import { mark } from '../../../workbench/player_mark.js';
import { layout } from '../core/layout.js';
import { memory } from '../core/state.js';
import { drawFlight } from './flight.js';
import { drawDecided, drawSeen, hitOf } from './hit.js';
import { drawPace, paceWords } from './pace.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('../core/frame.js').Frame} Frame */

/** The views are shown instead. */
export const views = signal(false);

/** @param {string} id @param {Template} head @param {string} label @param {string} [lit] what a lesson highlights in it
 * @returns {Template} */
const box = (id, head, label, lit = '') => html`<section class="part" aria-label=${label}>
  <div class="heading">${head}</div><div class="view" data-shows=${lit}><canvas id=${id} role="img" aria-label=${label}></canvas><take-away
    name=${label}></take-away></div></section>`;

const victim = () => look.value?.player ?? 0;

/** @returns {Template} */
function hitTemplate() {
  const a = victim(),
    b = a === 0 ? 1 : 0;
  const saw = html`${mark(b)}<b id="hit-saw"></b><span id="hit-age"></span>`,
    own = html`${mark(a)}<b id="hit-screen"></b><span id="hit-back"></span>`;
  return html`${box('hit-seen', saw, t('netgame_more.hit.saw', { name: letter(b) }))}
    ${box('hit-own', own, t('netgame_more.hit.screen', { name: letter(a) }), 'cover')}`;
}

/** @returns {Template} */
function paceTemplate() {
  const title = t('netgame_more.pace.title'),
    head = html`<b>${title}</b><small>${t('netgame_more.pace.legend')}</small><span id="pace-says" class="marked"></span>`;
  return box('pace', head, title, 'waiting');
}

/** @returns {Template} */
function flightTemplate() {
  const title = t('netgame_more.flight.title'),
    tested = params.value?.server?.projectile_trace === 'parabola';
  return box(
    'flight',
    html`<b>${title}</b><small>${t(tested ? 'netgame_more.flight.legend.parabola' : 'netgame_more.flight.legend')}</small>`,
    title,
    'path',
  );
}

/** What is drawn, by the look of the lesson. @type {Record<string, () => Template>} */
const TEMPLATES = { cover: hitTemplate, path: flightTemplate, waiting: paceTemplate };

/** @param {boolean} to the views @param {string} text @returns {Template} */
const swap = (to, text) =>
  html`<p class="swap"><button type="button" class="link" @click=${() => {
    views.value = to;
  }}>${text}</button></p>`;

/** @returns {Template} */
export function template() {
  const at = look.value?.at ?? '';
  return html`<main class="closeups" data-tab="all">
    <div class="parts" id="views" tabindex="-1">${TEMPLATES[at]?.()}</div>
    ${swap(true, t(at === 'waiting' ? 'netgame_more.pace.views' : 'netgame_more.hit.views'))}</main>`;
}

/** The way back. @returns {Template} */
export const back = () => swap(false, t('netgame_more.back'));

const WIDE = 900; /* px: what is drawn large has large letters */

/** @param {import('../../../draw/surface.js').Surface} surface */
function coloursOf({ width }) {
  const colours = palette();
  return width < WIDE ? colours : { ...colours, text: colours.text + 2 };
}

/** @param {string} id @param {string} text */
function tell(id, text) {
  const element = document.getElementById(id);
  if (element && element.textContent !== text) element.textContent = text;
}

/** @param {string} id @param {string} text */
const name = (id, text) => document.getElementById(id)?.setAttribute('aria-label', text);

/** @param {Frame} now @param {import('../core/layout.js').Layout} shape @param {boolean} named */
function drawHit(now, shape, named) {
  const a = victim(),
    b = a === 0 ? 1 : 0,
    hit = hitOf(now, shape, a),
    again = look.value?.step === 5;
  const at = (/** @type {import('../../../draw/surface.js').Surface} */ surface) => {
    const { pen, width, height } = surface;
    return { pen, width, height, colours: coloursOf(surface), frame: now, layout: shape, victim: a, again };
  };
  onto('hit-seen', (surface) => drawSeen(at(surface), hit));
  onto('hit-own', (surface) => drawDecided(at(surface), hit));
  const age = fixed(hit?.age ?? now.views[1 + b]?.view_age_ms ?? 0, 0),
    saw = t(hit ? 'netgame_more.hit.saw' : 'netgame_more.hit.sees', { name: letter(b) }),
    screen = t(hit ? 'netgame_more.hit.screen' : 'netgame_more.hit.own', { name: letter(a) }),
    old = t('netgame_more.hit.age', { name: letter(a), ms: age }),
    back = hit === null ? '' : hit.back < 1 ? t('netgame_more.hit.not_back') : t('netgame_more.hit.back', { ms: fixed(hit.back, 0) });
  tell('hit-saw', saw);
  tell('hit-age', old);
  tell('hit-screen', screen);
  tell('hit-back', back);
  document.getElementById('hit-back')?.classList.toggle('marked', hit?.hit ?? false);
  if (!named) return;
  name('hit-seen', `${saw}: ${old}`);
  name('hit-own', back === '' ? screen : `${screen}: ${back}`);
}

/** @param {Frame} now @param {import('../core/layout.js').Layout} shape */
function drawShell(now, shape) {
  const { projectile_speed_mps: speed = 0, gravity_mps2: gravity = 0 } = params.value?.params ?? params.value ?? {};
  const parabola = params.value?.server?.projectile_trace === 'parabola';
  onto('flight', (surface) => {
    const { pen, width, height } = surface;
    drawFlight({ pen, width, height, colours: coloursOf(surface), frame: now, layout: shape, player: victim(), speed, gravity, parabola });
  });
}

/** @param {Frame} now @param {boolean} named */
function drawWaits(now, named) {
  const at = {
    frame: now,
    memory,
    player: victim(),
    warmup: Number(params.value?.warmup_s ?? 0),
    delay: Number(params.value?.players?.[victim()]?.input_delay_ticks ?? 0),
    before: look.value?.before ?? null,
  };
  onto('pace', (surface) => {
    const { pen, width, height } = surface,
      drawing = { ...at, pen, width, height, colours: coloursOf(surface) };
    drawPace(drawing);
    tell('pace-says', now.tick > 0 ? paceWords(drawing) : '');
    if (named) name('pace', `${t('netgame_more.pace.title')}: ${paceWords(drawing)}`);
  });
}

/** @param {Frame} now @param {boolean} named whether what is drawn is said in words, too */
export function draw(now, named) {
  const shape = layout.value;
  if (shape === null) return;
  if (look.value?.at === 'cover') drawHit(now, shape, named);
  else if (look.value?.at === 'path') drawShell(now, shape);
  else drawWaits(now, named);
}
