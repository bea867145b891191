// Speed against error: a question, a plot of error against cost with two handles, the cheapest within both, which runs next to the truth.
import { html, nothing } from '../../../vendor/lit-html.js';
import { effect, signal } from '../../../vendor/signals-core.js';
import { styleSheet } from '../../base/api.js';
import { need, t } from '../../base/words.js';
import { paintOf, palette } from '../../draw/palette.js';
import { labs, tabOf } from '../../session/labs.js';
import { theme } from '../../session/state.js';
import { mark } from '../../workbench/player_mark.js';
import { said } from '../../workbench/said.js';
import { drawn, redraw } from './drawing.js';
import { slider } from './handles.js';
import { again, changes, leaveAll, runs, states, want } from './live.js';
import * as name from './names.js';
import { liveLink } from './open.js';
import { pictureOf } from './pictures.js';
import { place, write } from './place.js';
import { formOf, nearestSpot } from './plot.js';
import { cancel, families, job, mine, shippedAnswer, shownFamily, start } from './results.js';
import { methodOf, sentence } from './sentence.js';
import { all, dark, lines, methods, now, rows, selected, show, shownCost, shownError } from './state.js';
import { tables } from './tables.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('./results.js').Family} Family */
/** @typedef {import('./results.js').Row} Row */
/** @typedef {import('./state.js').Now} Now */

const styled = styleSheet('tradeoff');
const listed = signal(false); /* the tables are open */

// ---- families ----

/** A whole one: of `#…` alone a page is expected to have that part. @param {string} family */
const addressOf = (family) => new URL(write({ family, error: 0, cost: '', budget: null, enough: null }), location.href).href;

/** @returns {Template} */
function familyTabs() {
  return html`<nav class="families" aria-label=${t('tradeoff.families')}><ul>${families.value.map(
    (one) => html`<li><a href=${addressOf(one.name)} data-family=${one.name}
      aria-current=${one.name === shownFamily.value?.name ? 'page' : 'false'}><svg viewBox="0 0 64 40"
      aria-hidden="true">${pictureOf(one.name)}</svg>
      <span><b>${t(`tradeoff.tab.${one.name}`)}</b><small>${t(`tradeoff.how.${one.name}`)}</small></span></a></li>`,
  )}</ul></nav>`;
}

// ---- the plot ----

/** @param {PointerEvent} event */
function point(event) {
  const target = /** @type {HTMLElement} */ (event.target);
  if (target.tagName !== 'CANVAS' || !drawn.plot) return;
  const box = target.getBoundingClientRect(),
    index = nearestSpot(drawn.plot.of.spots, event.clientX - box.left, event.clientY - box.top);
  selected.value = index;
  dark.value = rows.value[index]?.method ?? '';
}

/** Only one line is dark, or none is pale. @param {string} method */
function darken(method) {
  dark.value = dark.value === method ? '' : method;
  selected.value = -1;
}

/** A few words to choose from. @param {string} label @param {{text: string, chosen: boolean, take: () => void, id: string}[]} list
 * @returns {Template | typeof nothing} */
function choice(label, list) {
  if (list.length < 2) return nothing;
  return html`<div class="segments" role="group" aria-label=${label}>${list.map(
    ({ text, chosen, take, id }) => html`<button type="button" aria-pressed=${chosen} data-choice=${id} @click=${take}>${text}</button>`,
  )}</div>`;
}

/** @param {Family} family @returns {Template} */
function choices(family) {
  const costs = family.costs.map((cost, c) => ({
    text: name.briefCostOf(cost),
    chosen: c === shownCost.value,
    take: () => show({ cost: cost.path }),
    id: cost.path,
  }));
  const n = methods.value.length,
    shown = all.value ? n : (now.value?.named.length ?? 0);
  return html`<header><p>${t('tradeoff.of_methods', { shown, n })}</p>
    ${choice(
      t('tradeoff.which_error'),
      family.problems.map((problem, p) => ({
        text: name.problemOf(problem),
        chosen: p === shownError.value,
        take: () => show({ error: p }),
        id: String(p),
      })),
    )}<span class="cost">${t('tradeoff.cost')} ${choice(t('tradeoff.cost'), [...costs.slice(1), ...costs.slice(0, 1)])}</span></header>`;
}

/** A point in words. @param {Now} at @returns {Template | typeof nothing} */
function readout(at) {
  const row = rows.value[selected.value];
  if (!row) return nothing;
  const words = t('tradeoff.says', {
    name: name.nameOf(at.family, row),
    error: `${name.errorOf(at.error)}: ${name.measuredOf(row.error)}`,
    cost: `${name.costOf(at.cost)}: ${name.measuredOf(row.costs[shownCost.value])}`,
  });
  return html`<p class="readout" role="status">${words} ${liveLink(row, t('tradeoff.open'))}</p>`;
}

/** @param {Now} at @returns {Template} */
function plot(at) {
  const label = t('tradeoff.plot', { error: name.errorOf(at.error), cost: name.costOf(at.cost) });
  return html`<div class="view plot" @pointerup=${point}><canvas id="tradeoff" role="img" aria-label=${label}></canvas>
    ${at.named.map(
      (method) => html`<button type="button" class="end" data-method=${method} aria-pressed=${dark.value === method}
      aria-label=${t('tradeoff.only', { name: methodOf(at, method) })} @click=${() => darken(method)}></button>`,
    )}${slider(at, 'budget')}${slider(at, 'enough')}<take-away data name=${label}></take-away></div>${readout(at)}
    ${
      all.value
        ? html`<div class="key" role="group" aria-label=${t('tradeoff.methods')}>${at.order.map((method) => {
            const { shape, colour } = formOf(at.order.indexOf(method));
            return html`<button type="button" class="small sample" aria-pressed=${dark.value === method} @click=${() => darken(method)}>
              ${mark(shape, colour)} ${methodOf(at, method)}</button>`;
          })}</div>`
        : nothing
    }`;
}

// ---- the runs ----

/** What a scenario's tab is called. @param {number} side */
function tabName(side) {
  states.value;
  const run = runs.value[side];
  const game = run?.layout?.game ?? run?.layout?.params?.game ?? run?.kind ?? '',
    id = tabOf(game);
  const tab = labs.value.flatMap(({ tabs }) => tabs).find((one) => one.id === id);
  return tab ? t(tab.name) : '';
}

/** How a run ends, as the drawing shows it. @param {Now} at @param {number} side */
function outcome(at, side) {
  states.value;
  const run = runs.value[side],
    row = run?.row;
  if (!run || !row) return '';
  if (row.error[0] === null) return t('workbench.diverged');
  if (run.kind === 'motion' && run.state === 'done' && drawn.runs[side]?.factor === 0)
    return t('tradeoff.run', { paid: name.priceOf(at.cost.path, row.costs[shownCost.value]?.[0] ?? 0), off: t('tradeoff.on_it') });
  return t(name.ownKey('tradeoff.run', at.family), {
    paid: name.priceOf(at.cost.path, row.costs[shownCost.value]?.[0] ?? 0),
    cost: name.paidOf(at.cost, row.costs[shownCost.value]?.[0] ?? 0),
    off: name.offOf(at.error, row.error[0]),
  });
}

/** @param {Now} at @param {number} side 0: the cheapest, 1: its rival @returns {Template | typeof nothing} */
function scene(at, side) {
  const run = runs.value[side],
    method = side === 0 ? at.best.method : at.rival;
  if (method === '') return nothing;
  const title = methodOf(at, method),
    words = outcome(at, side),
    still = run ? name.stillOf(at.family, run.row) : null;
  return html`<figure class="run" data-run=${side} data-state=${run?.state ?? 'waiting'}><figcaption><b>${title}</b><span>${words}</span>${
    still
      ? html`<span class="still">${t('tradeoff.still', { still: name.brief(still.still), of: name.brief(still.of) })}
      <progress max=${still.of} .value=${still.still} aria-hidden="true"></progress></span>`
      : nothing
  }</figcaption>
    <div class="view"><canvas id=${`live-${side}`} role="img" aria-label=${`${title}: ${words}`}></canvas></div>
    ${run?.state === 'failed' ? html`<p class="facts">${t('tradeoff.not_run')}</p>` : nothing}</figure>`;
}

/** @param {Now} at @returns {Template} */
function liveRuns(at) {
  const row = rows.value[at.best.index],
    tab = tabName(0),
    fluid = name.kindOf(at.error.scenario) === 'fluid',
    title = t(fluid ? 'tradeoff.live_colours' : name.ownKey('tradeoff.live', at.family));
  return html`<section class="live" data-scenario=${at.error.scenario} aria-label=${title}><header><h3>${title}</h3>
    ${fluid ? nothing : html`<small>${t(name.ownKey('tradeoff.dashed', at.family))}</small>`}</header>${scene(at, 0)}${scene(at, 1)}
    <p class="do">${row ? liveLink(row, tab === '' ? t('tradeoff.open') : t('tradeoff.open_in', { tab }), 'main') : nothing}
    <button type="button" id="again" @click=${() => again()}><svg class="icon" viewBox="0 0 12 12" aria-hidden="true"><path
    d="M2 1l9 5-9 5z"></path></svg> ${t('tradeoff.again')}</button></p></section>`;
}

// ---- where the numbers come from ----

/** @param {string | undefined} date */
const dateOf = (date) =>
  date ? new Date(date).toLocaleDateString(document.documentElement.lang, { day: 'numeric', month: 'short', year: 'numeric' }) : '';

/** @param {Family} family @returns {Template} */
function source(family) {
  const made = shippedAnswer.value,
    one = job.value,
    running = one?.state === 'running';
  const facts = { version: (made?.version ?? '').slice(0, 8), machine: made?.machine ?? '', date: dateOf(made?.date) },
    some = one?.answer !== null && one?.answer !== undefined;
  const here = one?.state === 'done' ? t('tradeoff.here', { date: dateOf(one.date) }) : '';
  const progress = one && one.steps > 0 ? t('tradeoff.done', { done: String(one.done), n: one.steps }) : t('tradeoff.starting');
  const why = one?.state === 'failed' ? `${t('tradeoff.state.failed')} ${said(one.error)}` : '';
  return html`<footer class="source"><p id="tradeoff-source">${here} ${
    made ? t(some ? 'tradeoff.hollow' : 'tradeoff.shipped', facts) : nothing
  }</p>${
    running
      ? html`<span class="progress" data-state="running"><progress aria-label=${t('tradeoff.progress')} max=${Math.max(1, one.steps)}
      .value=${one.done}></progress> <span id="tradeoff-progress">${progress}</span>
      ${mine.value ? html`<button type="button" id="cancel" @click=${() => cancel()}>${t('base.cancel')}</button>` : nothing}</span>`
      : html`<button type="button" id="measure" @click=${() => start(family.name, all.value ? 'all' : undefined)}>${t(
          one?.state === 'done' ? 'tradeoff.measure_again' : 'tradeoff.measure',
        )}</button>`
  }${some ? nothing : html`<small>${t('tradeoff.as_they_come')}</small>`}
    ${why ? html`<p role="alert">${why}</p>` : nothing}
    <span class="more">${
      methods.value.length > (now.value?.named.length ?? 0)
        ? html`<button type="button" id="all-methods" aria-pressed=${all.value} @click=${() => {
            all.value = !all.value;
          }}>${all.value ? t('tradeoff.few') : t('tradeoff.all', { n: methods.value.length })}</button>`
        : nothing
    }
    <button type="button" id="tables" aria-expanded=${listed.value} @click=${() => {
      listed.value = !listed.value;
    }}>${t('tradeoff.table_csv')}</button></span></footer>`;
}

/** @returns {Template} */
function template() {
  const family = shownFamily.value,
    at = now.value;
  if (!family || !at) return html`<main class="tradeoff" id="views" tabindex="-1"><div class="reading"><p>laglab</p></div></main>`;
  const label = t('tradeoff.plot', { error: name.errorOf(at.error), cost: name.costOf(at.cost) });
  const hint = t(name.ownKey('tradeoff.hint', family));
  return html`<main class="tradeoff" id="views" tabindex="-1"><div class="ask"><h2>${name.questionOf(family)}</h2><p>${hint}</p></div>
    ${familyTabs()}<section class="work" aria-label=${label}>${choices(family)}
    ${shownCost.value === 0 ? html`<p class="noisy" role="note">${t('tradeoff.noisy')}</p>` : nothing}${plot(at)}</section>
    ${sentence(at)}${liveRuns(at)}${source(family)}${listed.value ? tables(family) : nothing}</main>`;
}

/* A plot is drawn when it comes into view: no frames of a session make it drawn. */
const viewer = new IntersectionObserver((entries) => {
  if (entries.some(({ isIntersecting }) => isIntersecting)) redraw({ plot: true, runs: true });
});
const sizes = new ResizeObserver(() => redraw({ plot: true, runs: true }));
/** @type {WeakSet<Element>} */
const watched = new WeakSet();
let familyBefore = '';
/** On a phone the families do not all fit: the one that is shown does. */
function showTab() {
  const family = shownFamily.value?.name ?? '',
    tab = document.querySelector('.families a[aria-current="page"]'),
    row = tab?.closest('nav');
  if (family === familyBefore || !row || !(tab instanceof HTMLElement)) return;
  familyBefore = family;
  row.scrollLeft = tab.offsetLeft - row.offsetLeft - (row.clientWidth - tab.offsetWidth) / 2;
}

function rendered() {
  showTab();
  for (const canvas of document.querySelectorAll('.tradeoff canvas')) {
    if (watched.has(canvas)) continue;
    watched.add(canvas);
    viewer.observe(canvas);
    if (canvas.parentElement) sizes.observe(canvas.parentElement);
  }
  redraw({ plot: true, runs: true });
}

effect(() => {
  now.value;
  lines.value;
  dark.value;
  selected.value;
  theme.value;
  redraw({ plot: true });
});
effect(() => {
  changes.value;
  runs.value;
  theme.value;
  redraw({ runs: true });
});
effect(() => {
  const at = now.value;
  if (place.value === null) leaveAll();
  else if (at) want([rows.value[at.best.index], rows.value[at.tries]], () => at.error);
});
effect(() => {
  if (shownFamily.value) name.needNames(shownFamily.value);
});
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => redraw({ plot: true, runs: true }));

/** @param {Now} at @returns {import('../../session/lab.js').Table} */
function tableOf(at) {
  return {
    columns: ['method', 'setting', 'value', 'error', 'error_low', 'error_high', 'cost', 'cost_low', 'cost_high', 'front'].map((one) => ({
      name: one,
      unit: '',
    })),
    rows: at.shown.map(({ index, costs, errors }) => {
      const row = rows.value[index];
      return [row?.method ?? '', row?.setting ?? '', row?.value ?? null, ...errors, ...costs, row?.front[shownCost.value] === true];
    }),
    lines: at.named.map((method) => {
      const paint = paintOf(palette(), formOf(at.order.indexOf(method)).colour);
      return { name: methodOf(at, method), colour: paint.text, dash: paint.dash };
    }),
  };
}

/** @type {import('../../session/lab.js').Lab} */
const lab = {
  template,
  rendered,
  about: () => ({
    title: shownFamily.value ? `${t('session.tradeoff')}: ${name.titleOf(shownFamily.value)}` : t('session.tradeoff'),
    settings: shownFamily.value ? name.textOf(shownFamily.value) : '',
    moment: t('tradeoff.settings', { n: rows.value.length }),
    version: '',
  }),
  tables: async () => {
    const at = now.value;
    return { tradeoff: () => at && tableOf(at) };
  },
  facts: () => ({
    tradeoff: {
      enumerable: true,
      get: () => {
        const at = now.value,
          plot = drawn.plot?.at === at ? drawn.plot : null;
        return (
          at && {
            family: at.family.name,
            problem: shownError.value,
            lines: lines.value,
            winner: at.winner ? rows.value[at.winner.index] : null,
            rival: at.rival,
            ring: plot?.of.ring ?? null,
            rivalAt: plot?.of.rival ?? null,
            points: at.shown.length,
            here: at.shown.filter(({ here }) => here).length,
            runs: runs.value.map((run, side) => run && { state: run.state, link: run.row.link, ...drawn.runs[side] }),
          }
        );
      },
    },
  }),
};

/** With its words and its style. */
export async function load() {
  await Promise.all([need('tradeoff'), styled]);
  return lab;
}
