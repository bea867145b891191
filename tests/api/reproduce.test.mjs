// laglab reproduce: rows of a sweep are found equal, and one that was changed is found.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { BINARY } from '../lib/daemon.mjs';

const ORDER = {
  scenario: 'race',
  set: { duration_s: 3, 'players.0.link.up.loss_pct': 5 },
  axes: [{ path: 'players.0.lag_ms', values: [0, 80, 160] }],
  repeats: 4,
  metrics: ['players.0.remote_error_m.mean'],
};

let folder;
const at = (name) => path.join(folder, name);
const laglab = (...args) => spawnSync(BINARY, args, { encoding: 'utf8' });

before(() => {
  folder = mkdtempSync(path.join(tmpdir(), 'laglab-reproduce-'));
  writeFileSync(at('order.json'), JSON.stringify(ORDER));
  for (const name of ['runs.csv', 'runs.ndjson', 'runs.json']) assert.equal(laglab('sweep', at('order.json'), '--out', at(name)).status, 0);
  assert.equal(laglab('sweep', at('order.json'), '--points', '--out', at('points.csv')).status, 0);
});
after(() => rmSync(folder, { recursive: true, force: true }));

for (const name of ['runs.csv', 'runs.ndjson']) {
  test(`${name}: all rows, some rows, and one that was changed`, () => {
    const all = laglab('reproduce', at('order.json'), at(name));
    assert.equal(all.status, 0, all.stderr);
    const { version, made_by, ...counts } = JSON.parse(all.stdout);
    assert.deepEqual(counts, { rows: 12, compared: 12, equal: 12, skipped: 0 });
    assert.equal(made_by, version);
    assert.equal(JSON.parse(laglab('reproduce', at('order.json'), at(name), '--rows', '5').stdout).compared, 5);

    const lines = readFileSync(at(name), 'utf8').split('\n'),
      first = name.endsWith('csv') ? 1 : 0;
    const hash = /[0-9a-f]{16}/.exec(lines[first + 7])?.[0] ?? '';
    lines[first + 7] = lines[first + 7].replace(hash, `${hash[0] === '0' ? '1' : '0'}${hash.slice(1)}`);
    writeFileSync(at(`changed-${name}`), lines.join('\n'));
    const changed = laglab('reproduce', at('order.json'), at(`changed-${name}`), '--rows', '0');
    assert.equal(changed.status, 1);
    assert.deepEqual(/run (\d+) differs/.exec(changed.stderr)?.slice(1), ['7']);
    assert.equal(JSON.parse(changed.stdout).equal, 11);

    // Of another version: compared all the same, and named.
    writeFileSync(at(`older-${name}`), readFileSync(at(name), 'utf8').replaceAll(version, '0.1.9+0123456789ab'));
    const older = laglab('reproduce', at('order.json'), at(`older-${name}`));
    assert.equal(older.status, 0, older.stderr);
    assert.equal(JSON.parse(older.stdout).made_by, '0.1.9+0123456789ab');
  });
}

test('what it cannot compare it refuses', () => {
  const refused = (...args) => {
    const { status, stderr } = laglab('reproduce', ...args);
    assert.equal(status, 2, stderr);
    return stderr;
  };
  assert.match(refused(at('order.json'), at('runs.json')), /must be csv or ndjson/);
  assert.match(refused(at('order.json'), at('points.csv')), /must have the header of this experiment's runs/);
  assert.match(refused(at('order.json')), /needs an experiment and a file/);
  assert.match(refused(at('order.json'), at('nothing.csv')), /cannot read/);
  writeFileSync(at('short.json'), JSON.stringify({ ...ORDER, repeats: 1 }));
  assert.match(refused(at('short.json'), at('runs.csv')), /must begin with its run, 0 to 2; got/);
  writeFileSync(at('cost.json'), JSON.stringify({ ...ORDER, metrics: ['cost.ns_per_sim_s'] }));
  assert.match(refused(at('cost.json'), at('runs.csv')), /is measured/);
});
