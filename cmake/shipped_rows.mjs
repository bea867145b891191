// What `bench/run tradeoff` measured, as the page reads it: tradeoffs/FAMILY.json, in the form of a measurement's answer
// (GET /api/v1/tradeoffs/ID), without the texts of the family, with the machine, date and commit of the files' heads.
import { mkdirSync, readFileSync, readdirSync, writeFileSync } from 'node:fs';
import { basename, join } from 'node:path';

/** @typedef {Record<string, string>} Cells */

/** RFC 4180 under lines of comments. @param {string} text @returns {{head: Cells, rows: Cells[]}} */
export function read(text) {
  const lines = text.split('\n').filter((line) => line !== ''),
    comments = lines.filter((line) => line.startsWith('# ')),
    [names = [], ...cells] = lines
      .filter((line) => !line.startsWith('#'))
      .map((line) =>
        [...line.matchAll(/(?:^|,)(?:"((?:[^"]|"")*)"|([^,]*))/g)].map(([, quoted, plain]) => quoted?.replaceAll('""', '"') ?? plain ?? ''),
      );
  return {
    head: Object.fromEntries(comments.map((line) => /^# ([^:]*): (.*)$/.exec(line)?.slice(1) ?? [line, ''])),
    rows: cells.map((row) => Object.fromEntries(names.map((name, i) => [name, row[i] ?? '']))),
  };
}

const number = (/** @type {string | undefined} */ text) => (text === undefined || text === '' ? null : Number(text));
const problemOf = (/** @type {Cells} */ row) => `${row.scenario} ${row.metric}`;
const settingOf = (/** @type {Cells} */ row) => `${problemOf(row)} ${row.method} ${row.setting} ${row.value}`;

/** The query that opens it as a live session. @param {Cells} row */
function linkOf({ scenario, set = '', seed, seeds }) {
  const sets = set.split(' ').map((pair) => {
    const at = pair.indexOf('=');
    return `&set=${encodeURIComponent(pair.slice(0, at))}:${encodeURIComponent(pair.slice(at + 1))}`;
  });
  return `?scenario=${scenario}${sets.join('')}${Number(seeds) > 1 ? `&seed=${seed}` : ''}`;
}

/** A setting of its lines, one for each cost. @param {Cells[]} lines @param {string[]} problems */
function settingRow(lines, problems) {
  const row = lines[0] ?? {},
    seeds = Number(row.seeds);
  return {
    problem: problems.indexOf(problemOf(row)),
    by: row.by,
    method: row.method,
    setting: row.setting,
    value: number(row.value),
    status: row.status,
    random: seeds > 1,
    error: [number(row.error), number(row.error_low), number(row.error_high)],
    costs: lines.map((line) => [number(line.cost_value), number(line.cost_low), number(line.cost_high)]),
    cpu_median_s: null,
    runs: seeds > 1 ? seeds : null,
    seed: Number(row.seed),
    seeds,
    front: lines.map((line) => line.front === 'true'),
    check: row.check_seeds
      ? {
          error: [number(row.check_error), null, number(row.check_error_high)],
          costs: lines.map((line) => [number(line.check_cost), null, null]),
          cpu_median_s: null,
          runs: null,
          seed: Number(row.check_seed),
          seeds: Number(row.check_seeds),
        }
      : null,
    set: row.set,
    link: linkOf(row),
  };
}

/** @param {Cells} row of the winners @param {string[]} problems @param {string[]} costs @param {string[]} settings
 * @param {ReturnType<typeof settingRow>[]} rows */
function choiceOf(row, problems, costs, settings, rows) {
  const place = (/** @type {number} */ at) => (at < 0 ? null : at),
    problem = problems.indexOf(problemOf(row)),
    cost = costs.indexOf(row.cost ?? ''),
    level = Number(row.level);
  /* of the method that was the cheapest in the check the winners have no setting */
  const within = rows
    .map((one, at) => ({ ...one, at }))
    .filter((one) => one.problem === problem && one.method === row.check_cheapest && (one.check?.error[2] ?? Infinity) <= level);
  within.sort((a, b) => (a.check?.costs[cost]?.[0] ?? Infinity) - (b.check?.costs[cost]?.[0] ?? Infinity));
  return {
    problem,
    cost,
    level,
    row: place(settings.indexOf(settingOf(row))),
    outcome: row.verdict,
    figures: row.figures,
    check_cheapest: within[0]?.at ?? null,
    as_cheap: row.as_cheap ? row.as_cheap.split(', ') : [],
  };
}

/** @param {string} name of the family @param {string} measured its file @param {string} winners that of all choices */
export function shippedRows(name, measured, winners) {
  const { head, rows: lines } = read(measured),
    unique = (/** @type {string[]} */ list) => [...new Set(list)];
  const problems = unique(lines.map(problemOf)),
    costs = unique(lines.map((line) => line.cost ?? '')),
    settings = unique(lines.map(settingOf)),
    rows = settings.map((one) =>
      settingRow(
        lines.filter((line) => settingOf(line) === one),
        problems,
      ),
    );
  return {
    name,
    machine: head.cpu,
    date: head.date,
    version: head.commit,
    rows,
    choices: read(winners)
      .rows.filter((row) => row.family === name)
      .map((row) => choiceOf(row, problems, costs, settings, rows)),
  };
}

/** @param {string} from folder of the results @param {string} to a folder of the page */
export function shipRows(from, to) {
  const winners = readFileSync(join(from, 'winners.csv'), 'utf8');
  mkdirSync(to, { recursive: true });
  for (const file of readdirSync(from).filter((one) => one.endsWith('.csv') && one !== 'winners.csv')) {
    const name = basename(file, '.csv');
    writeFileSync(join(to, `${name}.json`), `${JSON.stringify(shippedRows(name, readFileSync(join(from, file), 'utf8'), winners))}\n`);
  }
}
