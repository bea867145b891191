// A viewer of a paused session, on a connection without data: a ping after 20 s; who does not answer is closed after 30 s.
import assert from 'node:assert/strict';
import net from 'node:net';
import { test } from 'node:test';
import { client, pause } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';

test('who answers pings stays, who does not is closed', { timeout: 600000 }, async (t) => {
  const daemon = await startDaemon(),
    c = client(daemon.url);
  t.after(() => daemon.stop());
  t.after(() => c.close());
  const session = await c.make({ paused: true }),
    there = await c.stream(session); // answers by itself
  let pings = 0;
  there.socket.on('ping', () => pings++);
  const begun = performance.now(),
    mute = net.connect(daemon.port, '127.0.0.1').resume();
  mute.on('error', () => undefined);
  mute.write(
    `GET /api/v1/sessions/${session.id}/stream HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n` +
      'Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Protocol: laglab.v2.json\r\n\r\n',
  );
  await new Promise((resolve) => mute.once('close', resolve));
  const after_s = (performance.now() - begun) / 1000;
  assert.ok(after_s > 29, `${after_s} s`);
  await pause(2000); /* it was there first: it would be closed by now */
  assert.equal(there.closed, undefined);
  assert.ok(pings >= 1, `${pings} pings`);
  await there.close();
});
