// Requests that two parsers could read differently, through the proxies of deploy/: proxy and daemon see the same ones.
import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { names } from '../../bench/proxies/proxies.mjs';
import { startDaemon } from '../lib/daemon.mjs';
import { NAME } from '../lib/public.mjs';
import { damaged, disagreement, smuggle } from '../lib/smuggled.mjs';
import { REQUESTS } from './smuggling.mjs';

const SEED = 3,
  DAMAGED = 300;
const table = REQUESTS.map(([name, bytes]) => /** @type {[string, string]} */ ([name, bytes]));

describe('proxies', { concurrency: names.length }, () => {
  for (const kind of names)
    test(`the daemon and ${kind} agree where each request ends`, async (t) => {
      const daemon = await startDaemon({
        args: ['--trusted-proxy', '127.0.0.1', '--allow-host', NAME, '--max-new-sessions-per-min', '1000000'],
      });
      t.after(() => daemon.stop());
      const { sent, passed, wrong } = await smuggle(kind, daemon, [...table, ...damaged(table, SEED, DAMAGED)]);
      assert.deepEqual(wrong, []);
      assert.ok(sent > 2 * table.length && passed > sent / 4, `${passed} of ${sent} requests reached the daemon`);
    });
});

test('a disagreement is found', () => {
  const asked = (/** @type {string[]} */ ...ids) => ids.map((id) => `GET / HTTP/1.1\r\nx-request-id: ${id}\r\n\r\n`).join('');
  const answer = (/** @type {number} */ status, id = '', more = '') =>
      `HTTP/1.1 ${status} X\r\n${id && `X-Request-Id: ${id}\r\n`}${more}\r\n`,
    refused = answer(400, '', 'Connection: close\r\n');
  const agree = (/** @type {string} */ a, /** @type {string} */ b) => disagreement({ asked: a, answered: b }) === undefined;
  assert.ok(agree(asked('a', 'b'), answer(200, 'a') + answer(404, 'b')));
  assert.ok(agree(asked('a', 'b'), answer(200, 'a')), 'a client that left');
  assert.ok(agree(asked('a', 'b'), answer(200, 'a') + refused), 'a refusal before the head was read');
  assert.ok(agree(asked('a'), refused + refused), 'what follows the last answer');
  assert.ok(agree(asked('a'), answer(100) + answer(200, 'a')));
  assert.ok(!agree(asked('a', 'b'), answer(200, 'a') + answer(200, 'hidden') + answer(200, 'b')));
  assert.ok(!agree(asked('a'), answer(200, 'a') + refused), 'more answers than requests');
  assert.ok(!agree(asked('a', 'b'), answer(400) + answer(200, 'b')), 'a refusal that is not the last');
  assert.ok(!agree(asked('a', 'b'), answer(413) + answer(413)), 'a head that is sent twice');
  assert.ok(!agree(asked('a', 'b'), answer(200, 'b')));
});
