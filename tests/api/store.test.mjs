// `laglab store`: what sweeps left in a store is listed, shown, paused, resumed and deleted.
import assert from 'node:assert/strict';
import { after, test } from 'node:test';
import { spawn, spawnSync } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { waitFor } from '../lib/client.mjs';
import { BINARY } from '../lib/daemon.mjs';

const folder = mkdtempSync(path.join(tmpdir(), 'laglab-store-'));
after(() => rmSync(folder, { recursive: true, force: true }));
const URL = `sqlite:${path.join(folder, 'results.db')}`;
const run = (/** @type {string[]} */ args, input = '', env = {}) =>
  spawnSync(BINARY, args, { input, encoding: 'utf8', env: { ...process.env, ...env } });
const experiment = (/** @type {number[]} */ values) =>
  JSON.stringify({
    scenario: 'race',
    set: { duration_s: 1, warmup_s: 0 },
    axes: [{ path: 'players.0.lag_ms', values }],
    metrics: ['players.0.own_lead_m.mean'],
  });

test('sweeps of a store are listed, shown and deleted', () => {
  for (const values of [[0, 40, 80], [7]]) assert.equal(run(['sweep', '-', '--store', URL], experiment(values)).status, 0);
  const list = () =>
    run(['store', 'list', '--store', URL])
      .stdout.trim()
      .split('\n')
      .filter(Boolean)
      .map((line) => line.split(/\s+/));
  const rows = list();
  assert.deepEqual(
    rows.map((row) => row.slice(1, 5)),
    [
      ['done', '3', 'of', '3'],
      ['done', '1', 'of', '1'],
    ],
  );
  assert.match(rows[0][5], /^20\d\d-\d\d-\d\dT\d\d:\d\d:\d\dZ$/);
  const shown = run(['store', 'show', rows[0][0]], '', { LAGLAB_STORE: URL }).stdout;
  assert.match(shown, /^state +done$/m);
  assert.match(shown, /^runs +0 to 2$/m);
  assert.deepEqual(JSON.parse(shown.slice(shown.indexOf('{'))).axes[0].values, [0, 40, 80]);
  const both = run(['store', 'delete', rows[1][0], 'no-such-one', '--store', URL]);
  assert.equal(both.status, 2);
  assert.match(both.stderr, /no-such-one/);
  assert.equal(list().length, 2, 'nothing is deleted where one is not there');
  assert.equal(run(['store', 'delete', rows[0][0], '--store', URL]).status, 0);
  assert.deepEqual(list(), [rows[1]]);
  assert.equal(run(['store', 'show', rows[0][0], '--store', URL]).status, 2);
  assert.equal(
    run(['sweep', '-', '--store', URL, '--format', 'csv'], experiment([0, 40, 80]))
      .stdout.trim()
      .split('\n').length,
    4,
    'it can be run again',
  );
});

test('an experiment that is paused waits until it is resumed', async (t) => {
  const order = experiment(Array.from({ length: 200 }, (_, i) => i)),
    sweep = spawn(BINARY, ['sweep', '-', '--store', URL, '--jobs', '0', '--out', path.join(folder, 'rows.csv')], {
      stdio: ['pipe', 'ignore', 'inherit'],
    });
  t.after(() => sweep.kill('SIGKILL'));
  const ended = new Promise((resolve) => sweep.once('close', resolve));
  sweep.stdin.end(order);
  const row = () =>
    run(['store', 'list', '--store', URL])
      .stdout.split('\n')
      .map((line) => line.split(/\s+/))
      .find((cells) => cells[4] === '200');
  await waitFor(() => row() !== undefined, 'the experiment', 10000);
  const [id] = row(),
    work = () => assert.equal(run(['worker', '--store', URL, '--experiment', id, '--drain']).status, 0);
  assert.equal(run(['store', 'pause', id, '--store', URL]).status, 0);
  assert.deepEqual(row().slice(1, 3), ['paused', '0']);
  assert.equal(run(['store', 'resume', id, '--store', URL]).status, 0);
  work();
  assert.equal(await ended, 0, 'the sweep ends when others have done its runs');
  const late = run(['store', 'pause', id, '--store', URL]);
  assert.equal(late.status, 2);
  assert.match(late.stderr, /is done; only an experiment that is running can be paused/);
});

test('what is asked wrongly is refused with a sentence', () => {
  for (const [args, words] of /** @type {[string[], RegExp][]} */ ([
    [['store'], /list, show, pause, resume, delete/],
    [['store', 'drop', '--store', URL], /list, show, pause, resume, delete/],
    [['store', 'show', '--store', URL], /must have the id of/],
    [['store', 'delete', '--store', URL], /must have ids/],
    [['store', 'pause', '--store', URL], /pause: must have ids/],
    [['store', 'resume', 'no-such-one', '--store', URL], /no-such-one/],
    [['store', 'list', 'x', '--store', URL], /must have no arguments/],
  ])) {
    const ended = run(args);
    assert.equal(ended.status, 2, args.join(' '));
    assert.match(ended.stderr, words);
  }
});
