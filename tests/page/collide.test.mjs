// The collide lab: scenes with overlays, two solvers side by side, the tunnelling meter, energy, and a body that is dragged.
import assert from 'node:assert/strict';
import { after, before } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { axe, launch, paramsOf, reads, refreshes, runOn, settles, SIZES, until, visit } from './lib.mjs';
import { sweep, test } from './tiers.mjs';

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

const cell = (page, name) => page.locator(`[data-rigid="${name}"]`).textContent();
const drawn = (page, id) => page.locator(`#${id}`).evaluate((c) => /** @type {HTMLCanvasElement} */ (c).toDataURL());
const open = (query, wish = {}) => visit(browser, `${daemon.url}${query}`, wish);

/** What the page has decoded of the newest frame. */
const sceneOf = (page) =>
  page.evaluate(async () => {
    while (globalThis.laglab().frame === null) await new Promise(requestAnimationFrame); /* another session has just begun */
    return globalThis.laglab().scene;
  });

/** The topmost dynamic body of a world, in m and on the screen. */
async function topmost(page, world = 0) {
  const { shapes } = await sceneOf(page);
  const body = shapes.filter((s) => s.dynamic && s.world === world).sort((a, b) => b.y - a.y)[0];
  return { body, ...(await place(page, world, body.x, body.y)) };
}

const place = (page, world, x, y) =>
  page.evaluate(
    ([w, mx, my]) => {
      const { cameras } = globalThis.laglab().drag;
      const at = cameras.get(w),
        box = document.getElementById(`world${w}`).getBoundingClientRect();
      return { px: box.left + (mx - at.left) * at.scale, py: box.top + (at.top - my) * at.scale };
    },
    [world, x, y],
  );

const dragging = (page, on) =>
  until(async () => (await sceneOf(page)).worlds[0].dragging === on, on ? 'a body is held' : 'nothing is held');
/** Goes on for longer than a busy machine needs. */
const LONG = '?scenario=rigid/pyramid&set=duration_s:300';
const pause = (page) => page.waitForFunction(() => document.getElementById('chip')?.textContent?.includes('Paused'));

test('/#collide opens the lab, and it moves', async () => {
  const { page, complaints, requests, close } = await open('#collide');
  await page.waitForSelector('#world0');
  await settles(() => page.locator('.lab[aria-current="page"]').textContent(), 'Collide');
  assert.equal((await paramsOf(page)).kind, 'rigid');
  await page.waitForFunction(() => Number(document.querySelector('[data-rigid="0/contacts"]')?.textContent) > 5);
  assert.ok(requests.some((r) => /js\/rigid-\w+\.js$/.test(r.url())));
  assert.deepEqual(complaints, []);
  await close();
});

test('the race does not read the lab', async () => {
  const { requests, close } = await open('#race');
  assert.ok(!requests.some((r) => /js\/rigid-/.test(r.url())));
  await close();
});

test('contacts are asked for only while they are drawn', async () => {
  const { page, complaints, close } = await open('?scenario=rigid/tumbler&set=duration_s:60');
  await page.waitForSelector('#world0');
  await page.waitForFunction(() => globalThis.laglab().frame.time_s > 0.5);
  const overlay = (name) => page.locator(`[data-overlay="${name}"]`),
    look = async () => {
      const { contacts, shapes } = await sceneOf(page);
      return { contacts: JSON.stringify(contacts), shapes: JSON.stringify(shapes) };
    };
  const moves = async () => {
    const before = await look();
    await runOn(page, 0.5);
    const now = await until(async () => {
      const next = await look();
      return next.shapes !== before.shapes && next;
    }, 'bodies move');
    return now.contacts !== before.contacts;
  };
  assert.ok(await moves(), 'drawn from the start');
  await overlay('contacts').uncheck();
  await until(async () => !(await moves()), 'not drawn, not sent'); /* frames that are on their way still have them */
  await overlay('pairs').check();
  assert.ok(await until(moves, 'contacts are sent'), 'pairs are drawn from them');
  assert.deepEqual(complaints, []);
  await close();
});

test('every overlay draws something', async () => {
  const { page, complaints, close } = await open('?scenario=rigid/tilted_stack');
  await page.waitForSelector('#world0');
  await page.waitForFunction(() => globalThis.laglab().frame.time_s > 0.5);
  await page.locator('#play').click();
  await pause(page);
  for (const name of ['contacts', 'islands', 'pairs', 'boxes', 'paths', 'volumes']) {
    const before = await drawn(page, 'world0');
    await page.locator(`[data-overlay="${name}"]`).click();
    await until(async () => (await drawn(page, 'world0')) !== before, name);
  }
  for (const volume of ['1', '2', '3']) {
    const before = await drawn(page, 'world0');
    await page.locator('#overlaid').selectOption(volume);
    await until(async () => (await drawn(page, 'world0')) !== before, `volume ${volume}`);
  }
  assert.deepEqual(complaints, []);
  await close();
});

test('solvers go side by side from the same start', async () => {
  const { page, complaints, close } = await open('?scenario=rigid/pyramid');
  await page.locator('#count').selectOption({ label: 'two solvers' });
  await page.waitForSelector('#world1');
  await page.locator('[data-path="side_by_side.0.solver.method"]').selectOption('impulse');
  await page.waitForFunction(() => globalThis.laglab().params.side_by_side[0].solver.method === 'impulse');
  await page.locator('#restart, .restart').first().click();
  const { shapes } = await until(async () => {
    const s = await sceneOf(page);
    return s.worlds.length === 2 && s;
  }, 'two worlds');
  assert.equal(shapes.filter((s) => s.world === 0).length, shapes.filter((s) => s.world === 1).length);
  await page.waitForFunction(
    () => document.querySelector('[data-rigid="1/tilt"]')?.textContent !== document.querySelector('[data-rigid="0/tilt"]')?.textContent,
  );
  assert.ok(!(await page.locator('#world0').getAttribute('aria-label'))?.includes('impulse'));
  await reads(() => page.locator('#world1').getAttribute('aria-label'), /impulse/);
  await page.locator('#count').selectOption({ label: 'three solvers' });
  await page.waitForSelector('#world2');
  await settles(
    async () => (await paramsOf(page))?.side_by_side?.map((/** @type {any} */ one) => one.solver.method),
    ['impulse', 'soft_step'],
    'it keeps its solver, and the next begins as the first',
  );
  await page.locator('[data-path="side_by_side.1.solver.substeps"]').fill('4');
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => /substeps 4/.test(document.getElementById('world2')?.getAttribute('aria-label') ?? ''));
  assert.deepEqual(complaints, []);
  await close();
});

test('a scenario of two worlds can be seen with one', async () => {
  const { page, close } = await open('?scenario=rigid/column');
  await page.waitForSelector('#world1');
  await page.locator('#count').selectOption({ label: 'one solver' });
  await page.waitForFunction(() => globalThis.laglab().params?.side_by_side?.length === 0 && !document.getElementById('world1'));
  await page.locator('details summary', { hasText: 'Rebuild with' }).click();
  await page.locator('[data-scene="size"]').fill('5');
  await page.keyboard.press('Tab');
  await page.waitForFunction(() => globalThis.laglab().params?.params?.size === 5);
  assert.equal((await paramsOf(page)).side_by_side.length, 0, 'and stays so');
  await close();
});

test('the tunnelling meter: none with continuous collision detection, most without', async () => {
  const { page, close } = await open('?scenario=rigid/bullets');
  await page.waitForFunction(() => document.getElementById('chip')?.textContent?.includes('Ended'));
  await settles(() => cell(page, '0/tunnelled'), '0 of 200');
  const [passed = 0] = (await reads(() => cell(page, '1/tunnelled'), /^\d+ of 200$/)).split(' of ').map(Number);
  assert.ok(passed > 160 && passed < 200, String(passed));
  const width = () =>
    page
      .locator('[data-fill="1"]')
      .evaluate((e) => e.getBoundingClientRect().width / /** @type {HTMLElement} */ (e.parentElement).getBoundingClientRect().width);
  await until(async () => Math.abs((await width()) - passed / 200) < 0.02, `a bar of ${passed} of 200`);
  await close();
});

test("energy and overlap are plotted; beginner's impulses add energy", async () => {
  const { page, close } = await open('?scenario=rigid/collapsing_stack', { reducedMotion: 'reduce' });
  await page.waitForSelector('#plot-energy');
  await page.waitForFunction(() => globalThis.laglab().frame !== null);
  const before = [await drawn(page, 'plot-energy'), await drawn(page, 'plot-overlap')];
  for (let i = 1; i <= 40; i++) {
    await page.keyboard.press('Period');
    await page.waitForFunction((tick) => globalThis.laglab().frame.tick >= tick, i);
  }
  await until(async () => /^\+[1-9]/.test((await cell(page, '0/energy')) ?? ''), 'energy is added');
  await until(
    async () => (await drawn(page, 'plot-energy')) !== before[0] && (await drawn(page, 'plot-overlap')) !== before[1],
    'the plots are drawn',
  );
  await until(async () => Math.abs(Number((await cell(page, '1/energy'))?.replace('−', '-'))) < 0.5, 'the other keeps its energy');
  await close();
});

test('the cost of each phase of a step is shown, in both worlds', async () => {
  const { page, complaints, close } = await open('?scenario=rigid/column&set=duration_s:300');
  await page.waitForFunction(() => Number(document.querySelector('[data-phase="1/all"] span')?.textContent) > 0);
  const costs = await page // in one question: they change meanwhile
    .locator('[data-phase]')
    .evaluateAll((all) =>
      Object.fromEntries(all.map((e) => [/** @type {HTMLElement} */ (e).dataset.phase, Number(e.querySelector('span')?.textContent)])),
    );
  for (const world of [0, 1])
    for (const phase of ['broad', 'narrow', 'solve', 'continuous', 'finish'])
      assert.ok(costs[`${world}/${phase}`] <= costs[`${world}/all`], `${world}/${phase}: ${JSON.stringify(costs)}`);
  assert.deepEqual(complaints, []);
  await close();
});

test('false hits of the volumes are counted, and the volumes are drawn from the start', async () => {
  const { page, close } = await open('?scenario=paper/fig05');
  await settles(() => page.getByLabel('Volumes', { exact: true }).isChecked(), true);
  await page.waitForFunction(() => Number(document.querySelector('[data-rigid="volume2/false"]')?.textContent) > 20);
  await settles(() => cell(page, 'volume3/missed'), '0');
  await close();
});

test('solver, phases and gravity change live; a value out of range is refused with the range', async () => {
  const { page, complaints, close } = await open('?scenario=rigid/pyramid');
  await page.waitForSelector('[data-path="solver.method"]');
  await page.locator('[data-path="solver.method"]').selectOption('avbd');
  await page.waitForSelector('[data-path="solver.iterations"]');
  await page.locator('[data-path="solver.iterations"]').fill('3');
  await page.locator('[data-path="solver.iterations"]').blur();
  await page.locator('[data-path="solver.continuous"]').selectOption('swept');
  await page.locator('[data-path="solver.bounding_volume"]').selectOption('sphere');
  await page.locator('[data-path="solver.sleep"]').uncheck();
  await page.locator('[data-path="broad_phase"]').selectOption('tree');
  await page.locator('#gravity').selectOption({ label: 'none' });
  await page.waitForFunction(() => {
    const p = globalThis.laglab().params,
      s = p.solver;
    return (
      s.method === 'avbd' &&
      s.iterations === 3 &&
      s.continuous === 'swept' &&
      s.bounding_volume === 'sphere' &&
      !s.sleep &&
      p.broad_phase === 'tree' &&
      p.gravity[1] === 0
    );
  });
  await page.locator('[data-path="solver.iterations"]').fill('900');
  await page.locator('[data-path="solver.iterations"]').blur();
  await page.waitForFunction(() => /200/.test(document.querySelector('.note')?.textContent ?? ''));
  assert.equal((await paramsOf(page)).solver.iterations, 3);
  assert.deepEqual(complaints, []);
  await close();
});

test('another scene or another size creates a new session', async () => {
  const { page, close } = await open('#collide');
  await page.waitForSelector('#scene');
  await page.locator('#scene').selectOption('rigid/arch');
  await page.waitForFunction(() => globalThis.laglab().params?.scene === 'arch');
  await page.locator('#scene').selectOption('rigid/pyramid');
  await page.waitForFunction(() => globalThis.laglab().params?.scene === 'pyramid');
  await page.getByText('Rebuild with').click();
  await page.locator('[data-scene="size"]').fill('4');
  await page.locator('[data-scene="size"]').blur();
  await page.waitForFunction(() => globalThis.laglab().params?.params.size === 4);
  await until(async () => (await sceneOf(page)).shapes.filter((s) => s.dynamic).length === 10, 'ten boxes');
  await close();
});

test('a body is dragged by the mouse, and released', async () => {
  const { page, complaints, close } = await open(LONG);
  await page.waitForFunction(() => globalThis.laglab().frame.time_s > 0.2 && document.getElementById('world0'));
  const { body, px, py } = await topmost(page);
  await page.mouse.move(px, py);
  await page.mouse.down();
  await dragging(page, true);
  const aim = await place(page, 0, body.x + 3, body.y);
  await page.mouse.move(aim.px, aim.py, { steps: 8 });
  await until(async () => {
    const s = (await sceneOf(page)).shapes.find((one) => one.body === body.body);
    return s && Math.abs(s.x - body.x - 3) < 0.5;
  }, 'the body follows');
  await page.mouse.up();
  await dragging(page, false);
  assert.deepEqual(complaints, []);
  await close();
});

test('a body is dragged by a finger', async () => {
  const { page, context, close } = await open(LONG, { width: 390, height: 844, hasTouch: true, isMobile: true });
  await page.waitForFunction(() => globalThis.laglab().frame.time_s > 0.2 && document.getElementById('world0'));
  const client = await context.newCDPSession(page);
  const { body, px, py } = await topmost(page);
  const aim = await place(page, 0, body.x + 2, body.y + 1);
  await client.send('Input.dispatchTouchEvent', { type: 'touchStart', touchPoints: [{ x: px, y: py }] });
  await dragging(page, true);
  for (let i = 1; i <= 8; i++) {
    await client.send('Input.dispatchTouchEvent', {
      type: 'touchMove',
      touchPoints: [{ x: px + ((aim.px - px) * i) / 8, y: py + ((aim.py - py) * i) / 8 }],
    });
  }
  await until(async () => {
    const s = (await sceneOf(page)).shapes.find((one) => one.body === body.body);
    return s && s.x - body.x > 1;
  }, 'the body follows');
  await client.send('Input.dispatchTouchEvent', { type: 'touchEnd', touchPoints: [] });
  await dragging(page, false);
  await close();
});

test('a body is dragged by keys', async () => {
  const { page, close } = await open(LONG);
  await page.waitForFunction(() => globalThis.laglab().frame.time_s > 0.1 && document.getElementById('world0'));
  const { body } = await topmost(page);
  await page.locator('.drag').first().focus();
  const hand = () => page.evaluate(() => globalThis.laglab().drag.pointer.value);
  await page.keyboard.press('ArrowRight');
  for (let i = 0; i < 200; i++) {
    const at = await hand();
    if (at.x < body.x - 0.3) await page.keyboard.press('ArrowRight');
    else if (at.x > body.x + 0.3) await page.keyboard.press('ArrowLeft');
    else if (at.y < body.y - 0.3) await page.keyboard.press('ArrowUp');
    else if (at.y > body.y + 0.3) await page.keyboard.press('ArrowDown');
    else break;
  }
  await page.keyboard.press('Enter');
  await dragging(page, true);
  const from = (await sceneOf(page)).shapes.find((one) => one.body === body.body);
  for (let i = 0; i < 15; i++) await page.keyboard.press('ArrowUp');
  await until(async () => {
    const s = (await sceneOf(page)).shapes.find((one) => one.body === body.body);
    return s && s.y - from.y > 0.5;
  }, 'the body follows');
  await page.keyboard.press('Escape');
  await dragging(page, false);
  await close();
});

for (const { name, width, height, query } of SIZES) {
  sweep(width < 400)(`without a complaint of axe at ${name}, light and dark`, async () => {
    const { page, close } = await open(`${query}${query ? '&' : '?'}scenario=rigid/bullets`, { width, height });
    await page.waitForSelector('#world1');
    for (const colorScheme of /** @type {const} */ (['light', 'dark'])) {
      await page.emulateMedia({ colorScheme });
      await refreshes(page);
      assert.deepEqual(await axe(page, { colours: colorScheme === 'dark' }), [], colorScheme);
    }
    for (const id of ['world0', 'world1']) {
      const box = await page.locator(`#${id}`).boundingBox();
      assert.ok(box && box.height > 80 && box.width > 180, JSON.stringify(box));
    }
    const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    assert.ok(wide <= 0, `${wide} px too wide`);
    await close();
  });
}
