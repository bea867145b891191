// Experiments of the daemon: made, watched, paused, resumed after a crash, and read in every format.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { execFile, execFileSync, spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { promisify } from 'node:util';
import { client, HANG_MS, pause, waitFor } from '../lib/client.mjs';
import { BINARY, startDaemon } from '../lib/daemon.mjs';

const E = '/api/v1/experiments';
const experiment = (repeats = 4) => ({
  title: 'Lag and error',
  scenario: 'race',
  set: { duration_s: 3 },
  repeats,
  axes: [
    { path: 'players.0.lag_ms', values: [0, 100, 200] },
    { path: 'players.0.link.up.jitter_ms', values: [0, 30] },
  ],
  metrics: ['players.0.own_lead_m.mean', 'players.0.bandwidth.down_bytes_per_s'],
});

let daemon, c;
before(async () => {
  daemon = await startDaemon();
  c = client(daemon.url);
});
after(async () => {
  c.close();
  await daemon.stop();
});

/** @param {string} id */
const state = async (id, who = c) => (await who.get(`${E}/${id}`)).json;
const ended = (/** @type {string} */ id, who = c) =>
  waitFor(
    async () => {
      const now = await state(id, who);
      return now.state === 'done' && now;
    },
    'the experiment',
    10 * HANG_MS,
  );

/** What the command line makes of the same experiment. */
function sweep(order, format = 'csv', more = /** @type {string[]} */ ([])) {
  const result = spawnSync(BINARY, ['sweep', '-', '--format', format, ...more], {
    input: JSON.stringify(order),
    encoding: 'utf8',
    maxBuffer: 1 << 28,
  });
  assert.equal(result.status, 0, result.stderr);
  return result.stdout;
}

test('rows are those of the command line, in each format and by Accept', async () => {
  const { id } = (await c.call('POST', E, { body: experiment() })).json;
  const now = await ended(id);
  assert.deepEqual([now.title, now.done, now.runs, now.points], ['Lag and error', 24, 24, 6]);
  assert.equal(now.experiment.scenario.kind, 'netgame', 'the scenario is in it');
  const csv = await c.get(`${E}/${id}/results`);
  assert.equal(csv.headers['content-type'], 'text/csv; charset=utf-8');
  assert.equal(csv.text, sweep(experiment()));
  assert.equal((await c.get(`${E}/${id}/results`, { headers: { accept: 'application/x-ndjson' } })).text, sweep(experiment(), 'ndjson'));
  assert.equal((await c.get(`${E}/${id}/results?format=json`)).text, sweep(experiment(), 'json'));
  assert.equal(
    (await c.get(`${E}/${id}/results`, { headers: { accept: 'text/csv;q=0.1, application/json' } })).headers['content-type'],
    'application/json',
  );
  const points = (await c.get(`${E}/${id}/results?points=true&format=json`)).json;
  assert.equal(points.length, 6);
  assert.match(points[0]['players.0.own_lead_m.mean.ci95_method'], /^none: fewer than 10 runs have it$/); // there are four
  const compared = (await c.get(`${E}/${id}/results?points=true&compare=3&format=json`)).json,
    lead = 'players.0.own_lead_m.mean';
  for (const [i, point] of compared.entries()) assert.ok(Math.abs(point[`${lead}.diff`] - (points[i][lead] - points[3][lead])) < 1e-9);
  for (const [query, words] of [
    ['points=true&compare=6', /compare: must be a point from 0 to 5; got 6/],
    ['points=true&compare=x.y=1', /x.y is not on an axis/],
    ['sensitivity=true', /saltelli/],
  ]) {
    const refused = await c.get(`${E}/${id}/results?${query}`);
    assert.equal(refused.status, 400);
    assert.match(refused.json.detail, /** @type {RegExp} */ (words));
  }
  const sampled = {
    ...experiment(),
    sample: { method: 'saltelli', count: 4 },
    repeats: 1,
    axes: [{ path: 'players.0.lag_ms', from: 0, to: 100 }],
  };
  const of = (await c.call('POST', E, { body: sampled })).json.id;
  await ended(of);
  const indices = (await c.get(`${E}/${of}/results?sensitivity=true&format=json`)).json;
  assert.deepEqual([indices[0].parameter, indices[0].samples, indices[0].first_low], ['players.0.lag_ms', 4, null]);
});

test('runs until a mean is known are as many as by the command line', async () => {
  const order = { ...experiment(60), until: { metric: 'players.0.own_lead_m.mean', half_width: 0.15, least: 12 } };
  const { id } = (await c.call('POST', E, { body: order })).json;
  await ended(id);
  const rows = (await c.get(`${E}/${id}/results`)).text;
  assert.ok(rows.includes(',skipped,') && rows.split(',ok,').length < 361, 'some runs were not needed');
  assert.equal(rows, sweep(order));
});

test('a run is opened live from its scenario, and is the same run', async () => {
  const { id } = (await c.call('POST', E, { body: experiment() })).json;
  await ended(id);
  const row = (await c.get(`${E}/${id}/results?format=json`)).json[17];
  const scenario = (await c.get(`${E}/${id}/runs/17`)).json;
  assert.equal(scenario.seed, row.seed);
  const session = await c.make({ scenario, paused: true });
  await c.control(session, { op: 'seek', time_s: 3 });
  assert.equal((await c.get(`/api/v1/sessions/${session.id}/state`)).json.hash, row.hash);
});

test('a workload goes with the experiment, and a run of it is opened live', async () => {
  const inputs = [...Array(40)].map((_, i) => ({ tick: 7 * i, player: i % 2, axes: [(i % 5) / 4, 0], buttons: 0 }));
  const order = {
    ...experiment(2),
    set: { duration_s: 3, 'players.0.control': 'person', 'players.1.control': 'person' },
    workload: { tick_hz: 50, inputs },
  };
  const { id } = (await c.call('POST', E, { body: order })).json;
  const now = await ended(id);
  assert.deepEqual(now.experiment.workload, { tick_hz: 50, inputs });
  assert.equal((await c.get(`${E}/${id}/results`)).text, sweep(order));
  const row = (await c.get(`${E}/${id}/results?format=json`)).json[7],
    scenario = (await c.get(`${E}/${id}/runs/7`)).json;
  const session = await c.make({ scenario, workload: now.experiment.workload, paused: true });
  assert.equal((await c.get(`/api/v1/sessions/${session.id}`)).json.tick, 0);
  await c.control(session, { op: 'seek', time_s: 3 });
  assert.equal((await c.get(`/api/v1/sessions/${session.id}/state`)).json.hash, row.hash);
  // its log is a workload again, as text
  const log = (await c.get(`/api/v1/sessions/${session.id}/log`)).text;
  const again = await c.make({ scenario, workload: log, paused: true });
  await c.control(again, { op: 'seek', time_s: 3 });
  assert.equal((await c.get(`/api/v1/sessions/${again.id}/state`)).json.hash, row.hash);
  for (const [workload, sentence] of /** @type {[unknown, RegExp][]} */ ([
    [{ inputs: [{ tick: 0, player: 3, axes: [0, 0] }] }, /player: must be 0 to 1; got 3/],
    [{ inputs: [{ tick: 0, player: 0, axes: [0, 2] }] }, /workload\.inputs\.0: axes: must be two numbers from -1 to 1; got 2/],
    ['drive.log', /line 1 of the log/],
  ])) {
    const refused = await c.call('POST', E, { body: { ...order, workload } });
    assert.equal(refused.status, 400);
    assert.match(refused.json.detail, sentence);
    assert.equal((await c.call('POST', '/api/v1/sessions', { body: { scenario, workload } })).status, 400);
  }
  assert.equal((await c.call('POST', '/api/v1/sessions', { body: { scenario: 'race', workload: order.workload } })).status, 409);
});

test('the trace of a run is that of its scenario alone', async () => {
  const { id } = (await c.call('POST', E, { body: experiment() })).json;
  const scenario = (await c.get(`${E}/${id}/runs/17`)).text,
    folder = mkdtempSync(path.join(tmpdir(), 'laglab-trace-'));
  try {
    const run = spawnSync(BINARY, ['run', '-', '--trace', path.join(folder, 'trace.csv')], { input: scenario, encoding: 'utf8' });
    assert.equal(run.status, 0, run.stderr);
    const trace = await c.get(`${E}/${id}/runs/17/trace`);
    assert.equal(trace.headers['content-type'], 'text/csv; charset=utf-8');
    assert.equal(trace.text, readFileSync(path.join(folder, 'trace.csv'), 'utf8'));
    assert.notEqual(trace.text, (await c.get(`${E}/${id}/runs/0/trace`)).text);
  } finally {
    rmSync(folder, { recursive: true, force: true });
  }
});

test('what is over and had its time is deleted when the next is made, and at the start; what is paused is not', async () => {
  const data = mkdtempSync(path.join(tmpdir(), 'laglab-expired-')),
    args = ['--experiment-ttl-s', '1'];
  try {
    const first = await startDaemon({ data, args });
    const one = client(first.url);
    const old = (await one.call('POST', E, { body: experiment(1) })).json;
    const held = (await one.call('POST', E, { body: experiment(4000) })).json;
    await one.call('POST', `${E}/${held.id}/control`, { key: held.owner_key, body: { op: 'pause' } });
    await ended(old.id, one);
    await pause(2100);
    const next = (await one.call('POST', E, { body: experiment(1) })).json;
    assert.equal((await one.get(`${E}/${old.id}`)).status, 404);
    assert.equal((await one.get(`${E}/${held.id}`)).json.state, 'paused');
    await ended(next.id, one);
    one.close();
    await first.stop();
    await pause(2100);
    const second = await startDaemon({ data, args });
    const two = client(second.url);
    assert.equal((await two.get(`${E}/${next.id}`)).status, 404);
    assert.equal((await two.get(`${E}/${held.id}`)).json.state, 'paused');
    two.close();
    await second.stop();
  } finally {
    rmSync(data, { recursive: true, force: true });
  }
});

test('pause holds it, resume lets it go on, cancel keeps its rows', async () => {
  const made = (await c.call('POST', E, { body: experiment(4000) })).json;
  const control = (op) => c.call('POST', `${E}/${made.id}/control`, { key: made.owner_key, body: { op } });
  await waitFor(async () => (await state(made.id)).done > 0, 'the first rows');
  assert.equal((await control('pause')).json.state, 'paused');
  // What was being run is finished; then nothing moves.
  let held = await state(made.id);
  await waitFor(async () => {
    await pause(400);
    const now = await state(made.id);
    const same = now.done === held.done;
    held = now;
    return same;
  }, 'it to hold');
  assert.ok(held.done < held.runs);
  assert.deepEqual([held.state, held.rate_per_s, held.left_s], ['paused', 0, null]);
  assert.equal((await control('resume')).json.state, 'running');
  await waitFor(async () => (await state(made.id)).done > held.done, 'more rows');
  await waitFor(async () => {
    const moving = await state(made.id);
    return moving.rate_per_s > 0 && moving.left_s > 0;
  }, 'its rate');
  assert.equal((await control('cancel')).json.state, 'cancelled');
  assert.equal((await control('resume')).status, 409);
  const rows = (await c.get(`${E}/${made.id}/results`)).text.split('\r\n').length - 2;
  assert.ok(rows >= held.done);
  assert.equal((await c.call('DELETE', `${E}/${made.id}`, { key: made.owner_key })).status, 204);
});

test('an experiment of another version is left alone by a daemon, which names both versions', async (t) => {
  const other = '0.0.9+0123456789ab',
    own = spawnSync(BINARY, ['--version'], { encoding: 'utf8' }).stdout.trim().split(' ')[1],
    data = mkdtempSync(path.join(tmpdir(), 'laglab-experiments-'));
  const sql = (/** @type {string} */ text) =>
    execFileSync('sqlite3', [path.join(data, 'experiments.db'), text], { encoding: 'utf8' }).trim();
  const namesVersions = (/** @type {string} */ text) => {
    for (const words of [other, own, 'run the experiment again']) assert.ok(text.includes(words), text);
  };
  const first = await startDaemon({ data, args: ['--threads', '1'] }),
    one = client(first.url);
  t.after(() => rmSync(data, { recursive: true, force: true }));
  const made = (await one.call('POST', E, { body: experiment(4000) })).json;
  await waitFor(async () => (await state(made.id, one)).done > 0, 'the first rows');
  const before = await state(made.id, one);
  assert.deepEqual([before.version, before.held_back], [own, null]);
  one.close();
  await first.stop();
  const rows = sql(`UPDATE experiment SET version='${other}'; SELECT count(*) FROM result`);
  const second = await startDaemon({ data, args: ['--threads', '1'] }),
    c = client(second.url);
  t.after(() => second.stop());
  t.after(() => c.close());
  assert.equal((await state(made.id, c)).state, 'running');
  namesVersions((await state(made.id, c)).held_back);
  const refused = await c.call('POST', `${E}/${made.id}/control`, { key: made.owner_key, body: { op: 'resume' } });
  assert.equal(refused.status, 409);
  namesVersions(refused.json.detail);
  const table = (await c.get(made.links.results)).text.split('\r\n').slice(1, -1);
  assert.equal(table.length, Number(rows), 'it added none');
  assert.ok(table.every((row) => row.endsWith(`,${other}`)));
});

test('what a killed daemon had begun, the next one finishes: every row once', async () => {
  const data = mkdtempSync(path.join(tmpdir(), 'laglab-experiments-'));
  try {
    const first = await startDaemon({ data });
    const one = client(first.url);
    const { id, owner_key: key } = (await one.call('POST', E, { body: experiment(1500) })).json;
    await waitFor(async () => (await state(id, one)).done > 0, 'the first rows');
    assert.notEqual((await state(id, one)).state, 'done');
    await first.kill();
    one.close();
    const second = await startDaemon({ data });
    const two = client(second.url);
    await ended(id, two);
    assert.equal((await two.get(`${E}/${id}/results`)).text, sweep(experiment(1500)));
    assert.equal((await two.call('DELETE', `${E}/${id}`, { key })).status, 204, 'its key still is its key');
    two.close();
    await second.stop();
  } finally {
    rmSync(data, { recursive: true, force: true });
  }
});

test('the examples by curl, Python and Node print the same rows', async () => {
  const folder = path.join(path.dirname(fileURLToPath(import.meta.url)), '../../examples');
  const wanted = sweep(JSON.parse(readFileSync(path.join(folder, 'experiment.json'), 'utf8')), 'csv', ['--points']);
  for (const [program, file] of [
    ['sh', 'experiment.sh'],
    ['python3', 'experiment.py'],
    ['node', 'experiment.mjs'],
  ]) {
    const { stdout } = await promisify(execFile)(program, [path.join(folder, file), daemon.url.replace(/\/$/, '')], { timeout: 600000 });
    assert.equal(stdout, wanted, file);
  }
});

test('a message about a limit has its number', async () => {
  const strict = await startDaemon({ args: ['--max-experiments', '1', '--max-experiment-runs', '30'] });
  const s = client(strict.url);
  try {
    const large = await s.call('POST', E, { body: experiment(6) });
    assert.equal(large.status, 400);
    assert.match(large.json.detail, /36 runs.*at most 30/);
    assert.equal((await s.call('POST', E, { body: experiment() })).status, 202);
    const second = await s.call('POST', E, { body: experiment() });
    assert.equal(second.status, 429);
    assert.match(second.json.detail, /Limit of 1 experiments reached/);
  } finally {
    s.close();
    await strict.stop();
  }
});

test('metrics in windows are columns, and a bad window is answered with its field and what it may be', async () => {
  const order = {
    ...experiment(2),
    windows: [
      { name: 'early', to_s: 2.5 },
      { name: 'late', from_s: 2.5 },
      { name: 'lagged', while: { value: 'players.0.lag_ms', above: 50 } },
    ],
    metrics: ['early', 'late', 'lagged'].map((name) => `players.0.own_lead_m.mean@${name}`).concat('player_0_own_lead_m.p95@late'),
  };
  const { id } = (await c.call('POST', E, { body: order })).json;
  await ended(id);
  const csv = (await c.get(`${E}/${id}/results`)).text;
  assert.equal(csv, sweep(order));
  assert.match(csv.split('\r\n')[0] ?? '', /players\.0\.own_lead_m\.mean@lagged/);
  const rows = sweep(order, 'ndjson')
    .trim()
    .split('\n')
    .map((line) => JSON.parse(line));
  for (const row of rows) assert.equal(row['players.0.own_lead_m.mean@lagged'] === null, row['players.0.lag_ms'] === 0);

  /** @type {[object, string, RegExp][]} */
  const bad = [
    [{ windows: [{ name: 'w', from_s: 5, to_s: 3 }] }, 'windows.0.to_s', /above from_s, which is 5 s, to 3600 s; got 3/],
    [{ windows: [{ name: 'w', from_s: -1 }] }, 'windows.0.from_s', /0 to 3600 s; got -1/],
    [{ windows: [{ name: 'A b' }] }, 'windows.0.name', /small letters, digits and _/],
    [{ windows: [{ name: 'w' }, { name: 'w' }] }, 'windows.1.name', /another window/],
    [
      { windows: [{ name: 'w', while: { value: 'player_9_lag', above: 1 } }] },
      'windows.0.while.value',
      /column of the trace or a parameter/,
    ],
    [{ windows: [{ name: 'w', while: { value: 'server_step' } }] }, 'windows.0.while', /above or below/],
    [{ windows: [{ name: 'w', while: { value: 'server_step', above: 2, below: 1 } }] }, 'windows.0.while', /less than below, 1/],
    [{ windows: [{ name: 'w', whilst: 1 }] }, 'windows.0.whilst', /did you mean while/],
    [{ windows: Array.from({ length: 9 }, (_, i) => ({ name: `w${i}` })) }, 'windows', /at most 8/],
    [{ windows: [{ name: 'w' }], metrics: ['players.0.own_lead_m.mean@v'] }, 'metrics.0', /one of: w; got v/],
    [{ metrics: ['players.0.own_lead_m.mean@v'] }, 'metrics.0', /has none/],
    [{ windows: [{ name: 'w' }], metrics: ['players.0.own_lead_m.p95@w'] }, 'metrics.0', /mean, rms or count of a distribution/],
    [{ windows: [{ name: 'w' }], metrics: ['player_0_own_lead_m.mode@w'] }, 'metrics.0', /mean, rms, min, max, p50, p95, p99/],
    [{ windows: [{ name: 'w' }], metrics: ['players.0.nothing@w'] }, 'metrics.0', /neither a metric nor a column/],
  ];
  for (const [change, field, said] of bad) {
    const answer = await c.call('POST', E, { body: { ...experiment(1), ...change } });
    assert.equal(answer.status, 400, JSON.stringify(change));
    assert.match(answer.json.detail, said, JSON.stringify(change));
    assert.equal(answer.json.errors[0].field, field, JSON.stringify(change));
  }
});
