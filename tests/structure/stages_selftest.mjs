// Proves that tests/stages.sh and tests/stages.mjs notice a stage that fails, finds no test, dies or hangs, and that they name what was
// skipped, has become slower or has gone; and that tests/find.mjs finds the tests of a name.
import assert from 'node:assert/strict';
import { spawn, spawnSync } from 'node:child_process';
import { once } from 'node:events';
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';
import { setTimeout as sleep } from 'node:timers/promises';
import { findTests } from '../find.mjs';
import { compare, count, readCommitted } from '../stages.mjs';

// ---- stages ----
const root = mkdtempSync(join(tmpdir(), 'stages-'));
const stages = `set -euo pipefail
cd '${root}'
. '${resolve('tests/stages.sh')}'
logs=logs
node() { command node "${resolve('tests')}/\${1#tests/}" "\${@:2}"; }`;
const bash = (script, option) => ['-c', `${stages}\nall_of_it() {\n${script}\n}\nrun_stages '${option}' all_of_it`];
const start = (script) => spawn('bash', bash(script, ''), { stdio: 'ignore' });
function run(script, option = '', env = {}) {
  const done = spawnSync('bash', bash(script, option), { encoding: 'utf8', env: { ...process.env, ...env } });
  return { status: done.status, lines: done.stdout.trim().split('\n'), text: done.stdout + done.stderr };
}
try {
  mkdirSync(join(root, 'tests'));
  const XML = `<testsuite>
  <testcase name="link.delay" classname="link.delay" time="1" status="run"><system-out>[       OK ] test_a
[       OK ] test_b
[  SKIPPED ] test_c</system-out></testcase>
  <testcase name="structure.x" time="1" status="run"><system-out></system-out></testcase>
  <testcase name="golden.riscv64" time="1" status="notrun"><skipped message="SKIP_RETURN_CODE=77"/><system-out>not run: no &lt;qemu&gt;
</system-out></testcase>
</testsuite>`;
  const WRONG = `<testsuite>
  <testcase name="link.loss" time="1" status="fail"><failure message=""/><system-out>[       OK ] test_a
[  FAILED  ] test_b
[  FAILED  ] test_b</system-out></testcase>
  <testcase name="link.gone" time="0" status="notrun"><skipped message="Unable to find executable"/><system-out></system-out></testcase>
</testsuite>`;
  const COUNTS = 'ℹ pass 1\nℹ fail 1\nℹ cancelled 0\nℹ skipped 1\nℹ todo 0\n';
  const NODE = `✔ one (1.5ms)\n﹣ two (0.1ms) # mounting needs root\n✖ three (2ms)\n${COUNTS}test at a.test.mjs:3:1\n✖ three (2ms)\n`;
  writeFileSync(join(root, 'good.xml'), XML);
  writeFileSync(join(root, 'wrong.xml'), WRONG);
  writeFileSync(join(root, 'node'), NODE);
  const good = run(`
    stage "units" ctest cp good.xml logs/units.xml
    stage "layout" one true
    stage "container" node eval 'echo "no namespaces here"; exit 77'`);
  assert.equal(good.status, 0, good.text);
  assert.equal(good.lines.at(-1), '4 passed, 0 failed, 3 skipped');
  for (const line of ['units: link.delay test_c', 'units: golden.riscv64: not run: no <qemu>', 'container: no namespaces here'])
    assert.ok(good.lines.includes(line), `${line} in ${good.text}`);

  const first = run('if stage "build" one eval "echo no such header; false"; then stage "units" one true; fi');
  assert.equal(first.lines.at(-1), '0 passed, 1 failed', 'nothing is run without a build');
  assert.ok(first.lines.includes('no such header'), 'what failed is shown');
  const bad = run(`
    stage "units" ctest eval 'cp wrong.xml logs/units.xml; false'
    stage "page" node eval 'cat node; false'
    stage "nothing" ctest true
    stage "no test" node true
    stage "layout" one false
    steps() { false; true; }
    stage "one of its steps" one steps
    stage "dies" one eval 'kill -SEGV $BASHPID'
    stage "ends badly" node eval 'echo "ℹ pass 3"; exit 3'
    stage "good" one true`);
  assert.equal(bad.status, 1);
  assert.equal(bad.lines.at(-1), '6 passed, 9 failed, 1 skipped', bad.text);
  for (const line of [
    'units: link.loss test_b (logs/units.log)',
    'units: link.gone (logs/units.log)',
    'page: a.test.mjs:3:1 three (logs/page.log)',
    'nothing: no test was found (logs/nothing.log)',
    'no test: no test was found (logs/no-test.log)',
    'layout: exit status 1 (logs/layout.log)',
    'one of its steps: exit status 1 (logs/one-of-its-steps.log)',
    'dies: exit status 139 (logs/dies.log)',
    'ends badly: exit status 3 (logs/ends-badly.log)',
  ])
    assert.ok(bad.lines.includes(line), `${line} in ${bad.text}`);
  const hangs = run('stage "hangs" one sleep 1000', '', { LAGLAB_STALL_S: '2' });
  assert.equal(hangs.lines.at(-1), '0 passed, 1 failed');
  assert.ok(hangs.lines.includes('hangs: exit status 143 (logs/hangs.log)'), hangs.text);
  assert.match(readFileSync(join(root, 'logs/hangs.log'), 'utf8'), /nothing was written for 2 s/);

  // Side by side. What a stage has started ends with it, and all ends with the run.
  const alive = `bash -c 'while sleep 0.1; do date +%N >"$1"; done' -`;
  const ended = async (file) => {
    await sleep(500);
    const then = readFileSync(join(root, file), 'utf8');
    await sleep(500);
    assert.equal(readFileSync(join(root, file), 'utf8'), then, `${file} is not written any more`);
  };
  const beside = run(`
    one() { stage "one" one eval "${alive.replaceAll('"', '\\"').replace('$1', '\\$1')} left & sleep 1"; stage "two" one true; }
    other() { stage "other" one false; }
    side_by_side one other`);
  assert.equal(beside.status, 1);
  assert.equal(beside.lines.at(-1), '2 passed, 1 failed', beside.text);
  await ended('left');
  const early = run(`
    one() { stage "one" one true; echo "$nothing"; stage "two" one true; }
    other() { stage "other" one true; }
    side_by_side one other`);
  assert.equal(early.lines.at(-1), '2 passed, 1 failed', early.text);
  assert.ok(early.lines.includes('last stage of one: exit status 1 (none)'), early.text);
  const stopped = start(`
    one() { stage "one" one ${alive} first; }
    other() { stage "other" one ${alive} second; }
    side_by_side one other`);
  while (!existsSync(join(root, 'first')) || !existsSync(join(root, 'second'))) await sleep(50);
  stopped.kill('SIGTERM');
  assert.deepEqual(await once(stopped, 'exit'), [130, null]);
  await ended('first');
  await ended('second');

  // The table: renewed only by a run without a failure, and compared.
  const table = join(root, 'tests/stages.csv');
  run(`stage "units" ctest cp good.xml logs/units.xml`, '--record');
  assert.match(readFileSync(table, 'utf8'), /^stage,seconds,checks\nunits,\d,5\n$/);
  run('stage "units" one false', '--record');
  assert.match(readFileSync(table, 'utf8'), /units,\d,5\n/);
  assert.match(run('stage "units" one true').text, /^units: 1 checks, 5 in tests\/stages\.csv$/m);
} finally {
  rmSync(root, { recursive: true });
}

const committed = readCommitted('stage,seconds,checks\nfast,10,5\nslow,100,5\n');
const changed = (name, seconds, checks) => compare([{ name, seconds, checks }], committed);
assert.deepEqual(changed('slow', 125, 5), []);
assert.deepEqual(changed('slow', 126, 5), ['slow: 126 s, 100 s in tests/stages.csv']);
assert.deepEqual(changed('fast', 20, 6), []);
assert.deepEqual(changed('fast', 21, 4), ['fast: 21 s, 10 s in tests/stages.csv', 'fast: 4 checks, 5 in tests/stages.csv']);
assert.deepEqual(changed('new', 100, 1), []);
assert.equal(count('ctest', 'none.log', 0).failed.length, 1);

// ---- names ----
assert.deepEqual(findTests(['link']), ['target tests_link', 'ctest ^link\\.']);
assert.deepEqual(findTests(['link.delay', './tests/page/time.test.mjs']), [
  'target tests_link',
  'ctest ^link\\.delay_?[0-9]?$',
  'node tests/page/time.test.mjs',
]);
assert.deepEqual(findTests(['structure']), ['target laglab', 'ctest ^structure\\.']);
const client = findTests(['netcode/client/']);
assert.ok(client.includes('target tests_netcode') && client.includes('ctest ^netcode\\.ack_?[0-9]?$'));
assert.ok(!client.includes('ctest ^netcode\\.'));
assert.deepEqual(findTests(['src/netcode/client/client.c']), client);
assert.deepEqual(findTests(['src/ode/stiff']), findTests(['ode']), 'of the room above');
assert.deepEqual(findTests([resolve('src/main.c')]), ['node tests/api/trace.test.mjs', 'node tests/api/cli.test.mjs'], 'from outside');
assert.deepEqual(findTests(['oracle.netgame_more']), ['target laglab', 'ctest ^oracle\\.netgame_more$']);
assert.deepEqual(findTests(['sim.outages_many']), ['target tests_sim', 'ctest ^sim\\.outages_many$']);
assert.ok(findTests(['daemon']).some((line) => line.startsWith('node ')) && findTests(['daemon']).includes('ctest ^daemon\\.'));
for (const name of ['nix', 'netcode/clint', 'src/nix.c', 'tests', 'tests/page/nix.test.mjs', 'main.c', 'link.nix', 'cost.nix', ''])
  assert.throws(() => findTests([name]), new RegExp(`no tests of ${name}\\. Rooms: api base`));
for (const [, names] of readFileSync('CONTRIBUTING.md', 'utf8').matchAll(/`\.\/dev test ([^-`][^`]*)`/g)) findTests(names.split(' '));
const foreign = /^FOREIGN=\(([^)]*)\)/m.exec(readFileSync('tests/stages.sh', 'utf8'))[1].trim().split(/\s+/);
assert.ok(foreign.length > 5 && !findTests(foreign).join().includes('('), 'ctest takes 32 pairs of parentheses');
console.log('stages_selftest: all cases as expected');
