// Small, enlarged, in other colours: every lab on a narrow screen, at 200 % zoom, in the colours that a system forces, with reduced motion.
import assert from 'node:assert/strict';
import { mkdirSync } from 'node:fs';
import { after, before } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { axe, launch, refreshes, settles, shown, tickOf, until, visit } from './lib.mjs';
import { sweep } from './tiers.mjs';

const SHOTS = process.env.LAGLAB_SHOTS ?? ''; // a folder for images of the page
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

const LABS = [
  ['race', '?scenario=race'],
  ['cannon', '?scenario=cannon'],
  ['shooter', '?scenario=rifle'],
  ['crates', '?scenario=crates'],
  ['integrators', '?scenario=motion/orbit'],
  ['rigid bodies', '?scenario=rigid/collapsing_stack'],
  ['fluid', '?scenario=fluid/cylinder'],
];
const PLACES = [...LABS, ['questions', ''], ['a lesson', '#lesson=late_answer&step=1'], ['experiments', '#experiments']];

/** @param {string} at @param {any} [wish] */
async function open(at, wish = {}) {
  const visited = await visit(browser, daemon.url + at, { ...wish, wait: at.startsWith('?') });
  if (at === '') await visited.page.locator('.card').first().waitFor();
  if (at.startsWith('#lesson')) {
    await visited.page.locator('#rail .steps').waitFor();
    await shown(visited.page);
  }
  if (at === '#experiments') await visited.page.locator('#run:not([disabled])').waitFor();
  return visited;
}

/** Controls that reach beyond the screen, and are not in something that scrolls sideways. @param {import('playwright-core').Page} page
 * @returns {Promise<string[]>} */
const outside = (page) =>
  page.evaluate(() =>
    [...document.querySelectorAll('button, input, select, a, h1, h2, h3, p, label')]
      .filter((one) => {
        const { left, right, width } = one.getBoundingClientRect();
        if (width === 0 || (left >= -1 && right <= innerWidth + 1) || one.closest('.unseen')) return false;
        for (let at = one.parentElement; at; at = at.parentElement)
          if (at !== document.body && ['auto', 'scroll'].includes(getComputedStyle(at).overflowX) && at.scrollWidth > at.clientWidth)
            return false;
        return getComputedStyle(one).position !== 'absolute' || getComputedStyle(one).clipPath === 'none';
      })
      .map((one) => one.outerHTML.slice(0, 90)),
  );

for (const [what, size] of /** @type {[string, any][]} */ ([
  ['on 320 px', { width: 320, height: 640 }],
  ['at 200 % zoom', { width: 683, height: 384, deviceScaleFactor: 2 }],
]))
  for (const [name, at] of PLACES)
    sweep(size.width < 400 || name === 'race')(`${name} ${what}: nothing goes sideways, nothing is out of reach`, async () => {
      const { page, complaints, close } = await open(at, size);
      await settles(() => page.evaluate(() => document.documentElement.scrollWidth > innerWidth), false);
      await settles(() => outside(page), []);
      if (SHOTS) await page.screenshot({ path: `${SHOTS}/${name}-${size.width}.png`.replaceAll(' ', '-') });
      assert.deepEqual(complaints, []);
      await close();
    });

for (const [name, at] of PLACES)
  sweep(['race', 'questions', 'a lesson', 'experiments'].includes(name))(
    `${name} in forced colours: axe finds nothing, and the focus is seen`,
    async () => {
      const { page, complaints, close } = await open(at, { forcedColors: 'active' });
      assert.deepEqual(await axe(page), []);
      let focused = 0;
      for (let i = 0; i < 12; i++) {
        await page.keyboard.press('Tab');
        const focus = await page.evaluate(() => {
          const one = document.activeElement;
          if (!one || one === document.body) return null;
          const { outlineStyle, outlineWidth } = getComputedStyle(one);
          return { seen: outlineStyle !== 'none' && Number.parseFloat(outlineWidth) >= 1, what: one.outerHTML.slice(0, 80) };
        });
        assert.ok(focus === null || focus.seen, focus?.what);
        focused += Number(focus !== null);
      }
      assert.ok(focused > 3, `${focused} of 12 focused`);
      if (SHOTS) await page.screenshot({ path: `${SHOTS}/${name}-forced.png`.replaceAll(' ', '-') });
      assert.deepEqual(complaints, []);
      await close();
    },
  );

for (const [name, at] of LABS)
  sweep(['race', 'rigid bodies'].includes(name))(`${name} with reduced motion waits at its start`, async () => {
    const { page, close } = await open(at, { reducedMotion: 'reduce' });
    await refreshes(page);
    assert.equal(await tickOf(page), 0, name);
    await page.locator('#play').click();
    await until(async () => (await tickOf(page)) > 0, `${name} plays after a click`);
    await close();
  });
