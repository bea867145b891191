// Refuses comparisons of real numbers that NaN passes, in the tests in C: node tests/structure/near.mjs ROOT
// A failure behind `if (error > limit)` does not come for NaN; the worst of many errors by fmax or `x > worst ? x : worst` loses it.
// tests/support/near.h has what fails. Whether an operand is real follows from its text: a literal with a point or an exponent, a
// function of math.h, or a name that the file declares as double or float. Integers and branches that do not fail are left alone.
import { readFileSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { argv, exit } from 'node:process';
import { fileURLToPath } from 'node:url';

const REAL = /\b\d+\.\d*|\.\d+\b|\b\d+(?:\.\d*)?e[-+]?\d+|\b(?:fabsl?|sqrt|hypotl?|pow|log\w*|exp\w*|sin|cos|ll_to_m?s)\(|\bINFINITY\b/;

/** Comments and strings as blanks: lines and columns stay. @param {string} text */
function bare(text) {
  return text.replace(/\/\*[\s\S]*?\*\/|\/\/.*|"(?:[^"\\\n]|\\.)*"/g, (found) => found.replace(/[^\n]/g, ' '));
}

/** The place behind the parenthesis that closes the one at `open`. @param {string} text @param {number} open */
function behind(text, open) {
  let depth = 0;
  for (let i = open; i < text.length; i++) {
    if (text[i] === '(') depth++;
    if (text[i] === ')' && --depth === 0) return i + 1;
  }
  return text.length;
}

/** @param {string} text @returns {Set<string>} names of variables, members, parameters that are real */
function realNames(text) {
  const names = new Set();
  for (const [, list] of text.matchAll(/\b(?:double|float)\b\s*((?:\*|const\b|\s)*\w+[^;(){}]*)/g))
    for (const part of list.split(',')) {
      const name = /^(?:\s|\*|const\b)*(\w+)/.exec(part)?.[1];
      if (name) names.add(name);
    }
  return names;
}

/** Without what stands in `!( )` or `!is_near( )`, which fails for NaN. @param {string} condition */
function unguarded(condition) {
  let text = condition;
  for (let found = /!\w*\(/.exec(text); found; found = /!\w*\(/.exec(text))
    text = text.slice(0, found.index) + ' ' + text.slice(behind(text, found.index + found[0].length - 1));
  return text;
}

/** @param {string} text one source @returns {{at: number, why: string}[]} */
function breaches(text) {
  const names = realNames(text),
    isReal = (/** @type {string} */ operand) => REAL.test(operand) || [...operand.matchAll(/\w+/g)].some(([word]) => names.has(word)),
    compares = (/** @type {string} */ condition) =>
      condition.split(/&&|\|\|/).some((part) => {
        const sides = part.split(/(?<![-<>])(?:<=?|>=?)(?![<>])/);
        return sides.length === 2 && sides.some(isReal);
      });
  const found = [];
  for (const match of text.matchAll(/\bf(?:max|min)[fl]?\(/g)) found.push({ at: match.index, why: 'larger() and smaller() keep NaN' });
  for (const match of text.matchAll(/\bassert_false\(/g)) {
    const open = match.index + match[0].length - 1;
    if (compares(text.slice(open + 1, behind(text, open) - 1)))
      found.push({ at: match.index, why: 'assert_true of the contrary fails for NaN' });
  }
  for (const match of text.matchAll(/\bif \(/g)) {
    const open = match.index + match[0].length - 1,
      end = behind(text, open);
    if (/^\s*\{?\s*fail(?:_msg)?\(/.test(text.slice(end)) && compares(unguarded(text.slice(open + 1, end - 1))))
      found.push({ at: match.index, why: 'a failure behind `if` needs is_near() or !(x <= limit)' });
    const kept = /^\s*([\w.>[\]-]+) = ([\w.>[\]-]+);/.exec(text.slice(end)),
      pair = kept && text.slice(open + 1, end - 1).split(/ [<>]=? /);
    if (kept && pair?.length === 2 && pair.includes(kept[1]) && pair.includes(kept[2]) && pair.some(isReal))
      found.push({ at: match.index, why: 'larger() and smaller() keep NaN' });
  }
  for (const match of text.matchAll(/([\w.>[\]-]+) = ([\w.>[\]-]+) [<>]=? ([\w.>[\]-]+) \? (?:\2 : \3|\3 : \2);/g)) {
    const pair = [match[2], match[3]];
    if (pair.includes(match[1]) && pair.some(isReal)) found.push({ at: match.index, why: 'larger() and smaller() keep NaN' });
  }
  return found;
}

/** @param {string} root @returns {{findings: string[], files: number}} one line per breach */
export function checkNear(root) {
  const files = readdirSync(join(root, 'tests'), { recursive: true, encoding: 'utf8' })
    .filter((path) => /\.[ch]$/.test(path) && !path.startsWith('support/near.'))
    .sort();
  const findings = files.flatMap((path) => {
    const text = bare(readFileSync(join(root, 'tests', path), 'utf8'));
    return breaches(text).map(({ at, why }) => `tests/${path}:${text.slice(0, at).split('\n').length}: ${why}`);
  });
  return { findings, files: files.length };
}

if (argv[1] === fileURLToPath(import.meta.url)) {
  const { findings, files } = checkNear(argv[2] ?? '.');
  for (const finding of findings) console.log(finding);
  console.log(`${files} files of tests, ${findings.length} findings`);
  exit(files > 0 && findings.length === 0 ? 0 : 1);
}
