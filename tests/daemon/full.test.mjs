// Acknowledged means stored: while the store fails, changes are refused with 507 and nothing changes; reads go on; what was acknowledged
// is there after kill -9.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { test } from 'node:test';
import { client, openStream, pause, waitFor } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';
import { failingDisk, makeDisk, nothing } from '../lib/full.mjs';

const C = '/api/v1/classes';
const folder = () => mkdtempSync(path.join(tmpdir(), 'laglab-full-'));
const remove = (name) => rmSync(name, { recursive: true, force: true });

/** What a change may be seen by: all but the board's clock and the serial number. */
function lasting(state) {
  const { serial, tick, status, n, type, ...rest } = state;
  return { ...rest, seats: rest.seats.map(({ rtt_ms, ...seat }) => seat) };
}

test('a class while the store fails: every change is refused, nothing changes, and kill -9 loses nothing', async (t) => {
  const data = folder();
  let daemon = await startDaemon({ data });
  t.after(async () => {
    await daemon.kill();
    remove(data);
  });
  let c = client(daemon.url);
  const limit = (size) => execFileSync('prlimit', ['--pid', String(daemon.pid), `--fsize=${size}:unlimited`]);
  const made = (await c.call('POST', C, { body: { lesson: 'late_answer' } })).json,
    at = `${C}/${made.id}`,
    key = made.teacher_key,
    state = async () => (await c.get(at)).json.state;
  const good = async (answer, status = 200) => {
    assert.equal(answer.status, status, answer.text);
    return answer.json;
  };
  await good(await c.call('PUT', `${at}/board`, { key, body: { scenario: 'race', set: { duration_s: 60 } } }));
  await waitFor(async () => (await state()).seats.length === 2, 'the players');
  const join = async (body) => (await good(await c.call('POST', `${at}/members`, { body }), 201)).token;
  const player = await join({ role: 'play', player: 0 }),
    [watcher, voter] = [await join({ role: 'watch' }), await join({ role: 'watch' })];
  await good(await c.call('PATCH', at, { key, body: { phase: 'predict', step: 3, choices: 3 } }));
  await good(await c.call('PUT', `${at}/vote`, { key: voter, body: { step: 3, choice: 1 } }), 204);
  const stream = await openStream(daemon.url, `classes/${made.id}`);
  await waitFor(async () => (await state()).status === 'paused' && (await state()).seats[0].state !== 'free', 'the board');
  const before = lasting(await state());
  await pause(700);
  const sessions = async () => (await c.get('/metrics')).text.match(/^laglab_sessions (\d+)/m)?.[1];
  const had = await sessions();
  limit(0);
  /** @type {[string, string, any][]} */
  const changes = [
    ['PUT', '/vote', { key: watcher, body: { step: 3, choice: 2 } }],
    ['PUT', '/vote', { key: voter, body: { step: 3, choice: 2 } }],
    ['PATCH', '', { key, body: { phase: 'locked' } }],
    ['PATCH', '', { key, body: { frozen: true } }],
    ['PUT', '/board', { key, body: { scenario: 'race' } }],
    ['POST', '/members', { body: { role: 'watch' } }],
    ['POST', '/members', { body: { role: 'play', player: 1 } }],
    ['POST', '/members', { body: { role: 'copy' } }],
    ['PATCH', '/member', { key: watcher, body: { role: 'play', player: 1 } }],
    ['PATCH', '/member', { key: player, body: { role: 'watch' } }],
    ['DELETE', '/member', { key: player }],
    ['DELETE', '/members/1', { key }],
    ['DELETE', '/seats/0', { key }],
    ['PATCH', '', { key, body: { door: 'closed' } }],
    ['DELETE', '', { key }],
  ];
  const refused = await Promise.all(changes.map(([method, rest, wish]) => c.call(method, at + rest, wish)));
  for (const [i, answer] of refused.entries()) {
    assert.equal(answer.status, 507, `${changes[i][0]} ${changes[i][1]}: ${answer.status} ${answer.text}`);
    assert.match(answer.json.detail, /laglab\.db failed: disk I\/O error/);
  }
  assert.equal((await c.call('POST', C)).status, 507);
  await pause(700);
  assert.deepEqual(lasting(await state()), before, 'nothing has changed');
  assert.equal((await c.call('GET', `${at}/member`, { key: player })).json.player, 0);
  assert.equal(await sessions(), had, 'no copy or board is left');
  for (const message of stream.messages.filter((each) => each.type === 'class')) {
    assert.deepEqual(
      [message.phase, message.votes, message.frozen, message.board],
      ['predict', 1, false, before.board],
      'nor was it shown',
    );
  }
  limit('unlimited');
  await waitFor(
    async () => (await c.call('PUT', `${at}/vote`, { key: watcher, body: { step: 3, choice: 0 } })).status === 204,
    'the store to work',
  );
  await good(await c.call('PATCH', at, { key, body: { phase: 'locked' } }));
  assert.deepEqual((await state()).tally, [1, 1, 0]);
  const after = lasting(await state());
  c.close();
  await daemon.kill();
  daemon = await startDaemon({ data });
  c = client(daemon.url);
  await waitFor(async () => (await state()).seats.length === 2, 'the players are read again');
  const found = await state();
  assert.deepEqual(
    { ...lasting(found), seats: found.seats.map(({ player: number, state: how }) => [number, how]) },
    {
      ...after,
      seats: [
        [0, 'away'],
        [1, 'free'],
      ],
    },
  );
  assert.equal((await c.call('DELETE', at, { key })).status, 204);
  c.close();
});

const X = '/api/v1/experiments',
  ORDER = { scenario: 'race', set: { duration_s: 0.2 }, repeats: 20, metrics: ['players.0.own_lead_m.mean'] };
const DISKS = {
  full: { fault: 'full', cause: /full|No space left on device/ },
  'read-only': { fault: 'sealed', cause: /Read-only file system|readonly database/ },
};

/** A disk of its own; undefined where none can be made. */
function disk() {
  try {
    return makeDisk();
  } catch (error) {
    if (/mkfs|loop|mount/.test(error.message)) return undefined;
    throw error;
  }
}

for (const [name, { fault, cause }] of Object.entries(DISKS))
  for (const end of ['kill', 'stop'])
    test(`a start on a disk that is ${name}, after ${end === 'kill' ? 'kill -9' : 'SIGTERM'}: what is there is served, and it recovers`, {
      skip: process.getuid?.() !== 0 && 'mounting needs root',
    }, async (t) => {
      const own = disk();
      if (!own) return t.skip('no disk can be made here');
      const { spoil, mend } = own.faults[fault];
      let daemon = await startDaemon({ data: own.data }),
        c = client(daemon.url);
      t.after(async () => {
        c.close();
        await daemon.kill();
        own.remove();
      });
      const again = async (/** @type {'kill' | 'stop'} */ how) => {
        c.close();
        await daemon[how]();
      };
      const begin = async () => {
        daemon = await startDaemon({ data: own.data });
        c = client(daemon.url);
      };
      const session = await c.make({ paused: true });
      assert.equal((await c.patch(session, { 'players.0.lag_ms': 77 })).status, 200);
      const room = (await c.call('POST', C)).json,
        at = `${C}/${room.id}`;
      const made = (await c.call('POST', X, { body: ORDER })).json;
      await waitFor(async () => (await c.get(made.links.self)).json.state === 'done', 'the experiment');
      const rows = (await c.get(`${made.links.results}?format=csv`)).text;
      await again(/** @type {'kill' | 'stop'} */ (end));
      spoil();
      await begin();
      assert.equal((await c.get('/readyz')).status, 200);
      assert.match((await c.get('/metrics')).text, /^laglab_store_failing 1$/m);
      const log = (await c.get(session.links.log)).text;
      assert.match(log, /"players.0.lag_ms":77/);
      assert.equal((await c.get(session.links.state)).status, 200);
      assert.equal((await c.get(`${made.links.results}?format=csv`)).text, rows);
      const stream = await c.stream(session);
      await stream.wait((each) => each.type === 'hello');
      await stream.close();
      const { state } = (await c.get(at)).json;
      for (const answer of await Promise.all([
        c.patch(session, { 'players.0.lag_ms': 5 }),
        c.call('POST', '/api/v1/sessions', { body: { scenario: 'race' } }),
        c.call('DELETE', session.links.self, { key: session.owner_key }),
        c.call('POST', C),
        c.call('PATCH', at, { key: room.teacher_key, body: { phase: 'free' } }),
        c.call('DELETE', at, { key: room.teacher_key }),
        c.call('POST', X, { body: ORDER }),
        c.call('DELETE', made.links.self, { key: made.owner_key }),
      ])) {
        assert.equal(answer.status, 507, answer.text);
        assert.match(answer.json.detail, cause);
      }
      assert.equal((await c.get(session.links.log)).text, log);
      assert.equal((await c.get(at)).json.state.phase, state.phase);
      await waitFor(() => /the store of experiments fails/.test(daemon.errors()), 'the line of the log');
      mend();
      const works = async () => (await c.patch(session, { 'players.0.lag_ms': 5 })).status === 200;
      await waitFor(works, 'the store to work');
      assert.equal((await c.call('PATCH', at, { key: room.teacher_key, body: { phase: 'free' } })).status, 200);
      await waitFor(async () => /^laglab_store_failing 0$/m.test((await c.get('/metrics')).text), 'both stores');
      assert.equal((await c.call('DELETE', made.links.self, { key: made.owner_key })).status, 204);
      await waitFor(() => /the store of experiments works/.test(daemon.errors()), 'the line of the log');
      const lines = daemon
        .errors()
        .trim()
        .split('\n')
        .map((line) => JSON.parse(line))
        .filter(({ level }) => level !== 'info');
      assert.deepEqual(
        lines.map(({ msg }) => msg).sort(),
        ['the store fails', 'the store of experiments fails', 'the store of experiments works again', 'the store works again'],
        'one line when a store begins to fail, one when it works again',
      );
      assert.match(lines.find(({ msg }) => msg === 'the store fails').detail, cause);
      await again('kill');
      await begin();
      assert.match((await c.get(session.links.log)).text, /"players.0.lag_ms":5\b/);
      assert.equal((await c.get(at)).json.state.phase, 'free');
      assert.equal((await c.get(made.links.self)).status, 404);
    });

test('disks that fail at random: nothing that was acknowledged is lost, nothing that was refused is there', {
  skip: process.getuid?.() !== 0 && 'mounting needs root',
}, async (t) => {
  const told = nothing(),
    seed = 1 + Math.floor(Math.random() * 1e6);
  try {
    await Promise.all([0, 1].map((i) => failingDisk({ trials: 12, seed: seed + i, told })));
  } catch (error) {
    if (/mkfs|loop|fsfreeze|chattr/.test(error.message) && told.trials === 0) return t.skip('no disk can be made here');
    throw error;
  }
  t.diagnostic(`seeds ${seed}, ${seed + 1}: ${JSON.stringify({ ...told, findings: undefined })}`);
  assert.deepEqual(told.findings, []);
  assert.ok(told.acknowledged > 500 && told.refused > 50, 'it was a trial');
});
