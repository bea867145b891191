// Sweeps that are killed, and whose disk is full, read-only or on another machine: every row once, and the same as without disturbances.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { execFileSync, spawn, spawnSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import { existsSync, mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, statSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { waitFor } from '../lib/client.mjs';
import { BINARY } from '../lib/daemon.mjs';
import { stored } from '../lib/store.mjs';

const RUNS = 1200;

let folder, undisturbed;
const file = (/** @type {string} */ name) => path.join(folder, name);
const checksum = (/** @type {string} */ name) =>
  createHash('sha256')
    .update(readFileSync(file(name)))
    .digest('hex');

/** @param {string[]} args */
function good(...args) {
  const { status, stdout, stderr } = spawnSync(BINARY, args, { cwd: folder, encoding: 'utf8', timeout: 600000 });
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

/** Short runs: Kepler's orbit by one method. @param {string} name @param {number} runs */
function writeOrbits(name, runs, dt_s) {
  const count = runs / 10;
  const orbits = {
    scenario: { kind: 'motion', problem: 'kepler', duration_s: 1, methods: [{ method: 'rk4', dt_s }] },
    axes: [{ path: 'params.e', from: 0.1, to: 0.6, count }],
    repeats: 10,
    metrics: ['methods.0.e_final', 'methods.0.energy_drift_max'],
  };
  writeFileSync(file(name), JSON.stringify(orbits));
  return name;
}

before(() => {
  folder = mkdtempSync(path.join(tmpdir(), 'laglab-chaos-'));
  // Kills come by progress, for every length of a run; each test asserts that they come before the end.
  good('sweep', writeOrbits('orbits.json', RUNS, 0.0005), '--out', 'undisturbed.csv');
  undisturbed = checksum('undisturbed.csv');
});
after(() => rmSync(folder, { recursive: true, force: true }));

test('a sweep that is killed again and again: every row once', { timeout: 600000 }, async (t) => {
  const rows = () =>
    Number(execFileSync('sqlite3', [file('disturbed.csv.runs'), 'SELECT count(*) FROM result'], { encoding: 'utf8' }).trim());
  const counts = [0];
  for (;;) {
    const sweep = spawn(BINARY, ['sweep', 'orbits.json', '--jobs', '3', '--out', 'disturbed.csv'], { cwd: folder, stdio: 'inherit' });
    const ended = new Promise((resolve) => sweep.once('close', resolve));
    t.after(() => sweep.kill('SIGKILL'));
    // By progress, not by time: each transaction changes the log of the store.
    let writes = 0,
      before = 0;
    const look = setInterval(() => {
      const now = statSync(file('disturbed.csv.runs-wal'), { throwIfNoEntry: false })?.mtimeMs ?? 0;
      if (now > before) writes++;
      before = Math.max(before, now);
      if (counts.length < 8 && writes > 3 + counts.length) sweep.kill('SIGKILL');
    }, 10);
    const code = await ended;
    clearInterval(look);
    if (code === 0) break;
    assert.equal(code, null, 'it was killed');
    if (existsSync(file('disturbed.csv.runs'))) counts.push(rows());
  }
  assert.equal(checksum('disturbed.csv'), undisturbed);
  assert.equal(existsSync(file('disturbed.csv.runs')), false);
  t.diagnostic(`rows after each kill: ${counts.join(', ')} of ${RUNS}`);
  const steps = counts.filter((count, k) => k > 0 && count > counts[k - 1]).length;
  assert.ok(steps >= 3, 'what was stored before a kill was kept');
});

test('the same from shards, one of which was killed', async () => {
  const shards = [1, 2, 3].map((i) => `shard${i}.csv`),
    command = (/** @type {number} */ i) => ['sweep', 'orbits.json', '--shard', `${i + 1}/3`, '--out', shards[i]];
  const killed = spawn(BINARY, [...command(1), '--jobs', '1'], { cwd: folder, stdio: 'ignore' }),
    ended = new Promise((resolve) => killed.once('close', (_, signal) => resolve(signal)));
  await stored(file('shard2.csv'));
  killed.kill('SIGKILL');
  assert.equal(await ended, 'SIGKILL', 'it was at work');
  for (let i = 0; i < 3; i++) good(...command(i));
  good('merge', 'orbits.json', ...shards, '--out', 'merged.csv');
  assert.equal(checksum('merged.csv'), undisturbed);
});

const SFTP = '/usr/lib/openssh/sftp-server';
const noNet = () =>
  process.getuid?.() !== 0
    ? 'mounting needs root'
    : !existsSync(SFTP) || spawnSync('sshfs', ['--version']).error
      ? 'sshfs or its server is not installed'
      : false;

test('a sweep whose output is on a network file system goes on after it was killed', { skip: noNet() }, async (t) => {
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
  if (await Promise.race([ended, waitFor(mounted, 'the mount').then(() => false)])) return t.skip(`no FUSE here: ${errors.trim()}`);
  // The process that waits for the file system must not be the one that serves it.
  const sweep = spawn(BINARY, ['sweep', 'orbits.json', '--out', 'far/net.csv'], { cwd: folder, stdio: 'ignore' });
  await stored(file('near/net.csv'));
  const killed = new Promise((resolve) => sweep.once('close', resolve));
  sweep.kill('SIGKILL');
  assert.equal(await killed, null);
  const again = await outcome('sweep', 'orbits.json', '--out', 'far/net.csv');
  assert.deepEqual(again, { status: 0, stderr: '' });
  assert.equal(checksum('near/net.csv'), undisturbed);
  assert.deepEqual(readdirSync(near), ['net.csv']);
});

test('a full or read-only store is reported, and finished runs are not lost', {
  skip: process.getuid() !== 0 && 'mounting needs root',
}, (t) => {
  const disk = file('disk'),
    on = (/** @type {string[]} */ ...args) => spawnSync(BINARY, args, { cwd: disk, encoding: 'utf8', timeout: 600000 });
  mkdirSync(disk);
  const experiment = `../${writeOrbits('small.json', 3000, 0.01)}`;
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
    assert.equal(on('sweep', experiment, '--out', 'rows.csv').status, 0);
    assert.equal(on('sweep', experiment, '--out', 'whole.csv').status, 0);
    assert.equal(checksum('disk/rows.csv'), checksum('disk/whole.csv'));
    execFileSync('mount', ['-o', 'remount,ro', disk]);
    assert.equal(on('sweep', experiment).stdout, readFileSync(file('disk/rows.csv'), 'utf8'), 'a store in memory needs no disk');
    const fixed = on('sweep', experiment, '--out', 'again.csv');
    assert.equal(fixed.status, 1);
    assert.equal(fixed.stderr, 'laglab: cannot write to the store again.csv.runs: Read-only file system\n');
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
