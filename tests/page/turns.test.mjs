// Where a frame has no time for all: the panels next to the views take turns, and what is behind is shown when no frame follows.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { EVENTS_TYPE } from '../../www/js/stream/names.js';
import { startDaemon } from '../lib/daemon.mjs';
import { frameOf, launch, pause, runOn, settles, until, visit } from './lib.mjs';

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

/** Makes the view take long, and notes at which frame each canvas is drawn: its tick, and its place in the order of the frames. A canvas of
 * a chart has the name of its box. @param {import('playwright-core').Page} page @param {string} view a selector @param {number} ms */
const slowDown = (page, view, ms) =>
  page.evaluate(
    ([selector, wait]) => {
      const own = CanvasRenderingContext2D.prototype.clearRect,
        drawn = /** @type {Record<string, {n: number, tick: number}[]>} */ ({});
      let frames = 0;
      CanvasRenderingContext2D.prototype.clearRect = function (x, y, w, h) {
        own.call(this, x, y, w, h);
        if (this.canvas.matches(selector)) {
          frames++;
          for (const end = performance.now() + wait; performance.now() < end; );
          return;
        }
        const name = this.canvas.id || this.canvas.closest('[id]')?.id || '';
        if (this.canvas.dataset.view !== undefined || name === '') return;
        drawn[name] ??= [];
        drawn[name].push({ n: frames, tick: globalThis.laglab().frame.tick });
      };
      globalThis.drawn = () => ({ frames, drawn });
    },
    /** @type {const} */ ([view, ms]),
  );
/** @returns {Promise<{frames: number, drawn: Record<string, {n: number, tick: number}[]>}>} */
const drawnOf = (page) => page.evaluate(() => globalThis.drawn());

/** Of each panel the tick that it shows. */
const shownBy = async (page, panels) => {
  const { drawn } = await drawnOf(page);
  return panels.map((name) => drawn[name]?.at(-1)?.tick);
};

const LABS = [
  {
    at: '?scenario=motion/two_orbits&set=duration_s:600',
    view: '#motion',
    panels: ['plot-value', 'plot-error', 'plot-energy', 'plot-phase'],
    ms: 140 /* each panel may wait 400 ms, fewer than four frames then: the first three could take all turns */,
    frames: 36,
  },
  {
    at: '?scenario=race&set=duration_s:600',
    view: 'canvas[data-view="0"]',
    panels: ['lane', 'error-chart', 'buffer-chart'],
    ms: 12,
    frames: 120,
  },
];

/** Opens a lab whose views take long, with all its panels on the screen. @param {typeof LABS[number]} lab @param {string} url */
async function open({ at, view, panels, ms }, url) {
  const opened = await visit(browser, `${url}${at}`, { height: 2400 }),
    { page } = opened;
  for (const name of panels) await page.locator(`canvas#${name}, #${name} canvas`).first().waitFor();
  await runOn(page, 0.8); // all is read
  await slowDown(page, view, ms);
  return opened;
}

for (const lab of LABS) {
  const { at, panels, frames } = lab;
  test(`${at}: panels without time take turns, and show the last frame in a pause`, async () => {
    const { page, complaints, close } = await open(lab, daemon.url);
    await until(async () => (await drawnOf(page)).frames >= frames, `${frames} frames`);
    const { drawn, frames: all } = await drawnOf(page);
    const inFrame = new Map();
    for (const name of panels) {
      const list = (drawn[name] ?? []).map(({ n }) => n),
        gaps = [...list, all].map((n, i) => n - (list[i - 1] ?? 0));
      const most = Math.max(...gaps);
      assert.ok(list.length >= 3 && most <= frames / 3, `${name}: drawn ${list.length} times in ${all} frames, ${most} apart`);
      for (const n of new Set(list)) inFrame.set(n, (inFrame.get(n) ?? 0) + 1);
    }
    const crowded = [...inFrame.values()].filter((n) => n > 1).length;
    assert.ok(10 * crowded <= all, `${crowded} frames of ${all} drew more than one panel`); // a frame after a stall draws all
    await pause(page);
    const { tick } = await frameOf(page);
    await settles(() => shownBy(page, panels), Array(panels.length).fill(tick));
    assert.deepEqual(complaints, []);
    await close();
  });

  test(`${at}: panels show the last frame when no other comes, and when the connection is lost`, async () => {
    const own = await startDaemon();
    const { page, close } = await open(lab, own.url);
    const allShow = async () => {
      const { tick } = await frameOf(page);
      return (await shownBy(page, panels)).every((shown) => shown === tick);
    };
    await until(async () => (await drawnOf(page)).frames >= frames / 3, 'some frames');
    process.kill(own.pid, 'SIGSTOP'); // the page is not notified
    await settles(allShow, true);
    if (panels.includes('lane')) {
      const { tick } = await frameOf(page);
      await settles(async () => (await page.locator('#facts').innerText()).startsWith(`tick ${tick} `), true);
    }
    await own.kill();
    await until(async () => (await page.evaluate(() => globalThis.laglab().connection.state)) === 'lost', 'it is lost');
    await settles(allShow, true);
    await own.stop();
    await close();
  });
}

const LEFT = 54,
  RIGHT = 12; /* of the lane: names, and room at the end */

test('a click on the messages selects the input that is drawn there, though the views are newer', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}?scenario=race&set=duration_s:600`, { height: 1200 });
  await runOn(page, 1.2);
  await slowDown(page, 'canvas[data-view="0"]', 12);
  const { number, newer } = await page.evaluate(
    ([left, right, INPUT]) =>
      /** @type {Promise<{number: number, newer: number}>} */ (
        new Promise((done, fail) => {
          setTimeout(() => fail(new Error(`no input among ${lines.length} lines`)), 100000);
          const lane = /** @type {HTMLCanvasElement} */ (document.getElementById('lane'));
          const { clearRect, moveTo, lineTo } = CanvasRenderingContext2D.prototype;
          let time = 0,
            from = [0, 0];
          /** @type {number[][]} */
          let lines = [];
          Object.assign(CanvasRenderingContext2D.prototype, {
            /** @this {CanvasRenderingContext2D} @param {number[]} box */
            clearRect(...box) {
              if (this.canvas === lane) {
                time = globalThis.laglab().frame.time_s;
                lines = [];
              }
              return clearRect.apply(this, box);
            },
            /** @this {CanvasRenderingContext2D} @param {number} x @param {number} y */
            moveTo(x, y) {
              from = [x, y];
              return moveTo.call(this, x, y);
            },
            /** @this {CanvasRenderingContext2D} @param {number} x @param {number} y */
            lineTo(x, y) {
              if (this.canvas === lane) lines.push([...from, x, y]);
              return lineTo.call(this, x, y);
            },
          });
          const timer = setInterval(() => {
            const { frame } = globalThis.laglab();
            const span = Math.max(0.4, ...frame.views.slice(1).map(({ lag_ms: lag }) => (3 * lag) / 1000)),
              scale = (lane.clientWidth - left - right) / span;
            const ahead = (frame.time_s - time) * scale;
            if (time === 0 || ahead < 40) return; // more than a click may miss by
            for (const { type, player, number: n, begin_s: begin } of globalThis.laglab().messages) {
              const x = left + ((begin - time) * scale + span * scale);
              const line = lines.find(([x0, y0, , y1]) => Math.abs(x0 - x) < 0.01 && y1 > y0 + 20);
              if (type !== INPUT || player !== 0 || line === undefined || x < left + 100 || x > lane.clientWidth - 200) continue;
              clearInterval(timer);
              const { left: boxX, top: boxY } = lane.getBoundingClientRect();
              const at = { clientX: boxX + (line[0] + line[2]) / 2, clientY: boxY + (line[1] + line[3]) / 2 };
              lane.dispatchEvent(new MouseEvent('click', { bubbles: true, ...at }));
              done({ number: n, newer: ahead });
              return;
            }
          }, 2);
        })
      ),
    /** @type {const} */ ([LEFT, RIGHT, EVENTS_TYPE.input]),
  );
  await until(async () => /Input \d+ of A/.test(await page.locator('#lane-facts').innerText()), `a selection; ${newer} px newer`);
  assert.equal(/Input (\d+) of A/.exec(await page.locator('#lane-facts').innerText())?.[1], String(number), `${newer} px newer`);
  assert.deepEqual(complaints, []);
  await close();
});
