// On an address of a network, over plain http, where a browser gives no secure context: a network of the test's own.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { after, before, test } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { control, frameOf, launch, paramsOf, sessionOf, until, visit } from './lib.mjs';

const NAME = `laglab-${process.pid}`;
const OUTER = `ll${process.pid}a`.slice(0, 15),
  INNER = `ll${process.pid}b`.slice(0, 15);
const NET = `10.${200 + (process.pid % 50)}.${(process.pid >> 6) % 250}`;

const run = (/** @type {string[]} */ [command, ...words]) => execFileSync(command, words, { stdio: ['ignore', 'pipe', 'pipe'] });
const ip = (/** @type {string[]} */ ...words) => run(['ip', ...words]);

/* Not by `ip -n` and `ip netns exec`: these remount `/`, which in a chroot is not a mount point. */
const INSIDE = ['nsenter', `--net=/run/netns/${NAME}`];
const ipInside = (/** @type {string[]} */ ...words) => run([...INSIDE, 'ip', ...words]);

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;

before(async () => {
  ip('netns', 'add', NAME);
  ip('link', 'add', OUTER, 'type', 'veth', 'peer', 'name', INNER, 'netns', NAME);
  ip('addr', 'add', `${NET}.1/24`, 'dev', OUTER);
  ip('link', 'set', OUTER, 'addrgenmode', 'none'); /* an address that comes later would announce another network to the browser */
  ip('link', 'set', OUTER, 'up');
  ipInside('addr', 'add', `${NET}.2/24`, 'dev', INNER);
  ipInside('link', 'set', INNER, 'addrgenmode', 'none');
  ipInside('link', 'set', INNER, 'up');
  ipInside('link', 'set', 'lo', 'up');
  [daemon, browser] = await Promise.all([startDaemon({ listen: `${NET}.2:0`, before: INSIDE }), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
  try {
    ip('netns', 'del', NAME); /* takes the pair with it */
  } catch {
    /* it was never made */
  }
});

test('the page works in full on a network address without a secure context', async () => {
  assert.ok(daemon.url.startsWith(`http://${NET}.2:`), daemon.url);
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
  await page.locator('dialog input').nth(1).waitFor(); /* dialogs are read when the first one opens */
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
