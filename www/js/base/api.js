// REST calls of the daemon; a refused one throws a Problem (RFC 9457).
import { insist } from './insist.js';
import { ready, said } from './messages.js';
import { placeOf } from './place.js';
import { t } from './words.js';

export { insist };

/** @typedef {{field: string, detail: string}} FieldError */

export class Problem extends Error {
  /** The message and the details of fields are for people: in the page's language, with the names of parameters that the page has
   * when they are read. `detail` is the daemon's sentence.
   * @param {number} status @param {any} body @param {(english: string) => string} [said] */
  constructor(status, body, said = (english) => english) {
    super();
    this.status = status;
    this.detail = String(body?.detail ?? body?.title ?? '');
    this.said = said;
    /** @type {FieldError[]} */
    this.errors = (Array.isArray(body?.errors) ? body.errors : []).map((/** @type {FieldError} */ { field, detail }) => ({
      field,
      get detail() {
        return said(String(detail));
      },
    }));
    this.declined = body?.declined === true; /* the class key was asked for, and not given */
  }
  get message() {
    return this.detail === '' ? t('base.answered', { status: String(this.status) }) : this.said(this.detail);
  }
}

/** The shard that has what the page shows, which is the part of an id or a code before `-`; empty where one daemon is alone. */
let shard = '';

/** @param {string} path that was answered */
function noteShard(path) {
  shard = /^(?:sessions|classes|experiments)\/(\w+)-/.exec(path)?.[1]?.toLowerCase() ?? shard;
}

/** The address of an API path.
 * @param {string} path @returns {URL} */
export const address = (path) => new URL(`api/v1/${path}`, document.baseURI);

/** The stream of a session. @param {string} id @returns {WebSocket} */
export function socketOf(id) {
  const url = address(`sessions/${id}/stream`);
  url.protocol = url.protocol.replace('http', 'ws');
  const socket = new WebSocket(url, ['laglab.v2.bin']);
  socket.binaryType = 'arraybuffer';
  return socket;
}

/** @param {string} path @returns {Promise<ArrayBuffer>} */
export async function bytesOf(path) {
  const answer = await fetch(address(path), { cache: 'no-store' });
  if (!answer.ok) throw await refusal(answer.status, null);
  return answer.arrayBuffer();
}

/** The class key, which some daemons require for creating sessions: the browser keeps it. */
const CLASS_KEY = 'laglab.class_key';

/** @returns {string} */
function classKey() {
  try {
    return localStorage.getItem(CLASS_KEY) ?? '';
  } catch {
    return ''; // a browser that keeps nothing
  }
}

/** @param {string} key */
function keepClassKey(key) {
  try {
    localStorage.setItem(CLASS_KEY, key);
  } catch {
    /* it is asked for again */
  }
}

/** @param {unknown} error @returns {boolean} */
const wantsKey = (error) => error instanceof Problem && [401, 403].includes(error.status);

/** Makes something: with the class key where the daemon wants one, and where the page's sessions are, since a class shows only sessions
 * of its own daemon.
 * @param {string} path @param {unknown} [body] @param {boolean} [ask] whether the request may ask a person for the key
 * @returns {Promise<any>} */
export async function make(path, body, ask = true) {
  const kept = classKey();
  const post = async (/** @type {string} */ key) => {
    const made = await call('POST', shard === '' || path.includes('/') ? path : `${path}${path.includes('?') ? '&' : '?'}shard=${shard}`, {
      body,
      key,
    });
    noteShard(`${path}/${made?.id}`);
    return made;
  };
  try {
    return await post(kept);
  } catch (error) {
    if (!ask || !wantsKey(error)) throw error;
    const { withKey } = await part(() => import('./class_key.js'));
    return withKey(
      async (key) => {
        const made = await post(key);
        keepClassKey(key);
        return made;
      },
      wantsKey,
      kept !== '',
      new Problem(401, { detail: t('base.key_needed'), declined: true }),
    );
  }
}

/** What a daemon says without computing, such as its schema: the page was read below an address that a browser keeps forever, and so are
 * these. @param {string} path @returns {Promise<any>} */
export const constant = (path) => call('GET', path, { kept: placeOf(`api/v1/${path}`) });

/** @param {string} method @param {string} path
 * @param {{body?: unknown, key?: string, kept?: URL, signal?: AbortSignal}} [more] kept: its address in a cache
 * @returns {Promise<any>} the JSON of the answer; null when it has none */
export async function call(method, path, more = {}) {
  /** @type {Record<string, string>} */
  const headers = { Accept: 'application/json' };
  if (more.body !== undefined) headers['Content-Type'] = 'application/json';
  if (more.key) headers.Authorization = `Bearer ${more.key}`;
  const answer = await fetch(more.kept ?? address(path), {
    method,
    headers,
    body: more.body === undefined ? null : JSON.stringify(more.body),
    cache: more.kept ? 'default' : 'no-store',
    signal: more.signal ?? null,
  });
  const text = await answer.text();
  /** @type {any} */
  let body = null;
  try {
    body = text === '' ? null : JSON.parse(text);
  } catch {
    if (answer.ok) throw new Problem(answer.status, { detail: t('base.no_json') });
  }
  if (!answer.ok) throw await refusal(answer.status, body);
  noteShard(path);
  return body;
}

/** @param {number} status @param {any} body @returns {Promise<Problem>} */
async function refusal(status, body) {
  try {
    await ready();
    return new Problem(status, body, said);
  } catch {
    return new Problem(status, body); /* its words do not come: the daemon's */
  }
}

/** A module that is read when it is wanted. When the daemon was away it is read once the daemon answers; browsers that
 * remember the failure (HTML had it so until 2026) load the page again, once.
 * @template T @param {() => Promise<T>} read @returns {Promise<T>} */
export async function part(read) {
  try {
    return await read();
  } catch {
    await insist(() => call('GET', 'scenarios?brief=true'));
    try {
      return await read();
    } catch (error) {
      const [opened] = performance.getEntriesByType('navigation');
      if (/** @type {PerformanceNavigationTiming} */ (opened).type === 'reload') throw error;
      location.reload();
      return new Promise(() => {});
    }
  }
}

/** A style sheet that is read when it is wanted. @param {string} name of a file of www/, without its end
 * @returns {Promise<unknown>} done when it has been read, or cannot be */
export const styleSheet = (name) =>
  new Promise((done) => {
    const sheet = document.createElement('link');
    sheet.rel = 'stylesheet';
    sheet.href = placeOf(`${name}.css`).href;
    sheet.onload = sheet.onerror = done;
    document.head.append(sheet);
  });
