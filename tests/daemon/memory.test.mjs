// What a busy time needed is not kept after it: of the memory that the C library holds for the daemon, little is free once the sessions are
// gone.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { client, pause } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';

const MIB = 2 ** 20,
  MOST_FREE_MIB = 12,
  MOST_GROWTH_MIB = 1;
const SCENARIOS = ['race', 'eight', 'rigid/pyramid', { kind: 'fluid', scene: 'pool', params: { size: 40 }, duration_s: 60 }];

/** A session with viewers, which is forked, read and deleted. */
async function visit(c, scenario) {
  const session = await c.make({ scenario, paused: true });
  const viewers = [await c.stream(session, 'bin', { ack: true }), await c.stream(session, 'json', { ack: true })];
  await c.control(session, { op: 'seek', time_s: 1 });
  await c.control(session, { op: 'play' });
  await pause(300);
  const fork = await c.call('POST', session.links.fork, { body: {} });
  for (const link of [session.links.state, session.links.metrics, session.links.trace]) await c.get(link);
  if (fork.status === 201) await c.call('DELETE', fork.json.links.self, { key: fork.json.owner_key });
  for (const viewer of viewers) viewer.socket.terminate();
  assert.equal((await c.call('DELETE', session.links.self, { key: session.owner_key })).status, 204);
}

test('memory that sessions needed is returned when they are gone', { timeout: 300000 }, async (t) => {
  const daemon = await startDaemon({ args: ['--max-new-sessions-per-min', '100000'] });
  t.after(() => daemon.stop());
  const c = client(daemon.url);
  t.after(() => c.close());
  const gauge = async (name) => Number(new RegExp(`^laglab_heap_${name}_bytes (.+)$`, 'm').exec((await c.get('/metrics')).text)[1]) / MIB;
  const rest = async () => {
    await pause(1000); // streams and tasks have released their sessions
    return { used: await gauge('used'), kept: await gauge('kept') };
  };
  const rests = [];
  for (let round = 0; round < 3; round++) {
    await Promise.all(
      Array.from({ length: 12 }, async (_, i) => {
        for (let n = 0; n < 3; n++) await visit(c, SCENARIOS[(i + n) % SCENARIOS.length]);
      }),
    );
    rests.push(await rest());
  }
  t.diagnostic(rests.map(({ used, kept }) => `${used.toFixed(2)} MiB used of ${kept.toFixed(2)}`).join(', '));
  for (const { used, kept } of rests) assert.ok(kept - used < MOST_FREE_MIB, `${(kept - used).toFixed(1)} MiB are kept and free`);
  assert.ok(rests[2].used - rests[0].used < MOST_GROWTH_MIB, `${(rests[2].used - rests[0].used).toFixed(2)} MiB more are used`);
});
