// The tables of metrics (from `laglab schema metrics`) as docs/metrics.md, those of columns as docs/columns.md.

/** @typedef {{name: string, type: string, unit?: string, signed?: boolean, rare?: boolean, tail?: string, help: string,
 * null?: string}} Row */
/** @typedef {{path: string, also?: string, when?: string, help: string, metrics: Row[]}} Table */

const TITLES = { netgame: 'Netgame', motion: 'Motion', rigid: 'Rigid bodies', fluid: 'Fluids' };
const code = (/** @type {string | undefined} */ text) => (text ? `\`${text}\`` : '');
const cell = (/** @type {string} */ text) => text.replaceAll('|', '\\|').replaceAll('*', '\\*');

/** @param {Row} row */
function line({ name, type, unit, signed, rare, tail, help, null: when }) {
  const of = [type.replace('_', ' '), ...(signed ? ['signed'] : []), ...(rare ? ['rare'] : []), ...(tail ? [`${tail} tail`] : [])].join(
    ', ',
  );
  return `| ${[code(name), of, cell(unit ?? ''), cell(help), cell(when ?? '')].join(' | ')} |`;
}

/** @param {Table} table */
function section({ path, also, when, help, metrics }) {
  const where = path === '' ? 'Members of `metrics` itself' : code(path),
    again = also ? `; the same under ${code(`${also}${path ? `.${path}` : ''}`)}` : '';
  return `${where}${again}. ${when ? `${when} ` : ''}${help}

| Name | Type | Unit | What it is | Null when |
| --- | --- | --- | --- | --- |
${metrics.map(line).join('\n')}
`;
}

/** @param {{kinds: {kind: string, tables: Table[]}[], common: Table[]}} all */
export function metricsDoc({ kinds, common }) {
  return `# Metrics, table by table

<!-- Written by docs/generate.mjs from \`laglab schema metrics\`: the tables are in C, and changed there. -->

The members of \`metrics\`, which \`laglab run\` prints and \`GET /api/v1/sessions/ID/metrics\` returns. \`GET /api/v1/metrics\` returns
these tables without a session. In a path \`*\` stands for each element of a list, or each member of an object.
[Concepts](concepts.md#metrics) defines the terms, and the instants between which each metric of a netgame is measured.

| Type | In JSON |
| --- | --- |
| number | a number |
| count | a whole number |
| flag | true or false |
| text | a name or a sentence |
| numbers | a list of numbers |
| distribution | an object with \`mean\`, \`rms\`, \`p50\`, \`p95\`, \`p99\`, \`max\` and \`count\` |
| latency | a distribution with one more member, \`lost_ratio\`: the share of inputs that were never applied |
| gauge | an object with \`mean\`, \`min\`, \`max\` and \`count\` |
| by name | an object with a number for each of some names |
| curve | a list of pairs: coordinate, value |
| notices | a list of sentences |

*Signed* metrics may be below 0 and are better the nearer they are to 0: comparisons take their magnitude. *Rare* metrics count
events that come one by one: their number has nearly a Poisson distribution, which their confidence intervals take into account. Of a
distribution and a gauge the members are null, not the object.

${kinds.map(({ kind, tables }) => `## ${TITLES[kind] ?? kind}\n\n${tables.map(section).join('\n')}`).join('\n')}
## Every kind

${common.map(section).join('\n')}`;
}

/** A table of columns: `beginning` of their names. @param {Table} table */
const columns = ({ path, when, help, metrics }) => `${path === '' ? '' : `${code(`${path}NAME`)}. `}${when ? `${when} ` : ''}${help}

| Name | Type | Unit | What it is | Null when |
| --- | --- | --- | --- | --- |
${metrics.map(line).join('\n')}
`;

/** @param {{kinds: {kind: string, tables: Table[]}[]}} traces @param {Table[]} results */
export function columnsDoc({ kinds }, results) {
  return `# Columns of traces and results

<!-- Written by docs/generate.mjs from \`laglab schema traces\` and \`laglab schema results\`: the tables are in C, and changed there. -->

## Traces

A trace (\`laglab run --trace\`, \`sweep --traces\`, \`GET /api/v1/sessions/ID/trace\`) is CSV with a line per tick, tick 0 too: the state
after all events of its time; other formats have the same columns. Its first columns are \`time_s\` and \`tick\`. In a beginning of names
\`*\` is the index of a player, a method or a body. Of worlds and fluids side by side, the columns of all after the first begin with
\`side_by_side0_\` or \`side_by_side1_\`. What is not known is \`nan\`, and null in other formats than CSV.

${kinds.map(({ kind, tables }) => `### ${TITLES[kind] ?? kind}\n\n${tables.map(columns).join('\n')}`).join('\n')}
## Results

The tables of [experiments](experiments.md) as CSV, NDJSON, JSON and SQLite. Parameters and metrics are columns named by their
paths, parameters with their unit; [metrics](metrics.md) says what each is. In other columns of a metric \`*\` is its path and a point:
\`players.0.remote_error_m.mean.ci95\`.

${results.map((table) => columns({ ...table, path: table.path && `${table.path}.` })).join('\n')}`;
}
