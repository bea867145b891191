// The frame that the peers send: laglab's header, then as many bytes as laglab's mean frame had in this run.
// What a server does per frame is what laglab's must at least do: stamp the sequence and the time.

/** @param {number} bytes */
export function makeFrame(bytes) {
  const frame = Buffer.alloc(Math.max(80, bytes), 7);
  frame.writeUInt16LE(1, 0);
  frame.writeUInt16LE(0, 2);
  return frame;
}

export function stamp(frame, seq) {
  frame.writeUInt32LE(seq, 4);
  frame.writeBigUInt64LE(process.hrtime.bigint(), 48);
}

/** Calls `tick` 60 times a second. A plain setInterval would round 16.67 ms down to 16: 62.5 Hz. */
export function pace(tick, hz = 60) {
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
  const [sessions, viewers, bytes] = process.argv.slice(2).map(Number);
  return { sessions, viewers, bytes };
}

/** The bench reads one line: where to connect. */
export const announce = (port, paths) => console.log(JSON.stringify({ port, paths }));
