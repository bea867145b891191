// Streams through nginx and HAProxy, whose upgrades arrive on connections that the daemon has kept since earlier requests.
import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { client } from '../lib/client.mjs';
import { names, startProxy } from '../../bench/proxies/proxies.mjs';
import { bridged, upgradesOnKept } from '../../bench/proxies/upgrades.mjs';

const COUNT = 200;

// Each has a daemon of its own, and mostly waits: side by side.
describe('upgrades', { concurrency: names.length }, () => {
  for (const name of names) {
    test(`${COUNT} of ${COUNT} upgrades on kept connections stream through ${name}`, async (t) => {
      const daemon = await startDaemon();
      t.after(() => daemon.stop());
      const http = client(daemon.url);
      t.after(() => http.close());
      const session = await http.make({ set: { duration_s: 3600 } });
      const proxy = await startProxy(name, daemon.port);
      t.after(() => proxy.stop());
      const before = await bridged(daemon.url);
      const { ok, failures } = await upgradesOnKept(proxy.url, session, COUNT);
      assert.deepEqual(failures, {});
      assert.equal(ok, COUNT);
      /* Otherwise the test would pass without having tried what it is about. A proxy opens another where it finds no idle one. */
      const kept = (await bridged(daemon.url)) - before;
      assert.ok(kept >= 0.9 * COUNT, `${kept} came on kept connections`);
    });
  }
});
