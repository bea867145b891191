// Proves that page.mjs can fail: it must find exactly what is wrong with a small page.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { execPath } from 'node:process';
import { fileURLToPath } from 'node:url';
import { checkPage } from './page.mjs';

const files = {
  'src/game/games/games.h': '#define LL_GAMES(ROW) \\\n    ROW(chess) \\\n    ROW(go)\n\nint other;\n',
  'tests/structure/page_rooms.txt':
    'base:\ndraw: base\nlabs/game/core: draw\nlabs/box: draw\nempty: base\nshell: labs/box gone\n' +
    'games: labs/game\ngenerated: base/rows.js\n',
  'www/js/base/fine.js': "import { html } from '../../vendor/lit-html.js';\nexport const cargo = '../shell/main.js';\n",
  'www/js/base/rows.js': `// chess\n${'\n'.repeat(600)}// the end\n`,
  'www/js/base/above.js': "import {\n  draw,\n} from '../draw/draw.js';\n",
  'www/js/base/type.js': "/** @typedef {import('../draw/draw.js').Pen} Pen */\n",
  'www/js/draw/draw.js': "export { fine } from '../base/fine.js';\nexport const later = () => import('../labs/box/long.js');\n",
  'www/js/labs/game/core/rules.js': "import '../../../draw/draw.js';\nexport const games = ['chess', 'go'];\n",
  'www/js/labs/box/lab.js': "import { games } from '../game/core/rules.js';\nif (game === 'chess') go();\n",
  'www/js/labs/box/one.js': "import './two.js';\n",
  'www/js/labs/box/two.js': "import './three.js';\n",
  'www/js/labs/box/three.js': "export * from './one.js';\n",
  'www/js/labs/box/long.js': '\n'.repeat(500) + '// the end\n',
  'www/js/shell/main.js': "import '../labs/box/lab.js';\nimport './missing.js';\nimport '../labs/game/core/rules.js';\n",
  'www/js/attic/old.js': '',
  ...Object.fromEntries(Array.from({ length: 21 }, (_, i) => [`www/js/draw/part${i}.js`, ''])),
};
const root = mkdtempSync(join(tmpdir(), 'laglab-page-rooms-'));
for (const [name, text] of Object.entries(files)) {
  mkdirSync(dirname(join(root, name)), { recursive: true });
  writeFileSync(join(root, name), text);
}
assert.deepEqual(checkPage(root).findings, [
  'tests/structure/page_rooms.txt:1: shell: there is no room gone',
  'www/js/attic/old.js:1: attic is not one of the rooms',
  'www/js/base/above.js:1: base imports draw/draw.js, and may not use draw',
  'www/js/base/type.js:1: base imports draw/draw.js, and may not use draw',
  'www/js/draw/draw.js:2: draw imports labs/box/long.js, and may not use labs/box',
  'www/js/draw:1: 22 modules, more than 20',
  'www/js/empty:1: has no modules',
  'www/js/labs/box/lab.js:1: labs/box imports labs/game/core/rules.js, and may not use labs/game/core',
  'www/js/labs/box/lab.js:2: knows the game chess',
  'www/js/labs/box/lab.js:2: knows the game go',
  'www/js/labs/box/long.js:501: more than 500 lines',
  'www/js/labs/box/one.js:1: in a circle: labs/box/one.js, labs/box/three.js, labs/box/two.js',
  'www/js/shell/main.js:2: imports shell/missing.js, which is in no room',
  'www/js/shell/main.js:3: shell imports labs/game/core/rules.js, and may not use labs/game/core',
]);
const script = fileURLToPath(new URL('page.mjs', import.meta.url));
assert.equal(spawnSync(execPath, [script, root]).status, 1, 'the command must fail on it');
rmSync(root, { recursive: true });
console.log('the check finds what it must');
