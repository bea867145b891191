// Streams: WebSockets as queues of messages, and frames by the page's decoder.
import { Decoder } from '../../www/js/stream/decode.js';
import { RECORDS, SCHEMA } from '../../www/js/stream/records.js';
import { LaglabError } from './errors.js';

/** One frame: `tick`, `time_s`, `seq` and the rows of each record, such as `frame.entities`.
 * @typedef {import('../../www/js/stream/decode.js').Frame} Frame */
/** @typedef {{code: number, reason: string}} Closed */

const NODE = typeof process === 'object' && process?.versions?.node !== undefined;

/** Messages of a socket, to be asked for one after the other. */
class Line {
  /** @param {WebSocket} socket */
  constructor(socket) {
    this.socket = socket;
    /** @type {(string | ArrayBuffer)[]} */
    this.queue = [];
    /** @type {Closed | null} */
    this.closed = null;
    /** @type {(() => void) | null} */
    this.wake = null;
    socket.binaryType = 'arraybuffer';
    socket.onmessage = ({ data }) => {
      this.queue.push(data);
      this.wake?.();
    };
    socket.onclose = ({ code, reason }) => {
      this.closed = { code, reason };
      this.wake?.();
    };
  }

  /** Until there is a message, or the end. */
  async something() {
    if (this.queue.length === 0 && this.closed === null)
      await new Promise((/** @type {(value?: unknown) => void} */ resolve) => {
        this.wake = resolve;
      });
    this.wake = null;
  }

  /** @returns {Promise<string | ArrayBuffer | null>} null: the daemon has closed */
  async next() {
    await this.something();
    return this.queue.shift() ?? null;
  }

  /** @param {unknown} message */
  send(message) {
    if (this.closed === null) this.socket.send(JSON.stringify(message));
  }

  close() {
    this.socket.onmessage = this.socket.onclose = null;
    this.socket.close();
  }
}

/** @param {URL} url of http or https @param {string} protocol @returns {Promise<Line>} */
export async function openLine(url, protocol) {
  const address = new URL(url);
  address.protocol = url.protocol.replace('http', 'ws');
  // Browsers and Node from 22 on have one.
  const Socket = globalThis.WebSocket ?? (await import('./node_socket.js')).NodeSocket;
  const socket = /** @type {WebSocket} */ (new /** @type {any} */ (Socket)(address, [protocol])),
    line = new Line(socket);
  let opened = false; // it may be closed again at once, with messages before
  await new Promise((/** @type {(value?: unknown) => void} */ resolve) => {
    socket.onopen = () => {
      opened = true;
      resolve();
    };
    line.wake = resolve;
  });
  if (!opened) throw new LaglabError(`no stream: ${line.closed?.reason || 'the daemon does not take the connection'}`);
  return line;
}

/** By Node's own library: before 20.12 its DecompressionStream did not know the format. */
async function nodeInflate() {
  const [{ inflateRaw }, { promisify }] = await Promise.all([import('node:zlib'), import('node:util')]);
  return promisify(inflateRaw);
}

/** Frames while they come. Each is acknowledged when the next one is asked for, so that a slow program skips frames in place of falling
 * behind. Ends with the session.
 * @param {URL} url @param {Record<string, number>} channels @param {() => Promise<{records: any[]}>} schema the daemon's own tables
 * @returns {AsyncGenerator<Frame, void, void>} */
export async function* frames(url, channels, schema) {
  const line = await openLine(url, 'laglab.v2.bin'),
    inflate = NODE ? await nodeInflate() : undefined;
  let decoder = new Decoder(RECORDS, 60, inflate);
  try {
    if (Object.keys(channels).length > 0) line.send({ subscribe: channels });
    for (let data = await line.next(); data !== null; data = await line.next()) {
      if (typeof data !== 'string') {
        const bytes = data;
        /** @type {Frame} */
        const frame = await new Promise((resolve, reject) => decoder.decode(bytes, resolve, reject));
        yield frame;
        line.send({ ack: frame.seq });
        continue;
      }
      const message = JSON.parse(data);
      if (message.type === 'hello')
        decoder = new Decoder(message.schema === SCHEMA ? RECORDS : (await schema()).records, message.tick_hz, inflate);
      else if (message.type === 'error') throw new LaglabError(message.problem.detail, { status: message.problem.status });
    }
    const { code, reason } = /** @type {Closed} */ (line.closed);
    if (![1000, 1001, 4404].includes(code)) throw new LaglabError(`the stream has ended: ${reason || code}`);
  } finally {
    line.close();
  }
}
