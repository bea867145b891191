// The experiment that is shown: its record, its points, and what one does with them. And the list of one's own.
import { batch, effect, signal } from '../../../vendor/signals-core.js';
import { t } from '../../base/words.js';
import { speak } from '../../session/announce.js';
import { Problem, call, make } from '../../base/api.js';
import { keep } from '../../session/opening.js';
import { show } from '../../session/session.js';
import { showAddress } from '../../session/params.js';
import { experiment, notify } from '../../session/state.js';
import { readSchema, start } from './form/draft.js';
import { IDS, OWN, examples } from './examples.js';
import { needKind } from './form/names.js';
import { Progress, isOver } from './progress.js';

/** @typedef {{id: string, key: string, title: string, state: string, done: number, runs: number}} Kept  key is empty for a reader */
/** @typedef {Record<string, string | number | boolean | null>} Cells */

/** As GET gives it; null before. @type {import('@preact/signals-core').Signal<any>} */
export const record = signal(null);
/** Of the record, whole; null until it is read. @type {import('@preact/signals-core').Signal<any>} */
export const scenario = signal(null);
/** A row of means per point. @type {import('@preact/signals-core').Signal<Cells[]>} */
export const points = signal([]);
/** Points of the run before, where the same was run: until their own come. @type {import('@preact/signals-core').Signal<Cells[]>} */
export const before = signal([]);
/** The finished experiments that ship with the page. @type {import('@preact/signals-core').Signal<import('./examples.js').Example[]>} */
export const finished = signal([]);
/** The selected point, by its index in `points`; -1: none. */
export const selected = signal(-1);
/** Why there is nothing to show: end of the key of its words. */
export const missing = signal('');
/** How the progress comes, for tests and for the curious. */
export const way = signal('');

export const POINTS_MAX = 20000;
const READ_MS = 1500 /* between two readings of the points while it runs */,
  FEW_MS = 300,
  FEW = 200; /* where they are no more than this */

// ---- one's own ----

const KEPT = 'laglab.experiments',
  KEPT_MAX = 50;

/** @returns {Kept[]} newest first */
function readKept() {
  try {
    const list = JSON.parse(localStorage.getItem(KEPT) ?? '[]');
    return Array.isArray(list) ? list.filter((one) => typeof one?.id === 'string') : [];
  } catch {
    /* storage may be forbidden: the list then lasts as long as the page */
    return [];
  }
}
export const kept = signal(readKept());

/** @param {Kept[]} list */
function writeKept(list) {
  kept.value = list.slice(0, KEPT_MAX);
  try {
    localStorage.setItem(KEPT, JSON.stringify(kept.value));
  } catch {
    /* as above */
  }
}

/** @param {string} id @param {Partial<Kept>} change */
function note(id, change) {
  if (kept.value.some((one) => one.id === id)) writeKept(kept.value.map((one) => (one.id === id ? { ...one, ...change } : one)));
}

export const keyOf = (/** @type {string} */ id) => kept.value.find((one) => one.id === id)?.key ?? '';

/** Brings the list up to date; what the daemon no longer has goes. */
export async function renewKept() {
  await Promise.all(
    kept.value.map(async ({ id, state }) => {
      if (isOver(state) && state !== 'done') return;
      try {
        const now = await call('GET', `experiments/${id}`);
        note(id, { state: now.state, done: now.done, runs: now.runs });
      } catch (error) {
        if (error instanceof Problem && error.status === 404) writeKept(kept.value.filter((one) => one.id !== id));
      }
    }),
  );
}

// ---- the one that is shown ----

/** @type {Progress | null} */
let progress = null;
let reading = false;
let read = { at: -Infinity, done: -1 };

/** Reads the points when there are more of them, not too often. @param {string} id @param {boolean} last */
async function readPoints(id, last) {
  const now = record.value;
  if (reading || now?.id !== id || now.points > POINTS_MAX || now.done === read.done) return;
  if (!last && performance.now() - read.at < (now.points <= FEW ? FEW_MS : READ_MS)) return;
  reading = true;
  const done = now.done;
  try {
    const rows = await call('GET', `experiments/${id}/results?points=true&format=json`);
    if (experiment.value === id) {
      points.value = rows;
      read = { at: performance.now(), done };
    }
  } catch {
    /* the next progress asks again */
  }
  reading = false;
  if (isOver(record.value?.state) && record.value.done !== read.done) setTimeout(() => readPoints(id, true), 200);
}

/** @param {string} id @param {import('./progress.js').Report} report */
function follow(id, report) {
  if (record.value?.id !== id) return;
  const before = record.value.state;
  record.value = { ...record.value, state: report.state, done: report.done, rate_per_s: report.rate_per_s, left_s: report.left_s };
  way.value = progress?.way ?? '';
  note(id, { state: report.state, done: report.done });
  if (report.state !== before) speak('experiment', t(`experiments.spoken.${report.state}`, { done: report.done, n: record.value.runs }));
  readPoints(id, isOver(report.state));
}

/** The experiment that was begun here, which is what is written already. */
let begun = '';

/** The whole scenario of an experiment, when the names of its kind are there. @param {any} of */
async function scenarioOf({ scenario_id: id = '', scenario: given }) {
  const whole = typeof given === 'object' && given !== null ? given : await call('GET', `scenarios/${id || given}`);
  await Promise.all([readSchema(whole.kind), needKind(whole.kind)]);
  return whole;
}

/** One that ships with the page, as if it were the daemon's. @param {string} id */
async function loadFinished(id) {
  finished.value = await examples();
  const found = finished.value.find((one) => one.id === (id || IDS[0]));
  if (!found) return;
  const whole = await scenarioOf(found.experiment);
  if (experiment.value !== id) return;
  const { experiment: of, points: rows } = found,
    runs = rows.reduce((sum, row) => sum + Number(row.runs), 0);
  batch(() => {
    scenario.value = whole;
    record.value = { id: '', ships: found.id, state: 'done', runs, done: runs, points: rows.length, repeats: of.repeats, experiment: of };
    points.value = rows;
  });
  start(of, whole);
}

/** @param {string} id */
async function load(id) {
  try {
    if (id === '' || IDS.includes(id)) return await loadFinished(id);
    finished.value = await examples();
    const now = await call('GET', `experiments/${id}`);
    const whole = await scenarioOf(now.experiment);
    if (experiment.value !== id) return;
    scenario.value = whole;
    record.value = now;
    if (id !== begun) start(now.experiment, whole);
    note(id, { state: now.state, done: now.done, runs: now.runs });
    progress = new Progress(id, (report) => follow(id, report));
    readPoints(id, true);
  } catch (error) {
    if (experiment.value !== id) return;
    const gone = error instanceof Problem && error.status === 404;
    missing.value = gone ? 'gone' : 'no_answer';
    if (gone) writeKept(kept.value.filter((one) => one.id !== id));
  }
}

effect(() => {
  const id = experiment.value;
  progress?.close();
  progress = null;
  read = { at: -Infinity, done: -1 };
  batch(() => {
    record.value = null;
    scenario.value = null;
    points.value = [];
    before.value = [];
    selected.value = -1;
    missing.value = '';
  });
  if (id !== null && id !== OWN) load(id);
});

/** @param {string} id empty: none */
export function look(id) {
  experiment.value = id;
  showAddress();
}

// ---- what one does ----

/** @param {unknown} error */
const detailOf = (error) => (error instanceof Error ? error.message : t('session.no_answer_now'));

/** @param {object} specification @param {string} title @param {boolean} again whether its points replace those that are shown */
export async function run(specification, title, again) {
  const made = await make('experiments', specification),
    old = again ? points.value : [];
  begun = made.id;
  writeKept([{ id: made.id, key: made.owner_key, title, state: 'running', done: 0, runs: made.runs }, ...kept.value]);
  look(made.id);
  before.value = old;
  speak('experiment', t('experiments.spoken.started', { n: made.runs }));
}

/** @param {'pause' | 'resume' | 'cancel'} op */
export async function control(op) {
  const id = record.value.id;
  try {
    const now = await call('POST', `experiments/${id}/control`, { body: { op }, key: keyOf(id) });
    if (op === 'resume') progress ??= new Progress(id, (report) => follow(id, report));
    follow(id, now);
  } catch (error) {
    notify(t('session.not_done', { detail: detailOf(error) }));
  }
}

/** Deletes one of one's own. @param {string} id */
export async function remove(id) {
  try {
    await call('DELETE', `experiments/${id}`, { key: keyOf(id) });
  } catch (error) {
    if (!(error instanceof Problem) || error.status !== 404) {
      notify(t('experiments.not_deleted', { detail: detailOf(error) }));
      return;
    }
  }
  writeKept(kept.value.filter((one) => one.id !== id));
  if (experiment.value === id) look('');
}

/** The first run of a point. @param {Cells} row */
export const runOf = (row) => Number(row.point) * record.value.repeats;

/** The first run of a point, as a session is made of it. @param {Cells} row */
async function firstRun(row) {
  const { id, experiment: of } = record.value;
  if (id !== '') return { scenario: await call('GET', `experiments/${id}/runs/${runOf(row)}`) };
  const varied = of.axes.map((/** @type {any} */ { path }) => [path, row[path]]);
  return { scenario: of.scenario, set: { ...of.set, ...Object.fromEntries(varied) } };
}

/** The same as a live session. @param {Cells} row */
export async function live(row) {
  try {
    const paused = matchMedia('(prefers-reduced-motion: reduce)').matches ? { paused: true } : {};
    const { workload } = record.value.experiment;
    const made = await make('sessions', { ...(await firstRun(row)), ...(workload ? { workload } : {}), ...paused });
    keep(made.id, made.owner_key, false);
    history.pushState(null, '', location.pathname + location.search);
    experiment.value = null;
    show(made.id, made.owner_key, false);
    notify(t('experiments.opened', { n: String(row.point) }));
  } catch (error) {
    notify(t('experiments.not_opened', { detail: detailOf(error) }));
  }
}
