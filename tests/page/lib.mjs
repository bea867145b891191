// A browser, pages that note everything a console or the network complains about, and a few words for the tests.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { setTimeout as wait } from 'node:timers/promises';
import { isDeepStrictEqual } from 'node:util';
import { chromium } from 'playwright-core';

/** Ends what hangs: a busy machine may take long for anything. */
const LIMIT_MS = 120000;
/** Each reading of a page costs processor time in three processes. */
const POLL_MS = 50;
const AXE = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');

const RULES = ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa', 'best-practice'];

export const SIZES = [
  { name: '1366x768', width: 1366, height: 768, query: '' },
  { name: '1024x768 projector', width: 1024, height: 768, query: '?theme=projector' },
  { name: '390x844', width: 390, height: 844, query: '' },
];

/** Makes races show: each part of the page that is asked for after it has loaded comes that many ms late. A test that fails by it alone
 * reads what is not there yet, and would fail on a busy machine now and then. */
const SLOW_MS = Number(process.env.LAGLAB_PAGE_SLOW_MS ?? 0);

/** @param {import('playwright-core').BrowserContext} context */
async function slowed(context) {
  /** @type {WeakSet<import('playwright-core').Page>} */
  const loaded = new WeakSet();
  context.on('page', (page) => {
    page.on('load', () => loaded.add(page));
    page.on('request', (request) => {
      if (request.isNavigationRequest() && request.frame() === page.mainFrame()) loaded.delete(page);
    });
  });
  await context.route(/\/(js|vendor|words|lessons|css)\/[^?]*$|\.css$/, async (route) => {
    if (loaded.has(route.request().frame().page())) await wait(SLOW_MS);
    await route.fallback().catch(() => {}); /* the page has been closed */
  });
}

const WHOLE = '/usr/bin/chromium';
/** The same engine without windows, twice as fast to load a page. */
const HEADLESS = '/usr/bin/chromium-headless-shell';

/** @param {{whole?: boolean, args?: string[]}} [wish] */
const options = ({ whole = false, args = [] } = {}) => ({
  executablePath: whole ? WHOLE : HEADLESS,
  args: [
    '--no-sandbox',
    '--disable-gpu',
    '--disable-quic',
    '--no-first-run',
    '--disable-background-networking',
    '--disable-component-update',
    '--disable-sync',
    '--in-process-gpu',
    '--enable-features=NetworkServiceInProcess2',
    ...args,
  ],
});

/** A browser for several processes, which drive it themselves at this address: tests/run.mjs keeps one for each of its workers. Its port
 * is in its folder, which it names only when it is automated. */
export async function serve() {
  const browser = await chromium.launch(options({ args: ['--remote-debugging-port=0', '--enable-automation'] }));
  const devtools = await browser.newBrowserCDPSession(),
    { arguments: given } = await devtools.send('Browser.getBrowserCommandLine');
  await devtools.detach();
  const folder = given.find((one) => one.startsWith('--user-data-dir='))?.slice('--user-data-dir='.length) ?? '',
    [port, path] = readFileSync(`${folder}/DevToolsActivePort`, 'utf8').split('\n');
  return { browser, address: `ws://127.0.0.1:${port}${path}` };
}

/** That of the worker that runs this file; what a file opens there goes with the file. */
async function kept() {
  const answer = new Promise((resolve) => process.once('message', resolve));
  process.send?.('browser');
  const { address, error } = /** @type {any} */ (await answer);
  if (error) throw new Error(error);
  return chromium.connectOverCDP(address);
}

/** Drawing and network are in its main process: two cores have no room for more.
 * @param {{whole?: boolean, args?: string[]}} [wish] whole: Chromium as people have it, with windows. Without a wish it
 * may be one that has served other files. */
export async function launch(wish) {
  const browser = await (process.send && !wish ? kept() : chromium.launch(options(wish)));
  const open = browser.newContext.bind(browser);
  browser.newContext = async (options) => {
    const context = await open(options);
    context.setDefaultTimeout(LIMIT_MS);
    if (SLOW_MS > 0) await slowed(context);
    return context;
  };
  return browser;
}

/** In the page: a display that refreshes 20 times in a second instead of 60. Most of what a test waits for comes no sooner by more frames,
 * and each costs drawing in several processes. */
function slowDisplay() {
  const PERIOD_MS = 50;
  /** @type {any} */ (globalThis).refreshesEach = 3;
  const refresh = globalThis.requestAnimationFrame.bind(globalThis);
  /** @type {Map<number, FrameRequestCallback>} */
  let waiting = new Map();
  /** What this refresh still calls. @type {Map<number, FrameRequestCallback>} */
  let drawing = new Map();
  let last = 0;
  /** @param {number} now */
  const draw = (now) => {
    drawing = waiting;
    waiting = new Map();
    for (const callback of drawing.values())
      try {
        callback(now);
      } catch (error) {
        reportError(error);
      }
  };
  globalThis.requestAnimationFrame = (callback) => {
    if (waiting.size === 0) setTimeout(() => refresh(draw), PERIOD_MS - (performance.now() % PERIOD_MS));
    waiting.set(++last, callback);
    return last;
  };
  globalThis.cancelAnimationFrame = (id) => {
    waiting.delete(id);
    drawing.delete(id);
  };
}

/** What leaves something behind in a context. */
const LASTING = {
  page: ['addInitScript', 'emulateMedia', 'exposeBinding', 'exposeFunction', 'pdf', 'route', 'routeWebSocket'],
  context: ['addInitScript', 'grantPermissions', 'newCDPSession', 'newPage', 'route', 'setOffline'],
};
/** What tests listen to. */
const HEARD = ['console', 'pageerror', 'request', 'requestfailed', 'response', 'download'];
/** @typedef {{page: import('playwright-core').Page, context: import('playwright-core').BrowserContext, lasting: boolean}} Tab */
/** Tabs that a test has left, emptied, by their browser and by what their contexts were made with: in one the page's files are not read and
 * compiled again, which is half of the cost of a visit. @type {WeakMap<import('playwright-core').Browser, Map<string, Tab[]>>} */
const left = new WeakMap();

/** @param {import('playwright-core').Browser} browser @param {any} wish @returns {Promise<Tab>} */
async function newTab(browser, { smooth, scripts, ...wish }) {
  const context = await browser.newContext(wish),
    page = await context.newPage();
  if (!smooth) await page.addInitScript(slowDisplay);
  for (const script of scripts) await page.addInitScript(script);
  const tab = { page, context, lasting: false };
  for (const [of, names] of /** @type {[any, string[]][]} */ ([
    [page, LASTING.page],
    [context, LASTING.context],
  ]))
    for (const name of names) {
      const own = of[name];
      of[name] = function (/** @type {any[]} */ ...args) {
        tab.lasting = true;
        return own.apply(this, args);
      };
    }
  return tab;
}

/** Leaves a tab without what it has kept. @param {Tab} tab @param {string} url @returns {Promise<boolean>} false: it is of no more use */
async function emptied({ page, context, lasting }, url) {
  if (SLOW_MS > 0 || lasting || page.isClosed() || context.pages().length !== 1 || new URL(page.url()).origin !== new URL(url).origin)
    return false;
  for (const event of HEARD) page.removeAllListeners(event);
  const empty = await page.goto(new URL('/icon.svg', url).href).catch(() => null);
  if (!empty?.ok()) return false;
  await page.evaluate(() => {
    localStorage.clear();
    sessionStorage.clear();
  });
  await page.mouse.move(0, 0);
  return true;
}

/** Opens the page with nothing kept but its files; `complaints` gathers errors of console, page and requests. smooth: on a
 * display of 60 Hz. scripts: what runs before the page. allowed: what the console may say. For an address of no page the cache is empty.
 * @param {import('playwright-core').Browser} browser @param {string} url @param {any} [wish] */
export async function visit(browser, url, wish = {}) {
  const { width = 1366, height = 768, wait = true, smooth = false, scripts = [], allowed = /^$/, ...more } = wish;
  delete more.name;
  delete more.query;
  const kind = JSON.stringify([more, smooth, scripts.map(String)]),
    fresh = !url.startsWith('http');
  const tabs = left.get(browser) ?? new Map();
  left.set(browser, tabs);
  const known = fresh ? undefined : tabs.get(kind)?.pop(),
    tab = known ?? (await newTab(browser, { viewport: { width, height }, smooth, scripts, ...more })),
    { page, context } = tab;
  if (known) await page.setViewportSize(more.viewport ?? { width, height });
  /** @type {string[]} */
  const complaints = [];
  /** @type {import('playwright-core').Request[]} */
  const requests = [];
  /** @type {string[]} */
  const failures = [];
  page.on('console', (message) => {
    if (['error', 'warning'].includes(message.type()) && !allowed.test(message.text())) complaints.push(`console: ${message.text()}`);
  });
  page.on('pageerror', (error) => complaints.push(`error: ${error.message}`));
  page.on('request', (request) => requests.push(request));
  page.on('requestfailed', (request) => failures.push(`${request.url()} ${request.failure()?.errorText}`));
  await page.goto(url);
  if (wait) {
    await shown(page).catch(async (error) => {
      const text = await page.evaluate(() => document.body.innerText.slice(0, 400)).catch(() => '');
      throw new Error(`the page is not there: ${error.message}; ${failures.join('; ')}; ${complaints.join('; ')}; it shows: ${text}`);
    });
  }
  const close = async () => {
    if (!fresh && (await emptied(tab, url))) tabs.set(kind, [...(tabs.get(kind) ?? []), tab]);
    else await context.close();
  };
  return { page, context, complaints, requests, close };
}

/** Until the page has drawn a frame and has its controls. @param {import('playwright-core').Page} page */
export async function shown(page) {
  await page.waitForFunction(() => globalThis.laglab?.().frame !== null && document.querySelector('[data-path]') !== null);
}

/** The newest drawn frame, each view with its entities. @param {import('playwright-core').Page} page @returns {Promise<any>} */
export async function frameOf(page) {
  const frame = await page.evaluate(() => globalThis.laglab().frame?.plain() ?? null);
  frame?.views?.forEach((view) => {
    view.entities = frame.entities.filter((one) => one.view === view.view);
  });
  return frame;
}
/** @param {import('playwright-core').Page} page */
export const paramsOf = (page) => page.evaluate(() => globalThis.laglab().params);
/** @param {import('playwright-core').Page} page */
export const sessionOf = (page) => page.evaluate(() => globalThis.laglab().session);

/** @param {import('playwright-core').Page} page */
export const tickOf = (page) => page.evaluate(() => globalThis.laglab().frame.tick);
/** @param {import('playwright-core').Page} page @param {string | RegExp} name */
export const button = (page, name) => page.getByRole('button', { name, exact: true });

/** @param {import('playwright-core').Page} page */
export async function pause(page) {
  await button(page, 'Pause').click();
  await button(page, 'Play').waitFor();
}

/** Steps by the keyboard: a button that is held steps on, and on a busy machine a click takes as long.
 * @param {import('playwright-core').Page} page @param {'forward' | 'back'} way */
export const stepOnce = (page, way) => button(page, `One tick ${way}`).press('Enter');

/** The time of a number of refreshes at 60 Hz, in those of the page's display: a fixed part of what a page can do, on a busy machine too.
 * For what has to settle, and for what is not to happen. @param {import('playwright-core').Page} page @param {number} [count] */
export const refreshes = (page, count = 20) =>
  page.evaluate(
    (n) =>
      new Promise((resolve) => {
        let left = Math.ceil(n / /** @type {any} */ (globalThis.refreshesEach ?? 1));
        const next = () => (left-- > 0 ? requestAnimationFrame(next) : resolve(null));
        next();
      }),
    count,
  );

/** Until the simulation has gone on by some time. @param {import('playwright-core').Page} page @param {number} time s */
export async function runOn(page, time) {
  const goal = (await page.evaluate(() => globalThis.laglab().frame.time_s)) + time;
  await page.waitForFunction((to) => globalThis.laglab().frame?.time_s >= to, goal);
}

/** Processor time of the page's script for each frame that it draws meanwhile, ms: what other processes do adds little.
 * @param {import('playwright-core').Page} page @param {() => Promise<unknown>} meanwhile */
export async function costOf(page, meanwhile) {
  const devtools = await page.context().newCDPSession(page);
  await devtools.send('Performance.enable', { timeDomain: 'threadTicks' });
  const now = async () => {
    const { metrics } = await devtools.send('Performance.getMetrics'),
      { drawn } = await page.evaluate(() => globalThis.laglab().counts);
    return { ms: 1000 * (metrics.find(({ name }) => name === 'ScriptDuration')?.value ?? NaN), drawn };
  };
  const from = await now();
  await meanwhile();
  const to = await now();
  await devtools.detach();
  return (to.ms - from.ms) / (to.drawn - from.drawn);
}

/** Until it has drawn this number of frames more. @param {import('playwright-core').Page} page @param {number} frames */
export async function draws(page, frames) {
  const goal = (await page.evaluate(() => globalThis.laglab().counts.drawn)) + frames;
  await page.waitForFunction((to) => globalThis.laglab().counts.drawn >= to, goal);
}

/** Moves the scrub slider as a drag does. @param {import('playwright-core').Page} page @param {number} time s */
export const scrub = (page, time) =>
  page.locator('#scrub').evaluate((/** @type {any} */ element, to) => {
    element.value = to;
    element.dispatchEvent(new Event('input', { bubbles: true }));
    element.dispatchEvent(new Event('change', { bubbles: true }));
  }, String(time));

/** Polls until `test` gives a true value, and gives it. @template T @param {() => Promise<T>} test @param {string} what */
export async function until(test, what) {
  const end = Date.now() + LIMIT_MS;
  for (;;) {
    const value = await test();
    if (value) return value;
    if (Date.now() > end) assert.fail(`not within ${LIMIT_MS} ms: ${what}`);
    await wait(POLL_MS);
  }
}

/** Reads until the value is the expected one; else fails as `assert.deepEqual` does. For all that a page shows after an action: it may load
 * or compute it first. @param {() => Promise<any>} read @param {any} expected @param {string} [what] */
export async function settles(read, expected, what) {
  let last;
  const end = Date.now() + LIMIT_MS;
  do {
    last = await read();
    if (isDeepStrictEqual(last, expected)) return;
    await wait(POLL_MS);
  } while (Date.now() < end);
  assert.deepEqual(last, expected, what);
}

/** Reads a text until it matches, and gives it; else fails as `assert.match` does.
 * @param {import('playwright-core').Locator | (() => Promise<string | null>)} from @param {RegExp} pattern */
export async function reads(from, pattern) {
  let last = '';
  const end = Date.now() + LIMIT_MS;
  do {
    last = (await (typeof from === 'function' ? from() : from.innerText())) ?? '';
    if (pattern.test(last)) return last;
    await wait(POLL_MS);
  } while (Date.now() < end);
  assert.match(last, pattern);
  return last;
}

/** The dialog that has just been asked for, once it is there with its content: dialogs are read when the first one opens.
 * @param {import('playwright-core').Page} page */
export async function dialogOf(page) {
  const dialog = page.locator('dialog[open]');
  await dialog.locator('h2').waitFor();
  return dialog;
}

/** A control of the page by its parameter, in its panel. @param {import('playwright-core').Page} page @param {string} path
 * @param {string} [type] */
export function control(page, path, type = '') {
  return page.locator(`#app [data-path="${path}"]${type === 'number' ? '.number' : type && `[type="${type}"]`}`).first();
}

/** From the list of scenarios. @param {import('playwright-core').Page} page @param {string} id */
export async function pick(page, id) {
  await page.locator('#scenario').click();
  await page.locator(`[data-scenario="${id}"]`).click();
}

/** The accessibility rules that a page breaks, as text. Nothing is drawn meanwhile. colours: of contrast alone, for another scheme of what
 * has been checked. @param {import('playwright-core').Page} page @param {{colours?: boolean}} [wish] */
export async function axe(page, { colours = false } = {}) {
  if (!(await page.evaluate(() => 'axe' in globalThis))) await page.evaluate(AXE);
  const result = await page.evaluate(
    async (runOnly) => {
      const draw = globalThis.requestAnimationFrame;
      /** @type {FrameRequestCallback[]} */
      const waiting = [];
      globalThis.requestAnimationFrame = (callback) => waiting.push(callback);
      const { violations, passes } = await globalThis.axe.run(document, {
        runOnly,
        resultTypes: ['violations'] /* of others not each element */,
      });
      globalThis.requestAnimationFrame = draw;
      for (const callback of waiting) draw(callback);
      return { violations, passes: passes.length };
    },
    colours ? ['color-contrast'] : RULES,
  );
  assert.ok(result.passes > (colours ? 0 : 20), 'axe has checked the page');
  return result.violations.map(
    (v) =>
      `${v.id}: ${v.nodes
        .map((n) => `${n.target} ${n.failureSummary}`)
        .slice(0, 3)
        .join(' | ')}`,
  );
}

/** What was saved. @param {import('playwright-core').Download} download */
export async function bytesOf(download) {
  const parts = [];
  for await (const part of await download.createReadStream()) parts.push(part);
  return Buffer.concat(parts);
}

/** Prints the lesson that is shown. @param {import('playwright-core').Page} page */
export async function printed(page) {
  await page.evaluate(() => {
    globalThis.printed = false;
    window.print = () => {
      globalThis.printed = true;
    };
  });
  await page.locator('#print').click();
  await page.waitForFunction(() => globalThis.printed);
  return page.pdf({ preferCSSPageSize: true, printBackground: true });
}

/** Asks the daemon without the page. @param {string} base @param {string} path @param {any} [body] @param {string} [key]
 * @param {string} [method] */
export async function api(base, path, body, key, method) {
  const answer = await fetch(`${base}api/v1/${path}`, {
    method: method ?? (body === undefined ? 'GET' : 'POST'),
    headers: { ...(body === undefined ? {} : { 'Content-Type': 'application/json' }), ...(key ? { Authorization: `Bearer ${key}` } : {}) },
    body: body === undefined ? undefined : JSON.stringify(body),
  });
  const text = await answer.text();
  return { status: answer.status, body: text === '' ? null : JSON.parse(text) };
}

/** What all canvases show, as one text that differs when a pixel does. @param {import('playwright-core').Page} page */
export function pictures(page) {
  return page.evaluate(() =>
    [...document.querySelectorAll('canvas[data-view]')].map((c) => /** @type {HTMLCanvasElement} */ (c).toDataURL()).join(),
  );
}
