/** The daemon at `url`: by default that which a page comes from, or the one of this machine. Throws where none answers.
 * @param {string | URL} [url] @param {{key?: string}} [more] @returns {Promise<Daemon>} */
export function connect(url?: string | URL, more?: {
    key?: string;
}): Promise<Daemon>;
export * from "../../www/js/stream/names.js";
/** What one run has measured. */
export class Result {
    /** @param {{scenario: Scenario, seed: number, duration_s: number, tick: number, hash: string, metrics: any}} report */
    constructor({ scenario, seed, duration_s, tick, hash, metrics }: {
        scenario: Scenario;
        seed: number;
        duration_s: number;
        tick: number;
        hash: string;
        metrics: any;
    });
    scenario: import("./specification.js").Scenario;
    seed: number;
    duration_s: number;
    ticks: number;
    /** Of the whole simulated state at the end: the same on every machine. */
    hash: string;
    /** The tree of all metrics. */
    metrics: any;
    /** One of them by its path; null: it was not counted in this run. @param {string} path @returns {any} */
    at(path: string): any;
}
/** A daemon. `key` is its class key or operator's key, where creation needs one. */
export class Daemon {
    /** @param {string | URL} url @param {{key?: string}} [more] */
    constructor(url: string | URL, { key }?: {
        key?: string;
    });
    url: URL;
    key: string | undefined;
    /** @param {string} path below /api/v1/ @returns {URL} */
    address(path: string): URL;
    /** Any operation of the API: docs/api.md. @param {string} method @param {string} path @param {RequestWish} [wish]
     * @returns {Promise<Response>} */
    answer(method: string, path: string, { body, key, query, accept }?: RequestWish): Promise<Response>;
    /** The same with the text of the answer. @param {string} method @param {string} path @param {RequestWish} [wish]
     * @returns {Promise<string>} */
    request(method: string, path: string, wish?: RequestWish): Promise<string>;
    /** The same with its bytes. @param {string} method @param {string} path @param {RequestWish} [wish] @returns {Promise<Uint8Array>} */
    bytes(method: string, path: string, wish?: RequestWish): Promise<Uint8Array>;
    /** The same with the JSON of the answer; null when it has none.
     * @param {string} method @param {string} path @param {RequestWish} [wish] @returns {Promise<any>} */
    json(method: string, path: string, wish?: RequestWish): Promise<any>;
    /** The library: of each scenario its id, kind and title. @returns {Promise<Answer<'listScenarios'>['scenarios']>} */
    scenarios(): Promise<Answer<"listScenarios">["scenarios"]>;
    /** A scenario of the library, to be changed and run. @param {string} id @returns {Promise<Record<string, any>>} */
    scenario(id: string): Promise<Record<string, any>>;
    /** Creates a session. It is paused at tick 0 unless `playing`, so that a program decides when it moves.
     * @param {Scenario} scenario @param {{set?: Record<string, any>, seed?: number, playing?: boolean, speed?: number}} [wish]
     * @returns {Promise<Session>} */
    session(scenario: Scenario, { set, seed, playing, speed }?: {
        set?: Record<string, any>;
        seed?: number;
        playing?: boolean;
        speed?: number;
    }): Promise<Session>;
    /** An existing session by its id; without its key it can only be watched. @param {string} id @param {string} [key]
     * @returns {Promise<Session>} */
    attach(id: string, key?: string): Promise<Session>;
    /** Runs a scenario to its end at full speed. @param {Scenario} scenario
     * @param {{set?: Record<string, any>, seed?: number, duration_s?: number}} [wish] @returns {Promise<Result>} */
    run(scenario: Scenario, { set, seed, duration_s }?: {
        set?: Record<string, any>;
        seed?: number;
        duration_s?: number;
    }): Promise<Result>;
    /** Starts an experiment. @param {Scenario} scenario @param {Wish} wish @returns {Promise<Experiment>} */
    experiment(scenario: Scenario, wish: Wish): Promise<Experiment>;
    /** Runs an experiment and deletes it: a row for each run, or with `points` for each point, with means and 95 % intervals.
     * @param {Scenario} scenario @param {Wish & {points?: boolean, progress?: (message: Progress) => void}} wish @returns {Promise<Row[]>} */
    sweep(scenario: Scenario, { points, progress, ...wish }: Wish & {
        points?: boolean;
        progress?: (message: Progress) => void;
    }): Promise<Row[]>;
}
/** A session of a daemon. */
export class Session {
    /** @param {Daemon} daemon @param {string} id @param {string} [key] @param {string} [code] @param {string[]} [playerKeys] */
    constructor(daemon: Daemon, id: string, key?: string, code?: string, playerKeys?: string[]);
    daemon: Daemon;
    id: string;
    key: string | undefined;
    code: string;
    playerKeys: string[];
    /** @param {string} method @param {string} path @param {RequestWish} [wish] @returns {Promise<any>} */
    json(method: string, path: string, wish?: RequestWish): Promise<any>;
    /** Its state of play, parameters and cost. @returns {Promise<Answer<'getSession'>>} */
    info(): Promise<Answer<"getSession">>;
    /** `play`, `pause`, `step`, `seek`, `speed` or `restart`. @param {string} op @param {Record<string, unknown>} [more]
     * @returns {Promise<Position>} */
    control(op: string, more?: Record<string, unknown>): Promise<Position>;
    /** @param {number} [speed] */
    play(speed?: number): Promise<{
        status: import("../../api.js").components["schemas"]["Status"];
        tick: import("../../api.js").components["schemas"]["Tick"];
        time_s: import("../../api.js").components["schemas"]["Seconds"];
        log_end_s: import("../../api.js").components["schemas"]["Seconds"];
        speed: import("../../api.js").components["schemas"]["Speed"];
        generation: import("../../api.js").components["schemas"]["Counter"];
        hash: import("../../api.js").components["schemas"]["Hash"];
    }>;
    pause(): Promise<{
        status: import("../../api.js").components["schemas"]["Status"];
        tick: import("../../api.js").components["schemas"]["Tick"];
        time_s: import("../../api.js").components["schemas"]["Seconds"];
        log_end_s: import("../../api.js").components["schemas"]["Seconds"];
        speed: import("../../api.js").components["schemas"]["Speed"];
        generation: import("../../api.js").components["schemas"]["Counter"];
        hash: import("../../api.js").components["schemas"]["Hash"];
    }>;
    /** Moves by ticks, back with a negative number, and pauses there. @param {number} [ticks] */
    step(ticks?: number): Promise<{
        status: import("../../api.js").components["schemas"]["Status"];
        tick: import("../../api.js").components["schemas"]["Tick"];
        time_s: import("../../api.js").components["schemas"]["Seconds"];
        log_end_s: import("../../api.js").components["schemas"]["Seconds"];
        speed: import("../../api.js").components["schemas"]["Speed"];
        generation: import("../../api.js").components["schemas"]["Counter"];
        hash: import("../../api.js").components["schemas"]["Hash"];
    }>;
    /** @param {number} time_s */
    seek(time_s: number): Promise<{
        status: import("../../api.js").components["schemas"]["Status"];
        tick: import("../../api.js").components["schemas"]["Tick"];
        time_s: import("../../api.js").components["schemas"]["Seconds"];
        log_end_s: import("../../api.js").components["schemas"]["Seconds"];
        speed: import("../../api.js").components["schemas"]["Speed"];
        generation: import("../../api.js").components["schemas"]["Counter"];
        hash: import("../../api.js").components["schemas"]["Hash"];
    }>;
    /** Moves to the end of the scenario. A daemon interrupts requests that take long; this goes on from where it has come to.
     * @returns {Promise<Position>} */
    finish(): Promise<Position>;
    /** @param {boolean} [reset] to the parameters of the creation */
    restart(reset?: boolean): Promise<{
        status: import("../../api.js").components["schemas"]["Status"];
        tick: import("../../api.js").components["schemas"]["Tick"];
        time_s: import("../../api.js").components["schemas"]["Seconds"];
        log_end_s: import("../../api.js").components["schemas"]["Seconds"];
        speed: import("../../api.js").components["schemas"]["Speed"];
        generation: import("../../api.js").components["schemas"]["Counter"];
        hash: import("../../api.js").components["schemas"]["Hash"];
    }>;
    /** Changes live parameters by their paths, all or nothing. @param {Record<string, any>} values
     * @returns {Promise<Answer<'patchParams'>>} */
    set(values: Record<string, any>): Promise<Answer<"patchParams">>;
    /** A person's controls, held until the next call; the player's `control` must be `person`.
     * @param {number} player @param {number[]} [axes] @param {number} [buttons] @returns {Promise<Answer<'postInput'>>} */
    input(player: number, axes?: number[], buttons?: number): Promise<Answer<"postInput">>;
    /** The whole simulated state, now or at an earlier tick. @param {number} [tick] @returns {Promise<Answer<'getState'> & {state: any}>} */
    state(tick?: number): Promise<Answer<"getState"> & {
        state: any;
    }>;
    /** @returns {Promise<Answer<'getMetrics'> & {metrics: any}>} from tick 0 to now */
    report(): Promise<Answer<"getMetrics"> & {
        metrics: any;
    }>;
    /** One metric, such as `players.0.remote_error_m.mean`. @param {string} path @returns {Promise<any>} */
    metric(path: string): Promise<any>;
    /** The trace as CSV. @param {TraceWish} [wish] @returns {Promise<string>} */
    trace(wish?: TraceWish): Promise<string>;
    /** The same as rows. @param {TraceWish} [wish] @returns {Promise<Row[]>} */
    table(wish?: TraceWish): Promise<Row[]>;
    /** The same as a Parquet file. @param {TraceWish} [wish] @returns {Promise<Uint8Array>} */
    parquet(wish?: TraceWish): Promise<Uint8Array>;
    /** The log, which `laglab replay` runs again. @returns {Promise<string>} */
    log(): Promise<string>;
    /** A separate session from the log up to now. @returns {Promise<Session>} */
    fork(): Promise<Session>;
    /** Frames while they come: `for await (const frame of session.stream({ scene: 30 }))`. Channels and their rates in Hz are those of
     * api/asyncapi.yaml; none: the drawn ones at 30 Hz. `break` ends it. @param {Record<string, number>} [channels]
     * @returns {AsyncGenerator<Frame, void, void>} */
    stream(channels?: Record<string, number>): AsyncGenerator<Frame, void, void>;
    delete(): Promise<void>;
}
/** An experiment on a daemon. It goes on when this program ends, unless it is deleted. */
export class Experiment {
    /** @param {Daemon} daemon @param {string} id @param {string} [key] @param {Record<string, Settings>} [named] */
    constructor(daemon: Daemon, id: string, key?: string, named?: Record<string, Settings>);
    daemon: Daemon;
    id: string;
    key: string | undefined;
    named: Record<string, import("./specification.js").Settings>;
    /** Its specification, state, and how many runs are done. @returns {Promise<Answer<'getExperiment'>>} */
    info(): Promise<Answer<"getExperiment">>;
    /** @param {'pause' | 'resume' | 'cancel'} op @returns {Promise<Answer<'controlExperiment'>>} */
    control(op: "pause" | "resume" | "cancel"): Promise<Answer<"controlExperiment">>;
    /** Progress while it runs: `for await (const { done, runs } of experiment.progress())`.
     * @returns {AsyncGenerator<Progress, void, void>} */
    progress(): AsyncGenerator<Progress, void, void>;
    /** Returns when it is done. Throws where it has failed or was cancelled. @param {(message: Progress) => void} [progress]
     * @returns {Promise<Experiment>} */
    wait(progress?: (message: Progress) => void): Promise<Experiment>;
    /** The present rows; with `points` means and 95 % intervals. @param {{points?: boolean, compare?: string}} [wish]
     * @returns {Promise<Row[]>} */
    table({ points, compare }?: {
        points?: boolean;
        compare?: string;
    }): Promise<Row[]>;
    /** A standalone page with plots and tables. @returns {Promise<string>} */
    report(): Promise<string>;
    /** The whole experiment as one tar file, which `laglab verify` checks on any machine. All runs must be done.
     * @param {{container?: string}} [wish] digest of the image that made the rows, as sha256:... @returns {Promise<Uint8Array>} */
    archive(wish?: {
        container?: string;
    }): Promise<Uint8Array>;
    /** One run as a live session, paused at its start. @param {number} run @returns {Promise<Session>} */
    open(run: number): Promise<Session>;
    delete(): Promise<void>;
}
export type Scenario = import("./specification.js").Scenario;
export type Settings = import("./specification.js").Settings;
export type Wish = import("./specification.js").Wish;
export type Frame = import("./stream.js").Frame;
/**
 * The operations of the API by their names, as api/openapi.yaml has them.
 */
export type Operations = import("../../api.js").operations;
/**
 * The schemas of the same.
 */
export type Schemas = import("../../api.js").components["schemas"];
/**
 * The JSON that an operation answers with.
 */
export type Answer<Name extends keyof Operations> = Operations[Name] extends {
    responses: {
        200: {
            content: {
                "application/json": infer Body;
            };
        };
    };
} ? Body : Operations[Name] extends {
    responses: {
        201: {
            content: {
                "application/json": infer Body;
            };
        };
    };
} ? Body : Operations[Name] extends {
    responses: {
        202: {
            content: {
                "application/json": infer Body;
            };
        };
    };
} ? Body : never;
/**
 * A row of a table: columns by name.
 */
export type Row = Record<string, any>;
/**
 * A message of an experiment's stream.
 */
export type Progress = {
    type: string;
    state: string;
    runs: number;
    done: number;
    rate_per_s: number;
    left_s: number | null;
};
/**
 * Where a session is after a command.
 */
export type Position = Answer<"controlSession">;
/**
 * What of which ticks a trace has. `of`: `ticks`, a record such as `entities`, `events`, `packets` or `corrections`.
 */
export type TraceWish = {
    from_s?: number;
    to_s?: number;
    of?: string;
};
/**
 * Anything beyond a method and a path.
 */
export type RequestWish = {
    /**
     * sent as JSON
     */
    body?: unknown;
    key?: string | undefined;
    query?: Record<string, string | number | boolean | undefined> | undefined;
    accept?: string | undefined;
};
import { LaglabError } from './errors.js';
import { leaves } from './values.js';
import { specification } from './specification.js';
import { valueAt } from './values.js';
export { LaglabError, leaves, specification, valueAt };
