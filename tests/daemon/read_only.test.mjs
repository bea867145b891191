// With a read-only file system, except for the daemon's own folder or none, every result, report and trace is answered.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { mkdtempSync, readdirSync, rmSync } from 'node:fs';
import path from 'node:path';
import { client, waitFor } from '../lib/client.mjs';
import { BINARY, startDaemon } from '../lib/daemon.mjs';
import { noMounts, OWN_MOUNTS } from '../lib/mounts.mjs';

const X = '/api/v1/experiments';
/* As a container with a read-only root has it. */
const SEALED = [
  ...OWN_MOUNTS,
  'sh',
  '-c',
  'for d in /tmp /var/tmp /dev/shm; do mount -t tmpfs -o ro none $d || exit 9; done; exec "$@"',
  'sh',
];

const skip = noMounts() || (/^\/(var\/)?tmp\//.test(BINARY) && `${BINARY} is in a folder that is to be sealed`);

async function ask(data) {
  const daemon = await startDaemon({ data, before: SEALED }),
    c = client(daemon.url);
  try {
    const order = { scenario: 'race', set: { duration_s: 0.5 }, repeats: 30, metrics: ['players.0.input_latency_ms.mean'] };
    const { id } = (await c.call('POST', X, { body: order })).json;
    await waitFor(async () => (await c.get(`${X}/${id}`)).json.state === 'done', 'the experiment', 60000);
    for (const format of ['csv', 'ndjson', 'json', 'sqlite']) {
      const answer = await c.get(`${X}/${id}/results?format=${format}`);
      assert.equal(answer.status, 200, `${format}: ${answer.text.slice(0, 300)}`);
      assert.ok(answer.text.length > 300, format);
      if (format === 'sqlite') assert.match(answer.text, /^SQLite format 3/);
      if (format === 'csv') assert.equal(answer.text.trim().split('\r\n').length, 31);
    }
    for (const part of ['report', 'runs/3/trace', 'runs/3/trace?of=packets&format=sqlite']) {
      const answer = await c.get(`${X}/${id}/${part}`);
      assert.equal(answer.status, 200, `${part}: ${answer.text.slice(0, 300)}`);
      assert.ok(answer.text.length > 1000, part);
    }
  } finally {
    c.close();
    await daemon.stop();
  }
}

test('with a folder of its own alone', { skip }, async () => {
  const data = mkdtempSync(path.join(path.dirname(BINARY), 'read-only-'));
  try {
    await ask(data);
    assert.deepEqual(
      readdirSync(data).filter((name) => !/^(laglab|experiments)\.db|^lock$/.test(name)),
      [],
      'nothing is left there',
    );
  } finally {
    rmSync(data, { recursive: true, force: true });
  }
});

test('with nothing', { skip }, async () => ask('memory'));
