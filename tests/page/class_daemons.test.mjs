// A class on pages behind HAProxy, of daemons that share PostgreSQL: the one that has it is killed, and all pages go on at another one.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { startProxy } from '../../bench/proxies/proxies.mjs';
import { ownPostgres } from '../lib/chaos.mjs';
import { pause } from '../lib/client.mjs';
import { memberOf, metric } from '../lib/group.mjs';
import { api, button, frameOf, launch, reads, sessionOf, shown, until, visit } from './lib.mjs';

const { missing: skip, call: postgres } = ownPostgres();
const CONFIG = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../../deploy/cluster/haproxy.cfg');
const WRITTEN_MS = 300; /* after an answer, until its change is stored: the daemon needs some milliseconds */

/** @type {string} */ let store;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  if (skip) return;
  store = postgres('start');
  browser = await launch();
});
after(async () => {
  await browser?.close();
  if (!skip) postgres('remove');
});

/** The proxy of deploy/cluster before these daemons. @param {{port: number}[]} daemons */
const proxyOf = (daemons) =>
  startProxy(
    'haproxy',
    0,
    readFileSync(CONFIG, 'utf8')
      .replace('bind :8080', 'bind LISTEN')
      .replace('maxconn 20000', 'maxconn 1000')
      .replace(' resolvers names', '')
      .replace(/^resolvers names\n(?:[ \t]+.*\n)+/m, '')
      .replace(/^ +server laglab-.*\n/gm, '')
      .concat(daemons.map(({ port }, i) => `    server laglab-${i} 127.0.0.1:${port}\n`).join('')),
  );

/** A page with a mark that a reload would remove. @param {string} url */
async function open(url) {
  const visitor = await visit(browser, url, { wait: false });
  await visitor.page.evaluate(() => {
    globalThis.never_reloaded = true;
  });
  return visitor;
}

/** The page draws newer and newer frames of this session, without a reload.
 * @param {import('playwright-core').Page} page @param {string} id */
async function goes_on(page, id) {
  await until(async () => (await sessionOf(page))?.id === id && (await frameOf(page)) !== null, `the page shows ${id}`, 15000);
  const { tick } = await frameOf(page);
  await until(async () => (await frameOf(page)).tick > tick + 30, `frames of ${id} after tick ${tick}`, 15000);
  assert.equal(await page.evaluate(() => globalThis.never_reloaded), true, 'the page was not loaded again');
}

test('kill -9 of the daemon that has a class: the pages of teacher and students go on at another', { skip }, async (t) => {
  const wish = { lease: 30, args: ['--trusted-proxy', '127.0.0.1'] };
  const daemons = await Promise.all([memberOf(t, store, wish), memberOf(t, store, wish)]);
  const proxy = await proxyOf(daemons);
  t.after(() => proxy.stop());
  const teacher = await open(`${proxy.url}/?scenario=race&set=duration_s:600&set=players.0.script:idle`);
  await shown(teacher.page);
  await button(teacher.page, 'Class').click();
  await button(teacher.page, 'Show the board').waitFor();
  const code = new URL(teacher.page.url()).hash.replace('#class=', '');
  const { id } = (await api(`${proxy.url}/`, `classes/${code}`)).body;
  const state = async () => (await api(`${proxy.url}/`, `classes/${id}`)).body.state;
  await until(async () => (await state())?.seats?.length === 2, 'the players');
  const { board } = await state();

  const [driver, copier] = await Promise.all([open(`${proxy.url}/#class=${code}`), open(`${proxy.url}/#class=${code}`)]);
  await button(driver.page, 'Play A').click();
  await button(copier.page, 'My own copy').click();
  await button(teacher.page, 'Run').click();
  await button(teacher.page, 'Show the board').click();
  await until(async () => (await sessionOf(copier.page))?.id !== board, 'the copy');
  const { id: copy } = await sessionOf(copier.page);
  await button(copier.page, 'Play').click();
  const pages = [
    { page: teacher.page, id: board },
    { page: driver.page, id: board },
    { page: copier.page, id: copy },
  ];
  await Promise.all(pages.map(({ page, id: of }) => goes_on(page, of)));
  await pause(WRITTEN_MS);

  await until(async () => (await state()).serial > 12, 'changes of the class', 10000);
  const { serial } = await state();
  const classes = await Promise.all(daemons.map(({ c }) => metric(c, 'classes')));
  assert.deepEqual([...classes].sort(), [0, 1]);
  await daemons[classes.indexOf(1)].kill();
  await Promise.all(pages.map(({ page }) => until(async () => page.locator('html[data-lost]').count(), 'the loss is shown')));
  await Promise.all(pages.map(({ page }) => until(async () => !(await page.locator('html[data-lost]').count()), 'it is over', 20000)));
  await Promise.all(pages.map(({ page, id: of }) => goes_on(page, of)));

  // What was taken before holds, and all can act.
  await reads(driver.page.locator('#class .chip'), /You play A/);
  await until(async () => (await state()).seats[0].state === 'held', 'the seat');
  const frozen = ({ page }) => page.locator('#class .state[data-kind="frozen"]');
  await button(teacher.page, 'Freeze all').click();
  await Promise.all([driver, copier].map((one) => frozen(one).waitFor({ timeout: 3000 })));
  assert.ok((await state()).serial < serial, 'the pages had seen later ones of the other daemon');
  await button(teacher.page, 'Unfreeze').click();
  await Promise.all([driver, copier].map((one) => frozen(one).waitFor({ state: 'detached', timeout: 3000 })));
  await button(copier.page, 'Pause').click();
  await button(copier.page, 'Play').waitFor();
  await Promise.all([teacher, driver, copier].map((one) => one.close()));

  // Who joins while no daemon is there is in the class once there is one.
  const late = await open(`${proxy.url}/#class`);
  await late.page.getByLabel('Code on the board').fill(code);
  await daemons[classes.indexOf(0)].kill();
  await until(async () => (await api(`${proxy.url}/`, 'scenarios').catch(() => null))?.status !== 200, 'an answer of the proxy alone');
  await button(late.page, 'Join').click();
  await late.page.locator('#class').getByText('Trying again').waitFor();
  await memberOf(t, store, { ...wish, port: daemons[0].port });
  await button(late.page, 'Watch').click({ timeout: 20000 });
  await goes_on(late.page, board);
  for (const { complaints } of [teacher, driver, copier, late])
    assert.deepEqual(
      complaints.filter((text) => !/Failed to load resource|WebSocket connection to/.test(text)),
      [],
    );
  await late.close();
});
