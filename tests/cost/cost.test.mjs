// No canonical run executes more instructions than is committed in instructions.csv, by 3 %. Who makes one dearer on purpose commits the
// count with the reason: node tests/cost/cost.mjs --update CASE "WHY".
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { cases, measure, RISE } from './cost.mjs';

for (const c of cases())
  test(`${c.case}: instructions per step`, async (t) => {
    const now = await measure(c),
      then = c.instructions_per_step,
      rise = now / then - 1;
    t.diagnostic(`${then} committed, ${now} now (${(100 * rise).toFixed(2)} %)`);
    assert.ok(then > 0 && now > 0);
    assert.ok(rise <= RISE, `${now} instructions per step, ${(100 * rise).toFixed(1)} % more than the ${then} committed (${c.why})`);
  });
