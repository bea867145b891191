// Proves that near.mjs can fail: it must find exactly the comparisons that NaN passes.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { execPath } from 'node:process';
import { fileURLToPath } from 'node:url';
import { checkNear } from './near.mjs';

const wrong = [
  'if (fabs(got - want) > limit) fail_msg("off");',
  'if (fabs(got - want) > 0.5)\n        fail();',
  'if (count > 3 || got - want > 1e-3) { fail_msg("off"); }',
  'if (error > 2e-9)\n        fail_msg("off");',
  'if (!(error < 1) || error < 0) fail_msg("off");',
  'assert_false(error > known->off);',
  'worst = fmax(worst, got);',
  'least = fminf(least, got);',
  'worst = error > worst ? error : worst;',
  'worst = worst < error ? error : worst;',
  'if (error > worst)\n        worst = error;',
];
const right = [
  'if (!(fabs(got - want) <= limit)) fail_msg("off");',
  'if (!is_near(got, want, a <= 2 ? 0.1 : 0.2)) fail_msg("off");',
  'if (count > limit_packets) fail_msg("%d", count);',
  'if (error > worst) break;',
  'assert_false(count > 3);',
  'assert_true(error < worst);',
  'count = most > count ? most : count;',
  '/* if (error > worst) fail(); */ print_message("if (error > 1.5) fail(");',
  'if (s->error != other) fail_msg("0.5");',
];
const head = 'static void f(double got, const double *want)\n{\n    double error = 0, worst, least;\n    int count = 0, most = 0;';
const text = (/** @type {string[]} */ lines) => `${head}\n${lines.join('\n')}\n}\n`;
const root = mkdtempSync(join(tmpdir(), 'laglab-near-'));
mkdirSync(join(root, 'tests/support'), { recursive: true });
writeFileSync(join(root, 'tests/support/near.c'), text(wrong));
writeFileSync(join(root, 'tests/right.h'), text(right));
assert.deepEqual(checkNear(root), { findings: [], files: 1 });
for (const one of wrong) {
  writeFileSync(join(root, 'tests/wrong.c'), text([one]));
  assert.equal(checkNear(root).findings.length, 1, one);
  assert.match(checkNear(root).findings[0], /^tests\/wrong\.c:5: /);
}
const script = fileURLToPath(new URL('near.mjs', import.meta.url));
assert.equal(spawnSync(execPath, [script, root]).status, 1, 'the command must fail on it');
rmSync(root, { recursive: true });
console.log('the check finds what it must');
