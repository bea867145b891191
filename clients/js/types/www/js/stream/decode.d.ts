/** The value of an integer. @param {Field} field @param {number} n @returns {number} */
export function valueOf(field: Field, n: number): number;
/** A section's body. @param {Layout} layout @param {Section | null} base the section that it is a delta of; null: it is whole
 * @param {Uint8Array} bytes
 * @returns {Section} */
export function readSection(layout: Layout, base: Section | null, bytes: Uint8Array): Section;
export const PLAYING: 2;
export const ENDED: 4;
export const BEHIND: 8;
export const FAILED: 16;
export const JUMP: 32;
/** The stream must be opened again: the bytes are none that this decoder understands. */
export class StreamError extends Error {
}
/** The last rows of a record: integers, and objects on request. */
export class Section {
    /** @param {Layout} layout @param {number} count */
    constructor(layout: Layout, count: number);
    layout: import("./records.js").Layout;
    count: number;
    values: Float64Array<ArrayBuffer>;
    first: number;
    lost: number;
    /** Of a grid: of each row. @type {Uint8Array[]} */
    planes: Uint8Array[];
    /** @type {any[] | null} */
    objects: any[] | null;
    /** @type {Map<string, Float64Array>} */
    columns: Map<string, Float64Array>;
    /** By field, by its value. @type {Map<string, Map<number, any[]>>} */
    groups: Map<string, Map<number, any[]>>;
    /** The rows in which a field has a value. @param {string} field @param {number} value @returns {any[]} */
    where(field: string, value: number): any[];
    /** Values of a field, row by row: for records of many rows. @param {string} name @returns {Float64Array} */
    column(name: string): Float64Array;
    /** An object of each row. @returns {any[]} */
    rows(): any[];
    /** @param {number} i */
    row(i: number): any;
}
/** One frame: its head, and the rows of each record as of then. Those of a log are the frame's own. */
export class FrameBase {
    /** @param {number} flags @param {number} seq @param {number} tick @param {number} tickHz @param {Map<string, Section>} sections */
    constructor(flags: number, seq: number, tick: number, tickHz: number, sections: Map<string, Section>);
    flags: number;
    seq: number;
    tick: number;
    time_s: number;
    tickHz: number;
    sections: Map<string, Section>;
    /** @param {string} name @returns {any[]} */
    rows(name: string): any[];
    /** Rows of logs that were forgotten before they could be sent. */
    get lost(): number;
    /** Without what it can do, for inspection only. @returns {any} */
    plain(): any;
    /** The rows of a record in which a field has a value. @param {string} name @param {string} field @param {number} value
     * @returns {any[]} */
    where(name: string, field: string, value: number): any[];
}
/** @typedef {FrameBase & import('./rows.js').Records} Frame */
/** @typedef {{id: number, whole: boolean, bytes: Uint8Array}} Part */
/** The reading end of one stream: it keeps what came last of each record. */
export class Decoder {
    /** @param {readonly Layout[]} records @param {number} tickHz of the session, from the hello
     * @param {(bytes: Uint8Array) => Promise<Uint8Array>} [unpack] raw deflate, where there is another way than a browser's */
    constructor(records: readonly Layout[], tickHz: number, unpack?: (bytes: Uint8Array) => Promise<Uint8Array>);
    unpack: (bytes: Uint8Array) => Promise<Uint8Array>;
    layouts: Map<number, import("./records.js").Layout>;
    tickHz: number;
    /** @type {Map<string, Section>} */
    sections: Map<string, Section>;
    /** Messages are decoded one after the other, also where one has to be inflated. @type {Promise<unknown> | null} */
    busy: Promise<unknown> | null;
    /** What follows is read by tables that are still to come. @param {Promise<readonly Layout[]>} records */
    learn(records: Promise<readonly Layout[]>): void;
    /** Gives the frame to `take`, at once where nothing is to be inflated. `fail` gets a StreamError.
     * @param {ArrayBuffer} bytes @param {(frame: Frame) => void} take @param {(error: unknown) => void} fail */
    decode(bytes: ArrayBuffer, take: (frame: Frame) => void, fail: (error: unknown) => void): void;
    /** @param {Uint8Array} message */
    split(message: Uint8Array): (Part & {
        deflated: boolean;
    })[];
    /** @param {Uint8Array} message @param {Part[]} parts @returns {Frame} */
    apply(message: Uint8Array, parts: Part[]): Frame;
}
export type Layout = import("./records.js").Layout;
export type Field = import("./records.js").Field;
export type Frame = FrameBase & import("./rows.js").Records;
export type Part = {
    id: number;
    whole: boolean;
    bytes: Uint8Array;
};
