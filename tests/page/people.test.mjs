// What a visitor, a teacher and two students do from the first page, at four sizes and in both languages: by fingers where a screen has
// pads, else by keys.
import assert from 'node:assert/strict';
import { after, before } from 'node:test';
import { faceOf } from '../browsers/browsers.mjs';
import { firstClass, firstVisit, quiet } from '../browsers/people.mjs';
import { startDaemon } from '../lib/daemon.mjs';
import { axe, launch, visit } from './lib.mjs';
import { sweep } from './tiers.mjs';

const PHONE = { width: 390, height: 844, hasTouch: true },
  LAPTOP = { width: 1366, height: 768 };
const SIZES = [PHONE, { width: 820, height: 1180, hasTouch: true }, LAPTOP, { width: 1920, height: 1080 }];

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

/** Pages at a size, by their addresses; the newest is `page`. @param {any} size */
function device(size) {
  const self = {
    page: /** @type {any} */ (null),
    /** @param {string} at */
    open: async (at) => {
      const { page, context, complaints, close } = await visit(browser, daemon.url + at, { ...size, wait: false });
      self.page = page;
      return { ...faceOf(page, complaints, close), ...(size.hasTouch ? { finger: finger(context, page) } : {}) };
    },
  };
  return self;
}

/** @param {any} context @param {any} page */
const finger = (context, page) => async (/** @type {string} */ selector) => {
  const touch = await context.newCDPSession(page),
    { x, y, width, height } = await page.locator(selector).boundingBox();
  const send = (/** @type {string} */ type, /** @type {any[]} */ touchPoints) =>
    touch.send('Input.dispatchTouchEvent', { type, touchPoints });
  assert.ok(height >= 80 && y + height < page.viewportSize().height, 'large, and on the first screen');
  await send('touchStart', [{ x: x + width / 2, y: y + height / 2 }]);
  return () => send('touchEnd', []);
};

/** Nothing is wider than the screen. @param {any} page */
const fits = async (page) => assert.equal(await page.evaluate(() => document.documentElement.scrollWidth > innerWidth), false, 'too wide');

for (const size of SIZES)
  for (const lang of ['en', 'de']) {
    const where = `${size.width}x${size.height} in ${lang}`;
    sweep((size === LAPTOP && lang === 'en') || (size === PHONE && lang === 'de'))(
      `a visitor drives, undoes the lag, and answers the question to which that leads: ${where}`,
      async (t) => {
        const screen = device(size);
        const look = async () => {
          await fits(screen.page);
          assert.deepEqual(await axe(screen.page), []);
        };
        const me = await firstVisit(screen.open, lang, { front: () => fits(screen.page), end: look });
        await look();
        t.diagnostic(me.notes.join('; '));
        await quiet(me);
        await me.close();
      },
    );
    sweep(size === LAPTOP && lang === 'de')(`a class from the first page: two students vote, read why, and drive: ${where}`, async (t) => {
      const teacher = device(size),
        students = [device(PHONE), device(size)];
      const people = await firstClass(
        teacher.open,
        students.map(({ open }) => open),
        lang,
        async () => {
          for (const { page } of [teacher, ...students]) await fits(page);
        },
      );
      for (const me of people) t.diagnostic(me.notes.join('; '));
      await quiet(...people);
      for (const me of people) await me.close();
    });
  }
