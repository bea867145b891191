// Opening the page: first frame, motion, no noise, no other hosts.
import assert from 'node:assert/strict';
import { after, before } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import {
  api,
  costOf,
  dialogOf,
  draws,
  frameOf,
  launch,
  pause,
  pictures,
  reads,
  refreshes,
  runOn,
  sessionOf,
  settles,
  shown,
  SIZES,
  tickOf,
  until,
  visit,
  pick,
} from './lib.mjs';
import { sweep, test } from './tiers.mjs';

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
  await (await visit(browser, `${daemon.url}#race`)).close(); /* the browser's own start is not the page's */
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

const firstFrame = (page) => page.evaluate(() => performance.getEntriesByName('laglab-first-frame')[0]?.startTime);

test('marks its first frame, whose time bench/run page measures', async () => {
  const { page, close } = await visit(browser, `${daemon.url}#race`);
  assert.ok((await firstFrame(page)) > 0);
  await close();
});

test('moves without a click, with a session of its own', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}#race`);
  const one = await pictures(page),
    tick = (await frameOf(page)).tick;
  await until(async () => (await frameOf(page)).tick > tick + 10, 'it goes on');
  await until(async () => (await pictures(page)) !== one, 'it is drawn');
  assert.equal((await sessionOf(page)).owner, true);
  await settles(() => page.locator('canvas[data-view]').count(), 3);
  await reads(() => page.title(), /laglab$/);
  assert.deepEqual(complaints, []);
  await close();
});

test('requests go to the daemon only', async () => {
  const { page, requests, close } = await visit(browser, `${daemon.url}#race`);
  await page.waitForSelector('#error-chart canvas');
  assert.ok(requests.length > 5);
  assert.deepEqual(
    requests.filter((r) => new URL(r.url()).origin !== new URL(daemon.url).origin).map((r) => r.url()),
    [],
  );
  await close();
});

/** What crosses the wire for an address that nothing is kept of; heads included. early: until something is shown, with all of what was
 * asked for by then; controls: until the controls are there; all: until nothing more comes, without the costs that are asked for again.
 * @param {string} at @param {string} shows a selector, or the name of a mark
 * @returns {Promise<{early: number, controls: number, requests: number, all: number, names: string[]}>} */
async function wire(at, shows) {
  const { page, context, close } = await visit(browser, 'about:blank', { wait: false });
  const devtools = await context.newCDPSession(page);
  /** @type {Map<string, {name: string, method: string, from: number, to: number, bytes: number}>} */
  const seen = new Map();
  let epoch = 0; /* of the other events' times, s */
  devtools.on('Network.requestWillBeSent', ({ requestId, wallTime, timestamp, request }) => {
    epoch = wallTime - timestamp;
    const name = request.url.replace(daemon.url, '/');
    seen.set(requestId, { name, method: request.method, from: 1000 * wallTime, to: Infinity, bytes: 0 });
  });
  devtools.on('Network.loadingFinished', ({ requestId, timestamp, encodedDataLength }) => {
    const one = seen.get(requestId);
    if (one) Object.assign(one, { to: 1000 * (epoch + timestamp), bytes: encodedDataLength });
  });
  await devtools.send('Network.enable');
  await page.addInitScript((what) => {
    if (!what.startsWith('.')) return;
    const watch = new MutationObserver(() => {
      if (document.querySelector(what) === null) return;
      watch.disconnect();
      requestAnimationFrame(() => performance.mark(what));
    });
    watch.observe(document, { childList: true, subtree: true });
  }, shows);
  await page.goto(daemon.url + at);
  const shown_at = await page
    .waitForFunction((what) => {
      const mark = performance.getEntriesByName(what)[0];
      return mark ? performance.timeOrigin + mark.startTime : null;
    }, shows)
    .then((handle) => handle.jsonValue());
  let last = -1;
  await until(async () => {
    const now = [...seen.values()].reduce((sum, { bytes }) => sum + bytes, 0);
    const still = now === last && [...seen.values()].some(({ name }) => /\/js\/more-\w+\.js$/.test(name));
    last = now;
    await refreshes(page, 30);
    return still;
  }, 'all is read');
  await close();
  const list = [...seen.values()],
    sum = (/** @type {{bytes: number}[]} */ of) => of.reduce((total, { bytes }) => total + bytes, 0),
    early = list.filter(({ from }) => from <= Number(shown_at)),
    schema = list.find(({ name }) => name.includes('/schema?')),
    costs = list.filter(({ name, method }) => method === 'GET' && /^\/api\/v1\/sessions\/\w+$/.test(name)),
    costs_s = ((costs.at(-1)?.from ?? 0) - (costs[0]?.from ?? 0)) / 1000;
  assert.ok(costs.length <= costs_s + 3 /* when it is opened, too */, `${costs.length} times in ${costs_s} s: once a second`);
  return {
    early: sum(early),
    controls: schema ? sum(list.filter(({ to }) => to <= schema.to)) : 0,
    requests: early.length,
    all: sum(list) - sum(costs.slice(1)),
    names: list.map(({ name }) => name),
  };
}

for (const language of ['en', 'de']) {
  for (const [lab, at, shows, most, all] of /** @type {[string, string, string, number, number][]} */ ([
    ['the first page', '', '.card', 115_000, 190_000],
    ['the race', '#race', 'laglab-first-frame', 100_000, 190_000],
    ['eight players', '&scenario=eight', 'laglab-first-frame', 100_000, 190_000],
    ['a fluid', '&scenario=fluid/two_discs&set=duration_s:60', 'laglab-first-frame', 135_000, 200_000],
    ['bodies', '&scenario=rigid/tumbler&set=duration_s:60', 'laglab-first-frame', 135_000, 200_000],
    ['methods', '&scenario=motion/two_orbits&set=duration_s:60', 'laglab-first-frame', 135_000, 200_000],
  ])) {
    sweep(language === 'de' || lab === 'the race')(
      `${lab} is shown after at most ${most} bytes, heads included, and no file is read twice: ${language}`,
      async () => {
        const { names, ...found } = await wire(`?lang=${language}${at}`, shows);
        assert.ok(found.early > 40_000 && found.early <= most && found.all <= all && found.requests <= 12, JSON.stringify(found));
        if (lab === 'the race') assert.ok(found.controls > found.early - 2000 && found.controls <= 110_000, JSON.stringify(found));
        const files = names.filter((name) => /\.(?:js|css|json)$/.test(name));
        assert.deepEqual(
          files.filter((name, i) => files.indexOf(name) !== i),
          [],
        );
      },
    );
  }
}

test('a frame lays the page out once in several, and draws what is on the screen', async () => {
  const { page, context, close } = await visit(browser, `${daemon.url}?scenario=eight`);
  await page.waitForSelector('#error-chart canvas');
  const devtools = await context.newCDPSession(page);
  await devtools.send('Performance.enable');
  const layouts = async () =>
    (await devtools.send('Performance.getMetrics')).metrics.find(({ name }) => name === 'LayoutCount')?.value ?? 0;
  const cleared = () =>
    page.evaluate(() => {
      const own = CanvasRenderingContext2D.prototype.clearRect,
        ids = new Set();
      CanvasRenderingContext2D.prototype.clearRect = function (x, y, w, h) {
        if (this.canvas.dataset.view !== undefined) ids.add(this.canvas.dataset.view);
        own.call(this, x, y, w, h);
      };
      globalThis.cleared = ids;
    });
  await runOn(page, 1);
  await cleared();
  const from = { drawn: (await page.evaluate(() => globalThis.laglab().counts)).drawn, layouts: await layouts() };
  await until(async () => (await page.evaluate(() => globalThis.laglab().counts)).drawn >= from.drawn + 60, 'sixty frames');
  const drawn = (await page.evaluate(() => globalThis.laglab().counts)).drawn - from.drawn,
    counted = (await layouts()) - from.layouts;
  assert.ok(counted > 0 && counted <= drawn / 2, `${counted} layouts in ${drawn} frames`);
  const seen = await page.evaluate(() => [...globalThis.cleared].sort()),
    onScreen = await page.evaluate(() => {
      const { bottom = 0 } = document.getElementById('views')?.getBoundingClientRect() ?? {}; // the bar of time covers the rest
      return [...document.querySelectorAll('canvas[data-view]')]
        .filter((canvas) => canvas.getBoundingClientRect().top < bottom)
        .map((canvas) => /** @type {HTMLElement} */ (canvas).dataset.view);
    });
  assert.ok(onScreen.length >= 3 && onScreen.length < 9, `${onScreen}`);
  for (const view of onScreen) assert.ok(seen.includes(view ?? ''), `${view} is drawn`);
  assert.ok(seen.length <= onScreen.length + 1, `${seen} drawn, ${onScreen} on the screen`);
  const lowest = page.locator('canvas[data-view="8"]');
  await lowest.scrollIntoViewIfNeeded();
  await until(() => page.evaluate(() => globalThis.cleared.has('8')), 'a view that is scrolled to is drawn');
  await close();
});

for (const [what, at, most, files] of /** @type {[string, string, number, number][]} */ ([
  ['the first page', '', 11, 9],
  ['a race', '#race', 11, 7],
  ['a lesson', '#lesson=late_answer&step=1', 20 /* a run of its own is made, read and deleted */, 9],
])) {
  test(`the first load of ${what} needs at most ${most} requests, ${files} of files, with what follows the first frame`, async () => {
    const { page, requests, complaints, close } = await visit(browser, 'about:blank', { wait: false });
    let sockets = 0;
    page.on('websocket', () => sockets++);
    await page.goto(daemon.url + at);
    await page.waitForFunction(() => document.querySelector('dialog'));
    if (at !== '')
      await page.waitForFunction(() => performance.getEntriesByType('resource').some(({ name }) => name.endsWith('_more.json')));
    await refreshes(page, 30);
    const all = requests.map((request) => `${request.method()} ${request.url()}`);
    assert.equal(sockets, 1);
    assert.ok(all.length + sockets <= most && all.length > 5, all.join('\n'));
    assert.ok(all.filter((one) => !one.includes('/api/')).length <= files, all.join('\n'));
    assert.deepEqual(complaints, []);
    await close();
  });
}

test('modules after the first frame load by themselves: curves, dialogs, inspectors', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}#race`);
  await page.waitForSelector('#error-chart canvas');
  await page.getByRole('button', { name: 'Help' }).click();
  await dialogOf(page);
  await page.keyboard.press('Escape');
  await page.waitForFunction(() => document.querySelectorAll('[aria-label="Content of the lower panel"] option').length > 1);
  assert.deepEqual(complaints, []);
  await close();
});

for (const size of SIZES) {
  for (const scenario of ['race', 'cannon', 'gambetta', 'paper/fig08', 'paper/fig13']) {
    sweep(size.width < 700 || scenario === 'race')(`no complaint, no sideways scroll: ${scenario} at ${size.name}`, async () => {
      const query = `${size.query === '' ? '?' : `${size.query}&`}scenario=${scenario}`;
      const { page, complaints, close } = await visit(browser, daemon.url + query, { width: size.width, height: size.height });
      await until(async () => (await frameOf(page)).tick > 20, 'it plays');
      assert.equal(await page.evaluate(() => document.documentElement.scrollWidth > innerWidth), false);
      assert.deepEqual(complaints, []);
      await close();
    });
  }
}

test('with reduced motion it waits at the start for Play, which has the focus', async () => {
  const { page, close } = await visit(browser, `${daemon.url}#race`, { reducedMotion: 'reduce' });
  await refreshes(page);
  assert.equal((await frameOf(page)).tick, 0);
  await settles(() => page.evaluate(() => document.activeElement?.id), 'play');
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => globalThis.laglab().frame.tick > 20);
  await close();
});

test('without JavaScript it says how to go on', async () => {
  const { page, close } = await visit(browser, `${daemon.url}#race`, { javaScriptEnabled: false, wait: false });
  await reads(page.locator('body'), /curl -X POST/);
  await close();
});

test('a page that is not shown draws nothing, is sent next to nothing, and is at the present when shown again', async () => {
  const { page, close } = await visit(browser, 'about:blank', { wait: false });
  await page.addInitScript(() => {
    /* holds the display back, as a browser does with a hidden tab */
    const real = globalThis.requestAnimationFrame.bind(globalThis);
    let waiting = [],
      held = false;
    globalThis.requestAnimationFrame = (callback) => (held ? waiting.push(callback) : real(callback));
    globalThis.hold = () => {
      held = true;
      return new Promise((done) => real(() => setTimeout(done))); /* what had asked before is drawn */
    };
    globalThis.release = () => {
      held = false;
      const list = waiting;
      waiting = [];
      list.forEach((callback) => real(callback));
    };
  });
  await page.goto(`${daemon.url}#race`);
  await shown(page);
  await page.evaluate(() => globalThis.hold());
  const before = await page.evaluate(() => globalThis.laglab().counts);
  const id = (await sessionOf(page)).id;
  const tick = async () => (await api(daemon.url, `sessions/${id}`)).body.tick;
  const [from, held] = [await tick(), await tickOf(page)];
  await until(async () => (await tick()) > from + 180, 'three seconds of the session');
  const after = await page.evaluate(() => globalThis.laglab().counts);
  assert.equal(after.drawn, before.drawn);
  assert.equal(await tickOf(page), held);
  assert.ok(after.received - before.received <= 8, `${after.received - before.received} frames`);
  const present = await tick();
  await page.evaluate(() => globalThis.release());
  // Of the frames that were sent meanwhile at most one more is drawn; then the page is at the present.
  await page.waitForFunction((least) => globalThis.laglab().frame.tick >= least, present);
  const drawn = (await page.evaluate(() => globalThis.laglab().counts)).drawn - after.drawn;
  assert.ok(drawn < 30, `${drawn} frames drawn on the way to the present`);
  await close();
});

test('frames are acknowledged as they are drawn, no more', async () => {
  const { page, close } = await visit(browser, `${daemon.url}#race`);
  await page.waitForFunction(() => globalThis.laglab().counts.drawn > 20);
  const { counts, frame } = await page.evaluate(() => {
    const l = globalThis.laglab();
    return { counts: l.counts, frame: l.frame };
  });
  assert.equal(counts.acked, frame.seq);
  assert.ok(counts.drawn > 20 && counts.drawn <= counts.received, JSON.stringify(counts));
  await close();
});

test('drawing a frame costs little', async () => {
  const { page, close } = await visit(browser, `${daemon.url}#race`);
  await draws(page, 20);
  const ms = await costOf(page, () => draws(page, 50));
  assert.ok(ms < 8, `${ms} ms`);
  await close();
});

test('where the views take long, messages are drawn in one of three frames; in a pause all is drawn, and then nothing', async () => {
  const { page, close } = await visit(browser, `${daemon.url}#race`);
  await page.evaluate(() => {
    const own = CanvasRenderingContext2D.prototype.clearRect,
      times = { view: 0, lane: 0, asked: 0, ms: 3 };
    CanvasRenderingContext2D.prototype.clearRect = function (x, y, w, h) {
      own.call(this, x, y, w, h);
      if (this.canvas.id === 'lane') times.lane++;
      if (this.canvas.dataset.view === undefined) return;
      if (this.canvas.dataset.view === '0') times.view++;
      for (const end = performance.now() + times.ms; performance.now() < end; );
    };
    const ask = globalThis.requestAnimationFrame;
    globalThis.requestAnimationFrame = (act) => {
      times.asked++;
      return ask(act);
    };
    globalThis.times = times;
  });
  const times = () => page.evaluate(() => ({ ...globalThis.times }));
  await until(async () => (await times()).view >= 60, 'sixty frames');
  const slow = await times();
  assert.ok(slow.lane > 0 && slow.lane <= slow.view / 3 + 5, `${slow.lane} of ${slow.view}`);

  await pause(page);
  await until(async () => (await times()).lane > slow.lane, 'the messages of the last frame are drawn');
  await refreshes(page, 30);
  const end = await times();
  await page.waitForTimeout(300); /* refreshes are counted: none is asked for meanwhile */
  const later = await times();
  assert.equal(later.view, end.view);
  assert.ok(later.asked <= end.asked + 2, `${later.asked - end.asked} refreshes asked for while nothing changes`);
  await close();
});

test('every scenario belongs to the lab that shows it', async () => {
  const { page, close } = await visit(browser, `${daemon.url}#race`);
  const current = () => page.locator('.lab[aria-current="page"]').allTextContents();
  await settles(current, ['Race']);
  for (const [scenario, lab] of [
    ['rifle', 'Shoot'],
    ['crates', 'Crates'],
    ['gambetta', 'Race'],
    ['cannon', 'Cannon'],
    ['motion/orbit', 'Step'],
    ['paper/fig05', 'Collide'],
    ['fluid/pool', 'Fluid'],
    ['sea_watched', 'Fluid'],
  ]) {
    await pick(page, scenario);
    await page.waitForFunction((name) => document.querySelector('.lab[aria-current="page"]')?.textContent === name, lab);
    await settles(current, [lab], scenario);
  }
  await page.getByRole('button', { name: 'Shoot', exact: true }).click();
  await page.waitForFunction(() => globalThis.laglab().params?.game === 'shooter');
  await close();
});
