// Proves that page_words.mjs can fail: it must find exactly what is wrong with a small page.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { execPath } from 'node:process';
import { fileURLToPath } from 'node:url';
import { checkWords } from './page_words.mjs';

const module_ = `import { html } from './Some thing';
/** A comment is no text for a person. */
const one = html\`<p class="two words" title=\${t('page.tip')}>\${x} ms</p>\`;
const two = html\`<p aria-label="Read aloud">Shown \${x}</p>\`;
notify('It did not work');
notify(\`Not \${done} because\`);
const key = event.key === 'Escape' ? t('page.gone') : t(\`page.state.\${now}\`);
document.querySelector('main table');
throw new StreamError('the bytes end too early');
throw new Error('the page ends');
`;
const files = {
  'tests/structure/page_words.txt': '# a list\nunconverted: old\ntexts: /^Escape$/\n',
  'www/words/de.json': JSON.stringify({ page: { 'page.tip': 'Bei {m}', 'page.state.a': 'A', 'page.left': 'Rest' } }),
  'www/words/en.json': JSON.stringify({ page: { 'page.tip': 'At {n}', 'page.state.a': 'A' } }),
  'www/js/shell/main.js': module_,
  'www/js/old/main.js': "notify('It did not work');\n",
};
const root = mkdtempSync(join(tmpdir(), 'laglab-page-words-'));
for (const [name, text] of Object.entries(files)) {
  mkdirSync(dirname(join(root, name)), { recursive: true });
  writeFileSync(join(root, name), text);
}
assert.deepEqual(checkWords(root).findings.sort(), [
  'www/js/shell/main.js:10: a text: "the page ends"',
  'www/js/shell/main.js:4: a text: "Read aloud"',
  'www/js/shell/main.js:4: a text: "Shown"',
  'www/js/shell/main.js:5: a text: "It did not work"',
  'www/js/shell/main.js:6: a text: "Not … because"',
  'www/js: no language has page.gone',
  'www/words/de.json: no module names page.left',
  'www/words/en.json: page.left is missing',
  'www/words/en.json: page.tip has other places than in de.json',
]);
const script = fileURLToPath(new URL('page_words.mjs', import.meta.url));
assert.equal(spawnSync(execPath, [script, root]).status, 1, 'the command must fail on it');
rmSync(root, { recursive: true });
console.log('the check finds what it must');
