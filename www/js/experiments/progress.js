// How far an experiment is: told by the daemon's stream, or asked for again and again where a stream does not get through.
import { address, call } from '../api.js';

/** @typedef {{state: string, runs: number, done: number, rate_per_s: number, left_s: number | null}} Told */

const ASK_MS = 1000, AGAIN_MS = 1000;
const OVER = ['done', 'cancelled', 'failed'];

/** @param {string} state */
export const isOver = (state) => OVER.includes(state);

export class Progress {
  /** @param {string} id @param {(told: Told) => void} tell */
  constructor(id, tell) {
    this.id = id;
    this.tell = tell;
    this.closed = false;
    this.way = ''; /* stream or asking, once one of them has brought something */
    /** @type {WebSocket | null} */
    this.socket = null;
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    this.timer = undefined;
    this.open();
  }

  open() {
    const url = address(`experiments/${this.id}/stream`);
    url.protocol = url.protocol.replace('http', 'ws');
    const socket = this.socket = new WebSocket(url, ['laglab.v2.json']);
    socket.onmessage = (message) => {
      const told = JSON.parse(String(message.data));
      if (told.type !== 'hello' && told.type !== 'progress') return;
      this.way = 'stream';
      this.take(told);
    };
    socket.onclose = () => {
      if (this.closed) return;
      this.socket = null;
      if (this.way === 'stream') this.timer = setTimeout(() => this.open(), AGAIN_MS);
      else this.ask();
      this.way = '';
    };
  }

  async ask() {
    try {
      const told = await call('GET', `experiments/${this.id}`);
      this.way = 'asking';
      if (!this.closed) this.take(told);
    } catch { /* asked again */ }
    if (!this.closed) this.timer = setTimeout(() => this.ask(), ASK_MS);
  }

  /** @param {Told} told */
  take(told) {
    this.tell(told);
    if (isOver(told.state)) this.close();
  }

  close() {
    this.closed = true;
    clearTimeout(this.timer);
    this.socket?.close();
  }
}
