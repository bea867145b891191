// What one takes away: pictures and data with the settings that made them.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, before, test } from 'node:test';
import * as zlib from 'node:zlib';
import { startDaemon } from '../lib/daemon.mjs';
import { api, axe, frameOf, launch, pause, until, visit } from './lib.mjs';

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

/** Presses a button that saves, and gives the file. @param {import('playwright-core').Page} page @param {'picture' | 'data'} what @param {string} name */
async function save(page, what, name) {
  const [download] = await Promise.all([
    page.waitForEvent('download', { timeout: 15000 }),
    page.getByRole('button', { name: `Save ${what}: ${name}`, exact: true }).click(),
  ]);
  const bytes = readFileSync(await download.path());
  return { bytes, file: download.suggestedFilename() };
}

/** CRC-32 as gzip has it, at the end of its file. @param {Buffer} bytes */
const crcOf = (bytes) => zlib.gzipSync(bytes).readUInt32LE(zlib.gzipSync(bytes).length - 8);

/** Chunks of a PNG, whose sums are checked. @param {Buffer} bytes */
function chunksOf(bytes) {
  assert.equal(bytes.subarray(0, 8).toString('latin1'), '\x89PNG\r\n\x1a\n');
  const list = [];
  for (let at = 8; at < bytes.length; ) {
    const size = bytes.readUInt32BE(at),
      type = bytes.toString('latin1', at + 4, at + 8),
      body = bytes.subarray(at + 8, at + 8 + size);
    assert.equal(bytes.readUInt32BE(at + 8 + size), crcOf(bytes.subarray(at + 4, at + 8 + size)), type);
    list.push({ type, body });
    at += 12 + size;
  }
  return list;
}

/** @param {Buffer} bytes @returns {Record<string, string>} its texts, and its size */
function textsOf(bytes) {
  const chunks = chunksOf(bytes);
  assert.equal(chunks.at(-1)?.type, 'IEND');
  assert.ok(zlib.inflateSync(Buffer.concat(chunks.filter(({ type }) => type === 'IDAT').map(({ body }) => body))).length > 1000);
  const head = chunks[0].body;
  return {
    width: String(head.readUInt32BE(0)),
    height: String(head.readUInt32BE(4)),
    ...Object.fromEntries(
      chunks
        .filter(({ type }) => type === 'iTXt')
        .map(({ body }) => [body.toString('latin1', 0, body.indexOf(0)), body.toString('utf8', body.indexOf(0) + 5)]),
    ),
  };
}

/** @param {Buffer} bytes @returns {{comments: string[], header: string[], rows: string[][]}} */
function csvOf(bytes) {
  const lines = bytes.toString('utf8').trim().split('\r\n');
  const comments = lines.filter((line) => line.startsWith('#')),
    [header = '', ...rows] = lines.slice(comments.length);
  const cells = (line) => [...line.matchAll(/(?:^|,)(?:"((?:[^"]|"")*)"|([^,]*))/g)].map(([, quoted, plain]) => quoted ?? plain);
  return { comments, header: cells(header), rows: rows.map(cells) };
}

const version = async () => {
  const text = await (await fetch(`${daemon.url}metrics`)).text();
  return /laglab_build_info\{version="([^"]+)"\}/.exec(text)?.[1] ?? 'none';
};
const ready = (page) => page.locator('take-away button').first().waitFor({ timeout: 15000 });

test('a view is saved as a picture with what differs from the scenario, seed, tick and version', async () => {
  const { page, complaints, close } = await visit(
    browser,
    `${daemon.url}?scenario=race&set=players.0.lag_ms:222&set=players.1.link.up.jitter_ms:30&seed=7`,
  );
  await ready(page);
  await pause(page);
  const { tick } = await frameOf(page);
  const { bytes, file } = await save(page, 'picture', 'View of Player A');
  const texts = textsOf(bytes);
  assert.match(file, /^laglab-a-race-in-three-views-view-of-player-a\.png$/);
  assert.equal(texts.Title, 'A race in three views – View of Player A');
  assert.match(texts.Description, /Player A: One-way lag 222 ms/);
  assert.match(texts.Description, /Player B: .+ \(up\) 30 ms/);
  assert.equal(texts.Description.split(';').length, 2, `no other setting: ${texts.Description}`);
  assert.match(texts.Description, new RegExp(`Seed 7 · tick ${tick} · \\d+\\.\\d\\d s`));
  assert.ok(texts.Software.startsWith(`laglab ${await version()} · stream schema `), texts.Software);
  assert.ok(texts.Source.includes('players.0.lag_ms:222') && texts.Source.includes('seed=7'), texts.Source);
  const box = await page.locator('canvas[data-view="1"]').boundingBox();
  assert.ok(Number(texts.width) > box.width && Number(texts.height) > box.height + 60, `${texts.width} x ${texts.height}, a caption below`);
  assert.deepEqual(complaints, []);
  await close();
});

test('a scenario with nothing changed says so', async () => {
  for (const scenario of ['race', 'behind_cover', 'motion/spring', 'rigid/collapsing_stack', 'fluid/cylinder']) {
    const { page, close } = await visit(browser, `${daemon.url}?scenario=${scenario}`);
    await ready(page);
    await page.waitForFunction(() => globalThis.laglab().params !== null);
    const name = await page.locator('take-away button[data-take="picture"]').first().getAttribute('aria-label');
    const texts = textsOf((await save(page, 'picture', name.replace('Save picture: ', ''))).bytes);
    assert.match(texts.Description, /^All settings are the scenario’s\.\nSeed \d+ · tick \d+/, `${scenario}: ${texts.Description}`);
    await close();
  }
});

test('data of the distances: names and units, settings above them, the numbers of the curves', async () => {
  const { page, close } = await visit(browser, `${daemon.url}?scenario=race&set=players.0.lag_ms:222`);
  await ready(page);
  await until(async () => (await frameOf(page)).time_s > 2, 'two seconds', 8000);
  await pause(page);
  const { bytes, file } = await save(page, 'data', 'distance');
  const { comments, header, rows } = csvOf(bytes);
  assert.match(file, /\.csv$/);
  assert.equal(comments.length, 4);
  assert.match(comments[1], /^# Changed: Player A: One-way lag 222 ms$/);
  assert.match(comments[2], /Seed 1 · tick \d+ .* laglab /);
  assert.equal(header[0], 'time (s)');
  assert.match(header[1], /^A own lead \((px|m|ms)\)$/);
  assert.ok(
    rows.length > 60 && rows.every((row) => row.length === header.length && Number.isFinite(Number(row[0]))),
    `${rows.length} rows`,
  );
  const { tick } = await frameOf(page);
  assert.ok(Math.abs(Number(rows.at(-1)[0]) - tick / 60) < 0.02, 'up to now');
  const messages = csvOf((await save(page, 'data', 'Messages')).bytes);
  assert.deepEqual(messages.header.slice(0, 4), ['event', 'player', 'number', 'begin (s)']);
  assert.ok(messages.rows.some(([event]) => event === 'state'));
  await page.getByLabel('Content of the lower panel').selectOption('inputs');
  const trace = csvOf((await save(page, 'data', 'Messages')).bytes);
  assert.equal(trace.comments.length, 4, 'where the page has no table: the trace of the daemon, under the same head');
  assert.match(trace.header[0] + trace.rows.length, /tick|time/);
  await close();
});

const CHARTS = [
  { at: 'motion/spring', names: ['Position over time', 'Error over time', 'Energy over time', 'Speed over position'], view: 'Motion' },
  { at: 'rigid/collapsing_stack', names: ['Energy over time', 'Overlap over time', 'Cost of a step'], view: null },
  { at: 'fluid/cylinder', names: null, view: null },
];
for (const { at, names, view } of CHARTS) {
  test(`${at}: each chart has its picture and its data`, async () => {
    const { page, complaints, close } = await visit(browser, `${daemon.url}?scenario=${at}`);
    await ready(page);
    await until(async () => (await frameOf(page)).tick > 30, 'half a second', 20000);
    await pause(page).catch(() => {}); /* it may have ended */
    const data = await page
      .locator('take-away button[data-take="data"]')
      .evaluateAll((all) => all.map((one) => one.getAttribute('aria-label')));
    const known = names ?? data.map((label) => label.replace('Save data: ', ''));
    assert.ok(known.length >= 2, `${data}`);
    for (const name of known) {
      const { comments, header, rows } = csvOf((await save(page, 'data', name)).bytes);
      assert.equal(comments.length, 4);
      assert.ok(header.length >= 2 && rows.length >= 3, `${name}: ${header}, ${rows.length} rows`);
      assert.ok(rows.every((row) => row.length === header.length));
      if (name.endsWith('over time')) assert.equal(header[0], 't (s)');
      if (name === 'Cost of a step') continue;
      assert.match(textsOf((await save(page, 'picture', name)).bytes).Title, new RegExp(`${name}$`));
    }
    if (view) assert.match(textsOf((await save(page, 'picture', view)).bytes).Title, /Motion$/);
    const drawings = await page.locator('canvas[role="img"]').count(),
      pictures = await page.locator('take-away button[data-take="picture"]').count();
    assert.equal(pictures, drawings, 'every drawing');
    assert.deepEqual(complaints, []);
    await close();
  });
}

test('an experiment: the points as picture and data, with what is varied', async () => {
  const made = await api(daemon.url, 'experiments', {
    title: 'Lag and age',
    scenario: 'race',
    set: { duration_s: 4 },
    axes: [{ path: 'players.0.lag_ms', values: [0, 100, 200] }],
    repeats: 2,
    metrics: ['players.0.view_age_ms.mean'],
  });
  assert.equal(made.status, 202, JSON.stringify(made.body));
  const { page, close } = await visit(browser, `${daemon.url}#experiments=${made.body.id}`, { wait: false });
  await until(async () => (await api(daemon.url, `experiments/${made.body.id}`)).body.state === 'done', 'its end', 30000);
  await page.getByRole('button', { name: 'Save data: Points', exact: true }).waitFor({ timeout: 15000 });
  const { comments, header, rows } = csvOf((await save(page, 'data', 'Points')).bytes);
  assert.match(comments[0], /Lag and age/);
  assert.match(comments[1], /players\.0\.lag_ms = 0, 100, 200/);
  assert.match(comments[2], new RegExp(`laglab ${(await version()).replace(/[+.]/g, '\\$&')}`));
  assert.ok(
    header.some((name) => name.startsWith('players.0.view_age_ms.mean')),
    `${header}`,
  );
  assert.equal(rows.length, 3);
  assert.match(textsOf((await save(page, 'picture', 'Points')).bytes).Title, /Lag and age – Points/);
  await close();
});

test('the buttons can be reached and read, and are no new fault of a page', async () => {
  for (const at of [
    '?scenario=race',
    '?scenario=motion/spring',
    '?scenario=rigid/collapsing_stack',
    '?scenario=fluid/cylinder&theme=projector',
  ]) {
    const { page, close } = await visit(browser, daemon.url + at);
    await ready(page);
    await pause(page).catch(() => {});
    assert.deepEqual(await axe(page), [], at);
    const button = page.locator('take-away button').first();
    await button.focus();
    const [download] = await Promise.all([page.waitForEvent('download'), page.keyboard.press('Enter')]);
    assert.match(download.suggestedFilename(), /\.png$/, at);
    await close();
  }
});
