// What the logs of ./dev test say (tests/stages.sh runs the stages):
//   node tests/stages.mjs count KIND LOG STATUS       one line for a stage that has ended; 1 where it failed
//   node tests/stages.mjs report ROWS [--record]      the table of all stages; 1 where one failed; --record renews tests/stages.csv
// A row of ROWS is: stage, kind, log, exit status, seconds, between tabs. Kinds: `ctest`, which writes JUnit's .xml, too; `node`,
// with the spec reporter's lines; `one`, a command that is itself the check. What cannot be run returns 77 after a line with the reason.
import { existsSync, readFileSync, writeFileSync } from 'node:fs';
import process, { argv } from 'node:process';
import { fileURLToPath } from 'node:url';

const COMMITTED = 'tests/stages.csv';
const NOT_RUN = 77;

/** @typedef {{passed: number, failed: string[], skipped: string[]}} Count names of what failed; names and reasons of what was skipped */

const plain = (text) => text.replace(/&(lt|gt|quot|apos|amp);/g, (_, name) => ({ lt: '<', gt: '>', quot: '"', apos: "'", amp: '&' })[name]);
const lastLine = (text) => text.trim().split('\n').at(-1).trim();

/** A program of cmocka has a check for each of its tests, another one is one check. @param {string} xml @returns {Count} */
function ofCtest(xml) {
  const count = { passed: 0, failed: [], skipped: [] };
  for (const [, name, status, body] of xml.matchAll(/<testcase name="([^"]*)"[^>]* status="(\w+)">([\s\S]*?)<\/testcase>/g)) {
    const output = plain(/<system-out>([\s\S]*?)<\/system-out>/.exec(body)?.[1] ?? '');
    const lines = output.split('\n');
    const inside = (mark) => [
      ...new Set(lines.filter((line) => new RegExp(`^\\[ *${mark} *\\] \\w+$`).test(line)).map((line) => line.split('] ')[1])),
    ];
    if (/<skipped message="SKIP_/.test(body)) count.skipped.push(`${name}: ${lastLine(output)}`);
    else if (status !== 'run') count.failed.push([name, ...inside('FAILED')].join(' '));
    for (const test of inside('SKIPPED')) count.skipped.push(`${name} ${test}`);
    if (status === 'run') count.passed += inside('OK').length || 1;
    else count.passed += inside('OK').length;
  }
  return count;
}

/** @param {string} log of the spec reporter @returns {Count} */
function ofNode(log) {
  const last = {};
  for (const [, what, number] of log.matchAll(/^\S+ (pass|fail|cancelled|skipped|todo) (\d+)$/gm)) last[what] = Number(number);
  const marked = log.matchAll(/^\s*✖ (.+) \([\d.]+ms\)|^(tests\/\S+: (?:has no test|ended with .*))$/gm);
  const names = new Set([...marked].map((match) => match[1] ?? match[2]));
  const place = new Map([...log.matchAll(/^test at (\S+)\n✖ (.+) \([\d.]+ms\)/gm)].map(([, where, name]) => [name, `${where} ${name}`]));
  const failed = [...names].map((name) => place.get(name) ?? name);
  const skipped = [...log.matchAll(/^\s*﹣ (.+) \([\d.]+ms\) # (.+)$/gm)].map((match) => `${match[1]}: ${match[2]}`);
  const wrong = (last.fail ?? 0) + (last.cancelled ?? 0);
  return {
    passed: last.pass ?? 0,
    failed: [...failed, ...Array(Math.max(0, wrong - failed.length)).fill('a test without a name')],
    skipped: [...skipped, ...Array(Math.max(0, (last.skipped ?? 0) + (last.todo ?? 0) - skipped.length)).fill('a test without a reason')],
  };
}

/** What a stage has checked. One that failed without a test that did, or that has no test, is itself what failed.
 * @param {string} kind @param {string} log a file @param {number} status @returns {Count} */
export function count(kind, log, status) {
  const text = existsSync(log) ? readFileSync(log, 'utf8') : '';
  if (status === NOT_RUN && kind !== 'ctest') return { passed: 0, failed: [], skipped: [lastLine(text) || 'without a reason'] };
  if (kind === 'one') return { passed: status === 0 ? 1 : 0, failed: status === 0 ? [] : [`exit status ${status}`], skipped: [] };
  const xml = log.replace(/\.log$/, '.xml');
  const counted = kind === 'node' ? ofNode(text) : ofCtest(existsSync(xml) ? readFileSync(xml, 'utf8') : '');
  if (counted.failed.length === 0 && status !== 0) counted.failed.push(`exit status ${status}`);
  if (counted.failed.length === 0 && counted.passed + counted.skipped.length === 0) counted.failed.push('no test was found');
  return counted;
}

const sum = (counts, member) => counts.reduce((total, one) => total + (member === 'passed' ? one.passed : one[member].length), 0);
const closing = (passed, failed, skipped) => `${passed} passed, ${failed} failed` + (skipped > 0 ? `, ${skipped} skipped` : '');

/** @param {string} text of tests/stages.csv @returns {Map<string, {seconds: number, checks: number}>} */
export const readCommitted = (text) =>
  new Map(
    text
      .trim()
      .split('\n')
      .slice(1)
      .map((line) => line.split(','))
      .map(([stage, seconds, checks]) => [stage, { seconds: Number(seconds), checks: Number(checks) }]),
  );

/** Lines on what has become slower by a quarter and 10 s, and on checks that have gone.
 * @param {{name: string, seconds: number, checks: number}[]} rows @param {ReturnType<typeof readCommitted>} committed */
export const compare = (rows, committed) =>
  rows.flatMap(({ name, seconds, checks }) => {
    const was = committed.get(name);
    if (!was) return [];
    return [
      ...(seconds > was.seconds * 1.25 && seconds > was.seconds + 10 ? [`${name}: ${seconds} s, ${was.seconds} s in ${COMMITTED}`] : []),
      ...(checks < was.checks ? [`${name}: ${checks} checks, ${was.checks} in ${COMMITTED}`] : []),
    ];
  });

function report(file, record) {
  const rows = readFileSync(file, 'utf8')
    .trimEnd()
    .split('\n')
    .filter((line) => line)
    .map((line) => line.split('\t'))
    .map(([name, kind, log, status, seconds]) => ({ name, log, seconds: Number(seconds), count: count(kind, log, Number(status)) }))
    .map((row) => ({ ...row, checks: row.count.passed + row.count.failed.length + row.count.skipped.length }));
  const committed = existsSync(COMMITTED) ? readCommitted(readFileSync(COMMITTED, 'utf8')) : new Map();
  const order = [...committed.keys()];
  const place = (row) => (order.includes(row.name) ? order.indexOf(row.name) : order.length);
  rows.sort((a, b) => place(a) - place(b));
  const list = (title, lines) => lines.length > 0 && console.log(`\n== ${title}\n${lines.join('\n')}`);
  list(
    'Stages',
    [
      ['stage', 'passed', 'failed', 'skipped', 'seconds'],
      ...rows.map(({ name, seconds, count: { passed, failed, skipped } }) => [name, passed, failed.length, skipped.length, seconds]),
    ].map(([name, ...numbers]) => String(name).padEnd(32) + numbers.map((number) => String(number).padStart(8)).join('')),
  );
  list('More seconds or fewer checks than committed', compare(rows, committed));
  list(
    'Skipped',
    rows.flatMap(({ name, count: { skipped } }) => skipped.map((reason) => `${name}: ${reason}`)),
  );
  list(
    'Failed',
    rows.flatMap(({ name, log, count: { failed } }) => failed.map((test) => `${name}: ${test} (${log})`)),
  );
  const counts = rows.map((row) => row.count);
  const failed = sum(counts, 'failed');
  if (record && failed === 0) {
    for (const { name, seconds, checks } of rows) committed.set(name, { seconds, checks });
    const lines = [...committed].map(([name, row]) => `${name},${row.seconds},${row.checks}\n`);
    writeFileSync(COMMITTED, `stage,seconds,checks\n${lines.join('')}`);
  }
  console.log(`\n${closing(sum(counts, 'passed'), failed, sum(counts, 'skipped'))}`);
  return failed === 0 && rows.length > 0 ? 0 : 1;
}

if (argv[1] === fileURLToPath(import.meta.url)) {
  const [verb, ...args] = argv.slice(2);
  if (verb === 'count') {
    const { passed, failed, skipped } = count(args[0], args[1], Number(args[2]));
    console.log(closing(passed, failed.length, skipped.length));
    process.exitCode = failed.length === 0 ? 0 : 1;
  } else process.exitCode = report(args[0], args[1] === '--record');
}
