// On an address of a network, over plain http, where a browser gives no secure context: a network of the test's own.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { openLan } from '../lib/lan.mjs';
import { control, dialogOf, frameOf, launch, paramsOf, sessionOf, until, visit } from './lib.mjs';

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;

/** @type {ReturnType<typeof openLan>} */ let lan;
before(async () => {
  lan = openLan();
  [daemon, browser] = await Promise.all([startDaemon(lan), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
  lan?.close();
});

test('the page works in full on a network address without a secure context', async () => {
  assert.ok(daemon.url.startsWith(`http://${lan.net}.2:`), daemon.url);
  const { page, requests, complaints, close } = await visit(browser, `${daemon.url}#race`);
  assert.equal(await page.evaluate(() => isSecureContext), false);
  assert.equal(await page.evaluate(() => 'clipboard' in navigator && navigator.clipboard !== undefined), false);
  await until(async () => (await frameOf(page)).tick > 60, 'it moves');
  await control(page, 'players.0.lag_ms', 'number').fill('300');
  await control(page, 'players.0.lag_ms', 'number').press('Enter');
  await until(async () => (await paramsOf(page)).players[0].lag_ms === 300, 'a change');
  await page.locator('.view[data-drive="0"]').focus();
  await page.keyboard.press('ArrowRight');
  await until(async () => (await paramsOf(page)).players[0].control === 'person', 'driving');
  await page.getByRole('button', { name: 'Share' }).click();
  await (await dialogOf(page)).locator('input').nth(1).waitFor();
  const links = await page.locator('dialog input').evaluateAll((all) => all.map((/** @type {any} */ input) => input.value));
  assert.ok(
    links.every((text) => text.startsWith(daemon.url)),
    links.join(),
  );
  assert.equal(await page.getByText('works on this computer only').count(), 0);
  const watcher = await visit(browser, links[1]);
  assert.equal((await sessionOf(watcher.page)).owner, false);
  await watcher.page.getByRole('button', { name: 'Make my copy' }).click();
  await until(async () => (await sessionOf(watcher.page)).owner, 'a copy');
  assert.ok(requests.every((request) => request.url().startsWith(daemon.url) || request.url().startsWith('ws')));
  assert.deepEqual(complaints, []);
  assert.deepEqual(watcher.complaints, []);
  await watcher.close();
  await close();
});
