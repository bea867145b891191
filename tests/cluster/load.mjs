// Clients of a cluster, as a process of its own on a machine of its own: for each session a viewer that reconnects by itself, as the page
// does, and commands, one after the other. It keeps what was acknowledged and what was seen; tests/cluster/checks.mjs compares that with
// what is stored. For every eighth session there is a second viewer, connected straight to the daemon that has the session, which never
// gives up a connection that is open: it would see a daemon that goes on with a session that is another's by now.
import WebSocket from 'ws';
import { client, pause } from '../lib/client.mjs';

/** One clock for all processes of the machine, ms since 1970; of `taken` it is what the daemon's monotonic clock says. */
const now = () => performance.timeOrigin + performance.now();
const monotonic_ms = () => Number(process.hrtime.bigint()) / 1e6;
const START_MS = [50, 200], // of a viewer that lost its stream, at random; twice that each time
  WAIT_MAX_MS = 5000,
  SILENT_MS = 2000, // then it sends a ping
  DEAD_MS = 5000, // then it gives the connection up
  PATIENCE_MS = 15000; // of a command

let url = '',
  servers = /** @type {Record<string, string>} */ ({}),
  hz = 20,
  ended = false;
/** @type {ReturnType<typeof client>} */
let c;

class Viewer {
  /** @param {any} session @param {Viewer | null} first the viewer whose daemon this one connects to, without the proxy */
  constructor(session, first = null) {
    this.session = session;
    this.first = first;
    this.server = ''; // the daemon that answered the upgrade
    this.since = 0;
    this.attempt = 0;
    this.last = now(); // frame
    this.tick = -1;
    this.frames = 0;
    this.back = 0; // most ticks that the view went back
    /** From the last frame before to the first one after. @type {{from: number, to: number, back: number}[]} */
    this.gaps = [];
    /**
     * Frames without a gap from one daemon: when they were taken, by the monotonic clock.
     * @type {{server: string, from: number, to: number}[]}
     */
    this.runs = [];
    this.codes = /** @type {Record<string, number>} */ ({}); // why streams ended
    this.socket = /** @type {WebSocket | null} */ (null);
    this.watch = setInterval(() => this.check(), 500);
    this.open();
  }

  place() {
    if (!this.first) return url;
    const { server, since, socket, last } = this.first; // only one that has it for some time: any other would take the session over
    const steady = socket?.readyState === WebSocket.OPEN && now() - since > 1000 && last > since && now() - last < 5000 / hz;
    return steady ? servers[server] : undefined;
  }

  open() {
    if (ended) return;
    const place = this.place();
    if (!place) return this.later();
    const socket = new WebSocket(`${place.replace(/^http/, 'ws')}/api/v1/sessions/${this.session.id}/stream`, 'laglab.v2.json', {
      perMessageDeflate: false,
      handshakeTimeout: DEAD_MS,
    });
    this.socket = socket;
    this.heard = now();
    const server = this.first?.server ?? '';
    socket.on('upgrade', (response) => {
      this.server = server || String(response.headers['x-served-by'] ?? 'd0');
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
    if (this.socket?.readyState !== WebSocket.OPEN || this.first) return;
    const silence = now() - this.heard;
    if (silence > DEAD_MS) this.lost();
    else if (silence > SILENT_MS) this.socket.send(`{"ping":${Math.round(now())}}`);
  }

  /** @param {any} message */
  take(message) {
    const at = now();
    this.heard = at;
    if (message.type !== 'frame') return;
    const period = 1000 / hz,
      taken = message.clock?.[0]?.wall_us / 1000,
      run = this.runs.at(-1);
    const back = Math.max(0, this.tick - message.tick);
    if (this.frames > 0 && at - this.last > 2.5 * period) this.gaps.push({ from: this.last, to: at, back });
    this.back = Math.max(this.back, back);
    if (run?.server === this.server && taken - run.to < 2.5 * period) run.to = Math.max(run.to, taken);
    else if (Number.isFinite(taken)) this.runs.push({ server: this.server, from: taken, to: taken });
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
let viewers = [],
  seconds = [];
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
    const told = { n, value: n / 16, status: 0, tick: -1, server: '', asked, answered: 0 };
    session.commands.push(told);
    try {
      const answer = await c.call('PATCH', `/api/v1/sessions/${session.id}/params`, {
        key: session.owner_key,
        body: { 'players.1.lag_ms': told.value },
        timeout: PATIENCE_MS,
      });
      told.status = answer.status;
      told.tick = answer.json?.tick ?? -1;
      told.server = String(answer.headers['x-served-by'] ?? '');
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

const quantile = (/** @type {number[]} */ values, /** @type {number} */ q) =>
  [...values].sort((a, b) => a - b)[Math.round(q * (values.length - 1))] ?? 0;

const acts = {
  /** Makes the sessions and their viewers. */
  async begin(wish) {
    ({ url, servers, hz } = wish);
    c = client(url, Infinity);
    sessions = Array.from({ length: wish.sessions }, () => ({ sent: 0, commands: [] }));
    await each(sessions, 8, async (session) => {
      const order = { scenario: 'race', set: { duration_s: 3600, 'params.laps': 1000 } };
      Object.assign(session, (await insist(() => c.call('POST', '/api/v1/sessions', { body: order }))).json);
    });
    viewers = sessions.map((session) => new Viewer(session));
    seconds = viewers.filter((_, i) => i % 8 === 0).map((viewer) => new Viewer(viewer.session, viewer));
  },
  async command({ every_ms }) {
    halted = false;
    commanding = sessions.map((session) => command(session, every_ms));
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
  /** What is known of all sessions. `offset_ms` makes one of the clock's times of the monotonic one. */
  async known() {
    return {
      offset_ms: now() - monotonic_ms(),
      sessions: sessions.map(({ id, owner_key, commands, end, log }) => ({ id, owner_key, commands, end, log })),
      viewers: viewers.map(({ frames, back, runs, codes, session }) => ({ id: session.id, frames, back, runs, codes })),
      seconds: seconds.map(({ frames, back, runs, codes, session }) => ({ id: session.id, frames, back, runs, codes })),
    };
  },
  async end() {
    ended = halted = true;
    for (const viewer of [...viewers, ...seconds]) viewer.close();
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
