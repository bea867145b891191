// What else would need eyes: A and B for those who see colours otherwise, the back row, lanes without overlap, and pages with nothing on
// them.
import assert from 'node:assert/strict';
import { after, before } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { launch, pause, reads, runOn, scrub, settles, shown, stepOnce, until, visit } from './lib.mjs';
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

// ---- A and B ----

/** Of Machado, Oliveira and Fernandes (2009), severity 1, for linear RGB. */
const SEEN = {
  protanopia: [
    [0.152286, 1.052583, -0.204868],
    [0.114503, 0.786281, 0.099216],
    [-0.003882, -0.048116, 1.051998],
  ],
  deuteranopia: [
    [0.367322, 0.860646, -0.227968],
    [0.280085, 0.672501, 0.047413],
    [-0.01182, 0.04294, 0.968881],
  ],
  tritanopia: [
    [1.255528, -0.076749, -0.178779],
    [-0.078411, 0.930809, 0.147602],
    [0.004733, 0.691367, 0.3039],
  ],
};
const linear = (/** @type {number} */ v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
/** @param {string} hex @returns {number[]} linear RGB */
const rgbOf = (hex) => [1, 3, 5].map((at) => linear(Number.parseInt(hex.slice(at, at + 2), 16) / 255));
/** CIE L*a*b* under D65. @param {number[]} rgb linear */
function labOf([r, g, b]) {
  const f = (/** @type {number} */ t) => (t > 216 / 24389 ? Math.cbrt(t) : (24389 / 27 / 116) * t + 16 / 116);
  const [x, y, z] = [
    (0.4124564 * r + 0.3575761 * g + 0.1804375 * b) / 0.95047,
    0.2126729 * r + 0.7151522 * g + 0.072175 * b,
    (0.0193339 * r + 0.119192 * g + 0.9503041 * b) / 1.08883,
  ].map(f);
  return [116 * y - 16, 500 * (x - y), 200 * (y - z)];
}
/** Distance in CIE 1976, of which 2.3 is just seen. @param {string} one @param {string} other @param {number[][]} seen */
function apart(one, other, seen) {
  const [a, b] = [one, other].map((hex) => {
    const rgb = rgbOf(hex);
    return labOf(
      seen.map((row) =>
        Math.min(
          1,
          Math.max(
            0,
            row.reduce((sum, k, i) => sum + k * rgb[i], 0),
          ),
        ),
      ),
    );
  });
  return Math.hypot(...a.map((value, i) => value - b[i]));
}

for (const theme of ['light', 'dark', 'projector'])
  test(`A and B can be distinguished by those who see colours otherwise, and by dash, shape and letter without any: ${theme}`, async () => {
    const { page, close } = await visit(browser, `${daemon.url}?scenario=race&theme=${theme}`);
    const colours = await page.evaluate(() => globalThis.laglab.palette().players);
    const [a, b] = colours;
    for (const [name, seen] of Object.entries(SEEN)) {
      assert.ok(apart(a.fill, b.fill, seen) > 20, `${name}: fills ${apart(a.fill, b.fill, seen)}`);
      assert.ok(apart(a.text, b.text, seen) > 15, `${name}: lines ${apart(a.text, b.text, seen)}`);
    }
    assert.equal(new Set(colours.map(({ dash }) => String(dash))).size, colours.length, 'each player has a dash of its own');
    assert.notEqual(String(a.dash), String(b.dash));
    await close();
  });

test('without colour A and B have other letters in the views and other shapes in the settings', async () => {
  const { page, context, close } = await visit(browser, `${daemon.url}?scenario=race`);
  await context.newCDPSession(page).then((cdp) => cdp.send('Emulation.setEmulatedVisionDeficiency', { type: 'achromatopsia' }));
  await hear(page);
  for (const letter of 'AB')
    await until(
      () => page.evaluate((wanted) => globalThis.texts.some(({ text }) => text === wanted), letter),
      `the letter ${letter} is drawn`,
    );
  const shapes = await page
    .locator('.panel .mark')
    .evaluateAll((all) => all.map((one) => one.innerHTML.replace(/<text.*?<\/text>|<!--.*?-->/g, '').trim()));
  assert.ok(shapes.length >= 2 && shapes[0] !== shapes[1], shapes.join(' | '));
  await close();
});

// ---- the back row, the lanes ----

/** Loads the page again, and notes what is written and drawn on canvases: text with its size and box, in CSS px, and widths of lines. What
 * is copied from a canvas of its own is noted when that is made. @param {import('playwright-core').Page} page */
async function hear(page) {
  await page.addInitScript(() => {
    const pen = CanvasRenderingContext2D.prototype,
      { fillText, stroke } = pen;
    /** @type {any[]} */
    globalThis.texts = [];
    globalThis.lines = [];
    pen.fillText = function (text, x, y, ...rest) {
      const size = Number(/([\d.]+)px/.exec(this.font)?.[1]),
        { width } = this.measureText(text),
        { a: scale, b: turned, e, f } = this.getTransform(),
        ratio = this.canvas.isConnected ? this.canvas.width / Math.max(1, this.canvas.clientWidth) : devicePixelRatio;
      const left = { left: 0, start: 0, center: width / 2, right: width, end: width }[this.textAlign];
      const uplot = this.canvas.closest('.uplot') !== null;
      if (globalThis.texts.length < 20000)
        globalThis.texts.push({
          text: String(text),
          id: this.canvas.id || this.canvas.dataset.view || (uplot ? 'chart' : ''),
          size: uplot ? size / ratio : size * (turned === 0 ? scale / ratio : 1),
          x: (x * scale + e) / ratio - left,
          y: (y * scale + f) / ratio,
          width,
          at: performance.now(),
        });
      return fillText.call(this, text, x, y, ...rest);
    };
    pen.stroke = function (...rest) {
      if (globalThis.lines.length < 20000) globalThis.lines.push({ width: this.lineWidth, colour: String(this.strokeStyle) });
      return stroke.apply(this, rest);
    };
  });
  await page.reload();
  await shown(page);
}

for (const at of [
  '?scenario=race',
  '?scenario=motion/two_orbits',
  '?scenario=rigid/collapsing_stack',
  '?scenario=fluid/two_discs',
  '?scenario=rifle',
])
  sweep(/race|motion/.test(at))(
    `with the projector’s colours at 1024 x 768 no text of a drawing is below 14 px, and curves are 3 px: ${at}`,
    async () => {
      const { page, close } = await visit(browser, `${daemon.url}${at}&theme=projector`, { width: 1024, height: 768 });
      await hear(page);
      await runOn(page, 1.2);
      const { texts, lines, colours } = await page.evaluate(() => ({
        texts: globalThis.texts,
        lines: globalThis.lines,
        colours: globalThis.laglab.palette(),
      }));
      assert.ok(texts.length > 10, `${texts.length} texts`);
      const small = texts.filter(({ size }) => size < 13.99).map(({ id, text, size }) => `${id}: “${text}” of ${size} px`);
      assert.deepEqual([...new Set(small)].slice(0, 10), []);
      assert.ok(colours.line >= 3, `lines of ${colours.line} px`);
      const thick = lines.filter(({ colour, width }) => colour === colours.players[0].text && width >= 3 - 0.51);
      if (at.includes('motion')) assert.ok(thick.length > 0, 'curves of A');
      await close();
    },
  );

test('texts of the lanes do not overlap at 30 updates a second, at any size', async () => {
  for (const [width, height] of [
    [1366, 768],
    [1920, 1080],
    [390, 844],
  ]) {
    const { page, close } = await visit(browser, `${daemon.url}?scenario=race&set=server.update_hz:30`, { width, height });
    await hear(page);
    if (width < 700) await page.locator('.tabs button', { hasText: 'Messages' }).click();
    await pause(page);
    await scrub(page, 8);
    await settles(() => page.evaluate(() => globalThis.laglab().frame.time_s), 8);
    await page.evaluate(() => {
      globalThis.texts.length = 0;
    });
    await stepOnce(page, 'forward');
    const drawn = await until(async () => {
      const all = await page.evaluate(() => globalThis.texts);
      const of = all.filter(({ id }) => /lane/.test(id));
      return of.length > 2 && of;
    }, 'the lanes are drawn');
    const frame = drawn.filter(({ at }) => at > drawn.at(-1).at - 8);
    const overlap = frame.flatMap((one, i) =>
      frame
        .slice(i + 1)
        .filter((two) => two.text !== one.text || Math.abs(two.x - one.x) > 0.5)
        .filter(
          (two) =>
            Math.min(one.x + one.width, two.x + two.width) - Math.max(one.x, two.x) > 1 &&
            Math.abs(one.y - two.y) < 0.8 * Math.min(one.size, two.size),
        )
        .map((two) => `${width}: “${one.text}” and “${two.text}”`),
    );
    assert.deepEqual([...new Set(overlap)], []);
    await close();
  }
});

// ---- nothing to show ----

test('what is empty, being read or failed says so in words', async () => {
  const { page, close } = await visit(browser, daemon.url, { wait: false });
  await page.locator('.card').first().waitFor();
  await page.getByRole('button', { name: 'Find a scene' }).click();
  await page.getByRole('searchbox', { name: 'Search' }).or(page.getByLabel('Search')).fill('qqqqqq');
  await reads(page.locator('main.door'), /[Nn]othing|[Nn]o (?:question|lesson|scenario)/);
  await close();

  const unknown = await visit(browser, `${daemon.url}?scenario=there/is_none`);
  await reads(unknown.page.locator('.note').first(), /there\/is_none/);
  assert.ok((await unknown.page.locator('canvas').count()) > 0, 'and something is shown all the same');
  await unknown.close();

  const experiments = await visit(browser, `${daemon.url}#experiments`, { wait: false });
  await reads(experiments.page.locator('main h1'), /^Prediction cures your own car, not the others\.$/);
  await experiments.close();
});

test('a page whose parts do not come is not white: its name, and a way to try again', async () => {
  const context = await browser.newContext();
  const page = await context.newPage();
  await page.route(/\/js\/chunk-\w+\.js/, (route) => route.abort());
  await page.goto(`${daemon.url}?scenario=race`, { waitUntil: 'domcontentloaded' });
  await reads(page.locator('.reading'), /laglab/);
  await page.evaluate(() => {
    for (const one of document.getAnimations()) one.finish();
  });
  await page.unroute(/\/js\/chunk-\w+\.js/);
  await page.getByRole('link', { name: 'Reload' }).click();
  await page.locator('[data-path]').first().waitFor({ state: 'attached' });
  await context.close();
});
