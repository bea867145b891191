// The contract for clients: linted, compared with the schema of AsyncAPI, and compiled into a typed client that calls every operation.
import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { copyFileSync, mkdirSync, mkdtempSync, readFileSync, rmSync, symlinkSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { promisify } from 'node:util';
import { lint, loadConfig } from '@redocly/openapi-core';
import Ajv from 'ajv';
import addFormats from 'ajv-formats';
import YAML from 'yaml';
import { BINARY, startDaemon } from '../lib/daemon.mjs';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
const at = (/** @type {string} */ name) => path.join(ROOT, name);
const run = promisify(execFile);

/** A document as the build has it, next to the schemas to which it refers. */
const built = (/** @type {string} */ name) => path.join(path.dirname(BINARY), name);

// The library behind `redocly lint`, without the rest of that package, which is a web site's generator.
for (const name of ['api/openapi.yaml', 'api/asyncapi.yaml']) {
  test(`${name} is without errors and warnings of redocly's rules`, async () => {
    const config = await loadConfig({ configPath: at('redocly.yaml') });
    const problems = await lint({ ref: built(name), config });
    assert.deepEqual(
      problems.map((p) => `${p.severity} ${p.ruleId}: ${p.message} at ${p.location[0]?.pointer}`),
      [],
    );
  });
}

test('the linter finds what is wrong', async () => {
  const config = await loadConfig({ configPath: at('redocly.yaml') });
  const folder = mkdtempSync(path.join(tmpdir(), 'laglab-lint-'));
  try {
    copyFileSync(built('api/schemas.json'), path.join(folder, 'schemas.json'));
    const broken = readFileSync(at('api/openapi.yaml'), 'utf8')
      .replace('operationId: getSchema\n', 'operationId: getScenario\n')
      .replace('schemas/Counter"', 'schemas/Count"');
    writeFileSync(path.join(folder, 'openapi.yaml'), broken);
    const rules = (await lint({ ref: path.join(folder, 'openapi.yaml'), config })).map((p) => p.ruleId);
    assert.ok(rules.includes('operation-operationId-unique') && rules.includes('no-unresolved-refs'), rules.join());
  } finally {
    rmSync(folder, { recursive: true });
  }
});

test('api/asyncapi.yaml is what the schema of AsyncAPI takes', () => {
  const document = YAML.parse(readFileSync(at('api/asyncapi.yaml'), 'utf8'));
  const schema = JSON.parse(readFileSync(at(`node_modules/@asyncapi/specs/schemas/${document.asyncapi}-without-$id.json`), 'utf8'));
  const ajv = new Ajv({ strict: false, allErrors: true });
  addFormats.default(ajv);
  const validate = ajv.compile(schema);
  assert.ok(validate(document), ajv.errorsText(validate.errors));
  assert.ok(
    !validate({ .../** @type {any} */ (document), channels: { session: { adress: 'x' } } }),
    'it takes a channel without an address',
  );
});

test('a typed client is generated, compiles, and calls every operation', async () => {
  const folder = mkdtempSync(path.join(tmpdir(), 'laglab-typed-'));
  writeFileSync(path.join(folder, 'key'), 'an-operators-key-of-some-length\n', { mode: 0o600 });
  const daemon = await startDaemon({ args: ['--operator-key-file', path.join(folder, 'key')] });
  try {
    for (const name of ['client.ts', 'program.ts', 'tsconfig.json']) copyFileSync(at(`tests/api/typed/${name}`), path.join(folder, name));
    symlinkSync(at('node_modules'), path.join(folder, 'node_modules'));
    writeFileSync(path.join(folder, 'package.json'), '{"type":"module"}');
    // From what the daemon serves: what it refers to is there, too.
    await run(
      at('node_modules/.bin/openapi-typescript'),
      [`${daemon.url}api/v1/openapi.yaml`, '-o', path.join(folder, 'api.ts'), '--default-non-nullable=false', '--empty-objects-unknown'],
      { cwd: folder },
    );
    mkdirSync(path.join(folder, 'out'));
    await run(at('node_modules/.bin/tsc'), ['-p', '.', '--outDir', 'out'], { cwd: folder }).catch((error) => assert.fail(error.stdout));
    const { stdout } = await run(process.execPath, ['out/program.js', daemon.url, 'an-operators-key-of-some-length'], { cwd: folder });
    const document = YAML.parse(readFileSync(at('api/openapi.yaml'), 'utf8'));
    const all = Object.entries(document.paths).flatMap(([template, item]) =>
      Object.keys(item)
        .filter((key) => key !== 'parameters')
        .map((method) => `${method} ${template}`),
    );
    assert.deepEqual(stdout.trim().split('\n'), all.sort());
  } finally {
    await daemon.stop();
    rmSync(folder, { recursive: true });
  }
});
