// Requests that two parsers could read differently, from smuggling.mjs: one answer each, and what is sent behind it is never read as
// something else.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { HANG_MS, client, headed, raw } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';
import { BY_LIBRARY, FOLLOWER, GOES_ON, KEPT_BY_LIBRARY, REQUESTS, TWICE } from './smuggling.mjs';

let daemon, c;
before(async () => {
  daemon = await startDaemon({
    args: ['--head-timeout-s', '1', '--body-timeout-s', '1', '--idle-timeout-s', '1', '--max-new-sessions-per-min', '1000'],
  });
  c = client(daemon.url);
});
after(async () => {
  c.close();
  await daemon.stop();
});

const LAST = FOLLOWER.replace('\r\n\r\n', '\r\nConnection: close\r\n\r\n');
const statuses = (/** @type {string} */ text) => [...text.matchAll(/HTTP\/1\.1 (?!100 )(\d+) /g)].map((m) => Number(m[1]));

for (const [name, bytes, status, how] of REQUESTS) {
  test(`${name}: ${status || 'closed'}${how ? `, ${how}` : ''}`, async () => {
    for (const [before, answers] of /** @type {[string, number[]][]} */ ([
      ['', []],
      [FOLLOWER + FOLLOWER, [200, 200]],
    ])) {
      const { text, closed } = await raw(daemon.port, before + bytes + LAST, 6000);
      const wanted = [...answers, ...(status ? [status] : []), ...(how === GOES_ON ? [200] : how === TWICE && before ? [status] : [])];
      assert.deepEqual(statuses(text), wanted, text.slice(-600));
      assert.ok(closed, 'the connection ends');
      assert.doesNotMatch(text, /"creation"/, 'the hidden request was read');
      const library = how === BY_LIBRARY || (before && (how === KEPT_BY_LIBRARY || how === TWICE));
      if (status >= 400) assert.equal(/application\/problem\+json/.test(text), !library, text.slice(-600));
    }
  });
}

test('requests with faults make no sessions, and are no failures of the daemon', async () => {
  const sessions = Number(/^laglab_sessions (\d+)$/m.exec((await c.get('/metrics')).text)?.[1]);
  assert.equal(sessions, 2 * REQUESTS.filter(([, , status]) => status === 201).length);
  assert.doesNotMatch(daemon.errors(), /request failed/);
});

test('heads that come byte by byte are read alike, the first and later ones', async () => {
  const fields = [...Array(60)].map((_, i) => `X-${i}:${' '.repeat(i % 3)}${'v'.repeat(230)}\r\n`);
  const long = `GET /none?a=1&b=%20c HTTP/1.1\r\nHost: localhost\r\nCookie: a=1; b="2"; c\r\n${fields.join('')}\r\n`;
  const pieces = async (/** @type {number} */ size) => {
    const { default: net } = await import('node:net');
    const socket = net.connect({ port: daemon.port, noDelay: true });
    let text = '';
    socket.on('data', (part) => {
      text += part;
    });
    const ended = new Promise((resolve) => socket.on('close', resolve));
    for (const bytes of [FOLLOWER, long, long, LAST])
      for (let at = 0; at < bytes.length; at += size) await new Promise((resolve) => socket.write(bytes.slice(at, at + size), resolve));
    await ended;
    return statuses(text);
  };
  for (const size of [1, 7, 400, 100000]) assert.deepEqual(await pieces(size), [200, 404, 404, 200], `${size} bytes at a time`);
});

test('a body with a coding is refused, and one with identity is read', async () => {
  const { status, json, headers } = await c.call('POST', '/api/v1/sessions', {
    body: Buffer.from([31, 139, 8, 0]),
    headers: { 'content-encoding': 'gzip' },
  });
  assert.equal(status, 415);
  assert.match(json.detail, /Content-Encoding.*gzip/);
  assert.equal(headers['accept-encoding'], 'identity');
  const body = { scenario: 'race', paused: true };
  assert.equal((await c.call('POST', '/api/v1/sessions', { body, headers: { 'content-encoding': 'identity' } })).status, 201);
});

test('Expect: the client is asked to continue, except where its body is refused', async () => {
  const head = (/** @type {string} */ type) =>
    `POST /api/v1/sessions HTTP/1.1\r\nHost: localhost\r\nContent-Type: ${type}\r\nExpect: 100-continue\r\nContent-Length: 33\r\n\r\n`;
  assert.match((await raw(daemon.port, head('application/json'), HANG_MS, headed)).text, /^HTTP\/1\.1 100 Continue\r\n\r\n$/);
  assert.match((await raw(daemon.port, head('text/plain'), HANG_MS, headed)).text, /^HTTP\/1\.1 415 /);
});

test('space behind a key is no part of it', async () => {
  const session = await c.make({ paused: true });
  const control = async (/** @type {string} */ value) =>
    (await c.call('POST', `/api/v1/sessions/${session.id}/control`, { body: { op: 'pause' }, headers: { authorization: value } })).status;
  for (const value of [`Bearer ${session.owner_key}`, `Bearer ${session.owner_key} `, `bearer   ${session.owner_key} \t `])
    assert.equal(await control(value), 200, value);
  assert.equal(await control(`Bearer ${session.owner_key} x`), 403);
});
