/** @param {URL} url of http or https @param {string} protocol @returns {Promise<Line>} */
export function openLine(url: URL, protocol: string): Promise<Line>;
/** Frames while they come. Each is acknowledged when the next one is asked for, so that a slow program skips frames in place of falling
 * behind. Ends with the session.
 * @param {URL} url @param {Record<string, number>} channels @param {() => Promise<{records: any[]}>} schema the daemon's own tables
 * @returns {AsyncGenerator<Frame, void, void>} */
export function frames(url: URL, channels: Record<string, number>, schema: () => Promise<{
    records: any[];
}>): AsyncGenerator<Frame, void, void>;
/**
 * One frame: `tick`, `time_s`, `seq` and the rows of each record, such as `frame.entities`.
 */
export type Frame = import("../../www/js/stream/decode.js").Frame;
export type Closed = {
    code: number;
    reason: string;
};
/** Messages of a socket, to be asked for one after the other. */
declare class Line {
    /** @param {WebSocket} socket */
    constructor(socket: WebSocket);
    socket: WebSocket;
    /** @type {(string | ArrayBuffer)[]} */
    queue: (string | ArrayBuffer)[];
    /** @type {Closed | null} */
    closed: Closed | null;
    /** @type {(() => void) | null} */
    wake: (() => void) | null;
    /** Until there is a message, or the end. */
    something(): Promise<void>;
    /** @returns {Promise<string | ArrayBuffer | null>} null: the daemon has closed */
    next(): Promise<string | ArrayBuffer | null>;
    /** @param {unknown} message */
    send(message: unknown): void;
    close(): void;
}
export {};
