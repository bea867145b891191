// The inspectors in the panel below the views.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { launch, settles, visit } from './lib.mjs';

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

const CHOICE = 'select[aria-label="Content of the lower panel"]';
/** Waits until the description of the lane matches. @param {import('playwright-core').Page} page @param {RegExp} what */
async function words(page, what) {
  await page.waitForFunction(
    (source) => new RegExp(source).test(document.getElementById('lane')?.getAttribute('aria-label') ?? ''),
    what.source,
    { timeout: 15000 },
  );
}

test('buffers of a player: delay, state, under-runs', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}?scenario=race`);
  await page.waitForSelector(`${CHOICE} option[value="buffers"]`, { state: 'attached' });
  await page.locator(CHOICE).selectOption('buffers');
  await words(page, /^Buffers: .*delay \d+ ms .*under-runs \d+/);
  await page.locator(CHOICE).selectOption('messages');
  await words(page, /^Messages of the last/);
  assert.deepEqual(complaints, []);
  await close();
});

test('inputs from client to server, with their results', async () => {
  const { page, complaints, close } = await visit(
    browser,
    `${daemon.url}?scenario=race&set=players.0.link.up.loss_pct:20&set=players.0.redundancy:0`,
  );
  await page.waitForSelector(`${CHOICE} option[value="inputs"]`, { state: 'attached' });
  await page.locator(CHOICE).selectOption('inputs');
  await words(page, /^Inputs: input \d+, acknowledged up to \d+: \d+ open .*[1-9]\d* lost/);
  assert.deepEqual(complaints, []);
  await close();
});

test('a shot: hits by three rules, and the rewind', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}?scenario=rifle`);
  await words(page, /^Shots: A, rifle: (hits|miss).*rewound by \d+ ms/);
  await settles(() => page.locator(CHOICE).inputValue(), 'shots');
  assert.deepEqual(complaints, []);
  await close();
});

test('stalls and desyncs of peers', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}?scenario=desync_float`);
  await words(page, /^Waits and desyncs: .*stalled .*desync at tick \d+: \w+ \w+ by \d+ ulp/);
  assert.deepEqual(complaints, []);
  await close();
});

test('lockstep: the description says that the server waits', async () => {
  const { page, close } = await visit(browser, `${daemon.url}?scenario=paper/fig11`);
  await page.waitForSelector(`${CHOICE} option[value="waits"]`, { state: 'attached' });
  await page.locator(CHOICE).selectOption('waits');
  await words(page, /^Waits and desyncs: The server (waits|steps)/);
  await close();
});
