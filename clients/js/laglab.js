// laglab from JavaScript: runs, sweeps, live sessions and experiments on a daemon. For browsers and for Node from 18 on, without a build.
//
//   import { connect } from 'laglab';                        // a page of the daemon: '/clients/js/laglab.js'
//
//   const lab = await connect('http://127.0.0.1:8080');
//   const result = await lab.run('race', { duration_s: 10, set: { 'players.0.lag_ms': 200 } });
//   result.at('players.0.remote_error_m.mean');
import { LaglabError } from './errors.js';
import { namedAxes, specification, withNames } from './specification.js';
import { frames, openLine } from './stream.js';
import { leaves, valueAt } from './values.js';

export { LaglabError, leaves, specification, valueAt };
export * from '../../www/js/stream/names.js';

/** @typedef {import('./specification.js').Scenario} Scenario */
/** @typedef {import('./specification.js').Settings} Settings */
/** @typedef {import('./specification.js').Wish} Wish */
/** @typedef {import('./stream.js').Frame} Frame */
/** The operations of the API by their names, as api/openapi.yaml has them. @typedef {import('./types/api.js').operations} Operations */
/** The schemas of the same. @typedef {import('./types/api.js').components['schemas']} Schemas */
/** The JSON that an operation answers with.
 * @template {keyof Operations} Name
 * @typedef {Operations[Name] extends {responses: {200: {content: {'application/json': infer Body}}}} ? Body
 *   : Operations[Name] extends {responses: {201: {content: {'application/json': infer Body}}}} ? Body
 *   : Operations[Name] extends {responses: {202: {content: {'application/json': infer Body}}}} ? Body : never} Answer */
/** A row of a table: columns by name. @typedef {Record<string, any>} Row */
/** A message of an experiment's stream.
 * @typedef {{type: string, state: string, runs: number, done: number, rate_per_s: number, left_s: number | null}} Progress */
/** Where a session is after a command. @typedef {Answer<'controlSession'>} Position */
/** What of which ticks a trace has. `of`: `ticks`, a record such as `entities`, `events`, `packets` or `corrections`.
 * @typedef {{from_s?: number, to_s?: number, of?: string}} TraceWish */

/**
 * Anything beyond a method and a path.
 * @typedef {object} RequestWish
 * @property {unknown} [body]  sent as JSON
 * @property {string} [key]
 * @property {Record<string, string | number | boolean | undefined>} [query]
 * @property {string} [accept]
 */

/** @param {Response} answer @returns {Promise<LaglabError>} */
async function refusal(answer) {
  const text = await answer.text(),
    wait = Number(answer.headers.get('retry-after') ?? NaN);
  let sentence = `the daemon answers ${answer.status} ${answer.statusText}`;
  /** @type {Record<string, string>} */
  let fields = {};
  try {
    const problem = JSON.parse(text);
    if (problem.detail) sentence = problem.detail;
    fields = Object.fromEntries((problem.errors ?? []).map((/** @type {any} */ { field, detail }) => [field, detail]));
  } catch {
    /* it is no problem document */
  }
  return new LaglabError(sentence, { status: answer.status, fields, retryAfterS: Number.isFinite(wait) ? wait : null });
}

/** What one run has measured. */
export class Result {
  /** @param {{scenario: Scenario, seed: number, duration_s: number, tick: number, hash: string, metrics: any}} report */
  constructor({ scenario, seed, duration_s, tick, hash, metrics }) {
    this.scenario = scenario;
    this.seed = seed;
    this.duration_s = duration_s;
    this.ticks = tick;
    /** Of the whole simulated state at the end: the same on every machine. */
    this.hash = hash;
    /** The tree of all metrics. */
    this.metrics = metrics;
  }

  /** One of them by its path; null: it was not counted in this run. @param {string} path @returns {any} */
  at(path) {
    return valueAt(this.metrics, path);
  }
}

/** A daemon. `key` is its class key or operator's key, where creation needs one. */
export class Daemon {
  /** @param {string | URL} url @param {{key?: string}} [more] */
  constructor(url, { key } = {}) {
    this.url = new URL(url);
    this.key = key;
  }

  /** @param {string} path below /api/v1/ @returns {URL} */
  address(path) {
    return new URL(`api/v1/${path}`, this.url.href.replace(/\/?$/, '/'));
  }

  /** Any operation of the API: docs/api.md. @param {string} method @param {string} path @param {RequestWish} [wish]
   * @returns {Promise<Response>} */
  async answer(method, path, { body, key = this.key, query = {}, accept = 'application/json' } = {}) {
    const address = this.address(path);
    for (const [name, value] of Object.entries(query)) if (value !== undefined) address.searchParams.set(name, String(value));
    /** @type {Record<string, string>} */
    const headers = { Accept: accept };
    if (body !== undefined) headers['Content-Type'] = 'application/json';
    if (key) headers.Authorization = `Bearer ${key}`;
    /** @type {Response} */
    let answer;
    try {
      answer = await fetch(address, { method, headers, body: body === undefined ? null : JSON.stringify(body), cache: 'no-store' });
    } catch (error) {
      const cause = /** @type {any} */ (error)?.cause;
      throw new LaglabError(`no daemon answers at ${this.url.href}: ${cause?.code ?? cause?.message ?? error}`);
    }
    if (!answer.ok) throw await refusal(answer);
    return answer;
  }

  /** The same with the text of the answer. @param {string} method @param {string} path @param {RequestWish} [wish]
   * @returns {Promise<string>} */
  async request(method, path, wish) {
    return (await this.answer(method, path, wish)).text();
  }

  /** The same with the JSON of the answer; null when it has none.
   * @param {string} method @param {string} path @param {RequestWish} [wish] @returns {Promise<any>} */
  async json(method, path, wish) {
    const text = await this.request(method, path, wish);
    return text === '' ? null : JSON.parse(text);
  }

  /** The library: of each scenario its id, kind and title. @returns {Promise<Answer<'listScenarios'>['scenarios']>} */
  async scenarios() {
    return (await this.json('GET', 'scenarios', { query: { brief: true } })).scenarios;
  }

  /** A scenario of the library, to be changed and run. @param {string} id @returns {Promise<Record<string, any>>} */
  scenario(id) {
    return this.json('GET', `scenarios/${id.split('/').map(encodeURIComponent).join('/')}`);
  }

  /** Creates a session. It is paused at tick 0 unless `playing`, so that a program decides when it moves.
   * @param {Scenario} scenario @param {{set?: Record<string, any>, seed?: number, playing?: boolean, speed?: number}} [wish]
   * @returns {Promise<Session>} */
  async session(scenario, { set, seed, playing = false, speed } = {}) {
    const made = await this.json('POST', 'sessions', { body: { scenario, set, seed, speed, paused: !playing } });
    return new Session(this, made.id, made.owner_key, made.code, made.player_keys);
  }

  /** An existing session by its id; without its key it can only be watched. @param {string} id @param {string} [key]
   * @returns {Promise<Session>} */
  async attach(id, key) {
    await this.json('GET', `sessions/${id}`);
    return new Session(this, id, key);
  }

  /** Runs a scenario to its end at full speed. @param {Scenario} scenario
   * @param {{set?: Record<string, any>, seed?: number, duration_s?: number}} [wish] @returns {Promise<Result>} */
  async run(scenario, { set, seed, duration_s } = {}) {
    const session = await this.session(scenario, { seed, set: duration_s === undefined ? set : { ...set, duration_s } });
    try {
      await session.finish();
      const { seed: used, duration_s: whole } = await session.info();
      return new Result({ scenario, seed: used, duration_s: whole, ...(await session.report()) });
    } finally {
      await session.delete();
    }
  }

  /** Starts an experiment. @param {Scenario} scenario @param {Wish} wish @returns {Promise<Experiment>} */
  async experiment(scenario, wish) {
    const made = await this.json('POST', 'experiments', { body: specification(scenario, wish) });
    return new Experiment(this, made.id, made.owner_key, namedAxes(wish.axes));
  }

  /** Runs an experiment and deletes it: a row for each run, or with `points` for each point, with means and 95 % intervals.
   * @param {Scenario} scenario @param {Wish & {points?: boolean, progress?: (message: Progress) => void}} wish @returns {Promise<Row[]>} */
  async sweep(scenario, { points = false, progress, ...wish }) {
    const made = await this.experiment(scenario, wish);
    try {
      await made.wait(progress);
      return await made.table({ points });
    } finally {
      await made.delete();
    }
  }
}

/** The daemon at `url`: by default that which a page comes from, or the one of this machine. Throws where none answers.
 * @param {string | URL} [url] @param {{key?: string}} [more] @returns {Promise<Daemon>} */
export async function connect(url = globalThis.location?.origin ?? 'http://127.0.0.1:8080', more) {
  const daemon = new Daemon(url, more);
  await daemon.json('GET', 'creation');
  return daemon;
}

/** A session of a daemon. */
export class Session {
  /** @param {Daemon} daemon @param {string} id @param {string} [key] @param {string} [code] @param {string[]} [playerKeys] */
  constructor(daemon, id, key, code = '', playerKeys = []) {
    this.daemon = daemon;
    this.id = id;
    this.key = key;
    this.code = code;
    this.playerKeys = playerKeys;
  }

  /** @param {string} method @param {string} path @param {RequestWish} [wish] @returns {Promise<any>} */
  json(method, path, wish) {
    return this.daemon.json(method, `sessions/${this.id}${path}`, { key: this.key, ...wish });
  }

  /** Its state of play, parameters and cost. @returns {Promise<Answer<'getSession'>>} */
  info() {
    return this.json('GET', '');
  }

  /** `play`, `pause`, `step`, `seek`, `speed` or `restart`. @param {string} op @param {Record<string, unknown>} [more]
   * @returns {Promise<Position>} */
  control(op, more = {}) {
    return this.json('POST', '/control', { body: { op, ...more } });
  }

  /** @param {number} [speed] */
  async play(speed) {
    if (speed !== undefined) await this.control('speed', { speed });
    return this.control('play');
  }

  pause() {
    return this.control('pause');
  }

  /** Moves by ticks, back with a negative number, and pauses there. @param {number} [ticks] */
  step(ticks = 1) {
    return this.control('step', { ticks });
  }

  /** @param {number} time_s */
  seek(time_s) {
    return this.control('seek', { time_s });
  }

  /** Moves to the end of the scenario. A daemon interrupts requests that take long; this goes on from where it has come to.
   * @returns {Promise<Position>} */
  async finish() {
    const { duration_s } = await this.info();
    for (let before = -1; ; ) {
      try {
        return await this.seek(duration_s);
      } catch (error) {
        const { tick } = await this.info();
        if (!(error instanceof LaglabError) || error.status !== 503 || tick <= before) throw error;
        before = tick;
      }
    }
  }

  /** @param {boolean} [reset] to the parameters of the creation */
  restart(reset = false) {
    return this.control('restart', { reset });
  }

  /** Changes live parameters by their paths, all or nothing. @param {Record<string, any>} values
   * @returns {Promise<Answer<'patchParams'>>} */
  set(values) {
    return this.json('PATCH', '/params', { body: values });
  }

  /** A person's controls, held until the next call; the player's `control` must be `person`.
   * @param {number} player @param {number[]} [axes] @param {number} [buttons] @returns {Promise<Answer<'postInput'>>} */
  input(player, axes = [0, 0], buttons = 0) {
    return this.json('POST', '/input', { body: { player, axes, buttons } });
  }

  /** The whole simulated state, now or at an earlier tick. @param {number} [tick] @returns {Promise<Answer<'getState'> & {state: any}>} */
  state(tick) {
    return this.json('GET', '/state', { query: { tick } });
  }

  /** @returns {Promise<Answer<'getMetrics'> & {metrics: any}>} from tick 0 to now */
  report() {
    return this.json('GET', '/metrics');
  }

  /** One metric, such as `players.0.remote_error_m.mean`. @param {string} path @returns {Promise<any>} */
  async metric(path) {
    return valueAt((await this.report()).metrics, path);
  }

  /** The trace as CSV. @param {TraceWish} [wish] @returns {Promise<string>} */
  trace(wish) {
    return this.daemon.request('GET', `sessions/${this.id}/trace`, { key: this.key, query: wish, accept: 'text/csv' });
  }

  /** The same as rows. @param {TraceWish} [wish] @returns {Promise<Row[]>} */
  table(wish) {
    return this.json('GET', '/trace', { query: wish });
  }

  /** The log, which `laglab replay` runs again. @returns {Promise<string>} */
  log() {
    return this.daemon.request('GET', `sessions/${this.id}/log`, { key: this.key, accept: '*/*' });
  }

  /** A separate session from the log up to now. @returns {Promise<Session>} */
  async fork() {
    const made = await this.json('POST', '/fork', { body: {} });
    return new Session(this.daemon, made.id, made.owner_key, made.code, made.player_keys);
  }

  /** Frames while they come: `for await (const frame of session.stream({ scene: 30 }))`. Channels and their rates in Hz are those of
   * api/asyncapi.yaml; none: the drawn ones at 30 Hz. `break` ends it. @param {Record<string, number>} [channels]
   * @returns {AsyncGenerator<Frame, void, void>} */
  async *stream(channels = {}) {
    await this.info(); // a browser does not say why a stream is refused
    yield* frames(this.daemon.address(`sessions/${this.id}/stream`), channels, () => this.daemon.json('GET', 'stream/schema.json'));
  }

  async delete() {
    await this.json('DELETE', '');
  }
}

/** An experiment on a daemon. It goes on when this program ends, unless it is deleted. */
export class Experiment {
  /** @param {Daemon} daemon @param {string} id @param {string} [key] @param {Record<string, Settings>} [named] */
  constructor(daemon, id, key, named = {}) {
    this.daemon = daemon;
    this.id = id;
    this.key = key;
    this.named = named;
  }

  /** Its specification, state, and how many runs are done. @returns {Promise<Answer<'getExperiment'>>} */
  info() {
    return this.daemon.json('GET', `experiments/${this.id}`);
  }

  /** @param {'pause' | 'resume' | 'cancel'} op @returns {Promise<Answer<'controlExperiment'>>} */
  control(op) {
    return this.daemon.json('POST', `experiments/${this.id}/control`, { body: { op }, key: this.key });
  }

  /** Progress while it runs: `for await (const { done, runs } of experiment.progress())`.
   * @returns {AsyncGenerator<Progress, void, void>} */
  async *progress() {
    const line = await openLine(this.daemon.address(`experiments/${this.id}/stream`), 'laglab.v2.json');
    try {
      for (let data = await line.next(); data !== null; data = await line.next()) {
        const message = JSON.parse(String(data));
        if (message.type === 'hello' || message.type === 'progress') yield message;
      }
    } finally {
      line.close();
    }
  }

  /** Returns when it is done. Throws where it has failed or was cancelled. @param {(message: Progress) => void} [progress]
   * @returns {Promise<Experiment>} */
  async wait(progress) {
    for await (const message of this.progress()) progress?.(message);
    const { state } = await this.info();
    if (state !== 'done') throw new LaglabError(`the experiment is ${state}`);
    return this;
  }

  /** The present rows; with `points` means and 95 % intervals. @param {{points?: boolean, compare?: string}} [wish]
   * @returns {Promise<Row[]>} */
  async table({ points = false, compare } = {}) {
    const query = { format: 'json', points: points || undefined, compare };
    return withNames(await this.daemon.json('GET', `experiments/${this.id}/results`, { query }), this.named);
  }

  /** A standalone page with plots and tables. @returns {Promise<string>} */
  report() {
    return this.daemon.request('GET', `experiments/${this.id}/report`, { accept: 'text/html' });
  }

  /** One run as a live session, paused at its start. @param {number} run @returns {Promise<Session>} */
  async open(run) {
    return this.daemon.session(await this.daemon.json('GET', `experiments/${this.id}/runs/${run}`));
  }

  async delete() {
    await this.daemon.json('DELETE', `experiments/${this.id}`, { key: this.key });
  }
}
