// Controls of every lab, pressed in an order that a seed chooses: nothing breaks.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { startDaemon } from '../lib/daemon.mjs';
import { random } from '../lib/draws.mjs';
import { axe, launch, refreshes, until, visit } from './lib.mjs';

const SEED = Number(process.env.LAGLAB_PAGE_SEED ?? 20261124);
const ACTIONS = 80;

/** @type {Awaited<ReturnType<typeof startDaemon>>} */ let daemon;
/** @type {import('playwright-core').Browser} */ let browser;
before(async () => {
  [daemon, browser] = await Promise.all([startDaemon(), launch()]);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

/** Acts on one of the controls that can be seen; its description. @param {[number, number]} at which, and with what value: in [0, 1) */
function act([which, value]) {
  const seen = [...document.querySelectorAll('button, select, input, summary, [tabindex="0"]')].filter(
    (one) =>
      one.checkVisibility() &&
      !(/** @type {HTMLButtonElement} */ (one).disabled) &&
      !one.closest('take-away') &&
      (document.querySelector('dialog[open]')?.contains(one) ?? true),
  );
  const one = /** @type {HTMLElement} */ (seen[Math.floor(which * seen.length)]);
  if (!one) return 'nothing to press';
  const says = `${one.tagName} ${one.id || one.getAttribute('aria-label') || one.textContent?.trim().slice(0, 40)}`;
  if (one instanceof HTMLSelectElement) {
    one.selectedIndex = Math.floor(value * one.options.length);
    one.dispatchEvent(new Event('change', { bubbles: true }));
  } else if (one instanceof HTMLInputElement && ['range', 'number', 'text'].includes(one.type)) {
    const low = Number(one.min || -10),
      high = Number(one.max || 1000);
    one.value = value < 0.1 ? '' : String(low + (high - low) * (1.2 * value - 0.1));
    one.dispatchEvent(new Event('input', { bubbles: true }));
    one.dispatchEvent(new Event('change', { bubbles: true }));
  } else if (one.tabIndex >= 0 && !(one instanceof HTMLButtonElement || one instanceof HTMLInputElement) && one.tagName !== 'SUMMARY') {
    one.focus();
    const codes = ['ArrowLeft', 'ArrowRight', 'KeyA', 'KeyD', 'Space', 'Escape', 'KeyV', 'Enter'];
    const code = codes[Math.floor(value * codes.length)];
    one.dispatchEvent(new KeyboardEvent('keydown', { code, key: code, bubbles: true }));
    one.dispatchEvent(new KeyboardEvent('keyup', { code, key: code, bubbles: true }));
  } else if (/** @type {HTMLButtonElement} */ (one).form?.checkValidity() ?? true) one.click();
  return says;
}

for (const [i, [name, query, size]] of /** @type {[string, string, any][]} */ ([
  ['race', '#race', {}],
  ['race on a phone', '#race', { width: 390, height: 844 }],
  ['cannon', '#cannon', {}],
  ['shooter', '#shoot', {}],
  ['crates', '#crates', {}],
  ['methods', '#step', {}],
  ['rigid bodies', '#collide', {}],
  ['fluid on a phone', '#fluid', { width: 390, height: 844 }],
  ['experiments', '#experiments', {}],
  ['a lesson', '#lesson=late_answer', {}],
]).entries()) {
  test(`${name}: ${ACTIONS} controls at random break nothing`, async () => {
    const { page, complaints, close } = await visit(browser, daemon.url + query, { ...size, wait: false });
    await until(() => page.evaluate(() => document.querySelectorAll('main button, main select').length > 2), 'controls');
    const next = random(SEED + i),
      done = /** @type {string[]} */ ([]);
    page.on('response', async (answer) => {
      if (answer.status() < 400) return;
      const text = await answer.text().catch(() => '');
      done.push(`${answer.status()} ${answer.request().method()} ${answer.url()} ${text.slice(0, 200)}`);
    });
    page.on('console', (message) => done.push(message.text()));
    for (let n = 0; n < ACTIONS; n++) {
      done.push(await page.evaluate(act, /** @type {[number, number]} */ ([next(), next()])));
      await refreshes(page, 2);
    }
    const said = complaints.filter(
      (text) => !/(status of|response code:) (400|404|409|413|422|429)/.test(text),
    ); /* values out of their range, and what was closed since */
    assert.deepEqual(said, [], done.join('\n'));
    await page.keyboard.press('Escape');
    await until(() => page.evaluate(() => document.body.innerText.trim().length > 100), 'a page with words');
    assert.deepEqual(await axe(page), [], done.join('\n'));
    await close();
  });
}
