// What spectators see: a view of each below those of the players, how old it is, how full its buffer is, who has fallen out.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { axe, button, dialogOf, frameOf, launch, pause, reads, scrub, settles, shown, until, visit } from './lib.mjs';

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

const FIRST = 3; /* view of the first spectator of two players */

/** The description of a view. @param {import('playwright-core').Page} page @param {number} view */
const wordsOf = (page, view) => () => page.locator(`canvas[data-view="${view}"]`).getAttribute('aria-label');

test('below the players: a view of each spectator, older than the game, with its sender and its buffer', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}?scenario=spectators`);
  await settles(() => page.locator('canvas[data-view]').count(), 5);
  await reads(
    page.locator('section[aria-label="Spectator 1"] .facts'),
    /^inputs from A’s client · \d+ ticks caught up · fell out 0 times$/,
  );
  await until(async () => (await frameOf(page)).spectators?.[1]?.tick > 60, 'they watch', 15000);
  await reads(wordsOf(page, FIRST), /^Spectator 1: \d+ ms behind the game · shows each tick · buffer \d+ of 60 ticks$/);
  await pause(page);
  const { spectators, spectated, entities, views } = await frameOf(page);
  assert.deepEqual(
    spectators.map(({ spectator }) => spectator),
    [0, 1],
  );
  for (const { spectator, tick, age_ms } of spectators) {
    const shown = spectated.filter(({ view }) => view === FIRST + spectator);
    assert.equal(shown.length, 2);
    assert.ok(tick < views[0].input_seq, `spectator ${spectator} shows ${tick}, the server has made ${views[0].input_seq}`);
    assert.ok(age_ms >= [30, 80][spectator], `${age_ms} ms`);
    for (const { entity, x } of shown) assert.ok(x <= entities.find((one) => one.view === 0 && one.entity === entity).x);
  }
  assert.ok(spectators[1].age_ms > spectators[0].age_ms);
  assert.deepEqual(await axe(page), []);
  await page.locator('section[aria-label="Spectator 2"] button.quiet').click();
  const dialog = await dialogOf(page);
  await reads(dialog.locator('h2'), /^All settings of Spectator 2$/);
  assert.equal(await dialog.locator('[data-path="spectators.1.link.down.loss_pct"]').first().inputValue(), '5');
  assert.deepEqual(complaints, []);
  await close();
});

test('an outage is caught up; a longer one and it falls out, which its view says', async () => {
  const { page, close } = await visit(browser, `${daemon.url}?scenario=spectators`);
  await settles(() => page.locator('canvas[data-view]').count(), 5);
  await pause(page);
  await scrub(page, 5.95); /* after 0.8 s without inputs */
  await reads(
    wordsOf(page, FIRST + 1),
    /^Spectator 2: \d+ ms behind the game · catching up: two ticks at once · buffer [1-9]\d* of 60 ticks$/,
  );
  await scrub(page, 26.7);
  await reads(wordsOf(page, FIRST + 1), /^Spectator 2: 1\d{3} ms behind the game · has fallen out: waits for a whole world/);
  await reads(page.locator('section[aria-label="Spectator 2"] .facts'), /fell out once$/);
  await close();
});

test('on a phone each has a tab; in German', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}?scenario=spectators&lang=de`, { width: 390, height: 844 });
  await button(page, 'Zuschauer 2').click();
  await settles(() => page.locator('canvas[data-view]:visible').count(), 1);
  await reads(page.locator('.caption:visible'), /Zuschauer 2\s+80 ms · Eingaben vom Client von A/);
  await until(async () => (await frameOf(page)).spectators?.[1]?.tick > 60, 'they watch', 15000);
  await reads(wordsOf(page, FIRST + 1), /^Zuschauer 2: \d+ ms hinter dem Spiel · .* · Puffer \d+ von 60 Ticks$/);
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth > innerWidth), false);
  assert.deepEqual(await axe(page), []);
  assert.deepEqual(complaints, []);
  await close();
});

test('without spectators nothing of it is read or sent', async () => {
  const { page, requests, close } = await visit(browser, `${daemon.url}?scenario=rollback`);
  await until(async () => (await frameOf(page)).tick > 30, 'it plays');
  assert.equal(await page.evaluate(() => [...globalThis.laglab().frame.sections.keys()].some((name) => name.startsWith('spectat'))), false);
  assert.ok(!requests.some((one) => one.url().includes('spectators.js')));
  await close();
});

test('they are asked for also where the session answers before the page is read', async () => {
  const { page, close } = await visit(browser, 'about:blank', { wait: false });
  await page.route(/js\/shell\/main\.js$/, async (route) => {
    await page.waitForTimeout(700);
    await route.fallback();
  });
  await page.goto(`${daemon.url}?scenario=spectators`);
  await shown(page);
  await until(async () => (await frameOf(page)).spectators?.length === 2, 'they are sent');
  await close();
});
