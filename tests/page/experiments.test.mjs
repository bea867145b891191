// The Experiments view: writing, estimating, running, watching, reading and opening experiments; reload; accessibility.
import assert from 'node:assert/strict';
import { mkdirSync } from 'node:fs';
import { after, before } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { SIZES, api, axe, launch, reads, sessionOf, settles, until, visit } from './lib.mjs';
import { sweep, test } from './tiers.mjs';

const SHOTS = process.env.LAGLAB_SHOTS ?? '';
if (SHOTS) mkdirSync(SHOTS, { recursive: true });

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

/** Opens what is behind buttons. @param {import('playwright-core').Page} page */
async function openDrawers(page) {
  for (const name of ['settings', 'table', 'files', 'request']) {
    const button = page.locator(`[data-drawer="${name}"]`);
    if ((await button.getAttribute('aria-expanded')) === 'false') await button.click();
    await page.locator(`section#drawer-${name}`).waitFor();
  }
}

/** Opens the view and waits until the form is counted. @param {any} [wish] */
async function visitView(wish = {}) {
  const { query = '', hash = '#experiments', ...more } = wish;
  const visited = await visit(browser, daemon.url + query + hash, { allowed: /status of 400/, ...more, wait: false });
  await visited.page.locator('#run:not([disabled])').waitFor();
  return visited;
}

/** The same with all that is behind buttons; without an id with five lags alone in place of the finished experiment. @param {any} [wish] */
async function open(wish = {}) {
  const visited = await visitView(wish),
    { page } = visited;
  await openDrawers(page);
  if (wish.hash) return visited;
  await page.selectOption('#of', 'race');
  await until(async () => (await specification(page)).axes[0]?.values.length === 6, 'what suits a race');
  await page.selectOption('#compared', '');
  await page.locator('[data-axis="0.values"]').fill('0, 50, 100, 200, 500');
  await until(async () => (await specification(page)).axes[0].values.length === 5, 'five lags');
  await counted(page);
  return visited;
}

/** @param {import('playwright-core').Page} page @param {string} id */
async function begin(page, id) {
  await page.waitForFunction(() => document.querySelectorAll('#library option').length > 3);
  await page.selectOption('#library', id);
  await counted(page);
}
/** Until the number of runs is that of what is written. @param {import('playwright-core').Page} page */
async function counted(page) {
  await page.waitForTimeout(500); /* the pause after the last key */
  await page.locator('#run:not([disabled])').waitFor();
}
/** @param {import('playwright-core').Page} page */
const estimate = (page) => page.locator('#estimate');
/** @param {import('playwright-core').Page} page */
const specification = async (page) =>
  JSON.parse(/-d '(.*)' -H/.exec((await page.locator('textarea').inputValue()).replaceAll("'\\''", "'"))[1]);
/** @param {import('playwright-core').Page} page */
const shownId = (page) => page.evaluate(() => /experiments=(.+)$/.exec(location.hash)?.[1]);
/** @param {import('playwright-core').Page} page */
const done = (page) => page.locator('[data-state="done"]').waitFor();
/** Runs what the form says, to its end: what was shown before is done, too. @param {import('playwright-core').Page} page */
async function run(page) {
  const before = await shownId(page);
  await page.locator('#run').click();
  await until(async () => (await shownId(page)) !== before, 'the address has what was begun');
  await done(page);
}
/** @param {import('playwright-core').Page} page @param {string} name */
const column = async (page, name) => {
  const place = await page
    .locator('.points thead th')
    .evaluateAll((all, wanted) => all.findIndex((e) => e.dataset.column === wanted), name);
  return page.locator('.points tbody tr').evaluateAll((all, at) => all.map((row) => row.children[at].textContent), place);
};

test('notes above the results: runs too short, a metric that no run has, a rule that was not reached', async () => {
  const error = 'players.0.remote_error_m.mean',
    latency = 'players.1.input_latency_ms.mean';
  const base = { scenario: 'race', axes: [{ path: 'players.0.lag_ms', values: [30, 110] }], repeats: 11, metrics: [error] };
  const cases = [
    [
      { ...base, set: { duration_s: 1.25 } },
      [/duration_s, 1\.25 s, is not longer than warmup_s, 2 s/, /^No run has Player A: Others, error, mean \(m\): it is null in all 22/],
    ],
    [
      { ...base, set: { duration_s: 3, 'players.1.control': 'person' }, metrics: [error, latency] },
      [/^No run has Player B: Input latency, mean \(ms\)/],
    ],
    [
      { ...base, set: { duration_s: 3, 'players.0.link.down.jitter_ms': 20 }, until: { half_width: 1e-9 } },
      [/^At 2 of 2 points all 11 repeats were made/],
    ],
    [{ ...base, set: { duration_s: 3, 'players.0.link.down.jitter_ms': 20 }, until: { half_width: 50 } }, []],
  ];
  for (const [body, wanted] of /** @type {[object, RegExp[]][]} */ (cases)) {
    const { id } = (await api(daemon.url, 'experiments', body)).body;
    const { page, complaints, close } = await open({ hash: `#experiments=${id}` });
    await done(page);
    await page.locator('.points tbody tr').nth(1).waitFor();
    const note = page.locator('.progress [role="note"]');
    await settles(() => note.count(), wanted.length);
    const notes = (await note.allInnerTexts()).map((text) => text.replace(/\s+/g, ' '));
    for (const [i, words] of wanted.entries()) assert.match(notes[i], words);
    assert.deepEqual(complaints, []);
    await close();
  }
});

test('a first experiment is there for a scenario of each kind, and counted by the daemon', async () => {
  const { page, complaints, close } = await open();
  await reads(estimate(page), /^5 runs of 5 points, less than a second/);
  for (const [id, path] of [
    ['motion/pendulum', 'methods.0.dt_s'],
    ['rigid/pyramid', 'solver.substeps'],
    ['fluid/taylor_green', ''],
  ]) {
    await page.selectOption('#of', id);
    await until(
      async () => (await specification(page)).scenario === id && (await specification(page)).metrics.length > 0,
      `a form of ${id}`,
    );
    await counted(page);
    const written = await specification(page);
    assert.ok(written.axes.length === 1 && (path === '' || written.axes[0].path === path), JSON.stringify(written));
    await reads(estimate(page), /runs? of \d+ points?/);
    const dry = await api(daemon.url, 'experiments?dry_run=true', written);
    assert.equal(dry.status, 200, JSON.stringify(dry.body));
    await reads(estimate(page), new RegExp(`^${dry.body.runs} runs`));
  }
  assert.deepEqual(complaints, []);
  await close();
});

test('axes of every sort become the specification: range, log, list, choices, together, sampled', async () => {
  const { page, close } = await open();
  await page.locator('#add-axis').click();
  await page.getByLabel('Parameter of axis 2').selectOption('server.update_hz');
  await page.locator('[data-axis="1.from"]').fill('10');
  await page.locator('[data-axis="1.to"]').fill('90');
  await page.locator('[data-axis="1.count"]').fill('3');
  await page.getByLabel('Logarithmic steps of axis 2').check();
  await page.locator('#add-axis').click();
  await page.getByLabel('Parameter of axis 3').selectOption('players.0.prediction');
  await page.locator('#repeats').fill('2');
  await counted(page);
  await reads(estimate(page), /^60 runs of 30 points/);
  await reads(page.locator('.axis').nth(1), /10, 30, 90/);
  await settles(
    async () => (await specification(page)).axes,
    [
      { path: 'players.0.lag_ms', values: [0, 50, 100, 200, 500] },
      { path: 'server.update_hz', from: 10, to: 90, count: 3, scale: 'log' },
      { path: 'players.0.prediction', values: [false, true] },
    ],
  );
  await page.getByLabel('Values of axis 3').getByLabel('off').uncheck();
  await page.getByLabel('Together with the axis above').nth(0).check();
  await page.locator('[data-axis="1.count"]').fill('5');
  await counted(page);
  await reads(estimate(page), /^10 runs of 5 points/);
  await page.getByLabel('Together with the axis above').nth(0).uncheck();
  await page.selectOption('#sampling', 'sobol');
  await page.getByLabel('Number of points').fill('16');
  await counted(page);
  await reads(estimate(page), /^32 runs of 16 points/);
  await settles(async () => (await specification(page)).sample, { method: 'sobol', count: 16 });
  await close();
});

test('the until rule: written, estimated, refused at its fields, run, and edited again', async () => {
  const { page, complaints, close } = await open();
  await settles(async () => (await specification(page)).until, undefined);
  await page.locator('#until').check();
  await settles(async () => (await specification(page)).until, { relative: 0.05, least: 10 });
  await settles(async () => (await specification(page)).repeats, 100, 'one run alone has no mean');
  await page.locator('#repeats').fill('40');
  await page.selectOption('#until-metric', 'players.0.remote_error_m.mean');
  await page.locator('#until-relative').fill('');
  await page.locator('#until-half').fill('0.4');
  await page.locator('#until-least').fill('12');
  const until = { metric: 'players.0.remote_error_m.mean', half_width: 0.4, least: 12 };
  await settles(async () => (await specification(page)).until, until);
  await counted(page);
  await reads(estimate(page), /^200 runs of 5 points/);
  for (const [field, value, words] of [
    ['least', '3', /least: must be a whole number from 10 to 100000; got 3/],
    ['least', '50', /at most repeats, which is 40; got 50/],
    ['half', 'wide', /half_width/],
    ['relative', '1.5', /relative: must be 0 to 1; got 1.5/],
  ]) {
    const box = page.locator(`#until-${field}`),
      before = await box.inputValue();
    await box.fill(String(value));
    await page.locator('#wrong-until').filter({ hasText: words }).waitFor();
    await settles(() => box.getAttribute('aria-invalid'), 'true', String(field));
    await settles(() => box.getAttribute('aria-describedby'), 'wrong-until');
    await settles(() => page.locator('#run').isDisabled(), true);
    await box.fill(before);
    await page.locator('#wrong-until').waitFor({ state: 'detached' });
  }
  // Help and range are the schema's; a tooltip has no full stop.
  const rules = (await api(daemon.url, 'experiments/schema')).body,
    least = Object.values(rules.$defs).find((one) => one.properties?.least).properties.least;
  await settles(() => page.locator('label:has(#until-least)').getAttribute('title'), least.description.replace(/\.$/, ''));
  assert.ok(
    (await page.locator('.until').innerText()).includes(`${least.minimum} to ${least.maximum.toLocaleString('en')}`) ||
      (await page.locator('.until').innerText()).includes(`${least.minimum} to ${least.maximum}`),
    await page.locator('.until').innerText(),
  );
  await counted(page);
  await run(page);
  await page.locator('tr[data-point="4"]').waitFor();
  const rows = (await api(daemon.url, `experiments/${await shownId(page)}/results?points=true&format=json`)).body;
  await settles(
    async () => (await column(page, 'runs')).map(Number),
    rows.map((row) => row.runs),
  );
  assert.ok(
    rows.some((row) => row.runs < 40),
    'some means were known before',
  );
  await page.reload();
  await page.locator('#run:not([disabled])').waitFor();
  await openDrawers(page);
  await settles(async () => (await specification(page)).until, until, 'what was run is the form again');
  await page.locator('#until').uncheck();
  await settles(async () => (await specification(page)).until, undefined);
  await page.locator('#until').check();
  await counted(page);
  assert.deepEqual(complaints, []);
  await close();
});

test('windows: by time, while a condition holds, renamed, refused at its fields, run, and edited again', async () => {
  const { page, complaints, close } = await open();
  const error = 'players.0.remote_error_m.mean',
    latency = 'players.0.input_latency_ms.mean';
  await page.getByRole('button', { name: 'Add a value' }).click();
  await page.getByLabel(/^Value of Duration/).fill('6');
  await page.locator('[data-axis="0.values"]').fill('0, 100');
  await settles(async () => (await specification(page)).windows, undefined);
  await page.locator('#add-window').click();
  // Of what is chosen, the second half.
  await settles(async () => (await specification(page)).windows, [{ name: 'part_1', from_s: 3 }]);
  await settles(async () => (await specification(page)).metrics, [latency, error, `${latency}@part_1`, `${error}@part_1`]);
  await page.locator(`[data-windowed="${latency}@part_1"]`).uncheck();
  await page.locator('[data-window-name="0"]').fill('Späte Zeit');
  await settles(() => page.locator('[data-window-name="0"]').inputValue(), 'spate_zeit');
  await page.locator('[data-windowed="counted_s@spate_zeit"]').check();
  await page.locator('#window-0-to').fill('5');
  await page.locator('#add-window').click();
  await page.locator('[data-window-while="1"]').check();
  await page.locator('#window-1-from').fill('');
  await page.getByLabel('Condition of window part_2').getByLabel('Value').selectOption({ label: 'Age of information (ms)' });
  await page.locator('#window-1-above').fill('100');
  await page.selectOption('#error', `${error}@spate_zeit`);
  const windows = [
    { name: 'spate_zeit', from_s: 3, to_s: 5 },
    { name: 'part_2', while: { value: 'player_0_age_of_information_ms', above: 100 } },
  ];
  await settles(async () => (await specification(page)).windows, windows);
  await counted(page);
  await page.locator('#window-0-to').fill('2');
  await page
    .locator('#wrong-windows-0')
    .filter({ hasText: /to_s: must be above from_s, which is 3 s/ })
    .waitFor();
  await settles(() => page.locator('#window-0-to').getAttribute('aria-invalid'), 'true');
  await settles(() => page.locator('#run').isDisabled(), true);
  await page.locator('#window-0-to').fill('5');
  await page.locator('[data-window-name="1"]').fill('spate_zeit');
  await settles(() => page.locator('[data-window-name="1"]').inputValue(), 'spate_zeit_', 'two windows of one name would be one');
  await page.locator('[data-window-name="1"]').fill('part_2');
  const order = await specification(page);
  assert.equal(order.error, `${error}@spate_zeit`);
  assert.deepEqual(order.windows, windows);
  await counted(page);
  await page.locator('#wrong-windows-0').waitFor({ state: 'detached' });
  await run(page);
  await page.locator('tr[data-point="1"]').waitFor();
  const rows = (await api(daemon.url, `experiments/${await shownId(page)}/results?points=true&format=json`)).body;
  assert.deepEqual(
    rows.map((row) => row['counted_s@spate_zeit']),
    [2, 2],
  );
  assert.notEqual(rows[1][`${error}@spate_zeit`], rows[1][error]);
  await reads(page.locator('.points thead'), /Player A: Others, error, mean \(m\), in window spate_zeit/);
  await page.reload();
  await page.locator('#run:not([disabled])').waitFor();
  await openDrawers(page);
  await settles(async () => (await specification(page)).windows, windows, 'what was run is the form again');
  await page.getByRole('button', { name: 'Remove window spate_zeit' }).click();
  await settles(async () => (await specification(page)).windows, windows.slice(1));
  await settles(async () => (await specification(page)).metrics.filter((name) => /spate_zeit/.test(name)), []);
  await settles(async () => (await specification(page)).error, undefined);
  assert.deepEqual(complaints, []);
  await close();
});

test('a front of several metrics is chosen, marked in the table as a search without the page finds it', async () => {
  const { page, complaints, close } = await open();
  await begin(page, 'experiments/lag_techniques');
  await page.getByLabel(/^Value of Duration/).fill('5');
  const { metrics } = await specification(page),
    wanted = [metrics[1], metrics[3], metrics[0]];
  await page.locator(`[data-front="${metrics[0]}"]`).check();
  await page.locator('#wrong-front').filter({ hasText: 'front: must be an array of 2' }).waitFor();
  for (const path of wanted) await page.locator(`[data-front="${path}"]`).check();
  await counted(page);
  await settles(
    async () => (await specification(page)).front,
    metrics.filter((/** @type {string} */ path) => wanted.includes(path)),
  );
  await run(page);
  await page.locator('tr[data-point="19"]').waitFor();
  const rows = (await api(daemon.url, `experiments/${await shownId(page)}/results?points=true&format=json`)).body;
  const sizes = rows.map((row) => wanted.map((path) => Math.abs(row[path])));
  const on = sizes.map((a) => !sizes.some((b) => b.every((v, k) => v <= a[k]) && b.some((v, k) => v < a[k])));
  await settles(async () => (await column(page, 'front')).map((text) => text === 'front'), on);
  assert.ok(on.includes(true) && on.includes(false));
  // A metric that is not kept any more is on no front.
  await page.locator(`.chosen [data-metric="${wanted[0]}"]`).click();
  await settles(
    () => page.locator('[data-front]:checked').evaluateAll((all) => all.map((e) => e.getAttribute('data-front'))),
    metrics.filter((/** @type {string} */ path) => wanted.includes(path) && path !== wanted[0]),
  );
  assert.deepEqual(complaints, []);
  await close();
});

test('designs of points: a Latin hypercube, base samples for sensitivity, values of a range, seeds', async () => {
  const { page, close } = await open();
  await page.locator('#add-axis').click();
  await page.getByLabel('Parameter of axis 2').selectOption('server.update_hz');
  await page.getByRole('button', { name: 'Range' }).first().click();
  await page.locator('[data-axis="0.from"]').fill('0');
  await page.locator('[data-axis="0.to"]').fill('300');
  await page.selectOption('#sampling', 'lhs');
  await page.getByLabel('Number of points').fill('24');
  await page.locator('#sample-seed').fill('7');
  await page.locator('[data-axis="0.levels"]').fill('4');
  await counted(page);
  await reads(estimate(page), /^24 runs of 24 points/);
  const lhs = await specification(page);
  assert.deepEqual(lhs.sample, { method: 'lhs', count: 24, seed: 7 });
  assert.equal(lhs.axes[0].count, 4);
  assert.equal('count' in lhs.axes[1], false, 'any value');
  await run(page);
  await page.locator('tr[data-point="23"]').waitFor();
  const lags = (await column(page, 'players.0.lag_ms')).map(Number);
  assert.deepEqual(
    [0, 100, 200, 300].map((lag) => lags.filter((one) => one === lag).length),
    [6, 6, 6, 6],
    'each value as often',
  );
  await page.selectOption('#sampling', 'saltelli');
  await page.getByLabel('Base samples').fill('16');
  await reads(page.locator('#sample-facts'), /16 base samples × \(2 axes \+ 2\) = 64 points\./);
  await counted(page);
  await reads(estimate(page), /^64 runs of 64 points/);
  await page.getByLabel('Together with the axis above').check();
  await page.locator('[data-axis="1.levels"]').fill('4');
  await reads(page.locator('#sample-facts'), /\(1 axis \+ 2\) = 48 points/);
  await counted(page);
  await reads(estimate(page), /^48 runs of 48 points/);
  await page.getByLabel('Base samples').fill('0');
  await page.locator('#wrong-sample').filter({ hasText: 'count: must be a whole number from 1' }).waitFor();
  await settles(() => page.locator('#points').getAttribute('aria-invalid'), 'true');
  await close();
});

test('of many points those under others are not drawn, and it says how many; the table has all', async () => {
  const scenario = { kind: 'motion', problem: 'oscillator', duration_s: 0.2, methods: [{ method: 'rk4' }] };
  const axes = [
    { path: 'methods.0.dt_s', from: 0.01, to: 0.1, count: 60 },
    { path: 'params.omega', from: 0.5, to: 5, count: 50 },
  ];
  const { id } = (await api(daemon.url, 'experiments', { scenario, axes, metrics: ['methods.0.e_max', 'methods.0.evaluations'] })).body;
  await until(async () => (await api(daemon.url, `experiments/${id}`)).body.state === 'done', 'the runs');
  const { page, complaints, close } = await open({ hash: `#experiments=${id}` });
  const text = await reads(page.locator('#covered'), /points lie under others/);
  const said = Number(/^([\d,]+) of 3,000 points lie under others/.exec(text)?.[1]?.replace(',', ''));
  assert.ok(said > 100 && said < 2950, text);
  await reads(page.locator('#drawer-table'), /2,900 more points/);
  await page.locator('tr[data-point="7"] th').click();
  await reads(page.locator('#point'), /^Point 7\b/);
  await page.focus('#scatter-box');
  await page.keyboard.press('ArrowRight');
  await reads(page.locator('#point'), /^Point \d+/);
  assert.deepEqual(complaints, []);
  await close();
});

test('a work-precision experiment is written for a scenario of each kind, and from a session with its parameters', async () => {
  const { page, complaints, close } = await open();
  for (const [id, axes, error] of [
    ['crates_delta', ['server.snapshot_encoding', 'server.update_hz'], 'players.0.remote_error_m.mean'],
    ['rigid/pyramid', ['solver.method', 'solver.substeps', 'solver.iterations'], 'drift_worst_m'],
    ['fluid/taylor_green', ['solver.advection', 'params.n'], 'error_max'],
    ['motion/orbit', ['methods.0.method', 'methods.0.dt_s'], 'methods.0.e_max'],
  ]) {
    await page.selectOption('#of', String(id));
    await until(
      async () => (await specification(page)).scenario === id && (await specification(page)).metrics.length > 0,
      `a form of ${id}`,
    );
    await page.locator('#trade').click();
    await until(async () => (await specification(page)).cost === 'cost.ns_per_sim_s', `the trade of ${id}`);
    const written = await specification(page),
      paths = written.axes.flatMap((/** @type {any} */ axis) => (axis.zip ?? [axis]).map((/** @type {any} */ one) => one.path));
    for (const path of axes) assert.ok(paths.includes(path), `${id}: ${paths}`);
    assert.match(written.error, new RegExp(id === 'fluid/taylor_green' ? '^(error|divergence)' : `^${error}$`));
    assert.equal((await api(daemon.url, 'experiments?dry_run=true', written)).status, 200);
  }
  await page.goto(`${daemon.url}?scenario=eight&players.2.lag_ms=123`);
  await page.waitForFunction(() => globalThis.laglab?.().frame !== null && document.querySelector('#speed-against-error') !== null);
  const { players } = await page.evaluate(() => globalThis.laglab().params);
  await page.locator('#speed-against-error').click();
  await page.waitForFunction(() => document.querySelector('[data-state="done"]') && document.querySelector('#scatter')); // by itself
  await openDrawers(page);
  const { scenario, cost } = await specification(page);
  assert.deepEqual([scenario.players.length, scenario.players[2].lag_ms, cost], [8, players[2].lag_ms, 'cost.ns_per_sim_s']);
  assert.deepEqual(complaints, []);
  await close();
});

test('an error of the daemon is shown at the field that it names', async () => {
  const { page, close } = await open();
  const wrong = async (/** @type {string} */ field, /** @type {RegExp} */ words) => {
    const text = page.locator(`#wrong-${field.replaceAll('.', '-')}`);
    await text.filter({ hasText: words }).waitFor();
    await settles(() => page.locator('#run').isDisabled(), true);
  };
  await page.locator('[data-axis="0.values"]').fill('0, 5000');
  await wrong('axes.0', /5000/);
  await settles(
    () => page.locator('[data-axis="0.values"]').getAttribute('aria-describedby'),
    null,
    'the daemon names the axis, not its values',
  );
  await page.getByRole('button', { name: 'Range' }).click();
  await page.locator('[data-axis="0.count"]').fill('many');
  await wrong('axes.0', /count/);
  await settles(() => page.locator('[data-axis="0.count"]').getAttribute('aria-invalid'), 'true');
  await settles(() => page.locator('[data-axis="0.count"]').getAttribute('aria-describedby'), 'wrong-axes-0');
  await page.locator('[data-axis="0.count"]').fill('3');
  await page.locator('#repeats').fill('0');
  await wrong('repeats', /repeats/);
  await page.locator('#repeats').fill('1');
  for (let left = await page.locator('.chosen input').count(); left > 0; left--) await page.locator('.chosen input').first().click();
  await wrong('metrics', /metrics: must be/);
  await page.locator('#find-metric').fill('players.1.remote_error mean');
  await page.locator('.offered input').first().click();
  await settles(() => page.locator('.chosen').innerText(), 'Player B: Others, error, mean (m)');
  assert.match((await page.locator('.chosen label').getAttribute('title')) ?? '', /players\.1\.remote_error_m\.mean$/, 'the path');
  await page.locator('#run:not([disabled])').waitFor();
  await close();
});

test('run, watched by the stream, read as scatter and table, opened live; the way back; kept over a reload', async () => {
  const { page, context, complaints, close } = await open();
  await begin(page, 'experiments/lag_techniques');
  assert.equal((await specification(page)).axes[0].zip.length, 3, 'what goes together stays so');
  await page.getByLabel(/^Value of Duration/).fill('6');
  await counted(page);
  await reads(estimate(page), /^20 runs of 20 points/);
  const order = await specification(page);
  await run(page);
  const id = await shownId(page);
  await settles(() => page.locator('[data-way]').getAttribute('data-way'), 'stream');
  await page.locator('tr[data-point="19"]').waitFor();

  // The table is the API's, and so are files and report; the curl line makes the same again.
  const rows = (await api(daemon.url, `experiments/${id}/results?points=true&format=json`)).body;
  await settles(
    async () => (await column(page, 'players.0.lag_ms')).map(Number),
    rows.map((row) => row['players.0.lag_ms']),
  );
  const same = (await api(daemon.url, 'experiments', order)).body;
  await until(async () => (await api(daemon.url, `experiments/${same.id}`)).body.state === 'done', 'the same by the line');
  assert.deepEqual((await api(daemon.url, `experiments/${same.id}/results?points=true&format=json`)).body, rows);
  await settles(() => page.locator('.files a').count(), 9);
  const links = await page.locator('.files a').evaluateAll((all) => all.map((a) => /** @type {HTMLAnchorElement} */ (a).href));
  for (const link of links) assert.equal((await fetch(link)).status, 200, link);

  // The front is that of the two sides of the trade, found without the page.
  const { error, cost } = { error: order.metrics[0], cost: order.metrics[1] };
  const beaten = (a) => rows.some((b) => b[cost] <= a[cost] && b[error] <= a[error] && (b[cost] < a[cost] || b[error] < a[error]));
  await settles(
    async () => (await column(page, 'front')).map((text) => text === 'front'),
    rows.map((row) => !beaten(row)),
  );

  // By keyboard from point to point, and into one.
  await page.focus('#scatter-box');
  await page.keyboard.press('ArrowRight');
  const first = await reads(page.locator('#point'), /^Point \d+.*Player A: One-way lag \(ms\)/);
  await page.keyboard.press('ArrowRight');
  const second = await until(async () => {
    const text = await page.locator('#point').innerText();
    return text !== first && text;
  }, 'another point');
  const point = Number(/^Point (\d+)/.exec(second)[1]);
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => globalThis.laglab().frame !== null);
  assert.equal((await sessionOf(page)).owner, true);
  assert.equal((await page.evaluate(() => globalThis.laglab().params)).players[0].lag_ms, rows[point]['players.0.lag_ms']);
  await reads(async () => page.url(), /#s=/);
  await page.goBack();
  await page.locator('tr[data-point="19"]').waitFor();
  await settles(() => shownId(page), id);

  // Sorting, and a row's own button.
  await page.locator('[data-column="players.0.lag_ms"] button').click();
  await page.locator('[data-column="players.0.lag_ms"] button').click();
  await until(async () => {
    const lags = (await column(page, 'players.0.lag_ms')).map(Number);
    return lags.every((lag, i) => i === 0 || lag <= lags[i - 1]);
  }, 'the largest first');
  await page.locator('tr[data-point="3"] button').focus();
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => globalThis.laglab().frame !== null);
  await page.getByRole('button', { name: 'Experiments', exact: true }).click();
  await page.locator('tr[data-point="3"]').waitFor();

  // A reload, and another tab of the same browser.
  await page.reload();
  await openDrawers(page);
  await page.locator('tr[data-point="19"]').waitFor();
  await settles(() => page.locator('.mine li').count(), 1);
  const other = await context.newPage();
  await other.goto(`${daemon.url}#experiments`);
  await other.locator('.mine li', { hasText: 'Done' }).waitFor();
  await other.locator(`[data-id="${id}"]`).click();
  await other.locator('[data-drawer="table"]').click();
  await other.locator('tr[data-point="19"]').waitFor();
  await other.getByRole('button', { name: /^Delete/ }).click();
  await other.locator('.mine').waitFor({ state: 'detached' });
  assert.equal((await api(daemon.url, `experiments/${id}`)).status, 404);
  assert.deepEqual(complaints, []);
  await close();
});

test('pause, resume and cancel, and what a reader may not; without a stream it asks', async () => {
  const { page, close } = await open();
  await page.locator('#repeats').fill('3000');
  await counted(page);
  await page.locator('#run').click();
  await page.waitForFunction(() => /** @type {HTMLProgressElement} */ (document.querySelector('progress'))?.value > 0);
  await reads(page.locator('#progress-text'), /Running · [\d,]+ of 15,000 runs/);
  await page.waitForFunction(() => /runs\/s · \d+ (s|min) left/.test(document.getElementById('progress-text')?.textContent ?? ''));
  const id = await shownId(page);
  const reader = await browser.newContext({ viewport: { width: 1366, height: 768 } });
  const away = await reader.newPage();
  await away.addInitScript(() => {
    globalThis.WebSocket = /** @type {any} */ (
      class {
        onclose = () => {};
        constructor() {
          setTimeout(() => this.onclose(), 1);
        }
        close() {}
      }
    );
  });
  await away.goto(`${daemon.url}#experiments=${id}`);
  await away.locator('[data-way="asking"]').waitFor();
  await settles(() => away.locator('#pause').isDisabled(), true);
  await reads(away.locator('.progress'), /Read-only/);
  await page.locator('#pause').click();
  await page.locator('[data-state="paused"]').waitFor();
  await away.locator('[data-state="paused"]').waitFor();
  await page.locator('#resume').click();
  await page.locator('[data-state="running"]').waitFor();
  await page.locator('#cancel').click();
  await away.locator('[data-state="cancelled"]').waitFor();
  await page.locator('[data-state="cancelled"]').waitFor();
  await until(async () => /cancelled/i.test(await page.locator('#live').innerText()), 'it is spoken');
  assert.equal((await api(daemon.url, `experiments/${id}`)).body.state, 'cancelled');
  await reader.close();
  await close();
});

test('a pointer picks a point, and opens it when it picks it again', async () => {
  const { page, close } = await open();
  await run(page);
  await page.locator('tr[data-point="4"]').waitFor();
  await page.focus('#scatter-box');
  await page.keyboard.press('ArrowRight');
  const find = async () => {
    /* the picked point's ring, by its colour */
    const at = await page.evaluate(() => {
      const canvas = /** @type {HTMLCanvasElement} */ (document.getElementById('scatter')),
        ratio = canvas.width / canvas.clientWidth;
      const { data, width } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
      let n = 0,
        sx = 0,
        sy = 0;
      for (let i = 0; i < data.length; i += 4)
        if (data[i] === 0 && data[i + 1] === 0x72 && data[i + 2] === 0xb2) {
          n++;
          sx += (i / 4) % width;
          sy += Math.floor(i / 4 / width);
        }
      return { x: sx / n / ratio, y: sy / n / ratio, n };
    });
    return at.n > 20 ? at : null;
  };
  const at = await until(find, 'the ring');
  await page.locator('tr[data-point="2"] th').click();
  await reads(page.locator('#point'), /^Point 2\b/);
  await page.locator('#scatter-box').scrollIntoViewIfNeeded(); /* a click in the table can have moved it */
  const box = await page.locator('#scatter-box').boundingBox();
  await page.mouse.click(box.x + 1 + at.x, box.y + 1 + at.y);
  await until(async () => !/^Point 2\b/.test(await page.locator('#point').innerText()), 'another point');
  await page.mouse.click(box.x + 1 + at.x, box.y + 1 + at.y);
  await page.waitForFunction(() => globalThis.laglab().frame !== null);
  await close();
});

for (const size of [SIZES[0], SIZES[1], { name: '360x740', width: 360, height: 740, query: '' }]) {
  sweep(size.width < 400)(`axe, size of targets, no sideways scroll, nothing cut off at ${size.name}`, async () => {
    const { page, complaints, close } = await open(size);
    await page.selectOption('#sampling', 'saltelli');
    await page.locator('#until').check();
    await page.locator('.until').waitFor();
    await page.locator('#add-window').click();
    await page.locator('[data-window-while="0"]').check();
    await page.locator('[data-window-value="0"] option').nth(1).waitFor({ state: 'attached' });
    assert.deepEqual(await axe(page), [], 'the form with all that it has');
    if (SHOTS) await page.locator('#windows').screenshot({ path: `${SHOTS}/windows-${size.name}.png` });
    await page.getByRole('button', { name: 'Remove window part_1' }).click();
    await page.locator('#until').uncheck();
    await page.locator('#repeats').fill('1');
    await page.selectOption('#sampling', 'none');
    await page.locator('[data-axis="0.values"]').fill('0, 5000');
    await page.locator('#wrong-axes-0').waitFor();
    assert.deepEqual(await axe(page), [], 'an error');
    await page.locator('[data-axis="0.values"]').fill('0, 100, 200');
    await counted(page);
    await run(page);
    await page.locator('tr[data-point="2"] th').click();
    assert.deepEqual(await axe(page), [], 'results');
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth > innerWidth), false);
    const small = await page.locator('main button, main select, main label:has(input[type="checkbox"]), main a').evaluateAll((all) =>
      all
        .filter((e) => e.getClientRects().length > 0)
        .map((e) => ({ what: e.outerHTML.slice(0, 80), w: e.getBoundingClientRect().width, h: e.getBoundingClientRect().height }))
        .filter((b) => b.w < 24 || b.h < 23.9),
    );
    assert.deepEqual(small, []);
    const boxes = '.panel, .axis, .order, .progress, .choices, .files, .mine li, .until, .frontof, .numbers';
    const cut = await page.evaluate(
      (selector) =>
        [...document.querySelectorAll(selector)].flatMap((box) => {
          const outer = box.getBoundingClientRect();
          return [...box.querySelectorAll('button, input, select, h2, a')]
            .filter((part) => {
              const inner = part.getBoundingClientRect();
              return inner.width > 0 && !part.closest('.unseen') && (inner.right > outer.right + 1 || inner.left < outer.left - 1);
            })
            .map((part) => `${box.className}: ${part.outerHTML.slice(0, 90)}`);
        }),
      boxes,
    );
    assert.deepEqual(cut, []);
    assert.deepEqual(complaints, []);
    await close();
  });
}
