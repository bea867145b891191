// Two runs of a netgame compared: a second session from the same start, one time for both, what differs by name, and the difference as a
// curve.
import assert from 'node:assert/strict';
import { mkdirSync } from 'node:fs';
import { after, before } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import {
  api,
  axe,
  button,
  control,
  frameOf,
  launch,
  paramsOf,
  pause,
  reads,
  refreshes,
  scrub,
  sessionOf,
  settles,
  stepOnce,
  until,
  visit,
} from './lib.mjs';
import { sweep, test } from './tiers.mjs';

const SHOTS = process.env.LAGLAB_SHOTS ?? ''; // a folder for images of the page
if (SHOTS) mkdirSync(SHOTS, { recursive: true });

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

/** What the page says of the comparison. @param {import('playwright-core').Page} page @returns {Promise<any>} */
const facts = (page) => page.evaluate(() => globalThis.laglab().compare);
/** Until both runs are computed and drawn. @param {import('playwright-core').Page} page */
async function computed(page) {
  await page.waitForSelector('main.compare');
  await until(async () => {
    const now = await facts(page);
    return now && !now.working && now.second !== '' && now.traces.every((n) => n > 1) && now.ticks.length === 2;
  }, 'both runs are computed');
}
/** Until both views show that tick. @param {import('playwright-core').Page} page @param {number} tick */
const both = (page, tick) => until(async () => (await facts(page)).ticks.join() === `${tick},${tick}`, `both views show tick ${tick}`);

async function open(query = '?scenario=race', wish = {}) {
  const visited = await visit(browser, daemon.url + query, wish);
  const phone = (visited.page.viewportSize()?.width ?? 0) < 700;
  await visited.page.locator(phone ? '.tabs .compare' : '.side .compare').click();
  await computed(visited.page);
  return visited;
}

/** Changes the setting that is chosen in a run. @param {import('playwright-core').Page} page @param {0 | 1} run @param {string} value */
async function change(page, run, value) {
  const field = page.locator(`[data-run="${run}"]`);
  if ((await field.evaluate((element) => element.tagName)) === 'SELECT') await field.selectOption(value);
  else {
    await field.fill(value);
    await field.press('Enter');
  }
  const now = () => page.evaluate(() => ({ ...globalThis.laglab().compare, first: globalThis.laglab().params }));
  const path = await page.locator('#compare-setting').inputValue();
  const at = (of) => path.split('.').reduce((one, part) => one?.[part], of);
  await until(async () => String(at(run === 0 ? (await now()).first : (await now()).params)) === value, `${path} is ${value}`);
  await computed(page);
}

/** A column of the trace of a session that begins with these settings, and its hash at tick 360. @param {Record<string, unknown>} set
 * @param {string} column @param {number} [end] s */
async function reference(set, column, end = 60) {
  const { body } = await api(daemon.url, 'sessions', { scenario: 'race', set, paused: true });
  await api(daemon.url, `sessions/${body.id}/control`, { op: 'seek', time_s: end }, body.owner_key);
  const [head, ...lines] = (await (await fetch(`${daemon.url}api/v1/sessions/${body.id}/trace?to_s=${end}`)).text()).trim().split(/\r?\n/);
  const place = head.split(',').indexOf(column);
  assert.ok(place > 0);
  const { hash } = (await api(daemon.url, `sessions/${body.id}/state?tick=360`)).body;
  return { values: lines.map((line) => Math.abs(Number(line.split(',')[place]))), hash }; // a distance
}

test('nothing of it is read before it is wanted', async () => {
  const { page, requests, close } = await visit(browser, `${daemon.url}?scenario=race`);
  await page.waitForSelector('#error-chart canvas');
  const read = () => requests.filter((r) => /compare|words\/[a-z]+[.]json/.test(new URL(r.url()).pathname)).length;
  assert.equal(read(), 0);
  await page.locator('.side .compare').click();
  await computed(page);
  assert.ok(read() >= 3);
  await close();
});

test('the difference in words and numbers is that of two sessions made with the settings', async () => {
  const { page, complaints, close } = await open();
  await reads(() => page.locator('#compare-sentence').textContent(), /^Both runs are the same within 60 s/);
  await reads(() => page.locator('#compare-differ').textContent(), /No setting differs yet/);
  await change(page, 1, '300');
  await scrub(page, 6);
  await both(page, 360);
  const [expected, changed] = await Promise.all([
    reference({}, 'player_0_remote_error_m'),
    reference({ 'players.0.lag_ms': 300 }, 'player_0_remote_error_m'),
  ]);
  const hashOf = async (/** @type {string} */ id) => (await api(daemon.url, `sessions/${id}/metrics`)).body.hash;
  assert.equal(await hashOf((await sessionOf(page)).id), expected.hash);
  assert.equal(await hashOf((await facts(page)).second), changed.hash);
  const one = expected.values,
    other = changed.values;
  const metres = (/** @type {number} */ value) => `${value.toFixed(2)} m`;
  const gaps = one.map((value, tick) => Math.abs(other[tick] - value)),
    most = Math.max(...gaps);
  assert.ok(gaps[360] > 1 && most > gaps[360], `${gaps[360]} m, at most ${most} m`);
  const way = other[360] > one[360] ? 'higher' : 'lower';
  await until(
    async () =>
      (await page.locator('#compare-sentence').textContent()) ===
      `At 6.00 s, “A: Distance of the others” is ${metres(one[360])} in the first run and ${metres(other[360])} in the second, ` +
        `${metres(gaps[360])} ${way}; ` +
        `over 60 s they differ by ${metres(gaps.reduce((a, b) => a + b) / gaps.length)} on average and by at most ${metres(most)}, ` +
        `at ${(gaps.indexOf(most) / 60).toFixed(2)} s.`,
    'the sentence',
  );
  await settles(
    () => page.locator('#compare-differ tbody tr').evaluateAll((rows) => rows.map((row) => /** @type {any} */ (row).innerText)),
    ['A: One-way lag\t150 ms\t300 ms\tMake equal'],
  );
  await reads(() => page.locator('#compare-value-1').textContent(), new RegExp(`${metres(other[360])}$`));

  await page.locator('#compare-curve').selectOption('player_1_buffer_ms');
  await until(
    async () => /make no difference to “B: Interpolation buffer”/.test((await page.locator('#compare-sentence').textContent()) ?? ''),
    'a curve that lag of A does not change',
  );
  await button(page, 'Make equal: A: One-way lag').click();
  await until(async () => (await facts(page)).params.players[0].lag_ms === 150, 'they are equal again');
  await computed(page);
  await reads(() => page.locator('#compare-differ').textContent(), /No setting differs yet/);
  assert.deepEqual(complaints, []);
  await close();
});

test('a technique is changed in either run; the address has both', async () => {
  const { page, complaints, close } = await open();
  await page.locator('#compare-setting').selectOption('players.0.prediction');
  await change(page, 0, 'false');
  assert.equal((await paramsOf(page)).players[0].prediction, false);
  assert.equal((await facts(page)).params.players[0].prediction, true);
  assert.equal((await paramsOf(page)).players[0].reconciliation, false, 'it needs prediction');
  await reads(page.locator('#compare-differ'), /A: Prediction\s+off\s+on/);
  await page.locator('#compare-curve').selectOption('player_0_own_lead_m');
  await until(async () => /“A: Own lead”/.test((await page.locator('#compare-sentence').textContent()) ?? ''), 'the curve of the own lead');
  await until(
    async () => new URL(page.url()).searchParams.getAll('set').includes('players.0.prediction:false'),
    'the setting of the first run is in the address',
  );
  await reads(async () => new URL(page.url()).hash, /^#compare=players\.0\.prediction:true.*&curve=player_0_own_lead_m$/);
  assert.deepEqual(complaints, []);
  await close();
});

test('one time steers both: scrub, step, play, pause, the curves', async () => {
  const { page, complaints, close } = await open();
  await change(page, 1, '300');
  const { second } = await facts(page),
    first = await sessionOf(page);
  const at = async (id) => (await api(daemon.url, `sessions/${id}`)).body;
  await scrub(page, 3);
  await both(page, 180);
  await stepOnce(page, 'forward');
  await both(page, 181);
  await button(page, 'Play').click();
  const running = await until(async () => {
    const { ticks } = await facts(page);
    return ticks[0] > 190 && ticks;
  }, 'both go on');
  assert.ok(Math.abs(running[0] - running[1]) <= 8, `${running}: where frames are skipped, neighbours`);
  await pause(page);
  const { tick } = await frameOf(page);
  await both(page, tick);
  const states = await Promise.all([first.id, second].map(at));
  assert.deepEqual(
    states.map((one) => [one.status, one.tick]),
    [
      ['paused', tick],
      ['paused', tick],
    ],
  );
  const box = await page.locator('#compare-time').boundingBox();
  assert.ok(box);
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.up();
  await until(async () => {
    const { ticks } = await facts(page);
    return ticks[0] === ticks[1] && ticks[0] > 1700 && ticks[0] < 1900;
  }, 'the middle of the curves is about 30 s');
  assert.deepEqual(complaints, []);
  await close();
});

test('how much is compared: ten minutes of both, with the largest distance wherever it is; the address keeps it', async () => {
  const set = { duration_s: 700, 'players.0.lag_ms': 300 };
  const { page, complaints, close } = await open('?scenario=race&set=duration_s:700');
  await change(page, 1, '300');
  assert.deepEqual((await facts(page)).traces, [7201, 7201], 'two minutes where nothing is said');
  await settles(
    () => page.locator('#compare-length option').evaluateAll((all) => all.map((one) => one.textContent)),
    ['10 s', '30 s', '60 s', '120 s', '300 s', '600 s'],
  );
  await page.locator('#compare-length').selectOption('600');
  await until(async () => (await facts(page)).traces.join() === '36001,36001', 'ten minutes of both');
  await computed(page);
  const expected = await Promise.all([{ duration_s: 700 }, set].map((one) => reference(one, 'player_0_remote_error_m', 600)));
  const gaps = expected[0].values.map((value, tick) => Math.abs(expected[1].values[tick] - value)),
    most = Math.max(...gaps);
  await reads(
    page.locator('#compare-sentence'),
    new RegExp(`over 600 s .* at most ${most.toFixed(2)} m, at ${(gaps.indexOf(most) / 60).toFixed(2)} s`),
  );
  await scrub(page, 590);
  await both(page, 35400);
  await reads(async () => page.url(), /#compare=players\.0\.lag_ms:300&length=600$/);
  await page.reload();
  await computed(page);
  assert.deepEqual((await facts(page)).traces, [36001, 36001]);
  await page.locator('#compare-length').selectOption('10');
  await until(async () => (await facts(page)).traces.join() === '601,601', 'ten seconds of both');
  await both(page, 600);
  assert.deepEqual(complaints, []);
  await close();
});

test('a reload shows it again; closing deletes the second session and keeps the first', async () => {
  const { page, complaints, close } = await open();
  await change(page, 1, '275.5');
  const before = await facts(page),
    first = await sessionOf(page);
  assert.match(page.url(), /#compare=players\.0\.lag_ms:275\.5$/);
  await page.reload();
  await computed(page);
  const now = await facts(page);
  assert.equal(now.params.players[0].lag_ms, 275.5);
  assert.equal((await paramsOf(page)).players[0].lag_ms, 150);
  assert.equal((await sessionOf(page)).id, first.id);
  assert.notEqual(now.second, before.second);
  const gone = (id) => until(async () => (await api(daemon.url, `sessions/${id}`)).status === 404, `${id} is deleted`);
  await gone(before.second);
  await button(page, 'Close').first().click();
  await page.waitForSelector('canvas[data-view="2"]');
  await gone(now.second);
  assert.equal((await api(daemon.url, `sessions/${first.id}`)).status, 200);
  assert.ok(!page.url().includes('compare'), page.url());
  assert.equal((await paramsOf(page)).players[0].lag_ms, 150);
  await button(page, 'Play').click();
  const { tick } = await frameOf(page);
  await until(async () => (await frameOf(page)).tick > tick + 5, 'the lab goes on');
  assert.deepEqual(complaints, []);
  await close();
});

test('a link opens it elsewhere; another scenario ends it', async () => {
  const { page, complaints, close } = await visit(
    browser,
    `${daemon.url}?scenario=race&set=server.update_hz:20#compare=server.update_hz:5&view=0`,
    { wait: false },
  );
  await computed(page);
  const { second, params } = await facts(page);
  assert.deepEqual([(await paramsOf(page)).server.update_hz, params.server.update_hz], [20, 5]);
  await settles(() => page.locator('#compare-view').inputValue(), '0');
  await button(page, 'Cannon').click();
  await page.waitForSelector('canvas[data-view="2"]');
  await until(async () => (await api(daemon.url, `sessions/${second}`)).status === 404, 'the second session is deleted');
  assert.ok(!page.url().includes('compare'), page.url());
  assert.deepEqual(complaints, []);
  await close();
});

test('what a person drives becomes a script; Reset is followed', async () => {
  const visited = await visit(browser, `${daemon.url}?scenario=race`);
  const { page } = visited;
  await control(page, 'players.0.control').selectOption('person');
  await until(async () => (await paramsOf(page)).players[0].control === 'person', 'a person drives');
  await page.locator('.side .compare').click();
  await computed(page);
  const controls = async () => [(await paramsOf(page)).players[0].control, (await facts(page)).params.players[0].control];
  assert.deepEqual(await controls(), ['script', 'script']);
  await page.keyboard.press('ArrowRight');
  await refreshes(page);
  assert.deepEqual(await controls(), ['script', 'script'], 'keys do not drive one of two runs');
  await change(page, 0, '40');
  await button(page, 'Reset').click();
  await until(async () => (await paramsOf(page)).players[0].lag_ms === 150, 'the first run is that of the scenario');
  await until(async () => /^Both runs are the same/.test((await page.locator('#compare-sentence').textContent()) ?? ''), 'its curves too');
  assert.deepEqual(visited.complaints, []);
  await visited.close();
});

test('who may not change the session may not compare', async () => {
  const { body } = await api(daemon.url, 'sessions', { scenario: 'race' });
  const { page, close } = await visit(browser, `${daemon.url}#s=${body.id}`);
  await settles(() => page.locator('.side .compare').isDisabled(), true);
  await reads(() => page.locator('.side .compare').getAttribute('title'), /^Read-only/);
  await close();
});

test('German where the browser is', async () => {
  const { page, close } = await open('?scenario=race', { locale: 'de-DE' });
  await change(page, 1, '300');
  await scrub(page, 5); /* at the very start both may be the same */
  await settles(() => page.locator('main.compare h2').textContent(), 'Vergleichen');
  await until(
    async () =>
      /^Bei \d+,\d\d s .* „A: Abstand der anderen“ im ersten Lauf /.test((await page.locator('#compare-sentence').textContent()) ?? ''),
    'the sentence in German',
  );
  await reads(page.locator('#compare-differ'), /A: Lag je Weg\s+150 ms\s+300 ms\s+Angleichen/);
  await close();
});

for (const [width, height] of [
  [1366, 768],
  [768, 1024],
  [390, 844],
])
  for (const [scenario, setting] of [
    ['race', 'players.0.lag_ms'],
    ['cannon', 'players.0.lag_ms'],
    ['rifle', 'players.0.lag_ms'],
    ['crates', 'players.0.lag_ms'],
  ])
    sweep(width < 400 || (width > 1000 && scenario === 'race'))(
      `${scenario} at ${width} x ${height}: both views to one scale, readable for all`,
      async () => {
        const { page, complaints, close } = await open(`?scenario=${scenario}`, { width, height });
        await page.locator('#compare-setting').selectOption(setting);
        await change(page, 1, '400');
        await scrub(page, 4);
        await both(page, 240);
        const boxes = await page.locator('.run canvas').evaluateAll((all) =>
          all.map((/** @type {any} */ canvas) => {
            const colours = new Set(new Uint32Array(canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data.buffer));
            return { width: canvas.clientWidth, height: canvas.clientHeight, colours: colours.size };
          }),
        );
        assert.equal(boxes.length, 2);
        assert.deepEqual([boxes[0].width, boxes[0].height], [boxes[1].width, boxes[1].height]);
        for (const box of boxes) assert.ok(box.height > 80 && box.width > 200 && box.colours > 20, JSON.stringify(box));
        const wide = await page.locator('main').evaluate((main) => main.scrollWidth);
        assert.ok(wide <= width, `${wide} px of ${width}`);
        if (SHOTS) {
          await page.screenshot({ path: `${SHOTS}/${scenario}-${width}.png` });
          await page.locator('main').evaluate((main) => main.scrollTo(0, 1e5));
          if (width < 1000) await page.screenshot({ path: `${SHOTS}/${scenario}-${width}-end.png` });
        }
        assert.deepEqual(await axe(page), []);
        await page.locator('main.compare').evaluate((element) => element.setAttribute('aria-busy', 'true'));
        assert.deepEqual(await axe(page), [], 'while runs are computed');
        assert.deepEqual(complaints, []);
        await close();
      },
    );
