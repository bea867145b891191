// A class on pages behind HAProxy, at one of two shards: what its pages make is there, too. The shard is killed and started again, and all
// pages go on.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { pause } from '../lib/client.mjs';
import { shardOf, startShards } from '../lib/shards.mjs';
import { api, button, frameOf, launch, reads, sessionOf, shown, until, visit, pick } from './lib.mjs';

const WRITTEN_MS = 300; /* after an answer, until its change is stored: the daemon needs some milliseconds */

/** @type {Awaited<ReturnType<typeof startShards>>} */ let site;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [site, browser] = await Promise.all([startShards(['a', 's0']), launch()]);
});
after(async () => {
  await browser?.close();
  await site?.close();
});

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
  await until(async () => (await sessionOf(page))?.id === id && (await frameOf(page)) !== null, `the page shows ${id}`);
  const { tick } = await frameOf(page);
  await until(async () => (await frameOf(page)).tick > tick + 30, `frames of ${id} after tick ${tick}`);
  assert.equal(await page.evaluate(() => globalThis.never_reloaded), true, 'the page was not loaded again');
}

test('a class is where its board is, and goes on there after kill -9 of its shard', async () => {
  const teacher = await open(`${site.url}/?scenario=race&set=duration_s:600&set=players.0.script:idle`);
  await shown(teacher.page);
  await button(teacher.page, 'Class').click();
  await teacher.page.locator('.joining .letters').waitFor();
  const code = new URL(teacher.page.url()).hash.replace('#class=', ''),
    shard = shardOf(code);
  const { id } = (await api(`${site.url}/`, `classes/${code}`)).body;
  const state = async () => (await api(`${site.url}/`, `classes/${id}`)).body.state;
  await until(async () => (await state())?.seats?.length === 2, 'the players');

  await button(teacher.page, 'More for the teacher').click();
  await button(teacher.page, 'Show the workbench').click();
  // Another scenario is made at the class's shard, whichever is next in turn.
  for (const scenario of ['cannon', 'race']) {
    await fetch(`${site.url}/api/v1/sessions`, {
      method: 'POST',
      headers: { 'content-type': 'application/json' },
      body: '{"scenario":"race"}',
    });
    const before = (await state()).board;
    await pick(teacher.page, scenario);
    await until(async () => (await state()).board !== before, `${scenario} on the board`);
    assert.equal(shardOf((await state()).board), shard);
  }
  await until(async () => (await state()).seats.length === 2, 'the players of the race');
  const { board } = await state();
  /* as it is read out */
  const typed = code.replace('-', ' ').replace('0', 'o').toLowerCase();
  const [driver, copier] = await Promise.all([open(`${site.url}/#class`), open(`${site.url}/${code.toLowerCase()}`)]);
  await driver.page.getByLabel('Code on the board').fill(typed);
  await button(driver.page, 'Join').click();
  await button(driver.page, 'Play A').click();
  await button(copier.page, 'My own copy').click();
  for (const phase of ['predict', 'locked', 'run']) {
    await teacher.page.locator('#class .next').click();
    await until(async () => (await state()).phase === phase, phase);
  }
  const { id: copy } = await until(async () => {
    const now = await sessionOf(copier.page);
    return now && now.id !== board && now;
  }, 'the copy');
  assert.equal(shardOf(copy), shard);
  const pages = [
    { page: teacher.page, id: board },
    { page: driver.page, id: board },
    { page: copier.page, id: copy },
  ];
  await Promise.all(pages.map(({ page, id: of }) => goes_on(page, of)));
  await pause(WRITTEN_MS);

  await site.shards[shard].kill();
  await Promise.all(pages.map(({ page }) => until(async () => page.locator('html[data-lost]').count(), 'the loss is shown')));
  // Who joins meanwhile is in the class once its shard is there.
  const late = await open(`${site.url}/#class`);
  await late.page.getByLabel('Code on the board').fill(code);
  await button(late.page, 'Join').click();
  await site.again(shard);
  await Promise.all(pages.map(({ page }) => until(async () => !(await page.locator('html[data-lost]').count()), 'it is over')));
  await Promise.all(pages.map(({ page, id: of }) => goes_on(page, of)));
  await button(late.page, 'Watch').click();
  await goes_on(late.page, board);

  // What was taken before holds, and all can act.
  await reads(driver.page.locator('#class .chip'), /You play A/);
  await until(async () => (await state()).seats[0].state === 'held', 'the seat');
  const frozen = ({ page }) => page.locator('#class .state[data-kind="frozen"]');
  await button(teacher.page, 'More for the teacher').click();
  await button(teacher.page, 'Freeze all').click();
  await Promise.all([driver, copier].map((one) => frozen(one).waitFor()));
  await button(teacher.page, 'Unfreeze').click();
  await Promise.all([driver, copier].map((one) => frozen(one).waitFor({ state: 'detached' })));
  for (const { complaints } of [teacher, driver, copier, late])
    assert.deepEqual(
      complaints.filter((text) => !/Failed to load resource|WebSocket connection to/.test(text)),
      [],
    );
  await Promise.all([teacher, driver, copier, late].map((one) => one.close()));
});
