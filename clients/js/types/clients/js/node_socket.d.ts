/** What both directions of a browser's WebSocket have of it that the client uses. */
export class NodeSocket {
    /** @param {URL} url @param {string[]} protocols */
    constructor(url: URL, protocols: string[]);
    /** @type {(() => void) | null} */
    onopen: (() => void) | null;
    /** @type {((message: {data: string | ArrayBuffer}) => void) | null} */
    onmessage: ((message: {
        data: string | ArrayBuffer;
    }) => void) | null;
    /** @type {((event: {code: number, reason: string}) => void) | null} */
    onclose: ((event: {
        code: number;
        reason: string;
    }) => void) | null;
    binaryType: string;
    /** @type {import('node:net').Socket | null} */
    socket: import("node:net").Socket | null;
    ended: boolean;
    /** @type {Buffer} */
    bytes: Buffer;
    /** The message that is coming. @type {Buffer[]} */
    pieces: Buffer[];
    kind: number;
    /** @param {URL} url @param {string[]} protocols */
    shake(url: URL, protocols: string[]): void;
    /** @param {number} opcode @param {Buffer} payload */
    write(opcode: number, payload: Buffer): void;
    /** @param {string} text of less than 64 kB */
    send(text: string): void;
    close(): void;
    /** @param {number} code @param {string} reason */
    end(code: number, reason: string): void;
    /** @param {Buffer} part */
    take(part: Buffer): void;
    /** Reads a frame. @returns {boolean} whether it was there */
    frame(): boolean;
    /** @param {number} opcode @param {boolean} final @param {Buffer} payload */
    apply(opcode: number, final: boolean, payload: Buffer): void;
}
