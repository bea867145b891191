// The connection: lost, restored; and a session that no longer exists.
import assert from 'node:assert/strict';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { control, frameOf, launch, paramsOf, reads, refreshes, sessionOf, settles, shown, until, visit } from './lib.mjs';

/** @type {import('playwright-core').Browser} */ let browser;
/** @type {string} */ let data;
before(async () => {
  browser = await launch();
  data = mkdtempSync(path.join(tmpdir(), 'laglab-page-'));
});
after(async () => {
  await browser?.close();
  rmSync(data, { recursive: true, force: true });
});

const chip = (page) => page.locator('#chip').innerText();
/** The browser itself reports the failed attempts; nothing else may complain. */
const own = (complaints) =>
  complaints.filter((text) => !/ERR_CONNECTION_REFUSED|WebSocket|ERR_EMPTY_RESPONSE|ERR_CONNECTION_RESET|404/.test(text));

test('the daemon dies and comes back with its data: the same session goes on', async () => {
  let daemon = await startDaemon({ data });
  const { page, complaints, close } = await visit(browser, `${daemon.url}#race`);
  await whole(page);
  await control(page, 'players.0.lag_ms', 'number').fill('234');
  await control(page, 'players.0.lag_ms', 'number').press('Enter');
  await until(async () => (await paramsOf(page)).players[0].lag_ms === 234, 'changed');
  const { id } = await sessionOf(page);
  const listen = `127.0.0.1:${daemon.port}`;
  await page.evaluate(() => {
    const own = setTimeout;
    globalThis.delays = [];
    globalThis.setTimeout = /** @type {any} */ (
      (/** @type {any} */ run, /** @type {number} */ ms, /** @type {any[]} */ ...more) => {
        if (/\.retry\(\)/.test(String(run))) globalThis.delays.push(ms); // the connection's
        return own(run, ms, ...more);
      }
    );
  });
  await daemon.kill();
  await until(async () => /Connection lost – retrying \(\d+\)/.test(await chip(page)), 'it says so');
  await settles(() => control(page, 'players.0.lag_ms', 'number').isDisabled(), true);
  await reads(() => page.locator('fieldset.panel').first().getAttribute('title'), /Connection lost/);
  await settles(() => page.getByRole('button', { name: 'Reset' }).isDisabled(), true);
  await until(async () => /retrying \(([5-9]|\d\d)\)/.test(await chip(page)), 'it has tried again and again');
  const delays = await page.evaluate(() => globalThis.delays);
  for (const [i, ms] of delays.entries()) {
    const most = Math.min(2000, 200 * 2 ** i);
    assert.ok(ms >= most / 2 && ms <= most, `${delays.join()} ms between attempts`);
  }
  assert.ok(delays.length >= 5);
  daemon = await startDaemon({ data, listen });
  await until(async () => (await page.evaluate(() => globalThis.laglab().connection.state)) === 'open', 'connected again');
  await until(async () => /Reconnected/.test(await page.locator('.note').innerText()), 'it says so');
  assert.equal((await sessionOf(page)).id, id);
  assert.equal((await paramsOf(page)).players[0].lag_ms, 234);
  await settles(() => control(page, 'players.0.lag_ms', 'number').isEnabled(), true);
  await control(page, 'players.0.lag_ms', 'number').fill('345');
  await control(page, 'players.0.lag_ms', 'number').press('Enter');
  await until(async () => (await paramsOf(page)).players[0].lag_ms === 345, 'the key still holds');
  if (/Paused/.test(await chip(page))) await page.getByRole('button', { name: 'Play', exact: true }).click();
  const { tick } = await frameOf(page);
  await until(async () => (await frameOf(page)).tick > tick + 5, 'it runs on');
  assert.deepEqual(own(complaints), []);
  await close();
  await daemon.stop();
});

test('the daemon comes back without its data: the session is created again from the address, and that is said', async () => {
  let daemon = await startDaemon();
  const { page, complaints, close } = await visit(browser, `${daemon.url}?scenario=race&set=players.1.lag_ms:123`);
  await whole(page);
  const { id } = await sessionOf(page);
  const listen = `127.0.0.1:${daemon.port}`;
  await daemon.stop();
  await until(async () => /Connection lost/.test(await chip(page)), 'it says so');
  daemon = await startDaemon({ listen });
  await until(async () => {
    const s = await sessionOf(page);
    return s.id !== id && (await frameOf(page))?.tick > 3;
  }, 'a new session runs');
  await reads(page.locator('.note'), /Session expired . created again from the address/);
  assert.equal((await paramsOf(page)).players[1].lag_ms, 123);
  assert.deepEqual(own(complaints), []);
  await close();
  await daemon.stop();
});

/** What is read after the first frame is there: the dialogs, and of a netgame the curves. */
const whole = (page) =>
  page.waitForFunction(
    () => document.querySelector('dialog') && document.querySelector(globalThis.laglab().params.players ? '.plot canvas' : 'main'),
  );

for (const [what, pattern, query] of [
  ['what follows the first frame', '**/js/more-*.js', '#race'],
  ['a lab', '**/js/rigid-*.js', '?scenario=rigid/column'],
]) {
  test(`${what} that could not be read is read again`, async (t) => {
    const daemon = await startDaemon();
    const { page, close } = await visit(browser, 'about:blank', { wait: false });
    t.after(async () => {
      await close();
      await daemon.stop();
    });
    let asked = 0;
    await page.route(pattern, (route) => (asked++ === 0 ? route.abort() : route.continue()));
    await page.goto(daemon.url + query);
    await until(async () => asked >= 2, 'it is asked for again');
    await shown(page);
    await whole(page);
  });
}

test('a page that is loaded again shows the session it had', async () => {
  const daemon = await startDaemon();
  const { page, close } = await visit(browser, `${daemon.url}#race`);
  const { id } = await sessionOf(page);
  await control(page, 'players.0.lag_ms', 'number').fill('77');
  await control(page, 'players.0.lag_ms', 'number').press('Enter');
  await until(async () => page.url().includes('lag_ms:77'), 'the address');
  await page.reload();
  await page.waitForFunction(() => (globalThis.laglab?.().frame ?? null) !== null);
  assert.equal((await sessionOf(page)).id, id);
  assert.equal((await sessionOf(page)).owner, true);
  await close();
  await daemon.stop();
});

test('opened before the daemon is there: it waits and begins', async () => {
  const daemon = await startDaemon();
  const { page, close } = await visit(browser, 'about:blank', { wait: false });
  let refuse = true;
  await page.route('**/api/v1/sessions', (route) => (refuse ? route.abort() : route.continue()));
  await page.goto(`${daemon.url}#race`);
  await page.waitForFunction(() => /No session/.test(document.querySelector('.note')?.textContent ?? ''));
  refuse = false;
  await page.waitForFunction(() => globalThis.laglab().frame?.tick > 3);
  await close();
  await daemon.stop();
});

test('a frame that a closed stream decodes late is not drawn in the next session', async (t) => {
  const daemon = await startDaemon();
  const { page, close } = await visit(browser, 'about:blank', { wait: false });
  t.after(async () => {
    await close();
    await daemon.stop();
  });
  let streams = 0,
    frames = 0;
  /** @type {(value?: unknown) => void} */ let release = () => {};
  const released = new Promise((resolve) => {
    release = resolve;
  });
  /* The tables of the first stream come late, so that its frames wait; the second has a hello alone. */
  await page.routeWebSocket(/\/stream$/, (socket) => {
    const first = streams++ === 0,
      server = socket.connectToServer();
    server.onMessage((message) => {
      if (typeof message === 'string') socket.send(first ? message.replace(/"schema": *"\w+"/, '"schema":"0"') : message);
      else if (first) {
        frames++;
        socket.send(message);
      }
    });
  });
  await page.route('**/stream/schema.json', async (route) => {
    await released;
    await route.continue();
  });
  await page.goto(`${daemon.url}#race`);
  await until(async () => frames > 0, 'a frame waits');
  const counts = () => page.evaluate(() => globalThis.laglab().counts);
  await page.getByRole('button', { name: 'Step', exact: true }).click();
  await until(async () => (await counts()).hellos === 2, 'another session');
  const answered = page.waitForResponse('**/stream/schema.json');
  release();
  await (await answered).finished();
  await refreshes(page);
  assert.equal((await counts()).received, 0);
  assert.equal(await frameOf(page), null);
});

test('where WebSockets are blocked the page says so, asks for frames one by one, and is driven', async () => {
  const daemon = await startDaemon();
  const context = await browser.newContext(),
    page = await context.newPage();
  await page.addInitScript(() => {
    const { WebSocket: Socket } = globalThis;
    globalThis.WebSocket = class extends Socket {
      constructor(/** @type {string | URL} */ address, /** @type {string[]} */ ...rest) {
        const url = new URL(address);
        if (!(/** @type {any} */ (globalThis).unblocked)) url.port = '1'; /* refused */
        super(url, ...rest);
      }
    };
  });
  await page.goto(`${daemon.url}?scenario=race&set=players.0.control:person`);
  await shown(page);
  await reads(page.locator('.note'), /This network blocks live connections \(WebSocket\); the page asks for frames one by one instead/);
  assert.doesNotMatch(await chip(page), /lost/);
  const place = async () => (await frameOf(page)).views[0].entities[0].x;
  const { tick } = await frameOf(page);
  await until(async () => (await frameOf(page)).tick > tick + 30, 'the frames go on');
  const from = await place();
  await page.keyboard.down('ArrowRight');
  await until(async () => (await place()) > from + 1, 'the key drives');
  await page.keyboard.up('ArrowRight');
  await page.getByRole('button', { name: 'Pause', exact: true }).click();
  await page.getByRole('button', { name: 'Play', exact: true }).waitFor();
  await page.getByRole('button', { name: 'Restart', exact: true }).click();
  await until(async () => (await frameOf(page)).tick < tick, 'a jump of time');
  const ids = (await frameOf(page)).events.map(({ id }) => id);
  assert.equal(new Set(ids).size, ids.length);
  assert.equal(await page.evaluate(() => globalThis.laglab().connection.state), 'polled');
  await page.evaluate(() => {
    /** @type {any} */ (globalThis).unblocked = true;
  });
  await until(async () => (await page.evaluate(() => globalThis.laglab().connection.state)) === 'open', 'sockets again');
  await context.close();
  await daemon.stop();
});
