// The first question: time since the key as a line, whose texts do not touch each other or a slope; the first screen of a phone; and what
// comes after the last step.
import assert from 'node:assert/strict';
import { after, before } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { frameOf, launch, refreshes, scrub, tickOf, until, visit } from './lib.mjs';
import { sweep, test } from './tiers.mjs';

const STOP = 201;
const SCREENS = [
  [390, 844],
  [820, 1180],
  [1366, 768],
  [1920, 1080],
];

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

/** @param {number} step @param {string} language @param {number[]} screen @param {number} tick */
async function opened(step, language, [width = 0, height = 0], tick) {
  const visited = await visit(browser, `${daemon.url}#lesson=late_answer&step=${step}&lang=${language}`, {
    wait: false,
    reducedMotion: 'reduce',
    viewport: { width, height },
  });
  await until(
    () => visited.page.evaluate((stop) => globalThis.laglab?.().frame?.tick === stop && document.querySelector('.since text'), tick),
    'the line is drawn',
  );
  await refreshes(visited.page, 20);
  return visited;
}

/** What of the line touches what: texts, letters and slopes. @param {import('playwright-core').Page} page */
const touching = (page) =>
  page.evaluate(() => {
    /** @type {{name: string, kind: string, left: number, right: number, top: number, bottom: number}[]} */
    const boxes = [];
    const add = (/** @type {string} */ name, /** @type {string} */ kind, /** @type {DOMRect} */ box, trim = 0) =>
      boxes.push({ name, kind, left: box.left, right: box.right, top: box.top + trim, bottom: box.bottom - trim });
    for (const text of document.querySelectorAll('.since text')) {
      const box = text.getBoundingClientRect();
      if (box.width > 0) add(text.textContent ?? '', 'text', box, box.height * 0.15); /* without the room for accents */
    }
    for (const letter of document.querySelectorAll('.since .letter rect')) add('an envelope', 'letter', letter.getBoundingClientRect());
    for (const line of document.querySelectorAll('.since :is(.way, .to)')) {
      const [x1, y1, x2, y2] = ['x1', 'y1', 'x2', 'y2'].map((end) => /** @type {any} */ (line)[end].baseVal.value),
        at = /** @type {SVGSVGElement} */ (line.closest('.since > svg')).getBoundingClientRect();
      for (let i = 0; i <= 60; i++)
        add('a slope', 'slope', new DOMRect(at.left + x1 + ((x2 - x1) * i) / 60, at.top + y1 + ((y2 - y1) * i) / 60, 1, 1));
    }
    return boxes.flatMap((a, i) =>
      boxes
        .slice(i + 1)
        .filter(
          (b) => (a.kind === 'text' || b.kind === 'text') && a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom,
        )
        .map((b) => `${a.name} and ${b.name}`),
    );
  });

for (const screen of SCREENS)
  for (const language of ['en', 'de'])
    sweep(screen[0] === 390 && language === 'en')(`at ${screen[0]} px, ${language}, no text of the line touches anything`, async () => {
      for (const [step, tick] of /** @type {[number, number][]} */ ([
        [1, 180],
        [3, STOP],
      ])) {
        const { page, close } = await opened(step, language, screen, tick);
        assert.deepEqual([...new Set(await touching(page))], [], `step ${step}`);
        await close();
      }
    });

/** Whether elements are within what the lesson shows without being scrolled. @param {import('playwright-core').Page} page
 * @param {string} selector */
const hidden = (page, selector) =>
  page.evaluate((which) => {
    const frame = document.querySelector('.teach')?.getBoundingClientRect();
    return [...document.querySelectorAll(which)]
      .map((one) => ({ of: one.id || one.getAttribute('data-view') || one.className, box: one.getBoundingClientRect() }))
      .filter(({ box }) => !frame || box.width === 0 || box.top < frame.top - 1 || box.bottom > frame.bottom + 1)
      .map(({ of }) => of);
  }, selector);

test('on a phone the first screen has the sentence and both roads; after the change all three roads and the way on', async () => {
  const looked = await opened(3, 'en', [390, 844], STOP);
  assert.deepEqual(await hidden(looked.page, '#rail > p, .row:not(.pressed) canvas'), []);
  await looked.page.getByRole('button', { name: 'Explain' }).last().click();
  await until(async () => (await hidden(looked.page, '.since')).length === 0, 'the explanation has the line in view');
  await looked.close();

  const { page, close } = await visit(browser, `${daemon.url}#lesson=late_answer&step=5&lang=en`, {
    wait: false,
    reducedMotion: 'reduce',
    viewport: { width: 390, height: 844 },
  });
  await page.locator('#rail .main').click();
  await page.locator('#next').waitFor();
  await until(async () => (await hidden(page, '.row canvas, #next')).length === 0, 'all roads and Next are in view');
  assert.equal(await page.locator('#next').textContent(), 'Next: Why does it jump back?');
  assert.equal(await page.locator('.main:visible').count(), 1, 'one filled button');
  await page.getByRole('button', { name: 'Run it again' }).click();
  await until(async () => (await tickOf(page)) === 240, 'it stands at the stop again');
  await page.locator('#next').click();
  await until(async () => page.url().includes('lesson=jump_back&step=1'), 'the next question');
  await close();
});

test('the sandbox and its address keep what the lesson presses', async () => {
  const changed = await visit(browser, `${daemon.url}#lesson=late_answer&step=5&lang=en`, { wait: false, reducedMotion: 'reduce' });
  await changed.page.locator('#rail .main').click();
  await changed.page.locator('#next').waitFor();
  await changed.page.getByRole('button', { name: 'Open in the sandbox' }).click();
  await until(async () => changed.page.url().includes('workload='), 'the address has the keys');
  const again = await visit(browser, changed.page.url(), { reducedMotion: 'reduce' });
  const { inputs } = JSON.parse(new URL(again.page.url()).searchParams.get('workload') ?? '{}');
  assert.deepEqual(
    inputs.map((/** @type {any} */ one) => [one.tick, one.axes]),
    [
      [0, [1, 0]],
      [180, [-1, 0]],
    ],
  );
  await scrub(again.page, 2);
  await until(async () => (await tickOf(again.page)) === 120, 'it is at 2 s');
  assert.ok((await frameOf(again.page)).views[0].entities[0].x > 3, 'the throttle of the lesson drives it');
  await again.close();
  await changed.close();
});
