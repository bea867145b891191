// Proves that guides.mjs can fail: it must find exactly what is wrong with a small tree.
import assert from 'node:assert/strict';
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { checkGuides } from './guides.mjs';

const root = mkdtempSync(join(tmpdir(), 'laglab-guides-'));
const files = {
  'src/base/one.h': 'int ll_one(void);',
  'src/base/two.h': '',
  'src/game/race/race.c': 'int ll_race(void);',
  'src/game/dam/dam.c': '',
  'src/base/README.md': '# base\n- `one.h`: `ll_one`\n- `gone.h`: `ll_gone`\n',
  'src/game/README.md': `# game\n- \`race\`: \`race.c\`, \`src/missing/\`\n${'line\n'.repeat(30)}`,
  'tests/structure/rooms.txt': 'base:\ngame/race: base\ngame/dam: base\n',
  'tests/structure/page_rooms.txt': 'base:\nshell: base\n',
  'www/js/base/one.js': '',
  'ARCHITECTURE.md':
    '`base`, `game/race`, `www/js/base`: `src/base/one.h`, `ll_NAME` in `src/game/NAME.c`, `build/written.json`\n' +
    '```\n`src/in_a_block.c`\n```\n',
};
for (const [name, text] of Object.entries(files)) {
  mkdirSync(dirname(join(root, name)), { recursive: true });
  writeFileSync(join(root, name), text);
}
assert.deepEqual(checkGuides(root).sort(), [
  'ARCHITECTURE.md:1: does not name the room game/dam',
  'ARCHITECTURE.md:1: does not name the room www/js/shell',
  'CONTRIBUTING.md: is missing',
  'src/base/README.md:1: does not name two.h',
  'src/base/README.md:3: ll_gone is not in src',
  'src/base/README.md:3: there is no file gone.h',
  'src/game/README.md:1: does not name dam',
  'src/game/README.md:2: there is no src/missing/',
  'src/game/README.md:32: more than 30 lines',
]);
rmSync(root, { recursive: true });
console.log('the check finds what it must');
