// What families, errors, costs, methods and settings are called, and numbers of any size.
import { localized } from '../../base/format.js';
import { choiceOf, has, inputOf, language, need, t } from '../../base/words.js';

/** @typedef {import('./results.js').Family} Family */
/** @typedef {import('./results.js').Row} Row */
/** @typedef {import('./results.js').Answer} Answer */
/** @typedef {Family['problems'][number]} Question */
/** @typedef {Family['costs'][number]} Cost */

/** The kind of a problem's scenario: folders of the library are of one kind, netgames lie next to them. @param {string} scenario */
export const kindOf = (scenario) => /^(motion|rigid|fluid)\//.exec(scenario)?.[1] ?? 'netgame';

/** Words for the methods of a family. @param {Family} family @returns {Promise<void>} */
export const needNames = ({ problems: [first] }) => {
  const kind = kindOf(first?.scenario ?? '');
  return need(kind === 'netgame' ? 'netgame_more' : kind);
};

/** The page's words, or what the daemon says. @param {string} key @param {string} english */
const orElse = (key, english) => (has(key) ? t(key) : english);

/** @param {Question} problem */
const keyOf = ({ scenario, error }) => `${scenario}.${error}`;
/** @param {Family} family */
export const titleOf = (family) => orElse(`tradeoff.family.${family.name}`, family.title);
/** @param {Family} family */
export const textOf = (family) => orElse(`tradeoff.text.${family.name}`, family.text);
/** The question in large type. @param {Family} family */
export const questionOf = ({ name }) => (has(`tradeoff.asks.${name}`) ? t(`tradeoff.asks.${name}`) : t('tradeoff.asks'));
/** @param {Question} problem */
export const errorOf = (problem) => orElse(`tradeoff.error.${keyOf(problem)}`, problem.title);
/** In a word or two. @param {Question} problem */
export const problemOf = (problem) => orElse(`tradeoff.problem.${keyOf(problem)}`, problem.title);
/** @param {Cost} cost */
export const costOf = ({ path, title }) => orElse(`tradeoff.cost.${path}`, title);
/** In a word or two. @param {Cost} cost */
export const briefCostOf = ({ path, title }) => orElse(`tradeoff.brief.${path}`, title);

/** @param {Family} family @param {string} method @param {string} by the path that has the method */
export const methodOf = ({ problems: [first] }, method, by) =>
  has(`tradeoff.method.${method}`) ? t(`tradeoff.method.${method}`) : choiceOf(kindOf(first?.scenario ?? ''), by, method);

/** A setting by its name, such as Substeps 4. @param {Family} family @param {Row} row */
export function settingOf({ problems: [first] }, row) {
  const path = row.setting.split('+')[0] ?? '';
  const label = inputOf(kindOf(first?.scenario ?? ''), path)?.label ?? path.split('.').at(-1)?.replaceAll('_', ' ') ?? '';
  return `${label} ${numberOf(row.value)}`;
}

/** @param {Family} family @param {Row} row */
export const nameOf = (family, row) => `${methodOf(family, row.method, row.by)}, ${settingOf(family, row)}`;

/** Three digits, of any size. @param {number | null | undefined} value */
export const numberOf = (value) => (value === null || value === undefined ? '–' : localized(String(Number(value.toPrecision(3)))));

/** With its interval where it has one. @param {import('./results.js').Measured | undefined} measured */
export function measuredOf(measured) {
  const [value = null, low = null, high = null] = measured ?? [];
  return low === high ? numberOf(value) : `${numberOf(value)} (${numberOf(low)} – ${numberOf(high)})`;
}

// ---- numbers of a sentence, with their units ----

const SUPER = '⁰¹²³⁴⁵⁶⁷⁸⁹';
/** @param {number} power */
export const tenTo = (power) => `10${power < 0 ? '⁻' : ''}${[...String(Math.abs(power))].map((digit) => SUPER[Number(digit)]).join('')}`;

/** Two digits. @param {number} value */
export function brief(value) {
  if (value === 0) return '0';
  const power = Math.floor(Math.log10(Math.abs(value)) + 1e-9);
  if (power < -4) return `${localized(String(Number((value / 10 ** power).toPrecision(2))))}\u00a0·\u00a0${tenTo(power)}`;
  return localized(String(Number(value.toPrecision(Math.max(2, Math.min(5, power + 1))))));
}

/** What a family says in words of its own. @param {string} key @param {Family} family */
export const ownKey = (key, { name }) => (has(`${key}.${name}`) ? `${key}.${name}` : key);

/** A count: whole, with its thousands; from a million on in three digits. @param {number} value
 * @param {'short' | 'long'} [compactDisplay] M or million */
export function countOf(value, compactDisplay = 'short') {
  const large = Math.abs(value) >= 1e6;
  return new Intl.NumberFormat(language.value, {
    notation: large ? 'compact' : 'standard',
    compactDisplay,
    ...(large ? { maximumSignificantDigits: 3 } : { maximumFractionDigits: Math.abs(value) < 100 ? 2 : 0 }),
  }).format(value);
}

/** @param {number} value @param {[number, string][]} units by their sizes, the largest first */
function inUnits(value, units) {
  const [size, unit] = units.find(([size]) => value >= size * 0.9995) ?? units.at(-1) ?? [1, ''];
  return `${localized(String(Number((value / size).toPrecision(3))))} ${unit}`;
}

/** A cost as a figure. @param {string} path @param {number} value */
export function priceOf(path, value) {
  if (path === 'cpu_s')
    return inUnits(value, [
      [1, 's'],
      [1e-3, 'ms'],
      [1e-6, 'µs'],
    ]);
  if (/bytes/.test(path)) {
    const bytes = inUnits(value, [
      [1e6, 'MB'],
      [1e3, 'kB'],
      [1, 'B'],
    ]);
    return path.endsWith('_per_s') ? `${bytes}/s` : bytes;
  }
  if (/_ms(\.|$)/.test(path)) return `${localized(String(Number(value.toPrecision(3))))} ms`;
  if (path.endsWith('stalled_s')) return `${localized(String(Number(value.toPrecision(3))))} s`;
  return countOf(value, 'long');
}

/** An error as a figure. @param {Question} problem @param {number} value */
export function missOf({ error }, value) {
  if (/(^|_)m(\.|$)/.test(error)) return `${brief(value)} m`;
  return error.startsWith('divergence') ? `${brief(value)}/s` : brief(value);
}

/** In a sentence: 969 evaluations. @param {Cost} cost @param {number} value */
export const paidOf = (cost, value) =>
  has(`tradeoff.paid.${cost.path}`)
    ? t(`tradeoff.paid.${cost.path}`, { figure: priceOf(cost.path, value), n: value })
    : priceOf(cost.path, value);

/** In a sentence: 0.007 off. @param {Question} problem @param {number} value */
export const offOf = (problem, value) => {
  const key = `tradeoff.off.${keyOf(problem)}`;
  return t(has(key) ? key : 'tradeoff.off', { figure: missOf(problem, value), n: value });
};

/** How many times as much. @param {number} times */
export const timesOf = (times) => localized(String(Number(times.toPrecision(2))));

/** Seconds that the game stood still, of how many: what no other cost shows. Null where it never does.
 * @param {Family} family @param {Row} row @returns {{still: number, of: number} | null} */
export function stillOf({ costs }, row) {
  const at = costs.findIndex(({ path }) => path === 'server.stalled_s'),
    still = row.costs[at]?.[0] ?? 0,
    of = Number(/(?:^| )duration_s=([0-9.]+)/.exec(row.set)?.[1] ?? 0);
  return at >= 0 && of > 0 ? { still, of } : null;
}

// ---- a file ----

/** The columns of `laglab tradeoff --out`. */
const COLUMNS = [
  'family,scenario,by,method,setting,value,status',
  'metric,error,error_low,error_high,cost,cost_value,cost_low,cost_high,front,cpu_min_s,cpu_median_s',
  'seed,seeds,check_seed,check_seeds,check_error,check_error_high,check_cost,set,link',
].join();

/** As RFC 4180 has it. @param {unknown} value */
const cell = (value) => {
  const text = String(value ?? '');
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
};

/** Every setting with every cost. @param {Family} family @param {Row[]} rows @param {string} page its address, for links
 * @returns {string} */
export function csvOf(family, rows, page) {
  const lines = rows.flatMap((row) =>
    family.costs.map(({ path }, c) => {
      const problem = family.problems[row.problem],
        { check } = row;
      return [
        ...[family.name, problem?.scenario, row.by, row.method, row.setting, row.value, row.status, problem?.error, ...row.error],
        ...[path, ...(row.costs[c] ?? []), row.front[c], row.costs[0]?.[0], row.cpu_median_s, row.seed, row.seeds],
        ...[check?.seed, check?.seeds, check?.error[0], check?.error[2], check?.costs[c]?.[0], row.set, page + row.link],
      ]
        .map(cell)
        .join(',');
    }),
  );
  return `${[COLUMNS, ...lines].join('\r\n')}\r\n`;
}
