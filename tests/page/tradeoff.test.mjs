// Speed against error: the rule on the measured rows, all families as they open, the handles by keys and by dragging, the runs that follow
// them, labs that lead to their families, in German on a phone.
import assert from 'node:assert/strict';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before } from 'node:test';
import { fileURLToPath } from 'node:url';
import { shippedRows } from '../../cmake/shipped_rows.mjs';
import { cheapest, merged, nearest, needed, opening, pointsOf, rivalOf, tried } from '../../www/js/labs/tradeoff/rule.js';
import { startDaemon } from '../lib/daemon.mjs';
import { englishIn, hearCanvases, textsOn } from './german.mjs';
import { api, axe, bytesOf, launch, paramsOf, reads, settles, until, visit } from './lib.mjs';
import { sweep, test } from './tiers.mjs';

const SHOTS = process.env.LAGLAB_SHOTS ?? ''; // a folder for images of the page
const MEASURED = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../../bench/results/tradeoff');
const FAMILIES = [
  ...['integrators', 'contact_solvers', 'pressure_solvers', 'particles'],
  ...['oceans', 'snapshots', 'synchronisation', 'lag_compensation'],
];
const SEEN_PX = 40;

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

/** @typedef {import('playwright-core').Page} Page */
/** @param {Page} page @param {string} name */
const shot = (page, name) => (SHOTS === '' ? undefined : page.screenshot({ path: `${SHOTS}/tradeoff-${name}.png` }));
/** @param {Page} page */
const hash = (page) => page.evaluate(() => location.hash);
/** What the view shows. @param {Page} page @returns {Promise<any>} */
const facts = (page) => page.evaluate(() => globalThis.laglab?.().tradeoff ?? null);
/** @param {Page} page */
const sentence = (page) => page.locator('#tradeoff-said');
/** @param {Page} page @param {'budget' | 'enough'} name */
const handle = (page, name) => page.locator(`[role="slider"][data-handle="${name}"]`);
/** @param {{x: number, y: number}} a @param {{x: number, y: number}} b */
const apart = (a, b) => Math.hypot(a.x - b.x, a.y - b.y);
/** @param {Page} page */
const opened = (page) => until(async () => Boolean((await facts(page))?.ring), 'the plot is drawn');
/** Sessions of the daemon. */
const sessions = async () => Number(/^laglab_sessions(?:\{[^}]*\})? (\d+)$/m.exec(await (await fetch(`${daemon.url}metrics`)).text())?.[1]);

/** What ships of a family. @param {string} family */
const shipped = (family) =>
  shippedRows(family, readFileSync(`${MEASURED}/${family}.csv`, 'utf8'), readFileSync(`${MEASURED}/winners.csv`, 'utf8'));

test('the cheapest is that of the winners, at each of their levels', () => {
  let count = 0;
  for (const family of FAMILIES) {
    const { rows, choices } = shipped(family);
    for (const { problem, cost, level, row } of choices) {
      const points = pointsOf(/** @type {any} */ (rows), problem, cost),
        best = cheapest(points, { cost: Number.POSITIVE_INFINITY, error: level });
      assert.ok(best && row !== null, `${family} ${level}`);
      /* the file has six digits: those that cost the same by them may take each other's place */
      const wanted = points.find(({ index }) => index === row),
        ties = points.filter((one) => one.cost === wanted?.cost && (one.errors[2] ?? 0) <= level);
      assert.equal(best.cost, wanted?.cost, `${family} ${problem} ${cost} ${level}`);
      assert.ok(ties.length > 1 || best.index === row, `${family} ${problem} ${cost} ${level}: ${rows[best.index]?.method}`);
      count++;
      /* a line of cost just below it leaves nothing so cheap */
      if (best.cost > 0) assert.equal(cheapest(points, { cost: best.cost * 0.999, error: level }), undefined);
    }
  }
  assert.equal(count, 123);
});

test('what is compared: the rival, what it needs, what its budget buys, what is nearest', () => {
  const { rows } = shipped('integrators'),
    list = /** @type {any[]} */ (rows),
    points = pointsOf(list, 0, 1);
  const lines = { cost: 5000, error: 0.018 },
    winner = /** @type {any} */ (cheapest(points, lines));
  assert.equal(winner.method, 'dop853');
  assert.equal(rivalOf(points, ['rk4', 'dop853'], winner, lines, ['rk4']), 'rk4');
  assert.equal(needed(points, 'rk4', 0.018)?.cost, 32768);
  assert.equal(list[tried(list, points, 0, 1, 'rk4', 5000)].costs[1][0], 4096);
  /* a method that comes to no end within the budget is shown so; one that cannot be paid at all by its cheapest */
  const stiff = pointsOf(list, 1, 1),
    lost = list[tried(list, stiff, 1, 1, 'rk4', 5000)];
  assert.equal(lost.error[0], null);
  assert.ok(lost.costs[1][0] <= 5000);
  assert.ok(list[tried(list, points, 0, 1, 'dop853', 10)].costs[1][0] > 10);
  /* nothing is within both lines: the fewest decades beyond them */
  assert.equal(cheapest(points, { cost: 100, error: 1e-9 }), undefined);
  assert.equal(nearest(points, { cost: 2500, error: 1e-10 })?.method, 'taylor');
  /* of settings that cost the same the truest is shown: Gerstner's waves need the same memory, however many there are */
  const sea = /** @type {any[]} */ (shipped('oceans').rows),
    heights = pointsOf(sea, 0, 1);
  assert.ok(sea[tried(sea, heights, 0, 1, 'gerstner', 200000)].error[0] < 0.02);
  /* lines at first: one is within both, the rival is not */
  const first = opening(points, [0.018], ['rk4', 'dop853'], ['rk4']);
  assert.deepEqual(first, { cost: 5000, error: 0.018 });
});

test('what is measured here takes the place of the same setting; times of two machines do not mix', () => {
  const { rows } = shipped('contact_solvers'),
    list = /** @type {any[]} */ (rows),
    [one] = list,
    here = { ...one, costs: [[9, 9, 9], one.costs[1]] };
  const work = merged(list, [here], false),
    times = merged(list, [here], true);
  assert.equal(work.length, list.length);
  assert.equal(work.filter((row) => row.here).length, 1);
  assert.equal(work.filter((row) => row.problem === one.problem && row.method === one.method && row.value === one.value).length, 1);
  assert.equal(times.filter((row) => row.problem === one.problem).length, 1, 'of that problem what was measured here alone');
  assert.ok(times.filter((row) => row.problem !== one.problem).length > 0);
  /* 0.01953125 is 0.0195313 in the file */
  const steps = /** @type {any[]} */ (shipped('integrators').rows),
    step = steps.find(({ method, value }) => method === 'rk4' && value === 0.0195313);
  assert.equal(merged(steps, [{ ...step, value: 0.01953125 }], false).length, steps.length);
  const lost = merged(list, [{ ...here, error: [null, null, null] }], true);
  assert.equal(lost.length, list.length, 'what came to no end takes the place of its own setting alone');
});

test('orbits: filled at once, handles by keys and by dragging, the sentence and the runs follow, an address keeps them', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}#tradeoff`, { wait: false });
  await reads(
    sentence(page),
    /Inside both lines the cheapest is\s*DOP 853: 0\.007 off for 969 evaluations\.\s*RK4 needs 32,768 evaluations: 34 times as much\./,
  );
  await opened(page);
  const first = await facts(page);
  assert.deepEqual(first.lines, { cost: 5000, error: 0.018 });
  assert.equal(first.here, 0);
  assert.match(await page.locator('#tradeoff-source').innerText(), /^Shipped numbers: laglab \w+, .+, .*20\d\d\.$/);
  await until(async () => (await facts(page)).runs.every((run) => run?.state === 'done' && run.px > 0), 'both runs have ended');
  const [own, other] = (await facts(page)).runs;
  assert.match(decodeURIComponent(own.link), /"dop853"/);
  assert.match(decodeURIComponent(other.link), /"rk4"/);
  assert.ok(other.px >= SEEN_PX, `${other.px} px between RK4's planet and the true one`);
  assert.equal(await page.locator('[data-run="0"] figcaption span').innerText(), '969: on it');
  await settles(sessions, 0, 'a run that has ended is freed');
  await shot(page, 'orbits');
  assert.deepEqual(await axe(page), []);

  // by keys: the budget shrinks until nothing is within both
  await handle(page, 'budget').focus();
  assert.match((await handle(page, 'budget').getAttribute('aria-valuetext')) ?? '', /^my budget: 5,000\. DOP 853/);
  await page.keyboard.press('PageDown');
  await page.keyboard.press('PageDown');
  await reads(sentence(page), /Nothing is both cheap and good enough\.\s*\S.* comes nearest/);
  await until(async () => (await facts(page)).winner === null && (await facts(page)).ring !== null, 'what comes nearest has its ring');
  await page.keyboard.press('PageUp');
  await page.keyboard.press('PageUp');
  await reads(sentence(page), /DOP 853/);

  // dragged: good enough goes down, another is the cheapest, and runs
  const box = /** @type {any} */ (await handle(page, 'enough').boundingBox());
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 2, box.y + 130, { steps: 4 });
  await page.mouse.up();
  await until(async () => (await facts(page)).lines.error < 1e-4, 'good enough has moved');
  const second = await facts(page);
  const all = pointsOf(/** @type {any} */ (shipped('integrators').rows), 0, 1);
  assert.equal(second.winner.method, shipped('integrators').rows[/** @type {any} */ (cheapest(all, second.lines)).index]?.method);
  assert.notEqual(second.winner.value, first.winner.value);
  await until(async () => (await facts(page)).runs[0]?.link === second.winner.link, 'what is the cheapest now runs');
  await until(async () => /&budget=.*&enough=/.test(await hash(page)), 'the address has them');
  await page.reload();
  await opened(page);
  assert.deepEqual((await facts(page)).lines, second.lines);

  // a name: that line alone is dark; every method
  const name = page.locator('.end[data-method="rk4"]');
  await name.click();
  assert.equal(await name.getAttribute('aria-pressed'), 'true');
  await name.click();
  const few = (await facts(page)).points;
  await page.locator('#all-methods').click();
  await until(async () => (await facts(page)).points > 3 * few, 'all methods');
  assert.ok((await page.locator('.work .key button').count()) > 30);
  const ids = await page.locator('.work .key button').allInnerTexts();
  assert.deepEqual(
    ids.filter((text) => /kdk|^\s*(ab|bs|rk)\d|printed/.test(text)),
    [],
    'methods have names',
  );
  await page.locator('#all-methods').click();

  // the same in tables, and as a file
  await page.locator('#tables').click();
  assert.equal(await page.locator('.winners tbody tr').count(), 3);
  const [file] = await Promise.all([page.waitForEvent('download'), page.locator('#csv').click()]);
  const lines = (await bytesOf(file)).toString().trim().split('\r\n');
  assert.equal(lines.length, 1 + shipped('integrators').rows.length * 2);
  assert.equal(lines[0].split(',').length, 27);

  // the run opens in its lab; Back returns, and of the runs nothing is left on the daemon
  await page.locator('.live .main').click();
  await page.waitForFunction(() => globalThis.laglab().params?.problem === 'kepler');
  assert.equal((await paramsOf(page)).methods[0].method, second.winner.method);
  await page.goBack();
  await opened(page);
  await page.getByRole('button', { name: 'Experiments' }).click();
  await settles(sessions, 1, 'the session of the lab is left alone');
  assert.deepEqual(complaints, []);
  await close();
});

test('every family opens on a finished answer, with a ring, and two runs that differ', async () => {
  const before = await sessions(),
    { page, complaints, close } = await visit(browser, `${daemon.url}#tradeoff`, { wait: false });
  for (const family of FAMILIES) {
    await page.locator(`[data-family="${family}"]`).click();
    await until(async () => (await facts(page))?.family === family && (await facts(page)).ring !== null, family);
    const problems = page.locator('.work .segments').first().locator('button[data-choice]'),
      count = shipped(family).rows.reduce((most, { problem }) => Math.max(most, problem), 0) + 1;
    for (let problem = count - 1; problem >= 0; problem--) {
      if (count > 1) await problems.nth(problem).click();
      await until(async () => (await facts(page)).problem === problem && (await facts(page)).ring !== null, `${family} ${problem}`);
      const { ring, rivalAt, rival, winner } = await facts(page);
      assert.ok(winner && rival, family);
      assert.ok(apart(ring, rivalAt) >= SEEN_PX, `${family} ${problem}: ring and rival are ${apart(ring, rivalAt)} px apart`);
    }
    await until(async () => (await facts(page)).runs.every((run) => ['running', 'done'].includes(run?.state)), `${family}: both run`);
    /* of fluids colours are compared, not places */
    const placed = !/pressure|particles|oceans/.test(family);
    if (placed) await until(async () => (await facts(page)).runs.every(({ px }) => px > 0), `${family}: both are drawn`);
    for (const { px, factor } of (await facts(page)).runs)
      assert.ok(px === 0 || px >= SEEN_PX || factor !== 1, `${family}: ${px} px and no lens`);
    /* no caption lies on a scene */
    const over = await page.evaluate(() =>
      [...document.querySelectorAll('.run')].some((run) => {
        const caption = run.querySelector('figcaption')?.getBoundingClientRect(),
          scene = run.querySelector('canvas')?.getBoundingClientRect();
        return !caption || !scene || caption.bottom > scene.top + 1 || scene.height < 70;
      }),
    );
    assert.equal(over, false, `${family}: a caption covers the scene`);
    if (family === 'lag_compensation') {
      await until(async () => (await facts(page)).runs.every(({ px }) => px >= SEEN_PX), 'a shot, and where it counts');
      await reads(
        sentence(page),
        /victim’s veto: B loses 6\.4 hits, A takes 4\.75 in cover\.\s*rewinding, for the same: A takes 11\.15 in cover/,
      );
    }
    await shot(page, family);
  }
  assert.equal(await page.getByText(/No runs yet|not measured|Nothing has been measured/).count(), 0);
  await page.getByRole('button', { name: 'Experiments' }).click();
  await settles(sessions, before, 'runs that are left are freed');
  assert.deepEqual(complaints, []);
  await close();
});

for (const [width, height] of [
  [390, 844],
  [1024, 768],
  [1920, 1080],
])
  sweep(width < 400)(`ring and rival, and the planet and where it truly is, are 40 px apart at ${width}`, async () => {
    const { page, close } = await visit(browser, `${daemon.url}#tradeoff`, { wait: false, width, height });
    await opened(page);
    const { ring, rivalAt } = await facts(page);
    assert.ok(apart(ring, rivalAt) >= SEEN_PX, `${apart(ring, rivalAt)} px`);
    await page.locator('#live-1').scrollIntoViewIfNeeded();
    await until(async () => (await facts(page)).runs[1]?.state === 'done' && (await facts(page)).runs[1].px > 0, 'the run has ended');
    const { px } = (await facts(page)).runs[1];
    assert.ok(px >= SEEN_PX, `${px} px`);
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), width);
    await shot(page, `${width}`);
    await close();
  });

test('measured here: points come meanwhile, for all who look, after a reload and a restart; cancelled they are gone', async () => {
  const data = mkdtempSync(path.join(tmpdir(), 'laglab-tradeoff-'));
  let own = await startDaemon({ data });
  const at = '#tradeoff=contact_solvers';
  const first = await visit(browser, `${own.url}${at}`, { wait: false });
  await opened(first.page);
  assert.equal((await facts(first.page)).here, 0);
  const order = { family: 'contact_solvers', duration_s: 0.3, check_seeds: 0 };
  const { status, body } = await api(own.url, 'tradeoffs', order);
  assert.equal(status, 202);
  await until(async () => (await facts(first.page)).here > 0, 'points that another client has ordered');
  assert.match(await first.page.locator('#tradeoff-source').innerText(), /Hollow: shipped/);
  const second = await visit(browser, `${own.url}${at}`, { wait: false });
  await until(async () => (await facts(second.page))?.here > 0, 'a second browser');
  await reads(second.page.locator('#tradeoff-source'), /^Measured on this machine: .*20\d\d\./);
  const all = (await facts(second.page)).here,
    answer = (await api(own.url, `tradeoffs/${body.id}`)).body.answer;
  assert.equal(all, answer.rows.filter(({ problem, error }) => problem === 0 && error[0] !== null).length);
  assert.equal(await second.page.locator('#cancel').count(), 0);
  await second.page.reload();
  await until(async () => (await facts(second.page))?.here === all, 'after a reload');
  await first.close();
  await second.context.close();
  await own.stop();
  own = await startDaemon({ data });
  const third = await visit(browser, `${own.url}${at}`, { wait: false });
  await until(async () => (await facts(third.page))?.here === all, 'after a restart');

  // from the page: progress, points, and an end by who has begun it
  await third.page.locator('#measure').click();
  await third.page.locator('#cancel').waitFor();
  await until(async () => /^[1-9]\d* of \d+ steps/.test(await third.page.locator('#tradeoff-progress').innerText()), 'progress');
  await third.page.locator('#cancel').click();
  await third.page.locator('#measure').waitFor();
  await until(async () => (await facts(third.page)).here === 0, 'what was cancelled is gone, what ships is there');
  assert.ok((await facts(third.page)).ring);
  await third.context.close();
  await own.stop();
  rmSync(data, { recursive: true, force: true });
});

test('in German, dark, on a phone: by thumb, without a word of English', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}?theme=dark&lang=de#tradeoff=synchronisation`, {
    width: 390,
    height: 844,
    hasTouch: true,
    scripts: [hearCanvases],
    wait: false,
  });
  await reads(sentence(page), /In beiden Grenzen ist am billigsten/);
  await opened(page);
  const box = /** @type {any} */ (await handle(page, 'budget').boundingBox());
  assert.ok(box.width >= 44 && box.height >= 44, 'a thumb takes it');
  assert.ok(box.y + box.height < 844, 'it is on the screen');
  await until(async () => (await facts(page)).runs[0]?.state === 'running', 'it runs');
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 390);
  assert.deepEqual(await axe(page), []);
  await shot(page, 'phone-dark');
  const given = new Set(['laglab', 'lockstep']);
  assert.deepEqual(
    (await textsOn(page)).map((text) => englishIn(text, given)).filter((why) => why !== ''),
    [],
  );
  assert.deepEqual(complaints, []);
  await close();
});

test('experiments: charts are drawn again when the page becomes narrow, and no button lies on them', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}#experiments`, { wait: false, width: 820, height: 1180 });
  const chart = page.locator('#chart-0');
  await chart.waitFor();
  await page.setViewportSize({ width: 390, height: 844 });
  const sizes = () => chart.evaluate((/** @type {HTMLCanvasElement} */ canvas) => [canvas.width, canvas.clientWidth * devicePixelRatio]);
  await until(async () => {
    const [drawn, shown] = await sizes();
    return shown < 390 * 2 && Math.abs(drawn - shown) < 2;
  }, 'the chart has the pixels of its box');
  const clear = await page.locator('.chart-panel').evaluateAll((panels) =>
    panels.every((panel) => {
      const buttons = panel.querySelector('take-away')?.getBoundingClientRect(),
        drawn = panel.querySelector('canvas')?.getBoundingClientRect();
      return buttons && drawn && buttons.bottom <= drawn.top + 1;
    }),
  );
  assert.ok(clear);
  assert.deepEqual(complaints, []);
  await close();
});

test('labs lead to their own families', async () => {
  const { page, close } = await visit(browser, `${daemon.url}?scenario=motion/pendulum`);
  for (const [scenario, family] of [
    ['motion/pendulum', 'integrators'],
    ['fluid/cavity', 'pressure_solvers'],
    ['fluid/sea', 'oceans'],
    ['fluid/dam_break', 'particles'],
    ['race', 'synchronisation'],
    ['behind_cover', 'lag_compensation'],
    ['crates', 'snapshots'],
  ]) {
    await page.goto(`${daemon.url}?scenario=${scenario}`);
    await page.locator('#to-tradeoff').waitFor();
    await page.waitForFunction(
      (id) => globalThis.laglab?.().params && new URLSearchParams(location.search).get('scenario') === id,
      scenario,
    );
    await until(async () => (await page.locator('#to-tradeoff').count()) === 1, 'a button');
    await page.locator('#to-tradeoff').click();
    await until(async () => (await hash(page)).startsWith(`#tradeoff=${family}`), `${scenario} leads to ${family}: ${await hash(page)}`);
  }
  await close();
});
