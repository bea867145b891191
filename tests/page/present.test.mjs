// Views and caption alone, for the back row: sizes, the way in and out, every lab, the address.
import assert from 'node:assert/strict';
import { after, before } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { axe, button, launch, pictures, reads, settles, shown, tickOf, until, visit } from './lib.mjs';
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

const on = (page) => page.locator('#leave').waitFor();
const off = (page) => page.waitForFunction(() => document.documentElement.dataset.present === undefined);
/** Size of the type of what matches first, px. @param {import('playwright-core').Page} page @param {string} selector */
const type = (page, selector) =>
  page
    .locator(selector)
    .first()
    .evaluate((one) => Number.parseFloat(getComputedStyle(one).fontSize));
/** A number of the style sheet that the canvases take. @param {import('playwright-core').Page} page @param {string} name */
const drawn = (page, name) => page.evaluate((one) => Number(getComputedStyle(document.documentElement).getPropertyValue(one)), name);
const WIDE = { width: 1920, height: 1080 };

test('the key V shows views and caption alone, in type of the screen’s height; Esc leaves; the address keeps it', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}#race`, WIDE);
  await page.keyboard.press('v');
  await on(page);
  await reads(async () => page.url(), /present=yes/);
  for (const gone of ['.top', '.gutter', '.side', '.lane', '.bar'])
    await settles(() => page.locator(gone).first().isVisible(), false, gone);
  await settles(() => page.locator('canvas[data-view]').count(), 3);
  for (const box of await page.locator('canvas[data-view]').all()) {
    await until(async () => {
      const { width = 0, height = 0 } = (await box.boundingBox()) ?? {};
      return width > 1900 && height > 220;
    }, 'large views');
  }
  await settles(() => type(page, '.caption b'), 40);
  await until(async () => (await type(page, '.foot h1')) >= 34, 'a large title');
  assert.deepEqual(await Promise.all(['--draw-text', '--draw-axis', '--draw-line'].map((name) => drawn(page, name))), [36, 26, 4.2]);
  await reads(page.locator('.foot .said'), /A race in three views.*B none/s);
  const before = [await pictures(page), await tickOf(page)];
  await until(async () => (await pictures(page)) !== before[0] && (await tickOf(page)) > before[1], 'it moves');
  await page.keyboard.press('Space');
  await button(page, 'Play').waitFor();
  await page.reload();
  await on(page);
  await page.keyboard.press('Escape');
  await off(page);
  await until(async () => !/present/.test(page.url()), 'the address');
  await settles(() => page.locator('.gutter').first().isVisible(), true);
  await settles(() => drawn(page, '--draw-text'), 12);
  assert.deepEqual(complaints, []);
  await close();
});

test('the button of the time bar presents, and Leave returns to it', async () => {
  const { page, close } = await visit(browser, `${daemon.url}#race`);
  await button(page, 'Present').click();
  await on(page);
  await settles(() => page.evaluate(() => document.activeElement?.id), 'views', 'so that Space plays');
  await button(page, 'Leave').click();
  await off(page);
  await settles(() => page.evaluate(() => document.activeElement?.id), 'present');
  await close();
});

test('each view says one sentence with a number of the stream', async () => {
  const { page, close } = await visit(browser, `${daemon.url}?scenario=race&present=yes`, WIDE);
  await on(page);
  await until(async () => (await tickOf(page)) > 240, 'four seconds');
  await page.keyboard.press('Space');
  await button(page, 'Play').waitFor();
  const { views } = await page.evaluate(() => globalThis.laglab().frame.plain());
  const first = `A sees B as it was ${views[1].view_age_ms.toFixed(0)} ms ago`;
  await settles(async () => (await page.locator('.sentence').allInnerTexts())[0], first);
  const said = await page.locator('.sentence').allInnerTexts();
  assert.equal(said[1], 'The truth, 30 updates a second');
  const [, late] = /^B’s key shows after (\d+) ms$/.exec(said[2]) ?? [];
  assert.ok(Number(late) > 500 && Number(late) < 620, said[2]);
  await close();
});

for (const [name, scenario, canvas] of [
  ['shooter', 'rifle', 'canvas[data-view="1"]'],
  ['rigid bodies', 'rigid/collapsing_stack', '#world0'],
  ['integrators', 'motion/spring', '#motion'],
  ['fluid', 'fluid/cylinder', 'figure canvas'],
])
  for (const size of [
    { width: 1920, height: 1080 },
    { width: 1366, height: 768 },
    { width: 768, height: 1024 },
    { width: 390, height: 844 },
  ])
    sweep(size.width === 1920 || (size.width < 400 && name === 'shooter'))(
      `${name}, ${size.width} x ${size.height}: the views fill the screen, nothing goes sideways, axe finds nothing`,
      async () => {
        const { page, complaints, close } = await visit(browser, `${daemon.url}?scenario=${scenario}&present=yes`, size);
        await on(page);
        await until(async () => (await tickOf(page)) > 5, 'it plays');
        await until(async () => {
          const box = await page.locator(canvas).first().boundingBox(),
            foot = await page.locator('.foot').boundingBox();
          return box && foot && box.height > 80 && box.width >= size.width / 2 - 4 && foot.y + foot.height <= size.height + 1;
        }, 'the views fill the screen, and the caption is on it');
        await settles(
          () => page.evaluate(() => document.documentElement.scrollWidth > innerWidth || document.body.scrollHeight > innerHeight),
          false,
        );
        assert.deepEqual(await axe(page), []);
        assert.deepEqual(complaints, []);
        await close();
      },
    );

test('a lesson: its question and step stand below the views', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}?present=yes#lesson=in_the_past&step=3`, { ...WIDE, wait: false });
  await on(page);
  await shown(page);
  await until(async () => (await tickOf(page)) === 180, 'the stop');
  await settles(() => page.locator('.rail').isVisible(), false);
  await reads(page.locator('.foot .said'), /Why is everyone else in the past\?.*2\.27 m behind/s);
  assert.deepEqual(await axe(page), []);
  assert.deepEqual(complaints, []);
  await close();
});

test('the projector’s colours hide no explanation and shrink no panel', async () => {
  const { page, close } = await visit(browser, `${daemon.url}?scenario=race&theme=projector`, WIDE);
  await settles(() => page.locator('.about p').first().isVisible(), true);
  await settles(() => page.locator('.minor').first().isVisible(), true);
  assert.ok((await type(page, '.panel')) >= 16.5);
  await close();
});

test('an experiment is presented by what it shows, and its charts', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}?present=yes#experiments`, { wait: false });
  await on(page);
  await settles(() => page.locator('#chart-1').isVisible(), true);
  await settles(() => page.locator('.asked').isVisible(), false);
  await reads(page.locator('#headline'), /^Prediction cures/);
  assert.deepEqual(await axe(page), []);
  await page.keyboard.press('Escape');
  await off(page);
  await reads(async () => page.url(), /#experiments$/);
  assert.deepEqual(complaints, []);
  await close();
});

test('next to the charts each player has three sentences, whose numbers are the stream’s; who drives reads “your”', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}?scenario=gambetta_default&set=players.0.prediction:true`, WIDE);
  const says = (/** @type {string} */ at) => page.locator(`[data-sentence="${at}"]`).innerText();
  await until(async () => (await tickOf(page)) > 300, 'five seconds');
  await page.keyboard.press('Space');
  await button(page, 'Play').waitFor();
  const { views } = await page.evaluate(() => globalThis.laglab().frame.plain());
  await settles(() => page.locator('[data-term^="0/"]').allInnerTexts(), ['Input latency', 'View age', 'Corrections']);
  await reads(() => says('0/0'), new RegExp(`^A’s key shows after \\d+ ms \\(without prediction at least ${2 * views[1].lag_ms}\\)$`));
  await settles(() => says('1/1'), `B sees A as it was ${views[2].view_age_ms.toFixed(0)} ms ago`);
  assert.ok(views[1].corrections > 0, 'there were some');
  await reads(() => says('0/2'), new RegExp(`^A was pulled back ${views[1].corrections} times?, at most \\d\\.\\d\\d m`));
  await page.keyboard.press('Space');
  await page.evaluate(() => /** @type {HTMLSelectElement} */ (document.querySelector('[data-path="players.0.control"]')).focus());
  await page.locator('[data-path="players.0.control"]').first().selectOption('person');
  await until(async () => /^You see B/.test(await says('0/1')), 'you');
  assert.deepEqual(complaints, []);
  await close();
});
