// Queries: names that an operation does not have, and values that are neither true nor false, are refused.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { client } from '../lib/client.mjs';
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
