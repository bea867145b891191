// The JavaScript client against a daemon: from the sources, as npm installs it from the daemon, and in a page of the daemon's own address.
import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { once } from 'node:events';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:net';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { promisify } from 'node:util';
import WebSocket from 'ws';
import { LaglabError, connect, leaves, specification, valueAt } from '../../clients/js/laglab.js';
import { BINARY, startDaemon } from '../lib/daemon.mjs';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
const ERROR = 'players.1.remote_error_m.mean';
const run = promisify(execFile);

let daemon, lab;
before(async () => {
  daemon = await startDaemon();
  lab = await connect(daemon.url);
});
after(() => daemon.stop());

async function printed(...args) {
  return JSON.parse((await run(BINARY, ['run', ...args], { maxBuffer: 1 << 24 })).stdout);
}

test('a run is that of the command line', async () => {
  const told = await printed('race', '--duration', '7', '--seed', '5', '--set', 'players.0.lag_ms=170');
  const result = await lab.run('race', { duration_s: 7, seed: 5, set: { 'players.0.lag_ms': 170 } });
  assert.equal(result.hash, told.hash);
  assert.deepEqual([result.seed, result.duration_s, result.ticks], [5, 7, 420]);
  assert.equal(result.at(ERROR), told.metrics.players[1].remote_error_m.mean);
  assert.ok(result.at(ERROR) > 0);
  for (const [at, value] of leaves(result.metrics)) assert.equal(valueAt(result.metrics, at), value);
});

test('a session moves, changes, forks, and is gone at the end', async () => {
  const session = await lab.session('race', { seed: 8, set: { 'players.0.lag_ms': 40, duration_s: 3, 'players.0.control': 'person' } });
  assert.equal((await session.step(60)).tick, 60);
  await session.set({ 'players.1.lag_ms': 333 });
  await session.input(0, [1, 0]);
  assert.equal((await session.info()).params.players[1].lag_ms, 333);
  const position = await session.finish();
  assert.equal(position.tick, 180);
  assert.equal(typeof (await session.metric(ERROR)), 'number');
  assert.equal((await session.trace()).trim().split('\n').length, 182);
  assert.deepEqual(
    (await session.table({ from_s: 1, to_s: 1.5 })).map((row) => row.tick),
    Array.from({ length: 31 }, (_, i) => 60 + i),
  );
  assert.ok((await session.table({ of: 'packets', to_s: 1 })).some((row) => row.type === 'input' && row.player === 0));
  assert.equal((await session.state(60)).tick, 60);
  const fork = await session.fork();
  assert.equal((await fork.info()).tick, 180);
  await assert.rejects((await lab.attach(session.id)).pause(), (/** @type {any} */ error) => [401, 403].includes(error.status));
  await assert.rejects(session.set({ 'players.1.lag_ms': -4 }), (/** @type {any} */ error) => {
    assert.ok(error instanceof LaglabError && error.status === 400);
    assert.match(error.fields['players.1.lag_ms'], /must be 0 to/);
    return true;
  });
  for (const one of [session, fork]) await one.delete();
  await assert.rejects(session.info(), { name: 'LaglabError', status: 404 });
  await assert.rejects(session.stream().next(), { name: 'LaglabError', status: 404 });
});

/** Frames of a session that plays, until they have come 20 times. */
async function watch(session) {
  const frames = [];
  for await (const frame of session.stream({ scene: 30, session: 30 })) {
    frames.push(frame);
    if (frames.length === 20) break;
  }
  return frames;
}

const SOCKETS = { 'of its own': undefined, 'of the platform, as browsers have it': WebSocket };
for (const [name, socket] of Object.entries(SOCKETS)) {
  test(`frames come while it plays, and say what the state says: by a socket ${name}`, async () => {
    const before = globalThis.WebSocket;
    globalThis.WebSocket = /** @type {any} */ (socket);
    try {
      await framesAgree();
    } finally {
      globalThis.WebSocket = before;
    }
  });
}

async function framesAgree() {
  const session = await lab.session('race', { playing: true });
  const frames = await watch(session),
    ticks = frames.map(({ tick }) => tick);
  assert.deepEqual(
    ticks,
    [...ticks].sort((a, b) => a - b),
  );
  assert.ok(ticks[19] > ticks[0]);
  await session.pause();
  const last = frames[19],
    { state } = await session.state(last.tick);
  assert.equal(last.entities.length, 6); // two cars as the server and two clients see them
  const server = last.entities.filter(({ view }) => view === 0);
  server.forEach(({ x }, i) =>
    assert.ok(Math.abs(x - state.server.entities[i].x) < 0.01, `${x} ${JSON.stringify(state.server.entities[i])}`),
  );
  await session.delete();
}

test('large frames, which come deflated', async () => {
  const session = await lab.session('fluid/dam_break', { playing: true });
  let rows = 0;
  for await (const frame of session.stream({ points: 60, field: 60 })) {
    rows = Math.max(0, ...[...frame.sections.values()].map(({ count }) => count));
    if (rows > 100) break;
  }
  assert.ok(rows > 100);
  await session.delete();
});

test('an experiment reports its progress, and its rows are those of a sweep', async () => {
  const order = {
    axes: { lag: { little: { 'players.0.lag_ms': 20 }, much: { 'players.0.lag_ms': 180 } } },
    repeats: 4,
    metrics: [ERROR],
    set: { duration_s: 3 },
  };
  const experiment = await lab.experiment('race', order),
    seen = [];
  await experiment.wait((message) => seen.push(message));
  assert.equal(seen[0].type, 'hello');
  assert.equal(seen.at(-1).done, 8);
  const rows = await experiment.table();
  writeFileSync(path.join(daemon.data, 'order.json'), JSON.stringify(specification('race', order)));
  const local = JSON.parse((await run(BINARY, ['sweep', path.join(daemon.data, 'order.json'), '--format', 'json'])).stdout);
  assert.deepEqual(
    rows.map((row) => row.hash),
    local.map((/** @type {any} */ row) => row.hash),
  );
  assert.deepEqual(
    rows.map((row) => row.lag),
    ['little', 'little', 'little', 'little', 'much', 'much', 'much', 'much'],
  );
  assert.equal((await experiment.table({ points: true })).length, 2);
  assert.match(await experiment.report(), /id="point-data"/);
  const session = await experiment.open(3);
  assert.equal((await session.info()).tick, 0);
  await session.delete();
  await experiment.delete();
});

test('what is wrong is said before a request, or by the daemon', async () => {
  for (const technique of [{}, { a: {} }, { a: { x: 1 }, b: { y: 1 } }, { a: { x: 1 }, b: { x: 1 } }]) {
    assert.throws(() => specification('race', { axes: { technique } }), LaglabError);
  }
  await assert.rejects(lab.run('race', { duration_s: -3 }), /duration_s: must be .*got -3/);
  const closed = createServer().listen(0, '127.0.0.1');
  await once(closed, 'listening');
  const { port } = /** @type {import('node:net').AddressInfo} */ (closed.address());
  await new Promise((resolve) => closed.close(resolve));
  await assert.rejects(connect(`http://127.0.0.1:${port}`), new RegExp(`127\\.0\\.0\\.1:${port}.*ECONNREFUSED`));
  assert.throws(() => valueAt({ players: [{ a: 1 }] }, 'players.0.b'), /players\.0 has a/);
  const cancelled = await lab.experiment('race', {
    axes: { 'players.0.lag_ms': [1, 2] },
    repeats: 2000,
    metrics: [ERROR],
    set: { duration_s: 600 },
  });
  await cancelled.control('cancel');
  await assert.rejects(cancelled.wait(), /the experiment is cancelled/);
  await cancelled.delete();
});

test('a package without types, as it is where nothing makes them, does not name any', async () => {
  const folder = mkdtempSync(path.join(tmpdir(), 'laglab-pack-'));
  try {
    await run('python3', [path.join(ROOT, 'clients/js/pack.py'), folder]);
    const tar = async (/** @type {string[]} */ ...args) => (await run('tar', [...args], { cwd: folder })).stdout;
    const names = (await tar('-tzf', 'laglab-0.2.0.tgz')).trim().split('\n');
    assert.ok(names.includes('package/clients/js/laglab.js'));
    assert.deepEqual(
      names.filter((name) => name.endsWith('.d.ts')),
      [],
    );
    const { exports } = JSON.parse(await tar('-xOzf', 'laglab-0.2.0.tgz', 'package/package.json'));
    assert.deepEqual(exports, { '.': { default: './clients/js/laglab.js' } });
  } finally {
    rmSync(folder, { recursive: true });
  }
});

test('the package that a daemon serves is installed by npm, offline, and has types', async () => {
  const folder = mkdtempSync(path.join(tmpdir(), 'laglab-npm-'));
  try {
    const answer = await fetch(`${daemon.url}clients/laglab-0.2.0.tgz`);
    assert.equal(answer.status, 200);
    writeFileSync(path.join(folder, 'laglab.tgz'), Buffer.from(await answer.arrayBuffer()));
    writeFileSync(path.join(folder, 'package.json'), '{"type":"module"}');
    const environment = { ...process.env, npm_config_offline: 'true', npm_config_cache: path.join(folder, 'cache') };
    await run('npm', ['install', '--no-audit', '--no-fund', './laglab.tgz'], { cwd: folder, env: environment });
    writeFileSync(
      path.join(folder, 'program.ts'),
      `import { connect, EVENTS_TYPE, type Answer, type Schemas, type Session } from 'laglab';
const lab = await connect(process.argv[2] ?? '');
const session: Session = await lab.session('race', { playing: true });
const info: Answer<'getSession'> = await session.info();
const speed: number = info.speed;
if (info.params.kind === 'netgame') {
  const lag: number | undefined = info.params.players?.[0]?.lag_ms;
  // @ts-expect-error a player has no such parameter
  info.params.players?.[0]?.lagg_ms;
  console.log(typeof speed, typeof lag);
}
// @ts-expect-error a session has no such member
info.pace;
// @ts-expect-error an experiment's metrics are texts
const wish: Partial<Schemas['Experiment']> = { metrics: [1] };
for await (const frame of session.stream({ scene: 60 })) {
  const car = frame.entities[0];
  if (car) {
    const x: number = car.x;
    // @ts-expect-error a record has no such field
    car.colour;
    console.log(typeof x, typeof EVENTS_TYPE.input);
    break;
  }
}
await session.delete();
`,
    );
    const types = ['--types', 'node', '--typeRoots', path.join(ROOT, 'node_modules/@types'), '--lib', 'es2022,dom,dom.iterable'];
    const compile = ['--strict', '--target', 'es2022', '--module', 'nodenext', '--skipLibCheck', ...types, 'program.ts'];
    await run(path.join(ROOT, 'node_modules/.bin/tsc'), compile, { cwd: folder }).catch((error) => assert.fail(error.stdout));
    assert.deepEqual((await run(process.execPath, ['program.js', daemon.url], { cwd: folder })).stdout.split('\n'), [
      'number number',
      'number number',
      '',
    ]);
  } finally {
    rmSync(folder, { recursive: true, force: true });
  }
});

test('a daemon serves the client to pages, as one module that works there', async () => {
  const answer = await fetch(new URL('clients/js/laglab.js', daemon.url)),
    text = await answer.text();
  assert.match(answer.headers.get('content-type') ?? '', /javascript/);
  assert.doesNotMatch(text, /\bfrom\s*["']|\bimport\s*["']/);
  const served = await import(`data:text/javascript,${encodeURIComponent(text)}`),
    lab = await served.connect(daemon.url);
  assert.deepEqual(Object.keys(served).sort(), Object.keys(await import('../../clients/js/laglab.js')).sort());
  assert.equal((await lab.run('race', { duration_s: 1 })).hash, (await (await connect(daemon.url)).run('race', { duration_s: 1 })).hash);
});

test('a daemon serves the examples, and every client has the version of the program', async () => {
  for (const [name, source] of [
    ['techniques.ipynb', 'python/examples'],
    ['techniques.R', 'r'],
    ['techniques.json', 'r'],
  ]) {
    const answer = await fetch(new URL(`clients/${name}`, daemon.url));
    assert.equal(await answer.text(), readFileSync(path.join(ROOT, 'clients', source, name), 'utf8'));
  }
  const [, version] = /^project\(laglab VERSION (\S+)/m.exec(readFileSync(path.join(ROOT, 'CMakeLists.txt'), 'utf8'));
  for (const [file, said] of [
    ['clients/js/package.json', `"version": "${version}"`],
    ['clients/python/laglab/__init__.py', `__version__ = "${version}"`],
    ['CITATION.cff', `\nversion: ${version}\n`],
  ]) {
    assert.ok(readFileSync(path.join(ROOT, file), 'utf8').includes(said), file);
  }
});
