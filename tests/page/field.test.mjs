// Games that are drawn by their shapes: crates from above, the shooter from the side.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { SIZES, axe, frameOf, launch, reads, until, visit } from './lib.mjs';

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

/** How many pixels of a view have about this colour. @param {import('playwright-core').Page} page @param {number} view
 * @param {string} name of a custom property */
const painted = (page, view, name) =>
  page.evaluate(
    ([v, property]) => {
      const canvas = /** @type {HTMLCanvasElement} */ (document.querySelector(`canvas[data-view="${v}"]`));
      const copy = document.createElement('canvas'),
        pen = copy.getContext('2d', { willReadFrequently: true });
      copy.width = canvas.width;
      copy.height = canvas.height;
      pen.fillStyle = getComputedStyle(document.documentElement).getPropertyValue(String(property));
      pen.fillRect(0, 0, 1, 1);
      const want = pen.getImageData(0, 0, 1, 1).data;
      pen.clearRect(0, 0, 1, 1);
      pen.drawImage(canvas, 0, 0);
      const all = pen.getImageData(0, 0, copy.width, copy.height).data;
      let count = 0;
      for (let i = 0; i < all.length; i += 4) count += [0, 1, 2].every((k) => Math.abs(all[i + k] - want[k]) < 3) ? 1 : 0;
      return count;
    },
    /** @type {[number, string]} */ ([view, name]),
  );

for (const { name, width, height, query } of SIZES) {
  test(`crates and players are seen in every view, ${name}`, async () => {
    const { page, complaints, close } = await visit(browser, `${daemon.url}${query === '' ? '?' : `${query}&`}scenario=crates`, {
      width,
      height,
    });
    await until(async () => (await frameOf(page)).time_s > 1, 'a second has passed');
    for (const view of [0, 1, 2]) {
      for (const colour of ['--p0-fill', '--p1-fill', '--grid']) {
        assert.ok((await painted(page, view, colour)) > 20, `${colour} in view ${view}`);
      }
    }
    await reads(() => page.locator('canvas[data-view="1"]').getAttribute('aria-label'), /A at [\d.]+, [\d.]+ m, B at .* and 40 things/);
    assert.deepEqual(complaints, []);
    if (name === SIZES[0].name) assert.deepEqual(await axe(page), []);
    await close();
  });
}

test('scenery is drawn too', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}?scenario=rifle`);
  await until(async () => (await frameOf(page)).time_s > 1, 'a second has passed');
  for (const view of [0, 1, 2]) {
    for (const colour of ['--p0-fill', '--buffer', '--edge'])
      assert.ok((await painted(page, view, colour)) > 20, `${colour} in view ${view}`);
  }
  assert.deepEqual(complaints, []);
  await close();
});

test('networked water is drawn', async () => {
  for (const scenario of ['sea_watched', 'dam_watched']) {
    const { page, complaints, close } = await visit(browser, `${daemon.url}?scenario=${scenario}`);
    await until(async () => (await frameOf(page)).time_s > 1, 'a second has passed');
    for (const view of [0, 1, 2]) {
      for (const colour of ['--p0-fill', '--p1-fill', '--accent'])
        assert.ok((await painted(page, view, colour)) > 20, `${colour} in view ${view}`);
    }
    assert.deepEqual(complaints, []);
    await close();
  }
});

test('arrows drive in both directions', async () => {
  const { page, close } = await visit(browser, `${daemon.url}?scenario=crates&set=players.0.control:person&set=players.1.script:idle`);
  const place = async () => (await frameOf(page)).views[0].entities[0];
  await page.locator('.view[data-drive="0"]').focus();
  const start = await place();
  await page.keyboard.down('ArrowUp');
  await until(async () => (await place()).y > start.y + 0.5, 'it goes up');
  await page.keyboard.up('ArrowUp');
  await page.keyboard.down('ArrowLeft');
  await until(async () => (await place()).x < start.x - 0.3, 'it goes left');
  await page.keyboard.up('ArrowLeft');
  await until(async () => Math.hypot((await place()).vx, (await place()).vy) === 0, 'it stops');
  await close();
});

test('a view shows only what the player’s snapshots contain', async () => {
  const { page, close } = await visit(browser, `${daemon.url}?scenario=swarm_interest`);
  await until(async () => ((await frameOf(page))?.tick ?? 0) > 60, 'the first snapshots');
  /* 200 bodies on the server, in an area of a player some 30; lines to bodies without a place would darken the view */
  await until(async () => {
    const all = await painted(page, 0, '--truth');
    return all > 0 && (await painted(page, 1, '--truth')) < all;
  }, 'fewer bodies than on the server');
  await close();
});
