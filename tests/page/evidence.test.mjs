// What makes lag visible: dots, messages, corrections, curves.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { control, dialogOf, frameOf, launch, refreshes, runOn, settles, until, visit } from './lib.mjs';

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

const dotsOf = (page) => page.evaluate(() => globalThis.laglab().dots);
const gaps = (times) => times.slice(1).map((t, i) => t - times[i]);
const spread = (list) => Math.max(...list) - Math.min(...list);

test("Figure 8: the dots of client and server are evenly spaced, the client's 250 ms later", async () => {
  const { page, close } = await visit(browser, `${daemon.url}?scenario=paper/fig08`);
  await settles(() => page.getByRole('checkbox', { name: 'Arrival dots' }).isChecked(), true);
  const dots = await until(async () => {
    const d = await dotsOf(page);
    return d[1].length >= 5 && d[0].length >= 5 && d;
  }, 'dots');
  for (const view of [0, 1]) {
    const list = gaps(dots[view]);
    assert.ok(spread(list) < 0.05 && Math.abs(list[0] - 1 / 3) < 0.05, `view ${view}: ${list.map((g) => g.toFixed(3))}`);
  }
  const states = await page.evaluate(() =>
    globalThis
      .laglab()
      .messages.filter((m) => m.type === 2 && m.player === 0)
      .map((m) => m.end_s - m.begin_s),
  );
  assert.ok(states.length > 3 && states.every((way) => Math.abs(way - 0.25) < 0.02), states.join());
  await close();
});

test('Figure 9: with random latency they are not', async () => {
  const { page, close } = await visit(browser, `${daemon.url}?scenario=paper/fig09`);
  const dots = await until(async () => {
    const d = await dotsOf(page);
    return d[1].length >= 8 && d;
  }, 'dots, more than happen to be even');
  assert.ok(spread(gaps(dots[1])) > 0.1, gaps(dots[1]).join());
  await close();
});

test('a dot is described in the view and announced', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}?scenario=paper/fig08`);
  await until(async () => (await dotsOf(page))[1].length >= 5, 'dots');
  await page.keyboard.press('Alt+k');
  await page.getByRole('button', { name: 'Play', exact: true }).waitFor();
  await refreshes(page);
  const picture = () => page.evaluate(() => /** @type {any} */ (document.querySelector('canvas[data-view="1"]')).toDataURL());
  const before = await picture();
  await page.locator('.view[data-drive="0"]').focus();
  await page.keyboard.press('Shift+ArrowLeft');
  await page.waitForFunction(() =>
    /Snapshot of tick \d+ · arrived .* · sent .* · \d+ ms old/.test(document.getElementById('live').textContent),
  );
  await until(async () => (await picture()) !== before, 'the dot is named in the view');
  assert.deepEqual(complaints, []);
  await close();
});

test('one input is selected among the messages, and its path is described', async () => {
  const { page, close } = await visit(browser, `${daemon.url}?scenario=paper/fig08`);
  await until(async () => (await frameOf(page)).time_s > 2.2, 'inputs and states');
  await page.keyboard.press('Alt+k');
  await page.getByRole('button', { name: 'Play', exact: true }).waitFor();
  await refreshes(page);
  await page.locator('.view[data-arrows]').focus();
  await page.keyboard.press('ArrowLeft');
  await page.keyboard.press('ArrowLeft');
  await until(async () => /Input \d+ of A/.test(await page.locator('#lane-facts').innerText()), 'its life');
  /* The lane shows 0.75 s and a life takes half a second: step until the oldest input that is shown has lived its whole life. */
  const whole = async () => /250 ms to the server's tick .* to its use · total \d+ ms/.test(await page.locator('#lane-facts').innerText());
  for (let i = 0; i < 40 && !(await whole()); i++) {
    const { tick } = await frameOf(page);
    await page.keyboard.press('.');
    await until(async () => (await frameOf(page)).tick === tick + 1, 'a step');
    for (let k = 0; k < 4; k++) await page.keyboard.press('ArrowLeft');
    await refreshes(page, 4);
  }
  assert.ok(await whole(), await page.locator('#lane-facts').innerText());
  await page.keyboard.press('Escape');
  await until(async () => /^Last /.test(await page.locator('#lane-facts').innerText()), 'deselected');
  await close();
});

test('prediction without reconciliation snaps; with it, in a separate lane, nothing is corrected', async () => {
  const { page, close } = await visit(
    browser,
    `${daemon.url}?scenario=race&set=players.0.reconciliation:false&set=players.0.prediction:true&set=players.0.lag_ms:250`,
  );
  await until(async () => (await frameOf(page)).views[1].corrections > 3, 'snaps');
  await until(async () => Number(await page.locator('[data-now="corrections/0"]').innerText()) > 0, 'the number of corrections');
  await control(page, 'players.0.reconciliation').setChecked(true);
  await runOn(page, 1.2);
  const count = (await frameOf(page)).views[1].corrections;
  await runOn(page, 1.2);
  assert.equal((await frameOf(page)).views[1].corrections, count);
  await close();
});

test('interpolation draws the other between two snapshots and shows α', async () => {
  // 12 snapshots a second: a display of 20 Hz then shows five different places between two.
  const { page, close } = await visit(browser, `${daemon.url}?scenario=race&set=players.0.interpolation:true&set=server.update_hz:12`);
  // The frame and what had arrived by then, in one question: the page goes on meanwhile.
  const look = () =>
    page.evaluate(() => {
      const lab = globalThis.laglab();
      const frame = lab.frame?.plain();
      frame?.views.forEach((view) => {
        view.entities = frame.entities.filter((one) => one.view === view.view);
      });
      return { frame, arrived: lab.messages.filter((m) => m.type === 2 && m.player === 0).map((m) => m.begin_s) };
    });
  await until(async () => (await look()).frame?.views[1].entities[1].flags & 4, 'interpolated');
  const alphas = new Set();
  for (let i = 0; i < 100 && alphas.size <= 3; i++) {
    const { frame, arrived } = await look();
    const view = frame.views[1];
    assert.ok(view.entities[1].flags & 4, 'interpolated');
    assert.ok(view.alpha >= 0 && view.alpha <= 1, `${view.alpha}`);
    assert.ok(
      Math.min(...arrived) <= view.render_time_s && view.render_time_s < frame.time_s,
      `${Math.min(...arrived)} ${view.render_time_s} ${frame.time_s}`,
    );
    alphas.add(view.alpha);
    await refreshes(page, 4);
  }
  assert.ok(alphas.size > 3, [...alphas].join());
  await close();
});

test('charts have a table of the same numbers', async () => {
  const { page, close } = await visit(browser, `${daemon.url}#race`);
  await until(async () => (await frameOf(page)).time_s > 2, 'curves');
  await page.getByRole('group', { name: 'Unit of the distance' }).getByRole('button', { name: 'm', exact: true }).click();
  await page.getByRole('button', { name: 'Table of the distance' }).click();
  const dialog = await dialogOf(page);
  await settles(
    () => dialog.locator('thead th').allInnerTexts(),
    ['Time (s)', 'A own lead (m)', 'A others (m)', 'B own lead (m)', 'B others (m)'],
  );
  await dialog.locator('tbody tr').nth(2).waitFor();
  const rows = await dialog.locator('tbody tr').count();
  assert.ok(rows <= 25, `${rows} rows`);
  const cells = await dialog.locator('tbody td').allInnerTexts();
  assert.ok(
    cells.every((text) => /^−?\d+\.\d{3}$/.test(text)),
    cells.join(),
  );
  await close();
});

test('unit, ghosts, labels and dots change what is drawn', async () => {
  const { page, close } = await visit(browser, `${daemon.url}#race`);
  await until(async () => (await frameOf(page)).time_s > 1, 'dots');
  await page.keyboard.press('Alt+k');
  await page.getByRole('button', { name: 'Play', exact: true }).waitFor();
  await refreshes(page);
  const picture = () => page.evaluate(() => /** @type {any} */ (document.querySelector('canvas[data-view="1"]')).toDataURL());
  for (const name of ['Ghosts', 'Labels', 'Arrival dots']) {
    const before = await picture();
    const box = page.getByRole('checkbox', { name, exact: true });
    await box.setChecked(!(await box.isChecked()));
    await until(async () => (await picture()) !== before, name);
    await box.setChecked(!(await box.isChecked()));
    await until(async () => (await picture()) === before, `${name} back`);
  }
  await close();
});
