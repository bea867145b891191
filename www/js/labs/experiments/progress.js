// Progress of an experiment: from the daemon's stream, or by polling where no stream gets through.
import { address, call } from '../../base/api.js';

/** @typedef {{state: string, runs: number, done: number, rate_per_s: number, left_s: number | null}} Report */

const ASK_MS = 1000,
  AGAIN_MS = 1000;
const OVER = ['done', 'cancelled'];

/** @param {string} state */
export const isOver = (state) => OVER.includes(state);

export class Progress {
  /** @param {string} id @param {(report: Report) => void} onReport */
  constructor(id, onReport) {
    this.id = id;
    this.onReport = onReport;
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
    const socket = (this.socket = new WebSocket(url, ['laglab.v2.json']));
    socket.onmessage = (message) => {
      const report = JSON.parse(String(message.data));
      if (report.type !== 'hello' && report.type !== 'progress') return;
      this.way = 'stream';
      this.take(report);
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
      const report = await call('GET', `experiments/${this.id}`);
      this.way = 'asking';
      if (!this.closed) this.take(report);
    } catch {
      /* asked again */
    }
    if (!this.closed) this.timer = setTimeout(() => this.ask(), ASK_MS);
  }

  /** @param {Report} report */
  take(report) {
    this.onReport(report);
    if (isOver(report.state)) this.close();
  }

  close() {
    this.closed = true;
    clearTimeout(this.timer);
    this.socket?.close();
  }
}
