// libwebsockets loads its event loop by name: without that package the daemon says which one is missing, and ends.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { noMounts, OWN_MOUNTS } from '../lib/mounts.mjs';

const WITHOUT = [
  ...OWN_MOUNTS,
  'sh',
  '-c',
  'for f in /usr/lib/*/libwebsockets-evlib_ev.so; do mount --bind /dev/null $f || exit 9; done; exec "$@"',
  'sh',
];

test('a start without the plug-in of libwebsockets names its package', { skip: noMounts() }, async () => {
  await assert.rejects(startDaemon({ before: WITHOUT }), (/** @type {Error} */ error) => {
    assert.match(error.message, /the daemon ended with 1: .*Debian's package libwebsockets-evlib-ev/s);
    return true;
  });
  const daemon = await startDaemon({ before: OWN_MOUNTS });
  await daemon.stop();
});
