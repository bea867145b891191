// The finished experiments that the Experiments view opens on: their points are the engine's, their sentences and marks are those of the
// points, and one click runs them again.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, before, test } from 'node:test';
import { FINISHED } from '../../docs/finished.mjs';
import { startDaemon } from '../lib/daemon.mjs';
import { api, axe, launch, reads, sessionOf, settles, until, visit } from './lib.mjs';

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

/** @type {{id: string, at: number, experiment: any, points: any[]}[]} */
const SHIPPED = JSON.parse(readFileSync(FINISHED, 'utf8'));
const QUESTIONS = SHIPPED.map(({ id }) => id);
const EMPTY = /no runs yet|not measured|all is 0|events missing|noch kein lauf|nicht gemessen|alles ist 0|ereignisse fehlen/i;

/** Runs one and gives its points. @param {any} experiment */
async function run(experiment) {
  const made = await api(daemon.url, 'experiments', experiment);
  assert.equal(made.status, 202, JSON.stringify(made.body));
  await until(async () => (await api(daemon.url, `experiments/${made.body.id}`)).body.state === 'done', 'its end');
  return (await api(daemon.url, `experiments/${made.body.id}/results?points=true&format=json`)).body;
}

/** @param {string} [id] @param {any} [wish] */
async function open(id = '', wish = {}) {
  const visited = await visit(browser, `${daemon.url}${wish.query ?? ''}#experiments${id && `=${id}`}`, { ...wish, wait: false });
  await visited.page.locator('#run:not([disabled])').waitFor();
  await visited.page.locator('#chart-1[data-mark]').waitFor();
  return visited;
}

/** A straight line by least squares. @param {[number, number][]} points */
function fit(points) {
  const n = points.length,
    x = points.reduce((sum, [a]) => sum + a, 0) / n,
    y = points.reduce((sum, [, b]) => sum + b, 0) / n;
  const slope = points.reduce((sum, [a, b]) => sum + (a - x) * (b - y), 0) / points.reduce((sum, [a]) => sum + (a - x) ** 2, 0);
  return { slope, start: y - slope * x };
}

/** One line of the points: what is compared has this value.
 * @param {(typeof SHIPPED)[number]} of @param {boolean} on @param {number} k metric */
const line = ({ experiment, points }, on, k) =>
  points
    .filter((row) => row[experiment.axes[1].path] === on)
    .map((row) => /** @type {[number, number]} */ ([row[experiment.axes[0].path], row[experiment.metrics[k]]]));
const at = (/** @type {[number, number][]} */ points, /** @type {number} */ x) => points.find(([a]) => a === x)?.[1] ?? NaN;

for (const shipped of SHIPPED)
  test(`the points of ${shipped.id} are those of this daemon, and nothing in them is constant`, async () => {
    const { experiment, points } = shipped;
    assert.deepEqual(await run(experiment), points, 'node docs/finished.mjs writes them');
    for (const metric of experiment.metrics) {
      assert.ok(new Set(points.map((row) => row[metric])).size > 2, metric);
      assert.ok(
        points.some((row) => row[`${metric}.ci95_low`] < row[`${metric}.ci95_high`]),
        `${metric} has intervals`,
      );
    }
  });

test('it opens on prediction off and on over lag: title, sentences and marks have the numbers of the points', async () => {
  const [lag] = SHIPPED,
    own = fit(line(lag, false, 0)),
    others = fit(line(lag, true, 1)),
    saved = at(line(lag, false, 0), lag.at) - at(line(lag, true, 0), lag.at);
  const { page, complaints, close } = await open();
  assert.equal(await page.locator('h1#headline').innerText(), 'Prediction cures your own car, not the others.');
  const seen = (await page.locator('#seen').innerText()).replace(/\s+/g, ' ');
  assert.ok(Math.abs(own.slope - 2) < 0.1 && /needs twice the lag/.test(seen), `${own.slope}: ${seen}`);
  assert.equal(/about (\d+) ms more/.exec(seen)?.[1], String(5 * Math.round(own.start / 5)));
  assert.ok(100 * others.slope < 1 && 100 * others.slope >= 0.88 && /almost 1 m for every 100 ms/.test(seen), `${others.slope}: ${seen}`);
  assert.match(await page.locator('#alive h2').innerText(), /^At 300 ms$/);
  assert.deepEqual(
    await page.locator('canvas[data-x]').evaluateAll((all) => all.map((one) => [one.dataset.x, one.dataset.y])),
    lag.experiment.metrics.map((/** @type {string} */ metric) => [lag.experiment.axes[0].path, metric]),
    'what is varied lies across',
  );
  // What the chart is called in a file is what it shows; the mark is as long as its number.
  const drawn = await page.evaluate(() => {
    const canvas = /** @type {HTMLCanvasElement} */ (document.querySelector('#chart-0'));
    return { mark: canvas.dataset.mark?.split(' ').map(Number), says: canvas.dataset.says };
  });
  assert.equal(drawn.says, `${Math.round(saved)} ms saved at 300 ms`);
  const sentence = (
    await page
      .locator('.clauses')
      .evaluate((all) =>
        [...all.querySelectorAll('select, summary')].map((one) =>
          one instanceof HTMLSelectElement ? one.selectedOptions[0]?.textContent : one.textContent,
        ),
      )
  ).map((text) => text?.trim());
  assert.deepEqual(sentence, ['A race in three views', 'lag of A: 0 to 500 ms', 'Prediction off / on', '2 numbers']);
  assert.equal(await page.locator('main .primary').count(), 1, 'one filled button');
  assert.doesNotMatch(await page.locator('main').innerText(), EMPTY);
  assert.doesNotMatch(await page.locator('main').innerText(), /Pareto|curl/i, 'these come when they are wanted');
  assert.equal(await page.locator('main input[type="checkbox"]:visible').count(), 0);
  assert.deepEqual(complaints, []);
  await close();
});

for (const [width, height] of [
  [390, 844],
  [1024, 768],
  [1366, 768],
  [1920, 1080],
])
  test(`what a sentence names is at least 40 px on ${width}x${height}, and nothing is cut off`, async () => {
    for (const id of QUESTIONS) {
      const { page, close } = await open(id, { width, height });
      const marks = await page.locator('canvas[data-mark]').evaluateAll((all) =>
        all.map((one) => ({
          says: one.dataset.says ?? '',
          mark: (one.dataset.mark ?? '').split(' ').map(Number),
          height: one.clientHeight,
        })),
      );
      assert.equal(marks.length, 2);
      for (const { says, mark, height: whole } of marks) {
        const [, from = NaN, to = NaN] = mark;
        if (/either way$/.test(says)) assert.equal(from, to, `${id}: ${says}`);
        else assert.ok(Math.abs(from - to) >= Math.max(40, 0.03 * whole), `${id}, ${says}: ${Math.abs(from - to)} px`);
      }
      assert.equal(await page.evaluate(() => document.documentElement.scrollWidth > innerWidth), false);
      if (id === QUESTIONS[0]) assert.deepEqual(await axe(page), []);
      await close();
    }
  });

test('dark and in German: the same finding, in its words and numbers', async () => {
  const { page, complaints, close } = await open('updates', { query: '?lang=de&theme=dark' });
  await reads(page.locator('#headline'), /^Mehr Updates: kleinere Fehler, für mehr Bytes\.$/);
  const [, , updates] = SHIPPED,
    on = line(updates, true, 0);
  const said = (/** @type {number} */ value) => value.toFixed(1).replace('.', ',');
  await reads(page.locator('#seen'), new RegExp(`von ${said(on[0][1])} m auf ${said(on[on.length - 1][1])} m`));
  assert.deepEqual(await axe(page), []);
  assert.deepEqual(complaints, []);
  await close();
});

test('run again: the points are replaced by those of this machine, which are the same; the address keeps them', async () => {
  const { page, complaints, close } = await open();
  await page.locator('#run').click();
  await page.locator('[data-state="done"]').waitFor();
  await until(async () => /#experiments=.+/.test(page.url()), 'its address');
  await page.locator('[data-drawer="table"]').click();
  await page.locator('tr[data-point="17"]').waitFor();
  await reads(page.locator('h1#headline'), /^Prediction cures your own car/);
  await page.locator('[data-drawer="files"]').click();
  await settles(() => page.locator('.files a').count(), 9);
  await page.reload();
  await reads(page.locator('h1#headline'), /^Prediction cures your own car/);
  await settles(() => page.locator('.mine li').count(), 1);
  assert.deepEqual(complaints, []);
  await close();
});

test('one change of the sentence: it says so, runs, and the new quantity lies across', async () => {
  const { page, complaints, close } = await open();
  await page.selectOption('#across', 'server.update_hz');
  await page.locator('.changed').waitFor();
  await reads(page.locator('#run'), /^Run$/);
  await reads(page.locator('#across'), /updates a second: 7.5 to 120 Hz/);
  await page.selectOption('#compared', 'players.0.interpolation');
  await page.locator('#measured').click();
  await page.locator('[data-pick="players.0.input_latency_ms.mean"]').uncheck();
  await page.keyboard.press('Escape');
  await settles(() => page.locator('.pick[open]').count(), 0);
  await page.waitForTimeout(500);
  await page.locator('#run:not([disabled])').click();
  await page.locator('[data-state="done"]').waitFor();
  await settles(() => page.locator('canvas[data-x]').evaluateAll((all) => all.map((one) => one.dataset.x)), ['server.update_hz']);
  await settles(() => page.locator('.changed').count(), 0);
  await reads(page.locator('#seen'), /The others are drawn wrong by, m, Interpolation on: from [\d.]+ m at 7.5 Hz to [\d.]+ m at 120 Hz/);
  // Another finished one, and back.
  await page.locator('[data-ships="jitter"]').click();
  await reads(page.locator('h1#headline'), /^Smoothing takes the leaps away/);
  await page.locator('[data-ships="lag"]').click();
  await reads(page.locator('h1#headline'), /^Prediction cures/);
  assert.deepEqual(complaints, []);
  await close();
});

test('a point opens its run live: by its button, by a press on it, by the keyboard', async () => {
  const { page, complaints, close } = await open();
  const live = async () => {
    const { id, owner } = await until(() => sessionOf(page), 'a session');
    assert.equal(owner, true);
    const { players } = (await api(daemon.url, `sessions/${id}`)).body.params;
    await page.goBack();
    await page.locator('#chart-1[data-mark]').waitFor();
    return [players[0].lag_ms, players[0].prediction, players[0].link.down.jitter_ms];
  };
  await page.locator('[data-live]', { hasText: 'off, live' }).click();
  assert.deepEqual(await live(), [300, false, 20]);
  await page.locator('[data-live]', { hasText: 'on, live' }).click();
  assert.deepEqual(await live(), [300, true, 20]);

  const [x, from] = ((await page.locator('#chart-0').getAttribute('data-mark')) ?? '').split(' ').map(Number);
  const box = await page.locator('#chart-0').boundingBox();
  await page.mouse.click((box?.x ?? 0) + x, (box?.y ?? 0) + from);
  assert.deepEqual(await live(), [300, false, 20]);

  await page.locator('.chart-panel .view').first().focus();
  await page.keyboard.press('ArrowRight');
  await reads(page.locator('#alive h2'), /^At 400 ms$/);
  await page.keyboard.press('ArrowDown');
  await page.keyboard.press('Enter');
  assert.deepEqual(await live(), [400, true, 20]);
  assert.deepEqual(complaints, []);
  await close();
});

test('what is begun for a scenario of each kind changes what it measures', async () => {
  const { page, close } = await open();
  await page.locator('[data-drawer="request"]').click();
  const written = async () => JSON.parse(/-d '(.*)' -H/.exec(await page.locator('textarea').inputValue())?.[1] ?? '{}');
  for (const id of ['race', 'motion/pendulum', 'rigid/pyramid', 'fluid/taylor_green']) {
    await page.selectOption('#of', id);
    const order = await until(async () => {
      const now = await written();
      return now.scenario === id && now.metrics.length > 0 && now.axes.length > 0 && now;
    }, `an experiment with ${id}`);
    const rows = await run({ ...order, set: { duration_s: 2, ...order.set } });
    for (const metric of order.metrics) assert.ok(new Set(rows.map((/** @type {any} */ row) => row[metric])).size > 1, `${id}: ${metric}`);
  }
  await close();
});
