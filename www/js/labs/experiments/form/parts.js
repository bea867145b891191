// Windows of an experiment, which are parts of its runs: as they are typed, and as the specification has them.

import { typedNumber } from '../../../base/format.js';

/** on: only while the value, a column of the trace or a parameter, is above and below these; an empty text is no bound
 * @typedef {{name: string, from: string, to: string, on: boolean, value: string, above: string, below: string}} Part */

export const PARTS_MAX = 8;
const NAME_MAX = 24;

/** @param {string} text @returns {number | string} text that is not a number, or more than one, is passed on: the daemon rejects it */
export function toNumber(text) {
  const number = typedNumber(text);
  return number === 'ambiguous' || Number.isNaN(number) ? text : number;
}

/** A name is a part of paths: of what is typed the rest is left out. @param {string} text */
export const partName = (text) =>
  text
    .normalize('NFD')
    .replace(/\p{M}/gu, '')
    .toLowerCase()
    .replace(/[^a-z0-9]+/g, '_')
    .replace(/^[^a-z]+/, '')
    .slice(0, NAME_MAX);

/** A new one, from a time on. @param {Part[]} parts @param {number} from_s @returns {Part} */
export function newPart(parts, from_s) {
  let n = parts.length + 1;
  while (parts.some(({ name }) => name === `part_${n}`)) n++;
  return { name: `part_${n}`, from: String(from_s), to: '', on: false, value: '', above: '', below: '' };
}

/** @param {any} json @returns {Part} */
export const partOf = ({ name, from_s, to_s, while: condition }) => ({
  name: String(name ?? ''),
  from: String(from_s ?? ''),
  to: String(to_s ?? ''),
  on: condition !== undefined,
  value: String(condition?.value ?? ''),
  above: String(condition?.above ?? ''),
  below: String(condition?.below ?? ''),
});

/** Members without a text are left out. @param {Record<string, string>} texts */
const numbers = (texts) =>
  Object.fromEntries(
    Object.entries(texts)
      .filter(([, text]) => text.trim() !== '')
      .map(([name, text]) => [name, toNumber(text)]),
  );

/** @param {Part} part */
export const partJson = ({ name, from, to, on, value, above, below }) => ({
  name,
  ...numbers({ from_s: from, to_s: to }),
  ...(on ? { while: { value, ...numbers({ above, below }) } } : {}),
});

/** @param {string} metric `PATH@WINDOW`, or a metric of whole runs */
export const windowOf = (metric) => metric.split('@')[1] ?? '';
/** @param {string} metric */
export const bareOf = (metric) => metric.split('@')[0] ?? '';

/** Length of a window, as if it were a metric. */
export const LENGTH = 'counted_s';

/** Whether a metric is one in a window too, as its row says: src/experiment/spec/window.h.
 * @param {string} path @param {{type: string, unit?: string, rate?: boolean} | undefined} row */
export function isWindowed(path, row) {
  if (path === LENGTH) return true;
  if (row === undefined || path.startsWith('cost.')) return false;
  if (['distribution', 'latency', 'gauge'].includes(row.type)) return /\.(?:mean|rms|count)$/.test(path);
  return row.type === 'count' || row.rate === true || (row.type === 'number' && row.unit === 's');
}
