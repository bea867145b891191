// What a stream calls. Types alone; no page loads this.

/** polled: open, without a socket @typedef {'connecting' | 'open' | 'polled' | 'lost'} State */
/**
 * @typedef {object} Handlers
 * @property {(hello: any) => void} hello
 * @property {(frame: import('./decode.js').Frame) => void} frame
 * @property {(state: State, attempt: number) => void} state
 * @property {() => void} gone       the daemon does not know the session any more
 * @property {(divisor: number) => void} pace     by which all rates are divided, as this end is slow
 * @property {(detail: string) => void} refused  an input was refused
 */

export {};
