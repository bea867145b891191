// A class of 31 pages in one browser: a projector, twelve laptops and eighteen phones with touch, over a network whose bytes are counted.
// They join by code, two race from two devices, all predict, run, are frozen, brought to the board and released; some make copies. How soon
// every page shows a change, what is sent, what the daemon costs. Needs root, for a network of its own.
//   bench/run classroom [--quick] [--shots=FOLDER]      --shots: images of every step at three sizes
import { mkdirSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { digits, median, pause, printTable, say, writeCsv } from './lib.mjs';
import { startDaemon } from '../tests/lib/daemon.mjs';
import { cpu_s } from '../tests/lib/hostile.mjs';
import { openLan } from '../tests/lib/lan.mjs';
import { api, button, launch, shown, until } from '../tests/page/lib.mjs';

const quick = process.argv.includes('--quick'),
  shots = process.argv.find((word) => word.startsWith('--shots='))?.slice(8) ?? '';
const LAPTOPS = quick ? 2 : 12,
  PHONES = quick ? 3 : 18,
  COPIES = quick ? 1 : 4;
const AT_ONCE = 3; /* students who arrive in the same moment */
const RUN_MS = 10000,
  LONG_MS = 60000;
const MOST_MBIT_S = 2,
  FREEZE_MS = 1000,
  BRING_MS = 2000;
const PROJECTOR = { viewport: { width: 1920, height: 1080 } },
  LAPTOP = { viewport: { width: 1366, height: 768 } },
  PHONE = { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true };
if (shots) mkdirSync(shots, { recursive: true });

const lan = openLan(),
  daemon = await startDaemon(lan),
  browser = await launch({ whole: true });

/** CPU time of all processors that was not idle, and the number of processors. */
function machine_s() {
  const [all] = readFileSync('/proc/stat', 'utf8').split('\n');
  const [user, nice, system, idle, wait, ...rest] = all.split(/\s+/).slice(1, 9).map(Number);
  return {
    busy: (user + nice + system + rest.reduce((a, b) => a + b)) / 100,
    all: (user + nice + system + idle + wait + rest.reduce((a, b) => a + b)) / 100,
  };
}
const spent = () => ({ ms: performance.now(), bytes: lan.bytes(), daemon: cpu_s(daemon.pid), ...machine_s() });
/** What was used since then. */
function since(begun) {
  const now = spent(),
    s = (now.ms - begun.ms) / 1000;
  return {
    mbit_s: ((now.bytes - begun.bytes) * 8) / 1e6 / s,
    mib: (now.bytes - begun.bytes) / 2 ** 20,
    daemon: (100 * (now.daemon - begun.daemon)) / s,
    machine: (100 * (now.busy - begun.busy)) / (now.all - begun.all),
    s,
  };
}

const LAST_STEP = 'complaints of consoles';
const complaints = [];
/** A device of its own. */
async function device(size, name) {
  const context = await browser.newContext(size);
  const page = await context.newPage();
  page.setDefaultTimeout(LONG_MS);
  page.on('console', (message) => {
    if (['error', 'warning'].includes(message.type())) complaints.push(`${name}: ${message.text()}`);
  });
  page.on('pageerror', (error) => complaints.push(`${name}: ${error.message}`));
  await page.addInitScript(() => {
    addEventListener('click', () => (globalThis.clicked_at = Date.now()), true);
    /** Notes when this page shows something: `kind` of what, and which. */
    globalThis.await_shown = (/** @type {string} */ kind, /** @type {string} */ what) => {
      const holds = () => {
        const lab = globalThis.laglab?.();
        if (kind === 'there') return document.querySelector(what) !== null;
        if (kind === 'gone') return document.querySelector(what) === null;
        if (kind === 'board') return lab?.session?.id === what && lab.frame !== null;
        return lab?.frame !== null && (lab.frame.flags & 2) !== 0; /* it plays */
      };
      globalThis.shown_at = 0;
      const timer = setInterval(() => {
        if (!holds()) return;
        globalThis.shown_at = Date.now();
        clearInterval(timer);
      }, 10);
    };
  });
  return { page, name, size, role: 'watch' };
}

/** Students in groups, as they come through the door. */
async function inGroups(list, work) {
  for (let i = 0; i < list.length; i += AT_ONCE) await Promise.all(list.slice(i, i + AT_ONCE).map(work));
}

const rows = [];
function row(step, figure, unit, goal = '', more = {}) {
  rows.push({ step, figure: digits(figure), unit, goal, ...more });
  console.log(JSON.stringify(rows.at(-1))); /* it takes minutes, and may be ended */
}

let teacher, students, all;
/** The step as the projector, a laptop and two phones (one plays) show it. */
async function shot(step) {
  if (!shots) return;
  const seen = [
    teacher,
    ...['play', 'watch'].map((role) => students.find((s) => s.size === PHONE && s.role === role)),
    students.find((s) => s.size === LAPTOP),
  ];
  for (const one of seen.filter(Boolean)) await one.page.screenshot({ path: join(shots, `${step}-${one.name}.png`) });
}

/** Does something on the teacher's page, and measures until each of the pages shows what follows. */
async function everybody(step, act, pages, kind, what, goal) {
  await Promise.all(pages.map(({ page }) => page.evaluate(([k, w]) => globalThis.await_shown(k, w), [kind, what])));
  const begun = spent();
  await act();
  const at = await teacher.page.evaluate(() => globalThis.clicked_at);
  const times = await Promise.all(
    pages.map(({ page }) =>
      page.waitForFunction(() => globalThis.shown_at, null, { polling: 200, timeout: LONG_MS }).then((handle) => handle.jsonValue()),
    ),
  );
  const ms = times.map((time) => time - at),
    worst = Math.max(...ms);
  const { mbit_s } = since(begun);
  row(step, worst, 'ms', goal ? `${goal}` : '', {
    median: digits(median(ms)),
    pages: pages.length,
    mbit_s: digits(mbit_s),
    met: goal ? worst <= goal : '',
  });
  await shot(step.replace(/\W+/g, '-'));
}

try {
  const loading = spent();
  teacher = await device(PROJECTOR, 'projector');
  await teacher.page.goto(
    `${daemon.url}?scenario=race&theme=projector&set=duration_s:600&set=players.0.script:idle&set=players.1.script:idle`,
  );
  await shown(teacher.page);
  await button(teacher.page, 'Class').click();
  await button(teacher.page, 'Show the board').waitFor();
  const code = new URL(teacher.page.url()).hash.replace('#class=', '');
  const { id } = (await api(daemon.url, `classes/${code}`)).body;
  const state = async () => (await api(daemon.url, `classes/${id}`)).body.state;
  await until(async () => (await state()).seats.length === 2, 'the seats', LONG_MS);

  students = [];
  for (let i = 0; i < LAPTOPS; i++) students.push(await device(LAPTOP, `laptop${i + 1}`));
  for (let i = 0; i < PHONES; i++) students.push(await device(PHONE, `phone${i + 1}`));
  all = [teacher, ...students];
  students[0].role = students[LAPTOPS].role = 'play';
  await shot('lobby');
  const free = students.filter(({ role }) => role !== 'play').slice(-COPIES);
  const joining = performance.now();
  /* The first two by the first page's field, the others by the address that the projector shows. */
  const [b, a] = [students[0], students[LAPTOPS]];
  await inGroups(students, async (one) => {
    const { page } = one;
    if (one.role === 'play') {
      await page.goto(daemon.url);
      await page.getByLabel('Code of a class').fill(code.toLowerCase());
      await page.getByRole('button', { name: 'Join', exact: true }).click();
    } else await page.goto(`${daemon.url}${code}`);
    const part = one === a ? 'Play A' : one === b ? 'Play B' : 'Watch';
    await button(page, part).waitFor();
    if (shots && (one === a || one === b)) await page.screenshot({ path: join(shots, `join-${one.name}.png`) });
    await button(page, part).click();
    await shown(page)
      .catch(() => shown(page))
      .catch(() => shown(page)); /* ten seconds each */
  });
  await until(async () => (await state()).n === students.length, 'all have joined', LONG_MS);
  const loaded = since(loading);
  row('all have joined', (performance.now() - joining) / 1000, 's', '', { pages: all.length });
  row('bytes of all pages that load', loaded.mib, 'MiB', '', { pages: all.length, mbit_s: digits(loaded.mbit_s) });
  await shot('joined');

  await everybody('predict', () => button(teacher.page, 'Predict').click(), students, 'there', '.answer', 0);
  const voting = performance.now();
  await inGroups(students, async ({ page, size }, i) => {
    if (size === PHONE)
      await page
        .locator('.answer')
        .nth(i % 3)
        .tap();
    else await page.keyboard.press(String(1 + (i % 3)));
    await page.getByText(/Sent: Choice/).waitFor();
  });
  await until(async () => (await state()).votes === students.length, 'all have voted', LONG_MS);
  row('all have voted', (performance.now() - voting) / 1000, 's', '', { pages: students.length });
  await shot('voted');
  await everybody('lock and tally', () => button(teacher.page, 'Lock').click(), all, 'there', '.tally', 0);

  await button(teacher.page, 'Show the board').click();
  await shown(teacher.page);
  await everybody('run', () => button(teacher.page, 'Run').click(), students, 'plays', '', 0);
  const cars = () =>
    b.page.evaluate(() =>
      globalThis
        .laglab()
        .frame.plain()
        .entities.filter((one) => one.view === 0),
    );
  const pad = await a.page.getByRole('button', { name: 'Throttle, Player A' }).boundingBox();
  await a.page.mouse.move(pad.x + 20, pad.y + 20);
  await a.page.mouse.down();
  await b.page.locator('.view[data-drive="1"]').focus();
  await b.page.keyboard.down('ArrowRight');
  await until(async () => (await cars()).every((car) => car.vx > 0.5), 'both drive, from two devices', LONG_MS);
  const drawn = () => Promise.all(all.map(({ page }) => page.evaluate(() => globalThis.laglab().counts.drawn)));
  const before = await drawn(),
    running = spent();
  await pause(RUN_MS);
  const used = since(running),
    hz = (await drawn()).map((n, i) => (n - before[i]) / used.s);
  row('network while the board runs', used.mbit_s, 'Mbit/s', MOST_MBIT_S, { pages: all.length, met: used.mbit_s <= MOST_MBIT_S });
  row('daemon while the board runs', used.daemon, '% of a core', '', { pages: all.length });
  row('machine while the board runs', used.machine, '% of all cores', '', { pages: all.length });
  row('slowest page, drawn', Math.min(...hz.slice(1)), 'Hz', '', { median: digits(median(hz.slice(1))), pages: students.length });
  row('projector, drawn', hz[0], 'Hz', '', { pages: 1 });
  await shot('running');
  await everybody('freeze', () => button(teacher.page, 'Freeze all').click(), students, 'there', '.state[data-kind="frozen"]', FREEZE_MS);
  await a.page.mouse.up();
  await b.page.keyboard.up('ArrowRight');
  await everybody('unfreeze', () => button(teacher.page, 'Unfreeze').click(), students, 'gone', '.state[data-kind="frozen"]', 0);

  await button(teacher.page, 'Free').click();
  const board = (await state()).board;
  await inGroups(free, async (one) => {
    await button(one.page, 'Play or watch').click();
    await button(one.page, 'My own copy').click();
    await one.page.waitForFunction((of) => globalThis.laglab().session?.id !== of && globalThis.laglab().frame !== null, board);
    await button(one.page, 'Play').or(button(one.page, 'Pause')).waitFor();
    if ((await button(one.page, 'Play').count()) > 0) await button(one.page, 'Play').click();
    await button(one.page, 'Pause').waitFor();
    one.role = 'copy';
  });
  row('copies', free.length, 'copies', '', { pages: free.length });
  if (shots) await free[0].page.screenshot({ path: join(shots, 'copy.png') });
  await everybody(
    'freeze, with copies',
    () => button(teacher.page, 'Freeze all').click(),
    students,
    'there',
    '.state[data-kind="frozen"]',
    FREEZE_MS,
  );
  await everybody(
    'unfreeze, with copies',
    () => button(teacher.page, 'Unfreeze').click(),
    students,
    'gone',
    '.state[data-kind="frozen"]',
    0,
  );
  await everybody('bring all to the board', () => button(teacher.page, 'Bring all here').click(), free, 'board', board, BRING_MS);
  await button(teacher.page, 'Release from the board').click();
  await inGroups(free, async ({ page }) => {
    await until(() => button(page, 'My copy').isEnabled(), 'released', LONG_MS);
    await button(page, 'My copy').click();
    await page.waitForFunction((of) => globalThis.laglab().session?.id !== of && globalThis.laglab().frame !== null, board);
  });

  await button(teacher.page, 'Lobby').click();
  await teacher.page.getByLabel('Question', { exact: true }).selectOption('late_answer');
  await until(async () => (await state()).lesson === 'late_answer', 'a lesson', LONG_MS);
  await everybody('question of a lesson', () => button(teacher.page, 'Predict').click(), students, 'there', '.answer', 0);
  await Promise.all(students.map(({ page }) => page.locator('.answer').nth(2).click()));
  await until(async () => (await state()).votes === students.length, 'all have voted', LONG_MS);
  await button(teacher.page, 'Lock').click();
  await button(teacher.page, 'Run').click();
  await until(async () => (await state()).phase === 'stopped', 'the stop', LONG_MS);
  await button(teacher.page, 'Explain').click();
  await Promise.all(all.map(({ page }) => page.locator('.tally').getByText('right').first().waitFor()));
  await shot('explain');
  if (complaints.length > 0) say(`complaints: ${[...new Set(complaints)].slice(0, 8).join('; ')}`);
  row(LAST_STEP, complaints.length, '', 0, { pages: all.length, met: complaints.length === 0 });
} finally {
  const table = rows.map(({ step, figure, unit, median: mid = '', goal, met = '', pages, mbit_s = '' }) => ({
    step,
    figure,
    unit,
    median: mid,
    goal,
    met,
    pages,
    mbit_s,
  }));
  if (table.length > 0) printTable(`A class of ${1 + LAPTOPS + PHONES} pages in one browser`, table);
  if (!quick && table.at(-1)?.step === LAST_STEP)
    writeCsv(
      'classroom',
      'bench/run classroom',
      {
        step: 'what the teacher does, or what is measured',
        figure: 'of the page that is last, or of all',
        unit: 'of the figure',
        median: 'of the pages',
        goal: 'the most that is allowed',
        met: 'whether it is',
        pages: 'that are meant',
        mbit_s: 'network in both directions meanwhile',
      },
      table,
    );
  await browser.close();
  await daemon.stop();
  lan.close();
}
if (rows.some(({ met }) => met === false)) process.exitCode = 1;
