// Clients of a site of shards, as a process of its own on a machine of its own: for each session a viewer that reconnects by itself, as
// the page does, and commands, one after the other; classes, each with a board, members and votes. It keeps what was acknowledged and what
// was seen; checks.mjs compares that with what is stored.
import WebSocket from 'ws';
import { client, pause } from '../lib/client.mjs';

const now = () => performance.timeOrigin + performance.now();
const START_MS = [50, 200], // of a viewer that lost its stream, at random; twice that each time
  WAIT_MAX_MS = 5000,
  SILENT_MS = 2000, // then it sends a ping
  DEAD_MS = 5000, // then it gives the connection up
  PATIENCE_MS = 15000, // of a command
  MEMBERS = 6; // of a class; the first has a copy

const ORDER = { scenario: 'race', set: { duration_s: 3600, 'params.laps': 1000 } };

let url = '',
  hz = 20,
  ended = false;
/** @type {ReturnType<typeof client>} */
let c;

class Viewer {
  /** @param {any} session */
  constructor(session) {
    this.session = session;
    this.since = 0;
    this.attempt = 0;
    this.last = now(); // frame
    this.tick = -1;
    this.frames = 0;
    this.back = 0; // most ticks that the view went back
    /** From the last frame before to the first one after. @type {{from: number, to: number, back: number}[]} */
    this.gaps = [];
    this.codes = /** @type {Record<string, number>} */ ({}); // why streams ended
    this.socket = /** @type {WebSocket | null} */ (null);
    this.watch = setInterval(() => this.check(), 500);
    this.open();
  }

  open() {
    if (ended) return;
    const socket = new WebSocket(`${url.replace(/^http/, 'ws')}/api/v1/sessions/${this.session.id}/stream`, 'laglab.v2.json', {
      perMessageDeflate: false,
      handshakeTimeout: DEAD_MS,
    });
    this.socket = socket;
    this.heard = now();
    socket.on('upgrade', () => {
      this.since = now();
    });
    socket.on('open', () => socket.send(JSON.stringify({ subscribe: { clock: hz } })));
    socket.on('message', (data) => this.take(JSON.parse(String(data))));
    socket.on('error', () => {});
    socket.on('unexpected-response', (request, response) => {
      this.count(`HTTP ${response.statusCode}`);
      request.destroy();
      if (this.socket === socket) this.lost();
    });
    socket.on('close', (code) => {
      this.count(String(code));
      if (this.socket === socket) this.lost();
    });
  }

  /** @param {string} why */
  count(why) {
    this.codes[why] = (this.codes[why] ?? 0) + 1;
  }

  lost() {
    const socket = this.socket;
    this.socket = null;
    socket?.terminate();
    this.later();
  }

  later() {
    const [least, most] = START_MS,
      scale = Math.min(2 ** this.attempt++, WAIT_MAX_MS / most);
    setTimeout(() => this.open(), scale * (least + (most - least) * Math.random()));
  }

  check() {
    if (this.socket?.readyState !== WebSocket.OPEN) return;
    const silence = now() - this.heard;
    if (silence > DEAD_MS) this.lost();
    else if (silence > SILENT_MS) this.socket.send(`{"ping":${Math.round(now())}}`);
  }

  /** @param {any} message */
  take(message) {
    const at = now();
    this.heard = at;
    if (message.type !== 'frame') return;
    const back = Math.max(0, this.tick - message.tick);
    if (this.frames > 0 && at - this.last > 2500 / hz) this.gaps.push({ from: this.last, to: at, back });
    this.back = Math.max(this.back, back);
    this.attempt = 0;
    this.last = at;
    this.tick = message.tick;
    this.frames++;
  }

  /** Longest time without a frame that touches the span. @param {number} from @param {number} to */
  longest(from, to) {
    const gaps = this.gaps.filter((gap) => gap.to > from && gap.from < to).map((gap) => gap.to - gap.from);
    if (this.last < to) gaps.push(to - this.last);
    return Math.max(0, ...gaps);
  }

  close() {
    clearInterval(this.watch);
    this.socket?.terminate();
  }
}

/** @type {any[]} */
let sessions = [];
/** @type {Viewer[]} */
let viewers = [];
/** @type {any[]} */
const classes = [];
let commanding = /** @type {Promise<void>[]} */ ([]),
  halted = false;

/**
 * Commands, each with a value of its own, so that it is found in the log: sixteenths are exact in any format.
 * @param {any} session
 * @param {number} every_ms
 */
async function command(session, every_ms) {
  while (!halted) {
    await pause(-Math.log(1 - Math.random()) * every_ms);
    if (halted) return;
    const n = session.sent++,
      asked = now();
    const told = { n, value: n / 16, status: 0, tick: -1, asked, answered: 0 };
    session.commands.push(told);
    try {
      const answer = await c.call('PATCH', `/api/v1/sessions/${session.id}/params`, {
        key: session.owner_key,
        body: { 'players.1.lag_ms': told.value },
        timeout: PATIENCE_MS,
      });
      told.status = answer.status;
      told.tick = answer.json?.tick ?? -1;
    } catch {
      /* not answered: it may be stored or not */
    }
    told.answered = now();
  }
}

/** Asks again until it is answered as expected: what a person does. @param {() => Promise<any>} call @param {number} ms */
async function insist(call, ms = 60000) {
  const end = now() + ms;
  let last;
  for (;;) {
    try {
      last = await call();
      if (last.status < 300) return last;
      if (last.status < 500 && last.status !== 429) break;
    } catch (error) {
      last = error;
    }
    if (now() > end) break;
    await pause(200);
  }
  throw new Error(`not done: ${last?.status} ${last?.text ?? last?.message}`);
}

/**
 * Calls `act` for all, some at a time.
 * @template T
 * @param {T[]} all
 * @param {number} at_once
 * @param {(one: T, i: number) => Promise<any>} act
 */
async function each(all, at_once, act) {
  let next = 0;
  const work = async () => {
    while (next < all.length) {
      const i = next++;
      await act(all[i], i);
    }
  };
  await Promise.all(Array.from({ length: at_once }, work));
}

/** A class with a board, to which commands go like to other sessions, and members that vote. */
async function openClass() {
  const call = (/** @type {string} */ method, /** @type {string} */ path, /** @type {any} */ more) =>
    insist(() => c.call(method, `/api/v1/classes${path}`, more));
  const { json: made } = await call('POST', '', {});
  const { id, code, teacher_key: key } = made;
  const { json: board } = await call('PUT', `/${id}/board`, { key, body: ORDER });
  sessions.push({ sent: 0, commands: [], ...board });
  const members = [];
  for (let i = 0; i < MEMBERS; i++) members.push((await call('POST', `/${id}/members`, { body: { role: i ? 'watch' : 'copy' } })).json);
  return { id, code, key, board: board.id, members, step: 0, votes: 0 };
}

/** One question, and the votes of all members. @param {any} room */
async function ask(room) {
  const step = ++room.step % 1000,
    call = (/** @type {string} */ method, /** @type {string} */ part, /** @type {any} */ more) =>
      c.call(method, `/api/v1/classes/${room.id}${part}`, { timeout: PATIENCE_MS, ...more }).catch(() => ({ status: 0 }));
  const { status } = await call('PATCH', '', { key: room.key, body: { phase: 'predict', step, choices: 4 } });
  if (status !== 200) return false;
  const answers = await Promise.all(
    room.members.map(({ token }, i) => call('PUT', '/vote', { key: token, body: { step, choice: i % 4 } })),
  );
  room.votes += answers.filter((answer) => answer.status === 204).length;
  return answers.every((answer) => answer.status === 204);
}

/** @param {any} room @param {number} every_ms */
async function teach(room, every_ms) {
  while (!halted) {
    await pause(every_ms * (0.5 + Math.random()));
    if (!halted) await ask(room);
  }
}

/** What of a class is not as it was before all faults: empty when all is. @param {any} room */
async function lostOf(room) {
  const lost = [],
    get = (/** @type {string} */ path, key = undefined) => insist(() => c.call('GET', `/api/v1/classes/${path}`, { key }));
  try {
    const { json } = await get(room.code);
    if (json.id !== room.id || json.state.board !== room.board) lost.push('its code or board');
    for (const { token, copy } of room.members) if ((await get(`${room.id}/member`, token)).json.copy !== copy) lost.push('a copy');
    if (!(await ask(room))) lost.push('a vote');
    if ((await get(room.id)).json.state.votes !== MEMBERS) lost.push('a count of votes');
  } catch (error) {
    lost.push(String(error?.message ?? error));
  }
  return lost.map((what) => `class ${room.id}: ${what}`);
}

const quantile = (/** @type {number[]} */ values, /** @type {number} */ q) =>
  [...values].sort((a, b) => a - b)[Math.round(q * (values.length - 1))] ?? 0;

const acts = {
  /** Makes the sessions, their viewers, and the classes. */
  async begin(wish) {
    ({ url, hz } = wish);
    c = client(url, Infinity);
    sessions = Array.from({ length: wish.sessions }, () => ({ sent: 0, commands: [] }));
    await each(sessions, 8, async (session) => {
      Object.assign(session, (await insist(() => c.call('POST', '/api/v1/sessions', { body: ORDER }))).json);
    });
    viewers = sessions.map((session) => new Viewer(session));
    for (let i = 0; i < wish.classes; i++) classes.push(await openClass());
  },
  async command({ every_ms }) {
    halted = false;
    commanding = [...sessions.map((session) => command(session, every_ms)), ...classes.map((room) => teach(room, 2 * every_ms))];
  },
  async halt() {
    halted = true;
    await Promise.all(commanding);
  },
  /** Whether every viewer has had a frame since then, and how many have not. */
  async waiting({ since }) {
    return viewers.filter((viewer) => viewer.socket?.readyState !== WebSocket.OPEN || viewer.last < since).length;
  },
  /** How many viewers have lost frames or their stream in the last `ms`. */
  async unsteady({ ms }) {
    const from = now() - ms;
    return viewers.filter(
      (viewer) => viewer.socket?.readyState !== WebSocket.OPEN || viewer.since > from || viewer.longest(from, now()) > 5000 / hz,
    ).length;
  },
  /** Of each viewer its longest time without a frame in a span, ms. */
  async gaps({ from, to }) {
    return viewers.map((viewer) => viewer.longest(from, to));
  },
  /** Milliseconds until commands were acknowledged, of those that were asked in the span. */
  async latency({ from, to }) {
    const took = sessions
      .flatMap((session) => session.commands)
      .filter((told) => told.status === 200 && told.asked >= from && told.asked < to)
      .map((told) => told.answered - told.asked);
    return { count: took.length, p50: quantile(took, 0.5), p99: quantile(took, 0.99), max: Math.max(0, ...took) };
  },
  async get({ at }) {
    try {
      const response = await fetch(at, { signal: AbortSignal.timeout(3000) });
      return { status: response.status, text: await response.text() };
    } catch (error) {
      return { status: 0, text: String(error) };
    }
  },
  /** What the classes have lost. */
  async classes() {
    return (await Promise.all(classes.map(lostOf))).flat();
  },
  /** Ends the play: where each session stands, the hash there, and its log. */
  async settle() {
    await each(sessions, 8, async (session) => {
      const key = session.owner_key;
      const control = () => c.call('POST', `/api/v1/sessions/${session.id}/control`, { key, body: { op: 'pause' } });
      const { json } = await insist(control);
      session.end = { tick: json.tick, hash: json.hash };
      session.log = (await insist(() => c.call('GET', `/api/v1/sessions/${session.id}/log`))).text;
    });
  },
  /** What is known of all sessions. */
  async known() {
    return {
      sessions: sessions.map(({ id, owner_key, commands, end, log }) => ({ id, owner_key, commands, end, log })),
      viewers: viewers.map(({ frames, back, codes, session }) => ({ id: session.id, frames, back, codes })),
      classes: { count: classes.length, votes: classes.reduce((sum, { votes }) => sum + votes, 0) },
    };
  },
  async end() {
    ended = halted = true;
    for (const viewer of viewers) viewer.close();
  },
};

process.on('message', async (/** @type {{id: number, act: string, wish: any}} */ { id, act, wish }) => {
  try {
    process.send?.({ id, answer: await acts[act](wish ?? {}) });
  } catch (error) {
    process.send?.({ id, error: String(error?.stack ?? error) });
  }
});
process.on('disconnect', () => process.exit(0)); // with who started it
