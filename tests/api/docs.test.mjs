// What the documents say: generated files are fresh, scenarios fit the schema, commands run, links lead somewhere.
// Commands are those of the blocks marked `sh`; blocks marked `console` are shown only.
import assert from 'node:assert/strict';
import { execFile, execFileSync } from 'node:child_process';
import {
  cpSync,
  existsSync,
  mkdirSync,
  mkdtempSync,
  readFileSync,
  readdirSync,
  rmSync,
  statSync,
  symlinkSync,
  writeFileSync,
} from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { promisify } from 'node:util';
import Ajv from 'ajv/dist/2020.js';
import { ages } from '../../bench/ages.mjs';
import { roomsOf } from '../../bench/rooms.mjs';
import { anchor, generate, parseCsv } from '../../docs/generate.mjs';
import { BINARY, startDaemon } from '../lib/daemon.mjs';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
const read = (name) => readFileSync(path.join(ROOT, name), 'utf8');
const DOCUMENTS = [
  'README.md',
  ...readdirSync(path.join(ROOT, 'docs'))
    .filter((name) => name.endsWith('.md'))
    .sort()
    .map((name) => `docs/${name}`),
  ...(existsSync(path.join(ROOT, 'bench/README.md')) ? ['bench/README.md'] : []),
];
const WRITTEN = 'http://127.0.0.1:8080'; // the address in the documents

const generated = generate(BINARY); // before the daemon starts, which is given 10 s: this may take as long on a busy machine

let daemon;
before(async () => {
  daemon = await startDaemon();
});
after(() => daemon.stop());

// ---- generated files ----

/** After a new measurement the figures differ from the committed ones. */
function ownResults() {
  try {
    return (
      execFileSync('git', ['status', '--porcelain', 'bench/results'], {
        cwd: ROOT,
        encoding: 'utf8',
        stdio: ['ignore', 'pipe', 'ignore'],
      }) !== ''
    );
  } catch {
    return false;
  }
}

for (const [file, text] of generated) {
  const skip =
    ['docs/performance.md', 'docs/published.md', 'docs/scale.md', 'docs/tradeoff.md', 'docs/trust.md'].includes(file) && ownResults()
      ? 'bench/results are not the committed ones'
      : false;
  test(`${file} is what docs/generate.mjs makes`, { skip }, () => {
    assert.ok(existsSync(path.join(ROOT, file)), `${file} is missing: run node docs/generate.mjs`);
    assert.equal(read(file), text, `${file} is stale: run node docs/generate.mjs`);
  });
}

test('CSV is read', () => {
  const { comments, rows } = parseCsv('# cpu: 2 x "A", B\n# command: run: it\nname,ms,say\n"a, b",1,\nc,2.5,"he said ""no"""\n');
  assert.deepEqual(comments, [
    ['cpu', '2 x "A", B'],
    ['command', 'run: it'],
  ]);
  assert.deepEqual(rows, [
    { name: 'a, b', ms: '1', say: '' },
    { name: 'c', ms: '2.5', say: 'he said "no"' },
  ]);
});

// ---- the age of figures ----

test('every result that a benchmark writes says of which rooms it speaks', () => {
  const folder = path.join(ROOT, 'bench'),
    text = readdirSync(folder)
      .filter((file) => file.endsWith('.mjs'))
      .map((file) => readFileSync(path.join(folder, file), 'utf8'))
      .join('\n');
  const names = [...text.matchAll(/writeCsv\(\s*['"]([\w/]+)['"]/g)].map(([, name]) => name);
  assert.ok(names.includes('kills') && names.includes('soak') && names.length > 15, `${names}`);
  for (const name of names) assert.doesNotThrow(() => roomsOf(name));
});

test('results that are committed are those that documents cite', () => {
  let files;
  try {
    files = execFileSync('git', ['ls-files', 'bench/results'], { cwd: ROOT, encoding: 'utf8', stdio: ['ignore', 'pipe', 'ignore'] })
      .trim()
      .split('\n')
      .filter((file) => existsSync(path.join(ROOT, file)));
  } catch {
    files = readdirSync(path.join(ROOT, 'bench/results'), { recursive: true, withFileTypes: true })
      .filter((entry) => entry.isFile())
      .map((entry) => path.relative(ROOT, path.join(entry.parentPath ?? entry.path, entry.name)));
  }
  const text = DOCUMENTS.map(read).join('\n'),
    cited = new Set([...text.matchAll(/\]\([./]*bench\/(results\/[^)]+)\)/g)].map(([, target]) => `bench/${target}`));
  const generators = readdirSync(path.join(ROOT, 'docs'))
    .filter((name) => name.endsWith('.mjs'))
    .map((name) => read(`docs/${name}`))
    .join('\n');
  const isRead = (/** @type {string} */ file) =>
    generators.includes(`'${file}'`) || generators.includes(`'${file.slice('bench/results/'.length, -'.csv'.length)}'`);
  assert.ok(files.length > 40);
  assert.deepEqual(
    files.filter((file) => !cited.has(file) && !cited.has(path.dirname(file)) && !isRead(file)),
    [],
  );
});

/** The state of the rooms that a result speaks of, found without docs/generate.mjs: by the shell. @param {string[]} rooms
 * @param {string} root */
function stateOf(rooms, root = ROOT) {
  const list = rooms
    .map(
      (room) => `(cd ${room === 'www' ? '.' : 'src'} && find ${room} -type f \\( ${
        room === 'www' ? "-name '*.js' -o -name '*.css' -o -name '*.html'" : "-name '*.c' -o -name '*.h' -o -name '*.inc'"
      } \\) | sort | xargs sha256sum |
    sed -E 's/^([0-9a-f]+)  (.*)$/\\2 \\1/')`,
    )
    .join('; ');
  return execFileSync('bash', ['-c', `export LC_ALL=C; (${list}) | sha256sum | cut -c1-12`], { cwd: root, encoding: 'utf8' }).trim();
}

/** Of the daemon, as bench/rooms.mjs has them. */
const PAGE = ['base', 'daemon', 'game', 'input', 'link', 'netcode', 'param', 'session', 'sim'];

test('each figure of docs/performance.md says of which code it is, and bench/ages.mjs whether that has changed since', (t) => {
  const sections = read('docs/performance.md').split(/^### /m).slice(1),
    listed = new Map(ages().map(({ name, changed }) => [name, changed]));
  let told = 0;
  for (const section of sections) {
    const name = /\[All rows\]\(\.\.\/bench\/results\/(.+)\.csv\)/.exec(section)?.[1];
    if (!name) continue;
    const head = new Map(parseCsv(read(`bench/results/${name}.csv`)).comments);
    const rooms = [...section.slice(0, section.indexOf('\n|')).matchAll(/`(?:src\/(\w+)|www)`/g)].map(([, room]) => room ?? 'www').sort();
    assert.ok(
      rooms.length >= 2 && rooms.every((room) => existsSync(path.join(ROOT, room === 'www' ? '' : 'src', room))),
      `${name}: ${rooms}`,
    );
    assert.equal(listed.get(name), head.get('rooms') !== stateOf(rooms), name);
    assert.ok(section.includes(`Measured at commit ${head.get('commit')}`), name);
    told++;
  }
  assert.ok(told >= 12, `${told} results`);
  t.diagnostic(`older than the code: ${[...listed].flatMap(([name, changed]) => (changed ? [name] : [])).join(', ') || 'none'}`);
});

/** Changes the first digit of a file, and back with what it returns. @param {string} file */
function changeDigit(file) {
  const text = readFileSync(file, 'utf8');
  writeFileSync(
    file,
    text.replace(/\d/, (digit) => String((Number(digit) + 1) % 10)),
  );
  return () => writeFileSync(file, text);
}

/** A copy of what the generator and the benchmarks read. */
function copyTree() {
  const copy = mkdtempSync(path.join(tmpdir(), 'laglab-tree-'));
  for (const folder of ['src', 'www', 'docs', 'bench', 'api', 'scenarios', 'tests/rigid', 'tests/mutants.csv', 'package.json'])
    cpSync(path.join(ROOT, folder), path.join(copy, folder), { recursive: true, filter: (name) => path.basename(name) !== 'node_modules' });
  symlinkSync(path.join(ROOT, 'node_modules'), path.join(copy, 'node_modules'));
  return copy;
}

const CHANGED = /** @type {[string, string[]][]} */ ([
  ['src/ode/methods/boris.c', ['integrators']],
  ['src/base/detmath.c', ['fluid_grid/frames', 'integrators', 'page', 'rigid']],
  ['src/daemon/api/api.c', ['page']],
  ['src/cli/run.c', []],
  ['www/js/shell/header.js', ['page']],
]);

test('one digit of the code makes a figure of it old, and no other', () => {
  const copy = copyTree();
  const rooms = { integrators: ['base', 'ode'], rigid: ['base', 'rigid'], 'fluid_grid/frames': ['base', 'fluid'], page: [...PAGE, 'www'] };
  const write = (/** @type {string} */ name, /** @type {string} */ state) => {
    mkdirSync(path.dirname(path.join(copy, `bench/results/${name}`)), { recursive: true });
    writeFileSync(path.join(copy, `bench/results/${name}.csv`), `# commit: abc\n# date: today\n${state}a\n1\n`);
  };
  rmSync(path.join(copy, 'bench/results'), { recursive: true });
  for (const [name, list] of Object.entries(rooms)) write(name, `# rooms: ${stateOf(list, copy)}\n`);
  const old = () => ages(copy).flatMap(({ name, changed }) => (changed ? [name] : []));
  assert.deepEqual(old(), []);
  for (const [file, wanted] of CHANGED) {
    const back = changeDigit(path.join(copy, file));
    assert.deepEqual(old(), wanted, file);
    back();
  }
  write('speed', '');
  assert.deepEqual(old(), ['speed'], 'one that does not say of which code it is');
  rmSync(copy, { recursive: true });
});

test('the generator writes the same in another folder, at another place of the world, when code has changed that no document shows', () => {
  const copy = copyTree();
  for (const [file] of CHANGED) changeDigit(path.join(copy, file));
  const files = [...generated.keys()],
    state = () => files.map((file) => readFileSync(path.join(copy, file), 'utf8')),
    before = state();
  execFileSync(process.execPath, [path.join(copy, 'docs/generate.mjs')], {
    cwd: tmpdir(),
    env: { ...process.env, LAGLAB_BIN: BINARY, TZ: 'Pacific/Kiritimati', LANG: 'de_DE.UTF-8', LC_ALL: 'de_DE.UTF-8' },
  });
  state().forEach((text, i) => assert.equal(text, before[i], files[i]));
  rmSync(copy, { recursive: true });
});

// ---- scenarios ----

function scenarios(folder = 'scenarios') {
  return readdirSync(path.join(ROOT, folder), { withFileTypes: true }).flatMap((entry) =>
    entry.isDirectory() ? scenarios(`${folder}/${entry.name}`) : entry.name.endsWith('.json') ? [`${folder}/${entry.name}`] : [],
  );
}

const ajv = new Ajv({ strict: true, strictTypes: false, strictRequired: false, allErrors: true, keywords: ['x-unit', 'x-live'] });

/** As the build writes it next to the program. */
const scenarioSchema = () => JSON.parse(readFileSync(path.join(path.dirname(BINARY), 'api/scenario.schema.json'), 'utf8'));

test('every scenario fits scenario.schema.json', () => {
  const validate = ajv.compile(scenarioSchema());
  const files = scenarios().filter((file) => !file.startsWith('scenarios/experiments/'));
  assert.ok(files.length >= 12);
  for (const file of files) assert.ok(validate(JSON.parse(read(file))), `${file}: ${ajv.errorsText(validate.errors)}`);
});

test('every experiment fits its schema, which refuses an unknown key', () => {
  const validate = ajv.compile(JSON.parse(execFileSync(BINARY, ['schema', 'experiment'], { encoding: 'utf8' })));
  const files = [...scenarios('scenarios/experiments'), 'examples/experiment.json'];
  assert.ok(files.length >= 7);
  for (const file of files) assert.ok(validate(JSON.parse(read(file))), `${file}: ${ajv.errorsText(validate.errors)}`);
  assert.equal(validate({ scenario: 'race', metrics: ['x'], axis: [] }), false);
  assert.equal(validate({ scenario: 'race', metrics: ['x'], axes: [{ path: 'a', value: [1] }] }), false);
});

test('the schema refuses what the program refuses', () => {
  const validate = ajv.getSchema('') ?? ajv.compile(scenarioSchema());
  const race = JSON.parse(read('scenarios/race.json'));
  const wrong = {
    'an unknown key': { ...race, colour: 'red' },
    'no players': { ...race, players: [] },
    'a player too many': { ...race, players: Array(17).fill({}) },
    'a lag out of range': { ...race, players: [{ lag_ms: 1000.5 }] },
    'a text for a number': { ...race, duration_s: '30' },
    "another game's parameter": { ...race, params: { gravity_mps2: 9.81 } },
    'an unknown choice': { ...race, server: { sync: 'quantum' } },
    'part of a tick': { ...race, players: [{ slack_ticks: 1.5 }] },
  };
  for (const [what, scenario] of Object.entries(wrong)) {
    assert.equal(validate(scenario), false, `the schema takes ${what}`);
    assert.throws(
      () => execFileSync(BINARY, ['run', '-', '--duration', '0.1'], { input: JSON.stringify(scenario), stdio: ['pipe', 'ignore', 'pipe'] }),
      (/** @type {any} */ error) => error.status === 2,
      `the program takes ${what}`,
    );
  }
});

// ---- commands ----

const BLOCK = /^```(\w*)[^\n]*\n([\s\S]*?)^```$/gm;
const blocks = (file, language) => [...read(file).matchAll(BLOCK)].filter(([, name]) => name === language).map(([, , text]) => text);

test('blocks with commands are marked', () => {
  for (const file of DOCUMENTS) {
    for (const [, language, text] of read(file).matchAll(BLOCK)) {
      if (/^(\s*\$ )?(curl|laglab|build\/laglab) /m.test(text)) assert.match(language, /^(sh|console)$/, `${file}: ${text.slice(0, 80)}`);
    }
  }
});

/** Makes curl fail on an answer of 400 and above. */
const PRELUDE = 'set -euo pipefail\ncurl() { command curl --fail-with-body --max-time 20 "$@"; }\n';

for (const file of DOCUMENTS) {
  const commands = blocks(file, 'sh');
  if (commands.length === 0) continue;
  test(`the commands of ${file} work`, async () => {
    const folder = mkdtempSync(path.join(tmpdir(), 'laglab-docs-'));
    try {
      mkdirSync(path.join(folder, 'build'));
      symlinkSync(BINARY, path.join(folder, 'build/laglab'));
      symlinkSync(path.join(ROOT, 'scenarios'), path.join(folder, 'scenarios'));
      // The commands of a document follow each other, as a reader types them.
      const script = PRELUDE + commands.join('\n').replaceAll(WRITTEN, daemon.url.replace(/\/$/, ''));
      await promisify(execFile)('bash', ['-c', script], { cwd: folder, timeout: 600000, maxBuffer: 1 << 24 }).catch((error) => {
        assert.fail(`${file}: exit ${error.code}\n${String(error.stdout).slice(-800)}\n${error.stderr}`);
      });
    } finally {
      rmSync(folder, { recursive: true, force: true });
    }
  });
}

// ---- links ----

/** The text without blocks of code, which hold no links. */
const prose = (file) => read(file).replace(BLOCK, '');

function anchors(file) {
  const seen = new Map();
  return new Set(
    [...prose(file).matchAll(/^#+ (.+)$/gm)].map(([, heading]) => {
      const name = anchor(heading.replace(/\[([^\]]*)\]\([^)]*\)/g, '$1'));
      const count = seen.get(name) ?? 0;
      seen.set(name, count + 1);
      return count === 0 ? name : `${name}-${count}`;
    }),
  );
}

test('relative links lead somewhere', () => {
  const dead = [];
  let links = 0;
  for (const file of DOCUMENTS) {
    for (const [, target] of prose(file)
      .replace(/`[^`\n]*`/g, 'code')
      .matchAll(/\]\(([^)\s]+)\)/g)) {
      if (/^[a-z]+:/.test(target)) continue;
      const [name, fragment] = target.split('#');
      const to = name ? path.join(path.dirname(file), name) : file;
      links++;
      if (!existsSync(path.join(ROOT, to))) dead.push(`${file}: ${target}`);
      else if (fragment && (!to.endsWith('.md') || !anchors(to).has(fragment))) dead.push(`${file}: ${target} (no such heading)`);
    }
  }
  assert.ok(links > 50);
  assert.deepEqual(dead, []);
});

test('the image is small', () => {
  assert.ok(statSync(path.join(ROOT, 'docs/race.png')).size < 200 * 1024);
});
