// The stream of a class: its whole state after each change; reconnects by itself until it is closed or the class has ended.
import { Problem, address, call } from '../base/api.js';
import { leave, patience } from '../stream/connection.js';

const GONE = 4404; /* close code: no such class */

/**
 * @typedef {object} Handlers
 * @property {(state: import('./state.js').State, first: boolean) => void} state  first: of this connection. The daemon may have
 *   started again by then: its serials begin again at 0
 * @property {(member: import('./state.js').Member) => void} member  for this member alone
 * @property {(members: any) => void} members   for the teacher alone
 * @property {(byTeacher: boolean) => void} removed  the member of this connection is none any more
 * @property {(attempt: number) => void} lost   0: it is open again
 * @property {(why: string) => void} gone       the class has ended
 * @property {(detail: string) => void} refused
 */

export class Line {
  /** @param {string} id of the class @param {string} secret empty for who only looks @param {Handlers} on */
  constructor(id, secret, on) {
    this.id = id;
    this.secret = secret;
    this.on = on;
    this.attempt = 0;
    this.closed = false;
    this.why = '';
    /** @type {WebSocket | null} */
    this.socket = null;
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    this.timer = undefined;
    this.open();
  }

  open() {
    const url = address(`classes/${this.id}/stream`);
    url.protocol = url.protocol.replace('http', 'ws');
    const socket = new WebSocket(url, ['laglab.v2.json']);
    this.socket = socket;
    socket.onopen = () => this.auth(this.secret);
    socket.onmessage = ({ data }) => {
      if (socket === this.socket) this.take(JSON.parse(data));
    };
    socket.onclose = ({ code }) => {
      if (socket !== this.socket) return;
      if (code === GONE) this.end();
      else this.lost();
    };
  }

  /** From now on as the teacher, or as this member. @param {string} secret */
  auth(secret) {
    this.secret = secret;
    if (secret !== '' && this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify({ auth: secret }));
  }

  /** @param {any} message */
  take(message) {
    if (message.type === 'hello' || message.type === 'class') {
      if (message.type === 'hello') {
        this.attempt = 0;
        this.on.lost(0);
      }
      this.on.state(message, message.type === 'hello');
    } else if (message.type === 'member') {
      this.on.member(message);
    } else if (message.type === 'members') {
      this.on.members(message);
    } else if (message.type === 'removed') {
      this.on.removed(message.by_teacher);
    } else if (message.type === 'bye') {
      this.why = String(message.reason);
    } else if (message.type === 'error') {
      const field = message.problem?.errors?.[0]?.field; /* device: removed; auth: another has its place */
      if (field === 'device' || field === 'auth') return this.on.removed(field === 'device');
      this.on.refused(String(message.problem?.detail ?? message.problem?.title ?? 'refused'));
    }
  }

  lost() {
    this.socket = null;
    if (this.closed) return;
    this.attempt++;
    this.on.lost(this.attempt);
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.retry(), patience(this.attempt));
  }

  async retry() {
    try {
      await call('GET', `classes/${this.id}`);
    } catch (error) {
      if (this.closed) return;
      if (error instanceof Problem && error.status === 404) this.end();
      else this.lost();
      return;
    }
    if (!this.closed) this.open();
  }

  end() {
    if (this.closed) return;
    this.close();
    this.on.gone(this.why);
  }

  close() {
    this.closed = true;
    clearTimeout(this.timer);
    const socket = this.socket;
    this.socket = null;
    if (socket) leave(socket);
  }
}
