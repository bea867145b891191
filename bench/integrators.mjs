// Work against precision: laglab's adaptive methods compared with those of GSL, SUNDIALS and Boost.Odeint on the reference problems.
import { existsSync, mkdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { workPrecision } from './integrators/plot.mjs';
import { build, digits, laglab, median, printTable, results, run, say, writeCsv } from './lib.mjs';

const quick = process.argv.includes('--quick');
const program = join(build, 'bench', 'integrators');
if (!existsSync(program))
  throw new Error('GSL or SUNDIALS is missing: apt-get install libgsl-dev libsundials-dev libboost-dev, or ./dev bench');

const libraries = ['laglab', 'GSL', 'SUNDIALS', 'Odeint'],
  others = libraries.slice(1);
const levels = [1e-4, 1e-6, 1e-8, 1e-10];

// ---- what is solved ----

/** Every method is exact, or the peers have no word for the jump. */
const left = ['free_fall', 'jerk', 'bouncing_ball', 'penalty_floor', 'coulomb', 'coulomb_naive'];
const names = (await run(laglab, ['problems']))
  .split('\n')
  .map((line) => line.split(/\s/)[0])
  .filter((name) => name && !left.includes(name));
const cases = names.flatMap((problem) =>
  problem === 'kepler'
    ? [
        { name: 'kepler e=0.6', problem },
        { name: 'kepler e=0.9', problem, duration: 20, set: ['e=0.9'] },
      ]
    : [{ name: problem, problem }],
);

async function table(command, args) {
  const [head, ...lines] = (await run(command, args.map(String))).trim().split('\n');
  return lines.map((line) => Object.fromEntries(line.split(',').map((value, i) => [head.split(',')[i], value])));
}
const rounds = quick ? 5 : 11,
  perDecade = quick ? 1 : 2;
const measure = ({ problem, duration = 0, set = [] }) => table(program, [problem, duration, rounds, perDecade, ...set]);

// ---- time at equal error ----

/** Of one method, from the largest tolerance to the one of the least error: what error is certain from there on, so that a
 * level that hits the solution by chance counts no more than its neighbours. */
function ladder(rungs) {
  const good = rungs
    .filter((rung) => rung.status === 'ok' && Number.isFinite(Number(rung.error)))
    .map((rung) => ({ error: Math.max(Number(rung.error), 1e-17), time: Number(rung.cpu_min_s) }));
  const least = good.findIndex((rung) => rung.error === Math.min(...good.map((other) => other.error)));
  const kept = good.slice(0, least + 1);
  return kept.map((rung, i) => ({ time: rung.time, error: Math.max(...kept.slice(i).map((other) => other.error)) }));
}

function ladders(rungs) {
  const of = new Map();
  for (const rung of rungs) of.set(`${rung.library} ${rung.method}`, [...(of.get(`${rung.library} ${rung.method}`) ?? []), rung]);
  return [...of.values()].map((list) => ({ library: list[0].library, method: list[0].method, rungs: ladder(list) }));
}

/** Interpolated between logarithms; undefined where the error is not reached. */
function timeAt(rungs, error) {
  const i = rungs.findIndex((rung) => rung.error <= error);
  if (i <= 0) return rungs[i]?.time;
  const [a, b] = [rungs[i - 1], rungs[i]];
  const part = Math.log(a.error / error) / Math.log(a.error / b.error);
  return a.time * (b.time / a.time) ** part;
}

function best(all, library, error) {
  return all
    .filter((of) => of.library === library)
    .map((of) => ({ method: of.method, time: timeAt(of.rungs, error) }))
    .filter((of) => of.time !== undefined)
    .sort((a, b) => a.time - b.time)[0];
}

/** Undefined where the peer does not get there, infinite where laglab alone does not. */
const ratio = (own, peer) => (peer ? (own?.time ?? Infinity) / peer.time : undefined);

function compare(name, all) {
  return levels.map((error) => {
    const [own, ...peers] = libraries.map((library) => best(all, library, error));
    const exact = best(
      all.filter((of) => of.method !== 'taylor'),
      'laglab',
      error,
    );
    const micro = (of) => of && Number((1e6 * of.time).toPrecision(4));
    const ratios = peers.map((peer) => ratio(own, peer));
    const reached = ratios.filter((value) => value !== undefined);
    return {
      problem: name,
      error,
      laglab_method: own?.method,
      laglab_us: micro(own),
      laglab_f_method: exact?.method,
      laglab_f_us: micro(exact),
      ...Object.fromEntries(
        others.flatMap((library, i) => [
          [`${library.toLowerCase()}_method`, peers[i]?.method],
          [`${library.toLowerCase()}_us`, micro(peers[i])],
        ]),
      ),
      ...Object.fromEntries(others.map((library, i) => [`of_${library.toLowerCase()}`, ratios[i]?.toPrecision(3)])),
      of_best: reached.length ? Math.max(...reached).toPrecision(3) : undefined,
    };
  });
}

// ---- plots: the methods that are the best of their library at one of the errors ----

function plot(name, rungs, rows) {
  const shown = libraries.flatMap((library) => {
    const column = `${library.toLowerCase()}_method`;
    return [...new Set(rows.map((row) => row[column]).filter(Boolean))].map((method) => ({ group: library, name: method }));
  });
  const lines = shown.map((line) => ({
    ...line,
    points: rungs
      .filter((rung) => rung.library === line.group && rung.method === line.name && rung.status === 'ok' && Number(rung.error) < 1)
      .map((rung) => ({ x: Math.max(Number(rung.error), 1e-17), y: Number(rung.cpu_min_s) })),
  }));
  writeFileSync(join(results, 'integrators', `${name.replaceAll(/\W+/g, '_')}.svg`), workPrecision({ title: name, lines }));
}

mkdirSync(join(results, 'integrators'), { recursive: true });
const rungs = [],
  rows = [];
for (const thing of cases) {
  const own = (await measure(thing)).map((rung) => ({ problem: thing.name, ...rung }));
  const compared = compare(thing.name, ladders(own));
  plot(thing.name, own, compared);
  rungs.push(...own);
  rows.push(...compared);
}

// ---- output ----

const values = (column, of = rows) =>
  of
    .map((row) => row[column])
    .filter((value) => value !== undefined)
    .map(Number);
const shown = (column, of) => {
  const all = values(column, of);
  return all.length ? `${digits(median(all))} (${digits(Math.max(...all))})` : '-';
};

printTable(
  "laglab's best time over a peer's best at equal error: median (worst) over errors of 1e-4, 1e-6, 1e-8 and 1e-10",
  cases.map(({ name }) => {
    const of = rows.filter((row) => row.problem === name);
    const methods = (column) => [...new Set(of.map((row) => row[column]).filter(Boolean))].join(', ') || '-';
    return {
      problem: name,
      ...Object.fromEntries(others.map((library) => [`over ${library}`, shown(`of_${library.toLowerCase()}`, of)])),
      'over the fastest': shown('of_best', of),
      ...Object.fromEntries(libraries.map((library) => [library, methods(`${library.toLowerCase()}_method`)])),
    };
  }),
);

const verdict = (met) => (met ? 'met' : 'MISSED');
say('');
for (const [peer, column] of [...others.map((library) => [library, `of_${library.toLowerCase()}`]), ['the fastest of them', 'of_best']]) {
  const all = values(column);
  if (!all.length) continue; // it is not there
  const worst = Math.max(...all),
    slower = rows.filter((row) => Number(row[column]) > 1);
  const where = rows.find((row) => Number(row[column]) === worst);
  say(
    `${peer}: at most 1 everywhere: worst ${digits(worst)} (${where.problem} at ${where.error}), ` +
      `above 1 in ${slower.length} of ${all.length}: ` +
      `${verdict(worst <= 1)}; at most 1/3 in the median: ${digits(median(all))}: ${verdict(median(all) <= 1 / 3)}`,
  );
}

for (const method of new Set(many.map((row) => row.method))) {
  const speed = Math.max(...many.filter((row) => row.method === method).map((row) => row.steps_per_s));
  say(`${method} of 1,024 oscillators: at least 500 million steps/s: ${digits(speed / 1e6)} million: ${verdict(speed >= 500e6)}`);
}

const command = `bench/run integrators${quick ? ' --quick' : ''}`;
writeCsv(
  'integrators',
  command,
  {
    problem: 'reference problem',
    error: 'relative, Euclidean, at the end; times are interpolated to it between logarithms',
    laglab_method: "the fastest of laglab's",
    laglab_us: 'its CPU time',
    laglab_f_method: 'the fastest of those that know a problem by f alone: without taylor',
    laglab_f_us: 'its CPU time',
    gsl_method: "the fastest of GSL's",
    gsl_us: 'its CPU time',
    sundials_method: "the fastest of SUNDIALS'",
    sundials_us: 'its CPU time',
    odeint_method: "the fastest of Odeint's",
    odeint_us: 'its CPU time',
    of_gsl: 'laglab_us / gsl_us; empty where GSL does not get there',
    of_sundials: 'laglab_us / sundials_us',
    of_odeint: 'laglab_us / odeint_us',
    of_best: 'the largest of them',
  },
  rows,
);
writeCsv(
  'integrators/rungs',
  command,
  {
    problem: 'reference problem',
    library: 'laglab, GSL, SUNDIALS or Odeint',
    method: 'its method',
    tolerance: 'relative; absolute the same, of stiff problems a thousandth of it',
    status: 'failed: not to the end within 100,000 steps',
    error: 'relative, Euclidean, at the end',
    cpu_min_s: 'least CPU time of the blocks of runs, per run',
    cpu_median_s: 'their median',
    runs: 'their number',
    steps: 'accepted',
    evaluations: 'of f',
    jacobians: 'calls of the Jacobian',
  },
  rungs,
);
