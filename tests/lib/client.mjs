// HTTP and stream clients of the tests: nothing is followed, repeated or repaired on the way.
import http from 'node:http';
import net from 'node:net';
import WebSocket from 'ws';
import './inflate_raw.mjs';
import { Decoder } from '../../www/js/stream/decode.js';
import { RECORDS } from '../../www/js/stream/records.js';

/** What takes longer hangs: no busy machine needs it. */
export const HANG_MS = 60000;

/** Every channel at 60 Hz. */
export const EVERYTHING = Object.fromEntries(RECORDS.map(({ channel }) => [channel, 60]));

/** The seq of a binary frame. @param {Buffer} data */
export function seqOf(data) {
  let value = 0,
    scale = 1;
  for (let at = 2; ; at++, scale *= 128) {
    value += (data[at] % 128) * scale;
    if (data[at] < 128) return value;
  }
}

/** @typedef {{status: number, headers: http.IncomingHttpHeaders, text: string, json: any}} Answer */

/** A client of the daemon at `url`. `call` sends `body` as JSON unless it is text or bytes. @param {string} url */
export function client(url, maxSockets = 64) {
  const agent = new http.Agent({ keepAlive: true, maxSockets });
  /**
   * @param {string} method @param {string} path
   * @param {{body?: any, key?: string, headers?: Record<string, string>, type?: string | null, timeout?: number}} [wish]
   * @returns {Promise<Answer>}
   */
  function call(method, path, wish = {}) {
    const headers = { ...wish.headers };
    let body = wish.body;
    if (body !== undefined) {
      if (typeof body !== 'string' && !Buffer.isBuffer(body)) body = JSON.stringify(body);
      if (wish.type !== null) headers['content-type'] ??= wish.type ?? 'application/json';
      headers['content-length'] = String(Buffer.byteLength(body));
    }
    if (wish.key !== undefined) headers.authorization = `Bearer ${wish.key}`;
    return new Promise((resolve, reject) => {
      const request = http.request(new URL(path, url), { method, headers, agent, timeout: wish.timeout ?? 2 * HANG_MS }, (response) => {
        const parts = [];
        response.on('data', (part) => parts.push(part));
        response.on('error', reject);
        response.on('end', () => {
          const text = Buffer.concat(parts).toString('utf8');
          const is_json = /[/+]json\b/.test(response.headers['content-type'] ?? '');
          resolve({ status: response.statusCode, headers: response.headers, text, json: is_json && text ? JSON.parse(text) : undefined });
        });
      });
      request.on('timeout', () => request.destroy(new Error(`${method} ${path} was not answered`)));
      request.on('error', reject);
      request.end(body);
    });
  }
  return {
    url,
    call,
    get: (path, wish) => call('GET', path, wish),
    close: () => agent.destroy(),
    /** Makes a session and gives its 201 answer. */
    async make(order = {}) {
      const answer = await call('POST', '/api/v1/sessions', { body: { scenario: 'race', ...order } });
      if (answer.status !== 201) throw new Error(`no session: ${answer.status} ${answer.text}`);
      return answer.json;
    },
    control: (session, op) => call('POST', `/api/v1/sessions/${session.id}/control`, { key: session.owner_key, body: op }),
    patch: (session, patch) => call('PATCH', `/api/v1/sessions/${session.id}/params`, { key: session.owner_key, body: patch }),
    stream: (session, format, wish) => openStream(url, `sessions/${session.id}`, format, wish),
    progress: (id) => openStream(url, `experiments/${id}`),
    attend: (id) => openStream(url, `classes/${id}`),
  };
}

/**
 * A viewer. `messages` holds all texts as objects; `frames` all frames (objects, or Buffers). With `ack` it acknowledges each frame.
 * @param {string} url @param {string} place `sessions/ID` or `experiments/ID` @param {'json' | 'bin'} [format]
 * `subscribe` is what it gets (everything; null: it does not say).
 * @param {{ack?: boolean, subscribe?: any, origin?: string, headers?: Record<string, string>}} [wish]
 */
export async function openStream(url, place, format = 'json', wish = {}) {
  const socket = new WebSocket(`${url.replace(/^http/, 'ws').replace(/\/$/, '')}/api/v1/${place}/stream`, `laglab.v2.${format}`, {
    origin: wish.origin,
    headers: wish.headers,
    perMessageDeflate: false,
  });
  const stream = {
    socket,
    messages: [],
    frames: [],
    hello: undefined,
    closed: undefined,
    say: (message) => socket.send(typeof message === 'string' ? message : JSON.stringify(message)),
    /** The first message that `test` takes, now or later. */
    wait: (test, what = 'a message', ms = HANG_MS) => waitFor(() => stream.messages.find(test), what, ms),
    frame: (test = (/** @type {any} */ _) => true, ms = HANG_MS) => waitFor(() => [...stream.frames].reverse().find(test), 'a frame', ms),
    close: () =>
      new Promise((resolve) => {
        if (socket.readyState === WebSocket.CLOSED) resolve(undefined);
        socket.once('close', resolve);
        socket.close();
      }),
  };
  socket.on('message', (/** @type {Buffer} */ data, binary) => {
    if (binary) {
      stream.frames.push(data);
      if (wish.ack) stream.say({ ack: seqOf(data) });
      return;
    }
    const message = JSON.parse(data.toString('utf8'));
    if (message.type === 'frame') {
      stream.frames.push(message);
      if (wish.ack) stream.say({ ack: message.seq });
      return;
    }
    stream.messages.push(message);
    if (message.type === 'hello') stream.hello = message;
  });
  socket.on('close', (code, reason) => {
    stream.closed = { code, reason: reason.toString() };
  });
  await new Promise((resolve, reject) => {
    socket.once('open', resolve);
    socket.once('error', reject);
    socket.once('unexpected-response', (_, response) =>
      reject(Object.assign(new Error(`upgrade answered ${response.statusCode}`), { status: response.statusCode })),
    );
  });
  socket.on('error', () => {});
  if (wish.subscribe !== null && place.startsWith('sessions/')) stream.say({ subscribe: wish.subscribe ?? EVERYTHING });
  await waitFor(() => stream.hello || stream.closed, 'the hello'); // the daemon closes it after --hello-timeout-s, 20
  if (!stream.hello) throw Object.assign(new Error(`closed with ${stream.closed.code}: ${stream.closed.reason}`), stream.closed);
  return stream;
}

/** Polls until `test` gives something true. @template T @param {() => T} test @returns {Promise<T>} */
export async function waitFor(test, what = 'it', ms = HANG_MS) {
  const end = performance.now() + ms;
  for (;;) {
    const value = await test();
    if (value) return value;
    if (performance.now() > end) throw new Error(`waited ${ms} ms for ${what}`);
    await pause(5);
  }
}

/** Whether a head has come. @param {string} said */
export const headed = (said) => said.includes('\r\n\r\n');

export const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

/** Sends bytes on a connection of its own and gives what came until it was closed, `until` takes it or `ms` passed.
 * @returns {Promise<{text: string, closed: boolean, ms: number}>} */
export function raw(at, bytes, ms = HANG_MS, until = (/** @type {string} */ _) => /** @type {boolean} */ (false)) {
  return new Promise((resolve) => {
    const begun = performance.now();
    let text = '';
    const socket = typeof at === 'number' ? net.connect(at, '127.0.0.1') : at;
    socket.write(bytes);
    const end = (closed) => {
      clearTimeout(timer);
      socket.destroy();
      resolve({ text, closed, ms: performance.now() - begun });
    };
    const timer = setTimeout(() => end(false), ms);
    socket.on('data', (/** @type {Buffer} */ part) => {
      text += part.toString('latin1');
      if (until(text)) end(false);
    });
    socket.on('error', () => end(true));
    socket.on('close', () => end(true));
  });
}

/** Decodes all binary frames in order; resolves when the last is read. @param {Buffer[]} frames @param {number} tickHz */
export async function decodeAll(frames, tickHz) {
  const decoder = new Decoder(RECORDS, tickHz);
  /** @type {any[]} */
  const read = [];
  const all = [...frames]; /* more come meanwhile */
  for (const bytes of all)
    decoder.decode(
      new Uint8Array(bytes).buffer,
      (frame) => read.push(frame),
      (error) => {
        throw error;
      },
    );
  while (read.length < all.length) await pause(1);
  return read;
}
