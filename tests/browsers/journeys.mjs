// In a browser as people have it: every lab opens and plays, and what a visitor, a teacher and two students do.
import assert from 'node:assert/strict';
import { mkdirSync, writeFileSync } from 'node:fs';
import { after, before, test } from 'node:test';
import { setTimeout as wait } from 'node:timers/promises';
import { startDaemon } from '../lib/daemon.mjs';
import { firstClass, firstVisit, framed, pushOn, quiet, seen, there } from './people.mjs';

/** @typedef {import('./browsers.mjs').Visitor} Visitor */

const LAPTOP = { width: 1366, height: 768 },
  PHONE = { width: 500, height: 844 };
const LATE_MS = 120000; /* ends what hangs */
const SHOTS = process.env.LAGLAB_SHOTS ?? ''; // a folder for images of the page
if (SHOTS) mkdirSync(SHOTS, { recursive: true });

/** Each with the canvases of its views and those of its charts; of the charts, uPlot's are made when the first is drawn. */
const LABS = [
  { at: '#race', views: 'canvas[data-view]', charts: '#error-chart canvas, #buffer-chart canvas', count: 2 },
  { at: '#cannon', views: 'canvas[data-view]', charts: '#error-chart canvas, #buffer-chart canvas', count: 2 },
  { at: '?scenario=rifle', views: 'canvas[data-view]', charts: '#error-chart canvas, #buffer-chart canvas', count: 2 },
  { at: '?scenario=crates', views: 'canvas[data-view]', charts: '#error-chart canvas, #buffer-chart canvas', count: 2 },
  { at: '?scenario=motion/pendulum', views: '#motion', charts: '#plot-value, #plot-error, #plot-energy', count: 3 },
  { at: '?scenario=rigid/collapsing_stack', views: '#world0', charts: '#plot-energy, #plot-overlap', count: 2 },
  { at: '?scenario=fluid/cylinder', views: '#fluid', charts: '#plot0, #plot1', count: 2 },
];

/** What canvases show: how many, how many colours the dullest has, and a sum that differs when a pixel does. @param {string} selector */
const painted = (selector) => {
  const all = [...document.querySelectorAll(selector)].map((one) => {
    const canvas = /** @type {HTMLCanvasElement} */ (one),
      copy = document.createElement('canvas');
    copy.width = canvas.width;
    copy.height = canvas.height;
    if (copy.width === 0 || copy.height === 0) return { colours: 0, sum: 0 };
    const pen = /** @type {CanvasRenderingContext2D} */ (copy.getContext('2d'));
    pen.drawImage(canvas, 0, 0);
    const pixels = new Uint32Array(pen.getImageData(0, 0, copy.width, copy.height).data.buffer);
    let sum = 0;
    const colours = new Set();
    for (let i = 0; i < pixels.length; i++) {
      sum = (Math.imul(sum, 31) + (pixels[i] ?? 0)) | 0;
      if (i % 3 === 0) colours.add(pixels[i]);
    }
    return { colours: colours.size, sum };
  });
  return { count: all.length, colours: Math.min(...all.map((one) => one.colours)), sums: all.map((one) => one.sum).join() };
};

/** @param {Visitor} visitor @param {string} name */
async function shot(visitor, name) {
  if (SHOTS) writeFileSync(`${SHOTS}/${name}.png`, await visitor.screenshot());
}

/** @param {() => Promise<import('./browsers.mjs').Browser>} launch @param {{size: {width: number, height: number}, lang: string}} visitor's
 * @param {string} missing what is not installed; empty: nothing */
export function journeys(launch, { size, lang }, missing = '') {
  const skip = missing === '' ? false : `not installed: ${missing}`;
  /** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
  /** @type {import('./browsers.mjs').Browser} */ let browser;
  before(async () => {
    if (skip) return;
    [daemon, browser] = await Promise.all([startDaemon(), launch()]);
  });
  after(async () => {
    await browser?.close();
    await daemon?.stop();
  });

  for (const { at, views, charts, count } of LABS)
    test(`${at} opens and plays: its views move, its charts appear and move`, { skip }, async () => {
      const visitor = await browser.visit(daemon.url + at, LAPTOP);
      await framed(visitor);
      await seen(visitor, () => globalThis.laglab().frame?.tick > 20, null, 'ticks');
      const look = (/** @type {string} */ selector) => visitor.evaluate(painted, selector);
      for (const [what, selector, least] of /** @type {[string, string, number][]} */ ([
        ['views', views, 1],
        ['charts', charts, count],
      ])) {
        const now = await seen(
          visitor,
          `([selector, least]) => {
            const now = (${painted})(selector);
            return now.count >= least && now.colours > 3 && now;
          }`,
          [selector, least],
          `${what}, ${selector}, are drawn`,
        );
        const end = Date.now() + LATE_MS;
        while ((await look(selector)).sums === now.sums && Date.now() < end) await wait(100);
        assert.notEqual((await look(selector)).sums, now.sums, `${what} move`);
      }
      await shot(visitor, `${browser.name}-${at.replace(/\W+/g, '-')}`);
      await quiet(visitor);
      await visitor.close();
    });

  test('an experiment is run, and its points are drawn', { skip }, async () => {
    const visitor = await browser.visit(`${daemon.url}#experiments`, LAPTOP);
    await seen(visitor, () => document.querySelector('#run') !== null && !document.querySelector('#run:disabled'), null, 'a form');
    await pushOn(visitor, '#run');
    await there(visitor, '[data-state="done"]');
    await seen(visitor, `() => (${painted})('#chart-0').colours > 3`, null, 'points');
    await shot(visitor, `${browser.name}-experiments`);
    await quiet(visitor);
    await visitor.close();
  });

  test('a visitor drives, undoes the lag, and answers the question to which that leads', { skip }, async (t) => {
    const me = await firstVisit((at) => browser.visit(daemon.url + at, size), lang);
    t.diagnostic(me.notes.join('; '));
    await shot(me, `${browser.name}-visitor`);
    await quiet(me);
    await me.close();
  });

  test('a class from the first page: two students vote, read why, and drive', { skip }, async (t) => {
    const on = (/** @type {any} */ one) => (/** @type {string} */ at) => browser.visit(daemon.url + at, one);
    const people = await firstClass(on(LAPTOP), [on(PHONE), on(LAPTOP)], lang);
    for (const me of people) t.diagnostic(me.notes.join('; '));
    await quiet(...people);
    for (const me of people) await me.close();
  });
}
