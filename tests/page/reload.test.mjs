// What a browser keeps of the page: a reload asks for little, and nothing is stale when another build answers at the same address.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { appendFileSync, cpSync, mkdtempSync, readFileSync, rmSync, symlinkSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { startDaemon } from '../lib/daemon.mjs';
import { refreshes, launch, sessionOf, settles, shown, until, visit, pick } from './lib.mjs';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');

/** @type {import('playwright-core').Browser} */ let browser;
/** @type {string} */ let folder;
before(async () => {
  browser = await launch();
  folder = mkdtempSync(path.join(tmpdir(), 'laglab-reload-'));
});
after(async () => {
  await browser?.close();
  rmSync(folder, { recursive: true, force: true });
});

/** Notes what the daemon is asked for from now on: what a cache answers is not on the list.
 * @param {import('playwright-core').Page} page @param {string} base
 * @returns {Promise<{take: () => Promise<string[]>}>} take: when nothing more comes, `STATUS /PATH` of each, and begins again */
async function listen(page, base) {
  const devtools = await page.context().newCDPSession(page);
  /** @type {Map<string, {path: string, status: number, cached: boolean}>} */
  const seen = new Map();
  devtools.on('Network.requestWillBeSent', ({ requestId, request }) =>
    seen.set(requestId, { path: request.url.replace(base, '/'), status: 0, cached: false }),
  );
  devtools.on('Network.requestServedFromCache', ({ requestId }) => Object.assign(seen.get(requestId) ?? {}, { cached: true }));
  devtools.on('Network.responseReceived', ({ requestId, response }) => {
    if (response.fromDiskCache) Object.assign(seen.get(requestId) ?? {}, { cached: true });
  });
  devtools.on('Network.responseReceivedExtraInfo', ({ requestId, statusCode }) =>
    Object.assign(seen.get(requestId) ?? {}, { status: statusCode }),
  );
  await devtools.send('Network.enable');
  return {
    async take() {
      /* the last parts are asked for some time after the first frame, from a cache too */
      await page.waitForFunction(() => document.querySelector('dialog'));
      let last = -1;
      await until(async () => {
        const still = seen.size === last;
        last = seen.size;
        await refreshes(page, 30);
        return still;
      }, 'all is read');
      const list = [...seen.values()].filter(({ cached }) => !cached).map(({ path, status }) => `${status} ${path}`);
      seen.clear();
      return list;
    },
  };
}

for (const [what, at, most] of /** @type {[string, string, number][]} */ ([
  ['the first page', '', 3], // the race above the questions: its session, and its pause when the page is left
  ['a race', '?scenario=race', 2],
  ['experiments', '#experiments', 6], // a session for a draft is made, measured and deleted; its scenario; a dry run
])) {
  test(`a reload of ${what} asks for the page alone, and for what is alive`, async (t) => {
    const daemon = await startDaemon();
    const { page, close } = await visit(browser, 'about:blank', { wait: false });
    t.after(async () => {
      await close();
      await daemon.stop();
    });
    const requests = await listen(page, daemon.url);
    await page.goto(daemon.url + at);
    const first = await requests.take();
    assert.ok(first.length > 8, `${first.length} from an empty cache`);
    for (let i = 0; i < 2; i++) {
      await page.reload();
      const again = await requests.take(),
        alive = again.filter((one) => one.includes(' /api/v1/'));
      assert.deepEqual(
        again.filter((one) => !alive.includes(one)),
        [`304 /${at.replace(/#.*/, '')}`],
      );
      assert.ok(alive.length <= most, alive.join());
    }
  });
}

/** A page that says which one it is: in a module that is read at once, in a part that is read later, in a style and in a text.
 * @param {string} name */
function build(name) {
  const source = path.join(folder, name, 'source');
  for (const part of ['www', 'scenarios', 'clients', 'cmake', 'bench/results/tradeoff', 'LICENSE', 'tsconfig.json'])
    cpSync(path.join(ROOT, part), path.join(source, part), { recursive: true });
  symlinkSync(path.join(ROOT, 'node_modules'), path.join(source, 'node_modules'));
  appendFileSync(path.join(source, 'www/js/shell/main.js'), `\nglobalThis.mainOf = '${name}';\n`);
  appendFileSync(path.join(source, 'www/js/labs/rigid/lab.js'), `\nglobalThis.rigidOf = '${name}';\n`);
  appendFileSync(path.join(source, 'www/app.css'), `\n:root { --build: ${name}; }\n`);
  const words = path.join(source, 'www/words/en.json'),
    text = JSON.parse(readFileSync(words, 'utf8'));
  text.page['shell.share'] = `Share ${name}`;
  writeFileSync(words, JSON.stringify(text));
  execFileSync(process.execPath, [path.join(source, 'www/build.mjs'), source, path.join(folder, name)]);
  return path.join(folder, name, 'www');
}

/** @param {import('playwright-core').Page} page */
const builds = (page) =>
  page.evaluate(() => [
    globalThis.mainOf,
    getComputedStyle(document.documentElement).getPropertyValue('--build').trim(),
    /Share (\w+)/.exec(document.body.innerText)?.[1],
  ]);

/** @param {import('playwright-core').Page} page */
async function showRigid(page) {
  await pick(page, 'rigid/column');
  await page.waitForFunction(() => globalThis.rigidOf !== undefined && globalThis.laglab().params?.kind === 'rigid');
  return page.evaluate(() => globalThis.rigidOf);
}

test('another build at the same address: an open page goes on until it wants a part of it, and the earlier build comes back', async (t) => {
  const data = path.join(folder, 'data'),
    one = build('one'),
    two = build('two');
  let daemon = await startDaemon({ data, args: ['--www', one] });
  t.after(() => daemon.stop());
  const replace = async (/** @type {string} */ www) => {
    const listen = `127.0.0.1:${daemon.port}`;
    await daemon.stop();
    daemon = await startDaemon({ data, listen, args: ['--www', www] });
  };
  const { page, close } = await visit(browser, `${daemon.url}?scenario=race`);
  t.after(close);
  await settles(() => builds(page), ['one', 'one', 'one']);
  await page.waitForFunction(() => document.querySelector('dialog')); /* what follows the first frame is read */
  const { id } = await sessionOf(page);

  await replace(two);
  await until(async () => (await page.evaluate(() => globalThis.laglab().connection.state)) === 'open', 'connected again');
  assert.equal((await sessionOf(page)).id, id);
  assert.deepEqual(await builds(page), ['one', 'one', 'one'], 'it goes on');
  assert.equal(await showRigid(page), 'two', 'a part that it had not read is gone: the page loads again, and is of one build');
  await settles(() => builds(page), ['two', 'two', 'two']);

  await replace(one);
  await page.goto(`${daemon.url}?scenario=race&seed=2`);
  await shown(page);
  await settles(() => builds(page), ['one', 'one', 'one']);
  assert.equal(await showRigid(page), 'one', 'what the second build answered below the digest of the first was not kept');
});
