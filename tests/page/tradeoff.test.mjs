// Speed against error: from a lab and from the first page, measured, read by pointer, keys and table, opened as sessions, kept, in German
// on a phone.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { englishIn, hearCanvases, textsOn } from './german.mjs';
import { bytesOf, axe, launch, paramsOf, reads, refreshes, settles, until, visit } from './lib.mjs';

const SHOTS = process.env.LAGLAB_SHOTS ?? ''; // a folder for images of the page

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

/** @param {import('playwright-core').Page} page @param {string} name */
const shot = (page, name) => (SHOTS === '' ? undefined : page.screenshot({ path: `${SHOTS}/tradeoff-${name}.png` }));
/** @param {import('playwright-core').Page} page */
const hash = (page) => page.evaluate(() => location.hash);
/** @param {import('playwright-core').Page} page */
const title = (page) => page.locator('main.tradeoff h2');
/** Dark or coloured pixels of a plot. @param {import('playwright-core').Page} page @param {number} n */
const ink = (page, n) =>
  page.locator(`#tradeoff-${n}`).evaluate((/** @type {any} */ canvas) => {
    const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d', { willReadFrequently: true });
    copy.drawImage(canvas, 0, 0);
    const { data } = copy.getImageData(0, 0, canvas.width, canvas.height);
    let count = 0;
    for (let i = 0; i < data.length; i += 4) count += data[i + 3] > 200 && Math.max(data[i], data[i + 1], data[i + 2]) > 60 ? 1 : 0;
    return count;
  });

test('from a lab: a measurement, its plots and choices, live sessions and back', async () => {
  const { page, context, complaints, close } = await visit(browser, `${daemon.url}?scenario=rigid/pyramid`);
  await page.locator('#to-tradeoff').click();
  await reads(title(page), /Speed against error: Contact solvers/);
  assert.equal(await page.locator('[data-family]').count(), 8);
  await page.locator('#tradeoff-duration').fill('0.5');
  await page.locator('#measure').click();
  await page.locator('[data-state="running"] progress').waitFor();
  await page.locator('[data-state="running"]').waitFor({ state: 'detached' });
  await page.locator('.winners').nth(1).waitFor();
  const at = await hash(page),
    job = /^#tradeoff=contact_solvers&job=([a-z2-7]{26})$/.exec(at)?.[1];
  assert.ok(job, at);
  const { answer } = await (await fetch(`${daemon.url}api/v1/tradeoffs/${job}`)).json();

  // plots and choices are those of the answer
  assert.equal(await page.locator('#tradeoff-cost').inputValue(), 'passes_per_s', 'work before time');
  assert.equal(await page.locator('.noisy').count(), 0);
  for (const n of [1, 0]) {
    await page.locator(`#tradeoff-${n}`).scrollIntoViewIfNeeded();
    await until(async () => (await ink(page, n)) > 300, `plot ${n}`);
  }
  for (const n of [0, 1]) {
    const wanted = answer.choices.filter((one) => one.problem === n && one.cost === 1);
    assert.equal(wanted.length, 3);
    const rows = page.locator('.winners').nth(n).locator('tbody tr');
    assert.deepEqual(
      await rows.evaluateAll((all) => all.map((row) => row.dataset.outcome)),
      wanted.map(({ outcome }) => outcome),
    );
    for (const [i, { row }] of wanted.entries()) {
      const link = new URL(await rows.nth(i).locator('a').getAttribute('href'), daemon.url);
      assert.equal(link.search, answer.rows[row].link);
    }
  }
  await shot(page, 'desktop');
  assert.deepEqual(await axe(page), []);

  // the processor time comes with a warning, and is in the address
  const inked = await ink(page, 0);
  await page.locator('#tradeoff-cost').selectOption('cpu_s');
  await reads(page.locator('.noisy'), /while it serves others/);
  assert.equal(await hash(page), `#tradeoff=contact_solvers&cost=cpu_s&job=${job}`);
  await page.locator('#tradeoff-cost').selectOption('passes_per_s');

  // a method can be hidden
  await until(async () => (await ink(page, 0)) === inked, 'the work again');
  const first = page.locator('.problem').first();
  await first.locator('.key button').first().click();
  await until(async () => (await ink(page, 0)) < inked, 'one method less');
  await first.locator('.key button').first().click();

  // every row with every cost as CSV
  const [file] = await Promise.all([page.waitForEvent('download'), page.locator('#csv').click()]);
  const lines = (await bytesOf(file)).toString().trim().split('\r\n');
  assert.equal(lines.length, 1 + answer.rows.length * answer.costs.length);
  assert.equal(lines[0].split(',').length, 27);
  assert.ok(lines[1].startsWith(`contact_solvers,rigid/column,solver.method,${answer.rows[0].method},solver.substeps,`));

  // by keys: the plot is read, and a point opened with exactly its settings
  await first.locator('.view').focus();
  for (const press of ['ArrowRight', 'ArrowRight', 'ArrowRight']) await page.keyboard.press(press);
  const spoken = await reads(first.locator('output'), /Substeps \d+.*Sag of a column/);
  const substeps = Number(/Substeps (\d+)/.exec(spoken)?.[1]);
  const href = await first.locator('.looked a').getAttribute('href');
  await first.locator('.view').focus();
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => globalThis.laglab().params?.scene === 'column');
  const params = await paramsOf(page);
  assert.equal(params.solver.substeps, substeps);
  assert.equal(params.solver.method, /solver\.method:(\w+)/.exec(decodeURIComponent(href ?? ''))?.[1]);
  assert.equal(params.duration_s, 0.5);
  assert.match(page.url(), /\?scenario=rigid\/column&set=/);

  // Back and reload have the results; a family of its own has none; the first measurement is found again
  await page.goBack();
  await page.locator('.winners').nth(1).waitFor();
  await page.reload();
  await page.locator('.winners').nth(1).waitFor();
  assert.match(await hash(page), new RegExp(`job=${job}`));
  await page.locator('[data-family="snapshots"]').click();
  await reads(title(page), /Snapshots/);
  assert.equal(await page.locator('.winners').count(), 0);
  await page.goBack();
  await reads(title(page), /Contact solvers/);
  await page.locator('.winners').nth(1).waitFor();
  await page.locator('details summary').first().click();
  await settles(() => page.locator('details table tbody tr').count(), answer.rows.filter((row) => row.problem === 0).length);
  assert.deepEqual(complaints, []);
  await context.close();

  // the same measurement by its address, in German, dark, on a phone
  const phone = await visit(browser, `${daemon.url}?theme=dark&lang=de#tradeoff=contact_solvers&job=${job}`, {
    width: 390,
    height: 844,
    hasTouch: true,
    scripts: [hearCanvases],
    wait: false,
  });
  await phone.page.locator('.winners').nth(1).waitFor();
  await phone.page.locator('#tradeoff-0').scrollIntoViewIfNeeded();
  await until(async () => (await ink(phone.page, 0)) > 300, 'a plot on the phone');
  assert.equal(await phone.page.evaluate(() => document.documentElement.scrollWidth), 390);
  assert.deepEqual(await axe(phone.page), []);
  await shot(phone.page, 'phone-dark');
  await phone.page.locator('.problem').first().scrollIntoViewIfNeeded();
  await phone.page.locator('.problem .view').first().scrollIntoViewIfNeeded();
  await shot(phone.page, 'phone-dark-plot');
  await phone.page.locator('.winners').first().scrollIntoViewIfNeeded();
  await shot(phone.page, 'phone-dark-choices');
  const texts = await textsOn(phone.page);
  assert.ok(texts.some((text) => text.includes('Einsinken einer Säule')));
  const given = new Set(['rigid/column', 'rigid/pyramid', 'laglab']);
  assert.deepEqual(
    texts.map((text) => englishIn(text, given)).filter((why) => why !== ''),
    [],
  );
  assert.deepEqual(phone.complaints, []);
  await phone.close();
  await close();
});

test('from the first page: a measurement goes on while another family is shown, and is cancelled', async () => {
  const { page, complaints, close } = await visit(browser, daemon.url, { wait: false });
  await page.locator('.door a[href="#tradeoff"]').click();
  await reads(title(page), /Integrators/);
  await page.locator('[data-family="synchronisation"]').click();
  await reads(title(page), /Synchronisation/);
  await page.locator('#tradeoff-seeds').selectOption('100');
  await page.locator('#measure').click();
  await page.locator('#cancel').waitFor();
  const progress = page.locator('#tradeoff-progress');
  await page.locator('[data-family="integrators"]').click();
  await reads(title(page), /Integrators/);
  assert.equal(await page.locator('#cancel').count(), 0);
  await page.goBack();
  const doneOf = async () => Number(/^(\d+) of 70 steps/.exec((await progress.count()) ? await progress.innerText() : '')?.[1] ?? 0);
  await until(async () => (await doneOf()) > 1, 'progress');
  await page.locator('#cancel').click();
  await reads(page.locator('.ended'), /was cancelled/);
  await until(
    async () => /^laglab_tasks_running 0$/m.test(await (await fetch(`${daemon.url}metrics`)).text()),
    'the daemon has stopped it',
  );
  for (let i = 0; i < 4; i++) {
    if ((await page.locator('.door').count()) > 0) break;
    await page.goBack();
    await refreshes(page, 6);
  }
  await page.locator('.door a[href="#tradeoff"]').waitFor();
  assert.deepEqual(complaints, []);
  await close();
});

test('labs lead to their own families, and a wrong request says why', async () => {
  const { page, close } = await visit(browser, `${daemon.url}?scenario=motion/pendulum`);
  for (const [scenario, family] of [
    ['motion/pendulum', 'integrators'],
    ['fluid/cavity', 'pressure_solvers'],
    ['fluid/sea', 'oceans'],
    ['fluid/dam_break', 'particles'],
    ['race', 'synchronisation'],
    ['behind_cover', 'lag_compensation'],
    ['crates', 'snapshots'],
  ]) {
    await page.goto(`${daemon.url}?scenario=${scenario}`);
    await page.locator('#to-tradeoff').waitFor();
    await page.waitForFunction(
      (id) => globalThis.laglab?.().params && new URLSearchParams(location.search).get('scenario') === id,
      scenario,
    );
    await until(async () => (await page.locator('#to-tradeoff').count()) === 1, 'a button');
    await page.locator('#to-tradeoff').click();
    await until(async () => (await hash(page)).startsWith(`#tradeoff=${family}`), `${scenario} leads to ${family}: ${await hash(page)}`);
  }
  await page.locator('#tradeoff-duration').waitFor();
  await page.evaluate(() => {
    const field = /** @type {HTMLInputElement} */ (document.getElementById('tradeoff-duration'));
    field.removeAttribute('max');
    field.value = '5000';
    field.dispatchEvent(new Event('input', { bubbles: true }));
  });
  await page.locator('#measure').click();
  await reads(page.locator('.note'), /duration_s|0\.05 to 1000/);
  await close();
});
