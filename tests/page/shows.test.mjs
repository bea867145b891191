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

/** Lessons of which a step does not yet show what it says. */
const OPEN = new Set(['figure_10 observe', 'figure_10 change', 'straight_shell observe', 'straight_shell change']);
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
    await until(async () => (await tickOf(page)) > 0, `${id} has run with the change`);
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
  if (!lessonOf(id).shows?.[step]) return { problems: ['it has no shows'], rows };
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

/** Rows of the table, but of a lesson's step. @param {string} id @param {string} step */
const others = (id, step) =>
  (existsSync(TABLE) ? readFileSync(TABLE, 'utf8').trim().split('\n').slice(1) : []).filter((row) => !row.startsWith(`${id},${step},`));

for (const id of lessonIds())
  for (const step of /** @type {('observe' | 'change')[]} */ (['observe', 'change']))
    sweep(SOME.includes(id))(`${id}, ${step}: what its sentence names is seen on every screen`, async () => {
      const { problems, rows } = await measured(id, step);
      if (OPEN.has(`${id} ${step}`)) return assert.notDeepEqual(problems, [], 'it is done: take it out of the list');
      assert.deepEqual(problems, []);
      if (process.env.LAGLAB_SHOWS !== 'record') return;
      const order = lessonIds();
      const all = [...others(id, step), ...rows].sort(
        (a, b) => order.indexOf(a.split(',')[0] ?? '') - order.indexOf(b.split(',')[0] ?? ''),
      );
      writeFileSync(TABLE, `${[HEAD, ...all].join('\n')}\n`);
    });

test('the table has every step that is done, on every screen', () => {
  const has = existsSync(TABLE) ? readFileSync(TABLE, 'utf8').trim().split('\n') : [];
  const wanted = lessonIds().flatMap((id) =>
    Object.keys(STEPS).flatMap((step) => (OPEN.has(`${id} ${step}`) ? [] : SCREENS.map((screen) => `${id},${step},${screen}`))),
  );
  assert.deepEqual(
    has
      .slice(1)
      .map((row) => row.split(',').slice(0, 3).join())
      .sort(),
    wanted.sort(),
  );
});
