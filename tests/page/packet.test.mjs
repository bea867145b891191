// The packet view: one input through both loops and the buffers, with times that are the daemon's.
import assert from 'node:assert/strict';
import { after, before } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { api, axe, button, frameOf, launch, pause, reads, refreshes, settles, until, visit } from './lib.mjs';
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

const PLAIN = 'set=players.0.prediction:false&set=players.0.reconciliation:false';
const SIZES = [
  { name: '1366x768', width: 1366, height: 768 },
  { name: '768x1024', width: 768, height: 1024 },
  { name: '390x844', width: 390, height: 844 },
];
const TENTH = 0.05; /* ms: numbers are shown to a tenth */

/** What the view shows. @param {import('playwright-core').Page} page */
const shownOf = (page) =>
  page.evaluate(() => {
    const number = (/** @type {Element | null} */ cell) => Number.parseFloat(cell?.textContent?.replace(',', '.') ?? '');
    return {
      says: document.getElementById('packet-says')?.textContent ?? '',
      total: number(document.querySelector('.stations tfoot td:last-child')),
      stations: [...document.querySelectorAll('.stations tbody tr')].map((row) => ({
        id: /** @type {HTMLElement} */ (row).dataset.station,
        text: row.textContent ?? '',
        at: number(row.children[1] ?? null),
        ms: number(row.children[2] ?? null),
      })),
    };
  });
/** @param {{says: string}} shown */
const inputOf = ({ says }) => Number(/Input (\d+)/.exec(says)?.[1]);
/** @param {import('playwright-core').Page} page */
const opened = (page) => page.locator('.stations tbody tr').first().waitFor();
/** Until the view says it, and then what it shows. @param {import('playwright-core').Page} page @param {RegExp} what */
const says = (page, what) =>
  until(async () => {
    const now = await shownOf(page);
    return what.test(now.says) && now;
  }, String(what));

/** @param {Awaited<ReturnType<typeof shownOf>>} shown */
function addsUp({ stations, total }) {
  const sum = stations.slice(1).reduce((all, { ms }) => all + ms, 0);
  assert.ok(stations.length >= 7 && total > 0, `${stations.length} stations, ${total} ms`);
  assert.equal(sum.toFixed(1), total.toFixed(1));
  const first = stations[0]?.at ?? 0,
    last = stations.at(-1)?.at ?? 0;
  assert.ok(Math.abs((last - first) * 1000 - total) < 0.2, `${first} s to ${last} s in ${total} ms`);
}

/** A session that is paused at a tick after 1 s; `set` on top of a player who is driven by a person.
 * @param {Record<string, any>} set */
async function session(set) {
  const made = (
    await api(daemon.url, 'sessions', {
      scenario: 'race',
      seed: 3,
      set: {
        warmup_s: 0,
        'players.0.prediction': false,
        'players.0.reconciliation': false,
        'players.0.control': 'person',
        ...set,
      },
    })
  ).body;
  const control = async (/** @type {any} */ body) => {
    const answer = await api(daemon.url, `sessions/${made.id}/control`, body, made.owner_key);
    assert.equal(answer.status, 200, JSON.stringify(answer.body));
  };
  await control({ op: 'pause' });
  await control({ op: 'seek', tick: 120 });
  return { id: made.id, key: made.owner_key, control };
}

/** The first row of a trace where a column differs from the row before. @param {string} csv @param {string} column */
function changeOf(csv, column) {
  const [head = '', ...lines] = csv.trim().split('\n');
  const at = head.split(',').indexOf(column),
    tick = head.split(',').indexOf('tick'),
    step = head.split(',').indexOf('server_step');
  assert.ok(at > 0 && tick > 0 && step > 0, head);
  const rows = lines.map((line) => line.split(',').map(Number));
  const i = rows.findIndex((row, k) => k > 0 && row[at] !== rows[k - 1]?.[at]);
  assert.ok(i > 0, `${column} never changes`);
  return { tick: /** @type {number} */ (rows[i]?.[tick]), step: /** @type {number} */ (rows[i]?.[step]) };
}

for (const [name, set] of /** @type {[string, Record<string, any>][]} */ ([
  ['a constant delay', {}],
  ['jitter in both directions', { 'players.0.link.up.jitter_ms': 25, 'players.0.link.down.jitter_ms': 25 }],
  ['a de-jitter buffer', { 'players.0.dejitter': 'arrival', 'players.0.dejitter_ms': 60, 'players.0.link.down.jitter_ms': 10 }],
  ['a slow input device', { 'players.0.input_device_ms': 30 }],
  ['rare updates', { 'server.update_hz': 7 }],
]))
  test(`times are those of the engine's own measurement and of its trace: ${name}`, async () => {
    const { id, key, control } = await session(set);
    const drive = await api(daemon.url, `sessions/${id}/input`, { player: 0, axes: [1, 0], buttons: 0 }, key);
    assert.equal(drive.status, 200, JSON.stringify(drive.body));
    await control({ op: 'step', ticks: 60 });
    const measured = (await api(daemon.url, `sessions/${id}/metrics`)).body.metrics.players[0].input_latency_ms;
    const csv = await (await fetch(`${daemon.url}api/v1/sessions/${id}/trace?from_s=1.9`)).text();
    assert.equal(measured.count, 1, 'one change of the controls was measured');

    const { page, complaints, close } = await visit(browser, `${daemon.url}#s=${id}`);
    await until(async () => (await frameOf(page))?.tick === 180, 'the tick');
    const first = await page.evaluate(
      (time) => globalThis.laglab().messages.find((one) => one.type === 1 && one.player === 0 && one.begin_s > time)?.number, // input
      drive.body.time_s,
    );
    await page.keyboard.press('n');
    await opened(page);
    await page.locator('.packetview .view').focus();
    let now = await says(page, /Input \d+/);
    for (let i = 0; i < 60 && inputOf(now) !== first; i++) {
      const before = inputOf(now);
      await page.keyboard.press(before > first ? 'ArrowLeft' : 'ArrowRight');
      now = await until(async () => {
        const next = await shownOf(page);
        return inputOf(next) !== before && next;
      }, `another input than ${before}`);
    }
    assert.equal(inputOf(now), first);
    addsUp(now);
    assert.ok(Math.abs(now.total - measured.mean) <= TENTH + 0.01, `shown ${now.total} ms, measured ${measured.mean} ms`);
    assert.match(now.says, new RegExp(`shows after ${now.total.toFixed(1)} ms`));

    const server = changeOf(csv, 'server_0_x_m'),
      drawn = changeOf(csv, 'player_0_own_x_m');
    const taken = now.stations.find((one) => one.id === 'taken'),
      shown = now.stations.at(-1);
    assert.match(taken?.text ?? '', new RegExp(`in tick ${server.step},`));
    assert.equal(Math.ceil((shown?.at ?? 0) * 60 - 0.01), drawn.tick, 'the trace shows it from the tick after the display on');
    assert.deepEqual(complaints, []);
    await close();
  });

test('with prediction it shows at once, and the answer of the server comes later', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}?scenario=race`);
  await page.waitForFunction(() => globalThis.laglab().frame.tick > 90);
  await pause(page);
  await page.keyboard.press('n');
  await opened(page);
  const now = await says(page, /Input \d+ shows after 0\.0 ms, by prediction; the server’s answer is there after [\d.]+ ms\./);
  addsUp(now);
  assert.match(now.stations.at(-1)?.text ?? '', /confirmed or corrected/);
  assert.deepEqual(complaints, []);
  await close();
});

test('it moves on with time, stands still with it, and goes back with a step back', async () => {
  const { page, close } = await visit(browser, `${daemon.url}?scenario=race&${PLAIN}`);
  await page.waitForFunction(() => globalThis.laglab().frame.tick > 90);
  await pause(page);
  await page.keyboard.press('n');
  await opened(page);
  await button(page, 'Newest').click();
  const begin = await says(page, /is under way: on the link up/);
  await refreshes(page); /* the drawing follows the words */
  const picture = () => page.locator('#loops').evaluate((canvas) => /** @type {any} */ (canvas).toDataURL());
  const still = await picture();
  await refreshes(page);
  assert.equal(await picture(), still, 'while time stands still');
  const number = inputOf(begin);
  const seen = [];
  for (let i = 0; i < 40; i++) {
    const { tick } = await frameOf(page);
    const before = await picture();
    await page.locator('#packet-title').focus();
    await page.keyboard.press('.');
    await page.waitForFunction((t) => globalThis.laglab().frame.tick > t, tick);
    const now = await shownOf(page);
    assert.equal(inputOf(now), number, 'the same input');
    seen.push(now.stations.at(-1)?.id);
    if (i < 15) assert.notEqual(await picture(), before, `tick ${tick + 1} moves it`);
    if (/shows after/.test(now.says)) break;
  }
  assert.deepEqual(
    [...new Set(seen)].filter((id) => ['sent', 'arrived', 'taken', 'left', 'shown'].includes(id ?? '')).at(-1),
    'shown',
    seen.join(' '),
  );
  assert.ok(new Set(seen).size >= 3, seen.join(' '));
  const done = await shownOf(page);
  addsUp(done);
  for (let i = 0; i < 4; i++) {
    const { tick } = await frameOf(page);
    await page.keyboard.press(',');
    await page.waitForFunction((t) => globalThis.laglab().frame.tick < t, tick);
  }
  const back = await says(page, /is under way/);
  assert.equal(inputOf(back), number);
  assert.ok(back.stations.length < done.stations.length);
  await close();
});

test('a lost packet is called lost, and a repeated input repeated', async () => {
  const { page, close } = await visit(
    browser,
    `${daemon.url}?scenario=race&${PLAIN}&seed=4&set=players.0.link.up.loss_pct:40&set=players.0.redundancy:0`,
  );
  await page.waitForFunction(() => globalThis.laglab().frame.tick > 200);
  await pause(page);
  await page.keyboard.press('n');
  await opened(page);
  await page.locator('.packetview .view').focus();
  const found = new Set();
  for (let i = 0; i < 60 && found.size < 2; i++) {
    const now = await shownOf(page),
      number = inputOf(now);
    const fate = await page.evaluate(
      (n) =>
        globalThis
          .laglab()
          .messages.filter((one) => one.type === 1 && one.player === 0 && one.number === n)
          .map((one) => one.fate),
      number,
    );
    if (fate.every((one) => one === 1)) {
      assert.match(now.says, /is lost/, `input ${number}`);
      found.add('lost');
    } else {
      assert.doesNotMatch(now.says, /lost/, `input ${number}`);
      found.add('through');
    }
    await page.keyboard.press('ArrowLeft');
    await page.waitForFunction((text) => document.getElementById('packet-says')?.textContent !== text, now.says);
  }
  assert.deepEqual([...found].sort(), ['lost', 'through']);
  await close();

  const again = await visit(
    browser,
    `${daemon.url}?scenario=race&${PLAIN}&seed=4&set=players.0.link.up.loss_pct:40&set=players.0.redundancy:5`,
  );
  await again.page.waitForFunction(() => globalThis.laglab().frame.tick > 200);
  await pause(again.page);
  await again.page.keyboard.press('n');
  await opened(again.page);
  await again.page.locator('.packetview .view').focus();
  for (let i = 0; i < 60; i++) {
    if ((await again.page.locator('.packetview').innerText()).includes('A later packet brought the input')) break;
    const { says: text } = await shownOf(again.page);
    await again.page.keyboard.press('ArrowLeft');
    await again.page.waitForFunction((old) => document.getElementById('packet-says')?.textContent !== old, text);
  }
  await reads(again.page.locator('.packetview'), /lost before: [1-9]/);
  await again.close();
});

for (const size of SIZES)
  sweep(size.width !== 768)(`${size.name}: by keyboard alone from the messages to the view and back; axe has nothing`, async () => {
    const { page, complaints, close } = await visit(browser, `${daemon.url}?scenario=race`, size);
    await page.waitForFunction(() => globalThis.laglab().frame.tick > 90);
    if (size.width > 700) {
      await page.locator('.row.lane [data-arrows]').focus();
      await page.keyboard.press('ArrowLeft');
      await page.waitForFunction(() => /Input \d+ of A/.test(document.getElementById('lane-facts')?.textContent ?? ''));
      const chosen = /Input (\d+)/.exec((await page.locator('#lane-facts').textContent()) ?? '')?.[1];
      await page.keyboard.press('Enter');
      await opened(page);
      await settles(async () => String(inputOf(await shownOf(page))), chosen, 'the input that was chosen among the messages');
    } else {
      await button(page, 'Packet').focus();
      await page.keyboard.press('Enter');
      await opened(page);
    }
    await page.waitForFunction(() => document.activeElement?.id === 'packet-title');
    await button(page, 'Pause').focus();
    await page.keyboard.press('Enter');
    await button(page, 'Play').waitFor();
    assert.deepEqual(await axe(page), []);
    assert.ok(!(await page.evaluate(() => document.documentElement.scrollWidth > innerWidth)), 'no sideways scrolling');
    await page.locator('.packetview .view').focus();
    const before = inputOf(await says(page, /Input \d+/));
    await page.keyboard.press('ArrowLeft');
    await until(async () => inputOf(await shownOf(page)) === before - 1, 'the input before');
    await page.locator('#packet-player').focus();
    await page.keyboard.press('ArrowDown');
    await until(async () => (await page.locator('#loops').getAttribute('aria-label'))?.includes('network loop of B'), 'player B');
    await page.locator('.packetview .view').focus();
    await page.keyboard.press('Escape');
    await page.locator('#lane').waitFor({ state: size.width > 700 ? 'visible' : 'attached' });
    await page.locator('.packetview').waitFor({ state: 'detached' });
    assert.deepEqual(complaints, []);
    await close();
  });

test('a click in the drawing follows the packet that is there', async () => {
  const { page, close } = await visit(browser, `${daemon.url}?scenario=race`);
  await page.waitForFunction(() => globalThis.laglab().frame.tick > 120);
  await pause(page);
  await page.keyboard.press('n');
  await opened(page);
  const before = inputOf(await says(page, /Input \d+/));
  const box = await page.locator('#loops').boundingBox();
  assert.ok(box);
  await page.mouse.click(box.x + box.width * 0.4, box.y + box.height * 0.5);
  const next = await until(async () => {
    const now = inputOf(await shownOf(page));
    return now !== before && now;
  }, 'another input');
  assert.ok(next > before, `${next} was sent after ${before}`);
  await close();
});

for (const id of ['figure_6', 'figure_7'])
  sweep(id === 'figure_6')(`the lesson of ${id} opens it, from the list of the first page, in both languages`, async () => {
    const { page, complaints, close } = await visit(browser, daemon.url, { wait: false });
    await page.locator('[aria-controls="door-more"]').first().click();
    await page.locator(`a[href*="lesson=${id}"]`).first().click();
    await page.locator('.option input').first().check();
    await page.getByRole('button', { name: 'Lock in and run' }).click();
    await opened(page);
    await settles(() => page.locator('#packet-title').textContent(), 'The way of a packet');
    await button(page, 'DE, Deutsch').click();
    await page.waitForFunction(() => document.getElementById('packet-title')?.textContent === 'Der Weg eines Pakets');
    assert.doesNotMatch(await page.locator('.packetview').innerText(), /\b(loop|input|buffer)\b/);
    assert.deepEqual(complaints, []);
    await close();
  });

test('in the sandbox it takes two clicks; its modules are read only then', async () => {
  const { page, requests, close } = await visit(browser, daemon.url, { wait: false });
  await page.locator('.lab', { hasText: 'Race' }).click();
  await page.locator('#follow').waitFor();
  await page.waitForFunction(() => (globalThis.laglab().frame?.tick ?? 0) > 60);
  assert.ok(!requests.some((one) => /packet[-/]/.test(one.url())), 'nothing of it is read before');
  await page.locator('#follow').click();
  await opened(page);
  assert.ok(requests.some((one) => /js\/packet-\w+\.js$/.test(one.url())));
  await close();
});

test('where peers exchange inputs, it says that it has nothing to follow', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}?scenario=deterministic`);
  await page.waitForFunction(() => globalThis.laglab().frame.tick > 30);
  await page.keyboard.press('n');
  await says(page, /no snapshots/);
  assert.deepEqual(complaints, []);
  await close();
});
