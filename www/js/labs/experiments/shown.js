// The experiment that is shown: its record, its points, and what one does with them. And the list of one's own.
import { batch, effect, signal } from '../../../vendor/signals-core.js';
import { t } from '../../base/words.js';
import { speak } from '../../session/announce.js';
import { Problem, call, make } from '../../base/api.js';
import { keep } from '../../session/opening.js';
import { show } from '../../session/session.js';
import { showAddress } from '../../session/params.js';
import { experiment, notify } from '../../session/state.js';
import { readSchema } from './draft.js';
import { needKind } from './names.js';
import { Progress, isOver } from './progress.js';

/** @typedef {{id: string, key: string, title: string, state: string, done: number, runs: number}} Kept  key is empty for a reader */
/** @typedef {Record<string, string | number | boolean | null>} Cells */

/** As GET gives it; null before. @type {import('@preact/signals-core').Signal<any>} */
export const record = signal(null);
/** Of the record, whole; null until it is read. @type {import('@preact/signals-core').Signal<any>} */
export const scenario = signal(null);
/** A row of means per point. @type {import('@preact/signals-core').Signal<Cells[]>} */
export const points = signal([]);
/** The selected point, by its index in `points`; -1: none. */
export const selected = signal(-1);
/** Why there is nothing to show: end of the key of its words. */
export const missing = signal('');
/** How the progress comes, for tests and for the curious. */
export const way = signal('');

export const POINTS_MAX = 20000;
const READ_MS = 1500; /* between two readings of the points while it runs */

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
  if (!last && performance.now() - read.at < READ_MS) return;
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

/** @param {string} id */
async function load(id) {
  try {
    const now = await call('GET', `experiments/${id}`);
    const { scenario_id: of = '', scenario: given } = now.experiment;
    const whole = typeof given === 'object' && given !== null ? given : await call('GET', `scenarios/${of || given}`);
    await Promise.all([readSchema(whole.kind), needKind(whole.kind)]);
    if (experiment.value !== id) return;
    scenario.value = whole;
    record.value = now;
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
    selected.value = -1;
    missing.value = '';
  });
  if (id) load(id);
});

/** @param {string} id empty: none */
export function look(id) {
  experiment.value = id;
  showAddress();
}

// ---- what one does ----

/** @param {unknown} error */
const detailOf = (error) => (error instanceof Error ? error.message : t('session.no_answer_now'));

/** @param {object} specification @param {string} title */
export async function run(specification, title) {
  const made = await make('experiments', specification);
  writeKept([{ id: made.id, key: made.owner_key, title, state: 'running', done: 0, runs: made.runs }, ...kept.value]);
  look(made.id);
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

/** The first run of a point as a live session. @param {Cells} row */
export async function live(row) {
  try {
    const scenario = await call('GET', `experiments/${record.value.id}/runs/${runOf(row)}`);
    const paused = matchMedia('(prefers-reduced-motion: reduce)').matches ? { paused: true } : {};
    const { workload } = record.value.experiment;
    const made = await make('sessions', { scenario, ...(workload ? { workload } : {}), ...paused });
    keep(made.id, made.owner_key, false);
    history.pushState(null, '', location.pathname + location.search);
    experiment.value = null;
    show(made.id, made.owner_key, false);
    notify(t('experiments.opened', { n: String(row.point) }));
  } catch (error) {
    notify(t('experiments.not_opened', { detail: detailOf(error) }));
  }
}
