// The operator's key and the class key: from files and from the environment, and without either. Who may do what with a key is in
// access_matrix.csv.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { spawnSync } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { client } from '../lib/client.mjs';
import { BINARY, startDaemon } from '../lib/daemon.mjs';

const S = '/api/v1/sessions',
  E = '/api/v1/experiments',
  C = '/api/v1/creation';
const OPERATOR = 'operator-of-this-lab-71',
  CLASS = 'class-7b-autumn',
  SMALL = {
    scenario: 'race',
    set: { duration_s: 1, warmup_s: 0 },
    axes: [{ path: 'players.0.lag_ms', values: [0, 100] }],
    metrics: ['players.0.own_lead_m.mean', 'players.0.bandwidth.down_bytes_per_s'],
  };

const folder = mkdtempSync(path.join(tmpdir(), 'laglab-access-'));
const file = (/** @type {string} */ name, /** @type {string} */ text) => {
  writeFileSync(path.join(folder, name), text);
  return path.join(folder, name);
};
const FILES = ['--operator-key-file', file('operator', `${OPERATOR}\n`), '--class-key-file', file('class', CLASS)];

let daemon, c;
before(async () => {
  daemon = await startDaemon({ args: [...FILES, '--max-code-lookups-per-min', '100'] });
  c = client(daemon.url);
});
after(async () => {
  c.close();
  await daemon.stop();
  rmSync(folder, { recursive: true, force: true });
});

test('a key that is nearly the class key is another', async () => {
  const body = { scenario: 'race', paused: true };
  for (const key of [`${CLASS}x`, CLASS.slice(1), CLASS.slice(0, -1), CLASS.toUpperCase(), ''])
    assert.equal((await c.call('POST', S, { body, key })).status, 403, key);
  assert.match((await c.call('POST', S, { body })).json.detail, /class key/);
  assert.equal((await c.call('POST', S, { body, key: CLASS })).status, 201);
});

test('the operator lists sessions page by page, and experiments', async () => {
  const sessions = [];
  for (let i = 0; i < 5; i++) sessions.push((await c.call('POST', S, { body: { scenario: 'race' }, key: CLASS })).json);
  const ids = [];
  for (let after = 0; after !== null; ) {
    const { json } = await c.get(`${S}?limit=2&after=${after}`, { key: OPERATOR });
    assert.ok(json.sessions.length <= 2);
    ids.push(...json.sessions.map((/** @type {any} */ s) => s.id));
    after = json.next;
  }
  assert.deepEqual(
    ids.slice(-5),
    sessions.map((s) => s.id),
    'in the order of their making, none twice',
  );
  assert.equal(new Set(ids).size, ids.length);
  assert.deepEqual(
    ids,
    (await c.get(S, { key: OPERATOR })).json.sessions.map((/** @type {any} */ s) => s.id),
  );
  const x = (await c.call('POST', E, { body: SMALL, key: CLASS })).json.id;
  assert.ok((await c.get(E, { key: OPERATOR })).json.experiments.some((/** @type {any} */ e) => e.id === x));
});

test('the operator closes creation and opens it; anything else is refused', async () => {
  assert.deepEqual((await c.get(C)).json, { creation: 'class' });
  for (const body of [{ creation: 'closed' }, { creation: 1 }, {}, { creation: 'open', more: 1 }])
    assert.equal((await c.call('PUT', C, { body, key: OPERATOR })).status, 400);
  for (const creation of ['operator', 'open', 'class']) {
    assert.deepEqual((await c.call('PUT', C, { body: { creation }, key: OPERATOR })).json, { creation });
    assert.deepEqual((await c.get(C)).json, { creation });
  }
});

test('a key cannot be guessed: wrong ones are counted by address', async () => {
  const strict = await startDaemon({ args: [...FILES, '--max-code-lookups-per-min', '3'] }),
    s = client(strict.url);
  const statuses = [];
  for (let i = 0; i < 6; i++) statuses.push((await s.get(S, { key: `guess-number-${i}-abcdef` })).status);
  assert.deepEqual(statuses, [403, 403, 403, 429, 429, 429]);
  assert.equal((await s.get(S, { key: OPERATOR })).status, 200, 'who has it is not hindered');
  s.close();
  await strict.stop();
});

test('without either all is open, and no client is the operator', async () => {
  const open = await startDaemon(),
    s = client(open.url);
  assert.deepEqual((await s.get(C)).json, { creation: 'open' });
  const session = await s.make();
  assert.equal((await s.call('POST', `${S}/${session.id}/fork`)).status, 201);
  for (const key of ['', OPERATOR, session.owner_key]) assert.equal((await s.get(S, { key })).status, 403);
  s.close();
  await open.stop();
});

test('keys of the environment, and files that hold none', async () => {
  process.env.LAGLAB_OPERATOR_KEY = OPERATOR;
  const env = await startDaemon({ args: ['--creation', 'operator'] }).finally(() => delete process.env.LAGLAB_OPERATOR_KEY),
    s = client(env.url);
  assert.equal((await s.call('POST', S, { body: { scenario: 'race' } })).status, 401);
  assert.equal((await s.call('POST', S, { body: { scenario: 'race' }, key: OPERATOR })).status, 201);
  s.close();
  await env.stop();
  const refused = /** @type {[string[], RegExp][]} */ ([
    [['--operator-key-file', path.join(folder, 'none')], /Cannot read key file/],
    [['--operator-key-file', file('short', 'secret\n')], /16 to 256 characters; got 6/],
    [['--class-key-file', file('lines', 'first-line-1\nsecond-line\n')], /one line/],
    [['--class-key-file', file('space', 'two words in it')], /visible ASCII/],
    [['--class-key-file', file('empty', '')], /got 0/],
    [['--creation', 'class'], /requires the class key/],
    [['--creation', 'operator'], /requires the operator's key/],
    [['--creation', 'nobody'], /open, class, operator/],
  ]);
  for (const [args, words] of refused) {
    const ended = spawnSync(BINARY, ['serve', '--listen', '127.0.0.1:0', '--data', 'memory', ...args], {
      encoding: 'utf8',
      timeout: 600000,
    });
    assert.equal(ended.status, 2, args.join(' '));
    assert.match(ended.stderr, words);
  }
});
