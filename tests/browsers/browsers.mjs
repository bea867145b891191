// Chromium, Firefox and WebKit behind one face, so that all make the same journeys.
import { existsSync } from 'node:fs';
import { firefox } from 'playwright-core';
import { launch } from '../page/lib.mjs';

export { launchWebKit, missing as missingWebKit } from './webdriver.mjs';

/**
 * A page of its own in a browser: functions run in the page, clicks and keys are a person's.
 * @typedef {{complaints: () => Promise<string[]>, evaluate: (what: Function | string, arg?: any) =>
 * Promise<any>, click: (find: Function, arg?: any) => Promise<void>, press: (key: string) => Promise<unknown>, down: (key: string) =>
 * Promise<unknown>, up: (key: string) => Promise<unknown>, screenshot: () => Promise<Buffer>, close: () => Promise<void>,
 * finger?: (selector: string) => Promise<() => Promise<void>>, listen?: () => Promise<unknown>}} Visitor finger: on a screen for it,
 * touches an element until it is lifted; listen: where the page itself notes complaints, after it was loaded again
 * @typedef {{name: string, visit: (url: string, size: {width: number, height: number}) => Promise<Visitor>,
 * close: () => Promise<void>}} Browser
 */

const FIREFOX = '/usr/bin/firefox-esr';

/** What is not installed; empty where all is there. @returns {string} */
export const missingFirefox = () => (existsSync(FIREFOX) ? '' : FIREFOX);

/** Debian's Firefox, by WebDriver BiDi. */
export const launchFirefox = async () => steered('Firefox', await firefox.launch({ channel: 'moz-firefox', executablePath: FIREFOX }));
/** Debian's Chromium as people have it: the tests of the page take its engine alone. */
export const launchChromium = async () => steered('Chromium', await launch({ whole: true }));

/** @param {string} name @param {import('playwright-core').Browser} browser @returns {Browser} */
function steered(name, browser) {
  return {
    name,
    visit: async (url, size) => {
      const context = await browser.newContext({ viewport: size });
      const page = await context.newPage();
      /** @type {string[]} */
      const complaints = [];
      page.on('console', (message) => {
        if (['error', 'warning'].includes(message.type())) complaints.push(`console: ${message.text()}`);
      });
      page.on('pageerror', (error) => complaints.push(`error: ${error.message}`));
      await page.goto(url);
      return faceOf(page, complaints, () => context.close());
    },
    close: () => browser.close(),
  };
}

/** @param {import('playwright-core').Page} page @param {string[]} complaints @param {() => Promise<void>} close @returns {Visitor} */
export function faceOf(page, complaints, close) {
  const element = async (/** @type {Function} */ find, /** @type {any} */ arg) => {
    const handle = await page.evaluateHandle(/** @type {any} */ (find), arg ?? null);
    const found = handle.asElement();
    if (!found) throw new Error(`nothing to click: ${find} ${arg ?? ''}`);
    return found;
  };
  return {
    complaints: async () => complaints,
    evaluate: (what, arg) => page.evaluate(`(${what})(${JSON.stringify(arg ?? null)})`),
    click: async (find, arg) => (await element(find, arg)).click(),
    press: (key) => page.keyboard.press(key),
    down: (key) => page.keyboard.down(key),
    up: (key) => page.keyboard.up(key),
    screenshot: () => page.screenshot({ caret: 'initial' }) /* without a style that the page's policy would refuse */,
    close,
  };
}
