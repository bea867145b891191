// Traces of a run: drawn positions, packets and corrections as tables, in every format.
import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { client, waitFor } from '../lib/client.mjs';
import { BINARY, startDaemon } from '../lib/daemon.mjs';

let folder;
const at = (/** @type {string} */ name) => path.join(folder, name);
const RUN = [
  'run',
  'contact',
  '--duration',
  '4',
  '--set',
  'warmup_s=0',
  '--set',
  'players.0.link.up.loss_pct=10',
  '--set',
  'players.0.lag_ms=60',
];
const laglab = (/** @type {string[]} */ ...args) => spawnSync(BINARY, args, { encoding: 'utf8', cwd: folder, maxBuffer: 1 << 28 });
const ndjson = (/** @type {string} */ name) =>
  readFileSync(at(name), 'utf8')
    .trim()
    .split('\n')
    .map((line) => JSON.parse(line));

/** @type {any} */
let result;
before(() => {
  folder = mkdtempSync(path.join(tmpdir(), 'laglab-trace-'));
  const orders = [
    'entities=drawn.ndjson',
    'entities=drawn.sqlite',
    'events=events.ndjson',
    'packets=packets.csv',
    'corrections=corrections.ndjson',
  ];
  const run = laglab(...RUN, '--trace', 'ticks.csv', ...orders.flatMap((order) => ['--trace-of', order]));
  assert.equal(run.status, 0, run.stderr);
  result = JSON.parse(run.stdout);
});
after(() => rmSync(folder, { recursive: true, force: true }));

/** Rows of a CSV without quotes, by column. @param {string} name */
function csv(name) {
  const [header = '', ...lines] = readFileSync(at(name), 'utf8').trim().split('\r\n');
  const names = header.split(',');
  return lines.map((line) => Object.fromEntries(line.split(',').map((cell, i) => [names[i], cell])));
}

test('drawn positions are those of the trace of ticks, for every view, entity and tick', () => {
  const rows = ndjson('drawn.ndjson'),
    ticks = csv('ticks.csv');
  assert.equal(ticks.length, result.ticks + 1);
  const entities = rows.length / ticks.length;
  assert.ok(Number.isInteger(entities) && entities >= 6, `${entities} rows a tick`); // the server and two players draw two cars each
  for (const [k, tick] of ticks.entries()) {
    const now = rows.slice(k * entities, (k + 1) * entities);
    assert.ok(now.every((row) => row.session_tick === k && Math.abs(row.time_s - Number(tick.time_s)) < 1e-8));
    for (const p of [0, 1]) {
      const drawn = now.find((row) => row.view === p + 1 && row.entity === p),
        truth = now.find((row) => row.view === 0 && row.entity === p);
      assert.ok(Math.abs(drawn.x_m - Number(tick[`player_${p}_own_x_m`])) < 2 ** -13, `tick ${k}`);
      assert.ok(Math.abs(truth.x_m - Number(tick[`server_${p}_x_m`])) < 2 ** -13, `tick ${k}`);
    }
  }
});

test('events are each there once: corrections, packets and their fates as the metrics count them', () => {
  const events = ndjson('events.ndjson'),
    corrections = ndjson('corrections.ndjson'),
    packets = csv('packets.csv');
  const count = (/** @type {(row: any) => boolean} */ which) => events.filter(which).length;
  for (const p of [0, 1]) {
    assert.equal(
      count((e) => e.type === 'correction' && e.player === p),
      result.metrics.players[p].corrections,
      `player ${p}`,
    );
  }
  assert.ok(corrections.length > 2);
  assert.deepEqual(
    corrections,
    events.filter((e) => e.type === 'correction' || e.type === 'rollback'),
  );
  const kinds = ['input', 'state', 'refusal', 'relay', 'connect', 'accept', 'ping', 'pong'];
  assert.equal(
    packets.length,
    count((e) => kinds.includes(e.type)),
  );
  const lost = packets.filter((e) => e.player === '0' && e.fate === 'lost' && ['input', 'ping', 'connect'].includes(e.type));
  assert.equal(lost.length, result.metrics.players[0].link_up.lost);
  assert.ok(lost.length > 10);
  // Each belongs to the tick by which it has happened.
  for (const e of events) assert.ok(e.begin_s < e.time_s + 1e-6, JSON.stringify(e));
});

/** Rows of a database of SQLite, in the order in which they were written. @param {string} name @returns {any[]} */
const sqlite = (name) =>
  JSON.parse(
    execFileSync('sqlite3', ['-json', at(name), 'SELECT * FROM results ORDER BY rowid'], { encoding: 'utf8', maxBuffer: 1 << 28 }),
  );

test('SQLite has the same rows as JSON lines', () => {
  const rows = ndjson('drawn.ndjson'),
    read = sqlite('drawn.sqlite');
  assert.equal(read.length, rows.length);
  for (const [k, row] of read.entries())
    for (const [name, value] of Object.entries(rows[k]))
      assert.equal(Number(row[name]) === Number(value) || row[name] === value, true, `${name} of row ${k}`);
});

test('ticks too have every format, with the values of the CSV', () => {
  const run = laglab(...RUN, '--trace', 'ticks.sqlite');
  assert.equal(run.status, 0, run.stderr);
  assert.equal(JSON.parse(run.stdout).hash, result.hash);
  const wanted = csv('ticks.csv'),
    rows = sqlite('ticks.sqlite');
  assert.equal(rows.length, wanted.length);
  assert.deepEqual(Object.keys(rows[0]), Object.keys(wanted[0] ?? {}));
  for (const name of ['time_s', 'tick', 'player_1_view_age_ms', 'server_0_x_m'])
    for (const [k, row] of rows.entries())
      assert.ok(Math.abs(Number(row[name]) - Number(wanted[k]?.[name])) <= 1e-8 * Math.abs(Number(row[name])), name);
});

test('other kinds have their records, and what is no table is refused before the run', () => {
  assert.equal(laglab('run', 'rigid/column', '--duration', '0.5', '--trace-of', 'shapes=shapes.csv').status, 0);
  assert.ok(csv('shapes.csv').length >= 31 * 2);
  const refused = (/** @type {RegExp} */ said, /** @type {string} */ order, scenario = 'race') => {
    const run = laglab('run', scenario, '--duration', '3600', '--trace-of', order);
    assert.equal(run.status, 2, run.stderr);
    assert.match(run.stderr, said);
  };
  refused(/--trace-of: must be one of events, packets, corrections, views, entities, .*; got paths/, 'paths=x.csv');
  refused(/--trace-of: must be RECORD=FILE; got entities/, 'entities');
  refused(/--trace-of: must be RECORD=FILE/, 'entities=');
  assert.equal(existsSync(at('x.csv')), false);
});

/** What each format has, as rows. @type {[string, string, (file: string) => Promise<any[]>][]} */
const FORMATS = [
  ['application/x-ndjson', 'rest.ndjson', async (name) => ndjson(name)],
  ['application/json', 'rest.json', async (name) => JSON.parse(readFileSync(at(name), 'utf8'))],
  ['text/csv', 'rest.csv', async (name) => csv(name)],
  ['application/vnd.sqlite3', 'rest.sqlite', async (name) => sqlite(name)],
];

/** A trace of a daemon in every format, each with the rows of the command line. @param {URL} url @param {any[]} wanted */
async function inEveryFormat(url, wanted) {
  for (const [type, name, read] of FORMATS) {
    const answer = await fetch(url, { headers: { accept: type } });
    assert.equal(answer.status, 200, `${url} ${type}`);
    assert.equal((answer.headers.get('content-type') ?? '').split(';')[0], type);
    assert.match(answer.headers.get('vary') ?? '', /\bAccept,/);
    writeFileSync(at(name), Buffer.from(await answer.arrayBuffer()));
    const rows = await read(name);
    assert.equal(rows.length, wanted.length, `${url} ${type}`);
    assert.deepEqual(Object.keys(rows[0]), Object.keys(wanted[0]), type);
    for (const [k, row] of rows.entries())
      for (const [column, value] of Object.entries(wanted[k]))
        if (typeof value === 'number') assert.equal(Number(row[column]), value, `${type}: ${column} of row ${k}`);
        else assert.equal(String(row[column] ?? ''), String(value ?? ''), `${type}: ${column} of row ${k}`);
  }
}

test('a daemon gives the same by Accept, of a session and of a run', async () => {
  const daemon = await startDaemon(),
    c = client(daemon.url);
  const set = { 'players.0.link.up.loss_pct': 10, 'players.0.lag_ms': 60, warmup_s: 0, duration_s: 4 };
  const within = (/** @type {any[]} */ rows, /** @type {number} */ from, /** @type {number} */ to) =>
    rows.filter((row) => row.session_tick >= from && row.session_tick <= to);
  try {
    const session = await c.make({ scenario: 'contact', set, paused: true });
    await c.control(session, { op: 'seek', time_s: 4 });
    const of = (/** @type {string} */ query) => new URL(`${session.links.trace}?${query}`, daemon.url);
    for (const name of ['events', 'corrections']) await inEveryFormat(of(`of=${name}`), ndjson(`${name}.ndjson`));
    await inEveryFormat(of('of=entities&from_s=1&to_s=1.5'), within(ndjson('drawn.ndjson'), 60, 90));
    // Events before the first tick are left out, and none is there twice.
    await inEveryFormat(of('of=events&from_s=1.2&to_s=2.7'), within(ndjson('events.ndjson'), 72, 162));
    const ticks = await (await fetch(of('format=json'))).json(),
      lines = csv('ticks.csv');
    assert.deepEqual(Object.keys(ticks[0]), Object.keys(lines[0] ?? {}));
    for (const [k, row] of ticks.entries())
      for (const name of ['time_s', 'tick', 'player_1_view_age_ms', 'server_0_x_m'])
        assert.ok(Math.abs(row[name] - Number(lines[k]?.[name])) <= 1e-8 * Math.abs(row[name]), name);
    assert.equal(await (await fetch(of(''))).text(), readFileSync(at('ticks.csv'), 'utf8'), 'without Accept it is CSV of ticks');

    const order = { scenario: 'contact', set, metrics: ['players.0.remote_error_m.mean'] };
    const { id } = (await c.call('POST', '/api/v1/experiments', { body: order })).json;
    await waitFor(async () => (await c.get(`/api/v1/experiments/${id}`)).json.state === 'done', 'the experiment');
    await inEveryFormat(new URL(`/api/v1/experiments/${id}/runs/0/trace?of=corrections`, daemon.url), ndjson('corrections.ndjson'));
    const refused = await c.get(`${session.links.trace}?of=paths`);
    assert.equal(refused.status, 400);
    assert.match(refused.json.detail, /^of: must be one of events, packets, corrections, views, entities, .*; got paths/);
  } finally {
    c.close();
    await daemon.stop();
  }
});
