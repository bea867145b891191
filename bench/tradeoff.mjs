// Speed against error of eight families of methods, each with an image and the cheapest method at three levels of error, measured again.
// docs/tradeoff.md shows both, and the page has the rows (cmake/shipped_rows.mjs). --quick: 10 seeds for each setting and its check;
// default 20, and 100 where a few seeds have most of the error.
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { HEIGHT, WIDTH, drawFigure } from './figure.mjs';
import { digits, laglab, printTable, results, run, writeCsv } from './lib.mjs';

const quick = process.argv.includes('--quick');
/** Of an ocean few waves of a seed make its height, and its heights' fourth moment. */
const MANY = { oceans: 100 };
const seedsOf = (/** @type {string} */ family) => {
  const seeds = quick ? 10 : MANY[family];
  return seeds ? ['--seeds', String(seeds), '--check-seeds', String(seeds)] : [];
};
const command = `bench/run tradeoff${quick ? ' --quick' : ''}`;
const folder = mkdtempSync(join(tmpdir(), 'laglab-tradeoff-'));
process.on('exit', () => rmSync(folder, { recursive: true, force: true }));
mkdirSync(join(results, 'tradeoff'), { recursive: true });

const settings = {
  scenario: 'id in the library',
  metric: 'path of the error',
  method: 'what is compared',
  setting: 'path of what is varied',
  value: 'its value',
  error: 'mean of the magnitude over the seeds',
  error_low: 'lower bound of its 95 % interval; without randomness the error',
  error_high: 'upper bound',
  cost: 'cpu_s: processor time of a run, minimum of the runs; otherwise the path of a metric, or of cost',
  cost_value: 'minimum of cpu_s, mean of the others',
  cost_low: 'lower bound of its 95 % interval; of cpu_s the minimum',
  cost_high: 'upper bound; of cpu_s the median, at least 5 % above the minimum',
  front: 'whether no other setting is better in error and cost',
  seed: 'of the first run',
  seeds: 'runs; 1: nothing is random',
  check_seed: 'of the first run of the check',
  check_seeds: 'runs of the check',
  check_error: 'error in the check',
  check_error_high: 'upper bound in the check',
  check_cost: 'cost in the check',
  by: 'path of what is compared',
  status: 'ok, or diverged',
  set: 'path=value of the scenario that make this setting, separated by spaces',
};
const choices = {
  family: 'family of methods',
  ...Object.fromEntries(['scenario', 'metric', 'cost'].map((name) => [name, settings[name]])),
  level: 'the error has to stay within this: three equal steps between the bounds of the front, on a logarithmic scale, rounded up',
  method: 'the cheapest whose upper bound is within the level',
  ...Object.fromEntries(
    ['setting', 'value', 'error', 'error_high', 'cost_value', 'seed', 'seeds', 'check_seed', 'check_seeds'].map((name) => [
      name,
      settings[name],
    ]),
  ),
  check_error: 'its error in the check',
  check_error_high: 'its upper bound in the check',
  check_cost: 'its cost in the check',
  check_cheapest: 'the cheapest within the level in the check',
  verdict: 'holds: within the level again, and nothing that is within it there is cheaper beyond the intervals of both costs',
  figures: 'of the check',
  as_cheap: 'other methods whose cost does not differ certainly from it',
  link: 'a live session of it',
};

/** Six digits are enough for files that are kept. */
const short = (row) =>
  Object.fromEntries(Object.entries(row).map(([name, value]) => [name, typeof value === 'number' ? Number(value.toPrecision(6)) : value]));

/** Of the methods with a point on the front, error against cost. Rings: the front, and choices. */
function figure(problem, cost, rows, chosen) {
  const of = (row) => row.metric === problem.error && row.scenario === problem.scenario && row.cost === cost.path,
    place = (row) => [row.cost_value, row.error],
    drawn = rows.filter((row) => of(row) && row.error !== null && row.cost_value !== null && (row.error > 0 || row.seeds > 1)),
    choices = chosen.filter(of);
  return drawFigure({
    title: `${problem.scenario}: ${problem.title}`,
    x: cost.title,
    y: problem.title,
    series: [...new Set(drawn.filter((row) => row.front).map((row) => row.method))].map((method) => {
      const own = drawn.filter((row) => row.method === method),
        parts = [...new Set(own.map((row) => row.setting))].map((setting) => own.filter((row) => row.setting === setting).map(place));
      return { name: method, points: own.map(place), parts };
    }),
    rings: [
      ...drawn.filter((row) => row.front).map((row) => ({ at: place(row), radius: 5, colour: '#b34700' })),
      ...choices.filter((row) => row.method).map((row) => ({ at: place(row), radius: 8, colour: '#333' })),
    ],
    levels: choices.map(({ level }) => ({ at: level, name: digits(level, 2) })),
    logarithmic: drawn.every((row) => row.error > 0),
    across: drawn.every((row) => row.cost_value > 0),
  });
}

/** Figures of a family, two in a row. */
function figures({ problems, costs }, rows, chosen) {
  const all = problems.flatMap((problem) => costs.map((cost) => figure(problem, cost, rows, chosen)));
  const placed = all.map((text, i) =>
    text.replace('<svg ', `<svg x="${(i % 2) * WIDTH}" y="${Math.floor(i / 2) * HEIGHT}" width="${WIDTH}" height="${HEIGHT}" `),
  );
  return [
    `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${2 * WIDTH} ${Math.ceil(all.length / 2) * HEIGHT}">`,
    ...placed,
    '</svg>\n',
  ].join('\n');
}

const all = [];
for (const family of JSON.parse(await run(laglab, ['tradeoff', '--list']))) {
  const { name, title } = family,
    [rows, winners] = ['rows', 'winners'].map((part) => join(folder, `${name}.${part}.json`));
  await run(laglab, ['tradeoff', name, ...seedsOf(name), '--out', rows, '--winners', winners]);
  const read = (file) => JSON.parse(readFileSync(file, 'utf8')).map(short);
  const chosen = read(winners);
  all.push(...chosen);
  printTable(
    title,
    chosen.map((row) => ({
      scenario: row.scenario,
      cost: row.cost,
      'error up to': digits(row.level, 2),
      method: row.method ? `${row.method} ${row.value}` : 'none',
      error: digits(row.error),
      'cost of it': digits(row.cost_value),
      check: row.verdict,
      'as cheap': row.as_cheap || '-',
    })),
  );
  writeFileSync(join(results, 'tradeoff', `${name}.svg`), figures(family, read(rows), chosen));
  writeCsv(`tradeoff/${name}`, command, settings, read(rows));
}
writeCsv('tradeoff/winners', command, choices, all);
