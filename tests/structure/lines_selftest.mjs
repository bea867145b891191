// Proves that lines.mjs can fail: it must find exactly the long and the too new lines of a small tree.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { execPath } from 'node:process';
import { fileURLToPath } from 'node:url';
import { checkLines } from './lines.mjs';

const long = 'x'.repeat(141);
const files = {
  'tests/structure/page_rooms.txt': 'base:\ngames: base\ngenerated: base/rows.js\n',
  'tests/api/long.test.mjs': `// ${'x'.repeat(137)}\n// ${'x'.repeat(138)}\n`,
  'www/js/base/view.js': `html\`\n${'–'.repeat(140)}\n${long}\n\`;\n`,
  'www/js/base/rows.js': long,
  'www/vendor/large.js': long,
  'docs/sorted.mjs': ['list', 'toSorted()'].join('.'),
  'bench/node_modules/large.js': long,
  'docs/page.md': long,
};
const root = mkdtempSync(join(tmpdir(), 'laglab-lines-'));
for (const [name, text] of Object.entries(files)) {
  mkdirSync(dirname(join(root, name)), { recursive: true });
  writeFileSync(join(root, name), text);
}
assert.deepEqual(checkLines(root), {
  findings: [
    `docs/sorted.mjs:1: .${'toSorted'}(, which Node 18 has not`,
    'tests/api/long.test.mjs:2: 141 columns, more than 140',
    'www/js/base/view.js:3: 141 columns, more than 140',
  ],
  files: 3,
});
const script = fileURLToPath(new URL('lines.mjs', import.meta.url));
assert.equal(spawnSync(execPath, [script, root]).status, 1, 'the command must fail on it');
rmSync(root, { recursive: true });
console.log('the check finds what it must');
