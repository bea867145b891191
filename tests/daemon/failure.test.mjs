// A failed session is the same failure live, in its log, as a fork, after a restart and in a replay, and the replay exits with 1.
// A replay compares the hashes in the log.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { spawnSync } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { client } from '../lib/client.mjs';
import { BINARY, startDaemon } from '../lib/daemon.mjs';

const S = (session, rest = '') => `/api/v1/sessions/${session.id}${rest}`;
const DROP = { kind: 'fluid', scene: 'drop', duration_s: 3, solver: { method: 'dfsph', relaxation: 0.4 } };

let data, daemon, c;

before(async () => {
  data = mkdtempSync(path.join(tmpdir(), 'laglab-failure-'));
  daemon = await startDaemon({ data });
  c = client(daemon.url);
});
after(async () => {
  c.close();
  await daemon.stop();
  rmSync(data, { recursive: true, force: true });
});

const replay = (log) => {
  const { status, stdout, stderr } = spawnSync(BINARY, ['replay', '-'], { input: log });
  return { status, said: stderr.toString(), result: JSON.parse(stdout.toString() || 'null') };
};

async function seen(session) {
  const { status, tick, head_tick, error } = (await c.get(S(session))).json;
  return { status, tick, head_tick, error, hash: (await c.get(S(session, '/state'))).json.hash };
}

test('a failure is the same wherever it is read', async () => {
  const session = await c.make({ scenario: DROP, paused: true });
  assert.equal((await c.control(session, { op: 'seek', tick: 7 })).json.tick, 7);
  assert.equal((await c.patch(session, { solver: { relaxation: 1.4 } })).status, 200);
  assert.equal((await c.control(session, { op: 'seek', tick: 150 })).json.status, 'failed');
  const live = await seen(session);
  assert.equal(live.status, 'failed');
  assert.ok(live.tick >= 7 && live.tick < 150, String(live.tick));
  assert.match(live.error.detail, /CFL|finite/);

  const fork = (await c.call('POST', S(session, '/fork'), { body: {} })).json;
  assert.deepEqual(await seen(fork), live);

  const log = (await c.get(S(session, '/log'))).text,
    again = replay(log);
  assert.equal(again.status, 1);
  assert.equal(again.result.hash, live.hash);
  assert.ok(again.result.compared >= 1, `${again.result.compared} hashes were compared`);
  assert.match(again.said, new RegExp(`failure after tick ${live.tick}, as in the log`));
  const other = replay(log.replace(`"hash":"${live.hash}"`, '"hash":"0123456789abcdef"'));
  assert.equal(other.status, 1);
  assert.match(other.said, /0123456789abcdef/);

  c.close();
  await daemon.stop();
  daemon = await startDaemon({ data });
  c = client(daemon.url);
  assert.deepEqual(await seen(session), live, 'after a restart');
  assert.deepEqual(await seen(fork), live, 'the fork, after a restart');
  assert.equal((await c.control(session, { op: 'play' })).status, 409);
  assert.equal((await c.control(session, { op: 'seek', tick: 3 })).json.status, 'paused');
  assert.equal((await c.control(session, { op: 'seek', tick: 99 })).json.status, 'failed');
  assert.deepEqual(await seen(session), live, 'played again');
});

test('the log of a live session has the version of laglab, and its replay compares hashes', async () => {
  const session = await c.make({ scenario: 'race', paused: true });
  for (let i = 1; i <= 3; i++) {
    await c.control(session, { op: 'step', ticks: 40 + i });
    await c.patch(session, { players: { 1: { lag_ms: 30 * i } } });
  }
  await c.control(session, { op: 'step', ticks: 25 });
  const log = (await c.get(S(session, '/log'))).text,
    lines = log
      .trim()
      .split('\n')
      .map((line) => JSON.parse(line));
  assert.match(lines[0].version, /^\d+\.\d+\.\d+\+/);
  const good = replay(log),
    hash = (await c.get(S(session, '/state'))).json.hash;
  assert.equal(good.status, 0, good.said);
  assert.ok(good.result.compared >= 1);
  assert.equal(good.result.hash, hash);
  const changed = replay(log.replace('lag_ms":60', 'lag_ms":61'));
  assert.equal(changed.status, 1);
  assert.match(changed.said, /differs/);
});
