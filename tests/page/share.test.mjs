// One session, several pages: who may change it, and where its key is.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import {
  api,
  control,
  dialogOf,
  frameOf,
  launch,
  paramsOf,
  reads,
  refreshes,
  runOn,
  sessionOf,
  settles,
  shown,
  until,
  visit,
} from './lib.mjs';

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

const keyOf = (page) => page.evaluate(() => JSON.parse(sessionStorage.getItem('laglab')).keys);

test('a reader sees the same session with every control disabled, and why', async () => {
  const owner = await visit(browser, `${daemon.url}#race`);
  const { id } = await sessionOf(owner.page);
  const reader = await visit(browser, `${daemon.url}#s=${id}`);
  const { page } = reader;
  assert.deepEqual(await sessionOf(page), { id, owner: false });
  const changing = page.locator('#app fieldset :is(input, select, button)');
  await changing.nth(25).waitFor({ state: 'attached' });
  const count = await changing.count();
  for (let i = 0; i < count; i++)
    await settles(() => changing.nth(i).isDisabled(), true, await changing.nth(i).evaluate((e) => e.outerHTML));
  await reads(() => page.locator('fieldset.panel').first().getAttribute('title'), /Read-only/);
  await reads(page.locator('#reader'), /Read-only/);
  const before = await paramsOf(page);
  await page.locator('.view[data-drive="0"]').focus();
  for (const key of ['ArrowRight', 'Space', '1', 'r']) await page.keyboard.press(key);
  await refreshes(page);
  assert.deepEqual(await paramsOf(page), before);
  await control(owner.page, 'players.0.lag_ms', 'number').fill('456');
  await control(owner.page, 'players.0.lag_ms', 'number').press('Enter');
  await until(async () => (await control(page, 'players.0.lag_ms', 'number').inputValue()) === '456', 'the reader follows');
  assert.deepEqual(reader.complaints, []);
  await reader.close();
  await owner.close();
});

test('"Make my copy" creates a session at the same time', async () => {
  const owner = await visit(browser, `${daemon.url}?scenario=race&set=players.0.lag_ms:111&seed=9`);
  const { id } = await sessionOf(owner.page);
  const reader = await visit(browser, `${daemon.url}#s=${id}`);
  await runOn(reader.page, 0.5);
  const tick = (await frameOf(reader.page)).tick;
  await reader.page.getByRole('button', { name: 'Make my copy' }).click();
  await until(async () => (await sessionOf(reader.page)).owner, 'an owner');
  const copy = await sessionOf(reader.page);
  assert.notEqual(copy.id, id);
  await until(async () => (await frameOf(reader.page)) !== null, 'a frame');
  assert.ok((await frameOf(reader.page)).tick >= tick);
  assert.equal((await api(daemon.url, `sessions/${copy.id}`)).body.seed, 9);
  await control(reader.page, 'players.0.lag_ms', 'number').fill('222');
  await control(reader.page, 'players.0.lag_ms', 'number').press('Enter');
  await until(async () => (await paramsOf(reader.page)).players[0].lag_ms === 222, 'the copy changes');
  assert.equal((await paramsOf(owner.page)).players[0].lag_ms, 111);
  await reader.page.reload();
  await shown(reader.page);
  assert.deepEqual(await sessionOf(reader.page), { id: copy.id, owner: true });
  await reader.close();
  await owner.close();
});

test('a key in the fragment is taken and leaves the address bar; it is never sent in an address', async () => {
  const made = (await api(daemon.url, 'sessions', { scenario: 'race' })).body;
  const { page, requests, close } = await visit(browser, `${daemon.url}#s=${made.id}&k=${made.owner_key}`);
  assert.deepEqual(await sessionOf(page), { id: made.id, owner: true });
  assert.ok(page.url().endsWith(`#s=${made.id}`), page.url());
  assert.equal(
    await page.evaluate((key) => document.documentElement.outerHTML.includes(key) || location.href.includes(key), made.owner_key),
    false,
  );
  assert.ok(requests.every((request) => !request.url().includes(made.owner_key)));
  await control(page, 'players.0.prediction').setChecked(false);
  await until(async () => (await paramsOf(page)).players[0].prediction === false, 'the key works');
  await close();
});

test('what is shared has no key in it', async () => {
  const { page, close } = await visit(browser, `${daemon.url}#race`);
  const keys = Object.values(await keyOf(page));
  assert.equal(keys.length, 1);
  await page.getByRole('button', { name: 'Share' }).click();
  await (await dialogOf(page)).locator('input').nth(1).waitFor();
  const links = await page.locator('dialog input').evaluateAll((all) => all.map((/** @type {any} */ input) => input.value));
  assert.equal(links.length, 2);
  assert.ok(links.every((text) => !text.includes(keys[0])));
  const watcher = await visit(browser, links[1]);
  assert.equal((await sessionOf(watcher.page)).owner, false);
  await watcher.close();
  const same = await visit(browser, links[0]);
  assert.notEqual((await sessionOf(same.page)).id, (await sessionOf(page)).id);
  await same.close();
  await close();
});

test('a session that no longer exists is reported and replaced', async () => {
  const { page, close } = await visit(browser, `${daemon.url}#s=${'0'.repeat(32)}`);
  await reads(page.locator('.note'), /expired/);
  assert.equal((await sessionOf(page)).owner, true);
  assert.equal(new URL(page.url()).hash, '');
  await close();
});

const LAG = 'players.0.lag_ms';
const setLag = async (page, value) => {
  await control(page, LAG, 'number').fill(String(value));
  await control(page, LAG, 'number').press('Enter');
  await until(async () => (await paramsOf(page)).players[0].lag_ms === value, 'changed');
};

test('parameters that were read before a change do not undo it, though they come after', async () => {
  const { page, close } = await visit(browser, 'about:blank', { wait: false });
  /** @type {(value?: unknown) => void} */ let release = () => {};
  const released = new Promise((resolve) => {
    release = resolve;
  });
  let held = 0;
  await page.route(/\/api\/v1\/sessions\/\w+$/, async (route) => {
    if (route.request().method() !== 'GET' || held > 0) return route.continue();
    const answer = await route.fetch();
    held++;
    await released;
    return route.fulfill({ response: answer });
  });
  await page.goto(`${daemon.url}?scenario=race&set=${LAG}:111`);
  await shown(page);
  const { id } = await sessionOf(page);
  await api(daemon.url, `sessions/${id}/params`, { [LAG]: 133 }, (await keyOf(page))[id], 'PATCH');
  await until(async () => held === 1, 'read after the change of another client');
  await setLag(page, 222);
  release();
  await refreshes(page);
  assert.equal((await paramsOf(page)).players[0].lag_ms, 222);
  await close();
});

test('a hello that was written before a change does not undo it', async () => {
  const made = (await api(daemon.url, 'sessions', { scenario: 'race', set: { [LAG]: 111 } })).body;
  const { page, close } = await visit(browser, 'about:blank', { wait: false });
  let streams = 0;
  /** @type {(() => void)[]} */ const late = [];
  await page.routeWebSocket(/\/stream$/, (socket) => {
    const second = streams++ > 0,
      server = socket.connectToServer();
    server.onMessage((message) => {
      if (second && streams < 9) late.push(() => socket.send(message));
      else socket.send(message);
    });
  });
  await page.goto(`${daemon.url}#s=${made.id}`);
  await shown(page);
  await page.getByRole('button', { name: 'Make my copy' }).click();
  await until(async () => late.length > 1, 'the hello and a frame wait');
  await setLag(page, 222);
  streams = 9; /* what follows is not held back */
  late.forEach((send) => send());
  await until(async () => (await frameOf(page)) !== null, 'a frame');
  await until(async () => (await paramsOf(page)).players[0].lag_ms === 222, 'the change holds');
  await close();
});

test('a visit finds nothing that the one before has left', async () => {
  const first = await visit(browser, `${daemon.url}#race`);
  const { id } = await sessionOf(first.page);
  await first.page.evaluate(() => {
    localStorage.setItem('left', 'yes');
    sessionStorage.setItem('left', 'yes');
  });
  await first.close();
  const next = await visit(browser, `${daemon.url}#race`);
  const { left, session } = await next.page.evaluate(() => ({
    left: [localStorage.getItem('left'), sessionStorage.getItem('left')],
    session: globalThis.laglab().session,
  }));
  assert.deepEqual(left, [null, null]);
  assert.ok(session.owner && session.id !== id, 'a session of its own');
  assert.deepEqual(next.complaints, []);
  await next.close();
});
