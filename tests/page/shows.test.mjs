// The difference that a sentence names is seen: at the instant at which a step stops, the two things that it compares are in the view, and
// far enough apart on every screen. Measured from what was drawn. LAGLAB_SHOWS=record writes what was measured to bench/results/shows.csv.
import assert from 'node:assert/strict';
import { existsSync, readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { after, before } from 'node:test';
import { fileURLToPath } from 'node:url';
import { filled, lessonIds } from '../../docs/lessons.mjs';
import { startDaemon } from '../lib/daemon.mjs';
import { launch, refreshes, tickOf, until, visit } from './lib.mjs';
import { sweep, test } from './tiers.mjs';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
const TABLE = path.join(ROOT, 'bench/results/shows.csv');
const HEAD = 'lesson,step,screen,view,from,to,px,percent';
const lessonOf = (/** @type {string} */ id) => JSON.parse(readFileSync(path.join(ROOT, `www/lessons/${id}.json`), 'utf8'));
const SCREENS = ['390x844', '820x1180', '1366x768', '1920x1080'];
const LEAST_PX = 40,
  LEAST_PERCENT = 3;
const STEPS = { observe: 3, change: 5 };

/** Of the default tier. */
const SOME = ['late_answer'];

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

/** A lesson at the stop of a step. @param {string} id @param {'observe' | 'change'} step */
async function stopped(id, step) {
  const visited = await visit(browser, `${daemon.url}#lesson=${id}&step=${STEPS[step]}&lang=en`, { wait: false, reducedMotion: 'reduce' });
  const { page } = visited,
    lesson = lessonOf(id);
  await until(() => page.evaluate(() => globalThis.laglab?.().frame?.tick !== undefined), `${id} is there`);
  if (step === 'change') {
    await page.locator('#rail .main').click();
    await until(
      () => page.evaluate(() => (globalThis.laglab().frame?.tick ?? 0) > 0),
      `${id} has run with the change`,
    ); /* another session */
  } else await until(async () => (await tickOf(page)) === lesson.stop_tick, `${id} stands at its stop`);
  return { ...visited, lesson };
}

/** What is wrong with what a step shows on a screen; empty where nothing is. @param {any} seen @param {any} lesson @param {string} step */
function wrong(seen, lesson, step) {
  const { number, label } = lesson.shows[step];
  if (seen === null) return 'its places are not drawn';
  if (!seen.seen || !seen.inside) return `one of its places is outside of the view: ${JSON.stringify(seen)}`;
  if (seen.px < LEAST_PX || seen.percent < LEAST_PERCENT) return `${seen.px.toFixed(1)} px, ${seen.percent.toFixed(1)} %`;
  if (label && seen.label !== filled(lesson, label.en, 'en').replace(/-(?=\d)/g, '−')) return `its label is ${seen.label}`;
  if (number === undefined) return '';
  const { value, digits } = lesson.numbers[number];
  return Number(seen.value.toFixed(digits)) === Math.abs(value) ? '' : `${seen.value} apart in the drawing, ${value} in the sentence`;
}

/** @param {string} id @param {'observe' | 'change'} step @returns {Promise<{problems: string[], rows: string[]}>} */
async function measured(id, step) {
  const problems = [],
    rows = [];
  const { page, lesson, close } = await stopped(id, step);
  for (const screen of SCREENS) {
    const [width, height] = /** @type {[number, number]} */ (/** @type {unknown} */ (screen.split('x').map(Number)));
    await page.setViewportSize({ width, height });
    await refreshes(page, 30);
    await page.evaluate(
      (view) => (document.getElementById(view) ?? document.getElementById('views'))?.scrollIntoView({ block: 'center' }),
      lesson.shows[step].view,
    );
    const read = () => page.evaluate(() => globalThis.laglab.shown());
    let seen = await read();
    for (let tries = 0; tries < 10 && wrong(seen, lesson, step) !== ''; tries++) {
      await refreshes(page, 15);
      seen = await read();
    }
    const problem = wrong(seen, lesson, step);
    if (problem !== '') problems.push(`${screen}: ${problem}`);
    else rows.push([id, step, screen, seen.view, seen.from, seen.to, Math.round(seen.px), seen.percent.toFixed(1)].join(','));
  }
  await close();
  return { problems, rows };
}

/** What the card of a question compares, as it stands still; `top`: their upper ends. @type {Record<string, [string, string, 'top'?]>} */
const CARDS = {
  late_answer: ['[data-part="ghost"]', '[data-part="a"]'],
  jump_back: ['[data-part="rest"]', '[data-part="a"]'],
  in_the_past: ['[data-part="ghost"]', '[data-part="b"]'],
  who_waits: ['[data-part="a"]', '[data-part="c"]'],
  behind_wall: ['[data-part="seen"]', '[data-part="a"]'],
  keeps_energy: ['.left', '.right', 'top'],
  bullet_through: ['.ghost', '[data-part="ball"]'],
  falling_stack: ['.c', '.d'],
  how_many_sweeps: ['.c', '.d'],
  what_a_cheat_gains: ['[data-part="ghost"]', '[data-part="a"]'],
};

/** How far apart two parts of a card are. @param {import('playwright-core').Page} page @param {string} id */
const apart = (page, id) =>
  page.locator(`[data-card="${id}"] .sketch`).evaluate((sketch, [a = '', b = '', upper = '']) => {
    const [one, other] = [a, b].map((which) => sketch.querySelector(which)?.getBoundingClientRect()),
      box = sketch.getBoundingClientRect();
    if (!one || !other) return { px: 0, of: 1 };
    if (upper !== '') return { px: Math.abs(one.top - other.top), of: box.height };
    const dx = Math.abs(one.left + one.right - other.left - other.right) / 2,
      dy = Math.abs(one.top + one.bottom - other.top - other.bottom) / 2;
    return dx > dy ? { px: dx, of: box.width } : { px: dy, of: box.height };
  }, CARDS[id] ?? []);

test('what the card of each question compares is 40 px apart on every screen', async () => {
  const rows = [],
    problems = [];
  for (const screen of SCREENS) {
    const [width, height] = /** @type {[number, number]} */ (/** @type {unknown} */ (screen.split('x').map(Number)));
    const { page, close } = await visit(browser, `${daemon.url}#questions&lang=en`, {
      wait: false,
      reducedMotion: 'reduce',
      viewport: { width, height },
    });
    await page.locator('[data-card="what_a_cheat_gains"] .sketch').waitFor();
    assert.equal(await page.locator('.cards [data-card]').count(), Object.keys(CARDS).length);
    for (const [id, ends] of Object.entries(CARDS)) {
      const { px, of } = await apart(page, id),
        percent = (100 * px) / of;
      if (px < LEAST_PX || percent < LEAST_PERCENT) problems.push(`${id} at ${screen}: ${px.toFixed(1)} px`);
      const names = ends.slice(0, 2).map((which) => which?.replace(/\[data-part="(.*)"\]/, '$1').replace('.', ''));
      rows.push([id, 'card', screen, 'card', ...names, Math.round(px), percent.toFixed(1)].join(','));
    }
    await close();
  }
  assert.deepEqual(problems, []);
  if (process.env.LAGLAB_SHOWS === 'record') for (const id of Object.keys(CARDS)) write(id, 'card', rows);
});

/** Rows of the table, but of a lesson's step. @param {string} id @param {string} step */
const others = (id, step) =>
  (existsSync(TABLE) ? readFileSync(TABLE, 'utf8').trim().split('\n').slice(1) : []).filter((row) => !row.startsWith(`${id},${step},`));

/** Rows of a step in place of those before. @param {string} id @param {string} step @param {string[]} rows */
function write(id, step, rows) {
  const order = lessonIds();
  const all = [...others(id, step), ...rows.filter((row) => row.startsWith(`${id},${step},`))].sort(
    (a, b) => order.indexOf(a.split(',')[0] ?? '') - order.indexOf(b.split(',')[0] ?? ''),
  );
  writeFileSync(TABLE, `${[HEAD, ...all].join('\n')}\n`);
}

for (const id of lessonIds())
  for (const step of /** @type {('observe' | 'change')[]} */ (['observe', 'change']))
    sweep(SOME.includes(id))(`${id}, ${step}: what its sentence names is seen on every screen`, async () => {
      const { problems, rows } = await measured(id, step);
      assert.deepEqual(problems, []);
      if (process.env.LAGLAB_SHOWS !== 'record') return;
      write(id, step, rows);
    });

test('the table has both steps of every lesson and every card, on every screen', () => {
  const has = existsSync(TABLE) ? readFileSync(TABLE, 'utf8').trim().split('\n') : [];
  const wanted = lessonIds().flatMap((id) =>
    [...Object.keys(STEPS), ...(id in CARDS ? ['card'] : [])].flatMap((step) => SCREENS.map((screen) => `${id},${step},${screen}`)),
  );
  assert.deepEqual(
    has
      .slice(1)
      .map((row) => row.split(',').slice(0, 3).join())
      .sort(),
    wanted.sort(),
  );
});
