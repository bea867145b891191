// What a class does, in a browser as people have it: every lab opens and plays, a lesson, a class with a teacher and two students.
import assert from 'node:assert/strict';
import { mkdirSync, writeFileSync } from 'node:fs';
import { after, before, test } from 'node:test';
import { setTimeout as wait } from 'node:timers/promises';
import { startDaemon } from '../lib/daemon.mjs';
import { api } from '../page/lib.mjs';

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

/** Until the function gives a true value in the page, and gives it. @param {Visitor} visitor @param {Function | string} test_
 * @param {any} arg @param {string} what */
async function seen(visitor, test_, arg, what) {
  const end = Date.now() + LATE_MS;
  for (;;) {
    const value = await visitor.evaluate(test_, arg).catch((error) => {
      if (Date.now() > end) throw error;
      return null; /* the page is on its way to another */
    });
    if (value) return value;
    if (Date.now() > end) {
      const text = await visitor.evaluate(() => document.body.innerText.slice(0, 300)).catch(() => '');
      assert.fail(`not within ${LATE_MS} ms: ${what}; the page shows: ${text}; ${await visitor.complaints().catch(String)}`);
    }
    await wait(100);
  }
}

/** A button that is shown and can be used, by its name. @param {string} name */
const byName = (name) =>
  [...document.querySelectorAll('button')].find(
    (one) =>
      (one.getAttribute('aria-label') ?? one.textContent ?? '').replace(/\s+/g, ' ').trim() === name &&
      !one.disabled &&
      one.getClientRects().length > 0,
  ) ?? null;
/** @param {string} selector */
const bySelector = (selector) => document.querySelector(selector);

/** @param {Visitor} visitor @param {string} name */
async function push(visitor, name) {
  await seen(visitor, `(name) => (${byName})(name) !== null`, name, `the button ${name}`);
  await visitor.click(byName, name).catch(() => visitor.click(byName, name)); /* it was drawn again in between */
}
/** @param {Visitor} visitor @param {string} selector */
async function pushOn(visitor, selector) {
  await seen(visitor, (/** @type {string} */ at) => document.querySelector(at) !== null, selector, selector);
  await visitor.click(bySelector, selector);
}
/** @param {Visitor} visitor @param {string} selector */
const there = (visitor, selector) =>
  seen(visitor, (/** @type {string} */ at) => (document.querySelector(at)?.getClientRects().length ?? 0) > 0, selector, selector);
/** @param {Visitor} visitor @param {string} text */
const says = (visitor, text) => seen(visitor, (/** @type {string} */ one) => document.body.innerText.includes(one), text, `“${text}”`);
/** @param {Visitor} visitor */
const framed = (visitor) => seen(visitor, () => (globalThis.laglab?.().frame ?? null) !== null, null, 'a frame');

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

/** @param {Visitor[]} visitors */
async function quiet(...visitors) {
  for (const { complaints } of visitors) assert.deepEqual(await complaints(), []);
}

/** @param {() => Promise<import('./browsers.mjs').Browser>} launch @param {string} missing what is not installed; empty: nothing */
export function journeys(launch, missing = '') {
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

  test('a lesson: a question is chosen, answered, run to its stop, explained', { skip }, async () => {
    const visitor = await browser.visit(daemon.url, LAPTOP);
    await pushOn(visitor, '.card');
    await there(visitor, '#rail .steps');
    await framed(visitor);
    await visitor.press('2');
    await seen(visitor, () => document.querySelectorAll('.option input:checked').length === 1, null, 'a choice');
    await pushOn(visitor, '#lock-in');
    const current = (/** @type {string} */ name) =>
      seen(
        visitor,
        (/** @type {string} */ one) => document.querySelector('.steps [aria-current="step"]')?.textContent?.includes(one),
        name,
        name,
      );
    await current('Observe');
    await seen(visitor, () => globalThis.laglab().frame?.tick === 22, null, 'the stop');
    await shot(visitor, `${browser.name}-lesson`);
    await pushOn(visitor, '#rail .main');
    await current('Explain');
    await seen(visitor, () => Number.parseFloat(document.querySelector('#answer')?.textContent ?? '') > 100, null, 'the answer');
    await quiet(visitor);
    await visitor.close();
  });

  test('a class: two students race from two devices, vote, and are frozen', { skip }, async () => {
    const teacher = await browser.visit(
      `${daemon.url}?scenario=race&set=duration_s:600&set=players.0.script:idle&set=players.1.script:idle`,
      LAPTOP,
    );
    await framed(teacher);
    await push(teacher, 'Class');
    await seen(teacher, () => /^#class=\w{4}$/.test(location.hash), null, 'a code');
    const code = String(await teacher.evaluate(() => location.hash.slice(7)));
    const { id } = (await api(daemon.url, `classes/${code}`)).body;
    const state = async () => (await api(daemon.url, `classes/${id}`)).body.state;
    const [a, b] = await Promise.all([
      browser.visit(`${daemon.url}${code.toLowerCase()}`, PHONE),
      browser.visit(`${daemon.url}${code}`, LAPTOP),
    ]);
    await push(a, 'Play A');
    await framed(a);
    await push(b, 'Play B');
    await framed(b);
    assert.deepEqual(
      (await state()).seats.map((/** @type {any} */ seat) => seat.state),
      ['held', 'held'],
    );
    await push(teacher, 'Predict');
    for (const one of [a, b]) {
      await there(one, '.answer');
      await one.press('2');
      await says(one, 'Sent: Choice 2');
    }
    await push(teacher, 'Lock');
    for (const one of [teacher, a, b]) await says(one, '2 of 2 chose Choice 2.');
    await push(teacher, 'Run');
    for (const [one, player] of /** @type {[Visitor, number][]} */ ([
      [a, 0],
      [b, 1],
    ])) {
      await seen(one, () => (globalThis.laglab().frame?.flags & 2) !== 0, null, 'it plays');
      await one.evaluate(
        (/** @type {number} */ p) => /** @type {HTMLElement} */ (document.querySelector(`.view[data-drive="${p}"]`)).focus(),
        player,
      );
      await one.down('ArrowRight');
      await seen(
        teacher,
        (/** @type {number} */ p) =>
          globalThis
            .laglab()
            .frame?.plain()
            .entities.filter((/** @type {any} */ e) => e.view === 0)[p]?.vx > 0.5,
        player,
        `player ${player} drives`,
      );
      await one.up('ArrowRight');
    }
    await shot(a, `${browser.name}-class-a`);
    await push(teacher, 'Freeze all');
    for (const one of [a, b]) await says(one, 'The teacher has stopped all pages');
    await push(teacher, 'Unfreeze');
    for (const one of [a, b])
      await seen(one, () => !document.body.innerText.includes('The teacher has stopped all pages'), null, 'it goes on');
    await push(teacher, 'End the class');
    await push(teacher, 'End it for all');
    await says(a, 'Another class has another code');
    await quiet(teacher, a, b);
    for (const one of [teacher, a, b]) await one.close();
  });
}
