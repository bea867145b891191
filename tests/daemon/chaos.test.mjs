// An experiment on PostgreSQL while its workers are killed and frozen and its server crashes: every row once, and the same as without
// disturbances.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { execFileSync, spawn, spawnSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import { existsSync, mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { LEASE_S, crew, orbits, ownPostgres } from '../lib/chaos.mjs';
import { client, pause, waitFor } from '../lib/client.mjs';
import { BINARY, startDaemon } from '../lib/daemon.mjs';
import { RUNS } from '../lib/runs.mjs';

const { missing: skip, call: postgres, count } = ownPostgres();

let folder, url, undisturbed;
const file = (/** @type {string} */ name) => path.join(folder, name);
const checksum = (/** @type {string} */ name) =>
  createHash('sha256')
    .update(readFileSync(file(name)))
    .digest('hex');

/** @param {string[]} args */
function good(...args) {
  const { status, stdout, stderr } = spawnSync(BINARY, args, { cwd: folder, encoding: 'utf8', timeout: 120000 });
  assert.equal(status, 0, `laglab ${args.join(' ')}: ${stderr}`);
  return stdout;
}

/** Without waiting for it. @param {string[]} args @returns {Promise<{status: number, stderr: string}>} */
const outcome = (...args) =>
  new Promise((resolve) => {
    const child = spawn(BINARY, args, { cwd: folder, stdio: ['ignore', 'ignore', 'pipe'] });
    let stderr = '';
    child.stderr.setEncoding('utf8').on('data', (text) => {
      stderr += text;
    });
    child.once('close', (status) => resolve({ status: status ?? -1, stderr }));
  });

/** @param {string} name @param {number} runs */
function writeOrbits(name, runs) {
  writeFileSync(file(name), JSON.stringify(orbits(runs)));
  return name;
}

/** Polls, not so often that asking is what the machine does. @param {() => boolean} test */
async function until(test) {
  while (!test()) await pause(150);
}

before(() => {
  folder = mkdtempSync(path.join(tmpdir(), 'laglab-chaos-'));
  good('sweep', writeOrbits('orbits.json', RUNS), '--store', 'sqlite:undisturbed.db', '--out', 'undisturbed.csv');
  undisturbed = checksum('undisturbed.csv');
  if (!skip) url = postgres('start');
});
after(() => {
  if (!skip) postgres('remove');
  rmSync(folder, { recursive: true, force: true });
});

test('workers killed at random, one frozen beyond its lease, the server stopped at once twice: every row once', {
  skip,
  timeout: 110000,
}, async (t) => {
  const sweep = spawn(BINARY, ['sweep', 'orbits.json', '--store', url, '--jobs', '0', '--out', 'disturbed.csv'], {
    cwd: folder,
    stdio: ['ignore', 'inherit', 'pipe'],
  });
  let errors = '',
    code;
  sweep.stderr.setEncoding('utf8').on('data', (text) => {
    errors += text;
  });
  const ended = new Promise((resolve) => sweep.once('close', (status) => resolve((code = status))));
  const workers = crew(BINARY, url, 3);
  t.after(() => {
    sweep.kill('SIGKILL');
    return workers.dismiss();
  });
  const rows = () => count('SELECT count(*) FROM laglab.result');
  await until(() => count("SELECT (to_regclass('laglab.result') IS NOT NULL)::int") === 1);
  await until(() => rows() > 0);

  // By progress, not by time: on a slow machine the same chunk would be lost again and again, until it fails.
  let kills = 0;
  const killUntil = (/** @type {number} */ wanted) =>
    until(() => {
      const there = rows();
      if (there > (RUNS * kills) / 24) {
        kills++;
        workers.any()?.kill('SIGKILL');
      }
      return there > wanted;
    });
  for (const part of [0.2, 0.5]) {
    await killUntil(RUNS * part);
    postgres('kill');
    await pause(700);
    assert.equal(postgres('start'), url);
  }
  // A worker is frozen until others have taken over its chunk; then it continues and tries to store its rows.
  await until(() => workers.any() && count('SELECT count(*) FROM laglab.chunk WHERE state=1 AND lease_until>now()') > 0);
  const frozen = workers.any();
  frozen.kill('SIGSTOP');
  await pause(LEASE_S * 1000 + 500);
  frozen.kill('SIGCONT');
  await ended;
  assert.equal(code, 0, errors);
  await workers.dismiss();

  assert.equal(rows(), RUNS);
  assert.equal(count('SELECT count(DISTINCT run) FROM laglab.result'), RUNS);
  assert.equal(checksum('disturbed.csv'), undisturbed);
  const again = count('SELECT count(*) FROM laglab.chunk WHERE attempt>1');
  t.diagnostic(
    `${kills} kills, ${workers.hired()} workers, ${again} of ${count('SELECT count(*) FROM laglab.chunk')} chunks tried more than once`,
  );
  assert.ok(again > 0, 'nothing was disturbed');
});

test('the same from shards, one of which was killed', async () => {
  const shards = [1, 2, 3].map((i) => `shard${i}.csv`),
    command = (/** @type {number} */ i) => ['sweep', 'orbits.json', '--shard', `${i + 1}/3`, '--out', shards[i]];
  const killed = spawn(BINARY, command(1), { cwd: folder, stdio: 'ignore' });
  await waitFor(() => existsSync(file('shard2.csv.runs-wal')), 'the store', 10000);
  await pause(300);
  killed.kill('SIGKILL');
  for (let i = 0; i < 3; i++) good(...command(i));
  good('merge', 'orbits.json', ...shards, '--out', 'merged.csv');
  assert.equal(checksum('merged.csv'), undisturbed);
});

test('a daemon on the same store reports that the server is unreachable, and continues when it is back', { skip }, async (t) => {
  const daemon = await startDaemon({ args: ['--store', url, '--threads', '1'] });
  t.after(() => daemon.stop());
  const c = client(daemon.url);
  t.after(() => c.close());
  const made = (
    await c.call('POST', '/api/v1/experiments', { body: JSON.parse(readFileSync(file(writeOrbits('few.json', 1000)), 'utf8')) })
  ).json;
  postgres('kill');
  const away = await c.get(made.links.self);
  assert.equal(away.status, 503, away.text);
  assert.match(away.json.detail, /^server of the store postgresql:\/\/laglab@\/lab not usable/);
  postgres('start');
  await waitFor(async () => (await c.get(made.links.self)).json.state === 'done', 'the rows', 90000);
  good('sweep', 'few.json', '--out', 'few.csv');
  const rows = await c.get(made.links.results, { headers: { accept: 'text/csv' } });
  assert.equal(rows.text, readFileSync(file('few.csv'), 'utf8'));
});

// Sixty days ahead; the store's server is not.
const FAKETIME = `/usr/lib/${process.arch === 'arm64' ? 'aarch64' : 'x86_64'}-linux-gnu/faketime/libfaketimeMT.so.1`;
const AHEAD = ['env', `LD_PRELOAD=${FAKETIME}`, 'FAKETIME=+60d', 'FAKETIME_DONT_FAKE_MONOTONIC=1'];

test('experiments expire by the clock of the database, not of the daemon', {
  skip: skip || (!existsSync(FAKETIME) && 'libfaketime is not installed'),
}, async (t) => {
  const daemon = await startDaemon({ args: ['--store', url, '--threads', '1'] });
  const c = client(daemon.url);
  const made = (await c.call('POST', '/api/v1/experiments', { body: JSON.parse(readFileSync(file(writeOrbits('old.json', 10)), 'utf8')) }))
    .json;
  await waitFor(async () => (await c.get(made.links.self)).json.state === 'done', 'the rows', 20000);
  c.close();
  await daemon.stop();
  const status = async () => {
    const ahead = await startDaemon({ before: AHEAD, args: ['--store', url] });
    t.after(() => ahead.stop());
    const a = client(ahead.url);
    const { status: code, headers } = await a.get(made.links.self);
    assert.ok(Date.parse(headers.date) > Date.now() + 50 * 86400e3, 'its clock is ahead');
    a.close();
    return code;
  };
  assert.equal(await status(), 200);
  postgres('sql', 'UPDATE laglab.experiment SET created_s = created_s - 31 * 86400');
  assert.equal(await status(), 404);
});

const SFTP = '/usr/lib/openssh/sftp-server';
const noNet = () =>
  process.getuid?.() !== 0
    ? 'mounting needs root'
    : !existsSync(SFTP) || spawnSync('sshfs', ['--version']).error
      ? 'sshfs or its server is not installed'
      : false;

test('a store on a network file system is refused, and none is made there', { skip: noNet() }, async (t) => {
  const near = file('near'),
    far = file('far');
  mkdirSync(near);
  mkdirSync(far);
  const server = spawn(SFTP, { stdio: ['pipe', 'pipe', 'ignore'] });
  const mount = spawn('sshfs', ['-f', '-o', 'passive', `:${near}`, far], { stdio: ['pipe', 'pipe', 'pipe'] });
  let errors = '';
  mount.stderr.on('data', (text) => {
    errors += text;
  });
  server.stdout.pipe(mount.stdin);
  mount.stdout.pipe(server.stdin);
  const ended = new Promise((resolve) => mount.once('close', () => resolve(true)));
  const mounted = () => readFileSync('/proc/self/mounts', 'utf8').includes(` ${far} fuse.sshfs `);
  t.after(async () => {
    spawnSync('umount', ['-l', far]);
    mount.kill('SIGKILL');
    server.kill('SIGKILL');
    await ended;
  });
  if (await Promise.race([ended, waitFor(mounted, 'the mount', 10000).then(() => false)])) return t.skip(`no FUSE here: ${errors.trim()}`);
  // The process that waits for the file system must not be the one that serves it.
  const { status, stderr } = await outcome('sweep', writeOrbits('net.json', 100), '--out', 'far/net.csv');
  assert.equal(status, 2);
  assert.equal(
    stderr,
    'laglab: store far/net.csv.runs is on fuse.sshfs, where SQLite loses data: ' +
      'use a local folder, PostgreSQL, or --shard on each machine\n',
  );
  assert.deepEqual(readdirSync(near), []);
});

test('a full or read-only store is reported, and finished runs are not lost', {
  skip: process.getuid() !== 0 && 'mounting needs root',
}, (t) => {
  const disk = file('disk'),
    on = (/** @type {string[]} */ ...args) => spawnSync(BINARY, args, { cwd: disk, encoding: 'utf8', timeout: 60000 });
  mkdirSync(disk);
  const experiment = `../${writeOrbits('small.json', 3000)}`;
  try {
    execFileSync('mount', ['-t', 'tmpfs', '-o', 'size=400k', 'none', disk], { stdio: 'pipe' });
  } catch {
    return t.skip('no mounts here');
  }
  try {
    const full = on('sweep', experiment, '--out', 'rows.csv');
    assert.equal(full.status, 1);
    assert.equal(full.stderr, 'laglab: disk of the store rows.csv.runs is full\n');
    execFileSync('mount', ['-o', 'remount,size=20m', disk]);
    assert.equal(on('sweep', experiment, '--store', 'kept.db', '--out', 'kept.csv').status, 0);
    assert.equal(on('sweep', experiment, '--out', 'rows.csv').status, 0);
    assert.equal(checksum('disk/rows.csv'), checksum('disk/kept.csv'));
    execFileSync('mount', ['-o', 'remount,ro', disk]);
    assert.equal(on('sweep', experiment).stdout, readFileSync(file('disk/kept.csv'), 'utf8'), 'a store in memory needs no disk');
    const fixed = on('worker', '--store', 'kept.db', '--drain');
    assert.equal(fixed.status, 1);
    assert.equal(fixed.stderr, 'laglab: cannot write to the store kept.db: read-only file system\n');
  } finally {
    execFileSync('umount', ['-l', disk]);
  }
  const limited = spawnSync('prlimit', ['--fsize=60000', BINARY, 'sweep', experiment.slice(3), '--out', 'limited.csv'], {
    cwd: folder,
    encoding: 'utf8',
  });
  assert.equal(limited.status, 1);
  assert.match(limited.stderr, /^laglab: .* in the store limited.csv.runs failed: disk I\/O error\n$/);
});
