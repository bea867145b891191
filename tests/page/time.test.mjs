// The time bar: exact ticks, the same run again, nothing that plays by itself.
import assert from 'node:assert/strict';
import { after, afterEach, before, beforeEach, test } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import {
  api,
  button,
  control,
  dialogOf,
  frameOf,
  launch,
  paramsOf,
  pause,
  pictures,
  reads,
  refreshes,
  runOn,
  scrub,
  sessionOf,
  settles,
  stepOnce,
  tickOf,
  until,
  visit,
} from './lib.mjs';

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
  view = await visit(browser, `${daemon.url}#race`, { smooth: true });
});
afterEach(async () => {
  const complaints = view.complaints;
  await view.close();
  assert.deepEqual(complaints, []);
});

const stateOf = async (page) => (await api(daemon.url, `sessions/${(await sessionOf(page)).id}/state`)).body;

test('pause stands still, play goes on', async () => {
  const { page } = view;
  await pause(page);
  const tick = await tickOf(page),
    picture = await pictures(page);
  await refreshes(page, 40);
  assert.equal(await tickOf(page), tick);
  assert.equal(await pictures(page), picture);
  await reads(page.locator('#chip'), /Paused/);
  await button(page, 'Play').click();
  await until(async () => (await tickOf(page)) > tick + 10, 'it plays');
  await reads(page.locator('#chip'), /Live/);
});

/** As the stream rounds it. @param {number} a @param {number} b */
const alike = (a, b) => Math.abs(a - b) < 1e-7 * b;

test('a step is one tick at every speed, forward and back, and comes to the same state', async () => {
  const { page } = view;
  await runOn(page, 0.3);
  await pause(page);
  const speed = page.getByRole('combobox', { name: 'Speed' });
  const values = await speed.locator('option').evaluateAll((all) => all.map((/** @type {any} */ o) => o.value));
  assert.ok(values.includes('0.1') && values.includes('10'), values.join());
  for (const value of values) {
    await speed.selectOption(value);
    await until(async () => alike((await frameOf(page)).session.speed, Number(value)), `speed ${value}`);
    assert.deepEqual(
      await speed.locator('option').evaluateAll((all) => all.map((/** @type {any} */ o) => o.value)),
      values,
      'no speed is added',
    );
    await settles(() => speed.inputValue(), value);
    const start = await stateOf(page);
    await stepOnce(page, 'forward');
    await until(async () => (await tickOf(page)) === start.tick + 1, 'one more');
    await refreshes(page, 6);
    assert.equal(await tickOf(page), start.tick + 1);
    await stepOnce(page, 'back');
    await until(async () => (await tickOf(page)) === start.tick, 'one less');
    const again = await stateOf(page);
    assert.equal(again.tick, start.tick);
    assert.equal(again.hash, start.hash);
  }
});

/** The tick at which it stands still. @param {import('playwright-core').Page} page */
const still = (page) =>
  until(async () => {
    const tick = await tickOf(page);
    await refreshes(page);
    return (await tickOf(page)) === tick && tick;
  }, 'no more steps');

test('a held step button repeats, and stops when it is released', async () => {
  const { page } = view;
  await pause(page);
  const start = await tickOf(page),
    box = await button(page, 'One tick forward').boundingBox();
  await page.mouse.move(box.x + 10, box.y + 10);
  const from = performance.now();
  await page.mouse.down();
  await until(async () => (await tickOf(page)) > start + 4, 'five ticks');
  await page.mouse.up();
  const ms = performance.now() - from,
    moved = (await still(page)) - start;
  assert.ok(moved <= ms / 60, `${moved} ticks in ${ms} ms: 17 in a second at most`);
});

test('the click with which a held step button is released is no step', async () => {
  const { page } = view;
  await pause(page);
  const start = await tickOf(page),
    forward = button(page, 'One tick forward');
  await forward.dispatchEvent('pointerdown');
  await until(async () => (await tickOf(page)) > start + 4, 'five ticks');
  await forward.dispatchEvent('pointerup');
  const held = await still(page);
  await forward.dispatchEvent('click', { detail: 1 });
  await stepOnce(page, 'forward'); /* after it, as all steps are made one after the other */
  await until(async () => (await tickOf(page)) > held, 'a key steps');
  assert.equal(await still(page), held + 1);
  for (const [event, detail] of /** @type {[string, number][]} */ ([
    ['pointerdown', 0],
    ['pointerup', 0],
    ['click', 1],
  ]))
    await forward.dispatchEvent(event, { detail });
  await until(async () => (await tickOf(page)) > held + 1, 'a short click steps');
});

test('slow motion is slow, and lag stays in simulated time', async () => {
  const { page } = view;
  await page.getByRole('combobox', { name: 'Speed' }).selectOption('0.1');
  await until(async () => alike((await frameOf(page)).session.speed, 0.1), 'slow');
  // A frame is never newer than the daemon, however late it is drawn: two frames more cannot lie further apart than the time between.
  const now = () => page.evaluate(() => ({ time: globalThis.laglab().frame.time_s, wall: performance.now() }));
  const { wall } = await now();
  await runOn(page, 0.05);
  const first = await now();
  await runOn(page, 0.1);
  const last = await now();
  const factor = (last.time - first.time) / ((last.wall - wall) / 1000);
  assert.ok(factor < 0.12, `factor ${factor}`);
  const way = await page.evaluate(() => {
    const input = globalThis
      .laglab()
      .messages.filter((m) => m.type === 1 && m.player === 0)
      .at(-1);
    return input.end_s - input.begin_s;
  });
  assert.ok(Math.abs(way - (await paramsOf(page)).players[0].lag_ms / 1000) < 0.02, `${way} s`);
});

test('scrubbing back shows one tick everywhere, and back to live goes on at the head', async () => {
  const { page } = view;
  await until(async () => (await frameOf(page)).time_s > 1.5, 'there is a past');
  const head = (await frameOf(page)).time_s;
  await scrub(page, 1);
  await until(async () => (await tickOf(page)) === 60, 'tick 60');
  await settles(() => page.locator('#clock').innerText(), '1.00 s');
  await settles(() => page.locator('#ticks').textContent(), ' · tick 60');
  await settles(async () => Number(await page.locator('#scrub').inputValue()), 1);
  const newest = await page.evaluate(() => Math.max(...globalThis.laglab().messages.map((m) => m.begin_s)));
  assert.ok(newest <= 1.0001, `messages to ${newest}`);
  await reads(page.locator('#facts'), /^tick 60 /);
  await reads(page.locator('#chip'), /Paused at 1\.0 s of/);
  await page.getByRole('combobox', { name: 'Speed' }).selectOption('0.1'); /* the head is not reached by itself meanwhile */
  await until(async () => alike((await frameOf(page)).session.speed, 0.1), 'slow');
  await button(page, 'Play').click();
  await page.waitForFunction(() => /Replaying/.test(document.getElementById('chip').innerText));
  await button(page, 'Back to live').click();
  await until(async () => (await frameOf(page)).time_s >= head, 'at the head');
  await page.waitForFunction(() => /^Live/.test(document.getElementById('chip').innerText));
});

test('scrubbing fast ends where the finger ends', async () => {
  const { page } = view;
  await until(async () => (await frameOf(page)).time_s > 1.1, 'there is a past');
  await page.evaluate(() => {
    const slider = /** @type {any} */ (document.getElementById('scrub'));
    for (let i = 0; i <= 50; i++) {
      slider.value = String(i / 50);
      slider.dispatchEvent(new Event('input', { bubbles: true }));
    }
    slider.value = '0.5';
    slider.dispatchEvent(new Event('input', { bubbles: true }));
    slider.dispatchEvent(new Event('change', { bubbles: true }));
  });
  await until(async () => (await tickOf(page)) === 30, 'tick 30');
  await refreshes(page);
  assert.equal(await tickOf(page), 30);
});

test('restart gives the same state at tick 300, twice', async () => {
  const { page } = view;
  const hashes = [];
  for (let i = 0; i < 2; i++) {
    await button(page, 'Restart').click();
    await until(async () => (await tickOf(page)) < 60, 'at the start');
    if ((await page.getByRole('button', { name: 'Pause', exact: true }).count()) > 0) await pause(page);
    await scrub(page, 5);
    await until(async () => (await tickOf(page)) === 300, 'tick 300');
    const state = await stateOf(page);
    assert.equal(state.tick, 300);
    hashes.push(state.hash);
    await button(page, 'Play').click();
    await until(async () => (await tickOf(page)) > 310, 'it goes on');
  }
  assert.match(hashes[0], /^[0-9a-f]{16}$/);
  assert.equal(hashes[0], hashes[1]);
});

test('at the end Play is Replay, and works', async () => {
  const { page } = view;
  const duration = (await frameOf(page)).session.duration_s;
  await pause(page);
  await scrub(page, duration - 0.2);
  await until(async () => (await frameOf(page)).time_s > duration - 1, 'near the end');
  await button(page, 'Play').click();
  await button(page, 'Replay').waitFor();
  await reads(page.locator('#chip'), /Ended/);
  await button(page, 'Replay').click();
  await until(async () => {
    const tick = await tickOf(page);
    return tick > 5 && tick < 600;
  }, 'from the start');
});

test('reset restores parameters, speed and time', async () => {
  const { page } = view;
  const preset = await paramsOf(page);
  await control(page, 'players.0.lag_ms', 'number').fill('600');
  await control(page, 'players.0.lag_ms', 'number').press('Enter');
  await control(page, 'players.1.prediction').setChecked(true);
  await page.getByRole('combobox', { name: 'Speed' }).selectOption('2');
  await until(async () => {
    const p = await paramsOf(page);
    return p.players[0].lag_ms === 600 && p.players[1].prediction;
  }, 'changed');
  await button(page, 'Reset').click();
  await until(async () => JSON.stringify(await paramsOf(page)) === JSON.stringify(preset), 'the preset');
  await until(async () => (await frameOf(page)).session.speed === 1, 'speed');
  await until(async () => (await tickOf(page)) < 200, 'the start');
  await settles(async () => new URL(page.url()).search, '?scenario=race');
});

test('driving and switching never start a paused session', async () => {
  const { page } = view;
  await pause(page);
  const tick = await tickOf(page);
  await page.locator('.view[data-drive="0"]').focus();
  await page.keyboard.press('ArrowRight');
  await control(page, 'players.1.prediction').setChecked(true);
  await refreshes(page);
  assert.equal(await tickOf(page), tick);
  await settles(async () => (await paramsOf(page)).players[0].control, 'person');
});

test('numbers on the page are those of the daemon at that tick', async () => {
  const { page } = view;
  await until(async () => (await frameOf(page)).time_s > 1.5, 'more than a second');
  await pause(page);
  await scrub(page, 1.5); // while a correction is smoothed, what is drawn is no number of the state: always the same tick
  await until(async () => (await frameOf(page)).time_s === 1.5, 'its frame');
  const { id } = await sessionOf(page);
  const tick = await tickOf(page);
  const { body } = await api(daemon.url, `sessions/${id}/state?tick=${tick}`);
  assert.equal(body.tick, tick);
  const frame = await frameOf(page);
  const text = JSON.stringify(body.state);
  for (const entity of frame.views[0].entities) assert.ok(near(body.state, entity.x), `x ${entity.x} in ${text.slice(0, 300)}`);
  await settles(() => page.locator('[data-now="unacked/0"]').innerText(), String(frame.views[1].unacked));
  await settles(() => page.locator('#clock').innerText(), `${frame.time_s.toFixed(2)} s`);
});

/** Whether a number stands anywhere in a value, to the precision of a frame. */
function near(value, number) {
  if (typeof value === 'number') return Math.abs(value - number) <= 1e-6 * Math.max(1, Math.abs(number)) * 10;
  return value !== null && typeof value === 'object' && Object.values(value).some((part) => near(part, number));
}

test('the keys of the table do what the help says', async () => {
  const { page } = view;
  const press = (key) => page.keyboard.press(key);
  await page.locator('h1').click();
  await press('Space');
  await button(page, 'Play').waitFor();
  const tick = await tickOf(page);
  await press('.');
  await until(async () => (await tickOf(page)) === tick + 1, 'one forward');
  await press(',');
  await until(async () => (await tickOf(page)) === tick, 'one back');
  await press(']');
  await until(async () => (await frameOf(page)).session.speed === 2, 'faster');
  await press('[');
  await until(async () => (await frameOf(page)).session.speed === 1, 'slower');
  const before = (await paramsOf(page)).players;
  await press('3');
  await until(async () => (await paramsOf(page)).players[0].interpolation !== before[0].interpolation, 'interpolation of A');
  await press('Shift+1');
  await until(async () => (await paramsOf(page)).players[1].prediction !== before[1].prediction, 'prediction of B');
  await press('m');
  await settles(() => page.locator('#lane').isVisible(), false);
  await press('m');
  await settles(() => page.locator('#lane').isVisible(), true);
  await press('p');
  await settles(() => page.evaluate(() => document.documentElement.dataset.theme), 'projector');
  await until(async () => page.url().includes('theme=projector'), 'the address');
  await press('Shift+?');
  await (await dialogOf(page)).locator('kbd').nth(20).waitFor();
  await press('Escape');
  await page.locator('dialog').waitFor({ state: 'hidden' });
  await press('r');
  await until(async () => (await tickOf(page)) < 30, 'restart');
});

test('single keys can be switched off and stay silent in fields', async () => {
  const { page } = view;
  const playing = async () => ((await frameOf(page)).flags & 2) !== 0;
  await control(page, 'players.0.lag_ms', 'number').focus();
  await page.keyboard.press('Space');
  await page.keyboard.press('r');
  await refreshes(page);
  assert.ok(await playing());
  await page.getByRole('button', { name: 'Help' }).click();
  await page.getByRole('checkbox', { name: 'Single-key shortcuts' }).setChecked(false);
  await page.keyboard.press('Escape');
  await page.locator('dialog').waitFor({ state: 'hidden' });
  await page.locator('h1').click();
  await page.keyboard.press('Space');
  await page.keyboard.press('g');
  await refreshes(page);
  assert.ok(await playing());
  await settles(() => page.getByRole('checkbox', { name: 'Ghosts' }).isChecked(), true);
  await page.keyboard.press('Alt+k');
  await until(async () => !(await playing()), 'Alt+K still works');
});
