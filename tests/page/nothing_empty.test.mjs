// No view opens on words of emptiness: every lab of a fresh daemon, and every choice of what a plot shows, in both languages.
import assert from 'node:assert/strict';
import { after, before } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { launch, until, visit } from './lib.mjs';
import { sweep } from './tiers.mjs';

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

const PLACES = ['#race', '#cannon', '#shoot', '#crates', '#step', '#collide', '#fluid', '#experiments', '#tradeoff'];
const EMPTY = new RegExp(
  [
    'no runs yet|nothing has been measured|not measured|all is 0|events missing',
    'noch kein lauf|nichts gemessen|nicht gemessen|alles ist 0|ereignisse fehlen',
  ].join('|'),
  'i',
);

/** In the page: what canvases say, as they are drawn. */
function listen() {
  const said = /** @type {any} */ ((globalThis.said = new Set())),
    draw = CanvasRenderingContext2D.prototype.fillText;
  CanvasRenderingContext2D.prototype.fillText = function (text, ...at) {
    said.add(String(text));
    return draw.call(this, text, ...at);
  };
}

/** @param {import('playwright-core').Page} page */
const heard = (page) =>
  page.evaluate(() => {
    const { said } = /** @type {any} */ (globalThis),
      texts = [...said, document.querySelector('main')?.innerText ?? ''];
    said.clear();
    return texts.join('\n');
  });

for (const lang of ['en', 'de'])
  for (const at of PLACES)
    sweep(at === '#fluid' && lang === 'en')(`${at} in ${lang} opens on something, and so does each choice of a plot`, async () => {
      const visited = await visit(browser, 'about:blank', { wait: false }),
        { page, close } = visited;
      await page.addInitScript(listen);
      await page.goto(`${daemon.url}?lang=${lang}${at}`);
      await page.locator('main canvas').first().waitFor();
      await until(async () => (await page.evaluate(() => /** @type {any} */ (globalThis).said.size)) > 5, 'something is drawn');
      await page.waitForTimeout(1500);
      assert.doesNotMatch(await heard(page), EMPTY, `${at} as it opens`);
      const plots = page.locator('select.plotted');
      for (let i = 0; i < (await plots.count()); i++) {
        const values = await plots
          .nth(i)
          .locator('option')
          .evaluateAll((all) => all.map((one) => /** @type {HTMLOptionElement} */ (one).value));
        for (const value of values) {
          await plots.nth(i).selectOption(value);
          await page.waitForTimeout(450);
          assert.doesNotMatch(await heard(page), EMPTY, `${at}, plot ${i + 1}: ${value}`);
        }
      }
      await close();
    });
