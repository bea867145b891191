// `laglab tradeoff`: its rows equal to runs, its choices to its rows, its files, and what it refuses.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { readLink } from '../../www/js/base/link.js';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
const BINARY = path.resolve(process.env.LAGLAB_BIN ?? path.join(ROOT, 'build/laglab'));

/** @type {string} */
let folder;
before(() => {
  folder = mkdtempSync(path.join(tmpdir(), 'laglab-tradeoff-'));
});
after(() => rmSync(folder, { recursive: true, force: true }));

/** @param {string[]} args */
const laglab = (args) => spawnSync(BINARY, args, { cwd: folder, encoding: 'utf8', maxBuffer: 1 << 28, timeout: 600000 });

/** @param {string[]} args */
function good(args) {
  const { status, stdout, stderr } = laglab(args);
  assert.equal(status, 0, `laglab ${args.join(' ')}: ${stderr}`);
  return stdout;
}

/** @param {string[]} args @param {string[]} words */
function refused(args, words) {
  const { status, stdout, stderr } = laglab(args);
  assert.deepEqual([status, stdout], [2, ''], args.join(' '));
  for (const word of words) assert.ok(stderr.includes(word), `${args.join(' ')}: ${stderr}`);
}

const at = (/** @type {any} */ object, /** @type {string} */ where) => where.split('.').reduce((part, name) => part?.[name], object);
const read = (/** @type {string} */ name) => readFileSync(path.join(folder, name), 'utf8');

/** Mean of the error, and of a cost, over runs with seeds from `first` on.
 * @param {any} row @param {number | null} first @param {number} count */
function byRuns(row, first, count) {
  const runs = Array.from({ length: count }, (_, i) =>
    JSON.parse(
      good([
        'run',
        row.scenario,
        ...row.set.split(' ').flatMap((/** @type {string} */ pair) => ['--set', pair]),
        ...(first === null ? [] : ['--seed', String(first + i)]),
      ]),
    ),
  );
  const mean = (/** @type {(run: any) => number} */ of) => runs.reduce((sum, run) => sum + Math.abs(of(run)), 0) / count;
  return {
    error: mean((run) => at(run.metrics, row.metric)),
    cost: mean((run) => at(row.cost.startsWith('cost.') ? run : run.metrics, row.cost)),
  };
}

const near = (/** @type {number} */ a, /** @type {number} */ b) => Math.abs(a - b) <= 1e-9 * Math.max(Math.abs(a), Math.abs(b));

test('rows of a netgame are the means of runs with the seeds that they name, the check has other seeds', () => {
  const rows = JSON.parse(
    good([
      'tradeoff',
      'synchronisation',
      '--methods',
      'bucket',
      '--duration',
      '4',
      '--seeds',
      '10',
      '--check-seeds',
      '11',
      '--format',
      'json',
    ]),
  );
  assert.equal(rows.length, 5 * 4, 'five delays, four costs');
  for (const row of rows) {
    assert.deepEqual([row.seed, row.seeds, row.check_seed, row.check_seeds], [1, 10, 11, 11]);
    assert.ok(row.error_low < row.error && row.error < row.error_high && row.cpu_min_s > 0 && row.cpu_min_s <= row.cpu_median_s);
  }
  const row = rows.find((/** @type {any} */ r) => r.value === 100 && r.cost === 'players.0.bandwidth.down_bytes_per_s'),
    measured = byRuns(row, row.seed, row.seeds),
    again = byRuns(row, row.check_seed, row.check_seeds);
  assert.ok(near(row.error, measured.error) && near(row.cost_value, measured.cost), JSON.stringify([row, measured]));
  assert.ok(near(row.check_error, again.error) && near(row.check_cost, again.cost), JSON.stringify([row, again]));
});

test('rows without randomness equal one run: solvers with their memory, integrators with their evaluations', () => {
  const of = (/** @type {string[]} */ ...args) =>
    JSON.parse(good(['tradeoff', ...args, '--duration', '0.2', '--check-seeds', '0', '--format', 'json']));
  const rows = [
    ...of('contact_solvers', '--methods', 'xpbd').filter((/** @type {any} */ r) => r.value === 4 && r.cost === 'passes_per_s'),
    ...of('pressure_solvers', '--methods', 'multigrid').filter((/** @type {any} */ r) => r.value === 4 && r.cost === 'cost.block_bytes'),
    ...of('integrators', '--methods', 'dopri5').filter(
      (/** @type {any} */ r) => Math.abs(r.value - 1e-6) < 1e-9 && r.cost === 'methods.0.evaluations',
    ),
  ];
  assert.deepEqual(
    rows.map((row) => row.scenario),
    ['rigid/column', 'rigid/pyramid', 'fluid/cavity', 'motion/orbit', 'motion/stiff_reaction'],
  );
  for (const row of rows) {
    const { error, cost } = byRuns(row, null, 1);
    assert.ok(near(row.error, error) && near(row.cost_value, cost), JSON.stringify([row, error, cost]));
    assert.deepEqual([row.error_low, row.error_high, row.seeds, row.check_seeds, row.check_error], [row.error, row.error, 1, null, null]);
    const link = readLink(new URL(row.link).search, '');
    assert.deepEqual(link.problems, []);
    const set = Object.fromEntries(
      row.set.split(' ').map((/** @type {string} */ pair) => [pair.split('=')[0], pair.slice(pair.indexOf('=') + 1)]),
    );
    assert.deepEqual(Object.keys(link.set), Object.keys(set));
    for (const [name, value] of Object.entries(link.set))
      assert.deepEqual(value, typeof value === 'string' ? set[name] : JSON.parse(set[name]));
  }
});

test('choices follow from the rows; page and tables have them all', () => {
  const text = good([
    ...['tradeoff', 'lag_compensation', '--duration', '8', '--seeds', '10', '--check-seeds', '10'],
    ...['--out', 'rows.ndjson', '--winners', 'winners.ndjson', '--report', 'page.html', '--page', 'http://lab/'],
  ]);
  const lines = (/** @type {string} */ name) =>
    read(name)
      .trim()
      .split('\n')
      .map((line) => JSON.parse(line)); // prettier-ignore
  const rows = lines('rows.ndjson'),
    winners = lines('winners.ndjson');
  assert.equal(text.trim().split('\n').length, winners.length);
  assert.equal(winners.length, 4 * new Set(winners.map((w) => w.level)).size);
  assert.deepEqual([...new Set(rows.map((row) => row.method))].sort(), ['client_authoritative', 'hybrid', 'none', 'rewind', 'victim_veto']);
  for (const w of winners) {
    const within = rows.filter(
        (row) => row.cost === w.cost && row.cost_value !== null && row.error_high !== null && row.error_high <= w.level,
      ),
      least = Math.min(...within.map((row) => row.cost_value));
    assert.equal(w.cost_value, least, JSON.stringify(w));
    const same = (/** @type {any} */ row) => row.method === w.method && row.setting === w.setting && row.value === w.value;
    assert.ok(within.some((row) => same(row) && row.error === w.error && row.link === w.link));
    const inCheck = w.check_error_high !== null && w.check_error_high <= w.level;
    if (!inCheck) assert.equal(w.verdict, 'does not hold');
    assert.ok(['holds', 'does not hold'].includes(w.verdict) && w.figures.length > 0);
    assert.ok(w.link.startsWith('http://lab/?scenario=behind_cover&set=') && w.link.endsWith('&seed=1'));
  }
  for (const row of rows) {
    const better = (/** @type {any} */ r) =>
      r.cost_value <= row.cost_value && r.error <= row.error && (r.cost_value < row.cost_value || r.error < row.error);
    assert.equal(row.front, !rows.some((r) => r.cost === row.cost && better(r)), JSON.stringify(row));
  }
  const page = read('page.html'),
    { kind, command, address, families } = JSON.parse(/id="head">([^<]*)</.exec(page)[1]),
    [family] = families;
  assert.doesNotMatch(page, /<link|src=|url\(|import\b/);
  assert.deepEqual([kind, command, address], ['tradeoff', 'laglab tradeoff lag_compensation', 'http://lab/']);
  const cost = (/** @type {number} */ c) => family.costs[c].path;
  assert.deepEqual(
    family.rows.flatMap((/** @type {any} */ row) =>
      row.costs.map(([value, low, high], c) => [
        ...[row.method, row.setting, row.value, cost(c), value, low, high, ...row.error],
        ...[row.front[c], address + row.link],
      ]),
    ),
    rows.map((row) => [
      ...[row.method, row.setting, row.value, row.cost, row.cost_value, row.cost_low, row.cost_high],
      ...[row.error, row.error_low, row.error_high, row.front, row.link],
    ]),
  );
  assert.deepEqual(
    family.choices.map((/** @type {any} */ choice) => [
      ...[cost(choice.cost), choice.level, family.rows[choice.row].method, family.rows[choice.row].value],
      ...[choice.outcome, choice.figures, choice.as_cheap.join(', ')],
    ]),
    winners.map((w) => [w.cost, w.level, w.method, w.value, w.verdict, w.figures, w.as_cheap]),
  );
});

test('what it cannot do is refused with field and range', () => {
  refused(['tradeoff', 'magic'], ['FAMILY', 'integrators', 'lag_compensation', 'magic']);
  refused(['tradeoff', 'oceans', 'oceans'], ['FAMILY', 'duplicate oceans']);
  refused(['tradeoff', 'oceans', '--seeds', '9'], ['--seeds', '10', '1000', '9']);
  refused(['tradeoff', 'oceans', '--check-seeds', '5'], ['--check-seeds', '10', '1000', '5']);
  refused(['tradeoff', 'oceans', '--duration', '-1'], ['--duration', 'above 0', '-1']);
  refused(['tradeoff', 'oceans', '--methods', 'magic'], ['--methods', 'oceans', 'magic']);
  refused(['tradeoff', 'oceans', '--format', 'xml'], ['--format', 'csv', 'xml']);
});
