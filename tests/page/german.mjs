// Which texts of a page in German are English: those of www/words whose German differs, and sentences with an English word.
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

const WWW = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../../www');
/** @type {Record<string, any>} */
export const words = Object.fromEntries(
  ['en', 'de'].map((name) => [name, JSON.parse(readFileSync(path.join(WWW, `words/${name}.json`), 'utf8'))]),
);

/** Every text below a node by its place: plural forms, labels and tips each. @param {any} node @param {string} at
 * @param {Map<string, string>} [found] */
function textsOf(node, at, found = new Map()) {
  if (typeof node === 'string') found.set(at, node);
  else for (const [key, value] of Object.entries(node)) textsOf(value, `${at}/${key}`, found);
  return found;
}
const english = textsOf(words.en, ''),
  german = textsOf(words.de, '');

const quoted = (/** @type {string} */ text) => text.replace(/[.*+?^${}()|[\]\\]/g, '\\$&');
const HOLE = /\{[^{}]*\}/;
const plain = (/** @type {string} */ text) =>
  text
    .replace(/[\u00ad\u200b]/g, '')
    .replace(/\s+/g, ' ')
    .trim();
/** With any value in its places. @param {string} text */
const pattern = (text) => new RegExp(`^${plain(text).split(HOLE).map(quoted).join('[^·]+?')}$`);

const same = new Set([...german.values()].map(plain));
const exact = new Map(
  [...english].filter(([key, text]) => text !== german.get(key) && !HOLE.test(text)).map(([key, text]) => [plain(text), key]),
);
const filled = [...english]
  .filter(([key, text]) => HOLE.test(text) && text !== german.get(key) && /\p{L}{3,}/u.test(text.split(HOLE).join(' ')))
  .map(([key, text]) => ({ key, english: pattern(text) }));
const filledGerman = [...german.values()].filter((text) => HOLE.test(text)).map(pattern);

/** Words that no German sentence has. */
const ENGLISH = /\b(?:the|and|with|from|of|which|that|this|their|than|has|have|are|were|not|when|where|each|other)\b/i;

/** @param {string} text @param {Set<string>} given texts of scenarios and of the daemon, which have one language
 * @returns {string} why it is English; empty: it is not */
export function englishIn(text, given) {
  const shown = plain(text);
  if (shown === '' || given.has(shown) || [...given].some((one) => one.length > 8 && shown.includes(one))) return '';
  if (same.has(shown)) return '';
  const key = exact.get(shown);
  if (key !== undefined) return `“${shown}” is the English of ${key}`;
  if (filledGerman.some((one) => one.test(shown) && !one.test('x y z'))) return '';
  const found = filled.find((one) => one.english.test(shown));
  if (found) return `“${shown}” is the English of ${found.key}`;
  return ENGLISH.test(shown) ? `“${shown}” has “${ENGLISH.exec(shown)?.[0]}”` : '';
}

/** Whether it is a text of www/words in German. @param {string} text */
export const isGerman = (text) => same.has(plain(text)) && !exact.has(plain(text));

/** Notes what is written on canvases, in the page before it begins. */
export function hearCanvases() {
  const { fillText } = CanvasRenderingContext2D.prototype,
    drawn = new Set();
  /** @type {any} */ (globalThis).drawnTexts = drawn;
  CanvasRenderingContext2D.prototype.fillText = function (text, ...rest) {
    if (drawn.size < 20000) drawn.add(String(text));
    return fillText.call(this, text, ...rest);
  };
}

/** All that is seen or read aloud now, and what was drawn on canvases since the last call. @param {import('playwright-core').Page} page
 * @returns {Promise<string[]>} */
export const textsOn = (page) =>
  page.evaluate(() => {
    const found = new Set(),
      drawn = /** @type {any} */ (globalThis).drawnTexts;
    for (const text of drawn ?? []) found.add(text);
    drawn?.clear();
    for (const element of document.body.querySelectorAll('*')) {
      if (element.closest('code, pre, textarea, script, style, [lang="en"]:not(html), #scenario, #of, #library')) continue;
      const option = element instanceof HTMLOptionElement || element instanceof HTMLOptGroupElement;
      if (!option && !element.checkVisibility()) continue;
      for (const name of ['aria-label', 'aria-description', 'title', 'placeholder', 'alt', 'label']) {
        const value = element.getAttribute(name);
        if (value) found.add(value);
      }
      for (const node of element.childNodes) if (node.nodeType === Node.TEXT_NODE) found.add(node.textContent ?? '');
    }
    return [...found];
  });
