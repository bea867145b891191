// Changes parameters of the session: the last value wins while one request is under way.
import { call, Problem } from '../base/api.js';
import { lab } from './labs.js';
import { keep, link } from './opening.js';
import { lookOf, writeLesson, writeQuery } from '../base/link.js';
import { experiment, lesson, locked, notify, params, place, presenting, session, theme, tradeoff, usable } from './state.js';
import { t } from '../base/words.js';

/** @typedef {import('../base/link.js').Value} Value */

/** @type {Map<string, Value>} */
let pending = new Map();
/** @type {Record<string, Value>} those of the request that is under way */
let asked = {};
/** @type {Promise<void> | null} */
let sending = null;

export const seen = { version: -1, patches: 0 };

/** Whether the daemon has yet to answer a change of this value. @param {string} path */
export const unanswered = (path) => pending.has(path) || path in asked;

/** @param {Record<string, Value>} change values by dotted path @returns {Promise<void>} when the daemon has them */
export function change(change) {
  if (locked.value !== '' || !Object.keys(change).every(usable)) return Promise.resolve();
  for (const [path, value] of Object.entries(change)) pending.set(path, value);
  sending ??= send().finally(() => {
    sending = null;
  });
  return sending;
}

async function send() {
  const target = session.value;
  while (pending.size > 0 && target !== null && target === session.value) {
    const body = Object.fromEntries(pending);
    asked = body;
    pending = new Map();
    try {
      seen.patches++;
      const answer = await call('PATCH', `sessions/${target.id}/params`, { body, key: target.key }).finally(() => {
        asked = {};
      });
      if (target !== session.value) break; /* what is left was meant for that one */
      seen.version = answer.params_version;
      remember(body); /* first: what is drawn for the new values reads the link */
      accept(answer.params, body);
    } catch (error) {
      const detail = error instanceof Problem ? (error.errors[0]?.detail ?? error.message) : t('session.no_answer');
      notify(t('session.not_changed', { detail }));
      params.value = { ...params.value }; /* controls go back to what holds */
    }
  }
  pending = new Map();
}

/** Reports what the daemon changed in addition to the request.
 * @param {any} now @param {Record<string, Value>} asked */
function accept(now, asked) {
  const before = params.value;
  params.value = now;
  const followed = lab.peek()?.followed?.(now, before, asked) ?? [];
  if (followed.length > 0) notify(followed.join('. '));
}

/** The address keeps what differs from the scenario. @param {Record<string, Value>} body */
function remember(body) {
  for (const [path, value] of Object.entries(body)) {
    if (!path.endsWith('.control')) link.set[path] = value;
  }
  showAddress();
}

export function showAddress() {
  const now = session.value,
    shown = experiment.value;
  link.theme = theme.value;
  link.present = presenting.value;
  const look = lookOf(link).join('&'),
    colours = look === '' ? '' : `?${look}`;
  if (shown !== null || lesson.value !== null) {
    const hash = lesson.value !== null ? writeLesson(lesson.value) : (tradeoff.value ?? `#experiments${shown === '' ? '' : `=${shown}`}`);
    history.replaceState(null, '', location.pathname + colours + hash);
    return;
  }
  if (now === null) return;
  const query = now.own ? writeQuery(link) : colours;
  const at = [now.own ? '' : `s=${now.id}`, link.second].filter((text) => text !== '').join('&');
  const hash = place.value.at || (at && `#${at}`);
  history.replaceState(null, '', location.pathname + query + hash);
  if (now.own) keep(now.id, now.key, true);
}

/** @type {{id: string, control: AbortController} | null} */
let reading = null;

/** A session that is about to be deleted is no longer asked for: the answer would be a 404. @param {string} id */
export function stopReading(id) {
  if (reading?.id === id) reading.control.abort();
}

/** Reads the parameters again, after another client changed them or time jumped. @param {number} version */
export async function reread(version) {
  const target = session.value,
    { patches } = seen;
  if (target === null || sending !== null || seen.version === version) return;
  seen.version = version;
  reading?.control.abort(); /* its answer would be older */
  reading = { id: target.id, control: new AbortController() };
  try {
    const answer = await call('GET', `sessions/${target.id}`, { signal: reading.control.signal });
    if (target !== session.value) return;
    if (patches === seen.patches) params.value = answer.params;
    else if (seen.version === version) seen.version = -1; /* older than a change that is not done: to be read again */
  } catch {
    /* the stream says when the daemon is away */
  }
}
