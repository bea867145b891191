// The adviser compared with brute force over whole grids: extra cost of its advice over the cheapest setting that holds, and whether the
// advice holds on 200 seeds that no search has seen.
import { bruteForce, ask, judge, limitOf, seeded } from './advise/judge.mjs';
import { grids } from './advise/cases.mjs';
import { digits, laglab, median, printTable, say, writeCsv } from './lib.mjs';

const quick = process.argv.includes('--quick');
/** A part of the cases' names: nothing is written. */
const only = process.argv.find((option) => option.startsWith('--only='))?.slice('--only='.length) ?? '';
const SEEDS = 200; // of brute force at every setting
const searches = quick ? 1 : 5; // of each noisy case, from other seeds
const JOBS = 2; // searches, and threads of brute force, at a time
const GOAL_PCT = 2;

const round = (value) => (Number.isFinite(value) ? Number(value.toPrecision(6)) : value === Infinity ? 'none' : '');
/** @type {Record<string, any>[]} */
const rows = [];
const from = Date.now();
const since = (/** @type {number} */ start) => `${((Date.now() - start) / 1000).toFixed(1)} s`;

/** `work` of each of `things`, a few at a time; the results in their order. */
async function each(things, work) {
  const made = new Array(things.length);
  let next = 0;
  await Promise.all(
    Array.from({ length: JOBS }, async () => {
      while (next < things.length) {
        const i = next++;
        made[i] = await work(things[i]);
      }
    }),
  );
  return made;
}

const chosen = grids.filter((g) => (!quick || g.sample) && g.name.includes(only));
for (const [at, grid] of chosen.entries()) {
  const begun = Date.now(),
    noisy = grid.experiment.repeats > 1;
  const truth = await bruteForce(laglab, grid.experiment, SEEDS, {
    jobs: JOBS,
    event: grid.event,
    limits: grid.limits.filter((limit) => typeof limit === 'number'),
  });
  const forced = since(begun),
    asked = Date.now();
  const orders = grid.limits.flatMap((one) =>
    Array.from({ length: noisy ? searches : 1 }, (_, search) => ({ limit: limitOf(one, truth), search })),
  );
  const answers = await each(orders, async ({ limit, search }) =>
    JSON.parse(await ask(laglab, ['advise', '-', '--max-error', String(limit)], seeded(grid.experiment, 1 + 1000 * search))),
  );
  const told = [];
  for (const [i, { limit, search }] of orders.entries()) {
    const answer = answers[i];
    if (answer.advice) await truth.complete(answer.advice.point);
    const found = judge(answer, truth, limit);
    told.push(`${round(limit)}: ${round(100 * found.regret)} %${found.broken ? ', broken' : ''}`);
    rows.push({
      kind: grid.kind,
      case: grid.name,
      limit: round(limit),
      what: grid.what.join('; '),
      settings: truth.length,
      failing: truth.filter((p) => p.failed).length,
      search,
      least_cost: round(found.best),
      cost: found.advised ? round(found.advised.cost) : 'none',
      regret_pct: round(100 * found.regret),
      regret_mean_pct: round(100 * found.regret_possible),
      error: found.advised ? round(found.advised.error) : '',
      error_half: found.advised ? round(found.advised.half) : '',
      broken: Number(found.broken),
      untied: Number(found.untied),
      optimum: answer.optimum,
      runs: answer.runs,
      of_runs: answer.of_runs,
    });
  }
  console.log(
    `${at + 1} of ${chosen.length}, ${grid.kind}, ${grid.name}: ` +
      `brute force ${forced}, searches ${since(asked)}; regret at ${told.join('; ')}`,
  );
}

/** Of one case: all its searches. */
const cases = [
  ...rows.reduce((map, r) => map.set(`${r.case}, ${r.limit}`, [...(map.get(`${r.case}, ${r.limit}`) ?? []), r]), new Map()).values(),
];
const regrets = (of) => of.map((r) => (r.regret_pct === 'none' ? Infinity : r.regret_pct));
const told = (value) => (Number.isFinite(value) ? digits(value) : 'missed');
const table = cases.map((of) => ({
  kind: of[0].kind,
  case: of[0].case,
  limit: digits(of[0].limit),
  settings: of[0].settings,
  'regret %': told(median(regrets(of))),
  worst: told(Math.max(...regrets(of))),
  broken: `${of.filter((r) => r.broken).length}/${of.filter((r) => r.cost !== 'none').length}`,
  proven: `${of.filter((r) => r.optimum === 'proven').length}/${of.length}`,
  runs: `${of[0].runs}/${of[0].of_runs}`,
}));
printTable(`the adviser and brute force: ${cases.length} cases`, table);
say('');
for (const kind of ['motion', 'rigid', 'fluid', 'netgame', '']) {
  const these = cases.filter((of) => !kind || of[0].kind === kind),
    all = these.flat(),
    advised = all.filter((r) => r.cost !== 'none');
  const good = these.filter((of) => median(regrets(of)) <= GOAL_PCT).length,
    well = regrets(all).filter((r) => r <= GOAL_PCT).length,
    broken = advised.filter((r) => r.broken).length;
  const none = all.filter((r) => r.least_cost === 'none'),
    falsely = all.filter((r) => r.optimum === 'proven' && !(r.regret_pct <= GOAL_PCT)).length;
  if (these.length)
    say(
      `${kind || 'all'}: regret at most ${GOAL_PCT} % in ${good} of ${these.length} cases, ${well} of ${all.length} searches; ` +
        `limits broken on ${SEEDS} fresh seeds: ${broken} of ${advised.length} ` +
        `(at most 5 %: ${broken <= 0.05 * advised.length ? 'met' : 'MISSED'}); ` +
        `nothing holds in ${none.length}, reported in ${none.filter((r) => r.cost === 'none').length}; ` +
        `proven, but another is cheaper: ${falsely}`,
    );
}
say(`made in ${Math.round((Date.now() - from) / 1000)} s`);
if (!only)
  writeCsv(
    'advise',
    `bench/run advise${quick ? ' --quick' : ''}`,
    {
      kind: '',
      case: '',
      limit: 'of the mean error',
      what: '',
      settings: 'of the grid',
      failing: 'of them with a failed run or without the metric',
      search: 'by number: each from other seeds',
      least_cost: `of the settings whose error's upper 95 % bound over ${SEEDS} seeds is within the limit`,
      cost: 'of the advice, over the same seeds',
      regret_pct: '',
      regret_mean_pct: 'against settings whose mean is within the limit, however uncertain',
      error: 'of the advice, over the same seeds',
      error_half: 'of its 95 % interval',
      broken: '1: that error is above the limit, or a run failed',
      untied: '1: as cheap a setting with less error holds',
      optimum: 'as the adviser says',
      runs: 'that it made',
      of_runs: 'of the whole grid with its repeats',
    },
    rows,
  );
