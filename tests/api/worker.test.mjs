// Workers with a sweep or a daemon on one store: together they compute what one computes alone.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { execFileSync, spawn, spawnSync } from 'node:child_process';
import { once } from 'node:events';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { client, waitFor } from '../lib/client.mjs';
import { BINARY, startDaemon } from '../lib/daemon.mjs';

let folder;
before(() => {
  folder = mkdtempSync(path.join(tmpdir(), 'laglab-worker-'));
});
after(() => rmSync(folder, { recursive: true, force: true }));

/** @param {string[]} args */
const laglab = (...args) => spawnSync(BINARY, args, { cwd: folder, encoding: 'utf8', timeout: 60000 });
const race = {
  scenario: 'race',
  set: { duration_s: 2 },
  axes: [{ path: 'players.0.lag_ms', values: [0, 100, 200] }],
  repeats: 100,
  metrics: ['players.0.own_lead_m.mean'],
};

/** @param {string[]} args */
function begin(...args) {
  const child = spawn(BINARY, args, { cwd: folder, stdio: ['ignore', 'pipe', 'inherit'] });
  let text = '';
  child.stdout.setEncoding('utf8').on('data', (more) => {
    text += more;
  });
  const ended = new Promise((resolve) => child.on('close', (code, signal) => resolve({ code, signal, text })));
  return { child, ended };
}

test('a sweep without jobs of its own waits for workers, whose rows are those of one process', async () => {
  writeFileSync(path.join(folder, 'race.json'), JSON.stringify(race));
  const alone = laglab('sweep', 'race.json');
  assert.equal(alone.status, 0, alone.stderr);
  const sweep = begin('sweep', 'race.json', '--store', 'sqlite:s.db', '--jobs', '0', '--out', 'rows.csv');
  const workers = [1, 2].map(() => begin('worker', '--store', 's.db', '--jobs', '1'));
  assert.equal((await sweep.ended).code, 0);
  assert.equal(readFileSync(path.join(folder, 'rows.csv'), 'utf8'), alone.stdout);
  let runs = 0;
  for (const worker of workers) {
    worker.child.kill('SIGTERM');
    const { code, text } = await worker.ended;
    assert.equal(code, 0);
    runs += JSON.parse(text).runs;
  }
  assert.equal(runs, 300);
  assert.deepEqual(JSON.parse(laglab('worker', '--store', 's.db', '--drain').stdout), { runs: 0 });
});

test('a worker takes part in what a daemon was asked for', async (t) => {
  const store = path.join(folder, 'daemon.db'),
    daemon = await startDaemon({ args: ['--store', `sqlite:${store}`, '--threads', '1'] });
  t.after(() => daemon.stop());
  const c = client(daemon.url);
  t.after(() => c.close());
  const worker = begin('worker', '--store', store, '--jobs', '1');
  const made = (await c.call('POST', '/api/v1/experiments', { body: { ...race, repeats: 2000 } })).json;
  await waitFor(async () => (await c.get(made.links.self)).json.state === 'done', 'the rows', 30000);
  worker.child.kill('SIGTERM');
  const { code, text } = await worker.ended;
  assert.equal(code, 0);
  assert.ok(JSON.parse(text).runs > 0, 'the worker had a part of it');
});

test('an experiment of another version is left alone by workers and by a daemon, which name both versions', async (t) => {
  const other = '0.0.9+0123456789ab',
    own = laglab('--version').stdout.trim().split(' ')[1],
    store = path.join(folder, 'mixed.db');
  const sql = (/** @type {string} */ text) => execFileSync('sqlite3', ['-cmd', '.timeout 5000', store, text], { encoding: 'utf8' }).trim();
  const namesVersions = (/** @type {string} */ text) => {
    for (const words of [other, own, 'run the experiment again']) assert.ok(text.includes(words), text);
  };
  const daemon = await startDaemon({ args: ['--store', `sqlite:${store}`, '--threads', '1'] });
  t.after(() => daemon.stop());
  const c = client(daemon.url);
  t.after(() => c.close());
  const made = (await c.call('POST', '/api/v1/experiments', { body: { ...race, repeats: 4000 } })).json;
  const control = (/** @type {string} */ op) => c.call('POST', made.links.control, { key: made.owner_key, body: { op } });
  assert.deepEqual([(await control('pause')).json.version, (await c.get(made.links.self)).json.held_back], [own, null]);
  await waitFor(() => sql('SELECT count(*) FROM chunk WHERE state=1') === '0', 'what was begun', 20000);
  const rows = sql(`UPDATE experiment SET version='${other}'; SELECT count(*) FROM result`);
  namesVersions((await c.get(made.links.self)).json.held_back);
  const refused = await control('resume');
  assert.equal(refused.status, 409);
  namesVersions(refused.json.detail);
  sql('UPDATE experiment SET state=0');
  for (const more of [['--experiment', made.id], ['--drain']]) {
    const worker = laglab('worker', '--store', store, ...more);
    assert.equal(worker.status, 2, worker.stderr);
    namesVersions(worker.stderr);
  }
  const patient = spawn(BINARY, ['worker', '--store', store], { stdio: ['ignore', 'ignore', 'pipe'] });
  namesVersions(String((await once(patient.stderr, 'data'))[0]));
  await new Promise((resolve) => {
    patient.once('close', resolve).kill('SIGTERM');
  });
  assert.equal(sql('SELECT count(*) FROM result'), rows);
  assert.ok(
    (await c.get(made.links.results)).text
      .split('\r\n')
      .slice(1, -1)
      .every((row) => row.endsWith(`,${other}`)),
  );
});

test('LAGLAB_STORE in the environment is a store that the list of processes does not show', async () => {
  writeFileSync(path.join(folder, 'hidden.json'), JSON.stringify({ ...race, repeats: 10 }));
  const env = { ...process.env, LAGLAB_STORE: 'sqlite:hidden.db' },
    with_store = (/** @type {string[]} */ ...args) => {
      const result = spawnSync(BINARY, args, { cwd: folder, encoding: 'utf8', timeout: 60000, env });
      assert.equal(result.status, 0, result.stderr);
      return result.stdout;
    };
  const script = with_store('submit', 'hidden.json', '--engine', 'slurm', '--print');
  assert.doesNotMatch(script, /hidden\.db/);
  assert.deepEqual(JSON.parse(with_store('worker', '--drain')), { runs: 30 });
  const rows = with_store('sweep', 'hidden.json', '--jobs', '0');
  assert.equal(rows, laglab('sweep', 'hidden.json').stdout);
  const daemon = await startDaemon({ before: ['env', `LAGLAB_STORE=sqlite:${path.join(folder, 'hidden.db')}`] }),
    c = client(daemon.url);
  const made = (await c.call('POST', '/api/v1/experiments', { body: { ...race, repeats: 1 } })).json;
  c.close();
  await daemon.stop();
  assert.equal(
    execFileSync('sqlite3', [path.join(folder, 'hidden.db'), `SELECT count(*) FROM experiment WHERE id='${made.id}'`], {
      encoding: 'utf8',
    }),
    '1\n',
  );
});

test('what a worker cannot do is a sentence', () => {
  const cases = /** @type {[string[], number, string][]} */ ([
    [[], 2, '--store'],
    [['--store', 's.db', '--jobs', '0'], 2, '--jobs'],
    [['--store', 's.db', '--lease-s', '0'], 2, '--lease-s'],
    [['--store', 's.db', '--nosuch'], 2, '--nosuch'],
    [['--store', 's.db', 'x'], 2, 'x'],
    [['--store', 's.db', '--experiment', 'nosuch'], 2, 'experiment nosuch not found'],
    [['--store', 'mysql://x/y'], 2, 'mysql://x/y'],
    [['--store', '/nosuch/s.db'], 1, '/nosuch/s.db'],
  ]);
  for (const [args, code, words] of cases) {
    const result = laglab('worker', ...args);
    assert.equal(result.status, code, `${args}: ${result.stderr}`);
    assert.ok(result.stderr.includes(words), result.stderr);
    assert.equal(result.stdout, '');
  }
});
