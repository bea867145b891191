// Every lesson on paper.
import assert from 'node:assert/strict';
import { readFileSync, readdirSync } from 'node:fs';
import { after, before, test } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { launch, printed, visit } from './lib.mjs';

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

const LESSONS = readdirSync(new URL('../../www/lessons/', import.meta.url))
  .filter((name) => name.endsWith('.json'))
  .map((name) => name.slice(0, -5));

/** Pages of a PDF, each its size in points. @param {Buffer} pdf */
function pagesOf(pdf) {
  const text = pdf.toString('latin1');
  const boxes = [...text.matchAll(/\/MediaBox\s*\[([^\]]*)\]/g)].map(([, box]) => box.trim().split(/\s+/).map(Number).slice(2));
  return { count: [...text.matchAll(/\/Type\s*\/Page\b(?!s)/g)].length, boxes };
}

test('each lesson is printed on two pages of A4 in both languages, with nothing cut off', async () => {
  assert.ok(LESSONS.length >= 31);
  const { page, complaints, close } = await visit(browser, `${daemon.url}#lesson=${LESSONS[0]}&step=1&lang=en`, { wait: false });
  for (const id of LESSONS) {
    const lesson = JSON.parse(readFileSync(new URL(`../../www/lessons/${id}.json`, import.meta.url), 'utf8'));
    for (const lang of ['en', 'de']) {
      await page.evaluate((hash) => {
        location.hash = hash;
      }, `lesson=${id}&step=1&lang=${lang}`);
      await page.locator('#lesson-step', { hasText: lesson.title[lang] }).waitFor();
      await page.waitForFunction(
        (start) => globalThis.laglab().frame?.tick === start && document.querySelector('#print'),
        lesson.start_tick ?? 0,
      );
      const { count, boxes } = pagesOf(await printed(page));
      assert.equal(count, 2, `${id} ${lang}`);
      for (const [width, height] of boxes)
        assert.ok(Math.abs(width - 595.3) < 1 && Math.abs(height - 841.9) < 1, `${id}: ${width} x ${height}`);
      await page.emulateMedia({ media: 'print' });
      const sheets = await page.locator('.a4').evaluateAll((list) =>
        list.map((sheet) => {
          const foot = sheet.querySelector('footer').getBoundingClientRect().top;
          const images = [...sheet.querySelectorAll('img')].map(
            (image) => image.naturalWidth > 100 && image.getBoundingClientRect().height > 30,
          );
          return {
            text: sheet.textContent ?? '',
            free:
              foot -
              Math.max(...[...sheet.children].filter((one) => one.tagName !== 'FOOTER').map((one) => one.getBoundingClientRect().bottom)),
            sideways: sheet.scrollWidth - sheet.clientWidth,
            images,
          };
        }),
      );
      await page.emulateMedia({ media: null });
      for (const { free, sideways, images } of sheets) {
        assert.ok(free >= 0 && sideways <= 0, `${id} ${lang}: ${free} px above the foot, ${sideways} px too wide`);
        assert.ok(images.length > 0 && images.every(Boolean), `${id} ${lang}: images`);
      }
      assert.ok(
        sheets[0].text.includes(lesson.title[lang]) && sheets[1].text.includes(lesson.misconceptions[0]?.[lang] ?? ''),
        `${id} ${lang}`,
      );
      assert.doesNotMatch(sheets.map(({ text }) => text).join(), /\{\w+\}|undefined|NaN/, id);
    }
  }
  assert.equal(await page.evaluate(() => new URLSearchParams(location.hash.slice(1)).get('step')), '1', 'the lesson is where it was');
  assert.deepEqual(complaints, []);
  await close();
});
