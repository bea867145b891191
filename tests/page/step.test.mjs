// The step lab: methods side by side, live, with the numbers of the paper.
import assert from 'node:assert/strict';
import { after, before } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { axe, launch, paramsOf, reads, refreshes, runOn, settles, SIZES, tickOf, until, visit } from './lib.mjs';
import { sweep, test } from './tiers.mjs';

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

const ended = (page) => page.waitForFunction(() => document.getElementById('chip')?.textContent?.includes('Ended'));
const cell = (page, row, name) => page.locator(`[data-motion="${row}/${name}"]`).textContent();

test('/#step opens the lab, and it moves', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}#step`);
  await page.waitForSelector('#motion');
  assert.equal((await paramsOf(page)).problem, 'kepler');
  await settles(() => page.locator('.lab[aria-current="page"]').textContent(), 'Step');
  assert.match(await page.locator('.see').innerText(), /^Same orbit, same step: /);
  const errorOf = async (row) => Number(await cell(page, row, 'error'));
  await page.waitForFunction(() => globalThis.laglab().frame?.time_s > 8);
  await until(async () => (await errorOf(1)) > 3 * (await errorOf(2)), 'explicit Euler is off, next to a method that is not');
  await page.locator('[data-path="methods.0.method"]').selectOption('rk4');
  await page.locator('.see').waitFor({ state: 'detached' });
  assert.deepEqual(complaints, []);
  await close();
});

test('with reduced motion the lab waits for Play', async () => {
  const { page, close } = await visit(browser, `${daemon.url}#step`, { reducedMotion: 'reduce' });
  await page.locator('.see').waitFor();
  assert.equal(await tickOf(page), 0);
  await close();
});

test('Figure 4 shows the numbers of the paper, and what the listing really is', async () => {
  const { page, close } = await visit(browser, `${daemon.url}?scenario=paper/fig04`);
  await ended(page);
  await page.waitForFunction(() => document.querySelector('[data-motion="4/value"]')?.textContent !== '–');
  await settles(async () => {
    const values = [];
    for (let row = 1; row <= 8; row++) values.push(Number(await cell(page, row, 'value')));
    return values.map((v) => Number(v.toFixed(4)));
  }, [52.5, 49.5, 46.5, 45.5855, 37.5, 40.5, 43.5, 44.5945]);
  await settles(() => cell(page, 4, 't'), '3.003');
  await reads(page.locator('.errata'), /semi-implicit Euler/);
  await close();
});

test('each method shows its order on the problem, and the error of its worst component', async () => {
  const { page, close } = await visit(browser, `${daemon.url}?scenario=motion/lorentz`);
  await page.waitForFunction(() => Number(document.querySelector('[data-motion="1/weighted"]')?.textContent) > 0);
  await reads(() => page.locator('[data-order="0"]').textContent(), /^Of order \d on this problem\.$/);
  await page.locator('[data-path="methods.0.method"]').selectOption('yoshida4');
  await page.waitForFunction(() => document.querySelector('[data-order="0"]')?.textContent?.includes('order 1 on'));
  await page.locator('[data-path="methods.0.method"]').selectOption('rk4');
  await page.waitForFunction(() => document.querySelector('[data-order="0"]')?.textContent?.includes('order 4 on'));
  await close();
});

test('the time stepping of a method changes live, and the scenarios for it open', async () => {
  const { page, close } = await visit(browser, `${daemon.url}?scenario=motion/accumulator`);
  await page.waitForSelector('[data-path="methods.0.steps"]', { state: 'attached' });
  await page.locator('.method details summary').first().click();
  await settles(() => page.locator('[data-path="methods.0.steps"]').inputValue(), 'frame');
  await page.locator('[data-path="methods.0.steps"]').selectOption('accumulator');
  await page.waitForFunction(() => globalThis.laglab().params.methods[0].steps === 'accumulator');
  await page.locator('[data-path="reverse"]').click();
  await page.waitForFunction(() => /backwards/.test(document.querySelector('.note')?.textContent ?? ''));
  assert.equal((await paramsOf(page)).reverse, false);
  await page.locator('#scenario').click();
  for (const name of ['variable_steps', 'accumulator', 'clock_drift', 'far_from_origin', 'backwards']) {
    await settles(() => page.locator(`[data-scenario="motion/${name}"]`).count(), 1, name);
  }
  await close();
});

test('a step, a method and a parameter change live', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}?scenario=motion/pendulum`);
  await page.waitForSelector('[data-path="methods.0.dt_s"]');
  await page.getByRole('button', { name: '½ step of method 1' }).click();
  await page.waitForFunction(() => globalThis.laglab().params.methods[0].dt_s === 0.01);
  await page.locator('[data-path="methods.1.method"]').selectOption('dopri5');
  await page.waitForSelector('[data-path="methods.1.tolerance"]');
  assert.equal((await paramsOf(page)).methods[1].method, 'dopri5');
  await page.locator('[data-path="params.theta0"]').fill('1');
  await page.locator('[data-path="params.theta0"]').blur();
  await page.waitForFunction(() => globalThis.laglab().params.params.theta0 === 1);
  await page.locator('[data-path="params.theta0"]').fill('9');
  await page.locator('[data-path="params.theta0"]').blur();
  await page.waitForFunction(() => /3\.14/.test(document.querySelector('.note')?.textContent ?? ''));
  assert.equal((await paramsOf(page)).params.theta0, 1);
  assert.deepEqual(complaints, []);
  await close();
});

test('another problem creates a new session', async () => {
  const { page, close } = await visit(browser, `${daemon.url}#step`);
  await page.waitForSelector('#problem');
  await page.locator('#problem').selectOption('kepler');
  await page.waitForFunction(() => globalThis.laglab().params?.problem === 'kepler');
  await page.waitForSelector('[data-path="params.e"]');
  await close();
});

/** What is measured of each method: steps and errors. @param {import('playwright-core').Page} page
 * @returns {Promise<Record<string, any[]>>} */
const measured = (page) => page.evaluate(() => globalThis.laglab().refinement);
/** The order that the two finest steps of a series have. @param {{dt: number, error: number}[]} list */
function orderOf(list) {
  const [fine, coarse] = [...list].sort((a, b) => a.dt - b.dt);
  return Math.log(coarse.error / fine.error) / Math.log(coarse.dt / fine.dt);
}

test('the first scene shows measured curves without a press, of the order that theory has; a press adds the finest steps', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}#step`);
  const both = await until(async () => {
    const now = await measured(page);
    return now['0']?.length >= 4 && now['1']?.length >= 4 && now;
  }, 'both are measured');
  const before = await page.locator('#plot-work').evaluate((c) => /** @type {HTMLCanvasElement} */ (c).toDataURL());
  assert.ok(
    both['0'].every(({ error }, i) => error > 3 * (both['1'].find(({ dt }) => dt === both['0'][i].dt)?.error ?? 0)),
    'one fails, one holds',
  );
  await page.getByRole('button', { name: /^Measure / }).click();
  const all = await until(async () => {
    const now = await measured(page);
    return now['0'].length > 8 && now['1'].length > 12 && now;
  }, 'all steps are measured');
  assert.ok(Math.abs(orderOf(all['1']) - 1) < 0.05, `order ${orderOf(all['1'])}`);
  await page.waitForFunction((was) => /** @type {HTMLCanvasElement} */ (document.getElementById('plot-work')).toDataURL() !== was, before);
  assert.deepEqual(complaints, []);
  await close();
});

test('a method or a parameter that changes drops its curve and gets its own; a step does not; only what is seen is measured', async () => {
  const { page, requests, complaints, close } = await visit(browser, `${daemon.url}?scenario=motion/spring`, { width: 390, height: 844 });
  await runOn(page, 1);
  const asked = () => requests.filter((one) => one.method() === 'DELETE').length;
  assert.equal(asked(), 0, 'the plots are not in view');
  await page.setViewportSize({ width: 1366, height: 768 });
  await page.locator('#plot-step').scrollIntoViewIfNeeded();
  const before = await until(async () => {
    const now = await measured(page);
    return now['0'] && now['4'] && now;
  }, 'five methods are measured');
  const count = asked();
  await page.locator('[data-path="methods.0.dt_s"]').fill('0.05');
  await page.locator('[data-path="methods.0.dt_s"]').blur();
  await page.waitForFunction(() => globalThis.laglab().params.methods[0].dt_s === 0.05);
  await page.locator('[data-path="methods.1.method"]').selectOption('rk4');
  const after = await until(async () => {
    const now = await measured(page);
    return now['1'] && JSON.stringify(now['1']) !== JSON.stringify(before['1']) && now;
  }, 'the other method is measured');
  assert.deepEqual(after['0'], before['0']);
  await until(async () => asked() === count + 1, 'one more session is enough');
  assert.deepEqual(complaints, []);
  await close();
});

test('a method that blows up is shown as diverged', async () => {
  const { page, close } = await visit(browser, `${daemon.url}?scenario=motion/stiff_spring`);
  await page.waitForFunction(() => document.querySelector('[data-motion="1/error"]')?.textContent === 'diverged');
  assert.notEqual(await cell(page, 4, 'error'), 'diverged');
  await close();
});

for (const { name, width, height, query } of SIZES) {
  sweep(width < 400)(`without a complaint of axe at ${name}`, async () => {
    const { page, close } = await visit(browser, `${daemon.url}${query}${query ? '&' : '?'}scenario=motion/orbit`, { width, height });
    await page.waitForSelector('#motion');
    await refreshes(page);
    assert.deepEqual(await axe(page), []);
    const box = await page.locator('#motion').boundingBox();
    assert.ok(box && box.height > 80 && box.width > 200, JSON.stringify(box));
    await close();
  });
}
