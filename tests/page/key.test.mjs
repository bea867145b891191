// A daemon with a class key: the page asks for it once, when a person creates something.
import assert from 'node:assert/strict';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { axe, launch, refreshes, shown, SIZES, visit } from './lib.mjs';

const KEY = 'seven-otters-in-a-row';
const folder = mkdtempSync(path.join(tmpdir(), 'laglab-key-'));
/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  writeFileSync(path.join(folder, 'key'), `${KEY}\n`, { mode: 0o600 });
  [daemon, browser] = await Promise.all([startDaemon({ args: ['--class-key-file', path.join(folder, 'key')] }), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
  rmSync(folder, { recursive: true });
});

const give = async (/** @type {import('playwright-core').Page} */ page, /** @type {string} */ key) => {
  await page.locator('#class-key').fill(key);
  await page.keyboard.press('Enter');
};

for (const size of SIZES) {
  test(`the page asks for the key, reports a wrong one, and keeps the right one: ${size.name}`, async () => {
    const { page, complaints, close } = await visit(browser, `${daemon.url}${size.query}#race`, { ...size, wait: false });
    const dialog = page.getByRole('dialog', { name: 'Class key' });
    await dialog.waitFor();
    assert.equal(await page.locator('#class-key').evaluate((e) => e === document.activeElement), true, 'it has the focus');
    assert.deepEqual(await axe(page), []);
    const box = await dialog.boundingBox();
    assert.ok(box && box.x >= 0 && box.y >= 0 && box.x + box.width <= size.width && box.y + box.height <= size.height, JSON.stringify(box));
    await give(page, 'eight-otters');
    await page.getByText('Wrong key').waitFor();
    assert.deepEqual(await axe(page), []);
    await give(page, ` ${KEY} `);
    await shown(page);
    assert.equal(await page.locator('dialog[open]').count(), 0);
    assert.ok(!page.url().includes(KEY));
    await page.evaluate(() => sessionStorage.clear());
    await page.goto(`${daemon.url}${size.query}${size.query ? '&' : '?'}scenario=cannon`);
    await shown(page);
    assert.equal(await page.locator('dialog[open]').count(), 0, 'it is not asked for again');
    assert.deepEqual(
      complaints.filter((text) => !/status of 40[13]/.test(text)),
      [],
    );
    await close();
  });
}

test('a person who gives no key gets a message and is not asked again; a link needs no key', async () => {
  const other = await visit(browser, `${daemon.url}#race`, { wait: false });
  await other.page.getByRole('dialog', { name: 'Class key' }).waitFor();
  await give(other.page, KEY);
  await shown(other.page);
  const id = await other.page.evaluate(() => globalThis.laglab().session.id);
  const { page, requests, close } = await visit(browser, `${daemon.url}#race`, { wait: false });
  await page.getByRole('dialog', { name: 'Class key' }).waitFor();
  await page.getByRole('button', { name: 'Cancel' }).click();
  await page.getByLabel('Note').getByText('creating one needs a class key').waitFor();
  const asked = requests.length;
  await page.evaluate(() => new Promise((done) => setTimeout(done, 2100))); /* other failures are tried again after two seconds at most */
  await refreshes(page);
  assert.deepEqual(
    requests.slice(asked).filter((one) => one.method() === 'POST'),
    [],
  );
  assert.equal(await page.locator('dialog[open]').count(), 0);
  await close();
  const watcher = await visit(browser, `${daemon.url}#s=${id}`);
  assert.equal(await watcher.page.locator('dialog[open]').count(), 0);
  await watcher.close();
  await other.close();
});
