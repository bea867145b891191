// Large fluids stepped by one thread and by two: wall time, and whether the bits are the same.
import { join } from 'node:path';
import { build, digits, median, printTable, run, say, writeCsv } from './lib.mjs';

const quick = process.argv.includes('--quick');
const program = join(build, 'bench', 'fluid_threads');
const [ROUNDS, STEPS] = quick ? [2, 10] : [6, 30];

const cases = [
  { name: 'smoke, 256 x 256', scene: 'cylinder', rows: ['params.n=256'] },
  { name: 'smoke, 512 x 512', scene: 'cylinder', rows: ['params.n=512'] },
  { name: 'cavity, 512 x 512', scene: 'cavity', rows: ['params.n=512'] },
  { name: '10,000 particles, pbf', scene: 'pool', rows: ['params.size=400'] },
  { name: '62,500 particles, pbf', scene: 'pool', rows: ['params.size=1000'] },
  { name: '20,000 particles, dfsph', scene: 'dam_break', rows: ['params.size=100', 'solver.method=dfsph'] },
  { name: '20,000 particles, wcsph', scene: 'dam_break', rows: ['params.size=100'] },
];

const rows = [];
for (let round = 0; round < ROUNDS; round++)
  for (const { name, scene, rows: settings } of cases) {
    const { mib, one_ms, more_ms, ratio, same } = JSON.parse(await run(program, [scene, '2', String(STEPS), ...settings]));
    rows.push({ case: name, round, mib, one_ms, two_ms: more_ms, ratio, same });
  }

const of = (name, column) => rows.filter((row) => row.case === name).map((row) => row[column]);
printTable(
  'A step of 1/60 s by one thread and by two: wall time, ms',
  cases.map(({ name }) => ({
    case: name,
    one: digits(median(of(name, 'one_ms'))),
    two: digits(median(of(name, 'two_ms'))),
    ratio: digits(median(of(name, 'ratio'))),
    'same bits': String(of(name, 'same').every(Boolean)),
  })),
);
say('');
say(`the same bits by two threads: ${rows.every((row) => row.same) ? 'met' : 'MISSED'}`);

writeCsv(
  'fluid_threads',
  `bench/run fluid_threads${quick ? ' --quick' : ''}`,
  {
    case: 'scene and size',
    round: 'from 0',
    mib: 'of the block',
    one_ms: 'median wall time of a step by one thread',
    two_ms: 'by two threads, in turn with it',
    ratio: 'one_ms over two_ms',
    same: 'whether both have the same hash at the end',
  },
  rows,
);
