// A viewer on a line slower than the events of its session is not closed, and sees the present.
import assert from 'node:assert/strict';
import net from 'node:net';
import { test } from 'node:test';
import { client, pause } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';

const BYTES_PER_S = 2500, // the events of a race alone are 3,700
  // By bytes that the line has carried, not by time: a busy machine reads later, and no older frames.
  BYTES = 14 * BYTES_PER_S,
  SETTLED = 6 * BYTES_PER_S, // from then on its frames are of the present: the hello takes two seconds
  AGE = 2 * BYTES_PER_S, // that came between a tick and its frame; they were of up to 12 s
  FRAMES = 14;
const SUBSCRIPTION = '{"subscribe":{"session":60,"scene":60,"lanes":60,"clock":60}}';

const varint = (bytes, at) => {
  let value = 0;
  for (let factor = 1; ; factor *= 128) {
    const byte = bytes[at++];
    value += (byte & 127) * factor;
    if (byte < 128) return { value, at };
  }
};

/** The numbers at the head of a binary frame. @param {Buffer} frame */
function headOf(frame) {
  const seq = varint(frame, 2);
  return { seq: seq.value, tick: varint(frame, seq.at).value };
}

/** A text message of a client. @param {string} text */
const masked = (text) => Buffer.concat([Buffer.from([0x81, 0x80 | text.length, 0, 0, 0, 0]), Buffer.from(text)]);

/** The first whole message of the bytes: opcode, payload and rest. @param {Buffer} bytes */
function message(bytes) {
  if (bytes.length < 4) return null;
  const short = bytes[1] & 127,
    head = short === 126 ? 4 : 2,
    end = head + (short === 126 ? bytes.readUInt16BE(2) : short);
  assert.ok(short < 127, 'no message of 64 KiB');
  return bytes.length < end ? null : { opcode: bytes[0] & 15, payload: bytes.subarray(head, end), rest: bytes.subarray(end) };
}

test('a viewer on a line slower than the events is not closed, and its frames are of the present', { timeout: 600000 }, async (t) => {
  const daemon = await startDaemon();
  t.after(() => daemon.stop());
  const c = client(daemon.url);
  t.after(() => c.close());
  const session = await c.make({ set: { duration_s: 600 } }),
    newest = await c.stream(session, 'bin', { ack: true }); // the session's tick, without a question to it
  const socket = net.connect(daemon.port, '127.0.0.1').pause();
  t.after(() => socket.destroy());
  let closed = '';
  socket.on('error', (error) => (closed = error.message));
  socket.on('close', () => (closed ||= 'closed'));
  socket.write(
    `GET /api/v1/sessions/${session.id}/stream HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n` +
      'Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Protocol: laglab.v2.bin\r\n\r\n',
  );
  let bytes = /** @type {Buffer} */ (Buffer.alloc(0)),
    upgraded = false,
    frames = 0,
    passed = 0,
    oldest = 0;
  /** Ticks, and the bytes that had come when the session was there. @type {{tick: number, at: number}[]} */
  const ticks = [];
  const take = () => {
    if (!upgraded) {
      const end = bytes.indexOf('\r\n\r\n');
      if (end < 0) return;
      upgraded = true;
      bytes = bytes.subarray(end + 4);
      socket.write(masked(SUBSCRIPTION));
    }
    for (let m = message(bytes); m; m = message(bytes)) {
      bytes = m.rest;
      assert.notEqual(m.opcode, 8, `closed: ${m.payload.subarray(2)}`);
      if (m.opcode !== 2) continue;
      const { seq, tick } = headOf(m.payload);
      socket.write(masked(`{"ack":${seq}}`));
      frames++;
      if (passed > SETTLED) oldest = Math.max(oldest, passed - (ticks.find((seen) => seen.tick >= tick)?.at ?? passed));
    }
  };
  const begun = performance.now();
  for (let read = 0, now = 0; passed < BYTES; ) {
    await pause(20);
    now = (performance.now() - begun) / 1000;
    const chunk = socket.read(Math.min(socket.readableLength, Math.floor(now * BYTES_PER_S - read)));
    read = Math.max(read + (chunk?.length ?? 0), (now - 0.1) * BYTES_PER_S); // nothing is saved up
    passed += chunk?.length ?? 0;
    if (chunk) bytes = Buffer.concat([bytes, chunk]);
    if (newest.frames.length > 0) ticks.push({ tick: headOf(newest.frames.at(-1)).tick, at: passed });
    take();
    assert.equal(closed, '', `after ${now} s and ${frames} frames`);
  }
  t.diagnostic(`${frames} frames, the oldest came ${oldest} bytes after its tick`);
  assert.ok(frames > FRAMES, `${frames} frames`);
  assert.ok(oldest < AGE, `a frame came ${oldest} bytes after its tick`);
});
