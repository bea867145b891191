// Slow motion by itself where a thing takes a tenth of a second; what fast bodies sweep.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { axe, button, frameOf, launch, settles, until, visit } from './lib.mjs';

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

const speedOf = async (page) => Number((await frameOf(page)).session.speed.toPrecision(6));

test('three bullets fly ten times slower, the page says so, and ends it after the walls; again after Restart', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}?scenario=rigid/three_bullets&set=duration_s:4`);
  await until(async () => (await speedOf(page)) === 1, 'the normal speed, behind the walls');
  await settles(() => page.locator('#slower').isVisible(), false);
  await page.evaluate(() => {
    globalThis.seen = [];
    const note = () => {
      const frame = globalThis.laglab().frame;
      globalThis.seen.push([frame.time_s, frame.session.speed, document.getElementById('slower')?.textContent]);
      requestAnimationFrame(note);
    };
    note();
  });
  await button(page, 'Restart').click();
  await until(async () => (await page.evaluate(() => globalThis.seen.filter(([t, s]) => t < 0.14 && s < 0.11).length)) > 10, 'slow again');
  await page.locator('#slower', { hasText: '10 times slower' }).waitFor();
  assert.deepEqual(await axe(page), []);
  await until(async () => (await frameOf(page)).time_s > 0.5 && (await speedOf(page)) === 1, 'ended');
  assert.deepEqual(complaints, []);
  await close();
});

test('a speed that a person sets stays', async () => {
  const { page, close } = await visit(browser, `${daemon.url}?scenario=rigid/three_bullets&set=duration_s:4`);
  await button(page, 'Restart').click();
  await until(async () => (await speedOf(page)) === 0.1, 'slow');
  await page.getByLabel('Speed', { exact: true }).selectOption('0.5');
  await until(async () => (await frameOf(page)).time_s > 0.6, 'behind the walls');
  assert.equal(await speedOf(page), 0.5);
  await close();
});

test('the places of fast bodies are drawn, and can be switched off', async () => {
  const { page, close } = await visit(browser, `${daemon.url}?scenario=rigid/three_bullets`);
  const box = page.locator('[data-overlay="paths"]');
  await settles(() => box.isChecked(), true);
  await until(async () => (await frameOf(page)).time_s >= 0.5, 'the end');
  const picture = () => page.evaluate(() => /** @type {HTMLCanvasElement} */ (document.getElementById('world1')).toDataURL());
  const swept = await picture();
  await box.click();
  await until(async () => (await picture()) !== swept, 'without them');
  await page.goto(`${daemon.url}?scenario=rigid/pyramid`);
  await page.locator('[data-overlay="paths"]').waitFor();
  await until(async () => !(await page.locator('[data-overlay="paths"]').isChecked()), 'off where nothing is passed');
  await close();
});

test('the lab of rigid bodies opens on a stack that falls next to one that stands, moving', async () => {
  const { page, close } = await visit(browser, `${daemon.url}#collide`);
  await until(async () => (await frameOf(page)).time_s > 2.5, 'two seconds');
  const { worlds } = await frameOf(page);
  assert.ok(worlds[0].tilt > 0.3 || worlds[0].drift > 1, JSON.stringify(worlds[0]));
  assert.ok(worlds[1].drift < 0.05, JSON.stringify(worlds[1]));
  await close();
});
