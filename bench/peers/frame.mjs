// The frame that the peers send: laglab's header, then as many bytes as laglab's mean frame had in this run.
// What a server does per frame is what laglab's must at least do: stamp the sequence and the time.

const HEAD = 26,
  CLOCK = 60,
  FILLER = 127; /* ids of records; no table has the second */

/** A varint of a fixed length. @param {Buffer} frame @param {number} at @param {bigint} value @param {number} length */
function put(frame, at, value, length) {
  for (let i = 0; i < length; i++) frame[at + i] = Number((value >> BigInt(7 * i)) & 127n) | (i < length - 1 ? 128 : 0);
}

/** @param {number} bytes */
export function makeFrame(bytes) {
  const size = Math.max(HEAD, bytes),
    frame = Buffer.alloc(size, 7);
  frame.set([1, 2]);
  put(frame, 7, 0n, 1); /* tick */
  frame.set([CLOCK, 4 * 12 + 2, 1, 1, 0, 1], 8); /* whole: a row, changed, none skipped, its one field */
  frame[22] = FILLER;
  put(frame, 23, BigInt(4 * (size - HEAD)), 3);
  return frame;
}

export function stamp(frame, seq) {
  put(frame, 2, BigInt(seq), 5);
  put(frame, 14, (process.hrtime.bigint() / 1000n) * 2n, 8);
}

/** Calls `tick` `hz` times a second. A plain setInterval would round 16.67 ms down to 16: 62.5 Hz. */
export function pace(tick, hz) {
  const begin = performance.now();
  let n = 0;
  const next = () => {
    tick();
    const now = performance.now() - begin;
    n = Math.max(n + 1, Math.floor((now * hz) / 1000));
    setTimeout(next, Math.max(0, (n * 1000) / hz - (performance.now() - begin)));
  };
  next();
}

export function options() {
  const [sessions, viewers, bytes, hz = 60] = process.argv.slice(2).map(Number);
  return { sessions, viewers, bytes, hz };
}

/** The bench reads one line: where to connect. */
export const announce = (port, paths) => console.log(JSON.stringify({ port, paths }));
