// The fluid lab: a flow, settings that change live, and a pointer that drags the fluid.
import assert from 'node:assert/strict';
import { after, before } from 'node:test';
import { mapsOf } from '../../www/js/labs/fluid/colours.js';
import { startDaemon } from '../lib/daemon.mjs';
import { axe, costOf, launch, paramsOf, reads, refreshes, sessionOf, settles, SIZES, until, visit } from './lib.mjs';
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

const open = async (query, wish = {}) => {
  const visited = await visit(browser, `${daemon.url}${query}`, wish);
  await visited.page.waitForSelector('#fluid');
  return visited;
};
const drawn = (page, id = 'fluid') => page.locator(`#${id}`).evaluate((c) => /** @type {HTMLCanvasElement} */ (c).toDataURL());
const shownValue = async (page, name) => Number((await page.locator(`[data-fluid="${name}"]`).textContent())?.replaceAll('−', '-'));
const reached = (page, time) => page.waitForFunction((t) => globalThis.laglab().frame?.time_s >= t, time);
const pause = async (page) => {
  await page.locator('#play').click();
  await page.waitForFunction(() => document.getElementById('chip')?.textContent?.includes('Paused'));
};

/** What the page has decoded of the newest frame. */
const fluidOf = (page, i = 0) =>
  page.evaluate(async (at) => {
    while (globalThis.laglab().frame === null) await new Promise(requestAnimationFrame); /* another session has just begun */
    const one = globalThis.laglab().fluids[at];
    if (!one) return null; /* not in this frame yet */
    const { field, state, points } = one;
    return {
      state,
      field: field && { ...field, bytes: [...field.bytes.slice(0, field.width * field.height)] },
      points: points.map((one) => ({ ...one, values: [...one.values] })),
    };
  }, i);

/** A cell's value. */
const valueAt = (field, x, y) =>
  field.low + (field.bytes[Math.floor(y * field.height) * field.width + Math.floor(x * field.width)] / 254) * (field.high - field.low);

/** On the screen, from shares of the view's width and height, from the lower left. */
const place = (page, x, y) =>
  page.evaluate(
    ([sx, sy]) => {
      const { drag, view } = globalThis.laglab(),
        at = drag.cameras.get(0);
      const [left, right, bottom, top] = view,
        box = document.getElementById('fluid').getBoundingClientRect();
      return {
        px: box.left + (left + sx * (right - left) - at.left) * at.scale,
        py: box.top + (at.top - bottom - sy * (top - bottom)) * at.scale,
      };
    },
    [x, y],
  );

test('/#fluid opens the lab, and it flows', async () => {
  const { page, complaints, requests, close } = await open('#fluid');
  await settles(() => page.locator('.lab[aria-current="page"]').textContent(), 'Fluid');
  const now = await paramsOf(page);
  assert.deepEqual(
    [now.solver.advection, now.side_by_side[0].solver.advection],
    ['semi_lagrangian', 'bfecc'],
    'one fails next to one that holds',
  );
  assert.match(await page.locator('.see').innerText(), /^The same disc turns twice: /);
  const one = await drawn(page);
  await reached(page, 1);
  await until(async () => (await drawn(page)) !== one, 'it moves');
  await until(
    async () => (await shownValue(page, 'error_l1')) > 2 * (await shownValue(page, '1/error_l1')),
    'the disc is smeared, and next to it is not',
  );
  assert.ok(requests.some((r) => /js\/fluid-\w+\.js$/.test(r.url())));
  assert.deepEqual(complaints, []);
  await close();
});

test('the race reads nothing of the lab', async () => {
  const { requests, close } = await visit(browser, `${daemon.url}#race`);
  assert.deepEqual(
    requests.map((r) => r.url()).filter((url) => url.includes('fluid')),
    [],
  );
  await close();
});

test('the numbers on the page are those of the daemon at that tick', async () => {
  const { page, close } = await open('?scenario=fluid/taylor_green');
  await reached(page, 0.3);
  await pause(page);
  const { id } = await sessionOf(page);
  const { metrics } = await (await fetch(`${daemon.url}api/v1/sessions/${id}/metrics`)).json();
  await until(async () => Math.abs((await shownValue(page, 'error_l2')) / metrics.error_l2 - 1) < 1e-3, 'the error is shown');
  await until(async () => Math.abs((await shownValue(page, 'energy')) / metrics.energy - 1) < 1e-3, 'the energy is shown');
  await until(async () => (await shownValue(page, 'divergence_max')) < 1e-12, 'the divergence is shown');
  await close();
});

test('every field that the method offers can be seen, with its unit', async () => {
  const { page, complaints, close } = await open('?scenario=fluid/cavity');
  await reached(page, 0.5);
  await pause(page);
  const names = await page.locator('#field option').allTextContents();
  assert.ok(names.length >= 4, names.join());
  const seen = new Set();
  for (const [i, name] of names.entries()) {
    await page.locator('#field').selectOption(String(i));
    await until(async () => (await fluidOf(page)).field.layer === i, name);
    seen.add(
      await until(async () => {
        const picture = await drawn(page);
        return !seen.has(picture) && picture;
      }, `${name} is drawn, unlike those before`),
    );
  }
  await reads(page.locator('.method .facts'), /1\/s/);
  const smooth = await drawn(page);
  await page.locator('[data-drawing="cells"]').check();
  await until(async () => (await drawn(page)) !== smooth, 'sharp cells');
  const flat = await drawn(page);
  await page.locator('[data-drawing="relief"]').check();
  await until(async () => (await drawn(page)) !== flat, 'a relief');
  assert.deepEqual(complaints, []);
  await close();
});

test('walls and empty cells have separate colours, and the view is not upside down', async () => {
  const { page, close } = await open('?scenario=fluid/cavity&set=shown:1');
  await reached(page, 1);
  await pause(page);
  const { field } = await fluidOf(page);
  assert.ok(valueAt(field, 0.5, 0.99) > 4 * valueAt(field, 0.5, 0.1), 'the lid is at the top');
  const [top, bottom] = await Promise.all(
    [0.98, 0.05].map(async (y) => {
      const { px, py } = await place(page, 0.5, y);
      return page.evaluate(
        ([x, v]) => {
          const c = /** @type {HTMLCanvasElement} */ (document.getElementById('fluid')),
            box = c.getBoundingClientRect(),
            ratio = c.width / box.width;
          return [...c.getContext('2d').getImageData(Math.round((x - box.left) * ratio), Math.round((v - box.top) * ratio), 1, 1).data];
        },
        [px, py],
      );
    }),
  );
  assert.ok(bottom[0] + bottom[1] + bottom[2] > 690, `at rest it looks like paper: ${bottom}`);
  assert.ok(top[0] + top[1] + top[2] < 420, `what is fast stands out: ${top}`);
  await close();
});

test('the colour maps are even: no step is larger than another by a third', () => {
  const lab = (packed) => {
    const [r, g, b] = [packed & 255, (packed >> 8) & 255, (packed >> 16) & 255].map((v) =>
      v / 255 <= 0.04045 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4,
    );
    const l = Math.cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b),
      m = Math.cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
    const s = Math.cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
    return [
      0.2104542553 * l + 0.793617785 * m - 0.0040720468 * s,
      1.9779984951 * l - 2.428592205 * m + 0.4505937099 * s,
      0.0259040371 * l + 0.7827717662 * m - 0.808675766 * s,
    ];
  };
  const ratios = [];
  for (const dark of [false, true]) {
    for (const map of Object.values(mapsOf(dark))) {
      const steps = [];
      for (let i = 0; i + 16 < map.length; i += 16) {
        /* colours of a screen are whole numbers: steps of sixteen */
        const from = lab(map[i]),
          to = lab(map[i + 16]);
        if (map.length === 255 && i < 127 && i + 16 > 127) continue; /* across the middle of a signed map the way turns */
        steps.push(Math.hypot(...from.map((v, k) => v - to[k])));
      }
      ratios.push(Math.max(...steps) / Math.min(...steps));
    }
  }
  assert.equal(ratios.length, 6);
  assert.ok(
    ratios.every((ratio) => ratio < 1.33),
    ratios.join(),
  );
});

test('the pressure solver changes live, and the remaining divergence shows it', async () => {
  const { page, complaints, close } = await open('?scenario=fluid/cavity');
  await reached(page, 0.2);
  await until(async () => (await shownValue(page, 'divergence_max')) < 1e-12, 'the direct solver leaves nothing');
  await page.locator('[data-path="solver.pressure"]').selectOption('jacobi');
  await page.locator('[data-path="solver.sweeps"]').fill('20');
  await page.locator('[data-path="solver.sweeps"]').blur();
  await page.waitForFunction(
    () => globalThis.laglab().params.solver.pressure === 'jacobi' && globalThis.laglab().params.solver.sweeps === 20,
  );
  await until(async () => (await shownValue(page, 'divergence_max')) > 1e-4, 'twenty sweeps of Jacobi leave much');
  await page.locator('[data-path="solver.sweeps"]').fill('0');
  await page.locator('[data-path="solver.sweeps"]').blur();
  await page.waitForFunction(() => /from 1 to/.test(document.querySelector('.note')?.textContent ?? ''));
  assert.equal((await paramsOf(page)).solver.sweeps, 20);
  assert.deepEqual(complaints, []);
  await close();
});

test('the advection scheme changes live', async () => {
  const { page, close } = await open('?scenario=fluid/rotation&set=params.n:48');
  await reached(page, 0.1);
  await page.locator('[data-path="solver.advection"]').selectOption('semi_lagrangian');
  await page.waitForFunction(() => globalThis.laglab().params.solver.advection === 'semi_lagrangian');
  const before = await shownValue(page, 'error_l1');
  await until(async () => (await shownValue(page, 'error_l1')) > before + 0.005, 'the disc is smeared');
  await close();
});

test('another scene or resolution creates a new session', async () => {
  const { page, close } = await open('#fluid');
  await page.waitForFunction(() => document.querySelectorAll('#scene option').length >= 4);
  await page.locator('#scene').selectOption('fluid/cavity');
  await page.waitForFunction(() => globalThis.laglab().params?.scene === 'cavity');
  await page.locator('[data-scene="n"]').fill('16');
  await page.locator('[data-scene="n"]').blur();
  await until(async () => (await fluidOf(page)).field?.width === 16, 'sixteen cells');
  assert.equal((await paramsOf(page)).params.re, 100);
  await close();
});

test('numbers are plotted over time, and which one can be chosen; a cavity has its profiles', async () => {
  const { page, close } = await open('?scenario=fluid/cavity');
  await reached(page, 0.5);
  const before = [await drawn(page, 'plot0'), await drawn(page, 'plot1')];
  await until(async () => (await drawn(page, 'plot0')) !== before[0] && (await drawn(page, 'plot1')) !== before[1], 'the plots go on');
  await page.waitForSelector('#profiles');
  await pause(page);
  const curves = await until(() => page.evaluate(() => globalThis.laglab().profiles?.[0]), 'the profiles are measured');
  assert.deepEqual(
    Object.entries(curves).map(([name, pairs]) => [name, pairs.length]),
    [
      ['u', 129],
      ['v', 129],
      ['u_reference', 17],
      ['v_reference', 17],
    ],
  );
  assert.deepEqual(curves.u_reference[8], [0.5, -0.209149]); /* the middle, by Richardson's extrapolation */
  const error = await drawn(page, 'plot0');
  await page.locator('select.plotted').first().selectOption({ value: 'energy' });
  await until(async () => (await drawn(page, 'plot0')) !== error, 'energy is plotted');
  await close();
});

test('the cost of a step is shown', async () => {
  const { page, close } = await open('?scenario=fluid/cavity');
  await page.waitForFunction(() => Number(document.getElementById('step-ms')?.textContent) > 0);
  await close();
});

/** Fluid at rest: all motion comes from the pointer. */
const REST = '?scenario=fluid/cylinder&set=shown:2&set=params.n:32';

test('particles are drawn where they are, coloured by speed', async () => {
  const { page, close } = await open('?scenario=fluid/dam_break', { reducedMotion: 'reduce' });
  await until(async () => (await fluidOf(page)).points[0]?.count === 512, 'a column of 16 x 32');
  assert.equal(await page.locator('#field').count(), 0);
  const start = await drawn(page);
  const opaqueAt = async (x, y) => {
    const { px, py } = await place(page, x, y);
    return page.evaluate(
      ([a, b]) => {
        const c = /** @type {HTMLCanvasElement} */ (document.getElementById('fluid')),
          box = c.getBoundingClientRect(),
          ratio = c.width / box.width;
        return [...c.getContext('2d').getImageData(Math.round((a - box.left) * ratio), Math.round((b - box.top) * ratio), 1, 1).data][3];
      },
      [px, py],
    );
  };
  assert.deepEqual([await opaqueAt(0.08, 0.3), await opaqueAt(0.6, 0.3)], [255, 0], 'water at the left, nothing at the right');
  await until(async () => {
    await page.keyboard.press('Period');
    return (await drawn(page)) !== start;
  }, 'they move');
  await close();
});

test('the mouse drags the fluid, and releases it', async () => {
  const { page, complaints, close } = await open(REST);
  await reached(page, 0.2);
  const calm = Math.abs(valueAt((await fluidOf(page)).field, 0.3, 0.8));
  const from = await place(page, 0.2, 0.8),
    to = await place(page, 0.4, 0.8);
  await page.mouse.move(from.px, from.py);
  await page.mouse.down();
  await until(async () => (await fluidOf(page)).state.held, 'a hand stirs');
  for (let i = 0; i < 6; i++) {
    await page.mouse.move(to.px, to.py, { steps: 6 });
    await page.mouse.move(from.px, from.py, { steps: 6 });
  }
  await until(async () => {
    const { field } = await fluidOf(page);
    return Math.max(...[0.74, 0.86].map((y) => Math.abs(valueAt(field, 0.3, y)))) > calm + 0.5;
  }, `vorticity where it was ${calm}`);
  await page.mouse.up();
  await until(async () => !(await fluidOf(page)).state.held, 'the hand lets go');
  assert.deepEqual(complaints, []);
  await close();
});

test('a finger drags the fluid', async () => {
  const { page, context, close } = await open(REST, { width: 390, height: 844, hasTouch: true, isMobile: true });
  await reached(page, 0.2);
  const client = await context.newCDPSession(page);
  const from = await place(page, 0.2, 0.8),
    to = await place(page, 0.5, 0.8);
  await client.send('Input.dispatchTouchEvent', { type: 'touchStart', touchPoints: [{ x: from.px, y: from.py }] });
  await until(async () => (await fluidOf(page)).state.held, 'a finger stirs');
  for (let i = 1; i <= 12; i++) {
    await client.send('Input.dispatchTouchEvent', {
      type: 'touchMove',
      touchPoints: [{ x: from.px + ((to.px - from.px) * i) / 12, y: from.py }],
    });
  }
  await client.send('Input.dispatchTouchEvent', { type: 'touchEnd', touchPoints: [] });
  await until(async () => !(await fluidOf(page)).state.held, 'the finger lets go');
  await close();
});

test('keys drag the fluid', async () => {
  const { page, complaints, close } = await open(REST);
  await reached(page, 0.2);
  await page.locator('.stir').focus();
  for (let i = 0; i < 15; i++) await page.keyboard.press('ArrowUp');
  const calm = (await fluidOf(page)).field;
  await page.keyboard.press('Enter');
  await until(async () => (await fluidOf(page)).state.held, 'the hand takes hold');
  for (let i = 0; i < 12; i++) await page.keyboard.press(i % 6 < 3 ? 'ArrowLeft' : 'ArrowRight');
  await until(async () => {
    const { field } = await fluidOf(page);
    return Math.abs(valueAt(field, 0.47, 0.86)) + Math.abs(valueAt(field, 0.47, 0.74)) > Math.abs(valueAt(calm, 0.47, 0.86)) + 0.2;
  }, 'vorticity on both sides');
  await page.keyboard.press('Escape');
  await until(async () => !(await fluidOf(page)).state.held, 'the hand lets go');
  await page.keyboard.press('Space');
  await page.waitForFunction(() => document.getElementById('chip')?.textContent?.includes('Paused'));
  assert.deepEqual(complaints, []);
  await close();
});

test('a fluid that blows up is shown as diverged', async () => {
  const { page, close } = await open('?scenario=fluid/taylor_green&set=solver.pressure:jacobi&set=solver.sweeps:5&set=solver.tolerance:0');
  await page.waitForFunction(() => /[Dd]iverged/.test(document.getElementById('fluid')?.getAttribute('aria-label') ?? ''));
  await reads(() => page.locator('#chip').textContent(), /[Ss]topped|[Ff]ailed/);
  await close();
});

test('two fluids go side by side: each has its own solver, cells, error and cost, and the pointer drags both', async () => {
  const { page, complaints, close } = await open('?scenario=fluid/cavity&set=duration_s:300');
  await page.locator('#count').selectOption({ label: 'two fluids' });
  await page.waitForSelector('#fluid1');
  await page.locator('[data-path="side_by_side.0.solver.pressure"]').selectOption('jacobi');
  await page.waitForFunction(() => globalThis.laglab().params.side_by_side?.[0].solver.pressure === 'jacobi');
  assert.equal((await paramsOf(page)).solver.pressure, 'direct');
  await page.waitForFunction(
    () =>
      /ms\/step/.test(document.querySelectorAll('.drawing figcaption')[1]?.textContent ?? '') &&
      Number(document.getElementById('step-ms1')?.textContent) > 0 &&
      document.querySelector('[data-error="1"]')?.textContent !== '–',
  );
  await settles(() => page.locator('.drawing b').allTextContents(), ['direct', 'jacobi']);
  await page.locator('[data-scene="1/n"]').fill('16');
  await page.locator('[data-scene="1/n"]').blur();
  await page.waitForFunction(() => globalThis.laglab().params?.side_by_side?.[0].params.n === 16);
  await page.waitForSelector('#fluid1');
  const width = async (/** @type {number} */ i) => (await fluidOf(page, i))?.field?.width;
  await settles(() => width(0), 32);
  await settles(() => width(1), 16);
  assert.equal((await paramsOf(page)).side_by_side[0].solver.pressure, 'jacobi', 'it keeps its solver');
  await page.reload();
  await page.waitForSelector('#fluid1');
  await settles(() => width(1), 16, 'the address keeps it');
  const box = await page.locator('#fluid1').boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 2 + 20, box.y + box.height / 2, { steps: 4 });
  await until(async () => (await fluidOf(page, 0)).state.held && (await fluidOf(page, 1)).state.held, 'both are dragged');
  await page.mouse.up();
  assert.deepEqual(complaints, []);
  await close();
});

test('particles, a grid and a sea go side by side, each dragged at the same share of its view', async () => {
  const { page, complaints, close } = await open(
    `?scenario=fluid/pool&set=${encodeURIComponent('side_by_side:[{"scene":"cylinder"},{"scene":"sea"}]')}`,
  );
  await page.waitForSelector('#fluid2');
  await reached(page, 0.5);
  await settles(() => page.locator('.methods small').allTextContents(), ['particles', 'grid', 'ocean']);
  const shown = await Promise.all([0, 1, 2].map((i) => drawn(page, i === 0 ? 'fluid' : `fluid${i}`)));
  assert.equal(new Set(shown).size, 3);
  await page.locator('[data-scene="2/scene"]').selectOption('dam_break');
  await page.waitForFunction(() => globalThis.laglab().params?.side_by_side?.[1].scene === 'dam_break');
  await page.locator('#count').selectOption({ label: 'one fluid' });
  await page.waitForFunction(() => globalThis.laglab().params?.side_by_side?.length === 0 && !document.getElementById('fluid1'));
  assert.deepEqual(complaints, []);
  await close();
});

test('10,000 particles are drawn as they come', async () => {
  const { page, close } = await open('?scenario=fluid/pool&set=params.size:400', { smooth: true });
  await page.waitForFunction(() => globalThis.laglab().counts.drawn > 8); /* few on a busy machine */
  assert.equal((await fluidOf(page)).points[0]?.count, 10000);
  const colours = await page.locator('#fluid').evaluate((c) => {
    const { width, height } = /** @type {HTMLCanvasElement} */ (c),
      copy = new OffscreenCanvas(width, height).getContext('2d');
    copy.drawImage(/** @type {HTMLCanvasElement} */ (c), 0, 0, width, height);
    const { data } = copy.getImageData(0, Math.round(0.1 * height), width, Math.round(0.7 * height)),
      blue = (/** @type {number} */ k) => data[k + 2] - data[k] > 60;
    return Array.from({ length: data.length / 4 }, (_, k) => 4 * k).filter(blue).length / (data.length / 4);
  });
  assert.ok(colours > 0.05, `water covers ${colours} of the view`);
  const { drawn: count, received } = await page.evaluate(() => globalThis.laglab().counts);
  assert.ok(count > 0.5 * received, `${count} of ${received} frames`);
  await close();
});

test('256 x 256 cells are drawn in a fraction of a display refresh', async () => {
  const { page, close } = await open('?scenario=fluid/cylinder&set=params.n:256', { reducedMotion: 'reduce' });
  const ms = await costOf(page, () =>
    until(async () => {
      /* a key that is pressed while a step is made goes for nothing */
      await page.keyboard.press('Period');
      return page.evaluate(() => globalThis.laglab().frame.tick >= 12);
    }, 'a dozen ticks'),
  );
  assert.ok(ms < 16, `${ms} ms`);
  assert.equal((await fluidOf(page)).field.bytes.length, 65536);
  await close();
});

for (const { name, width, height, query } of [...SIZES, { name: '320x640', width: 320, height: 640, query: '' }]) {
  sweep(width < 350 || width > 1300)(`without a complaint of axe, light and dark, and without sideways scrolling at ${name}`, async () => {
    const { page, complaints, close } = await open(`${query}${query ? '&' : '?'}scenario=fluid/cavity`, { width, height });
    await page.waitForSelector('#profiles');
    for (const colorScheme of /** @type {const} */ (['light', 'dark'])) {
      await page.emulateMedia({ colorScheme });
      await refreshes(page);
      assert.deepEqual(await axe(page, { colours: colorScheme === 'dark' }), [], colorScheme);
    }
    const box = await page.locator('#fluid').boundingBox();
    assert.ok(box && box.height > 180 && box.width > 180, JSON.stringify(box));
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth));
    assert.deepEqual(complaints, []);
    await close();
  });
}
