// What one takes away: images and data with the settings that made them.
import assert from 'node:assert/strict';
import { createServer } from 'node:http';
import { after, before } from 'node:test';
import * as zlib from 'node:zlib';
import { startDaemon } from '../lib/daemon.mjs';
import { api, axe, bytesOf, frameOf, launch, pause, printed, reads, settles, until, visit } from './lib.mjs';
import { sweep, test } from './tiers.mjs';

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

/** Presses a button that saves, and gives the file. @param {import('playwright-core').Page} page @param {'image' | 'data'} what
 * @param {string} name */
async function save(page, what, name) {
  const [download] = await Promise.all([
    page.waitForEvent('download'),
    page.getByRole('button', { name: `Save ${what}: ${name}`, exact: true }).click(),
  ]);
  const bytes = await bytesOf(download);
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
const ready = (page) => page.locator('take-away button').first().waitFor();

test('a view is saved as a image with what differs from the scenario, seed, tick and version', async () => {
  const { page, complaints, close } = await visit(
    browser,
    `${daemon.url}?scenario=race&set=players.0.lag_ms:222&set=players.1.link.up.jitter_ms:30&seed=7`,
  );
  await ready(page);
  await pause(page);
  const { tick } = await frameOf(page);
  await page.evaluate(() => {
    const take = globalThis.createImageBitmap;
    globalThis.createImageBitmap = (/** @type {any} */ canvas) => {
      globalThis.takenAt = canvas.width / canvas.clientWidth;
      return take(canvas);
    };
  });
  const { bytes, file } = await save(page, 'image', 'View of Player A');
  const texts = textsOf(bytes);
  assert.ok((await page.evaluate(() => globalThis.takenAt)) >= 1.99, 'it is drawn again for the image, twice as fine as this screen');
  assert.match(file, /^laglab-a-race-in-three-views-view-of-player-a\.png$/);
  assert.equal(texts.Title, 'A race in three views – View of Player A');
  assert.match(texts.Description, /Player A: One-way lag 222 ms/);
  assert.match(texts.Description, /Player B: .+ \(up\) 30 ms/);
  assert.equal(texts.Description.split(';').length, 2, `no other setting: ${texts.Description}`);
  assert.match(texts.Description, new RegExp(`Seed 7 · tick ${tick} · \\d+\\.\\d\\d s`));
  assert.ok(texts.Software.startsWith(`laglab ${await version()} · stream schema `), texts.Software);
  assert.ok(texts.Source.includes('players.0.lag_ms:222') && texts.Source.includes('seed=7'), texts.Source);
  const box = await page.locator('canvas[data-view="1"]').boundingBox();
  assert.ok(
    Number(texts.width) > 2 * box.width - 4 && Number(texts.height) > 2 * box.height + 60,
    `${texts.width} x ${texts.height}, a caption below`,
  );
  assert.deepEqual(complaints, []);
  await close();
});

for (const scenario of ['race', 'behind_cover', 'motion/spring', 'rigid/collapsing_stack', 'fluid/cylinder'])
  sweep(['race', 'motion/spring'].includes(scenario))(`a scenario with nothing changed says so: ${scenario}`, async () => {
    const { page, close } = await visit(browser, `${daemon.url}?scenario=${scenario}`);
    await ready(page);
    await page.waitForFunction(() => globalThis.laglab().params !== null);
    const name = await page.locator('take-away button[data-take="image"]').first().getAttribute('aria-label');
    const texts = textsOf((await save(page, 'image', name.replace('Save image: ', ''))).bytes);
    assert.match(texts.Description, /^All settings are the scenario’s\.\nSeed \d+ · tick \d+/, `${scenario}: ${texts.Description}`);
    await close();
  });

test('data of the distances: names and units, settings above them, the numbers of the curves', async () => {
  const { page, close } = await visit(browser, `${daemon.url}?scenario=race&set=players.0.lag_ms:222`);
  await ready(page);
  await until(async () => (await frameOf(page)).time_s > 2, 'two seconds');
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
  assert.ok(messages.rows.some(([event]) => event === 'snapshot'));
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
  test(`${at}: each chart has its image and its data`, async () => {
    const { page, complaints, close } = await visit(browser, `${daemon.url}?scenario=${at}`);
    await ready(page);
    await until(async () => (await frameOf(page)).tick > 30, 'half a second');
    await pause(page).catch(() => {}); /* it may have ended */
    const drawings = page.locator('canvas[role="img"]'),
      images = page.locator('take-away button[data-take="image"]');
    await until(
      async () => (await drawings.count()) > 0 && (await images.count()) === (await drawings.count()),
      'an image of every drawing',
    );
    const data = await page
      .locator('take-away button[data-take="data"]')
      .evaluateAll((all) => all.map((one) => one.getAttribute('aria-label') ?? ''));
    const known = names ?? data.map((label) => label.replace('Save data: ', ''));
    assert.ok(known.length >= 2, `${data}`);
    for (const name of known) {
      const { comments, header, rows } = csvOf((await save(page, 'data', name)).bytes);
      assert.equal(comments.length, 4);
      assert.ok(header.length >= 2 && rows.length >= 3, `${name}: ${header}, ${rows.length} rows`);
      assert.ok(rows.every((row) => row.length === header.length));
      if (name.endsWith('over time')) assert.equal(header[0], 't (s)');
      if (name === 'Cost of a step') continue;
      assert.match(textsOf((await save(page, 'image', name)).bytes).Title, new RegExp(`${name}$`));
    }
    if (view) assert.match(textsOf((await save(page, 'image', view)).bytes).Title, /Motion$/);
    assert.deepEqual(complaints, []);
    await close();
  });
}

test('data of a plot of bodies that move: a column for each solver, and the values of the frames', async () => {
  const { page, close } = await visit(browser, `${daemon.url}?scenario=rigid/collapsing_stack&set=duration_s:600`);
  await ready(page);
  await page.evaluate(() => {
    const seen = /** @type {Record<string, number[][]>} */ ({});
    const note = () => {
      const { frame } = globalThis.laglab();
      seen[frame.time_s] = frame.worlds.map(({ energy, energy_start: from, penetration }) => [energy - from, penetration * 1000]);
      requestAnimationFrame(note);
    };
    note();
    globalThis.seen = () => seen;
  });
  await until(async () => (await frameOf(page)).time_s > 4, 'they move');
  const solvers = (await page.locator('table.now thead th').allInnerTexts()).map((text) => text.trim());
  assert.equal(new Set(solvers).size, 2, `${solvers}`);
  const plots = /** @type {[string, RegExp][]} */ ([
    ['Energy over time', /^energy.*\(J\)$/],
    ['Overlap over time', /^.*overlap.*\(mm\)$/],
    ['Energy over time', /^energy.*\(J\)$/],
  ]);
  for (const [which, [name, axis]] of plots.entries()) {
    const { header, rows } = csvOf((await save(page, 'data', name)).bytes),
      seen = await page.evaluate(() => globalThis.seen());
    assert.equal(header.length, 3);
    assert.equal(header[0], 't (s)');
    for (const [i, solver] of solvers.entries()) {
      assert.ok(header[i + 1].startsWith(`${solver}: `), `${header}: ${solver}`);
      assert.match(header[i + 1].slice(solver.length + 2), axis);
    }
    let compared = 0,
      apart = 0;
    for (const [k, row] of rows.entries()) {
      assert.equal(row.length, 3);
      assert.ok(
        row.every((text) => text !== '' && Number.isFinite(Number(text))),
        `row ${k} of ${rows.length}: ${row}`,
      );
      assert.ok(k === 0 || Number(row[0]) > Number(rows[k - 1][0]), `row ${k}`);
      const now = seen[row[0]]?.map((values) => values[which % 2]);
      if (now === undefined) continue;
      assert.deepEqual(row.slice(1).map(Number), now, `${row[0]} s`);
      compared++;
      if (now[0] !== now[1]) apart++;
    }
    assert.ok(compared > 20 && apart > 10, `${compared} rows of frames, ${apart} with solvers that differ`);
  }
  await close();
});

test('an experiment: the points as image and data, with what is varied', async () => {
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
  await until(async () => (await api(daemon.url, `experiments/${made.body.id}`)).body.state === 'done', 'its end');
  const picture = 'Player A: Age of the others, mean (ms)';
  await page.getByRole('button', { name: `Save data: ${picture}`, exact: true }).waitFor();
  const { comments, header, rows } = csvOf((await save(page, 'data', picture)).bytes);
  assert.match(comments[0], /Lag and age/);
  assert.match(comments[1], /Player A: One-way lag = 0, 100, 200/);
  assert.match(comments[2], new RegExp(`laglab ${(await version()).replace(/[+.]/g, '\\$&')}`));
  assert.ok(
    header.some((name) => name.startsWith('players.0.view_age_ms.mean')),
    `${header}`,
  );
  assert.equal(rows.length, 3);
  assert.equal(textsOf((await save(page, 'image', picture)).bytes).Title, `Lag and age – ${picture}`);
  await close();
});

for (const at of [
  '?scenario=race',
  '?scenario=motion/spring',
  '?scenario=rigid/collapsing_stack',
  '?scenario=fluid/cylinder&theme=projector',
])
  sweep(at === '?scenario=race')(`the buttons can be reached and read, and are no new fault of a page: ${at}`, async () => {
    const { page, close } = await visit(browser, daemon.url + at);
    await ready(page);
    await pause(page).catch(() => {});
    assert.deepEqual(await axe(page), [], at);
    const button = page.locator('take-away button').first();
    await button.focus();
    const [download] = await Promise.all([page.waitForEvent('download'), page.keyboard.press('Enter')]);
    assert.match(download.suggestedFilename(), /\.png$/, at);
    await close();
  });

// ---- paper ----

test('the sheet has a QR code of the lesson where others reach the address, and none of a loopback address', async (t) => {
  const outside = await startDaemon({ args: ['--allow-host', 'lab.example'] }),
    port = new URL(outside.url).port;
  const other = await launch({ args: ['--host-resolver-rules=MAP lab.example 127.0.0.1'] });
  t.after(async () => {
    await other.close();
    await outside.stop();
  });
  for (const [host, count] of [
    ['lab.example', 1],
    ['127.0.0.1', 0],
  ]) {
    const { page, close } = await visit(other, `http://${host}:${port}/#lesson=jump_back&step=1&lang=de`, { wait: false });
    await page.locator('#print').waitFor();
    await page.waitForFunction(() => globalThis.laglab().frame !== null);
    await printed(page);
    await settles(() => page.locator('.a4 .qr').count(), count, String(host));
    if (count) {
      const label = await page.locator('.a4 .qr').getAttribute('aria-label');
      assert.ok(label?.endsWith(`http://${host}:${port}/#lesson=jump_back&step=1&lang=de`), String(label));
    }
    await close();
  }
});

// ---- in a frame ----

test('a course page that is named shows ?embed=1 in a frame: views, caption, play and scrub; no other page shows anything', async (t) => {
  const server = createServer((request, response) => {
    const url = new URL(request.url ?? '/', 'http://course').searchParams.get('of') ?? '';
    response.setHeader('Content-Type', 'text/html');
    response.end(
      `<!doctype html><html lang="en"><title>Course</title><h1>Course</h1>
       <iframe title="laglab" width="800" height="480" src="${url}"></iframe>`,
    );
  });
  await new Promise((done) => {
    server.listen(0, '127.0.0.1', () => done(null));
  });
  const course = `http://127.0.0.1:${/** @type {import('node:net').AddressInfo} */ (server.address()).port}`;
  const framing = await startDaemon({ args: ['--allow-embed', `https://other.example,${course}`] });
  t.after(async () => {
    await framing.stop();
    server.closeAllConnections();
    await new Promise((done) => {
      server.close(done);
    });
  });
  const policyOf = async (base, at) => (await fetch(base + at)).headers.get('content-security-policy');
  assert.match(await policyOf(framing.url, '?embed=1'), new RegExp(`frame-ancestors https://other\\.example ${course};`));
  for (const at of ['', '?embed=0', 'api/v1/scenarios?brief=true'])
    assert.match(await policyOf(framing.url, at), /frame-ancestors 'none'/, at);
  assert.match(await policyOf(daemon.url, '?embed=1'), /frame-ancestors 'none'/, 'without the option');
  const framed = async (base, query) => {
    const { page, complaints, close } = await visit(browser, `${course}/?of=${encodeURIComponent(base + query)}`, {
      wait: false,
      width: 900,
      height: 640,
    });
    return { page, complaints, close, frame: page.frameLocator('iframe') };
  };
  const one = await framed(framing.url, '?scenario=race&set=players.0.lag_ms:222&embed=1');
  await one.frame.locator('#play').waitFor();
  await until(async () => /tick [1-9]/.test((await one.frame.locator('#ticks').textContent()) ?? ''), 'it runs');
  assert.equal(await one.frame.locator('header.top').count(), 0);
  await settles(() => one.frame.locator('canvas[data-view]:visible').count(), 3);
  assert.equal(await one.frame.locator('.gutter:visible, .side:visible').count(), 0);
  await reads(() => one.frame.locator('#embed-caption').textContent(), /A race in three views/);
  await settles(() => one.frame.locator('#scrub').isVisible(), true);
  const href = await one.frame.locator('#whole').getAttribute('href');
  assert.match(href ?? '', /^\/\?scenario=race&set=players\.0\.lag_ms:222$/);
  await one.frame.locator('#play').click();
  await one.frame.getByRole('button', { name: 'Play', exact: true }).waitFor();
  assert.deepEqual(one.complaints, []);
  await one.close();
  const alone = await visit(browser, `${framing.url}?scenario=race&embed=1`, { wait: false, width: 800, height: 480 });
  await alone.page.locator('#whole').waitFor();
  await alone.page.waitForFunction(() => globalThis.laglab().frame !== null);
  assert.deepEqual(await axe(alone.page), []);
  await alone.close();
  for (const [base, query] of [
    [framing.url, '?scenario=race'],
    [daemon.url, '?scenario=race&embed=1'],
  ]) {
    const refused = await framed(base, query);
    await until(async () => /frame-ancestors/.test(refused.complaints.join()), `${query} is refused`);
    assert.equal(await refused.frame.locator('#play').count(), 0, query);
    await refused.close();
  }
});

// ---- nothing set is lost ----

const lagOf = (page) => page.evaluate(() => globalThis.laglab().params?.players?.[0]?.lag_ms ?? null);
const kindOf = (page) => page.evaluate(() => globalThis.laglab().params?.kind ?? '');
const note = (page) => page.locator('aside.note').textContent();

test('another lab keeps what was changed: it says so, Back, Forward and the tab return with it', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}?scenario=race&set=players.0.lag_ms:222&seed=9`);
  await page.evaluate(() => {
    globalThis.same = true;
  });
  const tab = (name) => page.getByRole('navigation', { name: 'Labs' }).getByRole('button', { name, exact: true });
  await tab('Step').click();
  await until(async () => (await kindOf(page)) === 'motion', 'the step lab');
  await until(async () => /2 changed settings kept: Back returns to them/.test((await note(page)) ?? ''), 'it says so');
  await page.goBack();
  await until(async () => (await lagOf(page)) === 222, 'Back: the race with its lag');
  assert.equal(await page.evaluate(() => globalThis.laglab().params.seed), 9);
  assert.match(page.url(), /set=players\.0\.lag_ms:222&seed=9/);
  await page.goForward();
  await until(async () => (await kindOf(page)) === 'motion', 'Forward');
  await tab('Race').click();
  await until(async () => (await lagOf(page)) === 222, 'the tab');
  await until(async () => /2 changed settings as you left them/.test((await note(page)) ?? ''), 'it says so');
  await page.evaluate(() => {
    location.hash = '#collide';
  });
  await until(async () => (await kindOf(page)) === 'rigid', 'a short address that is typed');
  assert.equal(await page.evaluate(() => globalThis.same), true, 'all on one page');
  assert.deepEqual(complaints, []);
  await close();
});

test('another problem of the step lab keeps what was changed, and no measured curve of the one before', async () => {
  const { page, close } = await visit(browser, `${daemon.url}?scenario=motion/spring&set=methods.0.dt_s:0.25`);
  await page.locator('#problem').selectOption('pendulum');
  await until(async () => (await page.evaluate(() => globalThis.laglab().params?.problem)) === 'pendulum', 'the pendulum');
  await until(async () => /One changed setting kept: Back returns to it/.test((await note(page)) ?? ''), 'it says so');
  await page.goBack();
  await until(async () => (await page.evaluate(() => globalThis.laglab().params?.methods?.[0]?.dt_s)) === 0.25, 'Back');
  await close();
});

for (const language of ['en', 'de'])
  sweep(language === 'de')(`on a phone no button lies over a view of a race: ${language}`, async () => {
    const { page, complaints, close } = await visit(browser, `${daemon.url}?lang=${language}#race`, {
      width: 390,
      height: 844,
    });
    await ready(page);
    const rows = await page.evaluate(() =>
      [...document.querySelectorAll('.row:has(> .view > take-away)')].map((row) => {
        const box = (/** @type {string} */ what) => row.querySelector(what)?.getBoundingClientRect();
        const button = box('take-away button'),
          words = box('.caption .techniques');
        return [button.bottom <= box('canvas').top + 1, button.left >= words.right - 1, button.right <= box('.caption .icon').left + 1];
      }),
    );
    assert.deepEqual(rows, Array(3).fill([true, true, true]));
    assert.deepEqual(await axe(page), []);
    assert.deepEqual(complaints, []);
    await close();
  });
