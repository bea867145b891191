// Streams through nginx and HAProxy, whose upgrades arrive on connections that the daemon has kept since earlier requests.
import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { client } from '../lib/client.mjs';
import { plain, publicProxy } from '../lib/public.mjs';
import { names } from '../../bench/proxies/proxies.mjs';
import { bridged, upgradesOnKept } from '../../bench/proxies/upgrades.mjs';

const COUNT = 100; // as many again on a larger scale: bench/run proxies

// Each has a daemon of its own, and mostly waits: side by side.
describe('upgrades', { concurrency: names.length }, () => {
  for (const name of names) {
    test(`${COUNT} of ${COUNT} upgrades on kept connections stream through ${name}`, async (t) => {
      const daemon = await startDaemon();
      t.after(() => daemon.stop());
      const http = client(daemon.url);
      t.after(() => http.close());
      const session = await http.make({ set: { duration_s: 3600 } });
      const proxy = await publicProxy(name, daemon.port, plain);
      t.after(() => proxy.stop());
      const before = await bridged(daemon.url);
      // Only those on kept connections count: the test is about them. A proxy that finds no idle connection opens another, so a few more
      // may be needed.
      let kept = 0;
      for (let round = 0; kept < COUNT && round < 3; round++) {
        const { ok, failures } = await upgradesOnKept(proxy.url, session, COUNT - kept);
        assert.deepEqual(failures, {});
        assert.equal(ok, COUNT - kept);
        kept = (await bridged(daemon.url)) - before;
      }
      assert.equal(kept, COUNT, 'came on kept connections');
    });
  }
});
