// Large answers: compressed, in parts, not made again, not made at all.
import assert from 'node:assert/strict';
import http from 'node:http';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { gunzipSync } from 'node:zlib';
import { client, HANG_MS, pause, raw, waitFor } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';
import { cpu_s } from '../lib/hostile.mjs';

let daemon, c, done, running;
const data = mkdtempSync(path.join(tmpdir(), 'laglab-answers-'));
const X = '/api/v1/experiments';
const plan = (repeats, duration_s) => ({
  scenario: 'race',
  set: { duration_s, warmup_s: 0 },
  axes: [{ path: 'players.0.lag_ms', values: [0, 130] }],
  repeats,
  metrics: ['players.0.own_lead_m.mean'],
});

/** The answer with its bytes as they came. @returns {Promise<{status: number, headers: http.IncomingHttpHeaders, bytes: Buffer}>} */
const fetchRaw = (path, headers = {}, method = 'GET') =>
  new Promise((resolve, reject) => {
    http
      .request(new URL(path, daemon.url), { method, headers }, (answer) => {
        const parts = [];
        answer.on('data', (part) => parts.push(part));
        answer.on('end', () => resolve({ status: answer.statusCode, headers: answer.headers, bytes: Buffer.concat(parts) }));
      })
      .on('error', reject)
      .end();
  });

before(async () => {
  daemon = await startDaemon({ data });
  c = client(daemon.url);
  done = (await c.call('POST', X, { body: plan(60, 1) })).json;
  await waitFor(async () => (await c.get(`${X}/${done.id}`)).json.state === 'done', 'the experiment', 60000);
  running = (await c.call('POST', X, { body: plan(40000, 20) })).json;
  await waitFor(async () => (await c.get(`${X}/${running.id}`)).json.done > 2, 'some rows', 60000);
  await order('pause');
});
after(async () => {
  c.close();
  await daemon.stop();
  rmSync(data, { recursive: true, force: true });
});

/** To the long experiment, which computes only where a test needs that. @param {'pause' | 'resume'} op */
async function order(op) {
  const answer = await c.call('POST', `${X}/${running.id}/control`, { key: running.owner_key, body: { op } });
  assert.equal(answer.status, 200, answer.text);
}

const formats = ['csv', 'ndjson', 'json', 'sqlite'];
/** @returns {Record<string, string>} */
const places = () =>
  Object.fromEntries([
    ...formats.map((format) => [format, `${X}/${done.id}/results?format=${format}`]),
    ['points', `${X}/${done.id}/results?points=true`],
    ['report', `${X}/${done.id}/report`],
    ['trace', `${X}/${done.id}/runs/3/trace`],
  ]);

test('compressed answers are the same answers, and smaller', async () => {
  for (const [name, path] of Object.entries(places())) {
    const plain = await fetchRaw(path),
      small = await fetchRaw(path, { 'accept-encoding': 'br;q=1, gzip;q=0.5' });
    assert.equal(plain.headers['content-encoding'], undefined);
    assert.match(plain.headers.vary, /Accept-Encoding/);
    if (name === 'sqlite') {
      assert.equal(small.headers['content-encoding'], undefined, name);
      assert.deepEqual(small.bytes, plain.bytes, name);
      continue;
    }
    assert.equal(small.headers['content-encoding'], 'gzip', name);
    assert.ok(small.bytes.length < 0.8 * plain.bytes.length, `${name}: ${small.bytes.length} of ${plain.bytes.length}`);
    assert.ok(gunzipSync(small.bytes).equals(plain.bytes), name);
    assert.notEqual(small.headers.etag, plain.headers.etag);
  }
  const path = places().csv;
  for (const [wish, want] of [
    ['gzip', true],
    ['*', true],
    ['identity', false],
    ['gzip;q=0', false],
    ['gzip;q=0, *', false],
    ['*;q=0', false],
    ['gzippo', false],
    ['', false],
  ])
    assert.equal((await fetchRaw(path, { 'accept-encoding': wish })).headers['content-encoding'] === 'gzip', want, String(wish));
});

test('so are those of sessions and of the library', async () => {
  const session = await c.make({ paused: true });
  await c.control(session, { op: 'seek', time_s: 5 });
  for (const part of ['metrics', 'trace']) {
    const path = `/api/v1/sessions/${session.id}/${part}`;
    const plain = await fetchRaw(path),
      small = await fetchRaw(path, { 'accept-encoding': 'gzip' });
    assert.equal(small.headers['content-encoding'], 'gzip', part);
    assert.ok(gunzipSync(small.bytes).equals(plain.bytes), part);
  }
  assert.equal((await fetchRaw('/api/v1/scenarios', { 'accept-encoding': 'gzip' })).headers['content-encoding'], 'gzip');
  const made = await c.call('POST', '/api/v1/sessions', {
    body: { scenario: 'race', paused: true },
    headers: { 'accept-encoding': 'gzip' },
  });
  assert.equal(made.headers['content-encoding'], undefined, 'an answer with keys is not');
});

test('what a client has is not made again; when there is more, it is', async () => {
  for (const [name, path] of Object.entries(places())) {
    const first = await fetchRaw(path),
      again = await fetchRaw(path);
    assert.match(first.headers.etag, /^"[0-9a-f]{16}"$/, name);
    assert.equal(again.headers.etag, first.headers.etag);
    assert.ok(again.bytes.equals(first.bytes), `${name}: the same tag, the same bytes`);
    for (const tag of [first.headers.etag, `W/${first.headers.etag}`, `"other", ${first.headers.etag}`, '*']) {
      const none = await fetchRaw(path, { 'if-none-match': tag });
      assert.deepEqual([none.status, none.bytes.length, none.headers.etag], [304, 0, first.headers.etag], `${name} ${tag}`);
      assert.equal(none.headers['content-length'], undefined, `${name}: RFC 9110 8.6, and it is not known`);
    }
    assert.equal((await fetchRaw(path, { 'if-none-match': '"other"' })).status, 200);
  }
  const tags = new Set(Object.values(places()).map(async (path) => (await fetchRaw(path)).headers.etag));
  assert.equal(new Set(await Promise.all(tags)).size, Object.keys(places()).length, 'each has its own');
  const path = `${X}/${running.id}/results`,
    early = await fetchRaw(path);
  assert.match(early.headers.etag, /^W\/"/);
  assert.equal((await fetchRaw(path, { range: 'bytes=0-9' })).status, 200, 'parts of what still grows do not fit together');
  const { done: before } = (await c.get(`${X}/${running.id}`)).json;
  await order('resume');
  await waitFor(async () => (await c.get(`${X}/${running.id}`)).json.done > before + 2, 'more rows', 60000);
  await order('pause');
  const late = await fetchRaw(path, { 'if-none-match': early.headers.etag });
  assert.equal(late.status, 200);
  assert.ok(late.bytes.length > early.bytes.length);
});

test('parts of results put together are the whole', async () => {
  for (const path of [places().csv, places().sqlite, places().trace]) {
    const whole = await fetchRaw(path),
      size = whole.bytes.length,
      parts = [];
    for (let from = 0; from < size; from += 1777) {
      const part = await fetchRaw(path, {
        range: `bytes=${from}-${from + 1776}`,
        'if-range': whole.headers.etag,
        'accept-encoding': 'gzip',
      });
      assert.equal(part.status, 206);
      assert.equal(part.headers['content-range'], `bytes ${from}-${Math.min(from + 1776, size - 1)}/${size}`);
      parts.push(part.bytes);
    }
    assert.ok(Buffer.concat(parts).equals(whole.bytes));
    const ask = async (range, more = {}) => {
      const { status, bytes, headers } = await fetchRaw(path, { range, ...more });
      return [status, status === 416 ? headers['content-range'] : bytes.length];
    };
    assert.deepEqual(await ask('bytes=-100'), [206, 100]);
    assert.deepEqual(await ask(`bytes=-${size + 5}`), [206, size]);
    assert.deepEqual(await ask(`bytes=${size - 3}-`), [206, 3]);
    assert.deepEqual(await ask(`bytes=${size}-`), [416, `bytes */${size}`]);
    assert.deepEqual(await ask('bytes=-0'), [416, `bytes */${size}`]);
    for (const odd of ['bytes=5-2', 'bytes=0-1,4-5', 'lines=0-1', 'bytes=', 'bytes=a-b', 'bytes=1', `bytes=${'9'.repeat(30)}-`])
      assert.deepEqual(await ask(odd), [200, size], odd);
    assert.deepEqual(await ask('bytes=0-9', { 'if-range': '"other"' }), [200, size], 'it has changed: the whole');
  }
});

test('HEAD is cheap, and has the headers of GET', async () => {
  const long = (await c.call('POST', X, { body: plan(1, 3000) })).json;
  await waitFor(async () => (await c.get(`${X}/${long.id}`)).json.state === 'done', 'the experiment');
  const used = async () => {
    const from = cpu_s(daemon.pid);
    await pause(200);
    return cpu_s(daemon.pid) - from;
  };
  await waitFor(async () => (await used()) <= 0.02, 'the daemon to be idle');
  const from = cpu_s(daemon.pid);
  for (let i = 0; i < 20; i++) assert.equal((await fetchRaw(`${X}/${long.id}/runs/1/trace`, {}, 'HEAD')).status, 200);
  const took = cpu_s(daemon.pid) - from;
  assert.ok(took < 0.5, `20 HEADs of a trace of 3,000 s took ${took} s of processor time`);
  await c.call('DELETE', `${X}/${long.id}`, { key: long.owner_key });
  for (const path of Object.values(places())) {
    const get = await fetchRaw(path),
      head = await fetchRaw(path, {}, 'HEAD');
    for (const name of ['etag', 'content-type', 'vary', 'accept-ranges', 'cache-control'])
      assert.equal(head.headers[name], get.headers[name], `${path} ${name}`);
    assert.equal(head.bytes.length, 0);
    assert.equal((await fetchRaw(path, { 'if-none-match': get.headers.etag }, 'HEAD')).status, 304);
  }
  assert.equal((await fetchRaw(`${X}/${done.id}/results?points=maybe`, {}, 'HEAD')).status, 400);
  const ask = (method, path, more = '') => `${method} ${path} HTTP/1.1\r\nHost: localhost\r\n${more}\r\n`;
  for (const part of ['report', 'results']) {
    const asked = [ask('GET', '/healthz'), ask('HEAD', `${X}/${done.id}/${part}`), ask('GET', '/healthz', 'Connection: close\r\n')],
      { text, closed } = await raw(daemon.port, asked.join(''), HANG_MS);
    assert.ok(closed);
    const heads = text.split('HTTP/1.1 ').slice(1);
    assert.match(heads[1], /^200 OK\r\n[\s\S]*\r\n\r\n$/, 'nothing behind the head');
    assert.doesNotMatch(heads[1], /content-length/i);
    assert.ok(heads.length === 3 || (heads.length === 2 && /connection: close/i.test(heads[1])), text);
  }
});

test('the rate of an experiment is reported again after a restart', async () => {
  const rate = () =>
    waitFor(async () => {
      const { json } = await c.get(`${X}/${running.id}`);
      return json.rate_per_s > 0 && json;
    }, 'a rate');
  await order('resume');
  assert.ok((await rate()).left_s > 0);
  c.close();
  await daemon.stop();
  daemon = await startDaemon({ data });
  c = client(daemon.url);
  assert.ok((await rate()).left_s > 0);
});
