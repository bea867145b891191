// The inspectors in the panel below the views.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { launch, reads, settles, visit } from './lib.mjs';

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

test('traffic of a player: rates, bytes by type of message, losses, choke, round trip', async () => {
  const { page, complaints, close } = await visit(
    browser,
    `${daemon.url}?scenario=swarm_interest&set=players.0.link.down.loss_pct:50&set=server.snapshot_bytes:100`,
  );
  await page.waitForSelector(`${CHOICE} option[value="traffic"]`, { state: 'attached' });
  await page.locator(CHOICE).selectOption('traffic');
  await page.locator('#lane').scrollIntoViewIfNeeded(); // of four players the fifth view: drawn where it can be seen
  /* two ways of 40 ms; 60 inputs and 30 snapshots a second, half of which are lost; in an area of some 30 entities 100 bytes are few */
  const way = ['in \\d+ packets/s', '\\d+ B/s', 'loss [2-8]\\d\\.\\d %', 'snapshot \\d+ B'].join(' · ');
  await words(page, new RegExp(`^Traffic: A: ping 8\\d ms · (2[5-9]|3[0-5]) updates/s · choke [1-9]\\d+\\.\\d % · ${way}`));
  await words(page, /out (5\d|6\d|7\d) packets\/s · \d+ B\/s · loss 0\.0 % · input \d+ B/);
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

test('Figure 12 opens with its buffer', async () => {
  const { page, close } = await visit(browser, `${daemon.url}?scenario=paper/fig12`);
  await words(page, /^Inputs: input \d+, acknowledged up to \d+: \d+ open/);
  await close();
});

test('stalls and desyncs of peers', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}?scenario=desync_float`);
  await words(page, /^Waits and desyncs: .*stalled .*desync at tick \d+: \w+ \w+ by \d+ ulp/);
  assert.deepEqual(complaints, []);
  await close();
});

test('lockstep: the description says that the server waits; what the paper says of it stands next to it', async () => {
  const { page, close } = await visit(browser, `${daemon.url}?scenario=paper/fig11`);
  await page.waitForSelector(`${CHOICE} option[value="waits"]`, { state: 'attached' });
  await page.locator(CHOICE).selectOption('waits');
  await words(page, /^Waits and desyncs: The server (waits|steps)/);
  await settles(() => page.locator('.errata tbody tr').count(), 2);
  await reads(page.locator('.errata'), /150 ms one way.*Lag is one way.*perfectly in sync.*not at the same time/s);
  await close();
});
