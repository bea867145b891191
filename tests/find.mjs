// Which tests are those of a room, a folder, a file or a name: node tests/find.mjs [--all] NAME...
//   Prints lines as `target tests_link`, `ctest ^link\.` (a regular expression of ctest's names) and `node tests/page/time.test.mjs`.
//   A name is a room (link), a folder in one (netcode/client), a file or folder of src, whose tests are those of its folder or, where it
//   has none, of the room above or from outside (OUTSIDE of mutate.mjs), a file of tests, or what ctest calls a test (link.delay,
//   oracle.netgame).
//   --all: also files of the tier all (NAME.all.test.mjs), which are otherwise found only by their own name.
import { existsSync, readdirSync, readFileSync, statSync } from 'node:fs';
import { basename, dirname, relative } from 'node:path';
import { argv } from 'node:process';
import { fileURLToPath } from 'node:url';
import { OUTSIDE } from './mutate.mjs';

const SCRIPTS = ['structure', 'oracle']; // rooms of ctest whose tests are scripts
const IN_C = /(?:^|\/)(?:test|fuzz)_(\w+)\.c$/;

const testFiles = () =>
  readdirSync('tests', { recursive: true, encoding: 'utf8' })
    .filter((name) => (IN_C.test(name) || /^\w+\/[\w.]+\.test\.mjs$/.test(name)) && !name.includes('fixture/'))
    .map((name) => `tests/${name}`)
    .sort();

/** Whether ctest has a test of this name that is no file. @param {string} name */
const isScript = (name) =>
  (/^\w+\.\w+$/.test(name) &&
    readFileSync('cmake/tests.cmake', 'utf8')
      .split(/[^\w.]+/)
      .includes(name)) ||
  existsSync(`tests/oracle/found/${name.replace(/^oracle\./, '')}.json`);

/** Tests from outside of a place of src that has none inside, by the nearest folder. @param {string} place */
function fromOutside(place) {
  for (let folder = place; folder !== '.'; folder = dirname(folder))
    if (folder in OUTSIDE) return OUTSIDE[folder].map((name) => `tests/${name}.test.mjs`);
  return [];
}

/** @param {string[]} names @param {boolean} [tier_all] @returns {string[]} lines as above */
export function findTests(names, tier_all = false) {
  const all = testFiles();
  const inside = (folder) => all.filter((file) => file.startsWith(`${folder}/`));
  const rooms = [...new Set([...all.map((file) => file.split('/')[1]), ...SCRIPTS])].sort();
  const lines = names.flatMap((given) => {
    const name = relative('.', given);
    let files = all.filter((file) => file === name || (IN_C.test(file) && `${file.split('/')[1]}.${IN_C.exec(file)[1]}` === name));
    let folder = name.startsWith('tests/') ? name : `tests/${name}`;
    if (name.startsWith('src/') && existsSync(name)) {
      folder = `tests/${name.slice(4)}`;
      if (statSync(name).isFile()) folder = dirname(folder);
      while (inside(folder).length === 0 && dirname(folder) !== 'tests' && folder !== 'tests') folder = dirname(folder);
    }
    const room = basename(folder);
    const whole = folder === `tests/${room}` && rooms.includes(room) && files.length === 0;
    if (files.length === 0 && folder !== 'tests') files = inside(folder).filter((file) => tier_all || !file.endsWith('.all.test.mjs'));
    const top = name.split('.')[0];
    if (files.length === 0 && rooms.includes(top) && isScript(name))
      return [`target ${SCRIPTS.includes(top) ? 'laglab' : `tests_${top}`}`, `ctest ^${name.replace('.', '\\.')}$`];
    if (files.length === 0 && name.startsWith('src/') && existsSync(name)) files = fromOutside(name.slice(4));
    if (files.length === 0 && !(whole && SCRIPTS.includes(room)))
      throw new Error(
        `no tests of ${given}. Rooms: ${rooms.join(' ')}; or a folder in one (netcode/client), a file of src or tests, link.delay`,
      );
    const programs = files.filter((file) => IN_C.test(file)).map((file) => ({ top: file.split('/')[1], test: IN_C.exec(file)[1] }));
    return [
      ...(whole && SCRIPTS.includes(room) ? ['target laglab'] : []),
      ...programs.map(({ top }) => `target tests_${top}`),
      // golden.golden is two, golden.golden_1 and golden.golden_2: without parentheses, of which ctest takes few. A whole room has
      // scripts, too, such as golden.aarch64.
      ...(whole && (programs.length > 0 || SCRIPTS.includes(room)) ? [`ctest ^${room}\\.`] : []),
      ...(whole ? [] : programs.map(({ top, test }) => `ctest ^${top}\\.${test}_?[0-9]?$`)),
      ...files.filter((file) => !IN_C.test(file)).map((file) => `node ${file}`),
    ];
  });
  return [...new Set(lines)];
}

if (argv[1] === fileURLToPath(import.meta.url)) {
  try {
    const names = argv.slice(2);
    const tier_all = names[0] === '--all';
    console.log(findTests(tier_all ? names.slice(1) : names, tier_all).join('\n'));
  } catch (error) {
    console.error(`dev: ${error instanceof Error ? error.message : error}`);
    process.exitCode = 2;
  }
}
