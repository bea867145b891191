// The controls: from the schema, live, truthful about what the daemon made of them.
import assert from 'node:assert/strict';
import { after, before, beforeEach, afterEach, test } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { words as names } from './german.mjs';
import { api, axe, control, dialogOf, frameOf, launch, paramsOf, reads, sessionOf, settles, until, visit, pick } from './lib.mjs';

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
/** @type {Awaited<ReturnType<typeof visit>>} */ let view;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});
beforeEach(async () => {
  view = await visit(browser, `${daemon.url}#race`);
});
afterEach(async () => {
  const complaints = view.complaints;
  await view.close();
  assert.deepEqual(complaints, []);
});

/** Sets a slider as a drag does. */
const slide = (page, path, value) =>
  control(page, path, 'range').evaluate((/** @type {any} */ element, to) => {
    element.value = to;
    element.dispatchEvent(new Event('input', { bubbles: true }));
  }, String(value));

test('moving the lag is sent at once and changes the slope of the messages, without a restart', async () => {
  const { page } = view;
  const before = await frameOf(page);
  const change = (lag) =>
    page.evaluate(async (to) => {
      const slider = /** @type {any} */ (document.querySelector('#app input[type="range"][data-path="players.0.lag_ms"]'));
      const newest = Math.max(...globalThis.laglab().messages.map((m) => m.id)),
        { patches } = globalThis.laglab().counts;
      slider.value = String(to);
      slider.dispatchEvent(new Event('input', { bubbles: true }));
      await new Promise((resolve) => requestAnimationFrame(resolve));
      const sent = globalThis.laglab().counts.patches - patches;
      for (;;) {
        await new Promise((resolve) => requestAnimationFrame(resolve));
        const hit = globalThis
          .laglab()
          .messages.some((m) => m.id > newest && m.type === 1 && m.player === 0 && Math.abs(m.end_s - m.begin_s - to / 1000) < 0.02);
        if (hit) return sent;
      }
    }, lag);
  for (const lag of [700, 100, 400, 50, 700]) {
    assert.equal(await change(lag), 1, 'by the next refresh');
    await until(async () => (await paramsOf(page)).players[0].lag_ms === lag, 'the answer');
  }
  const later = await frameOf(page);
  assert.equal(later.session.generation, before.session.generation);
  assert.ok(later.tick >= before.tick);
  await settles(() => control(page, 'players.0.lag_ms', 'number').inputValue(), '700');
  await page.waitForFunction(() => document.body.innerText.includes('RTT 1400 ms'));
  await until(async () => (await frameOf(page)).views[1].lag_ms === 700, 'the frame has the lag');
});

test('the lane itself is drawn with another slope', async () => {
  const { page } = view;
  const lane = () => page.evaluate(() => /** @type {any} */ (document.getElementById('lane')).toDataURL());
  const facts = () => page.locator('#lane-facts').innerText();
  await slide(page, 'players.1.lag_ms', 20);
  await slide(page, 'players.0.lag_ms', 20);
  await until(async () => (await facts()).startsWith('Last 0.40 s'), 'the window of 20 ms lag');
  const steep = await lane();
  await slide(page, 'players.0.lag_ms', 600);
  await until(async () => (await facts()).startsWith('Last 1.80 s'), 'the window of 600 ms lag');
  await until(async () => (await lane()) !== steep, 'another slope');
});

test('a dragged slider sends only what is needed, and its last value wins', async () => {
  const { page } = view;
  const before = await page.evaluate(() => globalThis.laglab().counts.patches);
  await page.evaluate(() => {
    const slider = /** @type {any} */ (document.querySelector('#app input[type="range"][data-path="players.0.lag_ms"]'));
    for (let i = 1; i <= 400; i++) {
      slider.value = String(i);
      slider.dispatchEvent(new Event('input', { bubbles: true }));
    }
  });
  await until(async () => (await paramsOf(page)).players[0].lag_ms === 400, 'the last value');
  const sent = (await page.evaluate(() => globalThis.laglab().counts.patches)) - before;
  assert.ok(sent >= 1 && sent <= 5, `${sent} requests for 400 values`);
});

test('reconciliation turns prediction on; prediction off turns reconciliation off; both are said', async () => {
  const { page } = view;
  const box = (name) => control(page, `players.0.${name}`);
  const set = async (name, on) => {
    await box(name).setChecked(on);
    await until(async () => (await paramsOf(page)).players[0][name] === on, `${name} ${on}`);
  };
  const live = page.locator('#live');
  await set('reconciliation', false);
  await set('prediction', false);
  await set('reconciliation', true);
  await until(() => box('prediction').isChecked(), 'prediction follows');
  await until(async () => /Prediction of A turned on/.test(await live.innerText()), 'it is said');
  await set('prediction', false);
  await until(async () => !(await box('reconciliation').isChecked()), 'reconciliation follows');
  await until(async () => /Reconciliation of A turned off/.test(await live.innerText()), 'it is said');
  await settles(async () => (await frameOf(page)).views[1].flags & 3, 0);
});

test('the answer to a change does not undo a later one of the same control', async () => {
  const { page } = view;
  const box = control(page, 'players.1.interpolation');
  await box.setChecked(true);
  await until(async () => (await paramsOf(page)).players[1].interpolation, 'it is on');
  /** @type {(() => void)[]} */
  const held = [];
  await page.route('**/params', async (route) => {
    if (held.length === 0) await new Promise((resolve) => held.push(() => resolve(null)));
    await route.continue();
  });
  await box.setChecked(false);
  await until(async () => held.length === 1, 'the first is on its way');
  const sent = await box.evaluate((/** @type {any} */ element) => {
    const { patches } = globalThis.laglab().counts;
    element.click();
    globalThis.undone = 0;
    const look = () => {
      if (!element.checked) globalThis.undone++;
      requestAnimationFrame(look);
    };
    look();
    return patches;
  });
  held[0]();
  await until(async () => (await page.evaluate(() => globalThis.laglab().counts.patches)) > sent, 'the second is sent');
  await until(async () => (await paramsOf(page)).players[1].interpolation, 'it is on again');
  assert.equal(await page.evaluate(() => globalThis.undone), 0, 'frames in which the control showed the older value');
});

test('every technique of every player reaches the simulation', async () => {
  const { page } = view;
  for (const player of [0, 1]) {
    for (const [name, bit] of /** @type {[string, number][]} */ ([
      ['prediction', 1],
      ['reconciliation', 2],
      ['interpolation', 4],
    ])) {
      for (const on of [true, false]) {
        await control(page, `players.${player}.${name}`).setChecked(on);
        await until(async () => ((await frameOf(page)).views[1 + player].flags & bit) === (on ? bit : 0), `${name} of ${player}: ${on}`);
      }
    }
  }
});

test('updates per second take 1 to 128; 0 and nothing are refused in words', async () => {
  const { page } = view;
  const field = control(page, 'server.update_hz', 'number');
  for (const value of ['1', '128', '30']) {
    await field.fill(value);
    await field.press('Enter');
    await until(async () => (await paramsOf(page)).server.update_hz === Number(value), value);
  }
  for (const wrong of ['0', '']) {
    await field.fill(wrong);
    await field.press('Tab');
    await page.waitForFunction(() =>
      /Updates per second: give a number from 1 to 128/.test(/** @type {any} */ (document.querySelector('.note')).innerText),
    );
    await settles(() => field.inputValue(), '30');
    await page.locator('.note button').click();
  }
  assert.equal((await paramsOf(page)).server.update_hz, 30);
});

test('ranges of every control are those of the schema, names and help those of the words', async () => {
  const { page } = view;
  const schema = (await api(daemon.url, 'schema')).body;
  const rows = schema.$defs.player.properties;
  const lag = control(page, 'players.0.lag_ms', 'range');
  const limit = await lag.getAttribute('max');
  assert.equal(limit, '1000');
  assert.ok(JSON.stringify(rows.lag_ms).includes(limit));
  const help = await page.locator('label:has([data-path="players.0.lag_ms"])').first().getAttribute('title');
  assert.equal(help, names.en.params['players.*.lag_ms'].tip);
  await page.getByRole('button', { name: 'All settings of Player A' }).click();
  await (await dialogOf(page)).locator('[data-path]').first().waitFor();
  const shown = await page.locator('dialog [data-path]').evaluateAll((all) => [...new Set(all.map((e) => e.dataset.path))]);
  for (const name of [
    'lag_ms',
    'prediction',
    'reconciliation',
    'interpolation',
    'interpolation_ratio',
    'jitter_margin_ms',
    'control',
    'script',
    'link.up.jitter_ms',
    'link.down.loss_pct',
    'link.up.distribution',
  ]) {
    assert.ok(shown.includes(`players.0.${name}`), name);
  }
});

test('jitter and loss act on both directions; lost messages are seen', async () => {
  const { page } = view;
  const field = control(page, 'players.0.link.up.loss_pct', 'number');
  await field.fill('50');
  await field.press('Enter');
  await until(async () => {
    const link = (await paramsOf(page)).players[0].link;
    return link.up.loss_pct === 50 && link.down.loss_pct === 50;
  }, 'both directions');
  await until(
    () => page.evaluate(() => globalThis.laglab().messages.some((m) => m.type <= 2 && m.player === 0 && m.fate === 1)),
    'a lost message',
  );
});

test('a change by another client is shown', async () => {
  const { page } = view;
  const kept = await page.evaluate(() => JSON.parse(sessionStorage.getItem('laglab')));
  const { id } = await sessionOf(page);
  const answer = await api(daemon.url, `sessions/${id}/params`, { 'players.1.lag_ms': 444 }, kept.keys[id], 'PATCH');
  assert.equal(answer.status, 200);
  await until(async () => (await control(page, 'players.1.lag_ms', 'number').inputValue()) === '444', 'the field follows');
});

test('the address keeps what was changed, and gives it elsewhere', async () => {
  const { page } = view;
  await slide(page, 'players.1.lag_ms', 321);
  await control(page, 'players.1.interpolation').setChecked(true);
  await until(
    async () => page.url().includes('players.1.lag_ms:321') && page.url().includes('players.1.interpolation:true'),
    'both in the address',
  );
  const other = await visit(browser, page.url());
  const params = await paramsOf(other.page);
  assert.equal(params.players[1].lag_ms, 321);
  assert.equal(params.players[1].interpolation, true);
  assert.notEqual((await sessionOf(other.page)).id, (await sessionOf(page)).id);
  await other.close();
});

test('seed and parameters of the address are used; bad ones are named and the default used', async () => {
  const good = await visit(browser, `${daemon.url}?scenario=paper/fig13&set=players.0.lag_ms:222&seed=7`);
  assert.equal((await paramsOf(good.page)).players[0].lag_ms, 222);
  const { id } = await sessionOf(good.page);
  assert.equal((await api(daemon.url, `sessions/${id}`)).body.seed, 7);
  await good.close();
  for (const [query, words] of /** @type {[string, RegExp][]} */ ([
    ['?set=players.0.lag_ms:abc', /players\.0\.lag_ms=abc ignored/],
    ['?set=players.0.lag_ms:99999', /lag_ms=99999 ignored/],
    ['?set=players.0.nonsense:1', /nonsense=1 ignored/],
    ['?scenario=nonsense', /scenario=nonsense ignored/],
    ['?seed=abc', /seed=abc ignored/],
    ['?theme=pink#race', /theme=pink ignored/],
  ])) {
    const bad = await visit(browser, daemon.url + query);
    await reads(bad.page.locator('.note'), words);
    const lag = (await paramsOf(bad.page)).players[0].lag_ms;
    assert.ok(lag >= 0 && lag <= 1000);
    await bad.close();
  }
});

test('another scenario is chosen from the list of the daemon', async () => {
  const { page } = view;
  const list = (await api(daemon.url, 'scenarios')).body.scenarios;
  await page.locator('#scenario').click();
  await settles(() => page.locator('.options [role="option"]').count(), list.length);
  await page.keyboard.press('Escape');
  for (const id of ['paper/fig11', 'cannon', 'gambetta']) {
    await pick(page, id);
    const wanted = list.find((s) => s.id === id);
    await until(async () => (await paramsOf(page))?.title === wanted.title, wanted.title);
    await until(async () => (await frameOf(page))?.tick > 5, 'it runs');
    await until(async () => page.url().includes(`scenario=${id}`), 'the address');
    await reads(() => page.title(), new RegExp(wanted.title.slice(0, 8).replace(/[^\w ]/g, '.')));
  }
});

test('scenarios are found by words of their titles and texts, by keys and by touch, under their groups', async () => {
  for (const [lang, sought, id] of [
    ['en', 'DOMINOES', ''],
    ['en', 'pyramid', 'rigid/pyramid'],
    ['de', 'pyramide', 'rigid/pyramid'],
  ]) {
    const { page, complaints, close } = await visit(browser, `${daemon.url}?lang=${lang}#race`, {
      width: 390,
      height: 844,
      hasTouch: true,
    });
    const list = (await api(daemon.url, 'scenarios')).body.scenarios,
      options = page.locator('.options [role="option"]');
    await page.locator('#scenario').tap();
    const field = page.getByRole('combobox').and(page.locator('dialog input'));
    await settles(() => options.count(), list.length);
    assert.equal(await page.locator('.options [role="group"]').count(), 5);
    assert.equal(await page.evaluate(() => document.activeElement?.getAttribute('role')), 'combobox', 'one can type at once');
    assert.deepEqual(await axe(page), []);
    await field.fill(`${sought} xyzzy`);
    await settles(() => options.count(), 0);
    await field.fill(sought);
    await until(async () => (await options.count()) < 40, 'fewer');
    if (id === '') {
      await page.keyboard.press('Escape'); /* clears the search */
      await page.keyboard.press('Escape');
      await page.locator('dialog[open]').waitFor({ state: 'detached' });
    } else {
      const selected = () => page.locator('.options [aria-selected="true"]').getAttribute('id');
      const first = await selected();
      assert.equal(await field.getAttribute('aria-activedescendant'), first);
      if ((await options.count()) > 1) {
        await field.press('ArrowDown');
        assert.notEqual(await selected(), first);
        assert.equal(await field.getAttribute('aria-activedescendant'), await selected());
      }
      const at = await options.evaluateAll((all, wanted) => all.findIndex((one) => one.dataset.scenario === wanted), id);
      assert.ok(at >= 0, 'it is there');
      for (let i = 0; i < 40; i++) await field.press('ArrowUp');
      for (let i = 0; i < at; i++) await field.press('ArrowDown');
      await field.press('Enter');
      await until(async () => page.url().includes(`scenario=${id}`), id);
      await settles(() => page.locator('dialog[open]').count(), 0);
    }
    assert.deepEqual(complaints, []);
    await close();
  }
});

test('eight players are shown, and all can be reached', async () => {
  const eight = await visit(browser, `${daemon.url}?scenario=eight`);
  const count = (await paramsOf(eight.page)).players.length + 1;
  await settles(() => eight.page.locator('canvas[data-view]').count(), count);
  const last = eight.page.locator('canvas[data-view]').nth(count - 1);
  await last.scrollIntoViewIfNeeded();
  assert.ok((await last.boundingBox()).height > 80);
  assert.deepEqual(eight.complaints, []);
  await eight.close();
});

/** What a field takes, and what is said. @param {import('playwright-core').Page} page @param {string} path */
const typeInto = (page, path) => async (/** @type {string} */ text) => {
  const field = control(page, path, 'number');
  await field.fill(text);
  await field.press('Enter');
  return field;
};

test('numbers are typed and printed with the decimal sign of the page; what can be read in two ways is refused', async () => {
  const path = 'methods.0.dt_s';
  for (const { lang, own, other, wrong, said, kept } of [
    { lang: 'de', own: '0,2', other: '0.05', wrong: ['1.234', '1.000,5', '1,0,5'], said: /auf zwei Arten/, kept: '0,05' },
    { lang: 'en', own: '0.2', other: '.05', wrong: ['0,2', '1,234', '1,234.5'], said: /in two ways/, kept: '0.05' },
  ]) {
    const { page, complaints, close } = await visit(browser, `${daemon.url}?lang=${lang}#step`);
    const type = typeInto(page, path),
      value = async () => (await paramsOf(page)).methods[0].dt_s;
    const field = await type(own);
    await until(async () => (await value()) === 0.2, `${own} is 0.2`);
    await settles(() => field.inputValue(), own);
    await type(other);
    await until(async () => (await value()) === 0.05, `${other} is 0.05`);
    await settles(() => field.inputValue(), kept);
    for (const text of wrong) {
      await type(text);
      await until(async () => said.test(await page.locator('#app').innerText()), `${text} is refused`);
      const message = await page.locator('#app').innerText();
      assert.ok(message.includes(text) && message.includes(kept), text);
      await settles(() => field.inputValue(), kept);
    }
    await type(lang === 'de' ? 'acht' : 'eight');
    await settles(() => field.inputValue(), kept);
    assert.equal(await value(), 0.05);
    assert.deepEqual(complaints, []);
    await close();
  }
});

test('arrows count in a field of a number, within its range', async () => {
  const { page } = view,
    field = control(page, 'players.0.lag_ms', 'number');
  await field.fill('1');
  for (const [key, wanted] of [
    ['ArrowUp', 2],
    ['ArrowDown', 1],
    ['ArrowDown', 0],
    ['ArrowDown', 0],
  ]) {
    await field.press(String(key));
    await until(async () => (await paramsOf(page)).players[0].lag_ms === wanted, `${key}: ${wanted}`);
    assert.equal(await field.inputValue(), String(wanted));
  }
});
