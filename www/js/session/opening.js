// Asks the daemon for the session that the address says, and opens its stream. The first thing that runs, while the rest of the page is
// read.
import { Problem, call, make, socketOf } from '../base/api.js';
import { readLink, readScenario } from '../base/link.js';
import { t } from '../base/words.js';

/** own: made from the query, not from #s=; note: key of the words of its message.
 * @typedef {{id: string, key: string, own: boolean, note: string}} Opened */
/** @typedef {import('../stream/connection.js').Line} Line */

export const link = readLink(location.search, location.hash);

/** What was ignored of the address, in words; empty where nothing was. */
export const problems = () => link.problems.map(([key, values]) => t(key, values)).join('. ');

/** @param {string} key @param {Record<string, string>} values @param {() => string} detail in words, when they are shown */
const ignored = (key, values, detail) =>
  link.problems.push([
    key,
    {
      ...values,
      get detail() {
        return detail();
      },
    },
  ]);

/** @type {Record<string, import('./lab.js').Slow>} by scenario */
let slows = {};
/** How the scenario of the link is slowed; undefined where it is not. */
export const slowOf = () => slows[link.scenario];

const KEPT = 'laglab';

/** Keys stay in this tab, by session, with the query that made the tab's own session.
 * @returns {{own: {id: string, query: string} | null, keys: Record<string, string>}} */
function kept() {
  try {
    const value = JSON.parse(sessionStorage.getItem(KEPT) ?? 'null');
    if (value && typeof value.keys === 'object') return value;
  } catch {
    /* storage may be forbidden: the page works without it */
  }
  return { own: null, keys: {} };
}

/** @param {string} id @param {string} key @param {boolean} own */
export function keep(id, key, own) {
  const value = kept();
  value.keys[id] = key;
  if (own) value.own = { id, query: location.search };
  try {
    sessionStorage.setItem(KEPT, JSON.stringify(value));
  } catch {
    /* as above */
  }
}

/** The key of a session, as far as this tab has it. @param {string} id */
export const keyOf = (id) => kept().keys[id] ?? '';

/** Takes what the daemon refused out of the link. Returns false when nothing was found to take out.
 * @param {Problem} problem @returns {boolean} */
function dropRefused(problem) {
  const before = link.problems.length;
  for (const one of problem.errors) {
    const path = one.field.replace(/^set\./, '');
    if (path in link.set) {
      ignored('session.bad_value', { path, value: String(link.set[path]) }, () => one.detail);
      delete link.set[path];
    } else if (path.startsWith('workload') && link.workload !== null) {
      ignored('base.bad_workload', {}, () => one.detail);
      link.workload = null;
    } else if (path === 'seed' && link.seed !== null) {
      ignored('session.bad_seed', { seed: String(link.seed) }, () => one.detail);
      link.seed = null;
    }
  }
  if (link.problems.length > before) return true;
  const named = Object.keys(link.set).find((path) => problem.detail.includes(path));
  if (named !== undefined) {
    ignored('session.bad_value', { path: named, value: String(link.set[named]) }, () => problem.message);
    delete link.set[named];
  } else if (Object.keys(link.set).length > 0 && problem.status !== 404) {
    ignored('session.bad_changes', {}, () => problem.message);
    link.set = {};
  } else if (link.scenario !== link.first) {
    ignored('session.bad_scenario', { scenario: link.scenario, first: link.first }, () => problem.message);
    link.scenario = link.first;
    link.set = {};
  } else {
    return false;
  }
  return true;
}

/** A new session of what the link says; values that the daemon refuses are dropped and listed in `link.problems`.
 * @param {Record<string, unknown>} [how] paused, speed @returns {Promise<Opened>} */
export async function create(how = {}) {
  for (;;) {
    const slow = slowOf(),
      first = slow?.from_s === 0 ? { speed: slow.speed, ...how } : how;
    const more = matchMedia('(prefers-reduced-motion: reduce)').matches ? { paused: true, ...first } : first;
    const seed = link.seed === null ? {} : { seed: link.seed };
    const set = Object.keys(link.set).length === 0 ? {} : { set: link.set },
      workload = link.workload === null ? {} : { workload: link.workload };
    try {
      const made = await make('sessions', { scenario: link.scenario, ...set, ...seed, ...workload, ...more });
      keep(made.id, made.owner_key, true);
      return { id: made.id, key: made.owner_key, own: true, note: '' };
    } catch (error) {
      const refused = error instanceof Problem && [400, 404, 409, 422].includes(error.status);
      if (!refused || !dropRefused(error)) throw error;
    }
  }
}

/** A session of the first page's own: it runs while it is driven. @param {import('./lab.js').Start} start @returns {Promise<Opened>} */
export function createFirst({ scenario, set, seed }) {
  Object.assign(link, { scenario, set: { ...set }, seed, workload: null, session: '', problems: [] });
  return create({ paused: false });
}

/** @returns {Promise<Opened>} */
async function open() {
  const { own, keys } = kept();
  if (link.session) {
    const key = link.key || keys[link.session] || '';
    if (key) keep(link.session, key, false);
    try {
      await call('GET', `sessions/${link.session}`);
      return { id: link.session, key, own: false, note: '' };
    } catch (error) {
      if (!(error instanceof Problem) || error.status !== 404) throw error;
      history.replaceState(null, '', location.pathname + location.search);
      link.session = '';
      return { ...(await create()), note: 'session.expired' };
    }
  }
  if (own && own.query === location.search && keys[own.id]) {
    /* the tab was reloaded */
    try {
      const now = await call('GET', `sessions/${own.id}`);
      if (now.status !== 'failed') return { id: own.id, key: keys[own.id] ?? '', own: true, note: '' };
    } catch {
      /* it no longer exists: create a new one */
    }
  }
  return create();
}

/** @param {Opened} made @returns {Line} */
function listen({ id }) {
  /** @type {Line} */
  const line = { socket: socketOf(id), said: [] };
  line.socket.onmessage = (message) => line.said.push(message);
  return line;
}

/** Opens what the address says. @param {import('../base/link.js').Short[]} shorts @param {Record<string, import('./lab.js').Slow>} slow
 * @param {import('./lab.js').Start | undefined} start of the first page
 * @returns {{opened: Promise<Opened>, line: Promise<Line>} | null} null while the Experiments view or a lesson is shown, where a
 *  lab makes a session when it is wanted, and in a class, which has one */
export function begin(shorts, slow, start) {
  slows = slow;
  readScenario(link, location.search, location.hash, shorts);
  document.documentElement.dataset.theme = link.theme;
  if (link.key) history.replaceState(null, '', `${location.pathname}${location.search}#s=${link.session}`);
  if (link.room !== null) {
    document.documentElement.dataset.class = 'join'; /* the rest is hidden until the class says what to show */
    if (link.roomKey) history.replaceState(null, '', `${location.pathname}${location.search}#class=${link.room}`);
  }
  const first = link.lesson?.id === '' ? start : undefined;
  if (link.experiment !== null || (link.lesson !== null && first === undefined) || link.room !== null) return null;
  const opened = first ? createFirst(first) : open(),
    line = opened.then(listen);
  line.catch(() => {}); /* the code that awaits the session reports it */
  return { opened, line };
}
