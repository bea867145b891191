// Constant documents, which are what openapi.yaml says has a second address, and the page's files: one contract for all.
import assert from 'node:assert/strict';
import { cpSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import http from 'node:http';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { gunzipSync } from 'node:zlib';
import { HANG_MS, client, headed, raw } from '../lib/client.mjs';
import { readContract } from '../lib/contract.mjs';
import { BINARY, startDaemon } from '../lib/daemon.mjs';

const WWW = path.join(path.dirname(BINARY), 'www');
const FOREVER = 'max-age=31536000, immutable';
const GZIP = { 'accept-encoding': 'gzip' };

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {ReturnType<typeof client>} */ let c;
/** @type {Awaited<ReturnType<typeof readContract>>} */ let contract;
let digest = '';
const folder = mkdtempSync(path.join(tmpdir(), 'laglab-documents-'));
const agent = new http.Agent({ keepAlive: true });

/** @returns {Promise<{status: number, headers: http.IncomingHttpHeaders, bytes: Buffer}>} */
const ask = (/** @type {string} */ at, headers = {}, method = 'GET', url = daemon.url) =>
  new Promise((resolve, reject) => {
    http
      .request(new URL(at, url), { method, headers, agent }, (answer) => {
        /** @type {Buffer[]} */ const parts = [];
        answer.on('data', (part) => parts.push(part));
        answer.on('end', () => resolve({ status: answer.statusCode ?? 0, headers: answer.headers, bytes: Buffer.concat(parts) }));
      })
      .on('error', reject)
      .end();
  });

before(async () => {
  daemon = await startDaemon();
  c = client(daemon.url);
  contract = await readContract(c);
  digest = String((await ask('/api/v1/schema')).headers['content-location']).slice(1, 17);
});
after(async () => {
  c.close();
  agent.destroy();
  await daemon.stop();
  rmSync(folder, { recursive: true, force: true });
});

/** Paths of GET without names in them; constant: whether they should have a second address. */
const routes = (/** @type {boolean} */ constant) =>
  Object.keys(contract.api.paths).filter(
    (at) =>
      !at.includes('{') &&
      contract.api.paths[at].get &&
      constant === (contract.resolve(contract.api.paths[at].get.responses['200'])?.headers?.['Content-Location'] !== undefined),
  );

/** Each with all its variants. */
function documents() {
  const kinds = ['netgame', 'motion', 'rigid', 'fluid'];
  return [
    ...routes(true),
    '/api/v1/scenarios?brief=true',
    '/api/v1/schema?brief=true',
    ...kinds.flatMap((kind) => [`/api/v1/schema?kind=${kind}`, `/api/v1/schema?brief=true&kind=${kind}`]),
  ];
}

const files = () =>
  readdirSync(WWW, { recursive: true, withFileTypes: true })
    .filter((entry) => entry.isFile())
    .map((entry) => `/${path.relative(WWW, path.join(entry.parentPath ?? entry.path, entry.name))}`);

async function holds(/** @type {string} */ at) {
  const plain = await ask(at),
    small = await ask(at, GZIP),
    packed = small.headers['content-encoding'] === 'gzip';
  assert.equal(plain.status, 200, at);
  assert.match(String(plain.headers.etag), /^"[0-9a-f]{16}"$/, at);
  assert.equal(plain.headers['content-encoding'], undefined, at);
  assert.equal(plain.headers['cache-control'], 'no-cache', at);
  assert.ok(packed ? small.bytes.length < plain.bytes.length : small.bytes.equals(plain.bytes), at);
  if (packed) {
    assert.ok(gunzipSync(small.bytes).equals(plain.bytes), at);
    assert.equal(plain.headers.vary, 'Accept-Encoding', at);
    assert.equal(small.headers.etag, String(plain.headers.etag).replace(/"$/, '-gzip"'), at);
  }
  for (const [whole, wish] of /** @type {[typeof plain, Record<string, string>][]} */ ([
    [plain, {}],
    [small, GZIP],
  ])) {
    const head = await ask(at, wish, 'HEAD'),
      etag = String(whole.headers.etag);
    assert.deepEqual(said(head), said(whole), at);
    assert.equal(head.headers['content-length'], String(whole.bytes.length), at);
    assert.equal(head.bytes.length, 0, at);
    for (const method of ['GET', 'HEAD']) {
      const none = await ask(at, { ...wish, 'if-none-match': `"x", W/${etag}` }, method);
      assert.deepEqual([none.status, none.bytes.length, none.headers.etag], [304, 0, etag], at);
      assert.equal(none.headers.vary, whole.headers.vary, at);
      assert.equal(none.headers['cache-control'], 'no-cache', at);
      assert.equal(none.headers.connection, whole.headers.connection, `${at}: the connection goes on`);
      assert.equal(none.headers['content-length'], String(whole.bytes.length), `${at}: RFC 9110 8.6`);
    }
    assert.equal((await ask(at, { ...wish, 'if-none-match': '"0000000000000000"' })).status, 200);
  }
  if (packed) assert.equal((await ask(at, { 'if-none-match': String(small.headers.etag) })).status, 200, `${at}: of another encoding`);
  return { plain, small };
}

/** What HEAD and GET have in common. */
const said = (/** @type {{headers: http.IncomingHttpHeaders}} */ { headers: { date, 'x-request-id': id, ...rest } }) => rest;

/** The same bytes at its second address, to be kept; below another digest not to be kept. */
async function second(/** @type {string} */ at, /** @type {{plain: any, small: any}} */ { plain, small }) {
  const place = String(plain.headers['content-location']);
  assert.match(place, new RegExp(`^/${digest}/`), at);
  assert.equal(new URL(place, daemon.url).pathname, `/${digest}${new URL(at, daemon.url).pathname}`);
  for (const [whole, wish] of [
    [plain, {}],
    [small, GZIP],
  ]) {
    const kept = await ask(place, wish),
      old = await ask(place.replace(digest, '0123456789abcdef'), wish);
    assert.deepEqual([kept.status, kept.headers['cache-control']], [200, FOREVER], at);
    assert.deepEqual([old.status, old.headers['cache-control']], [200, 'no-store'], at);
    assert.ok(kept.bytes.equals(whole.bytes) && old.bytes.equals(whole.bytes), at);
    assert.deepEqual([kept.headers.etag, kept.headers.vary], [whole.headers.etag, whole.headers.vary], at);
    assert.equal(kept.headers['content-location'], undefined, at);
  }
}

test('each document of the API', async () => {
  const list = documents();
  assert.ok(list.length >= 19, list.join());
  for (const at of list) await second(at, await holds(at));
  for (const [query, same] of [
    ['?kind=fluid&brief=true', '?brief=true&kind=fluid'],
    ['?brief=false', ''],
  ])
    assert.ok((await ask(`/api/v1/schema${query}`)).bytes.equals((await ask(`/api/v1/schema${same}`)).bytes), query);
});

test('each file of the page', async () => {
  const list = files();
  assert.ok(list.length > 100, `${list.length}`);
  for (const at of list) {
    const found = await holds(at);
    if (at.endsWith('.html')) continue;
    assert.ok(found.plain.bytes.equals(readFileSync(path.join(WWW, at))), at);
    await second(at, found);
  }
});

test('the page itself has one address, and names the second ones of all its files', async () => {
  const { plain } = await holds('/'),
    text = plain.bytes.toString();
  assert.ok((await ask('/index.html')).bytes.equals(plain.bytes));
  assert.equal(plain.headers['content-location'], undefined);
  for (const at of [`/${digest}/`, `/${digest}/index.html`]) assert.equal((await ask(at)).status, 404, at);
  const named = [...text.matchAll(/(?:href|src)="([^"]+)"/g)].map(([, at]) => at).filter((at) => !/^(?:api|http)/.test(at));
  assert.ok(named.length >= 3);
  for (const at of named) {
    assert.ok(at.startsWith(`${digest}/`), at);
    assert.equal((await ask(`/${at}`)).headers['cache-control'], FOREVER, at);
  }
});

test('nothing else has a second address, and nothing is changed there', async () => {
  const rest = routes(false);
  assert.ok(rest.includes('/api/v1/sessions') && rest.includes('/healthz'));
  for (const at of [...rest, '/K7QF', '/nothing']) {
    const answer = await ask(at);
    assert.equal(answer.headers['content-location'], undefined, at);
    assert.equal((await ask(`/${digest}${at}`)).status, 404, at);
  }
  const body = { scenario: 'race' };
  const made = await c.call('POST', `/${digest}/api/v1/sessions`, { body });
  assert.equal(made.status, 405);
  const { id, owner_key: key } = await c.make({ paused: true });
  for (const [method, at] of [
    ['DELETE', `sessions/${id}`],
    ['GET', `sessions/${id}`],
    ['POST', `sessions/${id}/control`],
  ]) {
    const { status } = await c.call(method, `/${digest}/api/v1/${at}`, { key, body: method === 'POST' ? { op: 'step' } : undefined });
    assert.ok([404, 405].includes(status), `${method} ${at}: ${status}`);
  }
  assert.equal((await c.get(`/api/v1/sessions/${id}`)).json.tick, 0);
  const upgrade = await raw(
    daemon.port,
    `GET /${digest}/api/v1/sessions/${id}/stream HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n` +
      'Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: MDEyMzQ1Njc4OWFiY2RlZg==\r\n\r\n',
    HANG_MS,
    headed,
  );
  assert.doesNotMatch(String(upgrade.text ?? upgrade), /^HTTP\/1\.1 101/);
});

test('daemons of a build have one digest, another page has another, and the digest comes back with the page', async (t) => {
  const www = path.join(folder, 'www');
  cpSync(WWW, www, { recursive: true });
  const digestOf = async (/** @type {string} */ url) =>
    String((await ask('/icon.svg', {}, 'GET', url)).headers['content-location']).slice(1, 17);
  const start = async (/** @type {string[]} */ ...args) => {
    const other = await startDaemon({ args });
    t.after(() => other.stop());
    return other.url;
  };
  assert.equal(await digestOf(await start('--shard', 'a')), digest);
  assert.equal(await digestOf(await start('--www', www)), digest, 'a copy of the page');
  const file = path.join(www, 'first.css'),
    text = readFileSync(file, 'utf8');
  writeFileSync(file, `${text}\n.changed { color: red; }\n`);
  const url = await start('--www', www),
    changed = await digestOf(url);
  assert.notEqual(changed, digest);
  const old = await ask(`/${digest}/first.css`, {}, 'GET', url);
  assert.match(old.bytes.toString(), /changed/);
  assert.equal(old.headers['cache-control'], 'no-store', 'new bytes are never kept below an old digest');
  writeFileSync(file, text);
  const still = await ask('/first.css', {}, 'GET', url);
  assert.match(still.bytes.toString(), /changed/, 'a daemon serves what it began with, also while files are replaced');
  assert.equal(await digestOf(await start('--www', www)), digest);
});

test('what a cache keeps for this page is not given to another origin without its permission', async (t) => {
  const origin = 'https://lab.example',
    other = await startDaemon({ args: ['--allow-origin', origin] });
  t.after(() => other.stop());
  const at = `/${digest}/api/v1/schema`,
    own = await ask(at, {}, 'GET', other.url),
    theirs = await ask(at, { origin }, 'GET', other.url);
  for (const answer of [own, theirs]) assert.match(String(answer.headers.vary), /\bOrigin\b/);
  assert.equal(own.headers['access-control-allow-origin'], undefined);
  assert.equal(theirs.headers['access-control-allow-origin'], origin);
  const plain = await ask('/api/v1/schema', { origin }, 'GET', other.url);
  assert.match(String(plain.headers['access-control-expose-headers']), /\bContent-Location\b/);
  assert.equal((await ask(at)).headers.vary, 'Accept-Encoding', 'where no other origin may read, none is named');
});

test('what is not installed is missing, and the log says so', async (t) => {
  const none = path.join(folder, 'nothing');
  const bare = await startDaemon({ args: ['--www', none, '--scenarios', none, '--api', none] }),
    other = client(bare.url);
  t.after(async () => {
    other.close();
    await bare.stop();
  });
  for (const at of ['/api/v1/openapi.yaml', '/api/v1/asyncapi.yaml', '/api/v1/scenarios', '/api/v1/experiments/library']) {
    const answer = await other.get(at);
    contract.check('get', at, answer);
    assert.equal(answer.status, 404);
    assert.ok(answer.json.detail.includes(`${at} is not installed`), answer.text);
  }
  assert.equal((await other.get('/')).status, 404);
  assert.equal((await other.get('/api/v1/schema')).status, 200);
  assert.match(bare.errors(), /not installed.*nothing/);
});

test('a document costs about as much as the smallest answer', async () => {
  const cpu = () =>
    readdirSync(`/proc/${daemon.pid}/task`).reduce(
      (sum, id) => sum + Number(readFileSync(`/proc/${daemon.pid}/task/${id}/schedstat`, 'utf8').split(' ')[0]) / 1e6,
      0,
    );
  const cost = async (/** @type {string} */ at) => {
    const from = cpu();
    for (let i = 0; i < 200; i++) assert.equal((await ask(at, GZIP)).status, 200);
    return (cpu() - from) / 200;
  };
  const least = { small: Infinity, schema: Infinity };
  for (let i = 0; i < 5; i++) {
    least.small = Math.min(least.small, await cost('/healthz'));
    least.schema = Math.min(least.schema, await cost('/api/v1/schema'));
  }
  assert.ok(least.schema < 4 * least.small, `ms of CPU: ${JSON.stringify(least)}`);
});
