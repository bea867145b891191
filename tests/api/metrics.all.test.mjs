// The metrics of every scenario; metrics.test.mjs has some.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { test } from 'node:test';
import { ids, scenario } from '../lib/cli.mjs';
import { BINARY } from '../lib/daemon.mjs';
import { checkMetrics } from '../lib/metrics.mjs';

test('each metric of every scenario is a row, and every row is a metric of one', async () => {
  const rows = JSON.parse(execFileSync(BINARY, ['schema', 'metrics'], { encoding: 'utf8' }));
  const scenarios = ids().map((id) => ({ id, kind: scenario(id).kind }));
  assert.ok(scenarios.length > 100);
  assert.ok((await checkMetrics(scenarios, rows, true)) > scenarios.length);
});
