// The Python package: its own tests, with the program; and the wheel that a daemon serves, as pip reads it.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { test } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
const CLIENT = path.join(ROOT, 'clients/python');
const LAGLAB_BIN = path.resolve(process.env.LAGLAB_BIN ?? path.join(ROOT, 'build/laglab'));

/** Debian's Python. @param {string[]} args @param {Record<string, string>} env */
async function python(args, env) {
  const child = spawn('/usr/bin/python3', ['-B', ...args], { cwd: CLIENT, env: { ...process.env, LAGLAB_BIN, ...env } });
  let said = '';
  for (const stream of [child.stdout, child.stderr]) stream.setEncoding('utf8').on('data', (text) => (said += text));
  const [code] = await once(child, 'close');
  assert.equal(code, 0, said);
  return said;
}

test('the tests of the Python package', async () => {
  const said = await python(['-m', 'unittest', 'discover', 'tests'], { PYTHONPATH: CLIENT });
  assert.ok(Number(/^Ran (\d+) tests/m.exec(said)?.[1]) >= 22, said);
});

test('the wheel that a daemon serves has what its record says, and runs', async () => {
  const daemon = await startDaemon();
  const folder = mkdtempSync(path.join(tmpdir(), 'laglab-wheel-'));
  try {
    const answer = await fetch(`${daemon.url}clients/laglab-0.2.0-py3-none-any.whl`);
    assert.equal(answer.status, 200);
    const wheel = path.join(folder, 'laglab-0.2.0-py3-none-any.whl');
    writeFileSync(wheel, Buffer.from(await answer.arrayBuffer()));
    const check = `
import base64, hashlib, sys, zipfile
archive = zipfile.ZipFile(sys.argv[1])
record = [line.rsplit(",", 2) for line in archive.read("laglab-0.2.0.dist-info/RECORD").decode().splitlines()]
assert sorted(name for name, _, _ in record) == sorted(archive.namelist())
for name, digest, size in record[:-1]:
    data = archive.read(name)
    hashed = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
    assert int(size) == len(data) and digest == "sha256=" + hashed, name
sys.path.insert(0, sys.argv[1])
import laglab
assert laglab.__file__.startswith(sys.argv[1])
print(laglab.run("race", duration_s=1).hash)
`;
    assert.match(await python(['-c', check, wheel], {}), /^[0-9a-f]{16}\n$/);
  } finally {
    rmSync(folder, { recursive: true, force: true });
    await daemon.stop();
  }
});
