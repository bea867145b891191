// Other texts in place of the page's own, to see whether it holds longer ones and another script: `?stringTest=double`, `long` or `rtl`.

/** By the value of `stringTest`. @type {Record<string, (text: string) => string>} */
const WAYS = {
  /** As a language would whose sentences are twice as long. */
  double: (text) => `${text} ${text}`,
  /** As one would whose words are: each has half of itself once more. */
  long: (text) => text.replace(/\p{L}{4,}/gu, (word) => word + word.slice(0, Math.ceil(word.length / 2)).toLowerCase()),
  /** In a script that goes from right to left: letters of Hebrew, one for each. */
  rtl: (text) => text.replace(/[a-z]/gi, (letter) => String.fromCodePoint(0x5d0 + (letter.toLowerCase().charCodeAt(0) - 97))),
};

/** @param {any} node texts at any depth @param {(text: string) => string} change @returns {any} */
function changed(node, change) {
  if (typeof node === 'string')
    return node
      .split(/(\{[^{}]*\})/)
      .map((piece, i) => (i % 2 === 1 || piece.trim() === '' ? piece : change(piece)))
      .join('');
  return Object.fromEntries(Object.entries(node).map(([key, one]) => [key, changed(one, change)]));
}

/** @param {any} part of the words @param {string} how @returns {any} the same part with other texts; itself for an unknown way */
export function stretched(part, how) {
  const change = WAYS[how];
  return change ? changed(part, change) : part;
}
