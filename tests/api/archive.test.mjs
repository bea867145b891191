// An experiment as one archive: written by a sweep and from a store, read by tar and sha256sum, verified by laglab.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { client, waitFor } from '../lib/client.mjs';
import { BINARY, startDaemon } from '../lib/daemon.mjs';

const ORDER = {
  title: 'Lag and error',
  scenario: 'race',
  set: { duration_s: 3, 'players.0.link.up.loss_pct': 5 },
  axes: [{ path: 'players.0.lag_ms', values: [0, 80, 160] }],
  windows: [{ name: 'late', from_s: 2.5 }],
  repeats: 12,
  metrics: ['players.0.remote_error_m.mean', 'players.0.remote_error_m.mean@late'],
};
const DIGEST = `sha256:${'0a'.repeat(32)}`;

let folder;
const at = (/** @type {string} */ name) => path.join(folder, name);
const laglab = (/** @type {string[]} */ ...args) => spawnSync(BINARY, args, { encoding: 'utf8', cwd: folder });
const good = (/** @type {string[]} */ ...args) => {
  const { status, stdout, stderr } = laglab(...args);
  assert.equal(status, 0, `laglab ${args.join(' ')}: ${stderr}`);
  return stdout;
};

before(() => {
  folder = mkdtempSync(path.join(tmpdir(), 'laglab-archive-'));
  writeFileSync(at('order.json'), JSON.stringify(ORDER));
  good('sweep', 'order.json', '--jobs', '2', '--out', 'rows.csv', '--archive', 'a.tar', '--container', DIGEST);
});
after(() => rmSync(folder, { recursive: true, force: true }));

test('any machine reads it with tar and sha256sum', () => {
  const names = spawnSync('tar', ['-tf', at('a.tar')], { encoding: 'utf8' })
    .stdout.trim()
    .split('\n');
  assert.deepEqual(names, ['manifest.json', 'experiment.json', 'rows.csv', 'rows.bin', 'report.html', 'CITATION.cff', 'SHA256SUMS']);
  const out = mkdtempSync(at('out-'));
  assert.equal(spawnSync('tar', ['-xf', at('a.tar'), '-C', out]).status, 0);
  const sums = spawnSync('sha256sum', ['-c', 'SHA256SUMS'], { cwd: out, encoding: 'utf8' });
  assert.equal(sums.status, 0, sums.stdout);
  assert.equal(readFileSync(path.join(out, 'rows.csv'), 'utf8'), readFileSync(at('rows.csv'), 'utf8'));
  const manifest = JSON.parse(readFileSync(path.join(out, 'manifest.json'), 'utf8'));
  const version = good('--version').trim().replace('laglab ', '');
  assert.deepEqual([manifest.format, manifest.version, manifest.container, manifest.runs], ['laglab-archive', version, DIGEST, 36]);
  assert.deepEqual(manifest.metrics, ORDER.metrics);
  assert.match(readFileSync(path.join(out, 'CITATION.cff'), 'utf8'), new RegExp(`^version: ${version.replace('+', '\\+')}$`, 'm'));
  // The specification alone gives the rows again; the bytes are those of the CSV.
  assert.equal(good('sweep', path.join(out, 'experiment.json')), readFileSync(at('rows.csv'), 'utf8'));
  const rows = readFileSync(path.join(out, 'rows.bin'));
  const lines = readFileSync(at('rows.csv'), 'utf8').trim().split('\r\n');
  const column = (/** @type {string} */ name) => (lines[0] ?? '').split(',').indexOf(name);
  assert.equal(rows.length, 36 * (32 + 2 * 8));
  for (let run = 0; run < 36; run++) {
    const cells = (lines[run + 1] ?? '').split(',');
    assert.equal(Number(rows.readBigInt64LE(run * 48)), run);
    assert.equal(
      rows
        .readBigUInt64LE(run * 48 + 16)
        .toString(16)
        .padStart(16, '0'),
      cells[column('hash')],
    );
    ORDER.metrics.forEach((name, i) => assert.equal(rows.readDoubleLE(run * 48 + 32 + 8 * i), Number(cells[column(name)])));
  }
});

test('what GNU tar packs of the same files is the same archive', () => {
  const out = mkdtempSync(at('out-'));
  assert.equal(spawnSync('tar', ['-xf', at('a.tar'), '-C', out]).status, 0);
  const listing = spawnSync('tar', ['--full-time', '--numeric-owner', '-tvf', at('a.tar')], {
    encoding: 'utf8',
    env: { ...process.env, TZ: 'UTC' },
  });
  const listed = listing.stdout.trim().split('\n');
  assert.equal(listed.length, 7);
  for (const line of listed) assert.match(line, /^-rw-r--r-- 0\/0 +\d+ 1970-01-01 00:00:00 [A-Za-z0-9.]+$/);
  const names = listed.map((line) => line.replace(/.* /, ''));
  const made = ['--format=ustar', '--owner=0', '--group=0', '--numeric-owner', '--mtime=@0', '--mode=644', '-cf', at('gnu.tar')];
  assert.equal(spawnSync('tar', [...made, '-C', out, ...names]).status, 0);
  assert.equal(JSON.parse(good('verify', 'gnu.tar', '--rows', '2')).differences, 0);
});

test('a daemon gives the archive of its experiment, which is verified elsewhere', async () => {
  const daemon = await startDaemon(),
    c = client(daemon.url);
  try {
    const { id, links } = (await c.call('POST', '/api/v1/experiments', { body: ORDER })).json;
    await waitFor(async () => (await c.get(`/api/v1/experiments/${id}`)).json.state === 'done', 'the experiment', 60000);
    const read = async () => {
      const answer = await fetch(new URL(links.archive, daemon.url));
      assert.equal(answer.status, 200);
      assert.equal(answer.headers.get('content-type'), 'application/x-tar');
      assert.equal(answer.headers.get('content-disposition'), `attachment; filename="${id}.tar"`);
      return Buffer.from(await answer.arrayBuffer());
    };
    const bytes = await read();
    assert.ok(bytes.equals(await read()), 'the same bytes each time');
    writeFileSync(at('daemon.tar'), bytes);
    const found = JSON.parse(good('verify', 'daemon.tar', '--all'));
    assert.deepEqual([found.rows, found.equal, found.differences, found.report_compared], [36, 36, 0, true]);
    // It is what the command line writes of the same experiment, and of the daemon's own store.
    good('sweep', 'order.json', '--archive', 'plain.tar', '--out', 'plain.csv');
    assert.ok(bytes.equals(readFileSync(at('plain.tar'))));
    const noted = await fetch(new URL(`${links.archive}?container=${DIGEST}`, daemon.url));
    assert.ok(Buffer.from(await noted.arrayBuffer()).equals(readFileSync(at('a.tar'))));
    const partly = await fetch(new URL(links.archive, daemon.url), { headers: { range: 'bytes=512-1023' } });
    assert.equal(partly.status, 206);
    assert.ok(Buffer.from(await partly.arrayBuffer()).equals(bytes.subarray(512, 1024)));
  } finally {
    c.close();
    await daemon.stop();
  }
});

test('it is verified by a sample, by all rows, and by the same sample again', () => {
  const { version, made_by, seed, ...counts } = JSON.parse(good('verify', 'a.tar'));
  assert.equal(made_by, version);
  assert.deepEqual(counts, {
    container: DIGEST,
    rows: 36,
    compared: 20,
    equal: 20,
    skipped: 0,
    measured_metrics: 0,
    report_compared: true,
    differences: 0,
  });
  assert.equal(JSON.parse(good('verify', 'a.tar', '--all')).compared, 36);
  const again = JSON.parse(good('verify', 'a.tar', '--rows', '3', '--seed', `${seed}`));
  assert.deepEqual([again.compared, again.seed], [3, seed]);
});

test('a store gives the same bytes, for any number of threads', () => {
  good('sweep', 'order.json', '--jobs', '1', '--store', 'sqlite:runs.db', '--out', 'again.csv');
  good('export', 'b.tar', '--store', 'sqlite:runs.db', '--container', DIGEST);
  assert.ok(readFileSync(at('a.tar')).equals(readFileSync(at('b.tar'))));
  const { 0: id } = /\S+/.exec(good('store', 'list', '--store', 'sqlite:runs.db')) ?? [''];
  good('export', 'c.tar', '--store', 'sqlite:runs.db', '--experiment', id);
  assert.equal(JSON.parse(good('verify', 'c.tar', '--rows', '1')).container, null);
});

test('runs that were not needed, failed ones and measured metrics are no difference', () => {
  const order = {
    scenario: 'race',
    set: { duration_s: 2.5, 'players.0.link.up.loss_pct': 5 },
    axes: [{ path: 'players.0.lag_ms', values: [0, 80, 1000, 160] }],
    repeats: 20,
    interval: 't',
    until: { half_width: 1000, least: 10 },
    metrics: ['players.0.remote_error_m.mean', 'cost.ns_per_sim_s'],
  };
  writeFileSync(at('few.json'), JSON.stringify(order));
  good('sweep', 'few.json', '--archive', 'few.tar', '--out', 'few.csv');
  const found = JSON.parse(good('verify', 'few.tar', '--all'));
  assert.deepEqual([found.rows, found.compared + found.skipped, found.measured_metrics], [80, 80, 1]);
  assert.ok(found.skipped > 0 && found.equal === found.compared);
});

test('a damaged archive is refused, and so is what does not fit', () => {
  const bytes = readFileSync(at('a.tar'));
  const damaged = (/** @type {Buffer} */ content, /** @type {RegExp} */ said) => {
    writeFileSync(at('bad.tar'), content);
    const { status, stdout, stderr } = laglab('verify', 'bad.tar');
    assert.deepEqual([status, stdout], [2, ''], stderr);
    assert.match(stderr, said);
  };
  const text = bytes.toString('latin1');
  damaged(
    Buffer.from(text.replace('race', 'rice'), 'latin1'),
    /digest differs from that in SHA256SUMS: the archive is damaged or was changed/,
  );
  damaged(bytes.subarray(0, bytes.length / 2), /cut off/);
  damaged(Buffer.from('{}'), /cut off/);
  const refused = (/** @type {RegExp} */ said, /** @type {string[]} */ ...args) => {
    const { status, stderr } = laglab(...args);
    assert.equal(status, 2, stderr);
    assert.match(stderr, said);
  };
  refused(/needs an archive/, 'verify');
  refused(/cannot read/, 'verify', 'nothing.tar');
  refused(/--rows: must be a whole number from 1 to 10000000; got 0/, 'verify', 'a.tar', '--rows', '0');
  refused(/must not be given together/, 'verify', 'a.tar', '--rows', '3', '--all');
  refused(
    /--container: must be sha256: and 64 hexadecimal digits; got latest/,
    'export',
    'x.tar',
    '--store',
    'sqlite:runs.db',
    '--container',
    'latest',
  );
  refused(/needs the name/, 'export', '--store', 'sqlite:runs.db');
  refused(/--store: required/, 'export', 'x.tar');
  refused(/--archive: must be without --shard/, 'sweep', 'order.json', '--archive', 'x.tar', '--shard', '1/2');
  refused(/--container: must have --archive/, 'sweep', 'order.json', '--container', DIGEST);
});
