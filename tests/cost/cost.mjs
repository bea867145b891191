// Counts the instructions that canonical runs execute, by valgrind, and those of their heaviest functions.
//   node tests/cost/cost.mjs [CASE]                 prints committed and present counts
//   node tests/cost/cost.mjs --update CASE "WHY"    commits the present counts of a case (all: every one)
import { readFileSync, writeFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { heaviest, judge, raised_silently } from './guard.mjs';
import { build, measure } from './profile.mjs';

/** Of a function: a change of less than this renews nothing. */
const KEPT = 0.005;

/**
 * @typedef {object} Case
 * @property {string} case
 * @property {string} program below the build folder
 * @property {string} arguments with {} for the length
 * @property {number} from length of the shorter run
 * @property {number} to of the longer one
 * @property {number} steps_per_unit of the length
 * @property {number} instructions_per_step committed
 * @property {string} why the count is what it is: the reason of its last change
 */
/** @typedef {import('./guard.mjs').FunctionCount & {case: string}} CaseFunction */

const TABLES = {
  'instructions.csv': ['case', 'program', 'arguments', 'from', 'to', 'steps_per_unit', 'instructions_per_step', 'why'],
  'functions.csv': ['case', 'function', 'counted', 'instructions_per_step', 'why'],
};
const NUMBERS = ['from', 'to', 'steps_per_unit', 'instructions_per_step'];
/** @typedef {keyof typeof TABLES} Table */

/** @param {Table} name */
export const path = (name) => fileURLToPath(new URL(name, import.meta.url));

/** @param {Table} name @returns {string} */
export const text_of = (name) => readFileSync(path(name), 'utf8');

/** @param {Table} name @param {string} text @returns {any[]} an object per row; the last column may have commas */
export function parse(name, text) {
  const columns = TABLES[name],
    [head, ...lines] = text.trimEnd().split('\n');
  if (head !== columns.join(',')) throw new Error(`${path(name)}: the columns must be ${columns.join(',')}`);
  return lines.map((line) => {
    const fields = line.split(','),
      values = [...fields.slice(0, columns.length - 1), fields.slice(columns.length - 1).join(',')];
    return Object.fromEntries(columns.map((column, i) => [column, NUMBERS.includes(column) ? Number(values[i]) : values[i]]));
  });
}

/** @param {Table} name @param {any[]} rows */
function write(name, rows) {
  const columns = TABLES[name],
    lines = rows.map((row) => columns.map((column) => row[column]).join(','));
  writeFileSync(path(name), `${[columns.join(','), ...lines].join('\n')}\n`);
}

/** @returns {Case[]} */
export const cases = () => parse('instructions.csv', text_of('instructions.csv'));
/** @returns {CaseFunction[]} */
export const functions = () => parse('functions.csv', text_of('functions.csv'));

/** @param {Table} name @param {any[]} rows @returns {Map<string, any>} by what does not change */
export const by_name = (name, rows) =>
  new Map(rows.map((row) => [name === 'functions.csv' ? `${row.case}, ${row.function} (${row.counted})` : row.case, row]));

/** @param {Case} c @param {CaseFunction[]} old of the case @param {import('./profile.mjs').Profile} now @param {string} why */
function renew(c, old, now, why) {
  const before = by_name('functions.csv', old),
    renewed = { ...c, instructions_per_step: now.total, why },
    rows = heaviest(now).map((f) => {
      const row = { case: c.case, function: f.function, counted: f.counted, instructions_per_step: f.count, why },
        then = before.get([...by_name('functions.csv', [row]).keys()][0]);
      return then && Math.abs(f.count / then.instructions_per_step - 1) <= KEPT ? then : row;
    }),
    silent = [
      ...raised_silently(by_name('instructions.csv', [c]), by_name('instructions.csv', [renewed])),
      ...raised_silently(before, by_name('functions.csv', rows)),
    ];
  if (silent.length) throw new Error(`a count that rises has a new reason:\n${silent.join('\n')}`);
  return { renewed, rows };
}

/** @param {Case} c @param {CaseFunction[]} old @param {import('./profile.mjs').Profile} now */
function print(c, old, now) {
  const { failures, notes } = judge(c, old, now),
    change = (/** @type {number} */ then, /** @type {number} */ count) => `(${(100 * (count / then - 1)).toFixed(2)} %)`;
  console.log(`${c.case}: ${c.instructions_per_step} committed, ${now.total} now ${change(c.instructions_per_step, now.total)}`);
  for (const f of old) {
    const count = now[f.counted].get(f.function) ?? 0;
    if (Math.abs(count / f.instructions_per_step - 1) > KEPT)
      console.log(
        `  ${f.function} (${f.counted}): ${f.instructions_per_step} committed, ${count} now ${change(f.instructions_per_step, count)}`,
      );
  }
  for (const text of failures) console.log(`  fails: ${text}`);
  for (const text of notes) console.log(`  note: ${text}`);
}

async function main() {
  const updates = process.argv[2] === '--update',
    [name, why] = process.argv.slice(updates ? 3 : 2);
  if (updates && !(name && why)) throw new Error('--update CASE "WHY": name the case, or all, and the reason');
  const all = cases();
  let counts = functions();
  if (name && name !== 'all' && !all.some((c) => c.case === name)) throw new Error(`${name}: no such case`);
  await build();
  for (const [i, c] of all.entries()) {
    if (name && name !== 'all' && name !== c.case) continue;
    const now = await measure(c),
      old = counts.filter((f) => f.case === c.case);
    print(c, old, now);
    if (!updates) continue;
    const { renewed, rows } = renew(c, old, now, why);
    all[i] = renewed;
    counts = all.flatMap((each) => (each.case === c.case ? rows : counts.filter((f) => f.case === each.case)));
  }
  if (!updates) return;
  write('instructions.csv', all);
  write('functions.csv', counts);
}

if (process.argv[1] === fileURLToPath(import.meta.url)) await main();
