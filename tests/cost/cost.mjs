// Counts the instructions that canonical runs execute, by valgrind: the same number each time, on a busy machine too. What starting costs
// cancels out: each run is made with two lengths, and the difference is divided by the steps between them.
//   node tests/cost/cost.mjs                        prints committed and present counts
//   node tests/cost/cost.mjs --update CASE "WHY"    commits the present count of a case (all: every one)
import { execFile } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { promisify } from 'node:util';

const TABLE = fileURLToPath(new URL('instructions.csv', import.meta.url)),
  BUILD = process.env.LAGLAB_BUILD ?? fileURLToPath(new URL('../../build', import.meta.url)),
  ROOT = fileURLToPath(new URL('../..', import.meta.url));
const COLUMNS = ['case', 'program', 'arguments', 'from', 'to', 'steps_per_unit', 'instructions_per_step', 'why'];
/** More than this above the committed count is a failure. */
export const RISE = 0.03;

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

/** @returns {Case[]} */
export function cases() {
  const [head, ...lines] = readFileSync(TABLE, 'utf8').trimEnd().split('\n');
  if (head !== COLUMNS.join(',')) throw new Error(`${TABLE}: the columns must be ${COLUMNS.join(',')}`);
  return lines.map((line) => {
    const fields = line.split(','),
      [name, program, args, from, to, steps, count] = fields;
    return {
      case: name,
      program,
      arguments: args,
      from: Number(from),
      to: Number(to),
      steps_per_unit: Number(steps),
      instructions_per_step: Number(count),
      why: fields.slice(7).join(','),
    };
  });
}

/** @param {string} program @param {string[]} args @returns {Promise<number>} instructions of a whole run */
async function instructions(program, args) {
  const { stderr } = await promisify(execFile)(
    'valgrind',
    ['--tool=cachegrind', '--cache-sim=no', '--cachegrind-out-file=/dev/null', `${BUILD}/${program}`, ...args],
    { cwd: ROOT, maxBuffer: 64 << 20 },
  );
  const refs = /I +refs: +([\d,]+)/.exec(stderr);
  if (!refs) throw new Error(`${program} ${args.join(' ')}: valgrind has no count: ${stderr.slice(-400)}`);
  return Number(refs[1].replaceAll(',', ''));
}

/** @param {Case} c @returns {Promise<number>} instructions per step, now */
export async function measure(c) {
  const args = (/** @type {number} */ length) => c.arguments.replace('{}', String(length)).split(' '),
    [short, long] = await Promise.all([c.from, c.to].map((length) => instructions(c.program, args(length))));
  return Math.round((long - short) / ((c.to - c.from) * c.steps_per_unit));
}

/** @param {Case[]} all */
function write(all) {
  const line = (/** @type {any} */ c) => COLUMNS.map((name) => c[name]).join(',');
  writeFileSync(TABLE, `${[COLUMNS.join(','), ...all.map(line)].join('\n')}\n`);
}

async function main() {
  const [option, name, why] = process.argv.slice(2),
    all = cases(),
    updates = option === '--update';
  if (updates && !(name && why)) throw new Error('--update CASE "WHY": name the case, or all, and the reason');
  for (const c of all) {
    if (updates && name !== 'all' && name !== c.case) continue;
    const now = await measure(c),
      then = c.instructions_per_step;
    console.log(`${c.case}: ${then} committed, ${now} now (${(100 * (now / then - 1)).toFixed(2)} %)`);
    if (updates) Object.assign(c, { instructions_per_step: now, why });
  }
  if (updates) write(all);
}

if (process.argv[1] === fileURLToPath(import.meta.url)) await main();
