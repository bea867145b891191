// Requests that two readers could read in two ways are refused: the first of a connection, and each later one.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { client, raw, waitFor } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';

let daemon, c;
before(async () => {
  daemon = await startDaemon();
  c = client(daemon.url);
});
after(async () => {
  c.close();
  await daemon.stop();
});

const GOOD = 'GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n';
const BODY = '{"scenario":"race","paused":true}';
const post = (/** @type {string} */ headers, body = BODY) => `POST /api/v1/sessions HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n${headers}\r\n${body}`;
const many = (/** @type {number} */ n) => [...Array(n)].map((_, i) => `a${i}=1`).join('&');
const SESSIONS = /^laglab_sessions (\d+)$/m;
/** @type {[string, string, number][]} */
const BAD = [
  ['two Content-Lengths', post(`Content-Length: ${BODY.length}\r\nContent-Length: ${BODY.length + 7}\r\n`), 400],
  ['the same Content-Length twice', post(`Content-Length: ${BODY.length}\r\nContent-Length: ${BODY.length}\r\n`), 400],
  ['Content-Length and chunks', post(`Content-Length: 5\r\nTransfer-Encoding: chunked\r\n`, '0\r\n\r\n'), 400],
  ['an unknown Transfer-Encoding', post('Transfer-Encoding: gzip\r\n', ''), 501],
  ['two Transfer-Encodings', post('Transfer-Encoding: chunked\r\nTransfer-Encoding: identity\r\n', '0\r\n\r\n'), 400],
  ['a list of Transfer-Encodings', post('Transfer-Encoding: gzip, chunked\r\n', '0\r\n\r\n'), 501],
  ['two Origins', post(`Origin: http://localhost\r\nOrigin: http://elsewhere.example\r\nContent-Length: ${BODY.length}\r\n`), 400],
  ['two Hosts', 'GET /healthz HTTP/1.1\r\nHost: localhost\r\nHost: elsewhere.example\r\n\r\n', 400],
  ['a NUL in the path', 'GET /index.html%00.js HTTP/1.1\r\nHost: localhost\r\n\r\n', 400],
  ['a NUL in the query', 'GET /api/v1/schema?kind=fluid%00x HTTP/1.1\r\nHost: localhost\r\n\r\n', 400],
  ['65 arguments', `GET /healthz?${many(65)} HTTP/1.1\r\nHost: localhost\r\n\r\n`, 400],
  ['700 arguments', `GET /healthz?${many(700)} HTTP/1.1\r\nHost: localhost\r\n\r\n`, 400],
];

for (const [name, request, status] of BAD) {
  test(`${name}: as the first request, and on a kept connection`, async () => {
    const sessions = async () => Number(SESSIONS.exec((await c.get('/metrics')).text)[1]), begun = await sessions();
    for (const [before, answers] of /** @type {[string, number[]][]} */ ([['', []], [GOOD, [200]], [GOOD + GOOD, [200, 200]]])) {
      // What follows is hidden in what a lax reader would take for the next request.
      const { text, closed } = await raw(daemon.port, before + request + GOOD, 2500);
      const seen = [...text.matchAll(/HTTP\/1\.1 (\d+) /g)].map((m) => Number(m[1]));
      assert.deepEqual(seen, [...answers, status], text.slice(0, 600));
      assert.ok(closed, 'the connection ends');
      assert.match(text, /application\/problem\+json/);
    }
    assert.equal(await sessions(), begun, 'nothing was made');
  });
}

test('what is allowed still is: chunks, 60 arguments that are known to nobody aside', async () => {
  const chunked = await raw(daemon.port, post('Transfer-Encoding: chunked\r\nConnection: close\r\n', `${BODY.length.toString(16)}\r\n${BODY}\r\n0\r\n\r\n`));
  assert.match(chunked.text, /^HTTP\/1\.1 201 /);
});

test('a NUL in JSON is refused and not cut at', async () => {
  for (const body of ['{"scenario":"race\\u00gx, or what a lax reader takes for a NUL"}', '{"scenario":"race\\uD83"}', '{"scenario":"race\\\u0000"}', '{"scenario":"race\\u0000x"}', '{"scenario":"race","set":{"title":"a\\u0000"}}', '{"scenario":"race\u0000"}']) {
    const answer = await c.call('POST', '/api/v1/sessions', { body });
    assert.equal(answer.status, 400, body);
  }
  assert.equal((await c.call('POST', '/api/v1/sessions', { body: '{"scenario":"race","set":{"title":"a\\\\u0000 backslash"}}' })).status, 201);
});

test('a flood of pongs that nobody asked for is counted like messages', async () => {
  const session = await c.make({ paused: true });
  const stream = await c.stream(session);
  for (let i = 0; i < 2000; i++) stream.socket.pong('x'); // the library tells nothing of empty ones
  await waitFor(() => stream.closed, 'the end of a flood');
  assert.equal(stream.closed.code, 1008);
});
