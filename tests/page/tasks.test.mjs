// Tasks of a visitor who has not been taught: each in at most three clicks from the first page, each with its outcome on the screen.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { button, dialogOf, launch, paramsOf, reads, settles, shown, tickOf, until, visit } from './lib.mjs';

const CLICKS = 3;

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

/** A visitor at the first page, whose clicks are counted: a choice of a list is one. @param {any} [wish] */
async function visitor(wish = {}) {
  const { page, complaints, close } = await visit(browser, daemon.url, { ...wish, wait: false });
  await page.locator('.card').first().waitFor();
  let clicks = 0;
  return {
    page,
    /** @param {import('playwright-core').Locator} what */
    click: async (what) => {
      clicks++;
      await what.click();
    },
    /** @param {import('playwright-core').Locator} list @param {string | {label: string}} value */
    choose: async (list, value) => {
      clicks++;
      await list.selectOption(value);
    },
    /** @param {string} name */
    open: async (name) => {
      clicks++;
      await page.locator('nav').getByRole('button', { name, exact: true }).click();
      await shown(page);
    },
    end: async () => {
      assert.ok(clicks > 0 && clicks <= CLICKS, `${clicks} clicks`);
      assert.deepEqual(complaints, []);
      await close();
    },
  };
}
/** @param {import('playwright-core').Page} page @param {RegExp} title */
const card = (page, title) => page.locator('.card', { hasText: title });

test('a: why is prediction needed? A question, which is predicted, run and explained', async () => {
  const { page, click, end } = await visitor();
  await click(card(page, /Why does my car answer late/));
  await page.locator('#rail input[name="answer"]').first().waitFor();
  await shown(page);
  await end();
});

test('b: lockstep is compared with prediction, on the same seed', async () => {
  const { page, click, open, end } = await visitor();
  await open('Race');
  await click(button(page, 'Compare'));
  await click(button(page, 'Second run in lockstep'));
  await reads(page.locator('#compare-differ'), /Synchronisation/);
  await until(async () => (await page.locator('main.compare').getAttribute('aria-busy')) === 'false', 'both runs');
  await reads(page.locator('#compare-sentence'), /they differ by|differs between the runs by/);
  await end();
});

test('c: two students play: the class, its code, a seat on each device', async () => {
  const teacher = await visitor();
  await teacher.open('Race');
  await teacher.click(button(teacher.page, 'Class'));
  await teacher.page.locator('.joining .letters').waitFor();
  const code = new URL(teacher.page.url()).hash.replace('#class=', '');
  for (const player of ['A', 'B']) {
    const { page, click, end } = await visitor({ width: 390, height: 844, hasTouch: true });
    await page.getByLabel('Code of a class').fill(code);
    await click(button(page, 'Join'));
    await click(page.getByRole('button', { name: new RegExp(`^Play ${player}`) }));
    await shown(page);
    await page.locator('.pads button').first().waitFor();
    await settles(async () => (await paramsOf(teacher.page)).players['AB'.indexOf(player)].control, 'person');
    /* this device is the player; the board names both */
    await reads(() => page.locator(`[data-sentence="${'AB'.indexOf(player)}/0"]`).textContent(), /^Your key/);
    await end();
  }
  await reads(() => teacher.page.locator('[data-sentence="0/0"]').textContent(), /^A’s key/);
  await reads(() => teacher.page.locator('[data-sentence="1/0"]').textContent(), /^B’s key/);
  await teacher.end();
});

test('d: an image of a view is saved', async () => {
  const { page, click, open, end } = await visitor();
  await open('Race');
  const file = page.waitForEvent('download');
  await click(button(page, 'Save image: View of Player A'));
  assert.match((await file).suggestedFilename(), /\.png$/);
  await end();
});

test('e: lag from 0 to 500 ms as a plot', async () => {
  const { page, click, end } = await visitor();
  await page.locator('nav').getByRole('button', { name: 'Experiments', exact: true }).waitFor();
  await click(page.locator('nav').getByRole('button', { name: 'Experiments', exact: true }));
  const plot = page.locator('#chart-0');
  await plot.waitFor();
  await reads(() => plot.getAttribute('aria-label'), /^Your own key shows after, ms, over: lag of A, one way, ms/);
  await end();
});

test('f: a car is driven by the keys of this device', async () => {
  const { page, choose, open, end } = await visitor();
  await open('Race');
  await choose(page.locator('#app select[data-path="players.0.control"]'), 'person');
  await settles(async () => (await paramsOf(page)).players[0].control, 'person');
  await reads(page.locator('[data-sentence="0/0"]'), /^Your key/);
  await reads(page.locator('[data-sentence="1/0"]'), /^B’s key/);
  await end();
});

test('g: was I shot behind the wall? A question', async () => {
  const { page, click, end } = await visitor();
  await click(card(page, /Was I shot behind the wall/));
  await reads(page.locator('main'), /A’s screen/);
  await page.waitForFunction(() =>
    [...document.querySelectorAll('canvas')].some((picture) => picture.clientHeight > 100 && picture.toDataURL().length > 5000),
  );
  await end();
});

test('h: slow motion, and one tick at a time', async () => {
  const slow = await visitor();
  await slow.open('Race');
  await slow.choose(slow.page.getByLabel('Speed'), '0.1');
  await settles(() => slow.page.evaluate(() => Math.fround(0.1) === globalThis.laglab().frame?.plain().session.speed), true);
  await slow.end();
  const step = await visitor();
  await step.open('Race');
  await step.click(button(step.page, 'Pause'));
  await button(step.page, 'Play').waitFor();
  const tick = await tickOf(step.page);
  await step.click(button(step.page, 'One tick forward'));
  await settles(() => tickOf(step.page), tick + 1);
  await step.end();
});

test('i: what is set is passed on by a link', async () => {
  const { page, click, open, end } = await visitor();
  await open('Race');
  await click(button(page, 'Share'));
  await dialogOf(page);
  await until(async () => (await page.locator('dialog input').first().inputValue()).includes('scenario=race'), 'the address');
  await end();
});

test('j: one packet is followed from the key to the display', async () => {
  const { page, click, open, end } = await visitor();
  await open('Race');
  await click(button(page, 'Packet'));
  await page.locator('main canvas').first().waitFor();
  await page
    .getByRole('heading', { name: /packet/i })
    .first()
    .waitFor();
  await end();
});

test('k: the page in German, and help', async () => {
  const german = await visitor();
  await german.click(german.page.getByRole('button', { name: /Deutsch/ }));
  await german.page.locator('.card', { hasText: 'Warum' }).first().waitFor();
  await german.end();
  const help = await visitor();
  await help.click(button(help.page, 'Help'));
  await dialogOf(help.page);
  await help.end();
});
