// Reports in a browser: opened from a file, without a network; what they show is what the rows say.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, statSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath, pathToFileURL } from 'node:url';
import { axe, launch } from './lib.mjs';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
const BINARY = path.resolve(process.env.LAGLAB_BIN ?? path.join(ROOT, 'build/laglab'));
/** 200000 takes some 10 s; every size is below the same limits. */
const ROWS = Number(process.env.LAGLAB_REPORT_ROWS ?? 20000);

let folder;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  folder = mkdtempSync(path.join(tmpdir(), 'laglab-report-'));
  browser = await launch();
});
after(async () => {
  await browser?.close();
  rmSync(folder, { recursive: true, force: true });
});

const file = (/** @type {string} */ name) => path.join(folder, name);

/** @param {...string} args */
function laglab(...args) {
  const { status, stdout, stderr } = spawnSync(BINARY, args, { cwd: folder, encoding: 'utf8', maxBuffer: 1 << 28, timeout: 120000 });
  assert.equal(status, 0, stderr);
  return stdout;
}

/** @param {string} name @param {object} experiment @param {...string} more */
function sweep(name, experiment, ...more) {
  writeFileSync(file(`${name}.json`), JSON.stringify(experiment));
  return laglab('sweep', `${name}.json`, '--scenarios', path.join(ROOT, 'scenarios'), '--report', `${name}.html`, ...more);
}

/** Opens a report, and fails on anything that the console or the network says. @param {string} name @param {object} [wish] */
async function open(name, wish = {}) {
  const context = await browser.newContext(wish),
    page = await context.newPage(),
    /** @type {string[]} */ said = [],
    address = pathToFileURL(file(`${name}.html`)).href;
  page.on('console', (message) => said.push(message.text()));
  page.on('pageerror', (error) => said.push(error.message));
  page.on('request', (request) => request.url() === address || said.push(`asked for ${request.url()}`));
  await page.goto(address);
  await page.locator('#views canvas').first().waitFor();
  return { page, said, close: () => context.close() };
}

const nodes = (/** @type {import('playwright-core').Page} */ page) => page.evaluate(() => document.getElementsByTagName('*').length);
const VIEWS = ['series', 'scatter', 'heat', 'spread', 'differences', 'table'];

test('many rows open at once, in two megabytes and a few hundred elements', async (t) => {
  const steps = Math.ceil(ROWS / 800);
  sweep(
    'many',
    {
      title: 'Many',
      scenario: { kind: 'motion', problem: 'oscillator', duration_s: 0.3, methods: [{ method: 'rk4' }] },
      axes: [
        { path: 'methods.0.method', values: ['explicit_euler', 'semi_implicit_euler', 'velocity_verlet', 'rk4'] },
        { path: 'methods.0.dt_s', from: 0.01, to: 0.1, count: steps, scale: 'log' },
        { path: 'params.omega', from: 0.5, to: 5, count: 200 },
      ],
      metrics: ['methods.0.e_max', 'methods.0.evaluations'],
    },
    '--out',
    'many.csv',
  );
  const bytes = statSync(file('many.html')).size,
    { page, said, close } = await open('many');
  assert.ok(bytes <= 2e6, `${bytes} bytes`);
  for (const view of VIEWS) {
    await page.locator(`#tab-${view}`).click();
    assert.ok((await nodes(page)) < 2000, view);
  }
  t.diagnostic(`${steps * 800} rows: ${bytes} bytes, ${await nodes(page)} elements`);
  // All rows of the file are in the page: their values in full here.
  const lines = readFileSync(file('many.csv'), 'utf8').trimEnd().split('\r\n'),
    heads = lines[0].split(','),
    at = ['methods.0.e_max', 'methods.0.evaluations'].map((name) => heads.indexOf(name));
  const held = await page.evaluate(() => [0, 1].map((m) => [...globalThis.report.column(m, 'mean')]));
  assert.equal(held[0].length, lines.length - 1);
  lines.slice(1).forEach((line, k) => {
    const cells = line.split(',');
    for (const m of [0, 1]) {
      const value = cells[at[m]] === '' ? null : Number(cells[at[m]]);
      assert.ok(Math.abs(held[m][k] - value) <= 1e-6 * Math.abs(value), `row ${k}: ${held[m][k]} for ${value}`);
    }
  });
  assert.equal(await page.locator('#where code').innerText(), 'many.csv');
  assert.deepEqual(said, []);
  await close();
});

const SEEDS = {
  title: 'Frames <b>&',
  scenario: {
    kind: 'motion',
    problem: 'kepler',
    duration_s: 0.5,
    methods: [{ method: 'rk4', steps: 'frame' }],
    frame_jitter: 0.5,
    frames: 'random',
  },
  axes: [
    { path: 'methods.0.method', values: ['explicit_euler', 'velocity_verlet', 'rk4'] },
    { path: 'params.e', values: [0.1, 0.3] },
  ],
  repeats: 12,
  metrics: ['methods.0.e_max', 'methods.0.energy_drift_max'],
};

test('statistics, runs and differences in the page are those of the tables', async () => {
  const runs = JSON.parse(sweep('seeds', SEEDS, '--format', 'json')),
    points = JSON.parse(laglab('sweep', 'seeds.json', '--points', '--format', 'json')),
    { page, said, close } = await open('seeds');
  const held = await page.evaluate(() => {
    const r = globalThis.report;
    const names = ['mean', 'low', 'high', 'sd', 'p25', 'p50', 'p75'];
    return {
      head: r.head,
      columns: [0, 1].map((m) => Object.fromEntries(names.map((name) => [name, [...r.column(m, name)]]))),
      runs: [0, 1].map((m) => [...r.run(m)]),
      details: r.head.differences.map((_, k) => ['mean', 'low', 'high'].map((name) => [...r.difference(k, name)])),
    };
  });
  const tabled = { mean: '', low: '.ci95_low', high: '.ci95_high', sd: '.sd', p25: '.p25', p50: '.p50', p75: '.p75' };
  for (const [m, metric] of SEEDS.metrics.entries()) {
    for (const [name, end] of Object.entries(tabled))
      assert.deepEqual(
        held.columns[m][name],
        points.map((/** @type {any} */ p) => p[metric + end]),
        metric + end,
      );
    assert.deepEqual(
      held.runs[m],
      runs.map((/** @type {any} */ r) => r[metric]),
      `runs of ${metric}`,
    );
  }
  // Each difference at a setting is what --compare writes, by the same statistics.
  let compared = 0;
  for (const [k, d] of held.head.differences.entries()) {
    if (d.dimension !== 0) continue;
    for (const setting of [0, 1]) {
      const rows = JSON.parse(laglab('sweep', 'seeds.json', '--points', '--format', 'json', '--compare', String(d.from * 2 + setting))),
        row = rows[d.of * 2 + setting],
        metric = SEEDS.metrics[d.metric];
      assert.deepEqual(
        held.details[k].map((column) => column[setting]),
        [row[`${metric}.diff`], row[`${metric}.diff_low`], row[`${metric}.diff_high`]],
      );
      compared++;
    }
  }
  assert.equal(compared, 2 * 3 * 2);
  await page.locator('#tab-differences').click();
  const first = held.head.differences.find(
    (/** @type {any} */ d) => d.dimension === 0 && d.metric === held.head.error && d.from === 0 && d.of === 1,
  );
  const shown = (/** @type {number} */ x) => String(Number(x.toPrecision(6))).replace('-', '−');
  const overall = await page.locator('#overall').innerText();
  assert.ok(
    overall.includes(
      `velocity_verlet minus explicit_euler: ${shown(first.all[0])} (95 % from ${shown(first.all[1])} to ${shown(first.all[2])}`,
    ),
    overall,
  );
  // Reversed, the difference has the other sign.
  await page.locator('#pick-from').selectOption({ label: 'velocity_verlet' });
  assert.ok(
    (await page.locator('#overall').innerText()).startsWith(
      `explicit_euler minus velocity_verlet: ${shown(-first.all[0])} (95 % from ${shown(-first.all[2])}`,
    ),
  );
  // The table pages, sorts and chooses; its cells are the rows' values.
  await page.locator('#tab-table').click();
  const cells = (await page.locator('#view tbody tr').nth(3).locator('td').allInnerTexts()).slice(0, 5);
  assert.deepEqual(cells, ['3', 'velocity_verlet', '0.3', '12', shown(points[3]['methods.0.e_max'])]);
  assert.match(await page.locator('#view').innerText(), /How often intervals contain the mean: bootstrap-t: /);
  await page.locator('#sort-m0mean').click();
  const least = [...points].sort((/** @type {any} */ a, /** @type {any} */ b) => a['methods.0.e_max'] - b['methods.0.e_max'])[0];
  assert.equal(await page.locator('#view tbody td').first().innerText(), String(least.point));
  await page.locator('#only-0').selectOption({ label: 'explicit_euler' });
  assert.equal(await page.locator('#view tbody tr').count(), 2);
  assert.equal(await page.locator('h1').innerText(), SEEDS.title);
  assert.deepEqual(said, []);
  await close();
});

test('every view works by keys, in dark and light and on a phone, and a point opens live', async () => {
  sweep('race', {
    scenario: 'race',
    set: { duration_s: 3 },
    axes: [
      {
        zip: [
          { path: 'players.0.prediction', values: [false, true] },
          { path: 'players.0.reconciliation', values: [false, true] },
        ],
      },
      { path: 'players.0.lag_ms', values: [0, 100, 200] },
    ],
    metrics: ['players.0.own_timeline_error_m.rms', 'players.0.remote_error_m.mean'],
  });
  for (const wish of [{ colorScheme: 'dark' }, {}, { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true }]) {
    const { page, said, close } = await open('race', wish);
    await page.locator('#tab-series').focus();
    for (const view of [...VIEWS.slice(1), VIEWS[0]]) {
      await page.keyboard.press('ArrowRight');
      assert.equal(await page.locator('[role=tab][aria-selected=true]').getAttribute('id'), `tab-${view}`);
      assert.ok(
        (await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)) <= 0,
        `${view} is not wider than the screen`,
      );
      if (!('hasTouch' in wish) && ['spread', 'table'].includes(view)) assert.deepEqual(await axe(page), [], view);
    }
    // Marks by arrow keys; a point's details by Enter.
    await page.locator('#series').focus();
    await page.keyboard.press('ArrowRight');
    assert.match(await page.locator('.tip').first().innerText(), /players\.0\.lag_ms 0: .*error_m/);
    await page.keyboard.press('Enter');
    assert.equal(
      await page.locator('#live').getAttribute('href'),
      'http://127.0.0.1:8080/?scenario=race&set=duration_s:3' +
        '&set=players.0.prediction:false&set=players.0.reconciliation:false&set=players.0.lag_ms:0&seed=1',
    );
    assert.match(
      await page.locator('#detail code').innerText(),
      /^laglab run race --seed 1 --set 'duration_s=3' --set 'players\.0\.prediction=false'/,
    );
    assert.deepEqual(said, []);
    await close();
  }
});

const lines = (/** @type {string} */ name) =>
  readFileSync(file(name), 'utf8')
    .trim()
    .split('\n')
    .map((line) => JSON.parse(line)); // prettier-ignore

/** What the marks of each plot say, and the rows of its table. @param {import('playwright-core').Page} page */
async function plotted(page) {
  for (const summary of await page.locator('.plots summary').all()) await summary.click();
  await page.waitForFunction(() => [...document.querySelectorAll('.plots details')].every((one) => one.querySelector('table')));
  return page.evaluate(() =>
    globalThis.report.drawings.map((/** @type {any} */ c) => ({
      marks: c.marks.map((/** @type {any} */ m) => ({ text: m.text(), ...m.of })),
      rows: [...c.box.parentElement.querySelectorAll('tbody tr')].map((tr) => [...tr.children].map((td) => td.textContent)),
      marked: c.box.parentElement.querySelectorAll('tr.on').length,
    })),
  );
}

test('a trade-off is drawn for each cost, with its front, levels, choices and links', async () => {
  laglab(
    ...['tradeoff', 'lag_compensation', '--duration', '3', '--seeds', '10', '--check-seeds', '10', '--page', 'http://lab/'],
    ...['--scenarios', path.join(ROOT, 'scenarios'), '--out', 't.ndjson', '--winners', 'w.ndjson', '--report', 't.html'],
  );
  const rows = lines('t.ndjson'),
    winners = lines('w.ndjson'),
    costs = [...new Set(rows.map((row) => row.cost))];
  for (const wish of [{}, { viewport: { width: 390, height: 844 }, colorScheme: 'dark' }]) {
    const { page, said, close } = await open('t', wish),
      plots = await plotted(page);
    assert.equal(plots.length, costs.length);
    for (const [k, cost] of costs.entries()) {
      const of = rows.filter((row) => row.cost === cost && row.cost_value !== null && row.error !== null);
      const points = (/** @type {any[]} */ list, /** @type {(one: any) => any[]} */ read) => list.map(read).map(String).sort();
      const read = (/** @type {any} */ row) => [row.link, row.cost_value, row.error, row.error_low, row.error_high, row.front];
      assert.deepEqual(
        points(plots[k].marks, (m) => [m.link, m.x, m.y, m.low, m.high, m.front]),
        points(of, read),
      );
      assert.equal(plots[k].rows.length, of.length);
      assert.equal(plots[k].marked, of.filter((row) => row.front).length);
      const chosen = new Set(winners.filter((w) => w.cost === cost && w.link).map((w) => w.link));
      assert.deepEqual(new Set(plots[k].marks.filter((/** @type {any} */ m) => m.chosen).map((/** @type {any} */ m) => m.link)), chosen);
    }
    const choices = await page.locator('h3 + .scroll tbody tr').allInnerTexts();
    assert.equal(choices.length, winners.length);
    for (const [k, w] of winners.entries())
      assert.ok(choices[k].includes(w.verdict) && choices[k].includes(w.method ?? 'none'), choices[k]);
    await page.locator('#plot-0').focus();
    await page.keyboard.press('ArrowRight');
    assert.match(await page.locator('.tip').first().innerText(), /^\w+, \w+ \d+: CPU time of a run, minimum, s /);
    assert.ok((await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)) <= 0);
    assert.deepEqual(await axe(page), []);
    assert.deepEqual(said, []);
    await close();
  }
});

test('levels of refinement are drawn against time and counted cost, with the front of each', async () => {
  const options = ['--duration', '1', '--scenarios', path.join(ROOT, 'scenarios'), '--format', 'ndjson', '--report'];
  writeFileSync(file('column.ndjson'), laglab('work-precision', 'rigid/column', ...options, 'column.html'));
  writeFileSync(file('kepler.ndjson'), laglab('work-precision', 'kepler', '--methods', 'rk4,dopri5', ...options, 'kepler.html'));
  for (const [name, method, error, count] of [
    ['column', 'series', 'error', 'count'],
    ['kepler', 'method', 'e_max', 'evaluations'],
  ]) {
    const rows = lines(`${name}.ndjson`),
      { page, said, close } = await open(name),
      plots = await plotted(page);
    assert.equal(plots.length, 2);
    for (const [k, cost] of ['cpu_min_s', count].entries()) {
      const all = rows.filter((row) => row[error] > 0).map((row) => [row[method], row[cost], row[error]]);
      const front = all.filter(([, x, y]) => !all.some(([, a, b]) => a <= x && b <= y && (a < x || b < y)));
      const read = (/** @type {any[]} */ marks) => marks.map((m) => String([m.name.split(',')[0], m.x, m.y])).sort();
      assert.deepEqual(read(plots[k].marks), all.map(String).sort());
      assert.deepEqual(read(plots[k].marks.filter((/** @type {any} */ m) => m.front)), front.map(String).sort());
      assert.equal(plots[k].rows.length, rows.length);
    }
    assert.match(await page.locator('body').innerText(), /Repeated by laglab work-precision /);
    assert.deepEqual(await axe(page), []);
    assert.deepEqual(said, []);
    await close();
  }
});

test('without scripts the page says how to get the points', async () => {
  sweep('plain', { ...SEEDS, repeats: 2 });
  const context = await browser.newContext({ javaScriptEnabled: false }),
    page = await context.newPage();
  await page.goto(pathToFileURL(file('plain.html')).href);
  const text = await page.locator('body').innerText();
  assert.match(text, /Scripts are off.*laglab sweep experiment\.json --points --out points\.csv/);
  assert.match(text, /"path":\s*"params\.e"/, 'the specification');
  await context.close();
});
