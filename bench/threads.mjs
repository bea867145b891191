// Large worlds of rigid bodies stepped by one thread and by two: wall time, and whether the bits are the same.
import { join } from 'node:path';
import { build, digits, median, printTable, run, say, writeCsv } from './lib.mjs';

const quick = process.argv.includes('--quick');
const program = join(build, 'bench', 'rigid');
const [ROUNDS, STEPS] = quick ? [2, 30] : [6, 100];
const LEAST = 1.7;

/** More than 5,000 bodies, with the parameters of `bench/run rigid`. */
const scenes = [
  { name: 'pyramid of 5,050', scene: 'pyramid', args: ['size=100'] },
  { name: '22,000 boxes', scene: 'many_pyramids', args: ['size=400'] },
  { name: 'smash', scene: 'smash', args: [] },
  { name: 'spinner', scene: 'spinner', args: [] },
  { name: 'washer', scene: 'washer', args: [] },
];

const rows = [];
for (let round = 0; round < ROUNDS; round++)
  for (const { name, scene, args } of scenes) {
    const { bodies, one_ms, more_ms, ratio, same } = JSON.parse(await run(program, ['threads', scene, String(STEPS), '2', ...args]));
    rows.push({ scene: name, round, bodies, one_ms, two_ms: more_ms, ratio, same });
  }

const of = (name, column) => rows.filter((row) => row.scene === name).map((row) => row[column]);
const ratios = scenes.map(({ name }) => ({ name, ratio: median(of(name, 'ratio')), same: of(name, 'same').every(Boolean) }));
printTable(
  'A step by one thread and by two: wall time, ms',
  ratios.map(({ name, ratio, same }) => ({
    scene: name,
    bodies: String(of(name, 'bodies')[0]),
    one: digits(median(of(name, 'one_ms'))),
    two: digits(median(of(name, 'two_ms'))),
    ratio: digits(ratio),
    'same bits': String(same),
  })),
);
say('');
for (const { name, ratio, same } of ratios)
  say(
    `${name}: two threads at least ${LEAST} times one, same bits: ${digits(ratio)}, ${same}: ${ratio >= LEAST && same ? 'met' : 'MISSED'}`,
  );

writeCsv(
  'threads',
  `bench/run threads${quick ? ' --quick' : ''}`,
  {
    scene: "laglab's",
    round: 'from 0',
    bodies: 'in the world',
    one_ms: 'median wall time of a step by one thread',
    two_ms: 'by two threads, in turn with it',
    ratio: 'one_ms over two_ms',
    same: 'whether both worlds have the same hash at the end',
  },
  rows,
);
