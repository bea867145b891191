// The first page: a race that one drives; joining a class by its code.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { lineOf, meter, read } from '../../www/js/labs/netgame/front/felt.js';
import { startDaemon } from '../lib/daemon.mjs';
import { api, axe, frameOf, launch, paramsOf, reads, settles, until, visit } from './lib.mjs';

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

/** The first page, with its cards. @param {string} [at] @param {any} [wish] */
async function door(at = '', wish = {}) {
  const visited = await visit(browser, daemon.url + at, { ...wish, wait: false });
  await visited.page.locator('.card').first().waitFor();
  return visited;
}

test('the code of a class, typed on the first page in letters of either case, joins it', async () => {
  const { code } = (await api(daemon.url, 'classes', {})).body;
  const { page, complaints, close } = await door();
  await page.getByLabel('Code of a class').fill(` ${code.toLowerCase()} `);
  await page.getByRole('button', { name: 'Join', exact: true }).click();
  await page.getByRole('heading', { name: `Class ${code}` }).waitFor();
  assert.equal(new URL(page.url()).hash, `#class=${code}`);
  await page.getByRole('button', { name: 'Watch' }).click();
  await page.locator('[data-class="member"]').waitFor();
  assert.deepEqual(complaints, []);
  await close();
});

test('a code that no class has is named, and can be typed again; German has its words', async () => {
  const { page, close } = await door('#questions&lang=de', { width: 390, height: 844 });
  await page.getByLabel('Code einer Klasse').fill('QQQQ');
  await page.keyboard.press('Enter');
  await page.locator('#class-answer', { hasText: 'Keine Klasse hat den Code QQQQ' }).waitFor();
  await settles(() => page.locator('#class-code').isVisible(), true);
  await page.goBack();
  await page.locator('.card').first().waitFor();
  assert.deepEqual(await axe(page), []);
  await close();
});

// ---- the race ----

test('a friend drives B with A and D; the slider keeps the arrows only while the keyboard has chosen it', async () => {
  const { page, complaints, close } = await door();
  await page.waitForFunction(() => globalThis.laglab().frame !== null);
  await page.keyboard.down('d');
  await until(async () => (await frameOf(page)).views[0].entities[1].vx > 2, 'B drives');
  assert.equal((await frameOf(page)).views[0].entities[0].vx, 0, 'A does not');
  await page.keyboard.up('d');
  const slider = page.locator('#front-lag'),
    box = await slider.boundingBox();
  await page.mouse.click(box.x + 0.8 * box.width, box.y + box.height / 2);
  await until(async () => (await paramsOf(page)).players[0].lag_ms > 350, 'the mouse moves it');
  await page.keyboard.down('ArrowRight');
  await until(async () => (await frameOf(page)).views[0].entities[0].vx > 2, 'A drives');
  await page.keyboard.up('ArrowRight');
  await reads(page.locator('#front-line'), /At 4\d\d ms it is 0\.[89]\d s/);
  const { lag_ms: lag } = (await paramsOf(page)).players[0];
  await slider.focus();
  await page.keyboard.press('ArrowRight');
  await until(async () => (await paramsOf(page)).players[0].lag_ms === lag + 5, 'the arrows move it');
  assert.deepEqual(await axe(page), []);
  assert.deepEqual(complaints, []);
  await close();
});

test('a race that no person drives rests, with reduced motion too; a key wakes it', async () => {
  const { page, close } = await door('', { reducedMotion: 'reduce' });
  await page.waitForFunction(() => globalThis.laglab().frame !== null);
  await until(async () => (await frameOf(page)).time_s > 0.3, 'it runs');
  const { id, key } = await page.evaluate(() => {
    const { session } = globalThis.laglab();
    return { id: session.id, key: JSON.parse(sessionStorage.getItem('laglab')).keys[session.id] };
  });
  await api(daemon.url, `sessions/${id}/control`, { op: 'speed', speed: 10 }, key);
  await until(async () => (await api(daemon.url, `sessions/${id}`)).body.status === 'paused', 'it rests');
  await until(async () => (await frameOf(page)).time_s > 20, 'not before');
  await page.keyboard.down('ArrowRight');
  await until(async () => (await frameOf(page)).views[0].entities[0].x > 0, 'it goes on');
  await page.keyboard.up('ArrowRight');
  await close();
});

test('the line follows what was measured, not what was clicked', () => {
  const of = meter(),
    off = { lag: 150, predict: false, correct: false },
    predict = { ...off, predict: true },
    both = { ...predict, correct: true };
  const key = (/** @type {any} */ now) => lineOf(of.reading, now, 150).key;
  assert.equal(key(off), 'drive');
  assert.equal(key(predict), 'again_predict', 'a switch alone has shown nothing');
  assert.equal(read(of, { input_latency_sum_ms: 0, input_latencies: 0 }, off, true), false);
  assert.equal(read(of, { input_latency_sum_ms: 700, input_latencies: 2 }, off, false), true);
  assert.deepEqual(of.last, { latency: 0.35, lag: 150 });
  assert.deepEqual(lineOf(of.reading, off, 150), { key: 'late', lit: 'predict', done: 1 });
  assert.equal(key({ ...off, lag: 300 }), 'again');
  read(of, { input_latency_sum_ms: 1333, input_latencies: 3 }, { ...off, lag: 300 }, true);
  assert.equal(key({ ...off, lag: 300 }), 'late_at');
  assert.equal(of.last?.latency, 0.633);
  read(of, { input_latency_sum_ms: 1333, input_latencies: 4 }, predict, false);
  assert.equal(key(predict), 'again_predict', 'a key that is released');
  read(of, { input_latency_sum_ms: 1333, input_latencies: 5 }, predict, true);
  assert.deepEqual(lineOf(of.reading, predict, 150), { key: 'thrown', lit: 'correct', done: 2 });
  read(of, { input_latency_sum_ms: 1333, input_latencies: 6 }, both, true);
  assert.equal(key(both), 'stays');
  assert.equal(key({ ...both, lag: 40 }), 'again_both');
  assert.equal(key(off), 'again', 'the newest press of this mode had another lag');
});
