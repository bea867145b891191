// What families, errors, costs, methods and settings are called, and numbers of any size.
import { localized } from '../../base/format.js';
import { choiceOf, has, inputOf, need, t } from '../../base/words.js';

/** @typedef {import('./jobs.js').Family} Family */
/** @typedef {import('./jobs.js').Row} Row */
/** @typedef {import('./jobs.js').Answer} Answer */

/** The kind of a problem's scenario: folders of the library are of one kind, netgames lie next to them. @param {string} scenario */
export const kindOf = (scenario) => /^(motion|rigid|fluid)\//.exec(scenario)?.[1] ?? 'netgame';

/** Words for the methods of a family. @param {Family} family @returns {Promise<void>} */
export const needNames = ({ problems: [first] }) => {
  const kind = kindOf(first?.scenario ?? '');
  return need(kind === 'netgame' ? 'netgame_more' : kind);
};

/** The page's words, or what the daemon says. @param {string} key @param {string} english */
const orElse = (key, english) => (has(key) ? t(key) : english);

/** @param {Family} family */
export const titleOf = (family) => orElse(`tradeoff.family.${family.name}`, family.title);
/** @param {Family} family */
export const textOf = (family) => orElse(`tradeoff.text.${family.name}`, family.text);
/** @param {Family['problems'][number]} problem */
export const errorOf = ({ scenario, error, title }) => orElse(`tradeoff.error.${scenario}.${error}`, title);
/** @param {Family['costs'][number]} cost */
export const costOf = ({ path, title }) => orElse(`tradeoff.cost.${path}`, title);

/** @param {Family} family @param {string} method @param {string} by the path that has the method */
export const methodOf = ({ problems: [first] }, method, by) => choiceOf(kindOf(first?.scenario ?? ''), by, method);

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

/** With its interval where it has one. @param {import('./jobs.js').Measured | undefined} measured */
export function measuredOf(measured) {
  const [value = null, low = null, high = null] = measured ?? [];
  return low === high ? numberOf(value) : `${numberOf(value)} (${numberOf(low)} – ${numberOf(high)})`;
}

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

/** Every setting with every cost. @param {Answer} answer @param {string} page its address, for links @returns {string} */
export function csvOf(answer, page) {
  const lines = answer.rows.flatMap((row) =>
    answer.costs.map(({ path }, c) => {
      const problem = answer.problems[row.problem],
        { check } = row;
      return [
        ...[answer.name, problem?.scenario, row.by, row.method, row.setting, row.value, row.status, problem?.error, ...row.error],
        ...[path, ...(row.costs[c] ?? []), row.front[c], row.costs[0]?.[0], row.cpu_median_s, row.seed, row.seeds],
        ...[check?.seed, check?.seeds, check?.error[0], check?.error[2], check?.costs[c]?.[0], row.set, page + row.link],
      ]
        .map(cell)
        .join(',');
    }),
  );
  return `${[COLUMNS, ...lines].join('\r\n')}\r\n`;
}
