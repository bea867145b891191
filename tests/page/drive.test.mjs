// A person at the controls: keys, pads, the cannon.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { control, frameOf, launch, paramsOf, reads, refreshes, runOn, settles, until, visit } from './lib.mjs';

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

const SLOW = '?scenario=race&set=players.0.lag_ms:500&set=players.1.lag_ms:500&set=players.0.control:person&set=players.1.control:person';

/** Watches, frame by frame, what each view draws of a player after its key went down: between which times of the simulation it begins to
 * move, s: it stood in the frame of the first, it moves in that of the second; the time of the frame when the key went down; and how many
 * inputs were sent by the next refresh. */
const reaction = (page, player, code, key) =>
  page.evaluate(
    async ([p, c, k]) => {
      const lab = globalThis.laglab;
      const place = () => {
        const f = lab().frame,
          x = (view) => f.where('entities', 'view', view)[p].x;
        return { time: f.time_s, own: x(1 + p), server: x(0), other: x(2 - p) };
      };
      const start = place();
      const seen = { own: null, server: null, other: null, pressed: start.time, sent: 0 };
      let last = start;
      const { send } = WebSocket.prototype;
      WebSocket.prototype.send = function (data) {
        seen.sent += Number(typeof data === 'string' && data.includes('"input"'));
        send.call(this, data);
      };
      document.body.dispatchEvent(new KeyboardEvent('keydown', { code: c, key: k, bubbles: true }));
      await new Promise((resolve) => requestAnimationFrame(resolve));
      WebSocket.prototype.send = send;
      while (seen.own === null || seen.server === null || seen.other === null) {
        await new Promise((resolve) => requestAnimationFrame(resolve));
        const now = place();
        for (const who of ['own', 'server', 'other']) {
          if (seen[who] === null && now[who] > start[who] + 1e-4) seen[who] = [last.time, now.time];
        }
        last = now;
      }
      document.body.dispatchEvent(new KeyboardEvent('keyup', { code: c, key: k, bubbles: true }));
      return seen;
    },
    /** @type {[number, string, string]} */ ([player, code, key]),
  );

/** One place begins to move a lag later than another; a car takes ticks to move visibly, a state waits for the next update.
 * @param {Record<string, [number, number]>} seen @param {string} first @param {string} second @param {number} lag s */
function later(seen, first, second, lag) {
  const least = seen[second][0] - seen[first][1],
    most = seen[second][1] - seen[first][0];
  assert.ok(most > lag - 0.02 && least < lag + 0.1, `${second} ${least} to ${most} s after ${first}`);
}

test('with prediction the own car moves by the next frames at 500 ms lag; server and other see it later', async () => {
  const { page, complaints, close } = await visit(
    browser,
    `${daemon.url}${SLOW}&set=players.0.prediction:true&set=players.0.reconciliation:true`,
  );
  await until(async () => (await frameOf(page)).time_s > 1.2, 'states are on their way');
  assert.equal((await frameOf(page)).views[1].entities[0].x, 0);
  const seen = await reaction(page, 0, 'ArrowRight', 'ArrowRight');
  assert.equal(seen.sent, 1, 'by the next refresh');
  later(seen, 'own', 'server', 0.5);
  later(seen, 'server', 'other', 0.5);
  assert.deepEqual(complaints, []);
  await close();
});

test('without prediction the own car waits for the round trip', async () => {
  const { page, close } = await visit(browser, `${daemon.url}${SLOW}&set=players.0.prediction:false&set=players.0.reconciliation:false`);
  await until(async () => (await frameOf(page)).time_s > 1.2, 'states are on their way');
  const seen = await reaction(page, 0, 'ArrowRight', 'ArrowRight');
  assert.equal(seen.sent, 1, 'by the next refresh');
  assert.ok(seen.server[1] - seen.pressed > 0.5, `the server has it after ${seen.server[1] - seen.pressed} s`);
  later(seen, 'server', 'own', 0.5);
  await close();
});

test('D drives B; both at once; releasing stops', async () => {
  const { page, close } = await visit(browser, `${daemon.url}${SLOW}&set=players.1.prediction:true`);
  await page.locator('.view[data-drive="1"]').focus();
  await page.keyboard.down('d');
  await page.keyboard.down('ArrowRight');
  await until(async () => (await frameOf(page)).views[0].entities.every((e) => e.vx > 0.5), 'both drive');
  await page.keyboard.up('d');
  await page.keyboard.up('ArrowRight');
  const vx = async () => (await frameOf(page)).views[0].entities[1].vx;
  await runOn(page, 0.7); /* the release is on its way */
  const speed = await vx();
  await runOn(page, 0.4);
  assert.ok((await vx()) < speed, 'it coasts');
  await close();
});

test('a key takes control, wherever the focus is, and the hint has done its work; Esc returns it to the script', async () => {
  const { page, close } = await visit(browser, `${daemon.url}#race`);
  assert.equal((await paramsOf(page)).players[0].control, 'script');
  await reads(page.locator('#hint'), /drive A; D and A drive B/);
  await page.keyboard.press('ArrowUp'); /* it scrolls: a view without the focus leaves it */
  await refreshes(page);
  assert.equal((await paramsOf(page)).players[0].control, 'script');
  await page.keyboard.press('ArrowRight');
  await until(async () => (await paramsOf(page)).players[0].control === 'person', 'a person drives');
  await until(async () => (await frameOf(page)).views[1].flags & 32, 'the daemon says so');
  await page.keyboard.press('Escape');
  await until(async () => (await paramsOf(page)).players[0].control === 'script', 'the script drives');
  await settles(() => page.locator('#hint').count(), 0);
  await close();
});

test('a tap on a car takes it, and pads appear', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}#race`, { width: 390, height: 844, hasTouch: true });
  await reads(page.locator('#hint'), /Tap a car/);
  assert.equal(await page.locator('.pads').count(), 0);
  await page.locator('#play').click();
  await until(async () => ((await frameOf(page)).flags & 2) === 0, 'a pause');
  const canvas = page.locator('canvas[data-view="2"]'),
    { width, height } = await canvas.boundingBox(),
    { x } = (await frameOf(page)).views[2].entities[1],
    place = { x: 14 + ((width - 28) * x) / 100, y: 14 + 0.75 * (height - 33) };
  await canvas.click({ position: place });
  await until(async () => (await paramsOf(page)).players[1].control === 'person', 'B is taken');
  await page.locator('.pads[data-player="1"]').waitFor();
  assert.equal((await paramsOf(page)).players[0].control, 'script');
  await settles(() => page.locator('#hint').count(), 0);
  assert.deepEqual(complaints, []);
  await close();
});

test('arrow keys on a slider move the slider, not the car', async () => {
  const { page, close } = await visit(browser, `${daemon.url}${SLOW}`);
  const slider = control(page, 'players.0.lag_ms', 'range');
  await slider.focus();
  await page.keyboard.press('ArrowRight');
  await until(async () => (await paramsOf(page)).players[0].lag_ms === 510, 'a step of ten');
  await page.keyboard.press('Shift+ArrowLeft');
  await until(async () => (await paramsOf(page)).players[0].lag_ms === 509, 'a fine step');
  await page.keyboard.press('Home');
  await until(async () => (await paramsOf(page)).players[0].lag_ms === 0, 'the least');
  await runOn(page, 0.3);
  assert.equal((await frameOf(page)).views[0].entities[0].x, 0);
  await close();
});

test('touch pads drive while they are held', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}${SLOW}&set=players.0.prediction:true`, {
    width: 390,
    height: 844,
    hasTouch: true,
  });
  const pad = page.getByRole('button', { name: 'Throttle, Player A' });
  const box = await pad.boundingBox();
  assert.ok(box.width >= 44 && box.height >= 44);
  await page.mouse.move(box.x + 20, box.y + 20);
  await page.mouse.down();
  await until(async () => (await frameOf(page)).views[1].entities[0].vx > 0.5, 'the car drives');
  await page.mouse.up();
  await runOn(page, 0.6);
  const { vx } = (await frameOf(page)).views[1].entities[0];
  await runOn(page, 0.4);
  assert.ok((await frameOf(page)).views[1].entities[0].vx < vx, 'released');
  assert.deepEqual(complaints, []);
  await close();
});

test('a person aims and fires the cannon; each arrived state leaves a dot', async () => {
  const { page, complaints, close } = await visit(
    browser,
    `${daemon.url}?scenario=cannon&set=players.0.control:person&set=players.1.control:person&set=players.0.script:idle`,
  );
  await until(async () => (await frameOf(page)).time_s > 1.7, 'the pause before the first shot is over');
  await page.getByLabel('Angle').first().fill('60');
  await page.getByLabel('Angle').first().press('Enter');
  assert.equal(await page.evaluate(() => globalThis.laglab().dots.flat().length), 0);
  await page.getByRole('button', { name: 'Fire', exact: true }).first().click();
  await until(async () => (await frameOf(page)).views[0].entities[0].flags & 16, 'a shell flies');
  const { vx, vy } = (await frameOf(page)).views[0].entities[0];
  assert.ok(vy > vx, `steep: ${vx} ${vy}`);
  await until(() => page.evaluate(() => globalThis.laglab().dots.every((list) => list.length > 3)), 'dots in every view');
  assert.deepEqual(complaints, []);
  await close();
});
