// Disks that are full, read-only, locked, of a newer laglab or damaged: each has a message, no change is acknowledged that is
// not stored, and sessions continue when the disk works again.
import assert from 'node:assert/strict';
import { execFileSync, spawn, spawnSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { test } from 'node:test';
import { client, pause, waitFor } from '../lib/client.mjs';
import { BINARY, startDaemon } from '../lib/daemon.mjs';

/** A daemon that is stopped at the end of the test, also when it fails. */
const start = async (t, wish) => {
  const daemon = await startDaemon(wish);
  t.after(() => daemon.stop());
  return daemon;
};

const folder = () => mkdtempSync(path.join(tmpdir(), 'laglab-test-'));
const remove = (name) => rmSync(name, { recursive: true, force: true });

/** Starts a daemon that should fail to start. */
function refusal(data, ...args) {
  const { status, stderr, stdout } = spawnSync(BINARY, ['serve', '--listen', '127.0.0.1:0', '--data', data, ...args], {
    encoding: 'utf8',
    timeout: 600000,
  });
  assert.equal(stdout, '');
  return {
    status,
    text: stderr
      .split('\n')
      .filter((line) => !line.startsWith('{'))
      .join('\n')
      .trim(),
  };
}

const python = (script, ...args) => execFileSync('python3', ['-c', script, ...args], { encoding: 'utf8' });
const has_python = spawnSync('python3', ['-c', 'import sqlite3']).status === 0;

/** Repeats a command until it is accepted. */
const recovered = (c, session) => waitFor(async () => (await c.control(session, { op: 'step' })).status === 200, 'the store to work');

/** Checks while the store fails. */
async function refusesChanges(c, session) {
  const log = (await c.get(session.links.log)).text;
  const { hash } = (await c.get(session.links.state)).json;
  for (const answer of [
    await c.patch(session, { 'players.0.lag_ms': 5 }),
    await c.control(session, { op: 'step' }),
    await c.call('POST', '/api/v1/sessions', { body: { scenario: 'race' } }),
    await c.call('POST', session.links.fork),
    await c.call('DELETE', session.links.self, { key: session.owner_key }),
  ]) {
    assert.equal(answer.status, 507, answer.text);
    assert.equal(answer.headers['content-type'], 'application/problem+json');
  }
  assert.equal((await c.get(session.links.log)).text, log);
  assert.equal((await c.get(session.links.state)).json.hash, hash);
  assert.match((await c.get('/metrics')).text, /^laglab_store_failing 1$/m);
}

test('a disk that is full', { skip: process.getuid() !== 0 && 'mounting a small disk needs root' }, async (t) => {
  const disk = folder();
  try {
    execFileSync('mount', ['-t', 'tmpfs', '-o', 'size=1m', 'none', disk], { stdio: 'pipe' });
  } catch {
    remove(disk);
    return t.skip('no mounts here');
  }
  try {
    let daemon = await start(t, { data: disk, args: ['--max-new-sessions-per-min', '10000', '--max-commands-per-s', '100000'] });
    let c = client(daemon.url);
    const session = await c.make({ paused: true });
    const acknowledged = [];
    let refused;
    for (let i = 0; i < 20000 && !refused; i++) {
      const answer = await c.patch(session, { 'players.0.lag_ms': i % 1000 });
      if (answer.status === 200) acknowledged.push(i % 1000);
      else refused = answer;
    }
    assert.equal(refused.status, 507, refused.text);
    assert.match(refused.json.detail, /full/);
    await refusesChanges(c, session);
    c.close();
    await daemon.kill();
    execFileSync('mount', ['-o', 'remount,size=8m', disk]);
    daemon = await start(t, { data: disk });
    c = client(daemon.url);
    const lines = (await c.get(session.links.log)).text
      .trimEnd()
      .split('\n')
      .map((line) => JSON.parse(line))
      .filter((line) => line.op === 'set');
    assert.deepEqual(
      lines.slice(0, acknowledged.length).map((line) => line.values['players.0.lag_ms']),
      acknowledged,
    );
    assert.ok(lines.length <= acknowledged.length + 1, 'at most the one that was in flight');
    t.diagnostic(`${acknowledged.length} commands fitted`);
    c.close();
    await daemon.stop();
  } finally {
    execFileSync('umount', ['-l', disk]);
    remove(disk);
  }
});

test('a disk without inodes', { skip: process.getuid() !== 0 && 'mounting a small disk needs root' }, async (t) => {
  const disk = folder(),
    more = (/** @type {number} */ i) => path.join(disk, `filler-${i}`);
  try {
    execFileSync('mount', ['-t', 'tmpfs', '-o', 'size=64m,nr_inodes=24', 'none', disk], { stdio: 'pipe' });
  } catch {
    remove(disk);
    return t.skip('no mounts here');
  }
  try {
    let daemon = await start(t, { data: disk });
    let c = client(daemon.url);
    const session = await c.make({ paused: true }),
      order = { scenario: 'race', set: { duration_s: 0.2 }, repeats: 20, metrics: ['players.0.own_lead_m.mean'] };
    let fillers = 0;
    for (let full = false; !full; ) {
      try {
        writeFileSync(more(fillers), '');
        fillers++;
      } catch (error) {
        assert.equal(error.code, 'ENOSPC');
        full = true;
      }
    }
    assert.ok(fillers > 0);
    // Requests that need no new file work; others are answered, or get a problem document.
    assert.equal((await c.patch(session, { 'players.0.lag_ms': 77 })).status, 200);
    const made = await c.call('POST', '/api/v1/experiments', { body: order });
    assert.ok([202, 507].includes(made.status), made.text);
    if (made.status === 202) {
      await waitFor(async () => (await c.get(made.json.links.self)).json.state !== 'running', 'the experiment');
      for (const format of ['csv', 'json', 'sqlite']) {
        const answer = await c.get(`${made.json.links.results}?format=${format}`);
        assert.ok(
          answer.status === 200 || (answer.status === 507 && answer.json.detail),
          `${format}: ${answer.status} ${answer.text.slice(0, 200)}`,
        );
      }
    }
    const { hash } = (await c.get(session.links.state)).json;
    c.close();
    await daemon.kill();
    const told = spawnSync(BINARY, ['serve', '--listen', '127.0.0.1:0', '--data', path.join(disk, 'new')], {
      encoding: 'utf8',
      timeout: 600000,
    });
    assert.equal(told.status, 1);
    assert.match(told.stderr, /laglab: .*(cannot be made|No space left)/);
    for (let i = 0; i < fillers; i++) rmSync(more(i));
    daemon = await start(t, { data: disk });
    c = client(daemon.url);
    assert.equal((await c.get(session.links.state)).json.hash, hash);
    assert.match((await c.get(session.links.log)).text, /"players.0.lag_ms":77/);
    assert.equal((await c.call('POST', '/api/v1/experiments', { body: order })).status, 202);
    c.close();
    await daemon.stop();
  } finally {
    execFileSync('umount', ['-l', disk]);
    remove(disk);
  }
});

test('files that may not grow for a while', async (t) => {
  const daemon = await start(t);
  const c = client(daemon.url),
    session = await c.make({ set: { 'players.0.control': 'person' } });
  const stream = await c.stream(session);
  stream.say({ auth: session.owner_key, id: 0 });
  const limit = (size) => execFileSync('prlimit', ['--pid', String(daemon.pid), `--fsize=${size}:unlimited`]);
  await c.control(session, { op: 'pause' });
  limit(0);
  assert.equal((await c.patch(session, { 'players.0.lag_ms': 99 })).status, 507, 'the one that finds out');
  await refusesChanges(c, session);
  stream.say({ input: { player: 0, axes: [1, 0] }, id: 1 });
  assert.equal((await stream.wait((each) => each.id === 1)).problem.status, 507);
  limit('unlimited');
  await recovered(c, session);
  stream.say({ input: { player: 0, axes: [1, 0] }, id: 2 });
  assert.equal((await stream.wait((each) => each.id === 2)).ok, true);
  const log = (await c.get(session.links.log)).text,
    state = (await c.get(session.links.state)).json;
  await stream.close();
  c.close();
  await daemon.kill();
  const again = await start(t, { data: daemon.data }),
    d = client(again.url);
  assert.equal((await d.get(session.links.log)).text, log);
  assert.equal((await d.get(`${session.links.state}?tick=${state.tick}`)).json.hash, state.hash);
  d.close();
  await again.stop();
  remove(daemon.data);
});

/** Locks a daemon's database until the function that it gives is called. */
async function lock(data) {
  const script = [
    'import sqlite3,sys',
    'db=sqlite3.connect(sys.argv[1],isolation_level=None)',
    'db.execute("BEGIN IMMEDIATE")',
    'print("locked",flush=True)',
    'sys.stdin.read()',
  ].join('\n');
  const locker = spawn('python3', ['-c', script, path.join(data, 'laglab.db')]);
  await new Promise((resolve) => locker.stdout.once('data', resolve));
  return () => {
    locker.stdin.end();
    return new Promise((resolve) => locker.once('close', resolve));
  };
}

test('a database that another program locks', { skip: !has_python }, async (t) => {
  const daemon = await start(t);
  const c = client(daemon.url),
    session = await c.make({ paused: true });
  const unlock = await lock(daemon.data);
  const refused = await c.patch(session, { 'players.0.lag_ms': 99 });
  assert.equal(refused.status, 507);
  assert.match(refused.json.detail, /locked by another program/);
  await refusesChanges(c, session);
  await unlock();
  await recovered(c, session);
  c.close();
  await daemon.stop();
});

test('a viewer that waits for a session while its deletion is stored gets 4404, or its hello when that fails', {
  skip: !has_python,
}, async (t) => {
  const daemon = await start(t, { args: ['--park-after-s', '0.2'] });
  const c = client(daemon.url);
  t.after(() => c.close());
  for (const stored of [true, false]) {
    // It takes long to wake: the deletion comes meanwhile.
    const session = await c.make({ scenario: 'eight', paused: true, set: { duration_s: 3600 } });
    assert.equal((await c.control(session, { op: 'seek', time_s: 700 })).status, 200);
    await waitFor(async () => /^laglab_sessions_parked 1$/m.test((await c.get('/metrics')).text), 'a parked session');
    const unlock = await lock(daemon.data),
      viewer = c.stream(session).catch((error) => error);
    await waitFor(async () => /^laglab_viewers 1$/m.test((await c.get('/metrics')).text), 'the viewer');
    const deleted = c.call('DELETE', session.links.self, { key: session.owner_key });
    await pause(900);
    if (stored) await unlock();
    assert.equal((await deleted).status, stored ? 204 : 507);
    const { code, reason, hello, close } = await viewer;
    if (stored) assert.deepEqual([code, reason], [4404, 'the session was deleted']);
    else assert.equal(hello?.type, 'hello', `${code} ${reason}`);
    if (stored) continue;
    await unlock();
    await close();
  }
});

test('failures at the start', { skip: !has_python }, async (t) => {
  const data = folder(),
    file = path.join(data, 'laglab.db');
  try {
    await (await start(t, { data })).stop();
    python('import sqlite3,sys\ndb=sqlite3.connect(sys.argv[1])\ndb.execute("PRAGMA user_version=77")\ndb.commit()', file);
    let told = refusal(data);
    assert.equal(told.status, 1);
    assert.match(told.text, /^laglab: Database in .* has schema 77, of a newer laglab; this one supports up to 1\.$/);
    writeFileSync(file, 'x'.repeat(5000));
    told = refusal(data);
    assert.equal(told.status, 1);
    assert.match(told.text, /damaged or not a database/);
  } finally {
    remove(data);
  }
  assert.match(refusal('/proc/laglab').text, /Cannot create data directory \/proc\/laglab/);
  const daemon = await start(t);
  assert.match(refusal(daemon.data).text, /in use by another laglab/);
  await daemon.stop();
});

test('a read-only disk', { skip: process.getuid() !== 0 && 'mounting needs root' }, async (t) => {
  const disk = folder();
  try {
    execFileSync('mount', ['-t', 'tmpfs', 'none', disk], { stdio: 'pipe' });
  } catch {
    remove(disk);
    return t.skip('no mounts here');
  }
  try {
    execFileSync('mount', ['-o', 'remount,ro', disk]);
    const told = refusal(disk);
    assert.equal(told.status, 1, 'nothing is there');
    assert.match(told.text, /Cannot write to .*: Read-only file system/);
  } finally {
    execFileSync('umount', ['-l', disk]);
    remove(disk);
  }
});

test('a damaged log affects only its own session', { skip: !has_python }, async (t) => {
  const data = folder();
  try {
    let daemon = await start(t, { data }),
      c = client(daemon.url);
    const good = await c.make({ paused: true }),
      bad = await c.make({ paused: true });
    c.close();
    await daemon.stop();
    python(
      `import sqlite3,sys
db=sqlite3.connect(sys.argv[1])
half="UPDATE log SET line='{\\"op\\":\\"set\\"' WHERE line_index=1 AND session=(SELECT number FROM sessions WHERE id=?)"
db.execute(half,(sys.argv[2],))
db.commit()`,
      path.join(data, 'laglab.db'),
      bad.id,
    );
    python(
      `import sqlite3,sys
db=sqlite3.connect(sys.argv[1])
db.execute("INSERT INTO log SELECT number,1,'{\\"op\\":\\"nonsense\\"}' FROM sessions WHERE id=? ON CONFLICT DO NOTHING",(sys.argv[2],))
db.commit()`,
      path.join(data, 'laglab.db'),
      bad.id,
    );
    daemon = await start(t, { data });
    c = client(daemon.url);
    assert.equal((await c.get(good.links.self)).status, 200);
    for (const part of ['self', 'state', 'metrics', 'trace', 'log']) {
      const answer = await c.get(bad.links[part]);
      assert.equal(answer.status, 507, part);
      assert.match(answer.json.detail, /cannot be replayed: line 2/);
    }
    await assert.rejects(c.stream(bad), { code: 1013 }, 'its viewers are sent away');
    assert.equal((await c.call('DELETE', bad.links.self, { key: bad.owner_key })).status, 204);
    c.close();
    await daemon.stop();
  } finally {
    remove(data);
  }
});

test('without a folder sessions are kept in memory', async (t) => {
  const data = folder();
  mkdirSync(path.join(data, 'home'));
  const daemon = await start(t, { data: 'memory' });
  const c = client(daemon.url),
    session = await c.make();
  await pause(50);
  assert.equal((await c.control(session, { op: 'pause' })).status, 200);
  assert.match(daemon.errors(), /kept in memory only/);
  c.close();
  assert.equal((await daemon.stop()).code, 0);
  remove(data);
});

test('options: a wrong one exits 2 with a message, --help lists all', () => {
  const run = (...args) => spawnSync(BINARY, ['serve', ...args], { encoding: 'utf8', timeout: 600000 });
  /** @type {[string[], string][]} */
  const wrong = [
    [['--nonsense', '1'], 'unknown option --nonsense'],
    [['--threads'], 'needs a value'],
    [['--threads', 'x'], '--threads'],
    [['--max-sessions', '0'], '--max-sessions'],
    [['--park-after-s=-1'], '--park-after-s'],
    [['--listen', 'nowhere:x', '--data', 'memory'], 'listen'],
  ];
  for (const [args, word] of wrong) {
    const { status, stderr, stdout } = run(...args);
    assert.equal(status, 2, `${args}: ${stderr}`);
    assert.ok(stderr.includes(word), stderr);
    assert.equal(stdout, '');
  }
  const help = run('--help');
  assert.equal(help.status, 0);
  for (const option of [
    '--listen',
    '--data',
    '--www',
    '--scenarios',
    '--threads',
    '--allow-host',
    '--allow-origin',
    '--max-body-bytes',
    '--session-ttl-s',
    '--max-sessions',
    '--max-viewers',
    '--max-connections',
  ])
    assert.ok(help.stdout.includes(`${option} `), option);
});
