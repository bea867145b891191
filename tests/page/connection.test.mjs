// Connections on the page: state in the view, players who are not connected, the list of events, messages of the connection; and values
// without a sample.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import {
  api,
  axe,
  button,
  dialogOf,
  frameOf,
  launch,
  paramsOf,
  reads,
  refreshes,
  runOn,
  sessionOf,
  settles,
  until,
  visit,
  tickOf,
  pause,
} from './lib.mjs';

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

/** Until a view's words are so. @param {import('playwright-core').Page} page @param {number} view @param {RegExp} what */
const words = (page, view, what) =>
  page.waitForFunction(
    ({ index, source }) =>
      new RegExp(source).test(document.querySelector(`canvas[data-view="${index}"]`)?.getAttribute('aria-label') ?? ''),
    { index: view, source: what.source },
  );
const listed = async (page) => (await page.locator('.happened li').allInnerTexts()).map((text) => text.replace(/\s+/g, ' '));

/** How many pixels of a view are dark. @param {import('playwright-core').Page} page @param {number} view */
const ink = (page, view) =>
  page.evaluate((index) => {
    const canvas = /** @type {HTMLCanvasElement} */ (document.querySelector(`canvas[data-view="${index}"]`));
    const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d', { willReadFrequently: true });
    if (!copy) throw new Error('no copy');
    copy.drawImage(canvas, 0, 0);
    const { data } = copy.getImageData(0, 0, canvas.width, canvas.height);
    let dark = 0;
    for (let i = 0; i < data.length; i += 4) dark += data[i] + data[i + 1] + data[i + 2] < 300 ? 1 : 0;
    return dark;
  }, view);

test('an outage: stalled, disconnected, joined again; the view says so, and the list when', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}?scenario=outage&set=players.1.lag_ms:40`);
  const { id } = await sessionOf(page);
  const key = await page.evaluate((of) => JSON.parse(sessionStorage.getItem('laglab') ?? '').keys[of], id);
  const control = async (/** @type {any} */ body) => {
    const { status } = await api(daemon.url, `sessions/${id}/control`, body, key);
    assert.equal(status, 200, body.op);
  };
  await control({ op: 'pause' });
  await button(page, 'Play').waitFor();
  const hz = await page.evaluate(() => Math.round(globalThis.laglab().frame.tick / globalThis.laglab().frame.time_s));
  const go = async (/** @type {number} */ time) => {
    await control({ op: 'play', until_tick: time * hz });
    await until(async () => (await tickOf(page)) === time * hz, `${time} s`);
  };
  await settles(() => page.locator('.happened').count(), 0, 'nothing to list while all clients play');
  await page.evaluate(() => {
    const live = /** @type {HTMLElement} */ (document.getElementById('live')),
      spoken = /** @type {string[]} */ ([]);
    Object.assign(window, { spoken });
    new MutationObserver(() => spoken.push(live.textContent ?? '')).observe(live, { childList: true, characterData: true, subtree: true });
  });
  await words(page, 2, /^View of player B/);
  const plain = await ink(page, 2);
  await control({ op: 'speed', speed: 4 });
  await go(12);
  await control({ op: 'speed', speed: 1 });
  const at = async (/** @type {number} */ time, /** @type {number} */ state) => {
    await go(time);
    assert.equal((await frameOf(page)).views[2].connection, state, `at ${time} s`);
  };
  await at(15, 3);
  await words(page, 2, /^Stalled · dropped by the server\. View of player B/);
  await settles(
    async () => (await listed(page)).map((text) => text.replace(/^(≤ )?[\d.]+ s /, '')),
    ['B dropped by the server', 'B stalled'],
  );
  assert.ok((await frameOf(page)).views[1].entities[1].flags & 128, 'away for A');
  assert.ok(!((await frameOf(page)).views[1].entities[0].flags & 128));
  await at(17, 5);
  await words(page, 2, /^Disconnected\. View of player B/);
  await words(page, 1, /^View of player A/);
  await until(async () => (await ink(page, 2)) < 0.6 * plain, `dimmed, less than ${plain}`);
  assert.deepEqual(await axe(page), []);
  await control({ op: 'play' });
  await until(async () => (await frameOf(page)).time_s > 18.5 && (await frameOf(page)).views[2].connection === 2, 'playing again');
  await settles(
    async () => (await listed(page)).map((text) => text.replace(/^(≤ )?[\d.]+ s /, '')),
    ['B dropped by the server', 'B stalled', 'B disconnected', 'B joined again'],
  );
  const list = await listed(page);
  const times = list.map((text) => Number.parseFloat(text.replace('≤ ', '')));
  assert.ok(
    times[0] > 12.5 && times[0] < 13.5 && times[1] > times[0] + 0.4 && Math.abs(times[2] - times[1] - 2.5) < 0.11 && times[3] > 18,
    list.join(),
  );
  await until(() => page.evaluate(() => /** @type {any} */ (window).spoken.some((text) => /B joined again/.test(text))), 'it is spoken');
  await words(page, 2, /^View of player B/);
  assert.ok(!((await frameOf(page)).views[1].entities[1].flags & 128), 'back');
  assert.deepEqual(complaints, []);
  await close();
});

test('pings are among the messages when they are wanted', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}?scenario=race&set=players.0.lag_ms:300`);
  await runOn(page, 1.5);
  await page.keyboard.press('Alt+k');
  await button(page, 'Play').waitFor();
  await refreshes(page);
  const lane = () => page.evaluate(() => /** @type {HTMLCanvasElement} */ (document.getElementById('lane')).toDataURL());
  const pings = await page.evaluate(() => globalThis.laglab().messages.filter((m) => m.type === 7 || m.type === 8).length);
  assert.ok(pings >= 4, `${pings} pings and pongs`);
  const box = page.getByRole('checkbox', { name: 'Pings' }),
    before = await lane();
  await settles(() => box.isChecked(), false);
  await box.check();
  await until(async () => (await lane()) !== before, 'they are drawn');
  await box.uncheck();
  await until(async () => (await lane()) === before, 'and not');
  assert.deepEqual(complaints, []);
  await close();
});

test('a value without a sample is a dash; one with samples is a number', async () => {
  const { page, close } = await visit(browser, `${daemon.url}?scenario=race&set=warmup_s:8`);
  const cell = (name) => page.locator(`[data-now="${name}"]`).innerText();
  await until(async () => (await frameOf(page)).time_s > 2, 'two seconds');
  await pause(page);
  assert.ok((await frameOf(page)).time_s < 8, 'before anything counts');
  for (const name of ['latency', 'lost', 'error']) await settles(() => cell(`${name}/1`), '–', name);
  await button(page, 'Play').click();
  await until(async () => (await cell('latency/1')) !== '–', 'a change of B');
  const latency = Number(await cell('latency/1'));
  assert.ok(latency > 500 && latency < 600, `${latency}: a round trip of 500 ms, and the waits`);
  await settles(() => cell('lost/1'), '0');
  await settles(() => cell('error/1'), '0.00');
  await close();
});

test('a session that ends before anything counts says so', async () => {
  for (const [duration, notes] of /** @type {[string, number][]} */ ([
    ['1.75', 1],
    ['9', 0],
  ])) {
    const { page, complaints, close } = await visit(browser, `${daemon.url}?scenario=race&set=duration_s:${duration}`);
    await page.locator('.side .about h2').waitFor();
    const note = page.locator('.side .about [role="note"]');
    await settles(() => note.count(), notes);
    if (notes > 0) await reads(note, /duration_s, 1\.75 s, is not longer than warmup_s, 2 s/);
    assert.deepEqual(complaints, []);
    await close();
  }
});

test('both locksteps can be chosen, each by its name', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}?scenario=race`);
  const choice = page.locator('#app select[data-path="server.sync"]');
  await settles(
    () => choice.locator('option').allInnerTexts(),
    [
      'Server does not wait',
      'Lockstep (stop and wait)',
      'Inputs as they come',
      'Deterministic lockstep',
      'Rollback',
      'Lockstep, pipelined',
      'Buckets (ignore late inputs)',
    ],
  );
  for (const [sync, low, high] of /** @type {[string, number, number][]} */ ([
    ['lockstep', 1, 4],
    ['lockstep_pipelined', 20, 40],
  ])) {
    await choice.selectOption(sync);
    await until(async () => (await paramsOf(page)).server.sync === sync, sync);
    await runOn(page, 1);
    const { time_s: time, views } = await frameOf(page);
    await runOn(page, 2);
    const later = await frameOf(page),
      pace = (later.views[0].input_seq - views[0].input_seq) / (later.time_s - time);
    assert.ok(pace > low && pace < high, `${sync}: ${pace} steps a second`);
  }
  assert.deepEqual(complaints, []);
  await close();
});

test('settings are grouped; those fixed during a run are shown and disabled', async () => {
  const { page, close } = await visit(browser, `${daemon.url}?scenario=race&set=players.0.drift_ppm:40`);
  await button(page, 'All settings of Player A').click();
  await dialogOf(page);
  await settles(
    () => page.locator('dialog h3').allInnerTexts(),
    ['Link', 'Prediction and view', 'Control and inputs', 'Clock and devices', 'Link up', 'Link down'],
  );
  const drift = page.locator('dialog [data-path="players.0.drift_ppm"]'),
    send = page.locator('dialog [data-path="players.0.send_hz"]').first();
  await settles(() => drift.inputValue(), '40');
  await settles(() => drift.isDisabled(), true);
  await send.fill('20');
  await send.press('Enter');
  await until(async () => (await paramsOf(page)).players[0].send_hz === 20, 'sent per second');
  assert.deepEqual(await axe(page), []);
  await page.locator('dialog').getByRole('button', { name: 'Close', exact: true }).click();
  await page.locator('dialog').waitFor({ state: 'hidden' });
  await button(page, 'All settings of the server and the game').click();
  await settles(
    () => page.locator('dialog h3').allInnerTexts(),
    ['Rate and connections', 'Transport', 'Inputs', 'Shots', 'Snapshots', 'Deterministic and rollback', 'Game'],
  );
  await close();
});

/** A page whose drawing can be held up: then it draws, and acknowledges, at intervals only. */
async function slowPage(query) {
  const context = await browser.newContext(),
    page = await context.newPage();
  await page.addInitScript(() => {
    const { requestAnimationFrame: own, WebSocket: Socket } = globalThis;
    globalThis.WebSocket = class extends Socket {
      constructor(/** @type {[string, string[]]} */ ...where) {
        super(...where);
        /** @type {any} */ (globalThis).socket = this;
      }
    };
    /** @type {any} */ (globalThis).heldMs = 0;
    globalThis.requestAnimationFrame = (draw) => {
      const { heldMs } = /** @type {any} */ (globalThis);
      return heldMs > 0 ? Number(setTimeout(() => draw(performance.now()), heldMs)) : own(draw);
    };
  });
  await page.goto(`${daemon.url}${query}`);
  await until(async () => ((await frameOf(page))?.time_s ?? 0) > 0.5, 'a frame');
  return {
    page,
    hold: (ms) =>
      page.evaluate((value) => {
        /** @type {any} */ (globalThis).heldMs = value;
      }, ms),
    close: () => context.close(),
  };
}

test('a page that draws too slowly gets fewer frames, says so, and gets them back', async () => {
  const { page, hold, close } = await slowPage('?scenario=race&set=duration_s:120');
  const chip = page.locator('#pace');
  const rate = async () => ((await chip.count()) === 0 ? 60 : Number(/^Slow: (30|20|15|10|8|5|4) Hz$/.exec(await chip.innerText())?.[1]));
  await hold(300);
  const low = await until(async () => {
    const hz = await rate();
    return hz <= 15 && hz;
  }, 'the chip, with a rate that the page draws at');
  await reads(page.locator('#chip'), /Live/);
  await hold(0);
  await until(async () => (await rate()) > low, 'more frames, as many as the machine can draw');
  // A busy machine may never draw all, for which the daemon would say this:
  const all = () =>
    page.evaluate(async () => {
      const data = JSON.stringify({ type: 'rate', reason: 'viewer keeps up again', divisor: 1 });
      globalThis.socket.dispatchEvent(new MessageEvent('message', { data }));
      await new Promise((resolve) => requestAnimationFrame(resolve));
      return document.getElementById('pace') === null;
    });
  await until(all, 'no chip with all frames');
  await close();
});

test('where events were skipped the lanes are torn', async () => {
  const { page, hold, close } = await slowPage('?scenario=eight&set=duration_s:120');
  const newest = () => page.evaluate(() => globalThis.laglab().gaps.at(-1));
  await page.locator('#lane').scrollIntoViewIfNeeded(); // what is not seen is not drawn
  const before = (await newest())?.to ?? 0; /* a busy machine has its own */
  await hold(3000); // longer than events are kept, shorter than the daemon waits for an acknowledgement
  const gap = await until(async () => {
    const one = await newest();
    return one?.to > before && one;
  }, 'the gap');
  await hold(0);
  await until(async () => /Torn where this device skipped frames/.test(await page.locator('#lane-facts').innerText()), 'it is shown');
  assert.ok(gap.count > 0 && gap.to > gap.from, JSON.stringify(gap));
  assert.ok((await page.evaluate(() => globalThis.laglab().curves[0].own)).includes(null), 'no line across the gap');
  await close();
});
