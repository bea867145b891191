// Large worlds of rigid bodies stepped by one thread and by two: wall time, whether the bits are the same, and Box2D 3 in the same run:
// laglab where bench/run --box2d DIR has built it.
import { existsSync, mkdirSync, writeFileSync } from 'node:fs';
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

const engines = [
  { engine: 'laglab', command: program, settings: ['substeps=4'] },
  { engine: 'Box2D 3 AVX2', command: join(build, 'bench', 'peers', 'box2d_3_avx2'), settings: [] },
].filter(({ command }) => existsSync(command));
const beside = engines.length > 1;

const folder = join(build, 'bench', 'scenes');
const file = (name) => join(folder, `threads_${name.replaceAll(/\W+/g, '_')}.json`);
if (beside) {
  mkdirSync(folder, { recursive: true });
  for (const { name, scene, args } of scenes) writeFileSync(file(name), await run(program, ['scene', scene, String(STEPS), ...args]));
}

/** Median wall time of a step, ms, of the scene as numbers. */
async function wall({ command, settings }, name, threads) {
  const text = await run(command, [file(name), String(STEPS), '60', 'wall=1', `threads=${threads}`, ...settings]);
  return JSON.parse(text.trim().split('\n').at(-1)).median_ms;
}

const rows = [],
  besides = [];
for (let round = 0; round < ROUNDS; round++)
  for (const { name, scene, args } of scenes) {
    const { bodies, one_ms, more_ms, ratio, same } = JSON.parse(await run(program, ['threads', scene, String(STEPS), '2', ...args]));
    rows.push({ scene: name, round, bodies, one_ms, two_ms: more_ms, ratio, same });
    for (const engine of beside ? engines : [])
      for (const threads of [1, 2])
        besides.push({ scene: name, round, engine: engine.engine, threads, step_ms: await wall(engine, name, threads) });
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

// ---- compared with Box2D 3 ----

const steps = (name, engine, threads) =>
  besides.filter((row) => row.scene === name && row.engine === engine && row.threads === threads).map((row) => row.step_ms);
const perRound = (above, below) => median(above.map((ms, round) => ms / below[round]));
const peer = engines[1]?.engine;
const pairs = (beside ? scenes : []).map(({ name }) => ({
  name,
  one: perRound(steps(name, 'laglab', 1), steps(name, peer, 1)),
  two: perRound(steps(name, 'laglab', 2), steps(name, peer, 2)),
  gain: perRound(steps(name, peer, 1), steps(name, peer, 2)),
}));
if (beside)
  printTable(
    `The same compared with ${peer}: wall time, ms; ratios are medians of the rounds`,
    pairs.map(({ name, one, two, gain }) => ({
      scene: name,
      'laglab 1': digits(median(steps(name, 'laglab', 1))),
      'Box2D 1': digits(median(steps(name, peer, 1))),
      'ratio 1': digits(one),
      'laglab 2': digits(median(steps(name, 'laglab', 2))),
      'Box2D 2': digits(median(steps(name, peer, 2))),
      'ratio 2': digits(two),
      'Box2D one over two': digits(gain),
    })),
  );
say('');
for (const { name, ratio, same } of ratios)
  say(
    `${name}: two threads at least ${LEAST} times one, same bits: ${digits(ratio)}, ${same}: ${ratio >= LEAST && same ? 'met' : 'MISSED'}`,
  );
for (const { name, two } of pairs)
  say(`${name}: two threads of laglab never slower than two of ${peer}: ${digits(two)}: ${two <= 1 ? 'met' : 'MISSED'}`);

const command = `bench/run threads${quick ? ' --quick' : ''}${beside ? ' --box2d DIR' : ''}`;
writeCsv(
  'threads',
  command,
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
if (beside)
  writeCsv(
    'threads/peer',
    command,
    {
      scene: "laglab's, as numbers",
      round: 'from 0',
      engine: 'laglab or a peer',
      threads: 'of the step',
      step_ms: 'median wall time of a step',
    },
    besides,
  );
