// The first page: joining a class by its code; cards that move.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { api, axe, launch, settles, visit } from './lib.mjs';

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

/** The first page, with its cards. @param {string} [at] @param {any} [wish] */
async function door(at = '', wish = {}) {
  const visited = await visit(browser, daemon.url + at, { ...wish, wait: false });
  await visited.page.locator('.card').first().waitFor();
  return visited;
}

test('the code of a class, typed on the first page in letters of either case, joins it', async () => {
  const { code } = (await api(daemon.url, 'classes', {})).body;
  const { page, complaints, close } = await door();
  await page.getByLabel('Code of a class').fill(` ${code.toLowerCase()} `);
  await page.getByRole('button', { name: 'Join', exact: true }).click();
  await page.getByRole('heading', { name: `Class ${code}` }).waitFor();
  assert.equal(new URL(page.url()).hash, `#class=${code}`);
  await page.getByRole('button', { name: 'Watch' }).click();
  await page.locator('[data-class="member"]').waitFor();
  assert.deepEqual(complaints, []);
  await close();
});

test('a code that no class has is named, and can be typed again; German has its words', async () => {
  const { page, close } = await door('#questions&lang=de', { width: 390, height: 844 });
  await page.getByLabel('Code einer Klasse').fill('QQQQ');
  await page.keyboard.press('Enter');
  await page.locator('#class-answer', { hasText: 'No class has the code QQQQ' }).waitFor();
  await settles(() => page.locator('#class-code').isVisible(), true);
  await page.goBack();
  await page.locator('.card').first().waitFor();
  assert.deepEqual(await axe(page), []);
  await close();
});
