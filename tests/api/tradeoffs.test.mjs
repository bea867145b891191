// Speed against error over HTTP: the same rows and choices as `laglab tradeoff`, sessions that repeat a row, refusals, ends, limits.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { spawnSync } from 'node:child_process';
import { readLink } from '../../www/js/base/link.js';
import { client, HANG_MS, pause, waitFor } from '../lib/client.mjs';
import { BINARY, startDaemon } from '../lib/daemon.mjs';

const T = '/api/v1/tradeoffs';

let daemon, c;
before(async () => {
  daemon = await startDaemon();
  c = client(daemon.url);
});
after(async () => {
  c.close();
  await daemon.stop();
});

/** @param {string[]} args */
function laglab(args) {
  const { status, stdout, stderr } = spawnSync(BINARY, args, { encoding: 'utf8', maxBuffer: 1 << 28, timeout: 600000 });
  assert.equal(status, 0, stderr);
  return JSON.parse(stdout);
}

/** @param {any} body */
async function start(body) {
  const { status, json, text, headers } = await c.call('POST', T, { body });
  assert.equal(status, 202, text);
  assert.equal(headers.location, json.links.self);
  return json;
}

/** @param {string} self */
const ended = (self, client_ = c) =>
  waitFor(
    async () => {
      const { json } = await client_.get(self);
      assert.ok(json.done <= json.steps, `${json.done} of ${json.steps}`);
      return json.state !== 'running' && json;
    },
    'the measurement',
    10 * HANG_MS,
  );

/** @param {any} body */
const measured = async (body) => ended((await start(body)).links.self);

/** The rows as the command writes them, without times. @param {any} answer */
const rowsOf = (answer) =>
  answer.rows.flatMap((/** @type {any} */ row) =>
    answer.costs.slice(1).map((/** @type {any} */ cost, /** @type {number} */ i) => ({
      scenario: answer.problems[row.problem].scenario,
      metric: answer.problems[row.problem].error,
      by: row.by,
      method: row.method,
      setting: row.setting,
      value: row.value,
      status: row.status,
      error: row.error[0],
      error_low: row.error[1],
      error_high: row.error[2],
      cost: cost.path,
      cost_value: row.costs[i + 1][0],
      cost_low: row.costs[i + 1][1],
      cost_high: row.costs[i + 1][2],
      front: row.front[i + 1],
      seed: row.seed,
      seeds: row.seeds,
      check_seed: row.check?.seed ?? null,
      check_error: row.check?.error[0] ?? null,
      check_cost: row.check?.costs[i + 1][0] ?? null,
      set: row.set,
      link: row.link,
    })),
  );

/** @param {any[]} rows of the command */
const withoutTimes = (rows) =>
  rows
    .filter(({ cost }) => cost !== 'cpu_s')
    .map(({ family: _, cpu_min_s: __, cpu_median_s: ___, check_seeds: ____, check_error_high: _____, ...row }) => ({
      ...row,
      link: row.link.replace('http://lab/', ''),
    }));

test('families are those of the command', async () => {
  const { status, json } = await c.get(T);
  assert.equal(status, 200);
  assert.deepEqual(
    json.families.map((/** @type {any} */ { results: _, ...family }) => family),
    laglab(['tradeoff', '--list']),
  );
});

test('rows that came with the program have the form of an answer, their choices and links are those of the command', async () => {
  const { families } = (await c.get(T)).json;
  assert.equal(families.length, 8);
  for (const { name, first, problems, costs, results } of families) {
    const { status, json: shipped } = await c.get(`/${results.shipped}`);
    assert.equal(status, 200, name);
    assert.ok(shipped.machine && shipped.version && Date.parse(shipped.date) > Date.parse('2026-01-01'), name);
    for (const row of shipped.rows) {
      assert.ok(problems[row.problem] && row.costs.length === costs.length && row.front.length === costs.length, row.link);
      assert.ok(row.error[1] === null || (row.error[1] <= row.error[0] && row.error[0] <= row.error[2]), row.link);
      const { set, problems: wrong } = readLink(row.link, '');
      assert.deepEqual([wrong, new URLSearchParams(row.link).get('scenario')], [[], problems[row.problem].scenario]);
      assert.equal(Object.keys(set).length, row.set.split(' ').length, row.link);
    }
    for (const method of first)
      assert.ok(
        shipped.rows.some((/** @type {any} */ row) => row.method === method),
        `${name} ${method}`,
      );
    for (const { row, level, cost, problem, check_cheapest: again } of shipped.choices) {
      const within = shipped.rows.filter(
        (/** @type {any} */ one) => one.problem === problem && one.error[2] !== null && one.error[2] <= level,
      );
      assert.equal(shipped.rows[row].costs[cost][0], Math.min(...within.map((/** @type {any} */ one) => one.costs[cost][0] ?? Infinity)));
      assert.ok(again !== null, name);
    }
  }
  const [row] = laglab(['tradeoff', 'integrators', '--methods', 'dop853', '--check-seeds', '0', '--format', 'json', '--page', '']);
  const { rows } = (await c.get('/tradeoffs/integrators.json')).json,
    same = rows.find((/** @type {any} */ one) => one.method === 'dop853' && one.problem === 0);
  assert.deepEqual([same.by, same.setting, same.set, same.link], [row.by, row.setting, row.set, row.link]);
  assert.ok(Math.abs(same.error[0] - row.error) < 1e-5 * row.error);
});

for (const [body, args] of /** @type {[any, string[]][]} */ ([
  [
    { family: 'contact_solvers', methods: ['xpbd', 'soft_step'], duration_s: 0.2 },
    ['contact_solvers', '--methods', 'xpbd,soft_step', '--duration', '0.2'],
  ],
  [
    { family: 'integrators', methods: ['rk4', 'dopri5'], duration_s: 0.5, check_seeds: 0 },
    ['integrators', '--methods', 'rk4,dopri5', '--duration', '0.5', '--check-seeds', '0'],
  ],
  [
    { family: 'synchronisation', methods: ['bucket'], duration_s: 3, seeds: 10 },
    ['synchronisation', '--methods', 'bucket', '--duration', '3', '--seeds', '10', '--check-seeds', '10'],
  ],
]))
  test(`${body.family}: rows and choices are those of the command`, async () => {
    const { state, done, steps, answer, error } = await measured(body);
    assert.deepEqual([state, done, error], ['done', steps, null]);
    const rows = laglab(['tradeoff', ...args, '--page', 'http://lab/', '--format', 'json']);
    assert.deepEqual(rowsOf(answer), withoutTimes(rows));
    assert.ok(answer.rows.every((/** @type {any} */ row) => row.costs[0][0] >= 0 && row.costs[0][0] <= row.costs[0][2]));
    for (const choice of answer.choices) {
      const within = answer.rows.filter(
        (/** @type {any} */ row) =>
          row.problem === choice.problem && row.error[2] !== null && row.error[2] <= choice.level && row.costs[choice.cost][0] !== null,
      );
      const least = Math.min(...within.map((/** @type {any} */ row) => row.costs[choice.cost][0]));
      assert.equal(choice.row === null ? Number.POSITIVE_INFINITY : answer.rows[choice.row].costs[choice.cost][0], least);
      const outcomes = choice.row === null ? ['nothing'] : body.check_seeds === 0 ? ['not checked'] : ['holds', 'does not hold'];
      assert.ok(outcomes.includes(choice.outcome), JSON.stringify(choice));
    }
    const levels = new Set(answer.choices.map((/** @type {any} */ one) => `${one.problem} ${one.level}`)).size;
    assert.equal(answer.choices.length, levels * answer.costs.length);
    assert.ok(levels >= 1);
  });

test('the session that a row leads to has its error', async () => {
  const at = (/** @type {any} */ object, /** @type {string} */ where) => where.split('.').reduce((part, name) => part?.[name], object);
  for (const body of [
    { family: 'contact_solvers', methods: ['xpbd'], duration_s: 0.2, check_seeds: 0 },
    { family: 'integrators', methods: ['dopri5'], duration_s: 0.5, check_seeds: 0 },
    { family: 'pressure_solvers', methods: ['multigrid'], duration_s: 0.2, check_seeds: 0 },
  ]) {
    const { answer } = await measured(body);
    for (const [p, problem] of answer.problems.entries()) {
      const row = answer.rows.find((/** @type {any} */ one) => one.problem === p && one.error[0] !== null);
      const { set, problems } = readLink(row.link, ''),
        scenario = new URLSearchParams(row.link).get('scenario');
      assert.deepEqual([problems, scenario], [[], problem.scenario]);
      const made = await c.call('POST', '/api/v1/sessions', { body: { scenario, set, paused: true } });
      assert.equal(made.status, 201, made.text);
      const { id, owner_key: key } = made.json;
      const end = await c.call('POST', `/api/v1/sessions/${id}/control`, { body: { op: 'seek', time_s: body.duration_s }, key });
      assert.equal(end.status, 200, end.text);
      const { metrics } = (await c.get(`/api/v1/sessions/${id}/metrics`)).json;
      assert.equal(Math.abs(at(metrics, problem.error)), row.error[0], `${problem.scenario} ${row.set}`);
      await c.call('DELETE', `/api/v1/sessions/${id}`, { key });
    }
  }
});

test('what it cannot do is refused with field and range', async () => {
  const family = 'oceans';
  for (const [body, field, words] of /** @type {[any, string, RegExp][]} */ ([
    [{}, 'family', /one of integrators, .*lag_compensation; got nothing/],
    [{ family: 'magic' }, 'family', /got magic/],
    [{ family: 3 }, 'family', /got no text/],
    [{ family, seeds: 9 }, 'seeds', /10 to 100/],
    [{ family, seeds: 101 }, 'seeds', /10 to 100/],
    [{ family, seeds: 10.5 }, 'seeds', /whole number/],
    [{ family, check_seeds: 5 }, 'check_seeds', /0, or a whole number from 10 to 100/],
    [{ family, duration_s: 0 }, 'duration_s', /0\.05 to 1000 s/],
    [{ family, duration_s: '1' }, 'duration_s', /0\.05 to 1000 s/],
    [{ family, methods: [] }, 'methods', /array of names, or all/],
    [{ family, methods: 'some' }, 'methods', /array of names, or all/],
    [{ family, methods: ['spectrum', 'rk4'] }, 'methods.1', /method of oceans; got rk4/],
    [{ family, methods: ['spectrum,tiled'] }, 'methods.0', /got spectrum,tiled/],
    [{ family, methods: [1] }, 'methods.0', /got no name/],
    [{ family, speed: 1 }, 'speed', /family, methods, seeds, check_seeds, duration_s/],
  ])) {
    const { status, json } = await c.call('POST', T, { body });
    assert.equal(status, 400, JSON.stringify(body));
    assert.equal(json.errors[0].field, field);
    assert.match(json.detail, words);
  }
});

/** Tasks that run or wait for their turn. */
const tasks = async (/** @type {any} */ at) => {
  const { text } = await at.get('/metrics');
  return ['running', 'waiting'].reduce((sum, name) => sum + Number(new RegExp(`^laglab_tasks_${name} (\\d+)`, 'm').exec(text)?.[1]), 0);
};

/** What the daemon says of a family's results. @param {string} family */
const newest = async (family, at = c) => (await at.get(T)).json.families.find((/** @type {any} */ one) => one.name === family).results.job;

const LONG = { family: 'synchronisation', seeds: 100 };

test('the methods measured first are the default, all are measured where that is asked for', async () => {
  const first = (await c.get(T)).json.families.find((/** @type {any} */ one) => one.name === 'snapshots').first;
  const body = { family: 'snapshots', duration_s: 0.1, seeds: 10, check_seeds: 0 };
  const { answer, methods } = await measured(body);
  const named = (/** @type {any} */ of) => [...new Set(of.rows.map((/** @type {any} */ row) => row.method))].sort();
  assert.deepEqual([methods, named(answer)], [first, [...first].sort()]);
  const all = await measured({ ...body, methods: 'all' });
  assert.equal(all.methods, null);
  assert.deepEqual(named(all.answer), [...first, 'partial', 'quantised'].sort());
});

test('rows are readable while they are measured, coarse settings first; the same order gets the one that runs', async () => {
  const { id, owner_key: key, links } = await start(LONG);
  const other = client(daemon.url),
    counts = [];
  try {
    let now;
    do {
      now = (await other.get(links.self)).json;
      const rows = now.answer?.rows ?? [];
      if (rows.length > (counts.at(-1) ?? 0)) counts.push(rows.length);
      if (rows.length >= 8) {
        const values = (/** @type {string} */ method) => rows.filter((/** @type {any} */ row) => row.method === method).length;
        assert.ok(values('bucket') >= 1 && values('free') >= 1, 'no method waits for the finest setting of another');
      }
      assert.ok(now.answer === null || now.answer.rows.every((/** @type {any} */ row) => row.seeds === 100 && row.runs === 100));
      assert.ok(
        now.state === 'done' || now.answer === null || now.answer.choices.every((/** @type {any} */ one) => one.outcome !== 'holds'),
      );
    } while (now.state === 'running' && counts.length < 4);
    assert.ok(counts.length >= 3, `the rows grow: ${counts}`);
    assert.equal(now.state, 'running');
    assert.deepEqual([now.family, now.error, await newest(LONG.family, other)], [LONG.family, null, id]);
    const again = await other.call('POST', T, { body: LONG });
    assert.deepEqual([again.status, again.json], [200, { id, links }]);
    const differs = await other.call('POST', T, { body: { ...LONG, methods: ['free'] } });
    assert.equal(differs.status, 409);
    assert.match(differs.json.detail, /^family: another measurement of synchronisation runs, .* \d+ of 70 settings/);
    assert.equal((await other.call('DELETE', links.self, { key: 'b'.repeat(32) })).status, 403);
  } finally {
    other.close();
    assert.equal((await c.call('DELETE', links.self, { key })).status, 204);
  }
});

test('a measurement ends when it is deleted, in the midst of a run; what was finished before is the newest again', async () => {
  const before = await measured({ family: 'integrators', methods: ['rk4'], duration_s: 0.2 });
  assert.equal(await newest('integrators'), before.id);
  for (const family of ['integrators', 'synchronisation', 'particles']) {
    const { id, owner_key: key, links } = await start({ family, seeds: 100, methods: 'all' });
    await waitFor(async () => (await c.get(links.self)).json.done > 0, 'a step');
    await pause(200);
    assert.equal((await c.get(`/api/v1/advise/${id}`)).status, 404, 'it is no advice');
    assert.equal((await c.call('DELETE', links.self)).status, 401);
    assert.equal((await c.call('DELETE', links.self, { key: 'b'.repeat(32) })).status, 403);
    assert.equal((await c.call('DELETE', links.self, { key })).status, 204);
    assert.equal((await c.get(links.self)).status, 404);
    await waitFor(async () => (await tasks(c)) === 0, `the end of ${family}`);
  }
  assert.equal(await newest('integrators'), before.id);
  const after_ = await measured({ family: 'integrators', methods: ['rk4'], duration_s: 0.3 });
  assert.equal(await newest('integrators'), after_.id);
  assert.equal((await c.get(`${T}/${before.id}`)).status, 404, 'a newer one has taken its place');
});

test('it runs to its end without a reader; its processor time is limited, and what was measured until then is there', async () => {
  const strict = await startDaemon({ args: ['--job-cpu-s', '0.3', '--job-idle-s', '0.2'] });
  const s = client(strict.url);
  try {
    const over = await s.call('POST', T, { body: { family: 'integrators', methods: 'all' } });
    const { state, error, answer, done, steps } = await ended(over.json.links.self, s);
    assert.equal(state, 'failed');
    assert.match(error, /^Limit of 0\.3 s of processor time reached: interrupted after \d+ settings\.$/);
    assert.ok(answer.rows.length > 0 && done < steps && answer.choices.every((/** @type {any} */ one) => one.outcome !== 'holds'));
    assert.equal(await newest('integrators', s), over.json.id);
    const alone = await s.call('POST', T, { body: { family: 'lag_compensation', duration_s: 0.5, seeds: 10 } });
    await waitFor(async () => (await tasks(s)) === 0, 'its end, which no client asks for');
    await pause(500);
    assert.equal((await s.get(alone.json.links.self)).json.state, 'done');
  } finally {
    s.close();
    await strict.stop();
  }
});
