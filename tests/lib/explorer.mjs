// A client that uses every operation of a daemon as a seed says, and compares its answers with what must be so.
import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { appendFileSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { promisify } from 'node:util';
import { client, decodeAll, openStream, pause } from './client.mjs';
import { readContract } from './contract.mjs';
import { BINARY, startDaemon } from './daemon.mjs';
import { drawer, random, seedOf } from './draws.mjs';

const run = promisify(execFile);
const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
const NOBODY = 'a'.repeat(26),
  WRONG = 'b'.repeat(32);
const S = '/api/v1/sessions',
  I = `${S}/{id}`,
  X = '/api/v1/experiments',
  C = '/api/v1/classes/{id}';
const OPERATOR = 'an-operators-key-of-some-length';
const MAX_SESSIONS = 10,
  REPLAYED_TICKS = 3000,
  LAST = 40;
/** Limits that the explorer must not run into, and short times. */
const ARGS = Object.entries({
  scenarios: path.join(ROOT, 'scenarios'),
  api: path.join(ROOT, 'api'),
  'max-new-sessions-per-min': 1000000,
  'max-commands-per-s': 1000000,
  'max-code-lookups-per-min': 1000000,
  'max-client-experiments': 1000000,
  'max-experiments': 100000,
  'max-client-classes': 10000,
  'max-classes': 10000,
  'max-state-mib': 16,
  'max-memory-mib': 600,
  'request-cpu-s': 2,
  'job-cpu-s': 4,
  'job-idle-s': 2,
  'park-after-s': 1,
  'save-every-s': 0.5,
  'drain-s': 1,
  'response-timeout-s': 20,
}).flatMap(([name, value]) => [`--${name}`, String(value)]);
const CLOSES = [1000, 1001, 1002, 1003, 1005, 1007, 1008, 1009, 1013, 4403, 4404, 4429];

/** Values by path as a merge patch, dotted or nested. */
function nest(values) {
  const patch = {};
  for (const [place, value] of Object.entries(values)) {
    const keys = place.split('.');
    let at = patch;
    for (const key of keys.slice(0, -1)) at = at[key] ??= {};
    at[keys[keys.length - 1]] = value;
  }
  return patch;
}

const FORMATS = ['csv', 'ndjson', 'json', 'sqlite'],
  OF_POINTS = [
    '',
    'points=true',
    'points=true&compare=first',
    'points=true&compare=0',
    'points=true&compare=9',
    'sensitivity=true',
    'compare=x%3D1',
  ].map((wish) => wish && `&${wish}`);

export class Explorer {
  /**
   * `front`: starts what stands before the daemon of a port, a proxy that is asked in its place.
   * @param {number} seed @param {(port: number) => Promise<{url: string, stop: () => Promise<void>}>} [front]
   */
  constructor(seed, front) {
    this.seed = seed;
    this.front = front;
    this.folder = mkdtempSync(path.join(tmpdir(), 'laglab-random-'));
    this.requests = 0;
    this.answers = /** @type {Record<string, number>} */ ({});
    this.last = /** @type {string[]} */ ([]);
    this.compared = { replays: 0, restarts: 0, forks: 0, seeks: 0, runs: 0, hashes: 0, frames: 0, rounds: 0 };
    this.alone = true;
    /** @type {Awaited<ReturnType<typeof readContract>>} */ this.contract = undefined;
    /** @type {{id: string, kind: string}[]} */ this.scenarios = undefined;
    /** @type {{name: string}[]} */ this.families = undefined;
    /** @type {Map<string, string[]>} Paths by scenario. */ this.metrics = new Map();
    this.forget();
    this.draws(0, 0);
  }

  forget() {
    this.sessions = /** @type {any[]} */ ([]);
    this.experiments = /** @type {any[]} */ ([]);
    this.jobs = /** @type {any[]} */ ([]);
    this.classes = /** @type {any[]} */ ([]);
    this.streams = /** @type {any[]} */ ([]);
  }

  /** Each action has draws of its own, so that one answer that differs changes few later ones. */
  draws(round, turn) {
    this.d = drawer(random(seedOf(this.seed, round, turn)), { resolve: (node, root) => this.resolve(node, root) });
  }

  /** @returns {[any, any]} the schema that `node` refers to, and its document */
  resolve(node, root) {
    for (let hops = 0; node?.$ref && hops < 20; hops++) {
      const [file, pointer] = node.$ref.split('#');
      if (file) root = this.contract.schemas;
      node = pointer
        .split('/')
        .slice(1)
        .reduce((at, key) => at[key.replaceAll('~1', '/')], root);
    }
    return [node, root];
  }

  async start() {
    const key = path.join(this.folder, 'key');
    writeFileSync(key, `${OPERATOR}\n`, { mode: 0o600 });
    this.daemon = await startDaemon({ data: path.join(this.folder, 'data'), args: [...ARGS, '--operator-key-file', key] });
    this.before = await this.front?.(this.daemon.port);
    this.url = this.before?.url ?? this.daemon.url;
    this.c = client(this.url);
    this.contract ??= await readContract(this.c);
    this.scenarios ??= (await this.c.get('/api/v1/scenarios?brief=true')).json.scenarios;
    this.families ??= (await this.c.get('/api/v1/tradeoffs')).json.families;
  }

  async end() {
    this.hangUp();
    this.c?.close();
    await this.before?.stop();
    await this.daemon?.stop();
    rmSync(this.folder, { recursive: true, force: true });
  }

  note(line) {
    this.last.push(line.length > 1500 ? `${line.slice(0, 1500)}...` : line);
    if (this.last.length > LAST) this.last.shift();
    if (process.env.LAGLAB_RANDOM_TRACE) appendFileSync(process.env.LAGLAB_RANDOM_TRACE, `${line}\n`);
  }

  /** Asks, and holds the answer against the document.
   * @param {string} method @param {string} template @param {Record<string, any>} values @param {any} [wish] */
  async call(method, template, values = {}, wish = {}) {
    const at = template.replace(/{(\w+)}/g, (_, name) => values[name]) + (wish.query ?? '');
    this.requests++;
    this.note(`${method} ${at} ${wish.key ?? ''} ${typeof wish.body === 'string' ? wish.body : (JSON.stringify(wish.body) ?? '')}`);
    const answer = await this.c.call(method.toUpperCase(), at, { timeout: 240000, ...wish });
    this.note(`   ${answer.status} ${answer.text.slice(0, 160)}`);
    const where = this.contract.check(method, template, answer);
    this.answers[where] = (this.answers[where] ?? 0) + 1;
    assert.ok(answer.status < 500 || answer.status === 503, `${where}: ${answer.text.slice(0, 300)}`);
    return answer;
  }

  session = () => (this.sessions.length ? this.d.pick(this.sessions) : undefined);

  /** The scenario of a session with its present values, with where its leaves are. */
  async leavesOf(s, live) {
    const answer = await this.call('get', I, s);
    if (answer.status !== 200) return [];
    s.kind = answer.json.kind;
    s.params = answer.json.params;
    s.tick_hz = answer.json.tick_hz;
    s.duration_s = answer.json.duration_s;
    return this.leavesIn(answer.json.params).filter(([, schema]) => !live || schema['x-live'] !== false);
  }
  leavesIn(scenario) {
    const { schemas } = this.contract;
    return this.d.leaves(schemas.$defs.scenario, schemas, scenario);
  }

  /** New values of some leaves. */
  values(leaves, most) {
    const values = {};
    for (let n = 1 + this.d.below(most); n > 0 && leaves.length; n--) {
      const [place, schema, root, old] = this.d.pick(leaves);
      values[place] = this.d.chance(0.05) ? this.d.junk() : this.d.chance(0.05) ? old : this.d.make(schema, root);
    }
    return values;
  }

  /** A body as it is or damaged. */
  body(value, wrong = 0.12) {
    return this.d.written(this.d.chance(wrong) ? this.d.corrupt(value) : value);
  }

  keep(answer) {
    if (answer.status === 201) this.sessions.push({ ...answer.json });
    return answer;
  }

  async scenario() {
    const { id } = this.d.pick(this.scenarios);
    const { json } = await this.call('get', '/api/v1/scenarios/{id}', { id });
    return { id, json };
  }

  actions = /** @type {[number, string, () => Promise<any>][]} */ ([
    [10, 'create', () => this.create()],
    [8, 'create from scratch', () => this.createFromScratch()],
    [32, 'patch', () => this.patch()],
    [8, 'storm', () => this.storm()],
    [24, 'control', () => this.control()],
    [8, 'input', () => this.input()],
    [3, 'fork', () => this.fork()],
    [10, 'read', () => this.read()],
    [4, 'there and back', () => this.thereAndBack()],
    [1, 'replay', () => this.replay()],
    [4, 'watch', () => this.watch()],
    [12, 'say', () => this.say()],
    [3, 'leave', () => this.leave()],
    [3, 'experiment', () => this.experiment()],
    [5, 'read an experiment', () => this.readExperiment()],
    [1, 'ask for a job', () => this.job()],
    [2, 'read a job', () => this.readJob()],
    [1, 'open a class', () => this.openClass()],
    [12, 'class', () => this.inClass()],
    [14, 'any operation', () => this.anything()],
    [3, 'at once', () => this.atOnce()],
    [2, 'delete', () => this.remove()],
    [0.6, 'wait', () => pause(1300)],
  ]);

  async act() {
    const sum = this.actions.reduce((all, [weight]) => all + weight, 0);
    let at = this.d.next() * sum;
    for (const [weight, name, action] of this.actions) {
      at -= weight;
      if (at < 0) {
        this.note(`# ${name}`);
        await action();
        break;
      }
    }
    this.listen();
  }

  async create() {
    if (this.sessions.length >= MAX_SESSIONS) await this.remove();
    const { id, json } = await this.scenario();
    const wish = /** @type {any} */ ({ scenario: this.d.chance(0.7) ? id : json, paused: this.d.chance(0.6) });
    if (this.d.chance(0.6)) wish.set = this.values(this.leavesIn(json), 4);
    if (this.d.chance(0.3)) wish.seed = this.d.below(1000);
    if (this.d.chance(0.3)) wish.speed = this.d.pick([0.1, 1, 2, 10]);
    if (this.d.chance(0.1)) wish.workload = this.d.make(this.contract.api.components.schemas.Workload, this.contract.api);
    return this.keep(await this.call('post', S, {}, { body: this.body(wish, 0.08) }));
  }

  async createFromScratch() {
    if (this.sessions.length >= MAX_SESSIONS) await this.remove();
    const { schemas } = this.contract;
    const scenario = this.d.make(schemas.$defs.scenario, schemas);
    if (this.d.chance(0.8)) delete scenario.timeline;
    if (this.d.chance(0.8)) delete scenario.expect;
    if (this.d.chance(0.8)) scenario.duration_s = 20 * this.d.next();
    return this.keep(await this.call('post', S, {}, { body: this.body({ scenario, paused: this.d.chance(0.5) }, 0.08) }));
  }

  async patch() {
    const s = this.session();
    if (!s) return this.create();
    const leaves = await this.leavesOf(s, this.d.chance(0.93));
    const values = this.values(leaves, this.d.chance(0.3) ? 6 : 2);
    const body = this.body(this.d.chance(0.7) ? values : nest(values), 0.06);
    const before = this.alone && this.d.chance(0.25) ? await this.position(s) : undefined;
    const answer = await this.call('patch', `${I}/params`, s, { key: s.owner_key, body });
    assert.ok([200, 400, 409, 404, 429, 503].includes(answer.status), `${answer.status} to a patch`);
    if (answer.status === 400 || answer.status === 409) {
      const after = before && (await this.position(s));
      if (after && before.status === 'paused' && after.status === 'paused')
        assert.deepEqual(after, before, 'a patch was refused, and something changed');
    }
    return answer;
  }

  /** A new session, and changes with some ticks between them. */
  async storm() {
    const made = await this.create();
    if (made.status !== 201) return;
    const s = made.json,
      wish = { key: s.owner_key };
    const change = (op) => this.call('post', `${I}/control`, s, { ...wish, body: op });
    await change({ op: 'pause' });
    const leaves = await this.leavesOf(s, true);
    for (let n = 4 + this.d.below(10); n > 0; n--) {
      const values = this.values(leaves, this.d.chance(0.3) ? 8 : 2);
      await this.call('patch', `${I}/params`, s, { ...wish, body: values });
      const answer = await change(
        this.d.chance(0.1)
          ? { op: 'restart' }
          : this.d.chance(0.1)
            ? { op: 'seek', tick: this.d.below(60) }
            : { op: 'step', ticks: this.d.pick([1, 2, 7, 30, 90, -5]) },
      );
      if (answer.status === 503 || answer.json.status === 'failed') break;
    }
    if (this.d.chance(0.3)) await this.replay(s);
  }

  async position(s) {
    const answer = await this.call('get', I, s);
    if (answer.status !== 200) return undefined;
    const { status, tick, head_tick, params } = answer.json;
    return { status, tick, head_tick, params };
  }

  async control() {
    const s = this.session();
    if (!s) return this.create();
    const d = this.d;
    const tick = () => Math.floor(d.pick([0, 1, 10, 100, 300, 600, 1500]) * (0.5 + d.next()));
    const body = d.pick([
      () => ({ op: 'pause' }),
      () => ({ op: 'play' }),
      () => ({ op: 'play', until_tick: tick() }),
      () => ({ op: 'step' }),
      () => ({ op: 'step', ticks: d.chance(0.5) ? -tick() : tick() }),
      () => ({ op: 'seek', tick: tick() }),
      () => ({ op: 'seek', tick: tick() }),
      () => ({ op: 'seek', time_s: 10 * d.next() }),
      () => ({ op: 'speed', speed: d.pick([0.1, 1, 3, 10]) }),
      () => ({ op: 'restart' }),
      () => ({ op: 'restart', reset: d.chance(0.5) }),
      () => d.make(this.contract.api.components.schemas.Control, this.contract.api),
    ])();
    return this.call('post', `${I}/control`, s, { key: s.owner_key, body: this.body(body, 0.06) });
  }

  async input() {
    const s = this.session();
    if (!s) return;
    const d = this.d;
    if (d.chance(0.3))
      await this.call('patch', `${I}/params`, s, { key: s.owner_key, body: { [`players.${d.below(3)}.control`]: 'person' } });
    for (let n = d.below(4); n >= 0; n--) {
      const body = d.chance(0.7)
        ? { player: d.below(3), axes: [d.pick([-1, 0, 1, d.next()]), d.pick([-1, 0, 1])], buttons: d.pick([0, 1, 2, 3, 255]) }
        : d.make(this.contract.api.components.schemas.Input, this.contract.api);
      const key = d.chance(0.8) ? s.owner_key : d.pick([...(s.player_keys ?? []), WRONG]);
      await this.call('post', `${I}/input`, s, { key, body: this.body(body, 0.06) });
    }
  }

  async fork() {
    const s = this.session();
    if (!s) return;
    if (this.sessions.length >= MAX_SESSIONS) await this.remove();
    if (!this.sessions.includes(s)) return;
    const before = await this.state(s);
    const answer = this.keep(
      await this.call(
        'post',
        `${I}/fork`,
        s,
        this.d.chance(0.7) ? { body: '{}' } : { body: this.body({ paused: this.d.chance(0.5), speed: 2 }) },
      ),
    );
    if (answer.status !== 201 || !before || !this.alone) return;
    const same = await this.state(answer.json, before.tick);
    if (same) {
      this.compared.forks++;
      if (same.hash !== before.hash)
        assert.equal(
          (await this.state(s, before.tick))?.hash ?? same.hash,
          same.hash,
          `the fork ${answer.json.id} differs at tick ${before.tick}`,
        );
    }
  }

  /** Tick and hash, now or at a tick; undefined when they cannot be had. */
  async state(s, tick) {
    const answer = await this.call('get', `${I}/state`, s, { query: tick === undefined ? '' : `?tick=${tick}` });
    return answer.status === 200 ? { tick: answer.json.tick, hash: answer.json.hash } : undefined;
  }

  async read() {
    const s = this.session();
    if (!s) return;
    const d = this.d;
    const part = d.pick(['', '/state', '/metrics', '/trace', '/trace', '/packets', '/log']);
    const of = d.pick([
        'ticks',
        'entities',
        'events',
        'packets',
        'corrections',
        'shapes',
        'players',
        'session',
        'methods',
        'points',
        'cells',
        'x',
        '',
      ]),
      from = d.pick([0, 0.5, 1, 1e9, 1e-9]);
    let query = '';
    if (part === '/state' && d.chance(0.7)) query = `?tick=${d.pick([0, 1, 5, 60, 100, -1, 1e9, 'x', '9'.repeat(25)])}`;
    if (part === '/trace') query = `?of=${of}&format=${d.pick(FORMATS)}&from_s=${from}&to_s=${d.pick([from, from + 1, 5, 1e9, 0])}`;
    if (part === '/packets') query = d.pick(['', `?from_s=${from}&to_s=${from + 1}`, '?at=server', '?at=A', '?at=']);
    await this.call('get', I + part, s, { query });
    if (d.chance(0.2)) await this.call('get', '/api/v1/codes/{code}', s);
  }

  /** Seeks forth and back: the same tick is the same state. */
  async thereAndBack() {
    const s = this.session();
    if (!s) return;
    const seek = (tick) => this.call('post', `${I}/control`, s, { key: s.owner_key, body: { op: 'seek', tick } });
    const at = this.d.below(200);
    const first = await seek(at);
    if (first.status !== 200 || first.json.tick !== at || first.json.status === 'failed') return;
    const on = await seek(at + this.d.below(300));
    if (on.status !== 200) return;
    const back = await seek(at);
    if (back.status !== 200 || back.json.tick !== at) return;
    this.compared.seeks++;
    assert.equal(back.json.hash, first.json.hash, `session ${s.id}: another state at tick ${at} after a seek there and back`);
    const state = await this.state(s, at);
    if (state) assert.equal(state.hash, first.json.hash, `session ${s.id}: another state at tick ${at}`);
  }

  async replay(s = this.session()) {
    if (!s) return;
    const { json, status } = await this.call('get', I, s);
    if (status !== 200 || json.head_tick > REPLAYED_TICKS || json.cost.block_bytes > 2e6) return;
    if (json.status === 'playing') await this.call('post', `${I}/control`, s, { key: s.owner_key, body: { op: 'pause' } });
    const log = await this.call('get', `${I}/log`, s);
    if (log.status !== 200) return;
    const file = path.join(this.folder, 'replayed.log');
    writeFileSync(file, log.text);
    const said = await run(BINARY, ['replay', file], { timeout: 50000, cwd: ROOT }).catch((error) => error);
    if (said.killed || typeof said.code === 'string') return; /* too long, or not begun */
    const again = /"hash":"([0-9a-f]{16})"/.exec(said.stdout),
      ticks = /"ticks":(\d+)/.exec(said.stdout);
    /* Its replay fails too, even when the session was moved to an earlier tick meanwhile. */
    const failed = /"op":"fail".*"hash":"([0-9a-f]{16})"/.exec(log.text);
    if (said.code && (!failed || said.code !== 1)) {
      writeFileSync(`/tmp/laglab-random-${this.seed}-${s.id}.log`, log.text);
      assert.fail(`replay of ${s.id} (${json.status}) ended with ${said.code}: ${said.stdout} ${said.stderr}`);
    }
    if (!again || !ticks) return;
    if (failed) {
      this.compared.replays++;
      return assert.equal(again[1], failed[1], `replay of ${s.id} gives another failure`);
    }
    const now = await this.state(s, Number(ticks[1]));
    if (!now) return;
    this.compared.replays++;
    if (now.hash !== again[1]) writeFileSync(`/tmp/laglab-random-${this.seed}-${s.id}.log`, log.text);
    assert.equal(again[1], now.hash, `replay of ${s.id} gives another state at tick ${now.tick}`);
  }

  async watch() {
    const d = this.d;
    const what = d.pick(['session', 'session', 'session', 'class', 'experiment']);
    const one = what === 'session' ? this.session() : what === 'class' ? this.classes[0] : this.experiments[0];
    if (!one || this.streams.length > 8) return this.leave();
    const place = `${what === 'class' ? 'classes' : `${what}s`}/${one.id}`,
      format = what === 'session' && d.chance(0.6) ? 'bin' : 'json';
    this.note(`stream ${place} ${format}`);
    const stream = /** @type {any} */ (
      await openStream(this.url, place, format, { ack: d.chance(0.5), subscribe: d.chance(0.5) ? null : undefined }).catch((error) => error)
    );
    if (stream instanceof Error) return this.note(`   ${stream.message}`);
    Object.assign(stream, { what, one, place, format, seen: 0, seenFrames: 0 });
    this.streams.push(stream);
  }

  async say() {
    if (!this.streams.length) return this.watch();
    const d = this.d,
      stream = d.pick(this.streams);
    if (stream.closed) return;
    const keys =
      stream.what === 'class'
        ? [stream.one.teacher_key, ...(stream.one.members ?? [])]
        : [stream.one.owner_key, ...(stream.one.player_keys ?? [])];
    const channels = (stream.hello?.channels ?? []).map((channel) => channel.name);
    const subscribe = () => ({
      subscribe: Object.fromEntries(
        [...channels, 'x']
          .filter((name) => d.chance(name === 'x' ? 0.05 : 0.5))
          .map((name) => [name, d.pick([1, 2, 7, 20, 30, 59, 60, 60, 0, 61, 0.5])]),
      ),
    });
    for (let n = d.below(4); n >= 0; n--) {
      const message = d.pick([
        subscribe,
        subscribe,
        () => ({ auth: d.pick([...keys, WRONG]), id: d.below(1000) }),
        () => ({ input: { player: d.below(3), axes: [d.pick([-1, 0, 1]), 0], buttons: d.below(4) }, id: 'i' }),
        () => ({ ping: d.next() * 1000, id: d.pick([1, 'x', 'y'.repeat(16)]) }),
        () => ({ ack: d.pick([0, 1, 60, 1000, 2 ** 31]) }),
      ])();
      const text = this.body(message, 0.15);
      this.note(`say ${stream.place} ${text.slice(0, 300)}`);
      if (stream.socket.readyState === 1) stream.say(text);
    }
    await pause(d.below(30));
  }

  async leave() {
    const stream = this.streams.length && this.d.pick(this.streams);
    if (!stream) return;
    this.streams.splice(this.streams.indexOf(stream), 1);
    this.note(`leave ${stream.place}`);
    this.heard(stream);
    const frames = stream.format === 'bin' && stream.frames.length < 400 ? stream.frames : [];
    if (this.d.chance(0.4)) stream.socket.terminate();
    else {
      await Promise.race([stream.close(), pause(3000)]);
      stream.socket.terminate();
    }
    this.compared.frames += stream.frames.length;
    if (frames.length) await decodeAll(frames, stream.hello.tick_hz);
  }

  /** Holds what came since against asyncapi.yaml. */
  heard(stream) {
    const names = stream.what === 'session' ? {} : { hello: `${stream.what}Hello`, reply: 'classReply' };
    for (const message of stream.messages.splice(0)) this.contract.checkMessage(names[message.type] ?? message.type, message);
    for (let i = stream.seenFrames; i < stream.frames.length; i += 5)
      if (stream.format === 'json') this.contract.checkMessage('frame', stream.frames[i]);
    stream.seenFrames = stream.frames.length;
    if (stream.closed)
      assert.ok(
        CLOSES.includes(stream.closed.code),
        `the stream ${stream.place} was closed with ${stream.closed.code} ${stream.closed.reason}`,
      );
  }

  listen() {
    for (const stream of this.streams) this.heard(stream);
    this.streams = this.streams.filter((stream) => !stream.closed);
  }

  hangUp() {
    for (const stream of this.streams) stream.socket.terminate();
    this.streams = [];
  }

  /** A small experiment. */
  async plan() {
    const d = this.d,
      { schemas } = this.contract;
    const { id, json } = await this.scenario();
    const leaves = this.leavesIn(json);
    const wish = /** @type {any} */ ({ scenario: d.chance(0.7) ? id : json, set: { duration_s: d.pick([0.1, 0.3, 1]) } });
    if (json.kind === 'netgame') wish.set.warmup_s = 0;
    const paths = await this.metricPaths(id, json);
    wish.metrics = Array.from({ length: 1 + d.below(3) }, () => (d.chance(0.04) ? 'no.such' : d.pick(paths)));
    wish.metrics = [...new Set(wish.metrics)];
    wish.repeats = 1 + d.below(4);
    wish.axes = Array.from({ length: d.below(3) }, () => {
      const [place, schema, root] = d.pick(leaves);
      return schema.type === 'number' && d.chance(0.4)
        ? { path: place, from: schema.minimum ?? 0, to: schema.maximum ?? 1, count: 2 + d.below(2) }
        : { path: place, values: Array.from({ length: 1 + d.below(3) }, () => d.make(schema, root)) };
    });
    for (const name of ['sample', 'stop', 'until', 'windows', 'interval', 'traces', 'error', 'cost', 'front'])
      if (d.chance(0.08)) wish[name] = d.make(schemas.$defs.experiment.properties[name], schemas);
    return wish;
  }

  /** Paths of numbers in the metrics of a scenario. */
  async metricPaths(id, scenario) {
    if (!this.metrics.has(id)) {
      const made = await this.call('post', S, {}, { body: { scenario, paused: true } });
      const found = /** @type {string[]} */ ([]);
      if (made.status === 201) {
        const { json } = await this.call('get', `${I}/metrics`, made.json);
        (function walk(at, place) {
          if (at === null || typeof at === 'number') found.push(place);
          else if (typeof at === 'object') for (const [key, one] of Object.entries(at)) walk(one, place ? `${place}.${key}` : key);
        })(json?.metrics ?? {}, '');
        await this.call('delete', I, made.json, { key: made.json.owner_key });
      }
      this.metrics.set(id, found.length ? found : ['none']);
    }
    return this.metrics.get(id);
  }

  async experiment() {
    const wish = await this.plan();
    const dry = this.d.chance(0.3);
    const answer = await this.call('post', X, {}, { body: this.body(wish, 0.15), query: dry ? '?dry_run=true' : '' });
    if (answer.status !== 202) return;
    this.experiments.unshift({ ...answer.json });
    if (this.experiments.length > 4) {
      const old = this.experiments.pop();
      await this.call('delete', `${X}/{id}`, old, { key: old.owner_key });
    }
  }

  async readExperiment() {
    if (!this.experiments.length) return this.experiment();
    const d = this.d,
      x = d.pick(this.experiments),
      at = `${X}/{id}`;
    const run_ = d.pick([0, 0, 1, 2, 99, 1e15]);
    await d.pick([
      () => this.call('get', at, x),
      () =>
        this.call('post', `${at}/control`, x, {
          key: x.owner_key,
          body: this.body({ op: d.pick(['pause', 'resume', 'resume', 'cancel']) }),
        }),
      () =>
        this.call('get', `${at}/results`, x, {
          query: `?format=${d.pick(FORMATS)}${d.pick(OF_POINTS)}`,
        }),
      () => this.call('get', `${at}/report`, x),
      () => this.call('get', `${at}/runs/{run}`, { ...x, run: run_ }),
      () =>
        this.call(
          'get',
          `${at}/runs/{run}/trace`,
          { ...x, run: run_ },
          {
            query: `?of=${d.pick(['ticks', 'entities', 'events', 'packets', 'x'])}&format=${d.pick(['csv', 'sqlite', 'json'])}`,
          },
        ),
      () => this.sameAsRun(x),
      () => this.sameAsRun(x),
    ])();
  }

  /** A session of a run's scenario ends in the state that the run's row has. */
  async sameAsRun(x) {
    const rows = await this.call('get', `${X}/{id}/results`, x, { query: '?format=json' });
    if (rows.status !== 200 || !Array.isArray(rows.json)) return;
    const row = this.d.pick(rows.json.filter((one) => one.status === 'ok' && one.hash));
    if (!row) return;
    const { json, status } = await this.call('get', `${X}/{id}/runs/{run}`, { ...x, run: row.run });
    if (status !== 200) return;
    const made = await this.call('post', S, {}, { body: { scenario: json, paused: true } });
    if (made.status !== 201)
      return assert.ok(
        [503, 507].includes(made.status) || /max-state/.test(made.text),
        `the scenario of run ${row.run} is refused: ${made.text}`,
      );
    const there = await this.call('post', `${I}/control`, made.json, {
      key: made.json.owner_key,
      body: { op: 'seek', time_s: json.duration_s },
    });
    if (there.status === 200) {
      this.compared.runs++;
      assert.equal(there.json.hash, row.hash, `run ${row.run} of ${x.id} ended in another state than its session`);
    }
    await this.call('delete', I, made.json, { key: made.json.owner_key });
  }

  async job() {
    const d = this.d;
    if (this.jobs.length > 2) {
      const { place, ...old } = this.jobs.shift();
      await this.call('delete', `${place}/{id}`, old, { key: old.owner_key });
    }
    const place = d.chance(0.7) ? '/api/v1/advise' : '/api/v1/tradeoffs';
    const wish = place.endsWith('advise')
      ? { experiment: await this.plan(), max_error: d.pick([1e-3, 1, 100]), runs: 1 + d.below(60) }
      : { family: d.pick(this.families).name, seeds: 10, check_seeds: d.pick([0, 10]), duration_s: d.pick([0.05, 0.2]) };
    const answer = await this.call('post', place, {}, { body: this.body(wish, 0.15) });
    if (answer.status === 202) this.jobs.push({ place, ...answer.json });
  }

  async readJob() {
    const one = this.jobs.length && this.d.pick(this.jobs);
    if (one) await this.call('get', `${one.place}/{id}`, one);
  }

  async openClass() {
    if (this.classes.length > 2) {
      const old = this.classes.pop();
      await this.call('delete', C, old, { key: old.teacher_key });
    }
    const answer = await this.call(
      'post',
      '/api/v1/classes',
      {},
      { body: this.body(this.d.chance(0.5) ? {} : this.d.make(this.contract.api.components.schemas.ClassPatch, this.contract.api)) },
    );
    if (answer.status === 201) this.classes.unshift({ ...answer.json, members: [] });
  }

  async inClass() {
    if (!this.classes.length) return this.openClass();
    const d = this.d,
      one = d.pick(this.classes),
      { schemas } = this.contract.api.components,
      made = (name) => this.body(d.make(schemas[name], this.contract.api));
    const key = one.teacher_key,
      member = () => (one.members.length ? d.pick(one.members) : WRONG),
      name = { id: d.chance(0.8) ? one.id : one.code };
    await d.pick([
      () => this.call('get', C, name),
      () => this.call('patch', C, name, { key, body: made('ClassPatch') }),
      () =>
        this.call('patch', C, name, {
          key,
          body: {
            phase: d.pick(['lobby', 'predict', 'locked', 'run', 'stopped', 'explain', 'change', 'free']),
            choices: d.below(5),
            stop_tick: d.pick([0, 30, 200]),
            door: d.pick(['open', 'open', 'closed']),
          },
        }),
      () => this.call('patch', C, name, { key, body: { frozen: d.chance(0.5), together: d.chance(0.5) } }),
      async () => {
        const s = this.session();
        const body =
          s && d.chance(0.6)
            ? { session: s.id, owner_key: s.owner_key }
            : { scenario: d.pick(this.scenarios).id, set: d.chance(0.5) ? { 'players.0.control': 'person' } : {} };
        const answer = await this.call('put', `${C}/board`, name, { key, body: this.body(body) });
        if (answer.status === 200 && answer.json.owner_key) this.sessions.push({ ...answer.json, player_keys: [] });
      },
      async () => {
        const answer = await this.call('post', `${C}/members`, name, { body: made('Wish') });
        if (answer.status === 201) one.members.push(answer.json.token);
        if (answer.status === 201 && answer.json.copy)
          this.sessions.push({ id: answer.json.copy, owner_key: answer.json.copy_key, player_keys: [] });
      },
      () => this.call('get', `${C}/members`, name, { key: d.pick([key, member()]) }),
      () => this.call('delete', `${C}/seats/{player}`, { ...name, player: d.below(3) }, { key }),
      () =>
        this.call(
          'delete',
          `${C}/members/{number}`,
          { ...name, number: d.below(30) },
          { key, query: d.pick(['', '?and=later', '?and=address']) },
        ),
      () => this.call('get', `${C}/member`, name, { key: member() }),
      async () => {
        const answer = await this.call('patch', `${C}/member`, name, { key: member(), body: made('Wish') });
        if (answer.status === 200 && answer.json.copy_key)
          this.sessions.push({ id: answer.json.copy, owner_key: answer.json.copy_key, player_keys: [] });
      },
      () => this.call('put', `${C}/vote`, name, { key: member(), body: made('Vote') }),
      async () => {
        if (d.chance(0.7)) return;
        const token = member();
        await this.call('delete', `${C}/member`, name, { key: token });
        one.members = one.members.filter((other) => other !== token);
      },
    ])();
    while (this.sessions.length > MAX_SESSIONS) await this.remove();
  }

  /** Any operation of the document, with what its schemas say or something else. */
  async anything() {
    const d = this.d,
      { api, resolve } = this.contract;
    const template = d.pick(Object.keys(api.paths).filter((one) => !one.endsWith('/stream') && !(this.front && one === '/metrics')));
    const item = api.paths[template],
      method = d.pick(Object.keys(item).filter((key) => key !== 'parameters' && key !== 'description'));
    const operation = item[method];
    if (method === 'delete' && d.chance(0.9)) return;
    if (operation.operationId === 'setCreation') {
      await this.call(
        method,
        template,
        {},
        { key: OPERATOR, body: this.body(d.make({ $ref: '#/components/schemas/Creation' }, api), 0.5) },
      );
      return this.call(method, template, {}, { key: OPERATOR, body: { creation: 'open' } });
    }
    const of = template.startsWith(S)
      ? this.session()
      : template.startsWith(X)
        ? this.experiments[0]
        : template.startsWith('/api/v1/classes')
          ? this.classes[0]
          : this.jobs[0];
    const values = /** @type {any} */ ({
      id: of?.id ?? NOBODY,
      code: of?.code ?? '2222',
      run: d.pick([0, 1, -1, 'x', 1e20]),
      number: d.below(9),
      player: d.below(3),
    });
    if (template === '/api/v1/scenarios/{id}') values.id = d.pick(this.scenarios).id;
    const query = [...(item.parameters ?? []), ...(operation.parameters ?? [])]
      .map(resolve)
      .filter((one) => one.in === 'query' && d.chance(0.6));
    const word = (value) =>
      encodeURIComponent(
        String(value)
          .slice(0, 500)
          .replace(/[\ud800-\udfff\0]/g, ''),
      );
    const asked = query.map((one) => `${one.name}=${word(d.chance(0.7) ? d.make(one.schema, api) : d.junk())}`);
    const wish = /** @type {any} */ ({ query: asked.length ? `?${asked.join('&')}` : '' });
    const key = d.pick([
      of?.owner_key ?? of?.teacher_key,
      of?.owner_key ?? of?.teacher_key,
      WRONG,
      undefined,
      OPERATOR,
      of?.player_keys?.[0],
    ]);
    if (key) wish.key = key;
    if (operation.requestBody) {
      const schema = resolve(operation.requestBody).content['application/json'].schema;
      wish.body = this.body(d.make(schema, api), 0.4);
    }
    const answer = await this.call(method, template, values, wish);
    if (answer.status === 201 && template === S) this.keep(answer);
    if (answer.status === 201 && template.endsWith('/fork')) this.keep(answer);
    if (answer.status === 204 && template === I) this.sessions = this.sessions.filter((one) => one !== of);
    if (answer.status === 204 && template === `${X}/{id}`) this.experiments = this.experiments.filter((one) => one !== of);
    if (answer.status === 204 && template === C) this.classes = this.classes.filter((one) => one !== of);
  }

  /** Several at the same time. */
  async atOnce() {
    const quick = [
      () => this.patch(),
      () => this.control(),
      () => this.control(),
      () => this.read(),
      () => this.input(),
      () => this.fork(),
      () => this.inClass(),
      () => this.readExperiment(),
    ];
    this.alone = false; /* what is compared would be changed in between */
    await Promise.all(Array.from({ length: 3 + this.d.below(5) }, () => this.d.pick(quick)())).finally(() => {
      this.alone = true;
    });
  }

  async remove() {
    const s = this.session();
    if (!s) return;
    this.sessions.splice(this.sessions.indexOf(s), 1);
    await this.call('delete', I, s, { key: s.owner_key });
  }

  /** Ends the daemon and starts it again: all that it acknowledged is there. */
  async restart() {
    const kill = this.d.chance(0.5),
      before = /** @type {any[]} */ ([]);
    for (const s of this.sessions) {
      if (this.d.chance(0.7)) await this.call('post', `${I}/control`, s, { key: s.owner_key, body: { op: 'pause' } });
      const position = await this.position(s);
      if (position) before.push({ s, position, state: await this.state(s) });
    }
    this.note(`restart by ${kill ? 'SIGKILL' : 'SIGTERM'}`);
    this.hangUp();
    this.c.close();
    await this.before?.stop();
    if (kill) await this.daemon.kill();
    else {
      const how = await this.daemon.stop();
      assert.equal(how.code, 0, `SIGTERM: ${JSON.stringify(how)}: ${this.daemon.errors()}`);
    }
    await this.start();
    for (const { s, position, state } of before) {
      let after = await this.position(s);
      for (let more = 4; !after && more > 0; more--) after = await this.position(s); /* 503: not awake yet, it goes on from there */
      if (!after) {
        assert.equal((await this.call('get', I, s)).status, 503, `session ${s.id} is lost`);
        continue;
      }
      this.compared.restarts++;
      if (position.status === 'paused') assert.deepEqual(after, position, `session ${s.id} after the restart`);
      const again = state && (await this.state(s, state.tick));
      if (again) {
        this.compared.hashes++;
        assert.equal(again.hash, state.hash, `session ${s.id} has another state at tick ${state.tick} after the restart`);
      }
    }
    for (const x of this.experiments)
      assert.ok([200, 503].includes((await this.call('get', `${X}/{id}`, x)).status), `experiment ${x.id} is lost`);
    for (const one of this.classes) {
      assert.equal((await this.call('get', C, one)).status, 200, `class ${one.id} is lost`);
      for (const token of one.members) assert.ok([200, 403].includes((await this.call('get', `${C}/member`, one, { key: token })).status));
    }
  }

  /** Deletes everything; nothing of it is left in memory. */
  async clear() {
    this.hangUp();
    while (this.sessions.length) await this.remove();
    for (const x of this.experiments.splice(0)) await this.call('delete', `${X}/{id}`, x, { key: x.owner_key });
    for (const one of this.classes.splice(0)) await this.call('delete', C, one, { key: one.teacher_key });
    for (const { place, ...one } of this.jobs.splice(0)) await this.call('delete', `${place}/{id}`, one, { key: one.owner_key });
    const left = await this.c.call('GET', `${S}?limit=1000`, { key: OPERATOR });
    const own = left.json.sessions.filter((one) => one.id); /* copies and boards of classes */
    for (const { id } of own) await this.call('delete', I, { id }, { key: OPERATOR });
    const value = (text, name) => Number(new RegExp(`^${name} (\\S+)$`, 'm').exec(text)?.[1]);
    const text = await (await fetch(new URL('/metrics', this.daemon.url))).text(); /* no proxy passes it on */
    assert.equal(value(text, 'laglab_sessions'), 0);
    assert.equal(value(text, 'laglab_sessions_memory_bytes'), 0, 'memory of deleted sessions');
  }

  rss() {
    return Number(/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${this.daemon.pid}/status`, 'utf8'))[1]) * 1024;
  }

  /** One life of some sessions. */
  async round(round, turns, until = Infinity) {
    for (let turn = 1; turn <= turns && performance.now() < until; turn++) {
      this.draws(round, turn);
      await this.act();
    }
    this.draws(round, 0);
    for (const s of this.sessions.slice(0, 3)) await this.replay(s);
    if (round % 2 === 0) await this.restart();
    await this.clear();
    this.compared.rounds++;
  }
}
