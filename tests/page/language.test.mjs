// The page in another language: how it is chosen, that its texts fit, and that what is read aloud says in which language it is.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, before } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { englishIn, hearCanvases, isGerman, textsOn, words } from './german.mjs';
import { api, axe, button, dialogOf, launch, reads, refreshes, runOn, settles, shown, until, visit } from './lib.mjs';
import { sweep, test } from './tiers.mjs';

const SIZES = [
  { width: 1366, height: 768 },
  { width: 390, height: 844 },
];
const LABS = [
  { name: 'race', at: '#race' },
  { name: 'step', at: '#step' },
  { name: 'collide', at: '#collide' },
  { name: 'fluid', at: '#fluid' },
];

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

/** @param {import('playwright-core').Page} page */
const languageOf = (page) => page.evaluate(() => document.documentElement.lang);

/** Elements whose own text is wider than they are, and is not to be scrolled to; a name of the library may be cut, as its list has it.
 * @param {import('playwright-core').Page} page @param {string} [root] @returns {Promise<string[]>} */
const clipped = (page, root = 'body') =>
  page.evaluate((within) => {
    const found = [];
    for (const element of document.querySelector(within)?.querySelectorAll('*') ?? []) {
      if (!(element instanceof HTMLElement) || element.closest('.unseen, [hidden], svg') || !element.checkVisibility()) continue;
      if (![...element.childNodes].some((node) => node.nodeType === Node.TEXT_NODE && node.textContent?.trim())) continue;
      const text = element.textContent?.trim().slice(0, 60);
      if (getComputedStyle(element).clipPath !== 'none') continue; /* for the ear alone */
      const cuts = getComputedStyle(element).overflowX !== 'visible' || element.matches('button');
      if (cuts && element.clientWidth > 0 && element.scrollWidth > element.clientWidth + 1)
        found.push(`${element.tagName} “${text}” is cut`);
      const box = element.getBoundingClientRect();
      if (box.width === 0) continue;
      for (let at = element.parentElement; at; at = at.parentElement) {
        const { overflowX } = getComputedStyle(at);
        if (overflowX === 'visible') continue;
        const edge = at.getBoundingClientRect();
        if (overflowX === 'auto' || overflowX === 'scroll') {
          /* what scrolls sideways is meant to: the row of labs, wide tables */
          if (at.matches('nav, .wide-table, .phases-row')) break;
        }
        if (box.right > edge.right + 1 || box.left < edge.left - 1)
          found.push(`${element.tagName} “${text}” leaves ${at.className || at.tagName}`);
        break;
      }
    }
    return found;
  }, root);

test('the language is that of the address, else the chosen one, else the browser’s, else English', async () => {
  for (const [query, locale, expected] of [
    ['', 'de-AT', 'de'],
    ['', 'fr-FR', 'en'],
    ['?lang=en', 'de-DE', 'en'],
    ['?lang=de', 'en-US', 'de'],
    ['?lang=xx', 'de-DE', 'de'],
  ]) {
    const { page, close } = await visit(browser, `${daemon.url}${query}#race`, { locale });
    assert.equal(await languageOf(page), expected, `${query} ${locale}`);
    const { words: own } = { words: words[expected].page };
    await button(page, own['shell.pause']).or(button(page, own['shell.replay'])).waitFor();
    await close();
  }
});

test('one language is read, and of a lab only what it shows', async () => {
  for (const [at, parts] of /** @type {[string, string[]][]} */ ([
    ['#race', ['first']],
    ['#step', ['first', 'motion']],
  ])) {
    const { page, requests, close } = await visit(browser, `${daemon.url}?lang=de${at}`);
    const paths = () => requests.map((request) => new URL(request.url()).pathname.replace(/^\/[0-9a-f]{16}/, '')),
      read = () => paths().filter((name) => name.startsWith('/words/'));
    await settles(
      async () => [...new Set(read())].sort(),
      [...parts.map((part) => `/words/de/${part}.json`), '/words/messages/de.json', '/words/scenarios/de.json'],
    );
    await refreshes(page); /* and nothing more */
    assert.equal(new Set(read()).size, parts.length + 2);
    await close();
  }
});

test('a choice in the head of any view is shown at once, stays in the browser, and moves an address that names a language', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}?scenario=rigid/pyramid`);
  const choose = (/** @type {string} */ name) => page.locator(`.languages [lang="${name}"]`).click();
  await choose('de');
  await page.locator('.help', { hasText: '?' }).and(page.getByLabel(words.de.page['shell.help'])).waitFor();
  assert.equal(await languageOf(page), 'de');
  await page.locator('.methods label span', { hasText: words.de.inputs.rigid['solver.bounding_volume'].label }).first().waitFor();
  await page.reload();
  await shown(page);
  assert.equal(await languageOf(page), 'de');
  await page.goto(`${daemon.url}?scenario=rigid/pyramid&lang=en`);
  await shown(page);
  assert.equal(await languageOf(page), 'en');
  await choose('de');
  await page.waitForFunction(() => location.search.includes('lang=de'));
  for (const at of ['', '#experiments', '#tradeoff', '#lesson=late_answer', '?scenario=race', '?scenario=cannon']) {
    await page.goto(`${daemon.url}${at}`);
    for (const name of ['en', 'de']) {
      await choose(name);
      await settles(() => languageOf(page), name, `${name} at ${at}`);
    }
  }
  assert.deepEqual(complaints, []);
  await close();
});

test('parameters have their names, units and one line of help from the words', async () => {
  for (const language of ['en', 'de']) {
    const { page, close } = await visit(browser, `${daemon.url}?lang=${language}#step`);
    const { inputs, units } = words[language];
    const row = page.locator('label.field', { has: page.locator('[data-path="methods.0.dt_s"]') }).first();
    await row.waitFor();
    await reads(row, new RegExp(`${inputs.motion['methods.*.dt_s'].label}\\s*${units.s}`));
    await settles(() => row.getAttribute('title'), inputs.motion['methods.*.dt_s'].tip);
    await close();
  }
});

test('scenarios of the library have their titles and texts in German, and the search finds both', async () => {
  const own = JSON.parse(readFileSync(new URL('../../www/words/scenarios/de.json', import.meta.url), 'utf8')),
    { scenarios } = (await api(daemon.url, 'scenarios')).body;
  assert.deepEqual(Object.keys(own).sort(), scenarios.map((/** @type {{id: string}} */ row) => row.id).sort());
  for (const { id, title } of scenarios) {
    const given = JSON.parse(readFileSync(new URL(`../../scenarios/${id}.json`, import.meta.url), 'utf8'));
    assert.ok(own[id].title, id);
    assert.equal(typeof own[id].text, typeof given.text, `${id}: text`);
    const numbers = (/** @type {string} */ text) => (text.match(/\d+/g) ?? []).sort().join(' ');
    assert.equal(numbers(own[id].text ?? ''), numbers(given.text ?? ''), `${id}: numbers of the text of “${title}”`);
  }
  const { page, close } = await visit(browser, `${daemon.url}?lang=de&scenario=rigid/pyramid`);
  await settles(() => page.locator('.about h2').first().innerText(), own['rigid/pyramid'].title);
  await settles(() => page.locator('.about p').first().innerText(), own['rigid/pyramid'].text);
  await settles(() => page.locator('#scenario').innerText(), own['rigid/pyramid'].title);
  await page.goto(`${daemon.url}?lang=de`);
  await page.getByRole('button', { name: 'Eine Szene finden' }).click();
  for (const words of [own['rigid/pyramid'].title, scenarios.find((/** @type {{id: string}} */ row) => row.id === 'rigid/pyramid').title]) {
    await page.locator('.seek input').fill(words);
    await page.locator('.scenes a').filter({ hasText: own['rigid/pyramid'].title }).first().waitFor();
  }
  await close();
});

test('numbers have the language’s decimal point', async () => {
  const { page, close } = await visit(browser, `${daemon.url}?lang=de#race`);
  await reads(page.locator('#clock'), /^\d+,\d\d s$/);
  await close();
});

for (const { width, height } of SIZES)
  for (const { name, at } of LABS)
    sweep(width < 400 || name === 'race')(`German fits: ${name} at ${width}`, async () => {
      const { page, complaints, close } = await visit(browser, `${daemon.url}?lang=de${at}`, { width, height });
      await refreshes(page);
      assert.equal(await page.evaluate(() => document.documentElement.scrollWidth > innerWidth), false);
      assert.deepEqual(await clipped(page), []);
      for (const kind of ['shell.help', 'shell.share']) {
        await button(page, words.de.page[kind]).first().click();
        await dialogOf(page);
        assert.deepEqual(await clipped(page, 'dialog[open]'), [], kind);
        await page.keyboard.press('Escape');
        await page.locator('dialog').waitFor({ state: 'hidden' });
      }
      assert.deepEqual(complaints, []);
      await close();
    });

for (const { width, height } of SIZES)
  sweep(width < 400)(`German fits: questions at ${width}`, async () => {
    const { page, close } = await visit(browser, `${daemon.url}?lang=de`, { width, height, wait: false });
    await page.getByRole('heading', { name: words.de.lesson['door.title'] }).waitFor();
    await page.waitForSelector('.card');
    assert.deepEqual(await clipped(page), []);
    await close();
  });

test('the class in German: the code, joining, a vote', async () => {
  const own = words.de.class,
    { page, complaints, close } = await visit(browser, `${daemon.url}?lang=de#race`);
  await button(page, words.de.page['shell.class']).click();
  await button(page, own['class.next.predict']).waitFor();
  assert.deepEqual(await clipped(page, '#class'), []);
  assert.deepEqual(await axe(page), []);
  const code = (await reads(page.locator('.joining .letters'), /\w/)).replace(/\s/g, '');
  const member = await visit(browser, `${daemon.url}?lang=de#class=${code}`, { width: 390, height: 844, wait: false });
  await button(member.page, new RegExp(own['class.watch'])).click();
  await button(page, own['class.next.predict']).click();
  await member.page.locator('.ask').waitFor();
  assert.deepEqual(await clipped(member.page, '#class'), []);
  assert.deepEqual(await axe(member.page), []);
  assert.deepEqual(complaints, []);
  await member.close();
  await close();
});

for (const { name, at } of LABS)
  sweep(name === 'race')(`axe finds nothing in German: ${name}`, async () => {
    const { page, close } = await visit(browser, `${daemon.url}?lang=de${at}`);
    await refreshes(page);
    assert.deepEqual(await axe(page), []);
    await close();
  });

// ---- nothing is left in English ----

/** Texts that have one language: of the library, and notes of the daemon. @type {Set<string>} */
const given = new Set();
/** @param {any} node */
function take(node) {
  if (typeof node === 'string') given.add(node.replace(/\s+/g, ' ').trim());
  else if (node && typeof node === 'object') for (const one of Object.values(node)) take(one);
}

/** All that a page shows is looked through at each step. @param {string} at @param {{width: number, height: number}} size
 * @param {(page: import('playwright-core').Page, look: (what: string) => Promise<void>) => Promise<void>} steps */
async function walk(at, size, steps) {
  if (given.size === 0) {
    take((await api(daemon.url, 'scenarios')).body);
    take((await api(daemon.url, 'experiments/library')).body);
  }
  const { page, close } = await visit(browser, `${daemon.url}?lang=de${at}`, { ...size, scripts: [hearCanvases], wait: false });
  /** @type {string[]} */
  const findings = [];
  let texts = 0;
  const look = async (/** @type {string} */ what) => {
    await refreshes(page, 12);
    const now = await page.evaluate(() => {
      const { params, layout } = globalThis.laglab();
      return { params, layout };
    });
    for (const text of [
      now.params?.title,
      now.params?.text,
      now.params?.paper,
      ...(await page.locator('.about [role="note"]').allInnerTexts()),
    ])
      if (text) take(text);
    for (const text of await textsOn(page)) {
      if (isGerman(text)) texts++;
      const found = englishIn(text, given);
      if (found !== '') findings.push(`${what}: ${found}`);
    }
  };
  await steps(page, look);
  assert.ok(texts > 20, `${texts} texts in German`);
  assert.deepEqual([...new Set(findings)], []);
  await close();
}

const WIDE = { width: 1366, height: 768 },
  PHONE = { width: 390, height: 844 };
const CLOSER = '.lookrow select';
/** @param {import('playwright-core').Page} page @param {string} selector */
async function dialogBy(page, selector) {
  await page.locator(selector).first().click();
  await page.locator('dialog[open] .body > *').first().waitFor();
}

for (const at of ['#race', '#step', '#collide', '#fluid', '#experiments'])
  sweep(at === '#race')(`the search for English finds it: ${at}`, async () => {
    const { page, close } = await visit(browser, `${daemon.url}?lang=en${at}`, { wait: at !== '#experiments' });
    await page.locator('main *').first().waitFor();
    if (at === '#experiments') await page.locator('#run:not([disabled])').waitFor();
    const found = (await textsOn(page)).filter((text) => englishIn(text, new Set()) !== '');
    assert.ok(found.length > 25, `${at}: ${found}`);
    await close();
  });

test('the search for English knows words from sentences', () => {
  assert.equal(englishIn('Puffer', new Set()), '');
  assert.match(englishIn('Input 12 of A', new Set()), /English/);
  assert.match(englishIn('a key of the page', new Set()), /has “of”/);
});

test('German: a race, its inspectors, dialogs and keys', () =>
  walk('#race', WIDE, async (page, look) => {
    await shown(page);
    await look('race');
    await page.waitForSelector(`${CLOSER} option[value="inputs"]`, { state: 'attached' });
    for (const name of ['buffers', 'inputs', 'messages']) {
      await page.locator(CLOSER).selectOption(name);
      await look(name);
    }
    await page.focus('[data-arrows]');
    await page.keyboard.press('ArrowLeft');
    await look('an input');
    for (const [what, selector] of [
      ['player', '.gutter fieldset[data-player="0"] button.quiet'],
      ['server', '.gutter fieldset.server button.quiet'],
      ['table', '#error-chart ~ .key button.small:not(take-away *)'],
      ['buffers', '#buffer-chart ~ .key button.small:not(take-away *)'],
    ]) {
      await dialogBy(page, selector ?? '');
      await look(`dialog ${what}`);
      await page.keyboard.press('Escape');
    }
    for (const key of ['shell.help', 'shell.share']) {
      await button(page, words.de.page[key]).first().click();
      await page.locator('dialog[open] .body > *').first().waitFor();
      await look(key);
      await page.keyboard.press('Escape');
    }
    await page.locator('#follow').click();
    await page.locator('#packet-title').waitFor();
    await look('packet');
  }));

test('German: two runs compared, and presenting', () =>
  walk('#race', WIDE, async (page, look) => {
    await shown(page);
    await page.locator('.side button.compare').click();
    await page.locator('#compare-sentence').filter({ hasText: /\S/ }).waitFor();
    await look('compare');
    await page.locator('#compare-close').click();
    await page.locator('#present').click();
    await page.locator('.foot').waitFor();
    await look('present');
  }));

for (const [name, query, one = false] of /** @type {[string, string, boolean?][]} */ ([
  ['cannons driven by a person', '&scenario=cannon&set=players.0.control:person'],
  ['a shooter', '&scenario=rifle', true],
  ['crates driven by a person', '&scenario=crates&set=players.0.control:person'],
  ['eight players', '&scenario=eight', true],
  ['desync', '&scenario=desync_float'],
  ['lockstep', '&scenario=paper/fig11'],
  ['a boat', '&scenario=sea_watched'],
]))
  sweep(one)(`German: ${name}`, () =>
    walk(query, WIDE, async (page, look) => {
      await shown(page);
      await runOn(page, 1);
      await page.waitForSelector(`${CLOSER} option:nth-child(2)`, { state: 'attached' });
      await look('views');
      for (const value of await page.locator(`${CLOSER} option`).evaluateAll((all) => all.map((one) => /** @type {any} */ (one).value))) {
        await page.locator(CLOSER).selectOption(value);
        await look(value);
      }
    }),
  );

test('German: a race on a phone', () =>
  walk('#race', PHONE, async (page, look) => {
    await shown(page);
    const tabs = page.locator('nav.tabs button');
    for (let i = 0; i < (await tabs.count()); i++) {
      await tabs.nth(i).click();
      await look(`tab ${i}`);
    }
  }));

for (const at of ['#step', '#collide', '#fluid'])
  test(`German: ${at}`, () =>
    walk(at, WIDE, async (page, look) => {
      await shown(page);
      await page.locator('details').evaluateAll((all) => {
        for (const one of all) /** @type {HTMLDetailsElement} */ (one).open = true;
      });
      await runOn(page, 1);
      await look(at);
    }));

test('German: experiments, from the form to the results', () =>
  walk('#experiments', WIDE, async (page, look) => {
    await page.locator('#run:not([disabled])').waitFor();
    await look('form');
    for (const name of ['settings', 'table', 'files', 'request']) await page.locator(`[data-drawer="${name}"]`).click();
    await page.locator('#until').check();
    await page.selectOption('#sampling', 'saltelli');
    await page.locator('#add-axis').click();
    await look('all of the form');
    await page.locator('#until').uncheck();
    await page.locator('#repeats').fill('2');
    await page.selectOption('#sampling', 'none');
    await page.locator('[data-axis-field] button.small').nth(2).click();
    await refreshes(page, 30);
    await page.locator('#run:not([disabled])').click();
    await page.locator('[data-state="done"]').waitFor();
    await page.locator('tr[data-point="2"] th').click();
    await look('results');
    for (const id of ['motion/pendulum', 'rigid/pyramid', 'fluid/taylor_green']) {
      await page.selectOption('#of', id);
      const heard = async () => JSON.stringify(await page.locator('.curl, textarea').first().inputValue()).includes(id);
      await until(heard, `a form of ${id}`);
      await refreshes(page, 30);
      await look(id);
    }
  }));

test('what the daemon says is German: a refused value of an address and of a field, texts of its tables', async () => {
  const german = { locale: 'de-DE' };
  const race = await visit(browser, `${daemon.url}?scenario=race&set=players.0.lag_ms:5000`, german);
  await reads(race.page.locator('.note').first(), /A: Lag je Weg: muss 0 bis 1000 ms .*; angegeben .* 5000/);
  await race.close();
  const step = await visit(browser, `${daemon.url}?scenario=motion/pendulum`, german);
  await reads(step.page.locator('.facts').first(), /^Ein Pendel mit großem Ausschlag\.$/);
  await step.close();
  const reversed = await visit(browser, `${daemon.url}?scenario=motion/accumulator`, german);
  await reversed.page.locator('[data-path="reverse"]').click();
  await reads(reversed.page.locator('.note').first(), /können nicht rückwärts laufen: Zeitumkehr braucht feste Schritte/);
  await reversed.close();
  for (const [at, text] of [
    ['?scenario=rigid/pyramid', /Teilschritte mit weichen Kontakten/],
    ['?scenario=fluid/cylinder', /Ein Tunnel mit einem Zylinder/],
  ]) {
    const { page, close } = await visit(browser, daemon.url + at, german);
    await reads(() => page.locator('.side').textContent(), /** @type {RegExp} */ (text));
    await close();
  }
  const paper = await visit(browser, `${daemon.url}?scenario=paper/fig12`, german);
  await reads(paper.page.locator('.about h2'), /^Abbildung 12: /);
  await paper.close();
});
