// Every lab without players: pause, step, seek, copy, two pages on one session, rotation of a phone, reload.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import {
  api,
  axe,
  button,
  dialogOf,
  frameOf,
  launch,
  paramsOf,
  pause,
  reads,
  refreshes,
  scrub,
  sessionOf,
  settles,
  shown,
  stepOnce,
  tickOf,
  until,
  visit,
} from './lib.mjs';

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

/** Each with a canvas, and a setting that can change during a run. */
const LABS = [
  { name: 'Step', scenario: 'motion/orbit', canvas: 'motion', path: 'methods.0.method', value: 'explicit_euler' },
  { name: 'Collide', scenario: 'rigid/column', canvas: 'world0', path: 'solver.method', value: 'avbd' },
  { name: 'Fluid', scenario: 'fluid/pool', canvas: 'fluid', path: 'solver.method', value: 'dfsph' },
];

test('a dialog of settings goes with the lab that it is of', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}#crates`);
  const settings = page.getByRole('button', { name: 'All settings of Player A' });
  await settings.click();
  await (await dialogOf(page)).locator('[data-path]').first().waitFor();
  await page.keyboard.press('Escape');
  // The other lab is on its way when the dialog opens.
  const tab = await page.getByRole('button', { name: 'Fluid', exact: true }).elementHandle();
  await settings.evaluate((/** @type {any} */ element, /** @type {any} */ other) => {
    other.click();
    element.click();
  }, tab);
  await page.locator('#fluid').waitFor();
  await page.locator('dialog').waitFor({ state: 'hidden' });
  assert.deepEqual(complaints, []);
  await close();
});

const valueOf = (params, path) => path.split('.').reduce((at, part) => at[part], params);
const open = async (lab, wish = {}, hash = '') => {
  const visited = await visit(browser, `${daemon.url}${hash || `?scenario=${lab.scenario}&set=duration_s:120`}`, wish);
  await visited.page.waitForSelector(`#${lab.canvas}`);
  return visited;
};
const stateOf = async (page) => (await api(daemon.url, `sessions/${(await sessionOf(page)).id}/state`)).body;
const at = (page, tick) => until(async () => (await tickOf(page)) === tick, `tick ${tick}`);
const past = (page, tick) => page.waitForFunction((t) => globalThis.laglab().frame?.tick > t, tick);

/** What a canvas shows, by its text of pixels. */
const drawn = (page, id) => page.locator(`#${id}`).evaluate((c) => /** @type {HTMLCanvasElement} */ (c).toDataURL());

for (const lab of LABS) {
  test(`${lab.name}: pause stops, a step is one tick, a seek gives the same state, a reload restores the session`, async () => {
    const { page, complaints, close } = await open(lab);
    await past(page, 30);
    await pause(page);
    const start = await stateOf(page);
    await at(page, start.tick);
    const picture = await drawn(page, lab.canvas);
    await refreshes(page);
    assert.equal(await tickOf(page), start.tick);
    assert.equal(await drawn(page, lab.canvas), picture, 'a pause stands still');
    await stepOnce(page, 'forward');
    await at(page, start.tick + 1);
    assert.notEqual((await stateOf(page)).hash, start.hash);
    await stepOnce(page, 'back');
    await at(page, start.tick);
    assert.equal((await stateOf(page)).hash, start.hash);
    const { time_s: time } = await frameOf(page);
    await scrub(page, time / 2);
    await until(async () => {
      const tick = await tickOf(page);
      return tick > 0 && tick < start.tick;
    }, 'an earlier place');
    await reads(page.locator('#chip'), /Paused at/);
    await reads(page.locator('#clock'), new RegExp(`^${(await frameOf(page)).time_s.toFixed(2)} s`));
    await until(async () => (await drawn(page, lab.canvas)) !== picture, 'it is drawn');
    await scrub(page, time);
    await at(page, start.tick);
    assert.equal((await stateOf(page)).hash, start.hash);
    const { id } = await sessionOf(page);
    await page.locator(`[data-path="${lab.path}"]`).selectOption(lab.value);
    await until(async () => valueOf(await paramsOf(page), lab.path) === lab.value, 'changed');
    await page.getByRole('combobox', { name: 'Speed' }).selectOption('0.5');
    await until(async () => (await frameOf(page)).session.speed === 0.5, 'slower');
    const { tick } = await stateOf(page);
    await page.reload();
    await shown(page);
    await page.waitForSelector(`#${lab.canvas}`);
    assert.deepEqual(await sessionOf(page), { id, owner: true });
    await at(page, tick);
    assert.equal((await frameOf(page)).session.speed, 0.5);
    await settles(async () => valueOf(await paramsOf(page), lab.path), lab.value);
    await settles(() => page.locator(`[data-path="${lab.path}"]`).inputValue(), lab.value);
    await button(page, 'Play').click();
    await past(page, tick + 5);
    assert.deepEqual(complaints, []);
    await close();
  });

  test(`${lab.name}: two pages show one session, and the read-only one makes a copy`, async () => {
    const owner = await open(lab),
      { id } = await sessionOf(owner.page);
    const reader = await open(lab, {}, `#s=${id}`),
      { page } = reader;
    assert.deepEqual(await sessionOf(page), { id, owner: false });
    await settles(() => page.locator(`[data-path="${lab.path}"]`).isDisabled(), true);
    assert.deepEqual(await axe(page), [], 'what a reader may not change can be scrolled by keys');
    await past(page, 20);
    await pause(owner.page);
    const { tick, hash } = await stateOf(owner.page);
    await at(page, tick);
    await reads(page.locator('#chip'), /Paused/);
    await owner.page.locator(`[data-path="${lab.path}"]`).selectOption(lab.value);
    await until(async () => (await page.locator(`[data-path="${lab.path}"]`).inputValue()) === lab.value, 'the reader follows a setting');
    await stepOnce(owner.page, 'back');
    await at(page, tick - 1);
    await stepOnce(owner.page, 'forward');
    await at(page, tick);
    await button(page, 'Make my copy').click();
    await until(async () => {
      const now = await sessionOf(page);
      return now?.owner && now.id !== id && (await frameOf(page)) !== null;
    }, 'a copy');
    await at(page, tick);
    assert.equal((await stateOf(page)).hash, (await stateOf(owner.page)).hash);
    assert.match(hash, /^[0-9a-f]{16}$/);
    await button(page, 'Play').click();
    await past(page, tick + 5);
    assert.equal(await tickOf(owner.page), tick, 'the first one still waits');
    assert.deepEqual([...owner.complaints, ...reader.complaints], []);
    await reader.close();
    await owner.close();
  });

  test(`${lab.name}: a phone that is turned shows the whole view, playing and paused`, async () => {
    const { page, complaints, close } = await open(lab, { width: 390, height: 844, hasTouch: true, isMobile: true, deviceScaleFactor: 2 });
    const fits = async (what) => {
      await until(
        () =>
          page.locator(`#${lab.canvas}`).evaluate((c) => {
            const canvas = /** @type {HTMLCanvasElement} */ (c),
              box = canvas.getBoundingClientRect();
            return Math.abs(canvas.width - 2 * box.width) <= 2 && Math.abs(canvas.height - 2 * box.height) <= 2;
          }),
        `${what}: as many pixels as its box has`,
      );
      const [box, wide] = await Promise.all([
        page.locator(`#${lab.canvas}`).boundingBox(),
        page.evaluate(() => document.documentElement.scrollWidth - innerWidth),
      ]);
      const { width, height } = /** @type {{width: number, height: number}} */ (page.viewportSize());
      assert.ok(box && box.width > 0.45 * width && box.height > 120 && box.height < height, `${what}: ${JSON.stringify(box)}`);
      assert.ok(wide <= 0, `${what}: ${wide} px too wide`);
      const colours = await page.locator(`#${lab.canvas}`).evaluate((c) => {
        const { width: w, height: h } = /** @type {HTMLCanvasElement} */ (c),
          copy = new OffscreenCanvas(w, h).getContext('2d'); /* the page's own stays as it is */
        copy.drawImage(/** @type {HTMLCanvasElement} */ (c), 0, 0);
        return new Set(new Uint32Array(copy.getImageData(0, 0, w, h).data.buffer)).size;
      });
      assert.ok(colours > 3, `${what}: ${colours} colours`);
      const bar = await page.locator('.bar').boundingBox();
      assert.ok(bar && bar.y + bar.height <= height + 1, `${what}: the time bar at ${JSON.stringify(bar)}`);
    };
    await fits('upright');
    await page.setViewportSize({ width: 844, height: 390 });
    await fits('lying');
    await page.locator('#play').click();
    await button(page, 'Play').waitFor();
    await page.setViewportSize({ width: 390, height: 844 });
    await fits('upright and paused');
    assert.deepEqual(complaints, []);
    await close();
  });

  test(`${lab.name}: on a phone settings and numbers are one tap away`, async () => {
    const { page, complaints, close } = await open(lab, { width: 390, height: 844, hasTouch: true, isMobile: true });
    for (const [part, what] of [
      ['Settings', '.methods :is(select, input)'],
      ['Numbers', '.side table'],
      ['Views', `#${lab.canvas}`],
    ]) {
      await page.getByRole('navigation', { name: 'Part shown' }).getByRole('button', { name: part, exact: true }).tap();
      const first = page.locator(`main ${what}`).filter({ visible: true }).first();
      await first.waitFor();
      const box = /** @type {{y: number}} */ (await first.boundingBox());
      assert.ok(box.y < 844 / 2, `${part}: ${box.y} px down`);
      assert.deepEqual(await axe(page), [], part);
    }
    assert.deepEqual(complaints, []);
    await close();
  });
}

test('the help has the keys and views of the lab that is shown: driving only with a netgame', async () => {
  const { page, close } = await visit(browser, `${daemon.url}#race`);
  const captions = async () => {
    await button(page, 'Help').click();
    await dialogOf(page);
    const found = await page.locator('dialog caption').allTextContents(),
      keys = await page.locator('dialog kbd').allTextContents();
    await page.keyboard.press('Escape');
    await page.locator('dialog').waitFor({ state: 'hidden' });
    return { found, keys };
  };
  await page.waitForSelector('#error-chart canvas');
  const race = await captions();
  assert.deepEqual(race.found, ['Keys', 'Driving']);
  assert.ok(race.keys.includes('G') && race.keys.includes('Shift + 1') && race.keys.includes('A, D'));
  for (const lab of [...LABS.map(({ name }) => name), 'Experiments']) {
    await button(page, lab).click();
    await page.waitForFunction((name) => document.querySelector('.lab[aria-current="page"]')?.textContent === name, lab);
    await page.waitForSelector(lab === 'Experiments' ? 'main.sweeps' : 'main.step');
    const { found, keys } = await captions();
    assert.deepEqual(found, ['Keys'], lab);
    assert.ok(keys.includes('F') && !keys.includes('G') && !keys.includes('A, D'), lab);
    assert.equal(keys.includes('Space'), lab !== 'Experiments', lab);
  }
  await button(page, 'Race').click();
  await page.waitForFunction(() => document.querySelector('.lab[aria-current="page"]')?.textContent === 'Race');
  await shown(page);
  assert.deepEqual((await captions()).found, ['Keys', 'Driving']);
  await close();
});

test('a lab that is left lets go of what it has made: nodes and listeners are where they were', async () => {
  const { page, context, close } = await visit(browser, `${daemon.url}#race`);
  const devtools = await context.newCDPSession(page);
  for (const domain of /** @type {const} */ (['Performance', 'HeapProfiler'])) await devtools.send(`${domain}.enable`);
  /** All labs once, the race last. */
  const round = async () => {
    for (const [name, kind] of [
      ['Step', 'motion'],
      ['Collide', 'rigid'],
      ['Fluid', 'fluid'],
      ['Race', 'netgame'],
    ]) {
      await button(page, name).click();
      await page.waitForFunction(
        (of) =>
          globalThis.laglab().params?.kind === of && globalThis.laglab().frame?.tick > 5 && document.querySelector('main canvas') !== null,
        kind,
      );
    }
    await page.locator('#error-chart canvas').waitFor();
  };
  const held = async () => {
    for (let i = 0; i < 3; i++) {
      await devtools.send('HeapProfiler.collectGarbage');
      await refreshes(page, 3);
    }
    const { metrics } = await devtools.send('Performance.getMetrics');
    return ['Nodes', 'JSEventListeners'].map((name) => metrics.find((one) => one.name === name)?.value ?? NaN);
  };
  for (let i = 0; i < 2; i++) await round(); /* the last of each lab may be kept */
  const [nodes = 0, listeners = 0] = await held();
  for (let i = 0; i < 3; i++) await round();
  const [later = Infinity, heard = Infinity] = await held();
  /* one page of a race, which the browser's compiler may keep, has 1,130 nodes and 64 listeners: not three */
  assert.ok(later < nodes + 1700 && heard < listeners + 100, `${nodes} nodes and ${listeners} listeners, then ${later} and ${heard}`);
  await close();
});
