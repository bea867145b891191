// Queries: names that an operation does not have, names that come twice, and values that are neither true nor false, are refused.
import assert from 'node:assert/strict';
import net from 'node:net';
import { after, before, test } from 'node:test';
import { client, waitFor } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';

const S = '/api/v1/sessions',
  E = '/api/v1/experiments';
const SMALL = {
  scenario: 'race',
  set: { duration_s: 1, warmup_s: 0 },
  axes: [{ path: 'players.0.lag_ms', values: [0, 100] }],
  metrics: ['players.0.own_lead_m.mean'],
};
let daemon, c;
before(async () => {
  daemon = await startDaemon();
  c = client(daemon.url);
});
after(async () => {
  c.close();
  await daemon.stop();
});

test('a name that is not known begins nothing', async () => {
  const refused = await c.call('POST', `${E}?dryrun=true`, { body: SMALL });
  assert.equal(refused.status, 400);
  assert.equal(refused.json.errors[0].field, 'dryrun');
  assert.match(refused.json.detail, /must be one of dry_run/);
  assert.match((await c.get('/metrics')).text, /^laglab_streams 0$/m, 'no experiment was made');
  const { id, owner_key: key } = await c.make({ paused: true });
  for (const [method, place, body] of /** @type {[string, string, any][]} */ ([
    ['GET', `${S}/${id}/state?ticks=3`],
    ['GET', `${S}/${id}/trace?from=1`],
    ['GET', `${S}/${id}?x`],
    ['POST', `${S}/${id}/control?op=play`, { op: 'play' }],
    ['DELETE', `${S}/${id}?dry_run=true`],
    ['GET', '/api/v1/scenarios?briefly=true'],
    ['GET', '/readyz?verbose'],
    ['GET', `${S}/${id}/state?tick=0&tic=0`],
  ]))
    assert.equal((await c.call(method, place, { body, key })).status, 400, place);
  assert.equal((await c.get(`${S}/${id}/state?tick=0`)).status, 200);
  assert.equal((await c.get(`${S}/${id}`)).json.status, 'paused');
});

test('what is neither true nor false is refused', async () => {
  const { id } = (await c.call('POST', E, { body: SMALL })).json;
  for (const query of ['points=maybe', 'points=', 'points=1', 'sensitivity=True'])
    assert.equal((await c.get(`${E}/${id}/results?${query}`)).status, 400, query);
  for (const query of ['points=true', 'points=false', 'sensitivity=false'])
    assert.equal((await c.get(`${E}/${id}/results?${query}`)).status, 200, query);
});

test('a name that comes twice is refused on every route, also with the same value and without any', async () => {
  for (const [place, name] of [
    ['/api/v1/schema?kind=motion&kind=fluid', 'kind'],
    ['/api/v1/schema?kind=fluid&brief=true&kind=fluid', 'kind'],
    ['/api/v1/scenarios?brief&brief', 'brief'],
    [`${S}?after=3&limit=2&limit=4`, 'limit'],
    [`${S}/none/state?tick=7&tick=7`, 'tick'],
  ]) {
    const answer = await c.get(place);
    assert.equal(answer.status, 400, place);
    assert.equal(answer.json.errors[0].field, name, place);
    assert.match(answer.json.detail, /: must come once/, place);
  }
  assert.equal((await c.get('/api/v1/schema?kind=fluid&brief=true')).status, 200);
});

/** Asks for a stream on a connection of its own (fresh), or behind a request on it (late). */
async function upgrade(/** @type {number} */ port, /** @type {string} */ target, /** @type {boolean} */ late) {
  const socket = net.connect(port, '127.0.0.1');
  if (late) {
    socket.write('GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n');
    await new Promise((resolve) => socket.once('data', resolve));
  }
  const head = ['Connection: Upgrade', 'Upgrade: websocket', 'Sec-WebSocket-Version: 13', 'Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ=='];
  const lines = [`GET ${target} HTTP/1.1`, 'Host: localhost', ...head, 'Sec-WebSocket-Protocol: laglab.v2.json', '', ''];
  socket.write(lines.join('\r\n'));
  let text = '';
  socket.on('data', (part) => {
    text += part.toString('latin1');
  });
  await waitFor(() => /^HTTP\/1\.1 101 |\}$/.test(text), 'an answer');
  socket.destroy();
  return { status: Number(text.slice(9, 12)), text };
}

test('the query of a stream is checked as any other, of fresh upgrades and of late ones; its shard must be this one', async (t) => {
  const shard = await startDaemon({ args: ['--shard', 'k7'] });
  t.after(() => shard.stop());
  const c7 = client(shard.url);
  t.after(() => c7.close());
  for (const [place, at, plain] of /** @type {[typeof daemon, typeof c, boolean][]} */ ([
    [daemon, c, true],
    [shard, c7, false],
  ])) {
    const streams = [
      `${S}/${(await at.make({ paused: true })).id}`,
      `${E}/${(await at.call('POST', E, { body: { ...SMALL, repeats: 2000 } })).json.id}`,
      `/api/v1/classes/${(await at.call('POST', '/api/v1/classes', { body: { lesson: 'late_answer', step: 1, choices: 4 } })).json.id}`,
    ];
    for (const stream of streams)
      for (const late of [false, true])
        for (const [query, status, field] of /** @type {[string, number, string?][]} */ ([
          ['', 101],
          ['?', 101],
          ['?verbose=2', 400, 'verbose'],
          ['?shard=z9', 400, 'shard'],
          ['?shard=k7', plain ? 400 : 101, 'shard'],
          ['?shard=k7&shard=k7', 400, 'shard'],
          ['?shard=k7&token', 400, plain ? 'shard' : 'token'],
        ])) {
          const answer = await upgrade(place.port, `${stream}/stream${query}`, late),
            what = `${plain ? '' : 'shard '}${late ? 'late' : 'fresh'} ${stream}${query}`;
          assert.equal(answer.status, status, what);
          if (status === 400) assert.match(answer.text, new RegExp(`"field":"${field}"`), what);
        }
  }
});
