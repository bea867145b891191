// The command line with every scenario and every parameter; cli.test.mjs has one of each kind.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { checkBadValues, checkRepeats, ids } from '../lib/cli.mjs';

test('every scenario runs, has the same bytes each time, and its log replays to its hash', () => {
  assert.ok(ids().length > 100);
  for (const id of ids()) {
    checkRepeats(id);
    checkRepeats(id, ['--duration', '3']); // with the seed of the scenario
  }
});

test('every parameter refuses bad values by name and range', async () => {
  const values = await checkBadValues(true);
  assert.ok(values > 300, `${values} values`);
});
