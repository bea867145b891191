// kill -9 at twenty random moments under load, in two chains (tests/lib/kills.mjs; a thousand: `bench/run kills`), and what a clean stop
// keeps.
import assert from 'node:assert/strict';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { test } from 'node:test';
import { client, waitFor } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';
import { chain, nothing } from '../lib/kills.mjs';

/** A daemon that is stopped at the end of the test, also when it fails. */
const start = async (t, wish) => {
  const daemon = await startDaemon(wish);
  t.after(() => daemon.stop());
  return daemon;
};

const KILLS = 20;

test(`kill -9 at ${KILLS} random moments under load`, { timeout: 300000 }, async (t) => {
  const seed = Number(process.env.LAGLAB_TEST_SEED ?? Date.now() % 1e6),
    told = nothing();
  t.diagnostic(`LAGLAB_TEST_SEED=${seed}`);
  await Promise.all([seed, seed + 1].map((each) => chain({ kills: KILLS / 2, seed: each, told })));
  t.diagnostic(
    `${told.acknowledged} acknowledged, of which after restarts ${told.commands} commands and ${told.hashes} hashes were found again`,
  );
  assert.deepEqual(told.findings, []);
  assert.deepEqual([told.kills, told.lost, told.resurrected, told.differ], [KILLS, 0, 0, 0]);
  assert.ok(told.commands > 500 && told.hashes > 200);
});

test('a clean stop keeps the tick of a paused session and the play of a playing one', async (t) => {
  const data = mkdtempSync(path.join(tmpdir(), 'laglab-test-'));
  try {
    let daemon = await start(t, { data }),
      c = client(daemon.url);
    const paused = await c.make({ paused: true }),
      playing = await c.make({ speed: 2 });
    const { json: at } = await c.control(paused, { op: 'seek', tick: 123 });
    await c.control(paused, { op: 'seek', tick: 45 });
    await waitFor(async () => (await c.get(playing.links.self)).json.tick > 0, 'it to play');
    const { json: before } = await c.get(playing.links.self);
    c.close();
    await daemon.stop();
    daemon = await start(t, { data });
    c = client(daemon.url);
    const { json: one } = await c.get(paused.links.self),
      { json: two } = await c.get(playing.links.self);
    assert.deepEqual([one.status, one.tick, one.head_tick], ['paused', 45, 123]);
    assert.equal((await c.get(`${paused.links.state}?tick=123`)).json.hash, at.hash);
    assert.deepEqual([two.status, two.speed], ['playing', 2]);
    assert.ok(two.tick >= before.tick, 'it went on');
    assert.equal((await c.get(`/api/v1/codes/${paused.code}`)).json.id, paused.id);
    c.close();
    await daemon.stop();
  } finally {
    rmSync(data, { recursive: true, force: true });
  }
});
