// Notices give the reasons for null metrics: in runs, sessions, experiments, sweeps and reports.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { client, waitFor } from '../lib/client.mjs';
import { BINARY, startDaemon } from '../lib/daemon.mjs';

const E = '/api/v1/experiments',
  S = '/api/v1/sessions',
  LATENCY = 'players.1.input_latency_ms.mean',
  LEAD = 'players.0.own_lead_m.mean';
const SHORT = /^duration_s, 1\.5 s, is not longer than warmup_s, 2 s/;

let daemon, c;
const folder = mkdtempSync(path.join(tmpdir(), 'laglab-notices-'));
before(async () => {
  daemon = await startDaemon();
  c = client(daemon.url);
});
after(async () => {
  c.close();
  await daemon.stop();
  rmSync(folder, { recursive: true, force: true });
});

/** @param {string[]} args @param {any} [input] */
function laglab(args, input) {
  const result = spawnSync(BINARY, args, { input: input && JSON.stringify(input), encoding: 'utf8', maxBuffer: 1 << 28 });
  assert.equal(result.status, 0, result.stderr);
  return result;
}
const run = (/** @type {string[]} */ ...args) => JSON.parse(laglab(['run', ...args]).stdout).metrics;

test('a run that is over before metrics count says so, one that is longer does not', () => {
  const short = run('crates', '--duration', '1.5'),
    long = run('crates', '--duration', '3.25');
  assert.equal(short.players[0].remote_error_m.mean, null);
  assert.equal(short.notices.length, 1);
  assert.match(short.notices[0], SHORT);
  assert.ok(long.players[0].remote_error_m.mean > 0);
  assert.deepEqual(
    long.notices.filter((/** @type {string} */ text) => text.includes('duration_s')),
    [],
  );
});

test('players who never touch the controls, or never joined, are named', () => {
  const players = [{ name: 'Ida' }, { name: 'Leo', control: 'person' }, { name: 'Mo', link: { up: { loss_pct: 100 } } }];
  const { notices } = JSON.parse(laglab(['run', '-'], { kind: 'netgame', game: 'race', duration_s: 5, players }).stdout).metrics;
  assert.equal(notices.length, 2);
  assert.match(notices[0], /^Mo never joined/);
  assert.match(notices[1], /^Leo did not change the controls/);
});

test('a session has notices in its state, also before anything is counted', async () => {
  const { id } = (await c.call('POST', S, { body: { scenario: 'race', set: { duration_s: 1.5 }, paused: true } })).json;
  const session = (await c.get(`${S}/${id}`)).json;
  assert.equal(session.notices.length, 1);
  assert.match(session.notices[0], SHORT);
  const early = (await c.call('POST', S, { body: { scenario: 'race', set: { warmup_s: 7 }, paused: true } })).json.id;
  assert.deepEqual((await c.get(`${S}/${early}`)).json.notices, []);
  assert.match((await c.get(`${S}/${early}/metrics`)).json.metrics.notices[0], /^Metrics count from warmup_s, 7 s, on; it is 0 s\.$/);
});

const plan = {
  scenario: 'race',
  set: { duration_s: 1.5 },
  repeats: 2,
  axes: [{ path: 'players.0.lag_ms', values: [20, 90] }],
  metrics: [LEAD],
};

test('an experiment has notices before it runs, with the number of points', async () => {
  for (const query of ['', '?dry_run=true']) {
    const { notices } = (await c.call('POST', `${E}${query}`, { body: plan })).json;
    assert.equal(notices.length, 1);
    assert.match(notices[0], SHORT);
  }
  const some = { ...plan, set: {}, axes: [{ path: 'duration_s', values: [1, 1.9, 2.1, 3, 4] }] };
  const { id, notices } = (await c.call('POST', E, { body: some })).json;
  assert.match(notices[0], /^At 2 of 5 checked points: duration_s, 1 s, is not longer/);
  assert.deepEqual((await c.get(`${E}/${id}`)).json.notices, notices);
  const { stderr } = laglab(['sweep', '-', '--dry-run'], plan);
  assert.match(stderr, /laglab: duration_s, 1.5 s, is not longer/);
});

test('the sweep and its report name metrics that no run has', () => {
  const html = path.join(folder, 'idle.html');
  const idle = { ...plan, set: { duration_s: 3, 'players.1.control': 'person' }, metrics: [LEAD, LATENCY] };
  const said = `No run has ${LATENCY}: it is null in all 4.`;
  for (const more of [[], ['--points']]) {
    const { stderr } = laglab(['sweep', '-', '--report', html, ...more], idle);
    assert.ok(stderr.includes(`laglab: ${said}`), stderr);
    assert.ok(!stderr.includes(`No run has ${LEAD}`));
  }
  assert.ok(readFileSync(html, 'utf8').includes(`role="note">${said}`));
});

test('a notice gives the number of points at which a rule was not reached', async () => {
  const noisy = {
    scenario: 'race',
    set: { duration_s: 3, 'players.0.link.down.jitter_ms': 30 },
    repeats: 12,
    metrics: ['players.0.remote_error_m.mean'],
    axes: [{ path: 'players.0.lag_ms', values: [20, 90, 140] }],
  };
  const told = (/** @type {any} */ until) => laglab(['sweep', '-', '--points'], { ...noisy, until }).stderr;
  assert.match(
    told({ half_width: 1e-9 }),
    /At 3 of 3 points all 12 repeats were made, but the interval of players\.0\.remote_error_m\.mean is still wider/,
  );
  assert.doesNotMatch(told({ half_width: 100 }), /still wider/);
  const { id } = (await c.call('POST', E, { body: { ...noisy, until: { relative: 1e-9 } } })).json;
  await waitFor(async () => (await c.get(`${E}/${id}`)).json.state === 'done', 'the experiment', 60000);
  assert.match((await c.get(`${E}/${id}/report`)).text, /At 3 of 3 points all 12 repeats/);
});
