// docs/tradeoff.md: speed against error of families of methods, from what `bench/run tradeoff` measured.
import { existsSync, readFileSync } from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '..');

/** @typedef {{name: string, title: string, text: string, problems: {scenario: string, error: string, title: string}[],
 * costs: {path: string, title: string}[]}} Family */

const INTRODUCTION = `# Speed against error

Which method is the cheapest at a given error? \`laglab tradeoff\` measures families of methods, each method at each of its own settings,
and places them on the Pareto front of the error and every cost: processor time, work that is the same on every machine, bytes per second,
latency, memory. Each image has a drawing for each cost; left is cheap, low is accurate. \`--report FILE.html\` draws the same of a
measurement of yours.

- **Error**: the mean over seeds with its 95 % [interval](experiments.md#intervals); without randomness a run's own.
- **Front**: marked points, for which no other is better in both.
- **Levels**: three per problem, dashed. Of the settings on the fronts of the costs other than time, the upper bounds of the errors span
  a range; the levels divide it in four equal parts on a logarithmic scale, rounded up to two digits.
- **Cheapest**: the setting with the least cost whose upper bound is within the level; a ring in the image, a link to a live session in the
  table.
- **Check**: every setting is measured again, on seeds that follow those of the measurement. A choice *holds* if its upper bound is within
  the level again, and nothing else that is within it there is cheaper beyond the intervals of both costs. Without randomness the errors
  cannot differ, and the processor time is measured again. *As cheap* are methods whose cost does not differ certainly from it in one of the
  two measurements.
- **Time**: the minimum of the runs; its interval ends at the median, and at least 5 % above the minimum. A daemon measures two settings at
  the same time, where it has two cores: of four families that raised the processor times by 2 % at most in the median, and by at most
  3 % in nine of ten settings, within that interval.
- **Order**: the coarsest setting of every method comes first, then finer ones, then the check.

\`\`\`console
$ build/laglab tradeoff contact_solvers --winners winners.csv --report contacts.html > contacts.csv
\`\`\`

On the page, *Speed against error* (\`/#tradeoff\`) has these rows and measures a family on the daemon; \`POST /api/v1/tradeoffs\` is for
programs. \`bench/run tradeoff\` measures all of this page. [Work against precision](experiments.md#work-against-precision) has the options
for a problem of your own.
`;

const number = (/** @type {string} */ text, digits = 3) => (text === '' ? '' : String(Number(Number(text).toPrecision(digits))));
const inCell = (/** @type {string} */ text) => text.replaceAll('|', '\\|');

/** @param {Family} family @param {Record<string, string>} row */
function choice(family, row) {
  const problem = family.problems.find(({ scenario, error }) => scenario === row.scenario && error === row.metric),
    cost = family.costs.find((one) => one.path === row.cost);
  const name = row.method === '' ? 'none' : `[${row.method}, ${row.setting.split('.').at(-1)} ${number(row.value)}](${row.link})`;
  const figures = row.figures === '' ? row.verdict : `${row.verdict}: ${row.figures}`;
  const cells = [
    `${row.scenario}: ${problem?.title ?? row.metric}`,
    cost?.title ?? row.cost,
    number(row.level, 2),
    name,
    row.method === '' ? '' : `${number(row.error)}, at most ${number(row.error_high)}`,
    number(row.cost_value),
    figures,
    row.as_cheap,
  ];
  return `| ${cells.map(inCell).join(' | ')} |`;
}

/** @param {Family} family @param {Record<string, string>[]} winners */
function section(family, winners) {
  const image = `bench/results/tradeoff/${family.name}.svg`,
    rows = winners.filter((row) => row.family === family.name);
  const held = rows.filter((row) => row.verdict === 'holds').length;
  return [
    `## ${family.title}`,
    family.text,
    existsSync(path.join(ROOT, image)) ? `![${family.title}: error against each cost](../${image})` : '',
    rows.length === 0
      ? 'No figures yet: `bench/run tradeoff` measures them.'
      : `Of ${rows.length} choices ${held} hold. The rows: [${family.name}.csv](../bench/results/tradeoff/${family.name}.csv).`,
    ...(rows.length === 0
      ? []
      : [
          [
            '| Error | Cost | Error at most | Cheapest | Its error | Its cost | Check | As cheap |',
            '| --- | --- | --- | --- | --- | --- | --- | --- |',
            ...rows.map((row) => choice(family, row)),
          ].join('\n'),
        ]),
  ]
    .filter((part) => part !== '')
    .join('\n\n');
}

/** @param {Family[]} families @param {(text: string) => {comments: [string, string][], rows: Record<string, string>[]}} parse
 * @param {(name: string, head: Map<string, string>) => string} age */
export function tradeoffDoc(families, parse, age) {
  const file = path.join(ROOT, 'bench/results/tradeoff/winners.csv'),
    { comments, rows } = existsSync(file) ? parse(readFileSync(file, 'utf8')) : { comments: [], rows: [] };
  const head = new Map(/** @type {[string, string][]} */ (comments));
  const machine = ['cpu', 'memory', 'compiler', 'priority', 'load'].flatMap((key) => (head.has(key) ? [`${key}: ${head.get(key)}`] : []));
  const measured = rows.length === 0 ? [] : [age('tradeoff/winners', head), machine.map((line) => `- ${line}`).join('\n')];
  return [INTRODUCTION.trimEnd(), ...measured, ...families.map((family) => section(family, rows))].join('\n\n') + '\n';
}
