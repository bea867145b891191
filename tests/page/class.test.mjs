// A class on the page: a teacher, two players and a watcher, each in a browser context of its own.
import assert from 'node:assert/strict';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { networkInterfaces, tmpdir } from 'node:os';
import path from 'node:path';
import { after, before } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { api, axe, button, frameOf, launch, paramsOf, pick, reads, refreshes, sessionOf, settles, shown, until, visit } from './lib.mjs';
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
  const room = await opened(teacher, url);
  await until(async () => (await room.state()).seats.length === 2, 'the players');
  return room;
}

/** The class that a page has just opened. */
async function opened(teacher, url = daemon.url) {
  await next(teacher.page).waitFor();
  const code = new URL(teacher.page.url()).hash.replace('#class=', '');
  assert.match(code, /^[2-9A-HJKMNP-Z]{4}$/);
  const { id } = (await api(url, `classes/${code}`)).body;
  const state = async () => (await api(url, `classes/${id}`)).body.state,
    key = await teacher.page.evaluate(() => JSON.parse(sessionStorage.getItem('laglab.class') ?? '{}').secret);
  return {
    ...teacher,
    code,
    state,
    id,
    /** What another device of the teacher does. */
    put: (/** @type {any} */ patch) => api(url, `classes/${id}`, patch, key, 'PATCH'),
    /** Presses Next, and waits for the phase. */
    on: async (/** @type {string | string[]} */ phase) => {
      await next(teacher.page).click();
      await until(async () => [phase].flat().includes((await state()).phase), `phase ${phase}`);
    },
    /** Behind the button with three dots. */
    more: async () => {
      await button(teacher.page, 'More for the teacher').click();
      return teacher.page.locator('dialog.classmore');
    },
  };
}

/** The one button that says what comes next. */
const next = (page) => page.locator('#class .next');

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
  await teacher.put({ phase: 'explain' });
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
  await teacher.on('predict'); /* the teacher’s key works */
  await teacher.put({ phase: 'run' });
  await until(async () => (await teacher.state()).status === 'playing', 'the run');
  const { tick } = await frameOf(a.page);
  await until(async () => (await frameOf(a.page)).tick > tick, 'the board moves on the student’s page');
  await close(teacher, a);
});

test('a class is opened, joined by code in either case; two devices drive; a seat is taken once', async () => {
  const teacher = await teach();
  await settles(async () => (await teacher.page.locator('.joining .letters').innerText()).replace(/\s/g, ''), teacher.code);
  await reads(teacher.page.locator('.joining'), /Only this computer reaches laglab/);
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
  await until(async () => (await teacher.page.locator('.come').innerText()).includes('3 have joined'), 'three have joined');
  const menu = await teacher.more();
  await until(async () => /round trip [\d.]+ ms, simulated lag 150 ms/.test(await menu.locator('.seats').innerText()), 'the round trip');
  await button(teacher.page, 'Close').click();
  const board = (await sessionOf(teacher.page)).id;
  await settles(() => sessionOf(watcher.page), { id: board, owner: false });
  await settles(async () => (await sessionOf(a.page))?.id, board);

  await teacher.put({ phase: 'run' });
  await until(async () => (await teacher.state()).status === 'playing', 'the run');
  await until(async () => (await paramsOf(a.page)).players.every((p) => p.control === 'person'), 'two persons');
  const pad = a.page.getByRole('button', { name: 'Throttle, Player A' });
  const box = await pad.boundingBox();
  assert.ok(box && box.width >= 64 && box.height >= 64, JSON.stringify(box));
  await reads(pad, /^Go$/);
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
  await (await teacher.more()).getByLabel('Choices').selectOption('5');
  await teacher.page.keyboard.press('Escape');
  await teacher.on('predict');
  await a.page.getByRole('radio').nth(4).waitFor();
  for (const row of await a.page.locator('.answer').all()) assert.ok(((await row.boundingBox())?.height ?? 0) >= 44);
  const view = await a.page.locator('#app').boundingBox();
  assert.ok(view && view.height > 150, `room for a view of ${view?.height} px`);
  const drawn = () =>
    a.page.locator('canvas[data-view="1"]').evaluate((/** @type {any} */ canvas) => {
      const scale = devicePixelRatio;
      return Math.abs(canvas.width - scale * canvas.clientWidth) <= 1 && Math.abs(canvas.height - scale * canvas.clientHeight) <= 1;
    });
  await until(drawn, 'the view is drawn again at its new height');
  await a.page.getByRole('radio').nth(1).check();
  await watcher.page.getByRole('radio').nth(4).waitFor();
  await watcher.page.keyboard.press('3');
  await until(async () => /^2\s+of 2 have answered$/.test(await teacher.page.locator('.comers .count').innerText()), 'two votes');
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

  await teacher.on('locked');
  for (const { page } of [teacher, a, watcher]) await page.locator('.tally').getByText('2 of 2 chose Choice 2.').waitFor();
  await settles(() => watcher.page.locator('.tally b').allInnerTexts(), ['0', '2', '0', '0', '0']);
  assert.equal(await a.page.getByRole('radio').count(), 0, 'no more votes');

  await teacher.on('run');
  await teacher.on('explain');
  await teacher.on('predict');
  assert.equal((await teacher.state()).votes, 0, 'a new question');
  await a.page.getByText('Choose one.').waitFor();
  await silent([teacher, a, watcher]);
  quiet([teacher, a, watcher]);
  await close(teacher, a, watcher);
});

/** Where a page shows more than its screen, or type that is too small. */
const misfits = (page, least) =>
  page.evaluate((px) => {
    const found = [];
    if (document.documentElement.scrollWidth > innerWidth) found.push(`${document.documentElement.scrollWidth} px wide`);
    if (document.documentElement.scrollHeight > innerHeight + 1) found.push(`${document.documentElement.scrollHeight} px high`);
    for (const element of document.querySelectorAll('#class *, #app')) {
      const box = element.getBoundingClientRect();
      if (!(element instanceof HTMLElement) || box.height === 0 || element.closest('.unseen')) continue;
      if (box.bottom > innerHeight + 1 || box.right > innerWidth + 1)
        found.push(`${element.className} ends at ${box.right}, ${box.bottom}`);
      const own = [...element.childNodes].some((node) => node.nodeType === Node.TEXT_NODE && node.textContent?.trim());
      if (own && Number.parseFloat(getComputedStyle(element).fontSize) * (element.currentCSSZoom ?? 1) < px - 0.1)
        found.push(`${element.className || element.tagName} ${getComputedStyle(element).fontSize}: ${element.textContent}`);
      if (element.matches('.classwords, .tally, .joining, .choices, .comers') && element.scrollHeight > element.clientHeight + 2)
        found.push(`${element.className} overflows by ${element.scrollHeight - element.clientHeight} px`);
    }
    return found;
  }, least);

for (const [from, at, question] of [
  ['the first page', '', 'late_answer'],
  ['a lesson', '#lesson=in_the_past', 'in_the_past'],
])
  test(`from ${from} a class is open with its question on the projector after two presses`, async () => {
    const visitor = await open(daemon.url + at);
    await button(visitor.page, at === '' ? 'Class' : 'Ask my class').click();
    const teacher = await opened(visitor);
    assert.equal((await teacher.state()).lesson, question);
    await teacher.on('predict');
    const { steps, choices } = JSON.parse(readFileSync(new URL(`../../www/lessons/${question}.json`, import.meta.url), 'utf8'));
    const asked = await reads(teacher.page.locator('.asked'), /\?$/);
    assert.equal(asked.slice(0, 12), steps.predict.en.slice(0, 12));
    assert.equal(await teacher.page.locator('.choices li').count(), choices.length);
    assert.equal(await teacher.page.locator('.top, .bar, .methods').count(), 0, 'no workbench');
    await until(() => teacher.page.locator('canvas[data-view="1"]').isVisible(), 'the first view');
    assert.equal(await teacher.page.locator('canvas[data-view="0"]').isVisible(), false);
    quiet([visitor]);
    await visitor.close();
  });

test('a whole lesson by Next alone; phones show the same words; each says why nothing moves', async () => {
  const lesson = JSON.parse(readFileSync(new URL('../../www/lessons/late_answer.json', import.meta.url), 'utf8')),
    plain = (/** @type {string} */ text) => text.replace(/\{.*/, '').trim();
  const visitor = await open(daemon.url);
  await button(visitor.page, 'Class').click();
  const teacher = await opened(visitor);
  const a = await open(`${daemon.url}${teacher.code}`, PHONE),
    b = await open(`${daemon.url}${teacher.code}`, PHONE);
  for (const { page } of [a, b]) await button(page, 'Watch').click();
  await a.page.getByText('You are in. Watch the board').waitFor();
  const fits = async (/** @type {string} */ what) => {
    await refreshes(teacher.page);
    assert.deepEqual(await misfits(teacher.page, (26 * 1366) / 1920), [], what);
    assert.deepEqual(await misfits(a.page, 13), [], what);
  };
  await fits('join');
  await teacher.on('predict');
  assert.deepEqual(
    await teacher.page.locator('.choices small').allInnerTexts(),
    lesson.choices.map(({ hint }) => hint.en),
  );
  /** What the sentence is about is marked in the drawing, whose runs the projector has recorded. */
  const stands = (/** @type {string} */ view, /** @type {string} */ to, /** @type {string} */ what) =>
    until(async () => {
      const marked = await teacher.page.evaluate(() => globalThis.laglab.shown());
      return marked?.view === view && marked.to === to && marked.px >= 40 && marked.seen;
    }, `${what}: the band`);
  const says = (page, /** @type {string} */ text) => page.locator('#class').getByText(plain(text)).first().waitFor();
  for (const { page } of [teacher, a]) await says(page, lesson.steps.predict.en);
  await settles(() => a.page.locator('.answer span').allInnerTexts(), await teacher.page.locator('.choices b').allInnerTexts());
  await a.page.getByRole('radio').nth(1).check();
  await b.page.getByRole('radio').nth(2).check();
  await a.page.getByText('Sent: 150 ms').waitFor();
  await reads(teacher.page.locator('.count'), /^2\s+of 2 have answered$/);
  assert.equal((await teacher.state()).tally, null);
  for (const { page } of [teacher, a, b])
    assert.equal(await page.locator('.tally, #class svg:not(.qr) rect').count(), 0, 'no bar before the lock');
  await fits('predict');
  await teacher.on('locked');
  await a.page.getByText('Answers are locked. Watch the board.').waitFor();
  for (const { page } of [teacher, a]) await reads(page.locator('.tally'), /150 ms/);
  assert.equal(await a.page.getByText('right', { exact: true }).count(), 0);
  await fits('locked');
  await teacher.on(['run', 'stopped']);
  await until(async () => (await teacher.state()).phase === 'stopped', 'the stop');
  assert.equal((await teacher.state()).tick, lesson.stop_tick);
  for (const { page } of [teacher, a]) await says(page, lesson.steps.observe.en);
  assert.equal(await teacher.page.locator('canvas[data-view="0"]').isVisible(), true, 'all views');
  await stands('player_0', 'A.brake', 'run');
  await fits('run');
  await teacher.on('explain');
  for (const { page } of [teacher, a]) await says(page, lesson.steps.explain.en);
  await reads(teacher.page.locator('.measured'), new RegExp(`${lesson.answer.says.en}\\s+${lesson.answer.value} ms`));
  await reads(teacher.page.locator('.reasoned'), new RegExp(`^1 of you said 150 ms: ${lesson.choices[1].why.en}`));
  await reads(a.page.locator('.reasoned'), new RegExp(`^You said 150 ms: ${lesson.choices[1].why.en}`));
  await reads(b.page.locator('.reasoned'), /^You said 3\d\d ms:/);
  await reads(a.page.locator('.tally li').nth(1), /yours/);
  await reads(a.page.locator('.tally li[data-right="true"]'), /right/);
  for (const { page } of [teacher, a]) await reads(page.locator('.timeline'), /150 there/);
  await fits('explain');
  await reads(next(teacher.page), new RegExp(`^Next: ${lesson.change.says.en}$`));
  const before = (await teacher.state()).board;
  await teacher.on('change');
  assert.notEqual((await teacher.state()).board, before);
  for (const { page } of [teacher, a]) await says(page, lesson.steps.change.en);
  await reads(teacher.page.locator('.compared'), /Before\s+3\d\d ms\s+With the change\s+0 ms/);
  const { board } = await teacher.state();
  for (const [path, value] of Object.entries(lesson.change.set)) {
    const { params } = (await api(daemon.url, `sessions/${board}`)).body;
    assert.equal(
      path.split('.').reduce((at, name) => at[name], params),
      value,
      path,
    );
  }
  await until(
    async () => (await teacher.state()).status === 'paused' && (await teacher.state()).tick === lesson.change.stop_tick,
    'its stop',
  );
  await stands('first', 'A.brake', 'first run');
  await fits('change');
  await reads(next(teacher.page), /^Next: question 2$/);
  await teacher.on('predict');
  assert.deepEqual([(await teacher.state()).lesson, (await teacher.state()).votes], ['jump_back', 0]);
  await a.page.getByText('Choose one.').waitFor();
  quiet([visitor, a, b]);
  await close(visitor, a, b);
});

test('the plot that a sentence is about is on the projector', async () => {
  const visitor = await open(`${daemon.url}#lesson=keeps_energy`);
  await button(visitor.page, 'Ask my class').click();
  const teacher = await opened(visitor);
  const energy = visitor.page.locator('#plot-energy');
  for (const phase of ['stopped', 'explain']) {
    await teacher.put({ phase });
    await until(() => energy.isVisible(), `${phase}: the plot of the energy`);
  }
  quiet([visitor]);
  await visitor.close();
});

test('seats stay for the next question; Free plays, and a phone that drives says when the teacher has paused', async () => {
  const teacher = await teach();
  const a = await student(teacher.code, 'Play A', PHONE),
    b = await student(teacher.code, 'Play B', PHONE);
  await until(async () => (await teacher.state()).seats.every(({ state }) => state === 'held'), 'two seats');
  await (await teacher.more()).getByLabel('Question', { exact: true }).selectOption('in_the_past');
  await until(async () => (await teacher.state()).lesson === 'in_the_past', 'the question');
  const { board } = await teacher.state();
  for (const { page } of [a, b]) {
    await until(async () => (await sessionOf(page))?.id === board, 'its board');
    await page.getByText('You drive when the teacher lets all drive.').waitFor();
  }
  await reads(chip(a.page), /You play A/);
  await reads(chip(b.page), /You play B/);
  assert.deepEqual(
    (await teacher.state()).seats.map(({ state }) => state),
    ['held', 'held'],
  );
  const controls = async () => (await api(daemon.url, `sessions/${board}`)).body.params.players.map(({ control }) => control);
  assert.deepEqual(await controls(), ['script', 'script'], 'the lesson shows what its script does');
  await button(teacher.page, 'Let all drive').click();
  await until(async () => (await teacher.state()).status === 'playing', 'the board plays');
  await settles(controls, ['person', 'person']);
  await a.page.getByText('You drive: hold a key or a pad.').waitFor();
  const pad = a.page.getByRole('button', { name: 'Throttle, Player A' });
  const box = await pad.boundingBox();
  await a.page.mouse.move(box.x + 20, box.y + 20);
  await a.page.mouse.down();
  await until(async () => (await frameOf(a.page)).views[1].entities[0].vx > 0.5, 'A drives');
  await a.page.mouse.up();
  assert.deepEqual(await misfits(a.page, 13), []);
  await button(teacher.page, 'More for the teacher').click();
  await button(teacher.page, 'Freeze all').click();
  await a.page.getByText('The teacher has paused all pages').waitFor();
  await button(teacher.page, 'Unfreeze').click();
  await teacher.page.keyboard.press('Escape');
  const { board: shown } = await teacher.state(),
    key = await teacher.page.evaluate(() => JSON.parse(sessionStorage.getItem('laglab.class') ?? '{}').secret);
  await until(async () => (await teacher.state()).status === 'playing', 'it goes on');
  await api(daemon.url, `sessions/${shown}/control`, { op: 'pause' }, key);
  await a.page.getByText('The teacher has paused.').waitFor();
  quiet([teacher, a, b]);
  await close(teacher, a, b);
});

test('the join page says that a question is open; a tab that waits there follows another tab of its browser', async () => {
  const teacher = await teach();
  await teacher.on('predict');
  const a = await open(`${daemon.url}${teacher.code}`, PHONE);
  await a.page.getByText('A question is open').waitFor();
  const tab = await a.context.newPage();
  await tab.goto(`${daemon.url}${teacher.code}`);
  await button(tab, 'Play A').waitFor();
  await button(a.page, 'Play A').click();
  await reads(chip(tab), /You play A/);
  assert.equal((await teacher.state()).n, 1);
  quiet([teacher, a]);
  await close(teacher, a);
});

test('freeze reaches all pages, bringing leads all to the board; a copy is kept', async () => {
  const teacher = await teach();
  await teacher.more();
  await button(teacher.page, 'Let all drive').click();
  await until(async () => (await teacher.state()).status === 'playing', 'Free plays');
  const a = await student(teacher.code, 'Play A', PHONE),
    b = await student(teacher.code, 'Play B'),
    copy = await student(teacher.code, 'My own copy');
  await reads(chip(copy.page), /^Your copy$/);
  const board = (await sessionOf(teacher.page)).id;
  const own = await until(async () => {
    const now = await sessionOf(copy.page);
    return now && now.id !== board && now;
  }, 'a session of its own');
  await button(copy.page, 'Pause').waitFor();

  await teacher.more();
  const frozen = ({ page }) => page.getByText('The teacher has paused all pages').first().waitFor();
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
  await teacher.on('predict');
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
  await teacher.put({ phase: 'run' });
  await a.page.locator('.view[data-drive="0"]').focus();
  await a.page.keyboard.down('ArrowRight');
  await until(async () => (await frameOf(a.page)).views[0].entities[0].vx > 0.5, 'it drives again');
  await a.page.keyboard.up('ArrowRight');
  await close(teacher, a);
});

test('the teacher: a reload, another scenario, a second device, the end', async () => {
  const teacher = await teach();
  const watcher = await student(teacher.code, 'Watch');
  const menu = await teacher.more();
  await teacher.page.getByText('Steer from another device').click();
  const remote = await reads(() => menu.locator('details input').inputValue(), /^http/);
  const phone = await open(remote, PHONE);
  await next(phone.page).waitFor();
  assert.ok(phone.page.url().endsWith(`#class=${teacher.code}`), phone.page.url());
  await next(phone.page).click();
  await until(async () => (await teacher.state()).phase === 'predict', 'the remote control');

  await button(teacher.page, 'Show the workbench').click();
  await button(teacher.page, 'Back to the stage').waitFor();
  await teacher.page.reload();
  await shown(teacher.page);
  await settles(async () => (await sessionOf(teacher.page))?.owner, true);
  await pick(teacher.page, 'cannon');
  await until(async () => (await paramsOf(watcher.page))?.game === 'cannon', 'another board on every page');
  await until(async () => (await paramsOf(phone.page))?.game === 'cannon', 'on the second device too');
  await silent([teacher, phone]);
  await button(phone.page, 'More for the teacher').click();
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
  await teacher.on('predict');
  await teacher.more();
  const devices = teacher.page.locator('.devices'),
    device = (/** @type {number} */ n) => devices.getByRole('button', { name: new RegExp(`^Device ${n},`) });
  await settles(() => devices.locator('.device b').allInnerTexts(), ['1', '2']);
  await until(async () => /plays A, connected/.test((await device(1).textContent()) ?? ''), 'what it does');
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
  await teacher.on('predict');
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
  await next(page).waitFor();
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

const SIZES = [{ width: 1920, height: 1080 }, WIDE, { width: 1024, height: 768 }];
for (const size of SIZES)
  for (const lang of ['en', 'de'])
    sweep(size === WIDE && lang === 'de')(
      `every phase fits ${size.width} px and a phone of 390 px in ${lang}, and axe finds nothing`,
      async () => {
        const words = JSON.parse(readFileSync(new URL(`../../www/words/${lang}.json`, import.meta.url), 'utf8')),
          visitor = await open(`${daemon.url}?lang=${lang}#lesson=who_waits`, size);
        await visitor.page.locator('.askclass').click();
        await next(visitor.page).waitFor();
        const code = new URL(visitor.page.url()).hash.replace('#class=', '');
        const a = await open(`${daemon.url}?lang=${lang}#class=${code}`, PHONE),
          laptop = await open(`${daemon.url}?lang=${lang}#class=${code}`, WIDE);
        assert.deepEqual(await axe(a.page), [], 'join');
        await button(a.page, words.class['class.play'].replace('{player}', 'A')).click();
        await button(laptop.page, words.class['class.watch']).click();
        const state = async () => (await api(daemon.url, `classes/${code}`)).body.state;
        for (const phase of ['lobby', 'predict', 'locked', 'run', 'explain', 'change']) {
          if (phase !== 'lobby') await next(visitor.page).click();
          await until(async () => (await state()).phase === phase, phase);
          for (const { page } of [visitor, a, laptop]) {
            await page.locator(`[data-phase="${phase}"]`).waitFor();
            await refreshes(page, 6);
            assert.deepEqual(await axe(page), [], phase);
          }
          assert.deepEqual(await misfits(visitor.page, 26 * Math.min(size.width / 1920, size.height / 1080)), [], phase);
          for (const { page } of [a, laptop]) assert.deepEqual(await misfits(page, 13), [], phase);
          if (phase === 'predict') await a.page.getByRole('radio').nth(1).check();
        }
        await button(visitor.page, words.class['class.more']).click();
        await button(visitor.page, words.class['class.remote']).or(visitor.page.getByText(words.class['class.remote'])).first().waitFor();
        assert.deepEqual(await axe(visitor.page), [], 'what is seldom needed');
        await visitor.page.locator('.device').first().click();
        await button(visitor.page, words.class['class.to_workbench']).click();
        await visitor.page.locator('[data-class="teach"]').waitFor();
        assert.deepEqual(await axe(visitor.page), [], 'the workbench');
        await close(visitor, a, laptop);
      },
    );
