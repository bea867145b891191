// Longer texts and another script: nothing overlaps, nothing leaves the page. `?stringTest=` changes every text of the page
// (www/js/base/string_test.js).
import assert from 'node:assert/strict';
import { mkdirSync } from 'node:fs';
import { after, before, test } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { launch, refreshes, until, visit } from './lib.mjs';

const SHOTS = process.env.LAGLAB_SHOTS ?? '';
if (SHOTS) mkdirSync(SHOTS, { recursive: true });

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

const PLACES = ['', '#race', '#step', '#collide', '#fluid', '#experiments', '#lesson=late_answer'];

/** What is wrong with the layout: the page goes sideways, or two controls lie on each other. @param {import('playwright-core').Page} page
 * @returns {Promise<string[]>} */
const faults = (page) =>
  page.evaluate(() => {
    const found = [];
    const wide = document.documentElement.scrollWidth - innerWidth;
    if (wide > 0) found.push(`the page is ${wide} px too wide`);
    const parts = [...document.querySelectorAll('button, input, select, a[href], summary, h1, h2, h3')].filter(
      (one) =>
        one.checkVisibility({ visibilityProperty: true }) &&
        !one.closest('.unseen, svg, [inert], take-away') &&
        one.getBoundingClientRect().width > 1,
    );
    /** What of it can be seen within all that scrolls or cuts. */
    const boxes = parts.map((one) => {
      let { left, right, top, bottom } = one.getBoundingClientRect();
      for (let at = one.parentElement; at; at = at.parentElement) {
        if (getComputedStyle(at).overflow === 'visible') continue;
        const edge = at.getBoundingClientRect();
        [left, right, top, bottom] = [
          Math.max(left, edge.left),
          Math.min(right, edge.right),
          Math.max(top, edge.top),
          Math.min(bottom, edge.bottom),
        ];
      }
      return { left, right, top, bottom };
    });
    const name = (one) => `${one.tagName.toLowerCase()} “${(one.getAttribute('aria-label') ?? one.textContent ?? '').trim().slice(0, 30)}”`;
    for (let i = 0; i < parts.length; i++)
      for (let k = i + 1; k < parts.length; k++) {
        if (parts[i].contains(parts[k]) || parts[k].contains(parts[i])) continue;
        const across = Math.min(boxes[i].right, boxes[k].right) - Math.max(boxes[i].left, boxes[k].left),
          down = Math.min(boxes[i].bottom, boxes[k].bottom) - Math.max(boxes[i].top, boxes[k].top);
        if (across > 2 && down > 2)
          found.push(`${name(parts[i])} and ${name(parts[k])} overlap by ${Math.round(across)} x ${Math.round(down)} px`);
      }
    return found;
  });

for (const how of ['double', 'long', 'rtl'])
  for (const [width, height] of [
    [1366, 768],
    [390, 844],
  ])
    test(`texts ${how} at ${width} x ${height}`, async () => {
      const wrong = [];
      for (const place of PLACES) {
        const { page, close } = await visit(browser, `${daemon.url}?stringTest=${how}${place}`, { width, height, wait: false });
        await page
          .locator(
            place === '' ? '.card' : place === '#experiments' ? '#views h2' : place.startsWith('#lesson') ? '.option' : '[data-path]',
          )
          .first()
          .waitFor({ state: 'attached' });
        if (how === 'rtl')
          await until(async () => /[\u05d0-\u05ea]/.test(await page.evaluate(() => document.body.innerText)), 'another script');
        await refreshes(page, 15);
        wrong.push(...(await faults(page)).map((fault) => `${place || 'door'}: ${fault}`));
        if (SHOTS) await page.screenshot({ path: `${SHOTS}/${how}-${width}-${place.replace(/\W/g, '') || 'door'}.png` });
        await close();
      }
      assert.deepEqual(wrong, []);
    });
