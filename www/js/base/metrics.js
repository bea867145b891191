// What is measured of a run: the tables of GET metrics, which no session is needed for.

/** @typedef {{name: string, type: string, unit?: string, signed?: boolean, rate?: boolean, rare?: boolean, tail?: 'long' | 'extreme',
 * help: string, null?: string}} MetricRow */
/** @typedef {{path: string, also?: string, when?: string, help: string, metrics: MetricRow[]}} MetricTable */
/** @typedef {{kinds: {kind: string, tables: MetricTable[]}[], common: MetricTable[]}} MetricTables */

/** Types with parts, such as `.mean`. */
const PARTED = ['numbers', 'distribution', 'latency', 'gauge', 'by_name', 'curve', 'notices'];

/** The rest of a path behind what fits a pattern of its beginning; null: it begins otherwise. @param {string[]} path
 * @param {string} pattern */
function behind(path, pattern) {
  const parts = pattern === '' ? [] : pattern.split('.');
  return parts.length <= path.length && parts.every((part, i) => part === '*' || part === path[i]) ? path.slice(parts.length) : null;
}

/** The row that a path such as `players.0.remote_error_m.mean` is or leads into.
 * @param {MetricTables} all @param {string} kind @param {string} path @returns {MetricRow | undefined} */
export function metricRow(all, kind, path) {
  const tables = [...(all.kinds.find((one) => one.kind === kind)?.tables ?? []), ...all.common],
    names = path.split('.');
  for (const { path: at, also, metrics } of tables)
    for (const rest of [behind(names, at), also === undefined ? null : behind(names, at === '' ? also : `${also}.${at}`)]) {
      const row = metrics.find(({ name, type }) => rest !== null && rest[0] === name && (rest.length === 1 || PARTED.includes(type)));
      if (row) return row;
    }
  return undefined;
}

/** What is shown of a row: the unit, what it is, and when it is null. @param {MetricRow} row */
export const metricHelp = ({ unit, help, null: when }) =>
  `${unit === undefined ? '' : `${unit}; `}${help}${when === undefined ? '' : `. Null: ${when}`}`;
