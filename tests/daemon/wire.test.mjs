// Bytes on the wire: NULs in JSON, frames that RFC 6455 forbids, heads and bodies that come slowly. Ambiguous requests are in
// smuggling.mjs.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import net from 'node:net';
import { client, HANG_MS, raw } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';
import { cpu_s } from '../lib/hostile.mjs';

let daemon, c;
before(async () => {
  daemon = await startDaemon({ args: ['--head-timeout-s', '1', '--body-timeout-s', '1', '--idle-timeout-s', '5'] });
  c = client(daemon.url);
});
after(async () => {
  c.close();
  await daemon.stop();
});

const GOOD = 'GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n';
const post = (/** @type {string} */ headers, /** @type {string} */ body) =>
  `POST /api/v1/sessions HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n${headers}\r\n${body}`;
test('a list in several lines is one list', async () => {
  const { id } = await c.make({ paused: true }),
    { etag } = (await c.get('/index.html')).headers;
  const get = async (/** @type {string} */ place, /** @type {string[]} */ ...lines) => {
    const head = ['Host: localhost', 'Connection: close', ...lines].join('\r\n');
    return (await raw(daemon.port, `GET ${place} HTTP/1.1\r\n${head}\r\n\r\n`)).text;
  };
  const trace = `/api/v1/sessions/${id}/trace`;
  assert.match(await get(trace, 'Accept: image/png'), /^HTTP\/1\.1 406 /);
  assert.match(
    await get(trace, 'Accept: image/png', 'Accept: application/json'),
    /^HTTP\/1\.1 200 [\s\S]*\r\nContent-Type: application\/json/,
  );
  assert.match(await get('/index.html', 'If-None-Match: "a"', `If-None-Match: ${etag} `, 'If-None-Match: "b"'), /^HTTP\/1\.1 304 /);
  assert.match(await get('/index.html', 'Accept-Encoding: br ', 'Accept-Encoding:', 'accept-encoding: gzip'), /\r\nContent-Encoding: gzip/);
});

test('a NUL in JSON is refused and not cut at', async () => {
  for (const body of [
    '{"scenario":"race\\u00gx, or what a lax reader takes for a NUL"}',
    '{"scenario":"race\\uD83"}',
    '{"scenario":"race\\\u0000"}',
    '{"scenario":"race\\u0000x"}',
    '{"scenario":"race","set":{"title":"a\\u0000"}}',
    '{"scenario":"race\u0000"}',
  ]) {
    const answer = await c.call('POST', '/api/v1/sessions', { body });
    assert.equal(answer.status, 400, body);
  }
  assert.equal(
    (await c.call('POST', '/api/v1/sessions', { body: '{"scenario":"race","set":{"title":"a\\\\u0000 backslash"}}' })).status,
    201,
  );
});

/** A frame as a client sends it; `mask` false: as it must not. */
function frame(first, payload = Buffer.alloc(0), mask = true) {
  const bytes = Buffer.from(payload),
    size = bytes.length;
  const head = size < 126 ? [first, size] : [first, 126, size >> 8, size & 255],
    key = [0x12, 0x9a, 0xfe, 0x33];
  if (!mask) return Buffer.concat([Buffer.from(head), bytes]);
  head[1] |= 0x80;
  return Buffer.concat([Buffer.from(head), Buffer.from(key), bytes.map((b, i) => b ^ key[i % 4])]);
}

/** Opens a stream by hand, after `before` on the same connection, sends `bytes` after the hello (`again`: without end) and `answer` after
 * the first pong, and returns what was seen until `until` takes it, the connection is ended or `ms` are over: the code of the close frame
 * (0: none), the payloads of texts, of pongs and of both in their order, whether the connection was ended, and whether in an orderly way.
 * @param {any} session @param {Buffer} bytes
 * @param {{before?: string, answer?: Buffer, again?: boolean, ms?: number, until?: (seen: any) => boolean}} [wish] */
function shout(session, bytes, { before: kept = '', answer = Buffer.alloc(0), again = false, ms = HANG_MS, until = () => false } = {}) {
  const upgrade =
    `GET /api/v1/sessions/${session.id}/stream HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n` +
    'Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: laglab.v2.json\r\n\r\n';
  return new Promise((resolve) => {
    let got = Buffer.alloc(0),
      open = false,
      said = false,
      ended = false;
    const seen = { code: 0, reason: '', pongs: [], texts: [], order: [], over: false, orderly: false, accept: '' };
    const socket = net.connect({ port: daemon.port, host: '127.0.0.1', allowHalfOpen: true }, () => socket.write(kept + upgrade));
    const end = (over = true) => {
      if (!ended) {
        ended = true;
        seen.over = over;
        clearTimeout(timer);
        socket.destroy();
        resolve(seen);
      }
    };
    const timer = setTimeout(() => end(false), ms);
    socket.on('error', () => end());
    socket.on('end', () => {
      seen.orderly = true;
      end();
    });
    socket.on('data', (/** @type {Buffer} */ part) => {
      got = Buffer.concat([got, part]);
      if (!open) {
        const text = got.toString('latin1'),
          at = text.indexOf('HTTP/1.1 101'),
          behind = text.indexOf('\r\n\r\n', at);
        if (at < 0 || behind < 0) return;
        seen.accept = /sec-websocket-accept: (\S+)/i.exec(text.slice(at))?.[1] ?? '';
        got = got.subarray(behind + 4);
        open = true;
      }
      while (got.length >= 2) {
        const short = got[1] & 127,
          at = short === 126 ? 4 : short === 127 ? 10 : 2;
        if (got.length < at) return;
        const size = short === 126 ? got.readUInt16BE(2) : short === 127 ? Number(got.readBigUInt64BE(2)) : short;
        if (got.length < at + size) return;
        const opcode = got[0] & 15,
          payload = got.subarray(at, at + size);
        got = got.subarray(at + size);
        if (!said) {
          said = true;
          const say = () => {
            while (socket.write(bytes) && again);
            if (again) socket.once('drain', say);
          };
          say();
        }
        if (opcode === 8) {
          seen.code = size >= 2 ? payload.readUInt16BE(0) : 1005;
          seen.reason = payload.subarray(2).toString();
        }
        if (opcode === 1 || opcode === 10) seen.order.push(payload.toString());
        if (opcode === 1) seen.texts.push(payload.toString());
        if (opcode === 10 && seen.pongs.push(payload.toString()) === 1) socket.write(answer);
        if (until(seen)) end(false);
      }
    });
  });
}

const SAY = Buffer.from('{"subscribe":{}}');
/** @type {[string, Buffer, number][]} */
const FRAMES = [
  ['a reserved bit', frame(0xc1, SAY), 1002],
  ['a reserved opcode', frame(0x83, SAY), 1002],
  ['a ping in pieces', frame(0x09, Buffer.from('x')), 1002],
  ['a piece of nothing', frame(0x80, SAY), 1002],
  ['a text in a text', Buffer.concat([frame(0x01, Buffer.from('{')), frame(0x81, SAY)]), 1002],
  ['text that is no UTF-8', frame(0x81, Buffer.from([0x22, 0xc0, 0xaf, 0x22])), 1007],
  ['a close with a code that is none', frame(0x88, Buffer.from([3, 237])), 1002],
  ['a binary message', frame(0x82, SAY), 1003],
  ['too much in one message', Buffer.concat([frame(0x01, Buffer.alloc(65000, ' ')), frame(0x80, Buffer.alloc(65000, ' '))]), 1009],
  ['300,000 pongs', Buffer.concat(Array(300000).fill(frame(0x8a, Buffer.from('x')))), 1008],
  ['100,000 empty pieces', Buffer.concat([frame(0x01), ...Array(100000).fill(frame(0x00))]), 1008],
];

for (const [name, bytes, code] of FRAMES) {
  test(`a viewer that sends ${name} is closed with ${code}, on a new connection and on a kept one`, async () => {
    for (const kept of ['', GOOD + GOOD]) {
      const session = await c.make({ paused: true });
      const seen = await shout(session, bytes, { before: kept });
      assert.equal(seen.accept, 's3pPLMBiTxaQ9kYGzzhZRbK+xOo=');
      assert.equal(seen.code, code, seen.reason);
      assert.ok(seen.orderly, 'the close frame is not overtaken by a reset');
    }
  });
}

test('a ping between two pieces of a text is answered before the text', async () => {
  const pieces = [frame(0x01, Buffer.from('{"subscribe":{},')), frame(0x89, Buffer.from('between')), frame(0x80, Buffer.from('"id":78}'))];
  const bytes = Buffer.concat(pieces);
  for (const kept of ['', GOOD]) {
    const of = (seen) => seen.order.filter((text) => text === 'between' || text.includes('"id":78'));
    const order = of(await shout(await c.make({ paused: true }), bytes, { before: kept, until: (seen) => of(seen).length === 2 }));
    assert.deepEqual([order.length, order[0]], [2, 'between'], order.join());
  }
});

const replied = (seen, id) => seen.texts.some((text) => text.includes(`"id":${id}`) && text.includes('reply'));
// What libwebsockets 4.1.6 does otherwise than RFC 6455 asks: docs/limits.md has the list.
/** Where nothing ends the connection: what is waited for.
 * @type {[string, Buffer, (seen: any) => void, {answer?: Buffer, until: (seen: any) => boolean}?][]} */
const LIMITS = [
  [
    'an unmasked text is taken',
    frame(0x81, Buffer.from('{"subscribe":{},"id":77}'), false),
    (seen) => assert.ok(replied(seen, 77), seen.texts.join()),
    { until: (seen) => replied(seen, 77) },
  ],
  [
    'an unmasked ping is answered',
    frame(0x89, Buffer.from('x'), false),
    (seen) => assert.deepEqual(seen.pongs, ['x']),
    { until: (seen) => seen.pongs.length > 0 },
  ],
  ['an unmasked close is answered', frame(0x88, Buffer.from([3, 232]), false), (seen) => assert.equal(seen.code, 1000)],
  [
    'a ping of 126 bytes ends the connection without a code',
    frame(0x89, Buffer.alloc(126, 'p')),
    (seen) => assert.deepEqual([seen.code, seen.over], [0, true]),
  ],
  [
    'of several pings in one segment the first is answered',
    Buffer.concat(['a', 'b', 'c'].map((text) => frame(0x89, Buffer.from(text)))),
    (seen) => assert.deepEqual(seen.pongs, ['a']),
    { answer: frame(0x81, Buffer.from('{"subscribe":{},"id":79}')), until: (seen) => replied(seen, 79) },
  ],
  [
    'a ping in one segment with a close is not answered',
    Buffer.concat([frame(0x89, Buffer.from('one')), frame(0x88, Buffer.from([3, 232]))]),
    (seen) => assert.deepEqual([seen.pongs, seen.code], [[], 1000]),
  ],
  [
    'a pong between two pieces of a text, of which the first ends in a character, is closed with 1007',
    Buffer.concat([frame(0x01, Buffer.from([0x22, 0xc3])), frame(0x8a, Buffer.from('x')), frame(0x80, Buffer.from([0xa4, 0x22]))]),
    (seen) => assert.equal(seen.code, 1007),
  ],
];

for (const [name, bytes, check, wish] of LIMITS) {
  test(`a limit of libwebsockets: ${name}, on a new connection and on a kept one`, async () => {
    for (const kept of ['', GOOD]) check(await shout(await c.make({ paused: true }), bytes, { before: kept, ...wish }));
  });
}

test('pings are answered, the close is echoed, and others are served while one floods', async () => {
  const session = await c.make({ paused: true });
  const seen = await shout(session, frame(0x89, Buffer.from('one')), { answer: frame(0x88, Buffer.from([0x0f, 0xa0])) });
  assert.deepEqual([seen.pongs, seen.code, seen.orderly], [['one'], 4000, true]);
  const stream = await c.stream(session);
  const floods = [...Array(8)].map(() => shout(session, Buffer.concat(Array(200000).fill(frame(0x8a, Buffer.from('x'))))));
  stream.socket.ping();
  await new Promise((resolve) => stream.socket.once('pong', resolve));
  for (const flood of await Promise.all(floods)) assert.equal(flood.code, 1008);
  assert.equal(stream.closed, undefined);
  await stream.close();
});

test('pings are not counted, but read at a pace that costs little', async () => {
  const session = await c.make({ paused: true });
  const from = cpu_s(daemon.pid);
  const floods = [...Array(4)].map(() => shout(session, Buffer.concat(Array(3000).fill(frame(0x89))), { again: true, ms: 3000 }));
  for (const seen of await Promise.all(floods)) {
    assert.deepEqual([seen.code, seen.over], [0, false]);
    assert.ok(seen.pongs.length > 10, `${seen.pongs.length} pongs`);
  }
  const used = cpu_s(daemon.pid) - from;
  assert.ok(used < 0.3, `${used} s of processor time in 3 s`);
});

/** Sends `begin`, then a byte of `rest` each 100 ms, which would take longer than it is waited for. */
function dribble(begin, rest) {
  return new Promise((resolve) => {
    let text = '',
      at = 0;
    const socket = net.connect(daemon.port, '127.0.0.1', () => socket.write(begin));
    const timer = setInterval(() => (at < rest.length ? socket.write(rest[at++]) : at), 100);
    const end = (closed) => {
      clearInterval(timer);
      clearTimeout(limit);
      socket.destroy();
      resolve({ text, closed });
    };
    const limit = setTimeout(() => end(false), HANG_MS);
    socket.on('data', (part) => {
      text += part;
    });
    socket.on('error', () => end(true));
    socket.on('close', () => end(true));
  });
}

test('heads and bodies that come a byte now and then are cut: the first of a connection, and each later one', async () => {
  const head = 'GET /healthz HTTP/1.1\r\nHost: localhost\r\nX-Long: ',
    slow = 'x'.repeat(1000);
  const body = post(`Content-Length: 900\r\n`, '{');
  const found = await Promise.all([
    dribble('', head + slow),
    dribble(head, slow),
    dribble(GOOD + head, slow),
    dribble(body, slow),
    dribble(GOOD + GOOD + body, slow),
    dribble(post('Transfer-Encoding: chunked\r\n', '1\r\n{\r\n3e8\r\n'), slow),
    dribble(GOOD, 'G'),
  ]);
  for (const [i, { closed }] of found.entries()) assert.ok(closed, `${i}: not cut`);
  assert.match(found[1].text, /^HTTP\/1\.1 408 /);
  assert.equal((await c.get('/healthz')).status, 200);
});
