// Two shards behind HAProxy and nginx as deploy/shards configures them: what a client makes stays with its shard; one that is killed goes
// on from its folder, and the other does not notice. Then three, of which one thing after the other fails.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { after, before, describe, test } from 'node:test';
import { client, openStream, pause, waitFor } from '../lib/client.mjs';
import { BINARY } from '../lib/daemon.mjs';
import { shardOf, startShards } from '../lib/shards.mjs';
import { checkLog } from '../shards/checks.mjs';
import { noShards } from '../shards/rig.mjs';
import { broken, disturb } from '../shards/run.mjs';

const C = '/api/v1/classes',
  S = '/api/v1/sessions';
const NAMES = ['a', 's0'];
const WRITTEN_MS = 300; /* after a vote, until it is on disk */

const done = (/** @type {any} */ answer, status = 200) => {
  assert.equal(answer.status, status, answer.text);
  return answer.json;
};

test('a name that is none is refused', () => {
  for (const name of ['A', 'no', 'a-b', 'abcde']) {
    const { status, stderr } = spawnSync(BINARY, ['serve', '--shard', name, '--data', 'memory', '--listen', '127.0.0.1:0'], {
      encoding: 'utf8',
      timeout: 600000,
    });
    assert.equal(status, 2, stderr);
    assert.match(stderr, /shard/);
  }
});

for (const proxy of ['haproxy', 'nginx'])
  describe(proxy, () => {
    /** @type {Awaited<ReturnType<typeof startShards>>} */ let site;
    /** @type {ReturnType<typeof client>} */ let c;
    before(async () => {
      site = await startShards(NAMES, { proxy });
      c = client(site.url);
    });
    after(async () => {
      c?.close();
      await site?.close();
    });

    /** A session at a shard, by the query. @param {string} name */
    const makeAt = async (name) =>
      done(await c.call('POST', `${S}?shard=${name}`, { body: { scenario: 'race', set: { duration_s: 600 } } }), 201);

    test('new sessions go to each shard in turn, and everything about them to the one that made them', async () => {
      const made = [];
      for (let i = 0; i < 12; i++) made.push(await c.make({ set: { duration_s: 600 } }));
      for (const name of NAMES)
        assert.ok(
          made.some(({ id }) => shardOf(id) === name),
          name,
        );
      for (const session of made) {
        const name = shardOf(session.id);
        assert.match(session.id, /^(a|s0)-[a-z2-7]{26}$/);
        assert.match(session.code, new RegExp(`^${name.toUpperCase()}-[2-9A-HJKMNP-Z]{4}$`));
        for (const link of Object.values(session.links).filter((at) => String(at).startsWith(S)))
          assert.ok(link.includes(session.id), link);
        for (let i = 0; i < 3; i++) {
          done(await c.get(`${S}/${session.id}`));
          assert.equal(done(await c.get(`/api/v1/codes/${session.code}`)).id, session.id);
        }
        done(await c.patch(session, { 'players.1.lag_ms': 70 }));
        const fork = done(await c.call('POST', `${S}/${session.id}/fork`, { body: {} }), 201);
        assert.equal(shardOf(fork.id), name);
        const stream = await c.stream(session, 'json', { subscribe: { clock: 20 } });
        await waitFor(() => stream.frames.length > 2, 'frames');
        stream.close();
      }
    });

    test('a request that is repeated with its key makes nothing twice', async () => {
      const answers = [];
      for (let i = 0; i < 4; i++)
        answers.push(
          done(await c.call('POST', S, { body: { scenario: 'race' }, headers: { 'idempotency-key': 'once-and-again' } }), 201).id,
        );
      assert.equal(new Set(answers).size, 1);
    });

    test('experiments, advice and measurements stay with their shard', async () => {
      const metrics = ['players.0.remote_error_m.mean', 'players.0.remote_error_m.max'],
        race = { scenario: 'race', set: { duration_s: 1 }, axes: [{ path: 'players.0.lag_ms', values: [0, 50] }], metrics };
      for (const name of NAMES)
        for (const [path, body] of /** @type {[string, any][]} */ ([
          ['/api/v1/experiments', race],
          ['/api/v1/advise', { experiment: race, max_error: 1 }],
          ['/api/v1/tradeoffs', { family: 'contact_solvers', duration_s: 0.1 }],
        ])) {
          const { id } = done(await c.call('POST', `${path}?shard=${name}`, { body }), 202);
          assert.match(id, new RegExp(`^${name}-[a-z2-7]{26}$`));
          for (let i = 0; i < 3; i++) assert.equal(done(await c.get(`${path}/${id}`)).id, id);
        }
    });

    test('an id of a shard that there is not, or at the wrong one, is unknown; another name in the query is refused', async () => {
      const session = await makeAt('a');
      assert.equal((await fetch(new URL(`${S}/${session.id}`, site.shards.s0.url))).status, 404);
      assert.equal((await fetch(new URL(`${S}/${session.id}`, site.shards.a.url))).status, 200);
      assert.equal((await c.get(`${S}/zz-${session.id.slice(2)}`)).status, 404);
      assert.equal((await c.get(`${C}/ZZ-K7QF`)).status, 404);
      const refused = await c.call('POST', `${S}?shard=zz`, { body: { scenario: 'race' } });
      assert.equal(refused.status, 400, refused.text);
      assert.match(refused.json.errors[0].detail, /^shard: must be (a|s0), the name of this daemon; got zz$/);
      assert.equal((await c.get('/metrics')).status, 404);
    });

    test('a class is at one shard by its code and its id, with its board and its copies', async () => {
      for (const name of NAMES) {
        const shown = await makeAt(name);
        const made = done(await c.call('POST', `${C}?shard=${name}`), 201),
          at = `${C}/${made.id}`;
        assert.equal(shardOf(made.id), name);
        assert.match(made.code, new RegExp(`^${name.toUpperCase()}-`));
        for (const code of [made.code, made.code.toLowerCase()]) assert.equal(done(await c.get(`${C}/${code}`)).id, made.id);
        const page = await fetch(`${site.url}/${made.code.toLowerCase()}`, { redirect: 'manual' });
        assert.deepEqual([page.status, page.headers.get('location')], [302, `/#class=${made.code}`]);
        for (const url of made.join.urls) assert.ok(url.endsWith(`/${made.code}`), url);
        done(await c.call('PUT', `${at}/board`, { key: made.teacher_key, body: { session: shown.id, owner_key: shown.owner_key } }));
        const copier = done(await c.call('POST', `${at}/members`, { body: { role: 'copy' } }), 201);
        assert.equal(shardOf(copier.copy), name);
        const lesson = done(await c.call('PUT', `${at}/board`, { key: made.teacher_key, body: { scenario: 'race' } }));
        assert.equal(shardOf(lesson.id), name);
      }
    });

    test('a shard that is killed goes on from its folder; the other one does not notice', async () => {
      const [killed, other] = [await makeAt('a'), await makeAt('s0')];
      const room = done(await c.call('POST', `${C}?shard=a`), 201),
        at = `${C}/${room.id}`;
      done(await c.call('PATCH', at, { key: room.teacher_key, body: { phase: 'predict', step: 0, choices: 3 } }));
      const member = done(await c.call('POST', `${at}/members`, { body: { role: 'watch' } }), 201);
      done(await c.call('PUT', `${at}/vote`, { key: member.token, body: { step: 0, choice: 2 } }), 204);
      const streams = await Promise.all([killed, other].map((session) => c.stream(session, 'json', { subscribe: { clock: 20 } })));
      await waitFor(() => streams.every(({ frames }) => frames.length > 5), 'frames');
      const changed = done(await c.patch(killed, { 'players.1.lag_ms': 130 }));
      await pause(WRITTEN_MS);

      const seen = streams[1].frames.length;
      await site.shards.a.kill();
      const away = c.get(`${S}/${killed.id}`); // waits a while, then is a 503
      await pause(500);
      done(await c.patch(other, { 'players.1.lag_ms': 90 }));
      for (let i = 0; i < 4; i++) assert.equal(shardOf((await c.make()).id), 's0', 'new sessions go to the other shard');
      assert.ok(streams[1].frames.length > seen + 5, 'the stream of the other shard goes on');
      assert.ok([200, 502, 503].includes((await away).status));
      assert.ok([502, 503].includes((await c.get(`${S}/${killed.id}`)).status), 'and not 404, which would end the session for its viewers');

      await site.again('a');
      const now = done(await c.get(`${S}/${killed.id}`));
      assert.ok(now.tick >= changed.tick && now.params.players[1].lag_ms === 130);
      const again = await c.stream(killed, 'json', { subscribe: { clock: 20 } });
      await waitFor(() => again.frames.length > 3, 'frames after the restart');
      const { tick, hash } = done(await c.control(killed, { op: 'pause' }));
      const file = path.join(site.shards.a.data, 'session.log');
      writeFileSync(file, (await c.get(`${S}/${killed.id}/log`)).text);
      const replayed = spawnSync(BINARY, ['replay', file], { encoding: 'utf8' });
      assert.equal(replayed.status, 0, replayed.stderr);
      assert.ok(readFileSync(file, 'utf8').includes(`"tick":${tick},"hash":"${hash}"`), 'the log has the hash of the last tick');
      assert.equal(done(await c.get(`${C}/${room.code}`)).state.votes, 1, 'the vote is there');
      const back = await openStream(site.url, `classes/${room.id}`);
      back.close();
      for (const stream of [...streams, again]) stream.close();
    });
  });

test('shards that are disturbed lose nothing', { skip: noShards() || false, timeout: 600000 }, async (t) => {
  const kinds = ['killed', 'cut off', 'proxy restarted', 'stopped', 'rolling restart'],
    report = await disturb({ sessions: 12, classes: 2, kinds, every_ms: 200, quiet_s: 1, steady_s: 0.3, twins: 4 });
  t.diagnostic(JSON.stringify(report.totals));
  assert.deepEqual(report.findings.slice(0, 10), []);
  assert.deepEqual(broken(report), []);
  assert.ok(report.totals.acknowledged > 200 && report.totals.replayed === 14 && report.totals.votes > 20, 'something was disturbed');
});

test('what does not hold is found: lost and doubled commands, and those at another tick', () => {
  const line = (/** @type {number} */ tick, /** @type {number} */ value) =>
    JSON.stringify({ op: 'set', tick, values: { 'players.1.lag_ms': value } });
  const commands = [
    { value: 0.0625, status: 200, tick: 10 },
    { value: 0.125, status: 200, tick: 20 },
    { value: 0.1875, status: 200, tick: 30 },
    { value: 0.25, status: 503, tick: -1 },
  ];
  const check = (/** @type {string[]} */ ...lines) => {
    const { lost, twice, disorder, unanswered_stored } = checkLog(
      { id: 'a', commands, log: ['{"op":"create"}', ...lines, ''].join('\n') },
      [],
    );
    return [lost, twice, disorder, unanswered_stored];
  };
  assert.deepEqual(check(line(10, 0.0625), line(20, 0.125), line(30, 0.1875)), [0, 0, 0, 0]);
  assert.deepEqual(check(line(10, 0.0625), line(20, 0.125), line(30, 0.1875), line(40, 0.25)), [0, 0, 0, 1]);
  assert.deepEqual(check(line(10, 0.0625), line(30, 0.1875)), [1, 0, 0, 0]);
  assert.deepEqual(check(line(10, 0.0625), line(21, 0.125), line(30, 0.1875)), [1, 0, 0, 0]);
  assert.deepEqual(check(line(10, 0.0625), line(20, 0.125), line(30, 0.1875), line(30, 0.1875)), [0, 1, 0, 0]);
  assert.deepEqual(check(line(10, 0.0625), line(30, 0.1875), line(20, 0.125)), [0, 0, 1, 0]);
});
