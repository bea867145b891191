// Speed against error: the families, a measurement and its progress, a plot for each problem, who is the cheapest at three levels of error.
import { html, nothing } from '../../../vendor/lit-html.js';
import { effect, signal } from '../../../vendor/signals-core.js';
import { styleSheet } from '../../base/api.js';
import { lookOf, readLink } from '../../base/link.js';
import { need, t } from '../../base/words.js';
import { palette } from '../../draw/palette.js';
import { link } from '../../session/opening.js';
import { choose } from '../../session/session.js';
import { theme } from '../../session/state.js';
import { onto } from '../../workbench/canvas.js';
import { mark } from '../../workbench/player_mark.js';
import { said } from '../../workbench/said.js';
import { answer, cancel, families, job, lastOf, shownFamily, start } from './jobs.js';
import { costOf, csvOf, errorOf, measuredOf, methodOf, nameOf, needNames, numberOf, textOf, titleOf } from './names.js';
import { move, place, write } from './place.js';
import { drawTradeoff, formOf, methodsOf, nearest, pointsOf } from './plot.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('./jobs.js').Answer} Answer */
/** @typedef {import('./jobs.js').Choice} Choice */
/** @typedef {import('./jobs.js').Family} Family */
/** @typedef {import('./jobs.js').Row} Row */

const styled = styleSheet('tradeoff');

const SEEDS = [10, 20, 40, 100];
const seeds = signal(20);
const duration = signal(''); /* empty: that of each series */

/** Methods that are left out of the plots. @type {import('@preact/signals-core').Signal<Set<string>>} */
const hidden = signal(new Set());
/** A place in the rows; -1: none. @type {import('@preact/signals-core').Signal<number>} */
const selected = signal(-1);
/** Problems whose table of all settings is open. @type {import('@preact/signals-core').Signal<Set<number>>} */
const listed = signal(new Set());

const valueOf = (/** @type {Event} */ event) => /** @type {HTMLInputElement | HTMLSelectElement} */ (event.target).value;

/** Costs as they are offered: what is the same on every machine before processor time. @param {Family} family */
const costsOf = ({ costs }) => [...costs.slice(1), ...costs.slice(0, 1)];

/** The number of the shown cost. @param {Family} family */
function shownCost(family) {
  const at = family.costs.findIndex(({ path }) => path === place.value?.cost);
  return at >= 0 ? at : Math.min(1, family.costs.length - 1);
}

// ---- a setting as a live session ----

/** Its address. @param {Row} row */
const hrefOf = (row) => [row.link, ...lookOf({ ...link, theme: theme.value })].join('&');

/** @param {Row} row */
function live(row) {
  history.pushState(null, '', location.href);
  choose(new URLSearchParams(row.link).get('scenario') ?? '', readLink(row.link, '').set, false);
}

/** A link to it, which other tabs can open too. @param {Row} row @param {unknown} content @param {string} [kind] @returns {Template} */
const liveLink = (row, content, kind = '') =>
  html`<a class=${kind} href=${hrefOf(row)} @click=${(/** @type {MouseEvent} */ event) => {
    if (event.ctrlKey || event.metaKey || event.shiftKey) return;
    event.preventDefault();
    live(row);
  }}>${content}</a>`;

// ---- families ----

/** @returns {Template} */
function familyList() {
  return html`<nav class="families" aria-label=${t('tradeoff.families')}><ul>${families.value.map(
    (one) => html`<li><a href=${write({ family: one.name, cost: '', job: lastOf(one.name) })} data-family=${one.name}
      aria-current=${one.name === shownFamily.value?.name ? 'page' : 'false'}>${titleOf(one)}</a></li>`,
  )}</ul></nav>`;
}

// ---- the measurement ----

/** @param {Family} family */
function measure(family) {
  const seconds = Number(duration.value);
  start({ family: family.name, seeds: seeds.value, ...(duration.value === '' ? {} : { duration_s: seconds }) });
}

/** @param {Family} family @returns {Template} */
function order(family) {
  const repeated = answer.value !== undefined;
  return html`<form class="measure" @submit=${(/** @type {Event} */ event) => {
    event.preventDefault();
    measure(family);
  }}>
    <label class="field choice"><span>${t('tradeoff.seeds')}</span><select id="tradeoff-seeds" @change=${(/** @type {Event} */ event) => {
      seeds.value = Number(valueOf(event));
    }}>${SEEDS.map((n) => html`<option value=${n} ?selected=${n === seeds.value}>${n}</option>`)}</select></label>
    <label class="field"><span>${t('tradeoff.duration')}</span><input id="tradeoff-duration" type="number" min="0.05" max="1000"
      step="any" placeholder=${t('tradeoff.own')} .value=${duration.value} @input=${(/** @type {Event} */ event) => {
        duration.value = valueOf(event);
      }}><span class="unit">s</span></label>
    <button class="primary" id="measure">${t(repeated ? 'tradeoff.again' : 'tradeoff.measure')}</button></form>`;
}

/** @param {NonNullable<typeof job.value>} now @returns {Template} */
function progress(now) {
  const done = now.steps > 0 ? t('tradeoff.done', { done: String(now.done), n: now.steps }) : t('tradeoff.starting');
  const stop = now.key === '' ? nothing : html`<button type="button" id="cancel" @click=${() => cancel()}>${t('base.cancel')}</button>`;
  return html`<section class="progress" aria-label=${t('tradeoff.progress')} data-state="running">
      <progress aria-label=${t('tradeoff.progress')} max=${Math.max(1, now.steps)} .value=${now.done}></progress>
      <p><span id="tradeoff-progress">${done}</span>
      ${stop}</p></section>`;
}

/** @param {Family} family @returns {Template} */
function measurement(family) {
  const now = job.value;
  if (now?.state === 'running') return progress(now);
  const why = now?.state === 'failed' || now?.state === 'cancelled' ? said(now.error) : '';
  return html`${
    now === undefined || now.state === 'done'
      ? nothing
      : html`<p class="ended" role="status" data-state=${now.state}>${t(`tradeoff.state.${now.state}`)} ${why}</p>`
  }${order(family)}`;
}

// ---- a plot ----

/** By problem. @type {import('./plot.js').Spot[][]} */
let spots = [];

/** @param {number} problem @param {PointerEvent} event */
function at(problem, event) {
  const box = /** @type {HTMLElement} */ (event.currentTarget).getBoundingClientRect();
  return nearest(spots[problem] ?? [], event.clientX - box.left, event.clientY - box.top);
}

/** @param {Answer} of @param {number} problem @param {PointerEvent} event */
function press(of, problem, event) {
  const index = at(problem, event),
    row = of.rows[index];
  if (!row) return;
  if (selected.value === index) live(row);
  else selected.value = index;
}

/** @param {Answer} of @param {number} problem @param {KeyboardEvent} event */
function key(of, problem, event) {
  const list = spots[problem] ?? [],
    now = list.findIndex(({ index }) => index === selected.value),
    row = of.rows[selected.value];
  const way = ['ArrowRight', 'ArrowUp'].includes(event.key) ? 1 : ['ArrowLeft', 'ArrowDown'].includes(event.key) ? -1 : 0;
  if (event.key === 'Enter' && now >= 0 && row) {
    event.preventDefault();
    live(row);
  } else if (way !== 0 && list.length > 0) {
    event.preventDefault();
    selected.value = list[now < 0 ? 0 : Math.max(0, Math.min(list.length - 1, now + way))]?.index ?? -1;
  }
}

/** Shows a method that is left out of the plots, or leaves it out. @param {string} method */
function toggle(method) {
  const next = new Set(hidden.value);
  if (!next.delete(method)) next.add(method);
  hidden.value = next;
}

/** @param {Answer} of @param {number} problem @returns {Template} */
function legend(of, problem) {
  return html`<div class="key" role="group" aria-label=${t('tradeoff.methods')}>${methodsOf(of, problem).map((method, n) => {
    const { shape, colour } = formOf(n),
      by = of.rows.find((row) => row.method === method)?.by ?? '';
    return html`<button type="button" class="small sample" aria-pressed=${!hidden.value.has(method)} title=${t('tradeoff.toggle')}
      @click=${() => toggle(method)}>${mark(shape, colour)} ${methodOf(of, method, by)}</button>`;
  })}</div><p class="facts">${t('tradeoff.reads')}</p>`;
}

/** What is selected, in words. @param {Answer} of @param {Row} row @param {number} cost */
function words(of, row, cost) {
  const price = of.costs[cost],
    problem = of.problems[row.problem];
  if (!price || !problem) return '';
  const values = {
    name: nameOf(of, row),
    error: `${errorOf(problem)}: ${measuredOf(row.error)}`,
    cost: `${costOf(price)}: ${measuredOf(row.costs[cost])}`,
  };
  return [
    t('tradeoff.says', values),
    row.front[cost] ? t('tradeoff.says.front') : '',
    row.check ? t('tradeoff.says.check', { error: measuredOf(row.check.error), cost: numberOf(row.check.costs[cost]?.[0]) }) : '',
  ].join(' ');
}

/** What can be pressed has another pointer. @param {number} problem @param {PointerEvent} event */
function hover(problem, event) {
  /** @type {HTMLElement} */ (event.currentTarget).style.cursor = at(problem, event) < 0 ? 'default' : 'pointer';
}

/** @param {Answer} of @param {number} problem @param {number} cost @returns {Template} */
function plotOf(of, problem, cost) {
  const row = of.rows[selected.value],
    here = row?.problem === problem ? row : undefined,
    price = of.costs[cost],
    what = of.problems[problem];
  if (!price || !what) return html``;
  const name = t('tradeoff.plot', { error: errorOf(what), cost: costOf(price) });
  return html`<div class="view" role="group" tabindex="0" aria-label=${t('tradeoff.keys')}
      @pointerdown=${(/** @type {PointerEvent} */ event) => press(of, problem, event)}
      @pointermove=${(/** @type {PointerEvent} */ event) => hover(problem, event)}
      @keydown=${(/** @type {KeyboardEvent} */ event) => key(of, problem, event)}><canvas id=${`tradeoff-${problem}`} role="img"
      aria-label=${name}></canvas><take-away data name=${name}></take-away></div>
    ${legend(of, problem)}
    <div class="looked"><output aria-live="polite">${here ? words(of, here, cost) : t('tradeoff.select')}</output>
      ${here ? liveLink(here, t('tradeoff.open'), 'button') : nothing}</div>`;
}

// ---- who is the cheapest ----

/** Whether it was so again. @param {Answer} of @param {Choice} choice @param {Row} row @returns {string} */
function again(of, { cost, level, check_cheapest: best }, { check }) {
  const other = best === null ? undefined : of.rows[best];
  if (!check) return '';
  if (!((check.error[2] ?? Number.POSITIVE_INFINITY) <= level))
    return t('tradeoff.check.error', { error: numberOf(check.error[0]), most: numberOf(check.error[2]) });
  const mine = numberOf(check.costs[cost]?.[0]);
  if (!other || other.check === check) return t('tradeoff.check.cheapest', { cost: mine });
  return t('tradeoff.check.other', { name: nameOf(of, other), cost: numberOf(other.check?.costs[cost]?.[0]), mine });
}

/** A cell under the heading of its column: of text, or of a number. @param {string} column @param {unknown} content
 * @param {boolean} [text] */
const cell = (column, content, text = false) =>
  html`<td class=${text ? 'text' : nothing} data-label=${t(`tradeoff.column.${column}`)}>${content}</td>`;

/** The heading of a column. @param {string} column @param {boolean} [text] */
const heading = (column, text = false) => html`<th scope="col" class=${text ? 'text' : nothing}>${t(`tradeoff.column.${column}`)}</th>`;

/** @param {Answer} of @param {Choice} choice @returns {Template} */
function choiceRow(of, choice) {
  const row = choice.row === null ? undefined : of.rows[choice.row];
  const level = html`<th scope="row" data-label=${t('tradeoff.column.level')}>${numberOf(choice.level)}</th>`;
  if (!row) return html`<tr data-outcome=${choice.outcome}>${level}<td colspan="5" class="text">${t('tradeoff.nothing')}</td></tr>`;
  const held = `tradeoff.outcome.${choice.outcome.replaceAll(' ', '_')}`;
  const tied = choice.as_cheap.map((method) => methodOf(of, method, row.by)).join(', ') || '–';
  return html`<tr data-outcome=${choice.outcome}>${level}${cell('cheapest', liveLink(row, nameOf(of, row)), true)}
    ${cell('error', measuredOf(row.error))}${cell('cost', measuredOf(row.costs[choice.cost]))}
    ${cell('check', html`<span><b>${t(held)}</b> ${again(of, choice, row)}</span>`, true)}
    ${cell('tied', tied, true)}</tr>`;
}

/** @param {Answer} of @param {number} problem @param {number} cost @returns {Template} */
function winners(of, problem, cost) {
  const list = of.choices.filter((one) => one.problem === problem && one.cost === cost);
  const what = of.problems[problem];
  const label = `${t('tradeoff.winners')}: ${what ? errorOf(what) : ''}`;
  return html`<div class="wide-table" tabindex="0" role="region" aria-label=${label}><table
    class="data winners"><caption>${t('tradeoff.winners')}</caption>
    <thead><tr>${heading('level')}${heading('cheapest', true)}${heading('error')}
    ${heading('cost')}${heading('check', true)}${heading('tied', true)}</tr></thead>
    <tbody>${list.map((choice) => choiceRow(of, choice))}</tbody></table></div>`;
}

/** @param {Answer} of @param {Row} row @param {number} cost @returns {Template} */
function settingRow(of, row, cost) {
  const error = row.status === 'ok' ? measuredOf(row.error) : t('workbench.diverged');
  return html`<tr><th scope="row">${liveLink(row, nameOf(of, row))}</th><td>${error}</td>
        <td>${measuredOf(row.costs[cost])}</td><td>${row.front[cost] ? t('tradeoff.yes') : ''}</td></tr>`;
}

/** @param {Answer} of @param {Row[]} rows of one problem @param {number} cost @param {string} label @returns {Template} */
function settingTable(of, rows, cost, label) {
  return html`<div class="scroll" tabindex="0" role="region" aria-label=${label}><table class="data"><thead><tr>${heading('setting', true)}
      ${heading('error')}${heading('cost')}${heading('front')}</tr></thead>
      <tbody>${rows.map((row) => settingRow(of, row, cost))}</tbody></table></div>`;
}

/** Every setting, for those who read rather than point. @param {Answer} of @param {number} problem @param {number} cost
 * @returns {Template} */
function settings(of, problem, cost) {
  const rows = of.rows.filter((row) => row.problem === problem),
    what = of.problems[problem],
    open = listed.value.has(problem),
    title = t('tradeoff.settings', { n: rows.length });
  return html`<details ?open=${open} @toggle=${(/** @type {Event} */ event) => {
    const next = new Set(listed.value);
    if (/** @type {HTMLDetailsElement} */ (event.target).open) next.add(problem);
    else next.delete(problem);
    if (next.has(problem) !== open) listed.value = next;
  }}><summary>${title}</summary>${open ? settingTable(of, rows, cost, `${title}: ${what ? errorOf(what) : ''}`) : nothing}</details>`;
}

// ---- results ----

/** @param {Answer} of */
function download(of) {
  const blob = new Blob([csvOf(of, `${location.origin}${location.pathname}`)], { type: 'text/csv;charset=utf-8' });
  const anchor = document.createElement('a');
  anchor.href = URL.createObjectURL(blob);
  anchor.download = `laglab-tradeoff-${of.name}.csv`;
  anchor.click();
  setTimeout(() => URL.revokeObjectURL(anchor.href), 10000);
}

/** @param {Answer} of @param {number} cost @returns {Template} */
function costChoice(of, cost) {
  const set = (/** @type {Event} */ event) => move({ cost: valueOf(event) });
  const chosen = of.costs[cost]?.path;
  return html`<label class="field choice"><span>${t('tradeoff.cost')}</span><select id="tradeoff-cost"
    @change=${set}>${costsOf(of).map(
      (one) => html`<option value=${one.path} .selected=${one.path === chosen}>${costOf(one)}</option>`,
    )}</select></label>`;
}

/** @param {Answer} of @param {number} problem @param {number} cost @returns {Template} */
function problemSection(of, problem, cost) {
  const what = of.problems[problem],
    id = `tradeoff-title-${problem}`;
  return html`<section class="problem" aria-labelledby=${id}><h3 id=${id}>${what ? errorOf(what) : ''} <small>${what?.scenario}</small></h3>
      ${plotOf(of, problem, cost)}${winners(of, problem, cost)}${settings(of, problem, cost)}</section>`;
}

/** @param {Answer} of @returns {Template} */
function results(of) {
  const cost = shownCost(of);
  return html`<div class="choices">${costChoice(of, cost)}
    <button type="button" id="csv" @click=${() => download(of)}>${t('tradeoff.csv')}</button></div>
    ${cost === 0 ? html`<p class="noisy" role="note">${t('tradeoff.noisy')}</p>` : nothing}
    ${of.problems.map((_, p) => problemSection(of, p, cost))}<p class="facts">${t('tradeoff.explain')}</p>`;
}

/** @returns {Template} */
function template() {
  const family = shownFamily.value,
    found = answer.value;
  return html`<main class="tradeoff" id="views" tabindex="-1"><div class="kinds">${familyList()}</div>
    <div class="content">${
      family === undefined
        ? html`<p class="facts">${t('tradeoff.loading')}</p>`
        : html`<header><h2>${t('session.tradeoff')}: ${titleOf(family)}</h2><p>${textOf(family)}</p></header>
      ${measurement(family)}
      ${found ? results(found) : job.value ? nothing : html`<p class="facts">${t('tradeoff.empty')}</p>`}`
    }</div></main>`;
}

// ---- drawing ----

function draw() {
  const of = answer.value;
  if (!of) return;
  const cost = shownCost(of),
    price = of.costs[cost];
  of.problems.forEach((problem, p) => {
    const points = pointsOf(of, p, cost);
    const levels = [...new Set(of.choices.filter((one) => one.problem === p).map(({ level }) => level))];
    onto(`tradeoff-${p}`, (surface) => {
      spots[p] = drawTradeoff(surface, palette(), points, {
        levels,
        hidden: new Set(methodsOf(of, p).flatMap((method, n) => (hidden.value.has(method) ? [n] : []))),
        selected: selected.value,
        x: price ? costOf(price) : '',
        y: errorOf(problem),
        empty: t('tradeoff.no_points'),
      });
    });
  });
}
let asked = false;
function redraw() {
  if (asked) return;
  asked = true;
  requestAnimationFrame(() => {
    asked = false;
    draw();
  });
}

/* A plot is drawn when it comes into view: no frames of a session make it drawn. */
const viewer = new IntersectionObserver((entries) => {
  if (entries.some(({ isIntersecting }) => isIntersecting)) redraw();
});
/** @type {WeakSet<Element>} */
const watched = new WeakSet();
function rendered() {
  for (const canvas of document.querySelectorAll('.problem canvas')) {
    if (watched.has(canvas)) continue;
    watched.add(canvas);
    viewer.observe(canvas);
  }
  redraw();
}

effect(() => {
  answer.value;
  hidden.value;
  selected.value;
  theme.value;
  place.value;
  redraw();
});
let before = '';
effect(() => {
  /* of another measurement nothing is selected */
  const now = `${shownFamily.value?.name} ${place.value?.job}`;
  if (now === before) return;
  before = now;
  spots = [];
  hidden.value = new Set();
  selected.value = -1;
  listed.value = new Set();
});
effect(() => {
  if (shownFamily.value) needNames(shownFamily.value);
});
effect(() => {
  /* what was measured of a family before is shown again */
  const last = place.value?.job === '' && shownFamily.value ? lastOf(shownFamily.value.name) : '';
  if (last !== '') move({ job: last });
});
addEventListener('resize', redraw);
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);

/** @param {Answer} of @param {number} problem @returns {import('../../session/lab.js').Table} */
function tableOf(of, problem) {
  const cost = shownCost(of);
  return {
    columns: ['method', 'setting', 'value', 'error', 'error_low', 'error_high', 'cost', 'cost_low', 'cost_high', 'front'].map((name) => ({
      name,
      unit: '',
    })),
    rows: pointsOf(of, problem, cost).map(({ index, x, y, front }) => {
      const row = of.rows[index];
      return [row?.method ?? '', row?.setting ?? '', row?.value ?? null, ...y, ...x, front];
    }),
    lines: methodsOf(of, problem).map((method, n) => {
      const paint = palette().players[formOf(n).colour];
      return {
        name: methodOf(of, method, of.rows.find((row) => row.method === method)?.by ?? ''),
        colour: paint?.text ?? '',
        dash: paint?.dash ?? [],
      };
    }),
  };
}

/** @type {import('../../session/lab.js').Lab} */
const lab = {
  template,
  rendered,
  about: () => ({
    title: shownFamily.value ? `${t('session.tradeoff')}: ${titleOf(shownFamily.value)}` : t('session.tradeoff'),
    settings: shownFamily.value ? textOf(shownFamily.value) : '',
    moment: t('tradeoff.settings', { n: answer.value?.rows.length ?? 0 }),
    version: '',
  }),
  tables: async () => {
    const of = answer.value;
    return of ? Object.fromEntries(of.problems.map((_, p) => [`tradeoff-${p}`, () => tableOf(of, p)])) : {};
  },
};

/** With its words and its style. */
export async function load() {
  await Promise.all([need('tradeoff'), styled]);
  return lab;
}
