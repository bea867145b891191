// The stream of one session: hello, frames, replies; reconnects by itself until it is closed. Where WebSockets are blocked it asks for the
// frames one by one.
import { Problem, bytesOf, call, socketOf } from '../base/api.js';
import { Decoder } from './decode.js';
import { RECORDS, SCHEMA } from './records.js';

const SILENCE_MS = 2000; /* then ask for a sign of life */
const DEAD_MS = 5000;
const BACKOFF_MS = 200,
  BACKOFF_MAX_MS = 2000;

const POLL_MS = 60; /* between an answer and the next question */
const BLOCKED_AFTER = 3; /* sockets that failed one after the other although the daemon answers, of a page that has had a stream */
const SOCKET_AGAIN_MS = 10000;

/** Whether this page has had a hello from a socket: until then a failure is not a loss. */
let had = false;

/** ms until a page of a class tries again: 1, 2, 4, 8 s and up to one more, so that thirty do not come at once.
 * @param {number} attempt from 1 */
export const patience = (attempt) => 1000 * (Math.min(8, 2 ** (attempt - 1)) + Math.random());

/** A stream without a listener so far, and its messages. @typedef {{socket: WebSocket, said: MessageEvent[]}} Line */

/** @typedef {import('./handlers.js').Handlers} Handlers */
/** @typedef {import('./handlers.js').State} State */

/** Closes a socket that is no longer used. A browser complains of one that is still connecting: that is closed once it is open.
 * @param {WebSocket} socket */
export function leave(socket) {
  socket.onclose = socket.onmessage = null;
  if (socket.readyState === WebSocket.CONNECTING) socket.onopen = () => socket.close();
  else socket.close();
}

export class Stream {
  /** @param {string} id @param {string} key @param {Handlers} on @param {Line | undefined} line @param {Record<string, number>} wish
   * @param {boolean} [patient] whether many pages may lose their streams at once, as in a class */
  constructor(id, key, on, line, wish, patient = false) {
    this.id = id;
    this.key = key;
    this.patient = patient;
    this.on = on;
    this.attempt = 0;
    this.closed = false;
    this.heard = 0; /* when the last message came, ms */
    /** Subscription: of each channel its rate, Hz. @type {Record<string, number>} */
    this.wish = wish;
    this.decoder = new Decoder(RECORDS, 60);
    /** @type {WebSocket | null} */
    this.socket = null;
    this.answers = 0; /* of the daemon, since the last socket that opened */
    this.polled = false;
    this.from = 0; /* when polling began, ms */
    this.event = -1; /* the first that has not come */
    this.generation = 0;
    this.count = 0;
    /** Inputs that are sent without a socket. @type {Promise<unknown>} */
    this.inputs = Promise.resolve();
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    this.timer = undefined;
    this.watch = setInterval(() => this.check(), 1000);
    /* While hidden nothing is drawn, so nothing is asked for: that silence says nothing. */
    this.seen = () => {
      this.heard = performance.now();
      this.subscribe(this.wish);
    };
    document.addEventListener('visibilitychange', this.seen);
    this.open(line);
  }

  /** @param {Line} [line] that was opened before */
  open(line) {
    const socket = line && line.socket.readyState <= WebSocket.OPEN ? line.socket : socketOf(this.id);
    this.socket = socket;
    this.heard = performance.now();
    const greet = () => {
      this.subscribe(this.wish);
      if (this.key) this.send({ auth: this.key, id: 0 });
    };
    const take = (/** @type {MessageEvent} */ message) => {
      if (socket !== this.socket) return;
      this.heard = performance.now();
      if (typeof message.data === 'string') this.text(message.data);
      else this.binary(message.data);
    };
    socket.onopen = greet;
    socket.onmessage = take;
    socket.onclose = () => {
      if (socket === this.socket) this.lost();
    };
    if (socket !== line?.socket) return;
    greet(); /* if it is open */
    line.said.forEach(take);
  }

  /** @param {string} data */
  text(data) {
    const message = JSON.parse(data);
    if (message.type === 'hello') {
      had = true;
      this.polled = false;
      this.greeted(message, 'open');
    } else if (message.type === 'rate') {
      this.on.pace(Number(message.divisor));
    } else if (message.type === 'error') {
      this.on.refused(String(message.problem?.detail ?? message.problem?.title ?? 'refused'));
    }
  }

  /** @param {any} hello @param {State} state */
  greeted(hello, state) {
    this.attempt = this.answers = 0;
    this.meet(hello);
    this.on.hello(hello);
    this.on.state(state, 0);
  }

  /** Reads what follows by the daemon's own tables, where they are not those of this page. @param {any} hello */
  meet(hello) {
    const decoder = new Decoder(RECORDS, hello.tick_hz);
    if (hello.schema !== SCHEMA) decoder.learn(call('GET', 'stream/schema.json').then(({ records }) => records));
    this.decoder = decoder;
  }

  /** @param {ArrayBuffer} data */
  binary(data) {
    const { decoder } = this;
    const current = () => decoder === this.decoder && !this.closed; /* decoding can take longer than the connection lasts */
    decoder.decode(
      data,
      (frame) => {
        if (!current()) return;
        if (this.polled) this.note(frame);
        this.on.frame(frame);
      },
      () => {
        if (current()) this.lost();
      },
    );
  }

  /** Subscribes; to nothing while the page is hidden. @param {Record<string, number>} wish */
  subscribe(wish) {
    this.wish = wish;
    this.send({ subscribe: document.hidden ? {} : wish });
  }

  /** Asks for a sign of life after a silence, gives the socket up after a longer one. */
  check() {
    if (this.socket === null || document.hidden) return;
    const silence = performance.now() - this.heard;
    if (silence > DEAD_MS) this.lost();
    else if (silence > SILENCE_MS) this.send({ ping: Math.round(performance.now()) });
  }

  lost() {
    const socket = this.socket;
    this.socket = null;
    if (socket) leave(socket);
    if (this.closed || this.polled) return;
    this.attempt++;
    if (!had && this.attempt === 1) {
      this.retry();
      return;
    }
    this.on.state('lost', this.attempt);
    const backoff = Math.min(BACKOFF_MAX_MS, BACKOFF_MS * 2 ** (this.attempt - 1));
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.retry(), this.patient ? patience(this.attempt) : backoff * (0.5 + Math.random() / 2));
  }

  /** What a stream would have said of a frame, and what the next question is for. @param {import('./decode.js').Frame} frame */
  note(frame) {
    const events = frame.sections.get('events'),
      { generation } = frame.session;
    frame.seq = ++this.count;
    this.event = events && generation === this.generation ? events.first + events.count : -1;
    this.generation = generation;
  }

  /** Asks for frames, one after the other, until a socket opens. */
  async poll() {
    const again = () => !this.closed && this.polled;
    this.polled = true;
    this.from = performance.now();
    this.event = -1;
    try {
      const hello = await call('GET', `sessions/${this.id}/hello`);
      if (!again()) return;
      this.greeted(hello, 'polled');
      while (again()) {
        const events = this.event < 0 ? '' : `&from_event=${this.event}`;
        const frame = document.hidden
          ? null
          : await bytesOf(`sessions/${this.id}/frame?channels=${Object.keys(this.wish).join(',')}${events}`);
        if (frame && again()) this.binary(frame);
        await new Promise((done) => setTimeout(done, POLL_MS));
        if (performance.now() - this.from > SOCKET_AGAIN_MS && again()) this.tryAgain();
      }
    } catch {
      if (!again()) return;
      this.polled = false;
      this.lost();
    }
  }

  /** A socket while it still asks, which takes over when it opens. */
  tryAgain() {
    this.from = performance.now();
    if (this.socket === null) this.open();
  }

  async retry() {
    try {
      await call('GET', `sessions/${this.id}`);
    } catch (error) {
      if (this.closed) return;
      this.answers = 0;
      if (error instanceof Problem && (error.status === 404 || error.status === 410)) {
        this.close();
        this.on.gone();
      } else {
        this.lost();
      }
      return;
    }
    if (this.closed) return;
    if (had && ++this.answers <= BLOCKED_AFTER) this.open();
    else this.poll();
  }

  /** @param {any} message */
  send(message) {
    if (this.polled && message.input)
      this.inputs = this.inputs
        .then(() => call('POST', `sessions/${this.id}/input`, { body: message.input, key: this.key }))
        .catch((error) => this.on.refused(error instanceof Problem ? error.detail : String(error)));
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  close() {
    this.closed = true;
    clearTimeout(this.timer);
    clearInterval(this.watch);
    document.removeEventListener('visibilitychange', this.seen);
    const socket = this.socket;
    this.socket = null;
    if (socket) leave(socket);
  }
}
