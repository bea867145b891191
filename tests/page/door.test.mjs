// The first page: a race that one drives; joining a class by its code.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { lineOf, meter, read, valid } from '../../www/js/labs/netgame/front/felt.js';
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
  const { time_s: moved } = await frameOf(page);
  await until(async () => (await frameOf(page)).time_s > moved + 1.5, 'the clock of A has followed: no key comes too late');
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

test('the line follows what was measured, not what was clicked; a release is no press', () => {
  const of = meter(),
    off = { lag: 150, predict: false, correct: false },
    predict = { ...off, predict: true },
    both = { ...predict, correct: true };
  const key = (/** @type {any} */ now) => lineOf(of.reading, now, 150).key;
  /** @type {import('../../www/js/labs/netgame/front/felt.js').Change[]} */ let changes = [];
  let sum = 0,
    count = 0,
    lost = 0;
  /** What the driver did is answered after so long. @param {('' | 'ahead' | 'back')[]} ways @param {number} ms @param {any} now */
  const answer = (ways, ms, now) => {
    changes.push(...ways.map((way) => ({ way, time: 4 })));
    const input_latencies = (count += ways.length),
      input_latency_sum_ms = (sum += ways.length * ms);
    return read(of, { input_latency_sum_ms, input_latencies, input_changes_lost: lost }, now, changes, 5);
  };
  assert.equal(key(off), 'drive');
  assert.equal(key(predict), 'again_predict', 'a switch alone has shown nothing');
  assert.equal(answer([], 0, off), false);
  changes = [{ way: 'back', time: 1 }]; /* lost: its answer never came */
  assert.equal(answer([''], 310, off), false, 'a release');
  assert.equal(key(off), 'drive');
  assert.equal(answer(['ahead', ''], 350, off), true);
  assert.deepEqual(of.last, { latency: 0.35, lag: 150, mode: 'none', way: 'ahead' });
  assert.deepEqual(lineOf(of.reading, off, 150), { key: 'late', lit: 'predict', done: 1 });
  assert.equal(valid(of.last, off), of.last);
  assert.equal(valid(of.last, { ...off, lag: 300 }), null, 'it was felt at another lag');
  assert.equal(valid(of.last, predict), null, 'and with another car');
  assert.equal(key({ ...off, lag: 300 }), 'again');
  changes = [{ way: 'ahead', time: 4 }];
  lost = 1; /* the server had it too late */
  answer(['back'], 633, { ...off, lag: 300 });
  assert.equal(key({ ...off, lag: 300 }), 'late_at');
  assert.deepEqual(of.last, { latency: 0.633, lag: 300, mode: 'none', way: 'back' });
  answer([''], 0, predict);
  assert.equal(key(predict), 'again_predict', 'a key that is released');
  answer(['ahead'], 0, predict);
  assert.deepEqual(lineOf(of.reading, predict, 150), { key: 'thrown', lit: 'correct', done: 2 });
  answer(['ahead'], 0, both);
  assert.equal(key(both), 'stays');
  assert.equal(key({ ...both, lag: 40 }), 'again_both');
  answer(['ahead'], 0, { ...both, lag: 0 });
  assert.equal(key({ ...both, lag: 0 }), 'near', 'it is too little to be seen');
  assert.equal(key(off), 'again', 'the newest press of this mode had another lag');
});

/** The yellow of the first page, as it was drawn; null while there is none. @param {import('playwright-core').Page} page */
const yellow = (page) => page.evaluate(() => globalThis.laglab.shown());

test('a lag that is moved while the key is held takes the old number away, and asks to release it', async () => {
  const { page, close } = await door();
  await page.waitForFunction(() => globalThis.laglab().frame !== null);
  await page.keyboard.down('ArrowRight');
  await reads(page.locator('#front-latency'), /^0\.3\d s$/);
  await page.locator('#front-lag').fill('410');
  await page.locator('#front-lag').blur(); /* the arrows drive again */
  await reads(page.locator('#front-latency'), /^–$/);
  await reads(page.locator('#front-line'), /410 ms, one way\.\s+Release it, then hold → again: how late is it now\?/);
  await page.keyboard.up('ArrowRight');
  await reads(page.locator('#front-line'), /\s+Hold → again: how late is it now\?/);
  await page.waitForTimeout(1800);
  assert.equal(await page.locator('#front-latency').textContent(), '–', 'the answer to the release is none');
  await page.keyboard.down('ArrowRight');
  await reads(page.locator('#front-latency'), /^0\.8\d s$/);
  await close();
});

test('the line says which key was held: a brake at rest shows nothing, one at speed does', async () => {
  const { page, close } = await door();
  await page.waitForFunction(() => globalThis.laglab().frame !== null);
  await page.keyboard.down('ArrowLeft');
  await page.waitForTimeout(900);
  assert.equal(await page.locator('#front-line').getAttribute('data-line'), 'drive');
  await page.keyboard.up('ArrowLeft');
  await page.keyboard.down('ArrowRight');
  await reads(page.locator('#front-line'), /^\s*You held →: the car answered 0\.3\d s late/);
  await page.keyboard.up('ArrowRight');
  await page.keyboard.down('ArrowLeft');
  await reads(page.locator('#front-line'), /^\s*You held ←: the car answered 0\.3\d s late/);
  await close();
});

test('on a phone the pads have their names; yellow comes when 40 px can be seen', async () => {
  const { page, close } = await door('', { width: 390, height: 844 });
  await page.waitForFunction(() => globalThis.laglab().frame !== null);
  await reads(page.locator('#front-line'), /Hold Go/);
  await page.locator('.pedal[data-way="ahead"]').hover();
  await page.mouse.down();
  /** @type {number[]} */ const gaps = [];
  for (let k = 0; k < 45; k++, await page.waitForTimeout(60)) gaps.push(...[(await yellow(page))?.px ?? []].flat());
  assert.ok(gaps.length > 5 && gaps.every((px) => px >= 39), `px: ${gaps.map((px) => px.toFixed(0))}`);
  await reads(page.locator('#front-line'), /You held Go/);
  await page.mouse.up();
  await close();
});

test('at the largest lag, predicted and corrected, the other car stays in view', async () => {
  const { page, close } = await door();
  await page.waitForFunction(() => globalThis.laglab().frame !== null);
  for (const name of ['prediction', 'reconciliation']) await page.locator(`[data-path="players.0.${name}"]`).check({ force: true });
  await page.locator('#front-lag').fill('500');
  await page.locator('#front-lag').blur(); /* the arrows drive again */
  await page.waitForTimeout(2500); /* the clock of A follows: no key comes too late */
  await page.keyboard.down('ArrowRight');
  await until(async () => (await frameOf(page)).views[0].entities[0].vx > 12, 'A is fast');
  await page.waitForTimeout(1500);
  for (let k = 0; k < 12; k++, await page.waitForTimeout(150)) {
    const now = await yellow(page);
    assert.equal(now?.from, 'nose_1');
    assert.ok(now.inside && now.px > 150, JSON.stringify(now));
  }
  await close();
});
