// No canonical run executes more instructions than is committed in instructions.csv, by 3 %, and none of its heaviest functions more than
// in functions.csv. Who makes one dearer on purpose commits the counts with the reason: node tests/cost/cost.mjs --update CASE "WHY".
import assert from 'node:assert/strict';
import { before, test } from 'node:test';
import { by_name, cases, functions, parse, path, text_of } from './cost.mjs';
import { judge, raised_silently, text_before } from './guard.mjs';
import { build, measure } from './profile.mjs';

const committed = functions();
before(build);

for (const c of cases())
  test(`${c.case}: instructions per step`, async (t) => {
    const now = await measure(c),
      then = c.instructions_per_step;
    t.diagnostic(`${then} committed, ${now.total} now (${(100 * (now.total / then - 1)).toFixed(2)} %)`);
    assert.ok(then > 0 && now.total > 0);
    const { failures, notes } = judge(
      c,
      committed.filter((f) => f.case === c.case),
      now,
    );
    for (const note of notes) t.diagnostic(note);
    assert.ok(!failures.length, failures.join('\n'));
  });

for (const name of /** @type {const} */ (['instructions.csv', 'functions.csv']))
  test(`${name}: a count that rose has a new reason`, (t) => {
    const text = text_of(name),
      before = text_before(path(name), text);
    const head = (/** @type {string} */ table) => table.split('\n')[0];
    if (before === null || head(before) !== head(text)) return t.diagnostic('there is no earlier version');
    assert.deepEqual(raised_silently(by_name(name, parse(name, before)), by_name(name, parse(name, text))), []);
  });
