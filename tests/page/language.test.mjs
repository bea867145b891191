// The page in another language: how it is chosen, that its texts fit, and that what is read aloud says in which language it is.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { startDaemon } from '../lib/daemon.mjs';
import { axe, button, dialogOf, launch, reads, settles, shown, visit } from './lib.mjs';

const WWW = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../../www');
/** @type {Record<string, any>} */
const words = Object.fromEntries(
  ['en', 'de'].map((name) => [name, JSON.parse(readFileSync(path.join(WWW, `words/${name}.json`), 'utf8'))]),
);
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
  const { page, requests, close } = await visit(browser, `${daemon.url}?lang=de#race`);
  await page.waitForSelector('#error-chart canvas');
  const read = requests.map((request) => new URL(request.url()).pathname).filter((at) => at.startsWith('/words/'));
  assert.deepEqual(read, ['/words/de/page.json']);
  await page.goto(`${daemon.url}?lang=de#step`);
  await page.reload();
  await shown(page);
  const more = requests.map((request) => new URL(request.url()).pathname).filter((at) => at.startsWith('/words/'));
  assert.deepEqual([...new Set(more)].sort(), ['/words/de/motion.json', '/words/de/page.json']);
  await close();
});

test('a choice in the help is shown at once, stays in the browser, and moves an address that names a language', async () => {
  const { page, complaints, close } = await visit(browser, `${daemon.url}?scenario=rigid/pyramid`);
  await button(page, 'Help').click();
  await page.locator('#language').selectOption('de');
  await page.getByRole('heading', { name: words.de.page['shell.help'] }).waitFor();
  assert.equal(await languageOf(page), 'de');
  await page.keyboard.press('Escape');
  await page.locator('.methods label span', { hasText: words.de.inputs.rigid['solver.bounding_volume'].label }).first().waitFor();
  await page.reload();
  await shown(page);
  assert.equal(await languageOf(page), 'de');
  await page.goto(`${daemon.url}?scenario=rigid/pyramid&lang=en`);
  await shown(page);
  assert.equal(await languageOf(page), 'en');
  await button(page, 'Help').click();
  await page.locator('#language').selectOption('de');
  await page.waitForFunction(() => location.search.includes('lang=de'));
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

test('numbers have the language’s decimal point', async () => {
  const { page, close } = await visit(browser, `${daemon.url}?lang=de#race`);
  await reads(page.locator('#clock'), /^\d+,\d\d s$/);
  await close();
});

for (const { width, height } of SIZES)
  for (const { name, at } of LABS)
    test(`German fits: ${name} at ${width}`, async () => {
      const { page, complaints, close } = await visit(browser, `${daemon.url}?lang=de${at}`, { width, height });
      await page.waitForTimeout(700);
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
  test(`German fits: questions at ${width}`, async () => {
    const { page, close } = await visit(browser, `${daemon.url}?lang=de`, { width, height, wait: false });
    await page.getByRole('heading', { name: words.de.lesson['door.title'] }).waitFor();
    await page.waitForSelector('.card');
    assert.deepEqual(await clipped(page), []);
    await close();
  });

test('the class in German: the lobby, joining, a vote', async () => {
  const own = words.de.class,
    { page, complaints, close } = await visit(browser, `${daemon.url}?lang=de#race`);
  await button(page, words.de.page['shell.class']).click();
  await page.locator('.lobby').waitFor();
  await button(page, own['class.do.predict']).waitFor();
  assert.deepEqual(await clipped(page, '.lobby'), []);
  assert.deepEqual(await axe(page), []);
  const code = (await reads(page.locator('.lobby .letters'), /\w/)).replace(/\s/g, '');
  const member = await visit(browser, `${daemon.url}?lang=de#class=${code}`, { width: 390, height: 844, wait: false });
  await button(member.page, new RegExp(own['class.watch'])).click();
  await button(page, own['class.do.predict']).click();
  await member.page.locator('.ask').waitFor();
  assert.deepEqual(await clipped(member.page, '#class'), []);
  assert.deepEqual(await axe(member.page), []);
  assert.deepEqual(complaints, []);
  await member.close();
  await close();
});

for (const { name, at } of LABS)
  test(`axe finds nothing in German: ${name}`, async () => {
    const { page, close } = await visit(browser, `${daemon.url}?lang=de${at}`);
    await page.waitForTimeout(500);
    assert.deepEqual(await axe(page), []);
    await close();
  });
