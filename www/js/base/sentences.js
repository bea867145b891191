// Sentences of the daemon in another language. Its API speaks English; a table has the sentence of each with {places} for what differs.
// What stands in a place is said by the table as well, where it has that; a place n, m, k, l, i or j holds a number, `path` and `other` a
// parameter's path.

const PLACE = /\{(\w+)\}/;
const NUMBER = /^[nmklij]$/;
const DEEPEST = 4;

/** @typedef {{pattern: RegExp, names: string[], text: string, literal: number}} Sentence */

const quoted = (/** @type {string} */ text) => text.replace(/[.*+?^${}()|[\]\\]/g, '\\$&');

/** @param {string} english @param {string} text @returns {Sentence} */
function sentenceOf(english, text) {
  const pieces = english.split(PLACE),
    names = pieces.filter((_, i) => i % 2 === 1);
  const body = pieces
    .map((piece, i) =>
      i % 2 === 0
        ? quoted(piece)
        : NUMBER.test(piece)
          ? '([-−+]?(?:\\d[\\d.,e+-]*|inf|nan))'
          : piece === 'path' || piece === 'other'
            ? '([\\w.\\[\\]"]+)'
            : '(.+?)',
    )
    .join('');
  return { pattern: new RegExp(`^${body}$`, 's'), names, text, literal: english.replace(/\{\w+\}/g, '').length };
}

/** @param {Record<string, string>} table of sentences by the English one
 * @param {(path: string) => string} nameOf  what the page calls a parameter; the path where it has no name
 * @returns {(english: string) => string | null} null where the table has no sentence */
export function translator(table, nameOf) {
  const exact = new Map(Object.entries(table).filter(([english]) => !PLACE.test(english)));
  const open = Object.entries(table)
    .filter(([english]) => PLACE.test(english))
    .map(([english, text]) => sentenceOf(english, text))
    .sort((a, b) => b.literal - a.literal);

  /** @param {string} english @param {number} depth @returns {string | null} */
  function said(english, depth) {
    const found = exact.get(english);
    if (found !== undefined || depth === 0) return found ?? null;
    for (const { pattern, names, text } of open) {
      const values = pattern.exec(english);
      if (!values) continue;
      const parts = names.map((name, i) => {
        const value = values[i + 1] ?? '';
        return name === 'path' || name === 'other' ? nameOf(value) : (said(value, depth - 1) ?? nameOf(value));
      });
      if (text === '{path}: {why}' && parts[1] === values[2]) continue; /* nothing of it is known */
      return text
        .split(PLACE)
        .map((piece, i) => (i % 2 === 0 ? piece : (parts[names.indexOf(piece)] ?? '')))
        .join('');
    }
    return null;
  }
  return (english) => said(english, DEEPEST);
}
