// Questions and lessons: the first page, the steps of a lesson, both languages.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { after, before } from 'node:test';
import { fileURLToPath } from 'node:url';
import { filled } from '../../docs/lessons.mjs';
import { startDaemon } from '../lib/daemon.mjs';
import { api, axe, launch, paramsOf, reads, refreshes, sessionOf, settles, shown, tickOf, until, visit } from './lib.mjs';
import { sweep, test } from './tiers.mjs';

const WWW = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../../www');
const lessonOf = (id) => JSON.parse(readFileSync(path.join(WWW, `lessons/${id}.json`), 'utf8'));
const WORDS = Object.fromEntries(
  ['en', 'de'].map((name) => [name, JSON.parse(readFileSync(path.join(WWW, `words/${name}.json`), 'utf8')).lesson]),
);
const SIZES = [
  { name: '1366x768', width: 1366, height: 768 },
  { name: '768x1024', width: 768, height: 1024 },
  { name: '390x844', width: 390, height: 844 },
];
const LATE = lessonOf('late_answer');

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

/** The first page, with its cards. @param {string} [at] @param {any} [wish] */
async function door(at = '', wish = {}) {
  const visited = await visit(browser, daemon.url + at, { ...wish, wait: false });
  await visited.page.locator('.card').first().waitFor();
  return visited;
}

/** A lesson at a step, with its session drawn. @param {string} id @param {number} [step] @param {string} [lang] @param {any} [wish] */
async function open(id, step = 1, lang = 'en', wish = {}) {
  const visited = await visit(browser, `${daemon.url}${wish.query ?? ''}#lesson=${id}&step=${step}&lang=${lang}`, { ...wish, wait: false });
  await ready(visited.page);
  return visited;
}
/** @param {import('playwright-core').Page} page */
async function ready(page) {
  await page.locator('#rail .steps').waitFor();
  await shown(page);
}
/** @param {import('playwright-core').Page} page @param {string} name */
const current = (page, name) => page.locator('.steps [aria-current="step"]', { hasText: name }).waitFor();
/** @param {import('playwright-core').Page} page */
const stepped = (page) => new URLSearchParams(new URL(page.url()).hash.slice(1)).get('step');
const play = (page) => page.locator('#play');
const sideways = (page) => page.evaluate(() => document.documentElement.scrollWidth > innerWidth);

test('the first page has ten questions, the other lessons, all scenarios and a race; it asks the daemon only, and for little', async () => {
  const { page, requests, complaints, close } = await door();
  await settles(() => page.locator('.card').count(), 10);
  await settles(
    async () => (await page.locator('.card .title').allTextContents()).slice(0, 3),
    ['late_answer', 'jump_back', 'in_the_past'].map((id) => lessonOf(id).title.en),
  );
  assert.equal(await page.locator('section[aria-labelledby="topic-paper"]').count(), 0, 'what is not asked for is not there');
  await page.getByRole('button', { name: 'All 31 lessons' }).click();
  await settles(() => page.locator('section[aria-labelledby="topic-paper"] li').count(), 13);
  await page.locator('section[aria-labelledby="topic-techniques"] li').nth(7).waitFor();
  const { scenarios } = (await api(daemon.url, 'scenarios?brief=true')).body;
  await page.getByRole('button', { name: 'Find a scene' }).click();
  await until(async () => (await page.locator('.scenes li').count()) === scenarios.length, 'every scenario');
  await until(async () => (await paramsOf(page))?.players[0].control === 'person', 'the race');
  await reads(() => page.title(), /^Questions – laglab$/);
  assert.ok(requests.every((request) => request.url().startsWith(daemon.url)));
  const sizes = await Promise.all(requests.map(async (r) => (await (await r.response())?.body().catch(() => null))?.length ?? 0));
  const total = sizes.reduce((a, b) => a + b, 0);
  assert.ok(total > 100000 && total < 450000, `${total} bytes in ${requests.length} requests`);
  assert.deepEqual(complaints, []);
  await close();
});

test('one click opens a question, paused at its start; Back returns to the questions, Forward to it, in one page', async () => {
  const { page, complaints, close } = await door();
  await page.evaluate(() => {
    globalThis.same = true;
  });
  await page.locator('.card').first().click();
  await ready(page);
  await reads(async () => page.url(), /#lesson=late_answer&step=1/);
  await settles(() => page.locator('#lesson-step').textContent(), LATE.title.en);
  await settles(() => tickOf(page), LATE.start_tick);
  const now = await paramsOf(page);
  assert.equal(now.players[0].prediction, false);
  assert.equal(now.duration_s, LATE.set.duration_s);
  const { id } = await sessionOf(page);
  await page.goBack();
  await page.locator('.card').nth(9).waitFor();
  assert.equal(await page.evaluate(() => globalThis.same), true);
  await until(async () => (await api(daemon.url, `sessions/${id}`)).status === 404, 'its session is deleted');
  await page.goForward();
  await ready(page);
  assert.equal(await page.evaluate(() => globalThis.same), true);
  await page.locator('.lab', { hasText: 'Questions' }).click();
  await page.locator('.card').nth(9).waitFor();
  assert.deepEqual(
    complaints.filter((text) => !/404/.test(text)),
    [],
  );
  await close();
});

const moving = (page) => page.evaluate(() => document.getAnimations().filter((one) => one.playState === 'running').length);

test('cards play their recorded run once when they come into view, again under the pointer, and stand still else', async () => {
  const { page, complaints, close } = await door();
  await until(async () => (await moving(page)) > 10, 'they move');
  const box = page.locator('[data-card="in_the_past"] [data-part="b"]');
  const at = () => box.evaluate((part) => getComputedStyle(part).transform);
  const before = await at();
  await until(async () => (await at()) !== before, 'B moves');
  await until(async () => (await moving(page)) === 0, 'each once');
  assert.equal(await at(), 'matrix(1, 0, 0, 1, 50, 59)', 'at rest the drawing is as it was');
  await page.locator('[data-card="falling_stack"]').hover();
  await until(async () => (await moving(page)) === 6, 'six boxes fall');
  await page.mouse.move(5, 5);
  await until(async () => (await moving(page)) === 0, 'without it nothing moves');
  await page.locator('[data-card="keeps_energy"]').focus();
  await until(async () => (await moving(page)) >= 2, 'under the focus');
  assert.deepEqual(complaints, []);
  await close();
});

test('with reduced motion the cards are still, and their runs are not read', async () => {
  const { page, requests, close } = await door('', { reducedMotion: 'reduce' });
  await refreshes(page, 60);
  assert.equal(await moving(page), 0);
  assert.ok(requests.every((request) => !/cards\.json|moving-/.test(request.url())));
  await close();
});

test('Play is locked until a choice is made; then it stops on the tick, and the answer is the engine’s', async () => {
  const { page, complaints, close } = await open('late_answer');
  await settles(() => play(page).isDisabled(), true);
  await settles(() => page.locator('#lock-in').isDisabled(), true);
  await reads(page.locator('.bar .held'), /Answer first/);
  await page.keyboard.press('Space');
  await refreshes(page);
  assert.equal(await tickOf(page), LATE.start_tick, 'no key plays');
  await page.keyboard.press('2');
  await settles(() => page.locator('.option input').nth(1).isChecked(), true);
  await settles(() => play(page).isDisabled(), false);
  await page.locator('#lock-in').click();
  await current(page, 'Observe');
  await settles(() => tickOf(page), LATE.stop_tick);
  await refreshes(page);
  assert.equal(await tickOf(page), LATE.stop_tick, 'it stays there');
  await settles(() => page.locator('#rail > p').first().textContent(), filled(LATE, LATE.steps.observe.en, 'en'));
  const { id, key } = await page.evaluate(() => {
    const { session } = globalThis.laglab();
    return { id: session.id, key: JSON.parse(sessionStorage.getItem('laglab')).keys[session.id] };
  });
  await page.locator('#rail .main').click();
  await current(page, 'Explain');
  await reads(page.locator('.pair dd').first(), /^150 ms$/);
  await settles(() => page.locator('.why').innerText(), LATE.choices[1].why.en);
  const claimed = Number.parseFloat(await reads(page.locator('#answer'), /\d/));
  await api(daemon.url, `sessions/${id}/control`, { op: 'seek', time_s: LATE.set.duration_s }, key);
  const measured = await until(async () => {
    const { body } = await api(daemon.url, `sessions/${id}/metrics`);
    return body.time_s >= LATE.set.duration_s && body.metrics.players[0].input_latency_ms.mean;
  }, 'the end of the run');
  assert.ok(Math.abs(claimed - measured) < 1, `claimed ${claimed}, measured ${measured}`);
  assert.deepEqual(complaints, []);
  await close();
});

test('Skip goes on without a choice; Play of the bar stops, too', async () => {
  const skipped = await open('jump_back');
  await skipped.page.getByRole('button', { name: WORDS.en['predict.skip'] }).click();
  await current(skipped.page, 'Observe');
  await settles(() => tickOf(skipped.page), lessonOf('jump_back').stop_tick);
  await skipped.page.locator('#rail .main').click();
  await reads(skipped.page.locator('.pair dd').first(), /nothing/);
  await skipped.close();
  const { page, close } = await open('bullet_through');
  await page.locator('.option').first().click();
  await play(page).click();
  await current(page, 'Observe');
  await settles(() => tickOf(page), 4);
  await close();
});

test('the change is a session of the same seed with one thing set, and its answer is the engine’s', async () => {
  const lesson = lessonOf('in_the_past');
  const { page, complaints, close } = await open('in_the_past', 4);
  const seedOf = async () => (await api(daemon.url, `sessions/${(await sessionOf(page)).id}`)).body.seed;
  const before = await sessionOf(page);
  assert.equal(await seedOf(), lesson.seed);
  const plain = await paramsOf(page);
  await page.locator('#rail .main').click();
  await current(page, 'Change');
  await until(async () => (await sessionOf(page))?.id !== before.id && (await paramsOf(page)).server.update_hz === 5, 'the change');
  assert.equal(await seedOf(), lesson.seed);
  const changed = await paramsOf(page);
  changed.server.update_hz = plain.server.update_hz;
  assert.deepEqual(changed, plain);
  await reads(page.locator('#changed'), /^560 ms$/);
  await page.locator('#rail .main').click();
  await until(async () => (await tickOf(page)) === lesson.stop_tick, 'the same tick');
  const { id, key } = await page.evaluate(() => {
    const { session } = globalThis.laglab();
    return { id: session.id, key: JSON.parse(sessionStorage.getItem('laglab')).keys[session.id] };
  });
  await api(daemon.url, `sessions/${id}/control`, { op: 'seek', time_s: 20 }, key);
  const measured = await until(async () => {
    const { body } = await api(daemon.url, `sessions/${id}/metrics`);
    return body.time_s >= 20 && body.metrics.players[0].view_age_ms.mean;
  }, 'the end of the run');
  assert.ok(Math.abs(560 - measured) < 17, String(measured));
  await page.getByRole('button', { name: WORDS.en.free }).click();
  await page.waitForFunction(() => document.querySelector('#rail') === null);
  await reads(async () => page.url(), /\?scenario=race&.*server\.update_hz:5/);
  await settles(async () => (await sessionOf(page))?.id, id);
  assert.deepEqual(complaints, []);
  await close();
});

/** What can be used of the time bar. @param {import('playwright-core').Page} page */
const usable = (page) =>
  page.locator('.bar fieldset :is(button, select, input)').evaluateAll((all) => all.filter((one) => !one.matches(':disabled')).length);

test('a step locks what it does not name: time bar, keys, settings, dialogs, driving; one button unlocks all', async () => {
  const past = lessonOf('in_the_past');
  const { page, complaints, close } = await open('in_the_past', 3);
  await until(async () => (await tickOf(page)) === past.stop_tick, 'the stop');
  assert.equal(await play(page).isDisabled(), true);
  assert.equal(await page.locator('#scrub').isDisabled(), false);
  assert.equal(await usable(page), 3, 'a tick back, a tick forward, the scrubber');
  const plain = await paramsOf(page);
  for (const key of ['1', 'Shift+1', 'Space', 'r', 'Alt+r', ']', 'g', 'm', 'n']) await page.keyboard.press(key);
  await page.locator('.note', { hasText: WORDS.en['use.blocked'] }).waitFor();
  await page.locator('.view[data-drive="0"]').focus();
  await page.keyboard.press('ArrowRight');
  await refreshes(page);
  assert.deepEqual(await paramsOf(page), plain, 'no key changes a setting');
  assert.equal(await tickOf(page), past.stop_tick, 'no key plays');
  assert.equal(await page.locator('#packet-title').count(), 0);
  assert.equal(await page.locator('section.row.lane').isHidden(), false, 'messages are shown as before');
  assert.equal(await page.locator('.caption').first().isDisabled(), true, 'no dialog of settings');
  assert.equal(await page.locator('main [data-path]:visible').count(), 0);
  await page.keyboard.press('.');
  await until(async () => (await tickOf(page)) === past.stop_tick + 1, 'a step is left');
  await page.locator('#unlock').click();
  await page.getByText(WORDS.en['use.free']).waitFor();
  assert.equal(await play(page).isDisabled(), false);
  assert.ok((await page.locator('main [data-path]:visible').count()) > 10, 'the lab’s settings');
  await page.locator('#views').focus();
  await page.keyboard.press('1');
  await until(async () => (await paramsOf(page)).players[0].prediction === false, 'the key works');
  await page.locator('#unlock').click();
  await page.getByText(WORDS.en['use.locked']).waitFor();
  assert.equal(await play(page).isDisabled(), true);
  await page.locator('#rail .main').click();
  await current(page, 'Explain');
  await until(async () => (await paramsOf(page)).players[0].prediction === true, 'the next step has the lesson’s own settings');
  assert.deepEqual(complaints, []);
  await close();
});

test('unlocking frees a question, too, and holds until another lesson', async () => {
  const { page, close } = await open('late_answer');
  assert.equal(await play(page).isDisabled(), true);
  await page.locator('#unlock').click();
  await until(() => play(page).isEnabled(), 'Play is free');
  assert.equal(await page.locator('.bar .held').count(), 0);
  await page.locator('.option').first().click();
  await page.locator('#lock-in').click();
  await current(page, 'Observe');
  assert.equal(await play(page).isDisabled(), false);
  await page.evaluate(() => {
    location.hash = '#lesson=jump_back&step=1&lang=en';
  });
  await page.waitForFunction((title) => document.querySelector('#lesson-step')?.textContent === title, lessonOf('jump_back').title.en);
  await until(() => play(page).isDisabled(), 'locked again');
  await close();
});

test('the settings of the change stand in the rail: one of a run, and one that makes another run', async () => {
  const { page, complaints, close } = await open('jump_back', 5);
  const box = page.locator('#rail [data-path="players.0.reconciliation"]');
  await box.waitFor();
  assert.equal(await box.isChecked(), true);
  assert.notEqual(await box.getAttribute('data-lit'), null, 'it is highlighted');
  const first = await sessionOf(page);
  await box.uncheck();
  await until(async () => (await paramsOf(page)).players[0].reconciliation === false, 'without reconciliation');
  assert.equal((await sessionOf(page)).id, first.id);
  await close();
  const other = await open('bullet_through', 5);
  const hz = other.page.locator('#rail [data-path="hz"]');
  await hz.waitFor();
  await until(async () => (await hz.inputValue()) === '480', 'the change');
  const before = await sessionOf(other.page);
  await hz.fill('960');
  await hz.press('Enter');
  await until(async () => (await paramsOf(other.page)).hz === 960 && (await sessionOf(other.page)).id !== before.id, 'another run');
  assert.equal((await api(daemon.url, `sessions/${(await sessionOf(other.page)).id}`)).body.seed, lessonOf('bullet_through').seed);
  assert.deepEqual([...complaints, ...other.complaints], []);
  await other.close();
});

/** One of each lab, and one of a packet's way. */
const SOME = ['late_answer', 'figure_6', 'keeps_energy', 'falling_stack', 'vanishing_smoke'];
/** Of the lessons of the first page. @param {import('playwright-core').Page} page @param {boolean} some @returns {Promise<string[]>} */
async function chosen(page, some) {
  await page.getByRole('button', { name: 'All 31 lessons' }).click();
  const ids = await until(async () => {
    const found = await page
      .locator('a[href^="#lesson="]')
      .evaluateAll((all) => all.map((a) => /lesson=(\w+)/.exec(a.getAttribute('href') ?? '')?.[1] ?? ''));
    return found.length === 31 && found;
  }, '31 lessons');
  assert.equal(ids.filter((id) => SOME.includes(id)).length, SOME.length);
  return ids.filter((id) => SOME.includes(id) === some);
}

for (const some of [true, false])
  sweep(some)(
    `in ${some ? 'a lesson of each lab' : 'every other lesson'} the settings that steps name are there, and the stop highlights one thing`,
    async () => {
      const { page, complaints, close } = await door();
      for (const id of await chosen(page, some)) {
        const lesson = lessonOf(id);
        await page.evaluate((hash) => {
          location.hash = hash;
        }, `lesson=${id}&step=3&lang=en`);
        const heading = filled(lesson, (lesson.headings?.observe ?? lesson.title).en, 'en');
        await page.waitForFunction((title) => document.querySelector('#lesson-step')?.textContent === title, heading);
        await until(
          async () => (await page.evaluate(() => globalThis.laglab().frame?.tick)) === lesson.stop_tick,
          `${id} stands at its stop`,
        );
        if (lesson.look.at === 'packet') await page.locator('#packet-title').waitFor();
        else {
          await until(async () => (await page.locator('.teach > main [data-lit]').count()) === 1, `${id} highlights one thing`);
          await until(async () => /^Highlighted: .+/.test(await page.locator('#highlighted').innerText()), `${id} names it`);
          assert.equal(await page.locator('.teach > main [data-lit]').isVisible(), true, `${id}: it is seen`);
        }
        await page.evaluate((hash) => {
          location.hash = hash;
        }, `lesson=${id}&step=5&lang=en`);
        await current(page, 'Change');
        await until(
          async () => (await page.evaluate(() => globalThis.laglab().frame?.tick)) === (lesson.start_tick ?? 0),
          `${id} begins again`,
        );
        for (const name of lesson.controls.change.filter((one) => !one.startsWith('time.'))) {
          await page.locator(`#rail [data-path="${name}"]`).first().waitFor();
          assert.equal(await page.locator(`#rail [data-path="${name}"]`).first().isEnabled(), true, `${id} ${name}`);
        }
      }
      assert.deepEqual(
        complaints.filter((text) => !/404/.test(text)) /* what was asked of a session that the next lesson ended */,
        [],
      );
      await close();
    },
  );

test('a step outlives a reload, with the answer that was given', async () => {
  const { page, close } = await open('late_answer');
  await page.locator('.option').nth(3).click();
  await page.locator('#lock-in').click();
  await current(page, 'Observe');
  await page.locator('#rail .main').click();
  await current(page, 'Explain');
  await settles(async () => stepped(page), '4');
  await page.reload();
  await ready(page);
  await current(page, 'Explain');
  await reads(page.locator('.pair dd').first(), /^500 ms$/);
  await until(async () => (await tickOf(page)) === LATE.stop_tick, 'the tick');
  await page.locator('.steps button').first().click();
  await current(page, 'Predict');
  await until(async () => (await tickOf(page)) === LATE.start_tick, 'the start');
  await close();
});

test('German: the switch, the address, numbers and the language of the text', async () => {
  const { page, close } = await door();
  await page.getByRole('button', { name: 'DE, Deutsch' }).click();
  await page.getByRole('heading', { name: WORDS.de['door.title'] }).waitFor();
  await settles(() => page.locator('main').getAttribute('lang'), 'de');
  await settles(async () => (await page.locator('.card .title').allTextContents())[0], LATE.title.de);
  await page.locator('.card').first().click();
  await ready(page);
  await reads(async () => page.url(), /lang=de/);
  await settles(() => page.locator('#rail').getAttribute('lang'), 'de');
  await settles(() => page.locator('#rail > p').first().textContent(), filled(LATE, LATE.steps.predict.de, 'de'));
  await reads(page.locator('.bar .held'), /Erst antworten/);
  await page.locator('.option').first().click();
  await page.locator('#lock-in').click();
  await current(page, WORDS.de['steps.observe']);
  await reads(() => page.locator('#rail > p').first().textContent(), /16,6 m/);
  await page.getByRole('button', { name: 'EN, English' }).click();
  await current(page, 'Observe');
  await settles(() => tickOf(page), LATE.stop_tick, 'the session stays');
  await close();
});

test('search finds questions in both languages, and scenarios', async () => {
  const { page, close } = await door();
  await page.getByRole('button', { name: 'Find a scene' }).click();
  await page.getByRole('searchbox').fill('Kugel');
  await until(async () => (await page.locator('.scenes a[href^="#lesson="]').count()) === 1, 'one question');
  await page.getByRole('searchbox').fill('cavity');
  await page.locator('.scenes a[href="?scenario=fluid/cavity"]').waitFor();
  await page.getByRole('searchbox').fill('qqqq');
  await page.getByText(WORDS.en['door.none']).waitFor();
  await close();
});

test('the explanation says what the paper says otherwise', async () => {
  for (const lang of ['en', 'de']) {
    const { page, close } = await open('figure_11', 4, lang);
    await reads(page.locator('#erratum'), new RegExp(lessonOf('figure_11').erratum[lang].slice(0, 40)));
    await close();
  }
});

for (const some of [true, false])
  sweep(some)(`${some ? 'a lesson of each lab' : 'every other lesson'} opens, in both languages, without a complaint`, async () => {
    const { page, complaints, close } = await door();
    for (const id of await chosen(page, some)) {
      const lesson = lessonOf(id);
      for (const lang of ['en', 'de']) {
        await page.evaluate((hash) => {
          location.hash = hash;
        }, `lesson=${id}&step=1&lang=${lang}`);
        await page.waitForFunction((title) => document.querySelector('#lesson-step')?.textContent === title, lesson.title[lang]);
        await settles(
          () => page.locator('#rail > p').first().textContent(),
          filled(lesson, lesson.steps.predict[lang], lang).replace(/-(?=\d)/g, '−'),
        );
        await settles(() => page.locator('.option').count(), lesson.choices.length);
      }
      await until(
        async () => (await sessionOf(page)) !== null && (await page.evaluate(() => globalThis.laglab().frame !== null)),
        `${id} is drawn`,
      );
    }
    assert.deepEqual(complaints, []);
    await close();
  });

test('by keyboard alone: card, choice, run, explain, change', async () => {
  const { page, close } = await door();
  await page.locator('.card').first().focus();
  await page.keyboard.press('Enter');
  await ready(page);
  await page.keyboard.press('3');
  await settles(() => page.evaluate(() => document.activeElement?.getAttribute('value')), '2');
  await page.keyboard.press('ArrowDown');
  await settles(() => page.locator('.option input').nth(3).isChecked(), true);
  await page.keyboard.press('Tab');
  await settles(() => page.evaluate(() => document.activeElement?.id), 'lock-in');
  await page.keyboard.press('Enter');
  await current(page, 'Observe');
  await settles(() => page.evaluate(() => document.activeElement?.id), 'lesson-step');
  for (const name of ['Explain', 'Change']) {
    await page.locator('#rail .main').focus();
    await page.keyboard.press('Enter');
    await current(page, name);
  }
  await close();
});

test('the stop is announced once, with what it shows', async () => {
  const { page, close } = await open('late_answer');
  await page.evaluate(() => {
    globalThis.spoken = [];
    new MutationObserver(() => globalThis.spoken.push(document.getElementById('live')?.textContent)).observe(
      /** @type {HTMLElement} */ (document.getElementById('live')),
      { childList: true, characterData: true, subtree: true },
    );
  });
  await page.keyboard.press('1');
  await page.locator('#lock-in').click();
  await current(page, 'Observe');
  const said = async () =>
    (await page.evaluate(() => globalThis.spoken)).filter((text) => text.includes(filled(LATE, LATE.steps.observe.en, 'en').slice(0, -1)));
  await until(async () => (await said()).length > 0, 'it is said');
  await refreshes(page, 150); /* a second announcement would follow after two seconds */
  const spoken = await said();
  assert.equal(spoken.length, 1, String(spoken));
  assert.match(spoken[0], /^Step 3 of 5: Observe\./);
  await close();
});

test('with reduced motion the run is at its stop at once', async () => {
  const { page, close } = await open('in_the_past', 1, 'en', { reducedMotion: 'reduce' });
  await page.keyboard.press('1');
  // What is drawn on the way there: nothing between the start and the stop.
  await page.evaluate(() => {
    globalThis.ticks = new Set();
    const note = () => {
      globalThis.ticks.add(globalThis.laglab().frame?.tick);
      requestAnimationFrame(note);
    };
    note();
  });
  await page.locator('#lock-in').click();
  await current(page, 'Observe');
  await until(async () => (await tickOf(page)) === 180, 'the tick');
  const ticks = await page.evaluate(() => [...globalThis.ticks]);
  assert.ok(ticks.length <= 10, `not in six seconds: ${ticks}`);
  await close();
});

for (const size of SIZES)
  sweep(size.width < 400)(`axe finds nothing, light and dark, and nothing goes sideways: ${size.name}`, async () => {
    const wish = { width: size.width, height: size.height };
    const right = async (/** @type {import('playwright-core').Page} */ page, /** @type {string} */ what) => {
      for (const colorScheme of /** @type {('light' | 'dark')[]} */ (['light', 'dark'])) {
        await page.emulateMedia({ colorScheme });
        await refreshes(page);
        assert.deepEqual(await axe(page, { colours: colorScheme === 'dark' }), [], `${what}, ${colorScheme}`);
      }
      assert.equal(await sideways(page), false, what);
    };
    const first = await door('#questions&lang=de', wish);
    await right(first.page, 'the first page');
    await first.close();
    for (const [id, step] of /** @type {[string, number][]} */ ([
      ['late_answer', 1],
      ['late_answer', 4],
      ['falling_stack', 1],
      ['keeps_energy', 5],
    ])) {
      const { page, complaints, close } = await open(id, step, 'de', wish);
      await right(page, `${id} ${step}`);
      assert.deepEqual(complaints, []);
      await close();
    }
  });

test('on a phone question, choices and a view are seen without scrolling; answers are 44 px high', async () => {
  const { page, close } = await open('late_answer', 1, 'de', { width: 390, height: 844, hasTouch: true, isMobile: true });
  const bar = (await page.locator('.bar').boundingBox()).y;
  for (const option of await page.locator('.option').all()) {
    const box = await option.boundingBox();
    assert.ok(box.height >= 44 && box.y + box.height <= bar, JSON.stringify(box));
  }
  const view = await page.locator('canvas[data-view="1"]').boundingBox();
  assert.ok(view.y + view.height <= bar + 1 && view.height > 80, JSON.stringify({ view, bar }));
  await close();
});
