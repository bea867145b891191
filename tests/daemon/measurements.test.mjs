// Measurements of speed against error outlive the daemon: finished ones as they were, one in progress with the rows that it had, and the
// reason.
import assert from 'node:assert/strict';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { test } from 'node:test';
import { client, waitFor } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';

const T = '/api/v1/tradeoffs';

/** A folder, and a daemon on it, which ends with the test. @param {any} t */
function place(t) {
  const data = mkdtempSync(path.join(tmpdir(), 'laglab-test-'));
  /** @type {any} */ let daemon = null;
  /** @type {any} */ let c = null;
  t.after(async () => {
    c?.close();
    await daemon?.kill();
    rmSync(data, { recursive: true, force: true });
  });
  return async () => {
    c?.close();
    daemon = await startDaemon({ data });
    c = client(daemon.url);
    return { daemon, c };
  };
}

/** @param {any} c @param {any} body */
async function start(c, body) {
  const { status, json, text } = await c.call('POST', T, { body });
  assert.equal(status, 202, text);
  return json;
}

/** @param {any} c @param {string} family */
const newest = async (c, family) => (await c.get(T)).json.families.find((/** @type {any} */ one) => one.name === family).results.job;

for (const [how, name] of /** @type {const} */ ([
  ['kill', 'kill -9'],
  ['stop', 'SIGTERM'],
]))
  test(`measurements outlive ${name}`, async (t) => {
    const begin = place(t);
    let { daemon, c } = await begin();
    const short = await start(c, { family: 'lag_compensation', methods: ['rewind'], duration_s: 1, seeds: 10 });
    const finished = await waitFor(async () => {
      const { json } = await c.get(short.links.self);
      return json.state === 'done' && json;
    }, 'the end of the short one');
    /* stored every two seconds */
    const long = await start(c, { family: 'particles', methods: ['pbf', 'dfsph'] });
    const before = await waitFor(
      async () => {
        const { json } = await c.get(long.links.self);
        assert.equal(json.state, 'running');
        return json.answer?.rows.length >= 3 && json.done >= 3 && Date.now() - Date.parse(json.date) > 5000 && json;
      },
      'rows of the long one',
      60000,
    );
    await daemon[how]();

    ({ daemon, c } = await begin());
    assert.deepEqual((await c.get(short.links.self)).json, finished);
    assert.deepEqual([await newest(c, 'lag_compensation'), await newest(c, 'particles')], [short.id, long.id]);
    const after = (await c.get(long.links.self)).json;
    assert.equal(after.state, 'failed');
    assert.match(after.error, new RegExp(`^The daemon ended: interrupted after ${after.done} of ${before.steps} settings\\.$`));
    assert.ok(after.done > 0 && after.done < before.steps && after.answer.rows.length > 0, `${after.done}`);
    const known = new Map(before.answer.rows.map((/** @type {any} */ row) => [row.link, row.error]));
    assert.ok(after.answer.rows.some((/** @type {any} */ row) => known.has(row.link)));
    for (const row of after.answer.rows) if (known.has(row.link)) assert.deepEqual(row.error, known.get(row.link));

    assert.equal((await c.call('DELETE', long.links.self, { key: short.owner_key })).status, 403);
    assert.equal((await c.call('DELETE', long.links.self, { key: long.owner_key })).status, 204);
    assert.equal(await newest(c, 'particles'), null);
    const next = await start(c, { family: 'lag_compensation', methods: ['rewind'], duration_s: 1.5, seeds: 10 });
    await waitFor(async () => (await c.get(next.links.self)).json.state === 'done', 'the end of the next one');
    await daemon[how]();

    ({ daemon, c } = await begin());
    assert.deepEqual([await newest(c, 'lag_compensation'), await newest(c, 'particles')], [next.id, null]);
    assert.equal((await c.get(short.links.self)).status, 404, 'the next one took its place');
  });
