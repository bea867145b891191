// Drawings that lessons have in place of the views, and plots that have their past after a jump.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { startDaemon } from '../lib/daemon.mjs';
import { control, launch, reads, settles, tickOf, until, visit } from './lib.mjs';

const WWW = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../../www');
const lessonOf = (/** @type {string} */ id) => JSON.parse(readFileSync(path.join(WWW, `lessons/${id}.json`), 'utf8'));

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

/** A lesson at a step, at its stop. @param {string} id @param {number} step @param {string} [lang] */
async function open(id, step, lang = 'en') {
  const visited = await visit(browser, `${daemon.url}#lesson=${id}&step=${step}&lang=${lang}`, { wait: false, reducedMotion: 'reduce' });
  if (step > 2) await until(() => visited.page.evaluate((tick) => globalThis.laglab?.().frame?.tick === tick, lessonOf(id).stop_tick), id);
  return visited;
}

const seen = (/** @type {import('playwright-core').Page} */ page) => page.evaluate(() => globalThis.laglab.shown());

test('behind the wall: one goes through every hit that the answer counts; in each the victim is far from where it was hit', async () => {
  const { page, complaints, close } = await open('behind_wall', 3);
  const { ticks } = lessonOf('behind_wall').moments;
  await reads(page.locator('.moments'), /1 of 23/);
  await settles(() => page.getByRole('button', { name: 'The one before' }).isDisabled(), true);
  for (const tick of ticks) {
    await settles(() => tickOf(page), tick);
    await reads(page.locator('#hit-back'), /^rewound by 3[2-4]\d ms$/);
    await reads(page.locator('#hit-age'), /^A, as it was 2\d\d ms before$/);
    const { px, inside } = await until(() => seen(page), `the gap at ${tick}`);
    assert.ok(px >= 40 && inside, `${px} px at ${tick}`);
    if (tick !== ticks.at(-1)) await page.getByRole('button', { name: 'The next' }).click();
  }
  await settles(() => page.getByRole('button', { name: 'The next' }).isDisabled(), true);
  assert.deepEqual(complaints, []);
  await close();
});

test('behind the wall: both screens are live before a shot; without rewinding it misses; the views are one click away', async () => {
  const { page, close } = await open('behind_wall', 1, 'de');
  await reads(page.locator('#hit-saw'), /^Was B sieht$/);
  await reads(page.locator('#hit-screen'), /^Bildschirm von A$/);
  assert.equal(await page.locator('#hit-back').textContent(), '');
  await close();
  const changed = await open('behind_wall', 3);
  await reads(() => changed.page.locator('#hit-own').getAttribute('aria-label'), /^A’s screen when the server decides: rewound by 336 ms$/);
  await changed.page.locator('.steps button').nth(3).waitFor();
  await changed.page.locator('#rail .main').click();
  await changed.page.locator('#rail .main').click();
  await changed.page.locator('#changed').waitFor();
  await changed.page.locator('#rail .main').click();
  await reads(changed.page.locator('#hit-back'), /^not rewound$/);
  await changed.page.getByRole('button', { name: 'Show all views' }).click();
  await changed.page.locator('canvas[data-view="1"]').waitFor();
  await changed.page.getByRole('button', { name: 'Back to the drawing' }).click();
  await changed.page.locator('#hit-own').waitFor();
  await changed.close();
});

test('who waits: the wait is that of the event, and another way of C stops at the same moment with another wait', async () => {
  const { page, complaints, close } = await open('who_waits', 3);
  const { stop_tick: stop, numbers } = lessonOf('who_waits');
  await reads(page.locator('#pace-says'), new RegExp(`^A waits ${numbers.wait.value} ms$`));
  await reads(() => page.locator('#pace').getAttribute('aria-label'), /^Half a second of the race: A waits 133 ms$/);
  const way = control(page, 'players.2.lag_ms', 'range');
  await way.fill('20');
  await way.dispatchEvent('change');
  await until(async () => (await page.evaluate(() => globalThis.laglab().params.players[2].lag_ms)) === 20, 'a session with the other way');
  await settles(() => page.evaluate(() => globalThis.laglab().frame?.tick), stop);
  await reads(page.locator('#pace-says'), /^A waits [45]\d ms$/);
  await page.getByRole('button', { name: 'Show the cars' }).click();
  await page.locator('canvas[data-view="1"]').waitFor();
  assert.deepEqual(
    complaints.filter((text) => !/404/.test(text)) /* of the session before */,
    [],
  );
  await close();
});

for (const [id, ticks] of /** @type {[string, number][]} */ ([
  ['keeps_energy', 600],
  ['falling_stack', 90],
  ['how_many_sweeps', 600],
  ['figure_1', 297],
]))
  test(`${id}: after a jump the plots begin at the start, tick by tick`, async () => {
    const { page, close } = await open(id, 3);
    await until(() => page.evaluate((n) => globalThis.laglab().remembered?.[0]?.length === n, ticks + 1), `${ticks + 1} ticks`);
    const times = await page.evaluate(() => globalThis.laglab().remembered[0]);
    assert.equal(times[0], 0);
    times.forEach((time, i) => assert.ok(Math.abs(time - i / 60) < 1e-3, `${time} is tick ${i}`));
    for (const name of ['plot-step', 'plot-work']) assert.equal(await page.locator(`#${name}`).isVisible(), false, 'what is not measured');
    await close();
  });

test('figure 6: the packet view goes with a jump to the stop, and A’s car is above it', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}#lesson=figure_6&step=1&lang=en`, { wait: false });
  await page.locator('.option input').first().check();
  await page.locator('#lock-in').click();
  await reads(page.locator('#packet-says'), /^Input \d+ /);
  await page.getByRole('button', { name: /to the stop/ }).click();
  await settles(() => page.evaluate(() => globalThis.laglab().frame?.tick), lessonOf('figure_6').stop_tick);
  await reads(page.locator('#packet-says'), /^Input 2[67]\d shows after 0\.0 ms, by prediction; .* after 516\.7 ms\.$/);
  await page.locator('canvas[data-view="1"]').waitFor();
  assert.deepEqual(complaints, []);
  await close();
});
