// A WebSocket for Node before 22, which has none: the client's side of RFC 6455 as far as laglab's streams need it.
import { createHash, randomBytes } from 'node:crypto';
import http from 'node:http';
import https from 'node:https';

const GUID = '258EAFA5-E914-47DA-95CA-C5AB0DC85B11';
const TEXT = 1,
  BINARY = 2,
  CLOSE = 8,
  PING = 9,
  PONG = 10;
const MESSAGE_MAX = 64 << 20;

/** What both directions of a browser's WebSocket have of it that the client uses. */
export class NodeSocket {
  /** @param {URL} url @param {string[]} protocols */
  constructor(url, protocols) {
    /** @type {(() => void) | null} */
    this.onopen = null;
    /** @type {((message: {data: string | ArrayBuffer}) => void) | null} */
    this.onmessage = null;
    /** @type {((event: {code: number, reason: string}) => void) | null} */
    this.onclose = null;
    this.binaryType = 'arraybuffer';
    /** @type {import('node:net').Socket | null} */
    this.socket = null;
    this.ended = false;
    /** @type {Buffer} */
    this.bytes = Buffer.alloc(0);
    /** The message that is coming. @type {Buffer[]} */
    this.pieces = [];
    this.kind = 0;
    this.shake(url, protocols);
  }

  /** @param {URL} url @param {string[]} protocols */
  shake(url, protocols) {
    const key = randomBytes(16).toString('base64'),
      secure = url.protocol === 'wss:';
    const request = (secure ? https : http).request({
      host: url.hostname.replace(/^\[|\]$/g, ''),
      port: url.port || (secure ? 443 : 80),
      path: url.pathname + url.search,
      headers: {
        Host: url.host,
        Connection: 'Upgrade',
        Upgrade: 'websocket',
        'Sec-WebSocket-Version': '13',
        'Sec-WebSocket-Key': key,
        'Sec-WebSocket-Protocol': protocols.join(', '),
      },
    });
    request.on('error', (error) => this.end(1006, error.message));
    request.on('response', (response) => {
      response.resume();
      this.end(1006, `the daemon answers ${response.statusCode} ${response.statusMessage}`);
    });
    request.on('upgrade', (response, socket, head) => {
      const expected = createHash('sha1')
        .update(key + GUID)
        .digest('base64');
      if (this.ended || response.headers['sec-websocket-accept'] !== expected) {
        socket.destroy();
        this.end(1006, "the answer to the upgrade is not a WebSocket's");
        return;
      }
      this.socket = /** @type {import('node:net').Socket} */ (socket);
      socket.on('data', (part) => this.take(part));
      socket.on('error', () => {});
      socket.on('close', () => this.end(1006, 'the daemon has ended the connection'));
      this.onopen?.();
      this.take(head);
    });
    request.end();
  }

  /** @param {number} opcode @param {Buffer} payload */
  write(opcode, payload) {
    const size = payload.length,
      mask = randomBytes(4),
      masked = Buffer.from(payload);
    for (let i = 0; i < size; i++) masked[i] = /** @type {number} */ (masked[i]) ^ /** @type {number} */ (mask[i & 3]);
    const head = Buffer.alloc(size < 126 ? 2 : 4);
    head[0] = 0x80 | opcode;
    head[1] = 0x80 | (size < 126 ? size : 126);
    if (size >= 126) head.writeUInt16BE(size, 2); // no message of this client is longer
    this.socket?.write(Buffer.concat([head, mask, masked]));
  }

  /** @param {string} text of less than 64 kB */
  send(text) {
    this.write(TEXT, Buffer.from(text));
  }

  close() {
    if (this.ended) return;
    this.write(CLOSE, Buffer.from([1000 >> 8, 1000 & 255]));
    this.end(1000, '');
  }

  /** @param {number} code @param {string} reason */
  end(code, reason) {
    if (this.ended) return;
    this.ended = true;
    this.socket?.end();
    this.onclose?.({ code, reason });
  }

  /** @param {Buffer} part */
  take(part) {
    this.bytes = this.bytes.length === 0 ? part : Buffer.concat([this.bytes, part]);
    while (!this.ended && this.frame());
  }

  /** Reads a frame. @returns {boolean} whether it was there */
  frame() {
    const { bytes } = this;
    if (bytes.length < 2) return false;
    const first = bytes.readUInt8(0),
      second = bytes.readUInt8(1),
      from = second === 126 ? 4 : second === 127 ? 10 : 2;
    if (bytes.length < from) return false;
    const size = from === 2 ? second : from === 4 ? bytes.readUInt16BE(2) : Number(bytes.readBigUInt64BE(2));
    if (second & 128 || first & 0x70 || size > MESSAGE_MAX) {
      this.end(1002, 'the stream has a frame that RFC 6455 does not allow a server, or one too large');
      return false;
    }
    if (bytes.length < from + size) return false;
    this.bytes = bytes.subarray(from + size);
    this.apply(first & 15, (first & 128) !== 0, bytes.subarray(from, from + size));
    return true;
  }

  /** @param {number} opcode @param {boolean} final @param {Buffer} payload */
  apply(opcode, final, payload) {
    if (opcode === PING) this.write(PONG, payload);
    else if (opcode === CLOSE) {
      const code = payload.length >= 2 ? payload.readUInt16BE(0) : 1005;
      this.write(CLOSE, payload.subarray(0, 2));
      this.end(code, payload.subarray(2).toString());
    } else if (opcode !== PONG) {
      if (opcode !== 0) this.kind = opcode;
      this.pieces.push(payload);
      if (!final) return;
      const whole = Buffer.concat(this.pieces);
      this.pieces = [];
      const data = this.kind === BINARY ? whole.buffer.slice(whole.byteOffset, whole.byteOffset + whole.length) : whole.toString();
      this.onmessage?.({ data: /** @type {string | ArrayBuffer} */ (data) });
    }
  }
}
