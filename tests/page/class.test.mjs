// A class on the page: a teacher, two players and a watcher, each in a browser context of its own.
import assert from 'node:assert/strict';
import { mkdtempSync, rmSync } from 'node:fs';
import { networkInterfaces, tmpdir } from 'node:os';
import path from 'node:path';
import { after, before } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { api, axe, button, frameOf, launch, paramsOf, reads, sessionOf, settles, shown, until, visit, pick } from './lib.mjs';
import { sweep, test } from './tiers.mjs';

const WIDE = { width: 1366, height: 768 },
  PHONE = { width: 390, height: 844, hasTouch: true };

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

function keepSockets() {
  const Real = globalThis.WebSocket;
  globalThis.sockets = [];
  globalThis.WebSocket = class extends Real {
    constructor(/** @type {string} */ url, /** @type {string | string[] | undefined} */ protocols) {
      super(url, protocols);
      globalThis.sockets.push(this);
    }
  };
}
/** A page that remembers its WebSockets, so that a test can cut them. */
const open = (address, size = WIDE) => visit(browser, address, { ...size, scripts: [keepSockets], wait: false });

/** The teacher's page, with a class whose board is a race. */
async function teach(size = WIDE, url = daemon.url) {
  const teacher = await open(`${url}?scenario=race&set=duration_s:600&set=players.0.script:idle&set=players.1.script:idle`, size);
  await shown(teacher.page);
  await button(teacher.page, 'Class').click();
  await button(teacher.page, 'Show the board').waitFor();
  const code = new URL(teacher.page.url()).hash.replace('#class=', '');
  assert.match(code, /^[2-9A-HJKMNP-Z]{4}$/);
  const found = await api(url, `classes/${code}`);
  const state = async () => (await api(url, `classes/${found.body.id}`)).body.state;
  await until(async () => (await state()).seats.length === 2, 'the players');
  return { ...teacher, code, state, id: found.body.id };
}

/** A student's page that has taken a part, and shows the board. */
async function student(code, part, size = WIDE) {
  const visitor = await open(`${daemon.url}${code}`, size);
  await button(visitor.page, part).click();
  await shown(visitor.page);
  return visitor;
}

const chip = (page) => page.locator('#class .chip');
const close = (...visitors) => Promise.all(visitors.map((one) => one.close()));
/** Keys and tokens that a page keeps. */
const secretsOf = (page) =>
  page.evaluate(() => [
    JSON.parse(sessionStorage.getItem('laglab.class') ?? '{}').secret,
    ...Object.values(JSON.parse(localStorage.getItem('laglab.members') ?? '{}')),
    ...Object.values(JSON.parse(sessionStorage.getItem('laglab') ?? '{"keys":{}}').keys),
  ]);
const quiet = (visitors, allowed = /^$/) => {
  for (const { complaints } of visitors)
    assert.deepEqual(
      complaints.filter((text) => !allowed.test(text)),
      [],
    );
};
/** No key or token is part of an address that was requested, or that the address bar shows. */
async function silent(visitors) {
  for (const { page, requests } of visitors) {
    const secrets = (await secretsOf(page)).filter((text) => text);
    assert.ok(secrets.length > 0);
    for (const secret of secrets) {
      assert.ok(!page.url().includes(secret));
      assert.ok(requests.every((request) => !request.url().includes(secret)));
      assert.ok((await page.evaluate(() => globalThis.sockets.map((s) => s.url))).every((url) => !url.includes(secret)));
    }
  }
}

test('teacher and student go on after kill -9 of the daemon: same code, seat, phase and board', async (t) => {
  const data = mkdtempSync(path.join(tmpdir(), 'laglab-test-'));
  t.after(() => rmSync(data, { recursive: true, force: true }));
  let own = await startDaemon({ data });
  t.after(() => own.kill());
  const teacher = await teach(WIDE, own.url);
  const a = await open(`${own.url}${teacher.code}`, PHONE);
  await button(a.page, 'Play A').click();
  await shown(a.page);
  await button(teacher.page, 'Explain').click();
  await until(async () => (await teacher.state()).phase === 'explain', 'the phase');
  const before = await teacher.state();
  await until(async () => (await teacher.state()).seats[0].state === 'held', 'the seat');
  await a.page.waitForTimeout(300); /* until the change is on disk */
  await own.kill();
  await a.page.locator('#class').getByText('Connection lost').waitFor();
  own = await startDaemon({ data, listen: `127.0.0.1:${own.port}` });
  await until(async () => {
    const now = await teacher.state().catch(() => null);
    return now?.seats[0]?.state === 'held' && now.phase === 'explain' && now.board === before.board;
  }, 'the student holds the seat again');
  await reads(chip(a.page), /You play A/);
  await until(async () => (await frameOf(a.page)) !== null, 'the board is drawn');
  await button(teacher.page, 'Run').click();
  await until(async () => (await teacher.state()).status === 'playing', 'the teacher’s key works');
  const { tick } = await frameOf(a.page);
  await until(async () => (await frameOf(a.page)).tick > tick, 'the board moves on the student’s page');
  await close(teacher, a);
});

test('a class is opened, joined by code in either case; two devices drive; a seat is taken once', async () => {
  const teacher = await teach();
  await settles(async () => (await teacher.page.locator('.how .letters').innerText()).replace(/\s/g, ''), teacher.code);
  await reads(teacher.page.locator('.how'), /Only this computer reaches laglab/);
  assert.equal(await teacher.page.locator('.qr').count(), 0, 'no QR code of a loopback address');

  const a = await student(teacher.code.toLowerCase(), 'Play A', PHONE);
  assert.ok(a.page.url().endsWith(`#class=${teacher.code}`));
  await reads(chip(a.page), /You play A/);
  const b = await open(`${daemon.url}#class`);
  await b.page.getByLabel('Code on the board').fill('2222');
  await button(b.page, 'Join').click();
  await b.page.locator('#class').getByText('No class has the code 2222').waitFor();
  await b.page.getByLabel('Code on the board').fill(` ${teacher.code.toLowerCase()} `);
  await button(b.page, 'Join').click();
  await button(b.page, 'Play B').waitFor();
  await settles(() => button(b.page, 'Play A').isDisabled(), true, 'A is taken');
  await reads(b.page.locator('#class-seat-0'), /taken: another device plays A/);
  await button(b.page, 'Play A').evaluate((/** @type {any} */ element) => {
    element.disabled = false;
    element.click();
  });
  await b.page.locator('#class').getByText('seat 0 (A) is taken').waitFor();
  await button(b.page, 'Play B').click();
  await shown(b.page);
  const watcher = await student(teacher.code, 'Watch', PHONE);
  await until(async () => (await teacher.page.locator('.how .counts').innerText()).includes('3 joined'), 'three have joined');
  await until(
    async () => /round trip [\d.]+ ms, simulated lag 150 ms/.test(await teacher.page.locator('.seats').innerText()),
    'the round trip',
  );
  const board = (await sessionOf(teacher.page)).id;
  await settles(() => sessionOf(watcher.page), { id: board, owner: false });
  await settles(async () => (await sessionOf(a.page))?.id, board);

  await button(teacher.page, 'Run').click();
  await until(async () => (await teacher.state()).status === 'playing', 'the run');
  await until(async () => (await paramsOf(a.page)).players.every((p) => p.control === 'person'), 'two persons');
  const pad = a.page.getByRole('button', { name: 'Throttle, Player A' });
  const box = await pad.boundingBox();
  assert.ok(box && box.width >= 64 && box.height >= 64, JSON.stringify(box));
  assert.equal(await a.page.getByRole('button', { name: 'Throttle, Player B' }).count(), 0, 'only its own pads');
  const cars = async () => (await frameOf(watcher.page)).views[0].entities;
  await a.page.mouse.move(box.x + 20, box.y + 20);
  await a.page.mouse.down();
  await until(async () => (await cars())[0].vx > 0.5, 'A drives by its pad');
  assert.ok(Math.abs((await cars())[1].vx) < 0.1, 'B does not');
  await a.page.mouse.up();
  await b.page.locator('.view[data-drive="1"]').focus();
  await b.page.keyboard.down('ArrowRight');
  await until(async () => (await cars())[1].vx > 0.5, 'B drives by its arrow keys');
  await b.page.keyboard.up('ArrowRight');
  await settles(() => watcher.page.locator('#app fieldset :is(input, select)').first().isDisabled(), true);

  await silent([teacher, a, b, watcher]);
  await button(a.page, 'Give seat back').click();
  await until(async () => (await teacher.state()).seats[0].state === 'free', 'the seat is free');
  quiet([teacher, a, watcher]);
  quiet([b], /status of 40[49]/);
  await close(teacher, a, b, watcher);
});

test('votes: by button and key, hidden until locked; a reload keeps seat and vote', async () => {
  const teacher = await teach();
  const a = await student(teacher.code, 'Play A', PHONE),
    watcher = await student(teacher.code, 'Watch');
  await teacher.page.getByLabel('Choices').selectOption('5');
  await button(teacher.page, 'Predict').click();
  await a.page.getByRole('radio').nth(4).waitFor();
  for (const row of await a.page.locator('.answer').all()) assert.ok(((await row.boundingBox())?.height ?? 0) >= 44);
  const bottom = await a.page.locator('#class').boundingBox();
  assert.ok(bottom && bottom.y + bottom.height < 844 - 150, `room for a view below ${bottom?.height} px`);
  const drawn = () =>
    a.page.locator('canvas[data-view="1"]').evaluate((/** @type {any} */ canvas) => {
      const scale = devicePixelRatio;
      return Math.abs(canvas.width - scale * canvas.clientWidth) <= 1 && Math.abs(canvas.height - scale * canvas.clientHeight) <= 1;
    });
  await until(drawn, 'the view is drawn again at its new height');
  await a.page.getByRole('radio').nth(1).check();
  await watcher.page.getByRole('radio').nth(4).waitFor();
  await watcher.page.keyboard.press('3');
  await until(async () => (await teacher.page.locator('.how .counts').innerText()).includes('2 voted'), 'two votes');
  await a.page.getByText('Sent: Choice 2').waitFor();
  for (const { page } of [teacher, a, watcher]) assert.equal(await page.locator('.tally').count(), 0, 'hidden');
  assert.equal((await teacher.state()).tally, null);

  await a.page.reload();
  await shown(a.page);
  await reads(chip(a.page), /You play A/);
  await settles(() => a.page.getByRole('radio').nth(1).isChecked(), true, 'its vote is kept');
  await until(async () => (await teacher.state()).seats[0].state === 'held', 'its seat too');
  assert.equal((await teacher.state()).votes, 2);
  await watcher.page.keyboard.press('2');
  await watcher.page.getByText('Sent: Choice 2').waitFor();

  await button(teacher.page, 'Lock').click();
  for (const { page } of [teacher, a, watcher]) await page.locator('.tally').getByText('2 of 2 chose Choice 2.').waitFor();
  await settles(() => watcher.page.locator('.tally b').allInnerTexts(), ['0', '2', '0', '0', '0']);
  assert.equal(await a.page.getByRole('radio').count(), 0, 'no more votes');

  await button(teacher.page, 'Run').click();
  await button(teacher.page, 'Predict').click();
  await until(async () => (await teacher.state()).votes === 0 && (await teacher.state()).phase === 'predict', 'a new question');
  await a.page.getByText('Choose one.').waitFor();
  await silent([teacher, a, watcher]);
  quiet([teacher, a, watcher]);
  await close(teacher, a, watcher);
});

test('a lesson: its scene on the board, its question and choices on every page', async () => {
  const teacher = await teach();
  const watcher = await student(teacher.code, 'Watch', PHONE);
  await teacher.page.getByLabel('Question', { exact: true }).selectOption('late_answer');
  await until(async () => (await teacher.state()).lesson === 'late_answer', 'the lesson');
  const board = (await teacher.state()).board;
  await until(async () => (await sessionOf(watcher.page))?.id === board && (await sessionOf(teacher.page))?.id === board, 'its scene');
  await button(teacher.page, 'Predict').click();
  await watcher.page.getByText('A message takes 150 ms each way').waitFor();
  await settles(() => watcher.page.locator('.answer span').allInnerTexts(), ['0 ms', '150 ms', '350 ms', '500 ms']);
  assert.equal(await watcher.page.getByText('right', { exact: true }).count(), 0);
  await watcher.page.getByRole('radio').nth(2).check();
  await watcher.page.getByText('Sent: 350 ms').waitFor();
  await button(teacher.page, 'Lock').click();
  await button(teacher.page, 'Run').click();
  await until(async () => (await teacher.state()).phase === 'stopped', 'the stop');
  assert.equal((await teacher.state()).tick, 202);
  await button(teacher.page, 'Explain').click();
  await watcher.page.locator('.tally').getByText('yours right').waitFor();
  quiet([teacher, watcher]);
  await close(teacher, watcher);
});

test('freeze reaches all pages, bringing leads all to the board; a copy is kept', async () => {
  const teacher = await teach();
  await button(teacher.page, 'Free').click();
  const a = await student(teacher.code, 'Play A', PHONE),
    b = await student(teacher.code, 'Play B'),
    copy = await student(teacher.code, 'My own copy');
  await reads(chip(copy.page), /^Your copy$/);
  const board = (await sessionOf(teacher.page)).id;
  const own = await until(async () => {
    const now = await sessionOf(copy.page);
    return now && now.id !== board && now;
  }, 'a session of its own');
  await button(copy.page, 'Play').click();
  await button(copy.page, 'Pause').waitFor();

  const frozen = ({ page }) => page.getByText('The teacher has stopped all pages').first().waitFor();
  await button(teacher.page, 'Freeze all').click();
  await Promise.all([a, b, copy].map(frozen));
  await until(async () => (await api(daemon.url, `sessions/${own.id}`)).body.status === 'paused', 'the copy is paused');
  await settles(() => button(copy.page, 'Play').isDisabled(), true);
  await settles(() => a.page.getByRole('button', { name: 'Throttle, Player A' }).isDisabled(), true);
  await button(teacher.page, 'Unfreeze').click();
  await button(copy.page, 'Pause').waitFor();

  await button(teacher.page, 'Bring all here').click();
  await until(async () => (await sessionOf(copy.page)).id === board && (await frameOf(copy.page)) !== null, 'at the board');
  await settles(() => button(copy.page, 'My copy').isDisabled(), true);
  await button(teacher.page, 'Release from the board').click();
  await until(() => button(copy.page, 'My copy').isEnabled(), 'the way back');
  await button(copy.page, 'My copy').click();
  await until(async () => (await sessionOf(copy.page)).id === own.id, 'the copy');
  await copy.page.reload();
  await shown(copy.page);
  await settles(() => sessionOf(copy.page), { id: own.id, owner: true });
  await silent([teacher, a, b, copy]);
  quiet([teacher, a, b, copy]);
  await close(teacher, a, b, copy);
});

test('a lost connection: the last frame greyed, and seat and vote back by themselves', async () => {
  const teacher = await teach();
  const a = await student(teacher.code, 'Play A');
  await button(teacher.page, 'Predict').click();
  await a.page.getByRole('radio').nth(1).waitFor();
  await a.page.keyboard.press('2');
  await a.page.getByText('Sent: Choice 2').waitFor();
  await a.page.evaluate(() => globalThis.sockets.forEach((socket) => socket.close()));
  await a.page.getByText('Connection lost. Trying again').waitFor();
  await reads(() => a.page.locator('#app main').evaluate((e) => getComputedStyle(e).filter), /grayscale/);
  await until(async () => (await teacher.state()).seats[0].state === 'away', 'the class sees it');
  await a.page.locator('#class').getByText('Connection lost').waitFor({ state: 'detached' });
  await until(async () => (await teacher.state()).seats[0].state === 'held', 'the seat');
  await settles(() => a.page.getByRole('radio').nth(1).isChecked(), true, 'the vote');
  await reads(chip(a.page), /You play A/);
  await button(teacher.page, 'Run').click();
  await a.page.locator('.view[data-drive="0"]').focus();
  await a.page.keyboard.down('ArrowRight');
  await until(async () => (await frameOf(a.page)).views[0].entities[0].vx > 0.5, 'it drives again');
  await a.page.keyboard.up('ArrowRight');
  await close(teacher, a);
});

test('the teacher: a reload, another scenario, a second device, the end', async () => {
  const teacher = await teach();
  const watcher = await student(teacher.code, 'Watch');
  await teacher.page.getByText('Steer from another device').click();
  const remote = await reads(() => teacher.page.locator('.lobby details input').inputValue(), /^http/);
  const phone = await open(remote, PHONE);
  await button(phone.page, 'Show the board').waitFor();
  assert.ok(phone.page.url().endsWith(`#class=${teacher.code}`), phone.page.url());
  await button(phone.page, 'Run').click();
  await until(async () => (await teacher.state()).phase === 'run', 'the remote control');

  await button(teacher.page, 'Show the board').click();
  await teacher.page.reload();
  await shown(teacher.page);
  await settles(async () => (await sessionOf(teacher.page))?.owner, true);
  await pick(teacher.page, 'cannon');
  await until(async () => (await paramsOf(watcher.page))?.game === 'cannon', 'another board on every page');
  await until(async () => (await paramsOf(phone.page))?.game === 'cannon', 'on the second device too');
  await silent([teacher, phone]);
  await button(phone.page, 'End the class').click();
  await button(phone.page, 'End it for all').click();
  await watcher.page.locator('#class').getByText('Another class has another code').waitFor();
  await watcher.page.getByLabel('Code on the board').waitFor();
  await button(teacher.page, 'Class').waitFor();
  await settles(async () => (await sessionOf(teacher.page))?.owner, true, 'the session stays');
  quiet([teacher, watcher, phone]);
  await close(teacher, watcher, phone);
});

test('the teacher sees devices by number, closes the door and removes one; it stays out and reads why', async () => {
  const teacher = await teach();
  const a = await student(teacher.code, 'Play A', PHONE),
    b = await student(teacher.code, 'Watch');
  await reads(a.page.locator('#class .number'), /^Number 1$/);
  await reads(b.page.locator('#class .number'), /^Number 2$/);
  const devices = teacher.page.locator('.devices'),
    device = (/** @type {number} */ n) => devices.getByRole('button', { name: new RegExp(`^Device ${n},`) });
  await settles(() => devices.locator('.device b').allInnerTexts(), ['1', '2']);
  await until(async () => /plays A, connected/.test((await device(1).getAttribute('aria-label')) ?? ''), 'what it does');
  await button(teacher.page, 'Predict').click();
  await b.page.getByRole('radio').nth(1).check();
  await a.page.getByRole('radio').nth(0).check();
  await until(async () => (await teacher.state()).votes === 2, 'two votes');

  await button(teacher.page, 'Free the seats').click();
  await until(async () => (await teacher.state()).seats[0].state === 'free', 'the seat');
  await reads(chip(a.page), /You watch/);
  await button(teacher.page, 'Close the door').click();
  const late = await open(`${daemon.url}${teacher.code}`, PHONE);
  await late.page.getByText('The door of this class is closed').waitFor();
  assert.equal(await button(late.page, 'Watch').count(), 0);
  await a.page.reload();
  await reads(chip(a.page), /You watch/); /* who is in the class comes back */

  await device(1).click();
  await button(teacher.page, 'Keep it').click();
  assert.equal(await button(teacher.page, 'Remove 1').count(), 0);
  await device(1).click();
  await button(teacher.page, 'Remove 1').click();
  await a.page.getByRole('alert').getByText('The teacher has removed this device from the class').waitFor();
  await settles(() => devices.locator('.device b').allInnerTexts(), ['2']);
  assert.equal((await teacher.state()).votes, 1);
  await button(teacher.page, 'Open the door').click();
  await button(late.page, 'Watch').waitFor();
  await a.page.reload();
  await a.page.getByRole('alert').getByText('The teacher has removed this device').waitFor();
  const tab = await a.page.context().newPage();
  await tab.goto(`${daemon.url}${teacher.code}`);
  await tab.getByRole('alert').getByText('The teacher has removed this device').waitFor();
  assert.equal((await teacher.state()).n, 1);
  quiet([teacher, b, late]);
  quiet([a], /status of 403/);
  await close(teacher, a, b, late);
});

test('who gives way for another address reads it, and may join again', async (t) => {
  const small = await startDaemon({ args: ['--max-class-members', '2', '--trusted-proxy', '127.0.0.1'] });
  t.after(() => small.stop());
  const teacher = await teach(WIDE, small.url);
  const pupils = [];
  for (const part of ['Play A', 'Watch']) {
    const one = await open(`${small.url}${teacher.code}`, PHONE);
    await button(one.page, part).click();
    await shown(one.page);
    await until(async () => (await teacher.state()).n === pupils.length + 1, 'the device');
    pupils.push(one);
  }
  const join = () =>
    fetch(new URL(`api/v1/classes/${teacher.code}/members`, small.url), { method: 'POST', headers: { 'x-forwarded-for': '203.0.113.5' } });
  assert.equal((await join()).status, 201);
  await pupils[1].page.locator('#class').getByText('your place is another device’s now').waitFor();
  await reads(chip(pupils[0].page), /You play A/);
  await pupils[1].page.waitForTimeout(5500); /* the new one never connects */
  await button(pupils[1].page, 'Watch').click();
  await reads(chip(pupils[1].page), /You watch/);
  await reads(pupils[1].page.locator('#class .number'), /^Number 4$/);
  await close(teacher, ...pupils);
});

test('another tab of a browser is the same member, with its seat and vote', async () => {
  const teacher = await teach();
  const a = await student(teacher.code, 'Play A');
  await button(teacher.page, 'Predict').click();
  await a.page.getByRole('radio').nth(1).check();
  const tab = await a.page.context().newPage();
  await tab.goto(`${daemon.url}${teacher.code}`);
  await reads(chip(tab), /You play A/);
  await settles(() => tab.getByRole('radio').nth(1).isChecked(), true);
  await tab.getByRole('radio').nth(2).check();
  await settles(() => a.page.getByRole('radio').nth(2).isChecked(), true);
  assert.deepEqual([(await teacher.state()).n, (await teacher.state()).votes], [1, 1]);
  await close(teacher, a);
});

test('two clicks open one class; one that gets no board ends', async () => {
  const teacher = await open(`${daemon.url}?scenario=race`);
  const { page } = teacher;
  await shown(page);
  /** @type {Promise<string>[]} */
  const made = [];
  let puts = 0;
  page.on('response', (answer) => {
    if (answer.request().method() === 'POST' && answer.url().endsWith('/classes')) made.push(answer.json().then(({ id }) => id));
  });
  await page.route('**/api/v1/classes/*/board', (route) => {
    if (++puts === 1)
      return route.fulfill({ status: 409, contentType: 'application/problem+json', body: '{"status":409,"detail":"no board"}' });
    return route.continue();
  });
  await button(page, 'Class').click();
  await reads(page.locator('aside.note'), /No class: no board/);
  await until(async () => (await api(daemon.url, `classes/${await made[0]}`)).status === 404, 'the end of the class');
  await button(page, 'Class').dblclick();
  await button(page, 'Show the board').waitFor();
  assert.equal(made.length, 2);
  quiet([teacher], /Failed to load resource/);
  await close(teacher);
});

test('a daemon on all interfaces: its addresses, and a QR code of the first', async (t) => {
  const own = Object.values(networkInterfaces()).flat();
  if (!own.some((a) => a && !a.internal && a.family === 'IPv4' && !a.address.startsWith('169.254.'))) {
    t.skip('a machine without a network');
    return;
  }
  const wide = await startDaemon({ listen: '0.0.0.0:0' });
  t.after(() => wide.stop());
  const teacher = await teach(WIDE, `http://127.0.0.1:${wide.port}/`);
  const { join } = (await api(`http://127.0.0.1:${wide.port}/`, `classes/${teacher.code}`)).body;
  await settles(() => teacher.page.locator('.qr').getAttribute('aria-label'), `QR code of ${join.urls[0]}`);
  await reads(teacher.page.locator('.addresses'), new RegExp(new URL(join.urls[0]).host));
  await until(async () => ((await teacher.page.locator('.qr path').nth(1).getAttribute('d')) ?? '').length > 1000, 'the QR code');
  quiet([teacher]);
  await teacher.close();
});

for (const size of [WIDE, PHONE])
  sweep(size === PHONE)(`axe finds nothing in lobby, join view, vote and board at ${size.width} px; nothing scrolls sideways`, async () => {
    const teacher = await teach(size);
    const fits = async (page, what) => {
      assert.deepEqual(await axe(page), [], what);
      assert.equal(await page.evaluate(() => document.documentElement.scrollWidth > innerWidth), false, what);
    };
    await fits(teacher.page, 'lobby');
    const empty = await open(`${daemon.url}#class`, size);
    await empty.page.getByLabel('Code on the board').waitFor();
    await fits(empty.page, 'code');
    const a = await open(`${daemon.url}${teacher.code}`, size);
    await button(a.page, 'Play A').waitFor();
    await fits(a.page, 'join');
    await button(a.page, 'Play A').click();
    await shown(a.page);
    await fits(a.page, 'a player');
    await button(teacher.page, 'Predict').click();
    await a.page.getByRole('radio').first().waitFor();
    await fits(a.page, 'vote');
    await button(teacher.page, 'Lock').click();
    await a.page.locator('.tally').waitFor();
    await fits(a.page, 'tally');
    await teacher.page.locator('.device').first().click();
    await button(teacher.page, 'Remove 1').waitFor();
    await fits(teacher.page, 'lobby with votes and what a device is asked');
    await button(teacher.page, 'Show the board').click();
    await fits(teacher.page, 'board');
    await button(teacher.page, 'Freeze all').click();
    await a.page.getByText('The teacher has stopped all pages').first().waitFor();
    await fits(a.page, 'frozen');
    await close(teacher, empty, a);
  });
