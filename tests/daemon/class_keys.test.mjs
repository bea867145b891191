// Several class keys, each with quotas of its own: what they permit, what they refuse, what the operator sees, and files that are refused.
import assert from 'node:assert/strict';
import { after, test } from 'node:test';
import { execFileSync, spawnSync } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { client } from '../lib/client.mjs';
import { BINARY, startDaemon } from '../lib/daemon.mjs';

const S = '/api/v1/sessions',
  E = '/api/v1/experiments',
  C = '/api/v1/classes',
  K = '/api/v1/class-keys';
const OPERATOR = 'operator-of-this-site-73',
  NORTH = 'key-of-the-north-1',
  SOUTH = 'key-of-the-south-2';
const RACE = { scenario: 'race', paused: true };
const SMALL = {
  scenario: 'race',
  set: { duration_s: 1, warmup_s: 0 },
  axes: [{ path: 'players.0.lag_ms', values: [0, 100] }],
  metrics: ['players.0.own_lead_m.mean'],
};

const folder = mkdtempSync(path.join(tmpdir(), 'laglab-class-keys-'));
after(() => rmSync(folder, { recursive: true, force: true }));
const file = (/** @type {string} */ name, /** @type {string} */ text) => {
  writeFileSync(path.join(folder, name), text);
  return path.join(folder, name);
};

/** @param {string} keys @param {(s: any, daemon: any) => Promise<void>} use @param {string[]} [args] @param {any} [wish] */
async function withKeys(keys, use, args = [], wish = {}) {
  const files = ['--class-key-file', file('class', keys), '--operator-key-file', file('operator', OPERATOR)];
  const daemon = await startDaemon({ ...wish, args: [...files, ...args] });
  const s = client(daemon.url);
  try {
    await use(s, daemon);
  } finally {
    s.close();
    await daemon.stop();
  }
}

/** @param {any} s @param {string} key @param {string} [at] @param {any} [body] */
const post = (s, key, at = S, body = RACE) => s.call('POST', at, { body, key });

const made = async (/** @type {any} */ answer) => {
  const got = await answer;
  assert.ok([200, 201, 202].includes(got.status), got.text);
  return got.json;
};

/** Refused by a quota: what it says names the key, and never is it. @param {any} answer @param {RegExp} words */
async function refused(answer, words, status = 429) {
  const got = await answer;
  assert.equal(got.status, status, got.text);
  assert.match(got.json.detail, words);
  assert.ok(!got.text.includes(NORTH) && !got.text.includes(SOUTH), got.text);
  if (status === 429) assert.ok(Number(got.headers['retry-after']) > 0);
}

const usesOf = async (/** @type {any} */ s) =>
  Object.fromEntries((await made(s.get(K, { key: OPERATOR }))).class_keys.map((/** @type {any} */ k) => [k.name, k]));

test('each key has its quotas in place of those of the address; what is deleted makes room', async () => {
  const keys = `# two schools\n\n north ${NORTH} classes=1 sessions=3 experiments=1\r\nsouth\t${SOUTH}  sessions=2\n`;
  const args = ['--max-client-classes', '1', '--max-client-experiments', '1'];
  await withKeys(
    keys,
    async (s) => {
      assert.equal((await s.call('POST', S, { body: RACE })).status, 401);
      for (const wrong of [`${NORTH}x`, 'north', `north ${NORTH}`]) assert.equal((await post(s, wrong)).status, 403, wrong);
      const sessions = [];
      for (let i = 0; i < 3; i++) sessions.push(await made(post(s, NORTH)));
      await refused(post(s, NORTH), /^The class key north has as many sessions as it may have \(3\); delete some\.$/);
      await refused(post(s, NORTH, `${S}/${sessions[0].id}/fork`, {}), /class key north has as many sessions as it may have \(3\)/);
      for (let i = 0; i < 2; i++) await made(post(s, SOUTH));
      await refused(post(s, SOUTH), /class key south has as many sessions as it may have \(2\)/);
      await made(post(s, OPERATOR));

      // Classes: the sessions that are made for one count too, also when a member without a key asks for them.
      const { id, teacher_key: teacher } = await made(post(s, NORTH, C, {}));
      await refused(post(s, NORTH, C, {}), /^The class key north has as many classes as it may have \(1\); delete some\.$/);
      for (let i = 0; i < 3; i++) await made(post(s, SOUTH, C, {}));
      await refused(
        s.call('PUT', `${C}/${id}/board`, { key: teacher, body: RACE }),
        /class key north has as many sessions as it may have \(3\)/,
      );
      assert.equal((await s.call('DELETE', `${S}/${sessions[1].id}`, { key: sessions[1].owner_key })).status, 204);
      await made(s.call('PUT', `${C}/${id}/board`, { key: teacher, body: RACE }));
      await refused(post(s, NORTH), /class key north has as many sessions as it may have \(3\)/);
      assert.equal((await s.call('DELETE', `${S}/${sessions[2].id}`, { key: sessions[2].owner_key })).status, 204);
      await made(s.call('POST', `${C}/${id}/members`, { body: { role: 'copy' } }));
      await refused(
        s.call('POST', `${C}/${id}/members`, { body: { role: 'copy' } }),
        /class key north has as many sessions as it may have \(3\)/,
      );
      assert.equal((await s.call('DELETE', `${C}/${id}`, { key: teacher })).status, 204);
      await made(post(s, NORTH, C, {}));

      const x = await made(post(s, NORTH, E, SMALL));
      await refused(post(s, NORTH, E, SMALL), /^The class key north has as many experiments as it may have \(1\); delete some\.$/);
      for (let i = 0; i < 2; i++) await made(post(s, SOUTH, E, SMALL));
      assert.equal((await s.call('DELETE', `${E}/${x.id}`, { key: x.owner_key })).status, 204);
      await made(post(s, NORTH, E, SMALL));

      // What the operator sees, and others do not.
      assert.equal((await s.get(K)).status, 401);
      assert.equal((await s.get(K, { key: NORTH })).status, 403);
      const { north, south } = await usesOf(s);
      assert.deepEqual(north.most, { classes: 1, sessions: 3, experiments: 1, log_bytes: null, new_sessions_per_min: null });
      const { log_bytes: bytes, ...rest } = north.used;
      assert.deepEqual(rest, { classes: 1, sessions: 3, experiments: 1 });
      assert.deepEqual([south.used.classes, south.used.sessions, south.used.experiments, south.refused], [3, 2, 2, 1]);
      assert.equal(north.refused, 7);
      const { sessions: all } = await made(s.get(S, { key: OPERATOR }));
      const own = all.filter((/** @type {any} */ one) => one.class_key === 'north');
      assert.equal(
        own.reduce((/** @type {number} */ sum, /** @type {any} */ one) => sum + one.log_bytes, 0),
        bytes,
      );
      assert.deepEqual(
        all.map((/** @type {any} */ one) => one.class_key).sort(),
        [...'north north north south south'.split(' '), null].sort(),
      );
      const { experiments } = await made(s.get(E, { key: OPERATOR }));
      assert.deepEqual(experiments.map((/** @type {any} */ one) => one.class_key).sort(), ['north', 'south', 'south']);
      const { text } = await s.get('/metrics');
      for (const line of ['sessions{name="north"} 3', 'sessions{name="south"} 2', 'classes{name="south"} 3', 'experiments{name="north"} 1'])
        assert.ok(text.includes(`\nlaglab_class_key_${line}\n`), line);
      assert.match(text, /\nlaglab_class_key_refused_total\{name="north"\} 7\n/);
      assert.ok(!text.includes(NORTH) && !JSON.stringify([north, south]).includes(NORTH));
    },
    args,
  );
});

test('with open creation only who sends a key counts for it', async () => {
  await withKeys(
    `north ${NORTH} sessions=0\n`,
    async (s) => {
      await made(s.call('POST', S, { body: RACE }));
      await made(post(s, 'some-other-key'));
      await refused(post(s, NORTH), /class key north has as many sessions as it may have \(0\)/);
    },
    ['--creation', 'open'],
  );
});

test('a key has its own rate', async () => {
  await withKeys(
    `north ${NORTH} new_sessions_per_min=3\nsouth ${SOUTH}\n`,
    async (s) => {
      for (let i = 0; i < 2; i++) await made(post(s, NORTH));
      await made(post(s, NORTH, C, {}));
      await refused(
        post(s, NORTH),
        /^The class key north may make at most 3 sessions, classes and experiments per minute; wait a little\.$/,
      );
      for (const [at, body] of /** @type {[string, any][]} */ ([
        [C, {}],
        [E, SMALL],
      ]))
        await refused(post(s, NORTH, at, body), /class key north may make at most 3 /);
      for (let i = 0; i < 4; i++) await made(post(s, SOUTH));
    },
    ['--max-new-sessions-per-min', '12'],
  );
});

test('kill -9 and a new start: what was made with a key still counts, and the bytes of its logs', async () => {
  const keys = `north ${NORTH} classes=1 sessions=2 experiments=1 logs_mib=1\n`,
    args = ['--max-client-logs-mib', '1'];
  await withKeys(keys, async (s, daemon) => {
    const session = await made(post(s, NORTH)),
      other = await made(post(s, NORTH)),
      opened = await made(post(s, NORTH, C, {}));
    await made(post(s, NORTH, E, SMALL));
    const before = (await usesOf(s)).north.used;
    await new Promise((resolve) => setTimeout(resolve, 300)); /* a class is stored some milliseconds after its answer */
    await daemon.kill();
    const more = 1 << 20;
    const number = `(SELECT number FROM sessions WHERE id='${session.id}')`,
      longer = `UPDATE log SET line=line||printf('%${more}s','') WHERE line_index=0 AND session=${number}`;
    execFileSync('sqlite3', [path.join(daemon.data, 'laglab.db'), longer]);
    const use = async (/** @type {any} */ again) => {
      assert.deepEqual((await usesOf(again)).north.used, { ...before, log_bytes: before.log_bytes + more });
      await refused(post(again, NORTH, C, {}), /as many classes as it may have/);
      await refused(post(again, NORTH, E, SMALL), /as many experiments as it may have/);
      const full = /^The logs of the class key north have 1\.0 of the 1\.0 MiB that they may have; delete some of its sessions\.$/;
      await refused(post(again, NORTH), full, 507);
      for (const one of [session, other]) await refused(again.patch(one, { 'players.0.lag_ms': 9 }), full, 507);
      assert.equal((await again.control(other, { op: 'play' })).status, 200, 'the clock goes on');
      await made(post(again, SOUTH));
      assert.equal((await again.call('DELETE', `${S}/${session.id}`, { key: session.owner_key })).status, 204);
      assert.equal((await again.patch(other, { 'players.0.lag_ms': 9 })).status, 200);
      await made(post(again, NORTH));
      await refused(post(again, NORTH), /as many sessions as it may have/);
    };
    // While its line is missing nothing counts for it; what is stored meanwhile keeps its name.
    const without = async (/** @type {any} */ again, /** @type {any} */ next) => {
      assert.deepEqual(Object.keys(await usesOf(again)), ['south']);
      await made(again.call('POST', `${C}/${opened.id}/members`, { body: { role: 'watch' } }));
      await new Promise((resolve) => setTimeout(resolve, 300));
      await next.kill();
    };
    await withKeys(`south ${SOUTH}\n`, without, args, { data: daemon.data });
    await withKeys(`${keys}south ${SOUTH}\n`, use, args, { data: daemon.data });
  });
});

test('quotas hold for requests at the same time', async () => {
  await withKeys(`north ${NORTH} classes=2 sessions=3 experiments=2\n`, async (s) => {
    const of = async (/** @type {string} */ at, /** @type {any} */ body) =>
      (await Promise.all(Array.from({ length: 8 }, () => post(s, NORTH, at, body)))).filter(({ status }) => status < 300).length;
    assert.deepEqual([await of(S, RACE), await of(C, {}), await of(E, SMALL)], [3, 2, 2]);
  });
});

test('a file of keys that is wrong ends the start with the line', () => {
  const long = 'n'.repeat(33);
  const files = /** @type {[string, RegExp][]} */ ([
    [`north ${NORTH}\nsouth\n`, /line 2: must be NAME KEY and quotas/],
    [`${NORTH}\n${SOUTH}\n`, /line 1: must be NAME KEY.*its file must have one line/],
    [`north ${NORTH}\n\n# no\nsouth short`, /line 4: must be visible ASCII.*8 to 256 characters; got 5/],
    [`north ${NORTH}\nnorth ${SOUTH}\n`, /line 2: the name north is that of an earlier line/],
    [`north ${NORTH}\nsouth ${NORTH}\n`, /line 2: the key is that of an earlier line/],
    [`${long} ${NORTH}\n`, /line 1: the name must be 1 to 32 of/],
    [`nörth ${NORTH}\n`, /line 1: the name must be/],
    [`north ${NORTH} sessions:3\n`, /line 1: after NAME and KEY .* sessions=N/],
    [`north ${NORTH} sessions=3 secret-word\n`, /line 1: after NAME and KEY/],
    [`north ${NORTH} sessions=-1\n`, /line 1: sessions: must be a whole number from 0 to 1000000/],
    [`north ${NORTH} logs_mib=1e3\n`, /line 1: logs_mib: must be a whole number from 1 to/],
    [`north ${NORTH} classes=\n`, /line 1: classes: must be a whole number/],
    [`north ${NORTH} classes=1 classes=2\n`, /line 1: classes: is given twice/],
    ['# nothing\n\n', /has no key/],
    [Array.from({ length: 257 }, (_, i) => `n${i} key-number-${i}\n`).join(''), /line 257: must be at most 256 keys/],
    ['#'.repeat(140000), /smaller than 128 KiB/],
  ]);
  for (const [text, words] of files) {
    const args = ['serve', '--listen', '127.0.0.1:0', '--data', 'memory', '--class-key-file', file('wrong', text)];
    const ended = spawnSync(BINARY, args, { encoding: 'utf8', timeout: 600000 });
    assert.equal(ended.status, 2, text.slice(0, 80));
    assert.match(ended.stderr, words);
    assert.ok(!ended.stderr.includes(NORTH) && !ended.stderr.includes('secret-word'), 'no key is repeated');
  }
});
