// Rigid bodies: laglab compared with Box2D, Chipmunk, Rapier, Planck and Matter on the same scenes.
import { existsSync, mkdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { workPrecision } from './integrators/plot.mjs';
import { build, digits, interleave, median, printTable, results, root, run, say, writeCsv } from './lib.mjs';

const quick = process.argv.includes('--quick');
const program = join(build, 'bench', 'rigid'),
  peers = join(build, 'bench', 'peers'),
  folder = join(build, 'bench', 'scenes');
const script = (name) => join(root, 'bench', 'peers', 'rigid', `${name}.mjs`);

// ---- who ----

/** `settings` as the engine reads them; `missing`: scenes that it has no word for. */
const engine = (name, command, settings = [], missing = []) => ({ name, command, settings, missing });
const compiled = (name, file, settings) => (existsSync(join(peers, file)) ? [engine(name, [join(peers, file)], settings)] : []);
const node = (name, file, settings, missing) => engine(name, ['node', script(file)], settings, missing);
const noHinges = ['spinner', 'rain'];

/** The first is the yardstick: as many substeps as Box2D 3. Those that it is held to make all steps of all rounds. */
const held = ['laglab', 'laglab SSE2', 'Box2D 3 SSE2', 'Box2D 3 AVX2'];
const engines = [
  engine('laglab', [program], ['substeps=4']),
  engine('laglab SSE2', [program], ['substeps=4', 'simd=2']),
  engine('laglab standard', [program]),
  ...compiled('Box2D 3 SSE2', 'box2d_3_sse2'),
  ...compiled('Box2D 3 AVX2', 'box2d_3_avx2'),
  ...compiled('Box2D 2.4', 'box2d_2'),
  ...compiled('Chipmunk', 'chipmunk'),
  node('Rapier', 'rapier'),
  node('Rapier SIMD', 'rapier', ['simd=1']),
  node('Planck', 'planck'),
  node('Matter', 'matter', [], noHinges),
];

// ---- what ----

const scene = (name, of, args, steps) => ({ name, of, args, steps });
const speedScenes = [
  scene('pyramid of 210', 'pyramid', ['size=20'], 600),
  scene('pyramid of 820', 'pyramid', ['size=40'], 600),
  scene('pyramid of 5,050', 'pyramid', ['size=100'], 300),
  scene('22,000 boxes', 'many_pyramids', ['size=400'], 60),
  scene('joint grid', 'joint_grid', ['size=100'], 200),
  scene('smash', 'smash', [], 200),
  scene('spinner', 'spinner', [], 200),
  scene('tumbler', 'tumbler', [], 500),
  scene('washer', 'washer', [], 200),
  scene('rain', 'rain', ['size=1000'], 500),
];

/** Hard cases, 10 s; `ideal` is where the topmost body's centre should be at the end. */
const hard = (name, of, args, ideal) => ({ ...scene(name, of, args, 600), ideal });
const hardScenes = [
  hard('column of 20', 'column', ['size=20'], 19.5),
  hard('column of 20, +-1 cm, dropped', 'column', ['size=20', 'offset=0.01'], 19.5),
  hard('column of 10, top 100:1', 'column', ['size=10', 'ratio=100'], 9.5),
  hard('column of 10, top 100:1, +-1 cm, dropped', 'column', ['size=10', 'ratio=100', 'offset=0.01'], 9.5),
  hard('400:1 on two boxes', 'heavy_on_two', [], 11),
  hard('column of 80', 'column', ['size=80'], 79.5),
  hard('inverse pyramid 1:1,024', 'inverse_pyramid', [], 23.5),
  hard('house of cards', 'card_house', []),
  hard('arch', 'arch', []),
  hard('overlap recovery', 'overlap', []),
];

/** Of each solver, from the quickest to the most exact. */
const soft = [1, 2, 4, 5, 6, 8, 12, 16, 24].map((n) => [`substeps=${n}`]);
const ladders = [
  { name: 'soft_step', group: 'laglab', command: [program], rungs: soft },
  ...[
    ['pgs', 1],
    ['pgs_ngs', 2],
  ].map(([name, solver]) => ({
    name,
    group: 'laglab',
    command: [program],
    rungs: [10, 20, 50, 100].map((n) => [`solver=${solver}`, `iterations=${n}`]),
  })),
  ...[
    ['tgs_sticky', 4],
    ['xpbd', 5],
  ].map(([name, solver]) => ({
    name,
    group: 'laglab',
    command: [program],
    rungs: [4, 8, 16, 32].map((n) => [`solver=${solver}`, `substeps=${n}`]),
  })),
  { name: 'avbd', group: 'laglab', command: [program], rungs: [4, 6, 10, 20, 40].map((n) => ['solver=6', `iterations=${n}`]) },
  ...compiled('Box2D 3 AVX2', 'box2d_3_avx2').map((e) => ({
    ...e,
    group: '',
    rungs: [
      [2, 15],
      [4, 30],
      [8, 60],
      [16, 120],
    ].map(([n, hertz]) => [`substeps=${n}`, `hertz=${hertz}`]),
  })),
  ...compiled('Box2D 2.4', 'box2d_2').map((e) => ({
    ...e,
    group: '',
    rungs: [
      [2, 1],
      [4, 2],
      [8, 3],
      [20, 10],
    ].map(([v, p]) => [`velocity=${v}`, `position=${p}`]),
  })),
  ...compiled('Chipmunk', 'chipmunk').map((e) => ({ ...e, group: '', rungs: [5, 10, 20, 50].map((n) => [`iterations=${n}`]) })),
  { ...node('Rapier SIMD', 'rapier'), group: '', rungs: [2, 4, 8].map((n) => ['simd=1', `iterations=${n}`]) },
];

// ---- runs ----

const file = (of) => join(folder, `${of.name.replaceAll(/\W+/g, '_')}.json`);
async function writeScene(of) {
  mkdirSync(folder, { recursive: true });
  writeFileSync(file(of), await run(program, ['scene', of.of, String(of.steps), ...of.args]));
}

const nothing = { steps: 0, mean_ms: Infinity, sag: NaN, tilt: NaN };

/** Fewer steps when they take more than `seconds`; an engine that ends with an error has no figure. */
async function measure(who, what, seconds, settings = who.settings) {
  const [command, ...first] = who.command;
  try {
    const text = await run(command, [...first, file(what), String(what.steps), String(seconds), ...settings]);
    return JSON.parse(text.trim().split('\n').at(-1));
  } catch (error) {
    say(`${who.name}, ${what.name}: ${String(error).replaceAll(`${root}/`, '').slice(0, 200)}`);
    return nothing;
  }
}

/** Of each, the round with the least mean of a step. */
const leastOf = (found) => new Map([...found].map(([thing, rounds]) => [thing, rounds.reduce((a, b) => (b.mean_ms < a.mean_ms ? b : a))]));

const rounds = 6, // of those that laglab is held to; one of the others
  whole = 120,
  seconds = quick ? 1 : 3;
const patience = (who) => (held.includes(who.name) ? whole : who.command[0] === 'node' ? Math.min(2, seconds) : seconds);

// ---- speed ----

/** Who is never slower than whom, by the median of the rounds. */
const rivals = [
  { simd: 'SSE2', own: 'laglab SSE2', peer: 'Box2D 3 SSE2' },
  { simd: 'AVX2', own: 'laglab', peer: 'Box2D 3 AVX2' },
];
const rivalRows = [];
function noteRivals(scene, found) {
  const times = (name) => [...found].find(([who]) => who.name === name)?.[1].map((round) => round.mean_ms);
  for (const { simd, own, peer } of rivals)
    times(peer)?.forEach((peer_ms, round) => {
      const own_ms = times(own)[round];
      rivalRows.push({ scene, simd, round, own_ms, peer_ms, ratio: own_ms / peer_ms });
    });
}

const speedRows = [],
  speedTable = [];
for (const what of speedScenes) {
  await writeScene(what);
  const able = engines.filter((who) => !who.missing.includes(what.of));
  const all = await interleave(rounds, able, (who, round) =>
    round > 0 && !held.includes(who.name) ? nothing : measure(who, what, patience(who)),
  );
  noteRivals(what.name, all);
  const found = leastOf(all);
  speedTable.push({
    'ms a step': what.name,
    ...Object.fromEntries(
      engines.map((who) => [
        who.name,
        found.has(who) ? digits(found.get(who).mean_ms) + (found.get(who).steps < what.steps ? '*' : '') : '-',
      ]),
    ),
  });
  for (const [who, best] of found)
    if (best.steps > 0) speedRows.push({ scene: what.name, engine: who.name, settings: who.settings.join(' '), ...best });
}
printTable('CPU time of a step, ms (* fewer steps than the others: it took too long)', speedTable);

// ---- stability ----

const hardRows = [],
  hardTable = [];
const cm = (metres) => (Math.abs(metres) >= 10 ? 'lost' : digits(100 * metres, 2));
for (const what of hardScenes) {
  await writeScene(what);
  const line = { cm: what.name };
  for (const who of engines) {
    if (who.name === 'laglab SSE2' || who.missing.includes(what.of)) {
      if (who.name !== 'laglab SSE2') line[who.name] = '-';
      continue;
    }
    const m = await measure(who, what, 4 * patience(who));
    if (m.steps === 0) {
      line[who.name] = '-';
      continue;
    }
    const off = what.ideal === undefined ? m.sag : what.ideal - m.top_y;
    hardRows.push({ case: what.name, engine: who.name, settings: who.settings.join(' '), off: Number(off.toPrecision(6)), ...m });
    line[who.name] = m.tilt > 0.3 ? 'X' : `${cm(off)} / ${cm(m.drift)}`;
  }
  hardTable.push(line);
}
printTable('After 10 s, sleeping off: the topmost body too low / the farthest drift sideways, cm; X: something has toppled', hardTable);

// ---- speed against error ----

const pile = speedScenes[1],
  rungs = ladders.flatMap((of) => of.rungs.map((settings) => ({ of, settings })));
const slow = new Set();
const attempts = await interleave(quick ? 4 : rounds, rungs, async (rung, round) => {
  if (slow.has(rung)) return nothing;
  const m = await measure(rung.of, pile, 4 * seconds, rung.settings);
  if (round === 0 && m.steps * m.mean_ms > 2500) slow.add(rung); // one round is enough
  return m;
});
const errors = leastOf(attempts);
const errorRows = rungs
  .map((rung) => ({
    engine: rung.of.group || rung.of.name,
    solver: rung.of.group ? rung.of.name : '',
    settings: rung.settings.join(' '),
    ...errors.get(rung),
  }))
  .filter((row) => row.steps > 0);
const stands = (m) => m.tilt < 0.3 && m.steps === pile.steps;
mkdirSync(join(results, 'rigid'), { recursive: true });
writeFileSync(
  join(results, 'rigid', 'pile.svg'),
  workPrecision({
    title: '820 boxes',
    across: 'sag of the pile after 10 s, m (0.1 mm and less at the left edge)',
    what: 'CPU time of a step against sag',
    lines: ladders
      .map((of) => ({
        group: of.group || 'peers',
        name: of.name,
        points: rungs
          .filter((rung) => rung.of === of)
          .map((rung) => errors.get(rung))
          .filter(stands)
          .map((m) => ({ x: Math.max(m.sag, 1e-4), y: m.mean_ms / 1e3 })),
      }))
      .filter((line) => line.points.length > 0),
  }),
);
printTable(
  '820 boxes for 10 s',
  errorRows.map((row) => ({
    engine: `${row.engine} ${row.solver}`.trim(),
    settings: row.settings,
    'ms a step': digits(row.mean_ms),
    'sag m': digits(row.sag),
    'drift m': digits(row.drift),
    'tilt rad': digits(row.tilt),
  })),
);

// ---- what costs nothing, and what grows ----

const growth = (await run(program, ['growth', quick ? '20' : '60']))
  .trim()
  .split('\n')
  .map((text) => JSON.parse(text));
printTable(
  'Balls that fly about and meet: broad phase and solver, and the world asleep',
  growth.map((row) => ({
    bodies: row.bodies,
    'broad ms': digits(row.broad_ms),
    'solve ms': digits(row.solve_ms),
    'whole step ms': digits(row.step_ms),
    'asleep us': digits(row.asleep_us),
  })),
);

// ---- output ----

const verdict = (met) => (met ? 'met' : 'MISSED');
const cheapest = (name) =>
  errorRows.filter((row) => row.engine === name && stands(row) && row.sag <= 0.12).sort((a, b) => a.mean_ms - b.mean_ms)[0];
const own = cheapest('laglab');
say('');
for (const [name, share] of [
  ['Box2D 2.4', 1 / 4],
  ['Chipmunk', 1 / 3],
]) {
  const peer = cheapest(name);
  if (peer)
    say(
      `820 boxes at sag up to 0.12 m: at most ${digits(share)} of ${name}: ` +
        `${digits(own.mean_ms)} (${own.settings}) of ${digits(peer.mean_ms)} ms (${peer.settings}): ` +
        `${digits(own.mean_ms / peer.mean_ms)}: ${verdict(own.mean_ms <= share * peer.mean_ms)}`,
    );
}
const rivalRatio = (scene, simd) => median(rivalRows.filter((row) => row.scene === scene && row.simd === simd).map((row) => row.ratio));
for (const { simd, own, peer } of rivals.filter(({ peer }) => engines.some(({ name }) => name === peer))) {
  const ratios = speedScenes.map(({ name }) => [name, rivalRatio(name, simd)]);
  const listed = ratios.map(([name, ratio]) => `${name} ${digits(ratio, 3)}`).join(', ');
  say(`${own} never slower than ${peer}, median of ${rounds} rounds: ${listed}: ${verdict(ratios.every(([, ratio]) => ratio <= 1))}`);
}
const small = growth[0],
  large = growth.at(-1);
const grown = (what) => large[what] / small[what] / ((large.bodies * Math.log(large.bodies)) / (small.bodies * Math.log(small.bodies)));
say(
  `cost grows at most as N log N from ${small.bodies} to ${large.bodies} bodies: ` +
    `broad phase ${digits(grown('broad_ms'))}, solver ${digits(grown('solve_ms'))} of that: ` +
    verdict(grown('broad_ms') <= 1 && grown('solve_ms') <= 1),
);
const asleep_us = Math.max(...growth.map((row) => row.asleep_us));
say(`a sleeping world costs less than 1 us a step: ${digits(asleep_us)} us: ${verdict(asleep_us < 1)}`);

const command = `bench/run rigid${quick ? ' --quick' : ''}${existsSync(join(peers, 'box2d_3_sse2')) ? ' --box2d DIR' : ''}`;
const columns = {
  settings: "what differs from the engine's default",
  steps: 'made',
  mean_ms: 'CPU time of a step, of the quickest round',
  median_ms: 'of its steps',
  sag: 'm: the most that a dynamic body is too low',
  drift: 'm: the farthest sideways',
  tilt: 'rad: the most that one has turned',
  top_sag: 'm: of the topmost body',
  top_y: 'm: height of its centre',
  lowest: 'm: height of the lowest centre',
};
writeCsv('rigid', command, { scene: "laglab's", engine: 'laglab or a peer', ...columns }, speedRows);
if (rivalRows.length)
  writeCsv(
    'rigid/peer',
    command,
    {
      scene: "laglab's",
      simd: 'of both engines, four substeps each',
      round: 'from 0',
      own_ms: 'mean CPU time of a step of laglab',
      peer_ms: 'of Box2D 3, in turn with it',
      ratio: 'own_ms over peer_ms',
    },
    rivalRows,
  );
writeCsv(
  'rigid/stability',
  command,
  {
    case: '10 s, sleeping off',
    engine: 'laglab or a peer',
    off: 'm: how much too low the topmost body is; the sag where it may go anywhere',
    ...columns,
  },
  hardRows,
);
writeCsv('rigid/pile', command, { engine: 'laglab or a peer', solver: 'of laglab', ...columns }, errorRows);
writeCsv(
  'rigid/growth',
  command,
  {
    bodies: 'dynamic',
    broad_ms: "median of a step's broad phase",
    solve_ms: 'median of its solver',
    step_ms: 'median of a step',
    asleep_us: 'a step when all sleep',
  },
  growth,
);
