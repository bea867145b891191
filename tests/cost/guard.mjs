// Which counts of a run are too high: against those committed, and of the committed ones against those of the commit before.
import { execFileSync } from 'node:child_process';
import { basename, dirname } from 'node:path';
import { LIBRARY } from './profile.mjs';

/** More than this above the committed count is a failure. */
export const RISE = 0.03;
/** A function with this part of its case has a committed count. */
export const HEAVY = 0.02;
/** One with this part that has none is a failure: the loops have moved, and what is committed guards others. */
export const UNGUARDED = 0.08;
/** Less than this part of the case is no rise of a function. */
const SLACK = 0.0005;
/** Nor of one of a library: what copying takes depends on the alignment of the stack. */
const SLACK_OF_LIBRARY = 0.01;
/** With this part of the instructions of the compiled function its own lines need no count of their own. */
const SAME = 0.9;

/** @typedef {import('./profile.mjs').Profile} Profile */
/** @typedef {import('./profile.mjs').Counted} Counted */
/** @typedef {{instructions_per_step: number, why: string}} Committed */
/** @typedef {Committed & {function: string, counted: Counted}} FunctionCount */

/** @param {string} written `file:name` */
const name_of = (written) => written.slice(written.lastIndexOf(':') + 1);

/** @param {Profile} now @returns {{function: string, counted: Counted, count: number}[]} what has a committed count, by kind and weight */
export function heaviest(now) {
  const heavy = (/** @type {Counted} */ counted) =>
    [...now[counted]]
      .filter(([name, count]) => name !== `${LIBRARY}???` && count >= HEAVY * now.total)
      .sort((a, b) => b[1] - a[1] || (a[0] < b[0] ? -1 : 1))
      .map(([name, count]) => ({ function: name, counted, count }));
  const alike = (/** @type {{function: string, count: number}} */ f) =>
    f.count >= SAME * (now.compiled.get(name_of(f.function)) ?? Infinity);
  return [...heavy('compiled'), ...heavy('written').filter((f) => !alike(f))];
}

/** @param {string} name of a function */
const slack = (name) => (name.startsWith(LIBRARY) ? SLACK_OF_LIBRARY : SLACK);
const percent = (/** @type {number} */ part) => `${(100 * part).toFixed(2)} %`;

/**
 * @param {Committed} total @param {FunctionCount[]} functions committed @param {Profile} now
 * @returns {{failures: string[], notes: string[]}}
 */
export function judge(total, functions, now) {
  const failures = [],
    notes = [];
  const rise = (/** @type {string} */ name, /** @type {Committed} */ then, /** @type {number} */ count) =>
    `${name}: ${count} instructions per step, ${percent(count / then.instructions_per_step - 1)} above the ` +
    `${then.instructions_per_step} committed (${then.why})`;
  if (!(now.total <= total.instructions_per_step * (1 + RISE))) failures.push(rise('the whole', total, now.total));
  for (const f of functions) {
    const count = now[f.counted].get(f.function),
      name = `${f.function} (${f.counted})`;
    if (!count) notes.push(`${name} has gone: renamed, removed, or inlined where it was called; the whole is still counted`);
    else if (!(count <= f.instructions_per_step * (1 + RISE)) && !(count - f.instructions_per_step <= slack(f.function) * now.total))
      failures.push(rise(name, f, count));
  }
  for (const f of heaviest(now)) {
    if (functions.some((row) => row.function === f.function || row.function === name_of(f.function))) continue;
    const part = f.count / now.total,
      text = `${f.function} (${f.counted}) has ${percent(part)} of the case and no committed count`;
    if (part >= UNGUARDED) failures.push(text);
    else if (part >= 2 * HEAVY) notes.push(text);
  }
  return { failures, notes };
}

/**
 * Counts that rose while the reason in their row stayed.
 * @param {Map<string, Committed>} before @param {Map<string, Committed>} after by name @returns {string[]}
 */
export function raised_silently(before, after) {
  const found = [];
  for (const [name, now] of after) {
    const then = before.get(name);
    if (then && !(now.instructions_per_step <= then.instructions_per_step) && now.why === then.why)
      found.push(`${name}: ${then.instructions_per_step} was committed, now ${now.instructions_per_step}, and the reason is the same`);
  }
  return found;
}

/** For a git that works on the folder that it is given, as also inside of a hook. */
const OF_FOLDER = Object.fromEntries(Object.entries(process.env).filter(([name]) => !name.startsWith('GIT_')));

/** What git prints in a folder. @param {string} folder @returns {(...args: string[]) => string} */
export const git_in =
  (folder) =>
  (...args) =>
    execFileSync('git', ['-C', folder, ...args], { encoding: 'utf8', env: OF_FOLDER, stdio: ['ignore', 'pipe', 'ignore'] });

/**
 * @param {string} file with its folder @param {string} text of it now @param {(...args: string[]) => string} [git]
 * @returns {string | null} as it was committed before: at HEAD, or before its last commit where it has not changed since; null without
 */
export function text_before(file, text, git = git_in(dirname(file))) {
  const name = basename(file);
  try {
    const newest = git('show', `HEAD:./${name}`);
    return newest === text ? git('show', `${git('rev-list', '-1', 'HEAD', '--', name).trim()}^:./${name}`) : newest;
  } catch {
    return null; // no git, no history, or a file that is new
  }
}
