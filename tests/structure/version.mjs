// The version is a fingerprint of every file that the binary is made of: all files that the compiler has read for it, the scenarios that it
// names, and how it is built. One constant changed in any of them gives another version. Argument: the folder of the build.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { cpSync, existsSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { argv } from 'node:process';
import { fileURLToPath } from 'node:url';

const root = fileURLToPath(new URL('../..', import.meta.url)),
  build = path.resolve(argv[2] ?? 'build');
const listed = readFileSync(path.join(build, 'version_files.txt'), 'utf8').split('\n').filter(Boolean);

/** What the compiler read, as ninja keeps it, for the objects of the binary; paths from the root. @returns {Set<string>} */
function read() {
  const deps = spawnSync('ninja', ['-C', build, '-t', 'deps'], { encoding: 'utf8', maxBuffer: 1 << 28 });
  assert.equal(deps.status, 0, deps.stderr);
  /** @type {Set<string>} */
  const found = new Set();
  let counts = false;
  for (const line of deps.stdout.split('\n')) {
    const object = /^CMakeFiles\/laglab(?:_engine|_experiment|_daemon|_cli)?\.dir\/(.+)\.o: #deps/.exec(line);
    // ninja remembers objects of files that are gone
    if (line.includes(': #deps')) counts = object !== null && existsSync(path.join(root, object[1]));
    const name = path.relative(root, path.resolve(build, line.trim()));
    if (counts && line.startsWith(' ') && !name.startsWith('..') && !path.resolve(root, name).startsWith(build)) found.add(name);
  }
  return found;
}

const needed = read();
assert.ok(needed.size > 300 && [...needed].some((name) => name.endsWith('.inc')), `${needed.size} files were read`);
assert.deepEqual(
  [...needed].filter((name) => !listed.includes(name)),
  [],
  'files of the binary that are not in its version',
);
for (const name of readdirSync(path.join(root, 'scenarios'))) {
  if (name.endsWith('.json')) assert.ok(listed.includes(`scenarios/${name}`), name);
}

// The fingerprint of a copy.
const copy = mkdtempSync(path.join(tmpdir(), 'laglab-version-'));
for (const name of listed) cpSync(path.join(root, name), path.join(copy, name), { recursive: true });

function version() {
  const output = path.join(copy, 'version.out');
  const made = spawnSync(
    'cmake',
    [
      '-DRELEASE=1.2.3',
      `-DSOURCE=${copy}`,
      `-DLIST=${path.join(build, 'version_files.txt')}`,
      `-DOUTPUT=${output}`,
      '-P',
      path.join(root, 'cmake/version.cmake'),
    ],
    { encoding: 'utf8' },
  );
  assert.equal(made.status, 0, made.stderr);
  return (/"(1\.2\.3\+[0-9a-f]{12})"/.exec(readFileSync(output, 'utf8')) ?? [])[1];
}

const before = version(),
  seen = new Set([before]);
assert.ok(before);
const some = [
  ...listed.filter((name) => name.endsWith('.inc')),
  'CMakeLists.txt',
  'CMakePresets.json',
  'src/main.c',
  'src/daemon/api/api.c',
  'src/ode/core/scale.h',
  'src/cli/experiments/sweep.c',
  'scenarios/race.json',
].filter((name) => listed.includes(name));
assert.ok(some.length >= 8, some.join(' '));
for (const name of some) {
  const file = path.join(copy, name),
    text = readFileSync(file, 'utf8'),
    changed = text.replace(/\d/, (digit) => String((Number(digit) + 1) % 10));
  assert.notEqual(changed, text, name);
  writeFileSync(file, changed);
  const other = version();
  assert.ok(other && !seen.has(other), `${name}: ${other} was there before`);
  seen.add(other);
  writeFileSync(file, text);
  assert.equal(version(), before, `${name} is as it was`);
}
rmSync(copy, { recursive: true });
console.log(`${needed.size} files are read for the binary, ${listed.length} are in its version`);
