// Frames per second of fluids on one core, and errors of particles against references.
import { existsSync } from 'node:fs';
import { join } from 'node:path';
import { compression } from './compression.mjs';
import { build, digits, median, printTable, range, root, run, say, writeCsv } from './lib.mjs';

const quick = process.argv.includes('--quick');
const rounds = quick ? 3 : 11,
  peerRounds = quick ? 3 : 5;
const program = join(build, 'bench', 'fluid');

async function table(args, command = program) {
  const [head, ...lines] = (await run(command, args.map(String))).trim().split('\n');
  const columns = head.split(',');
  return lines.map((line) => Object.fromEntries(line.split(',').map((cell, i) => [columns[i], cell])));
}

// ---- speed ----

const tank = { width: 20, height: 3 },
  spacing = 0.05; // the pool of bench/fluid.c

/** The compression of a case of particles after each of the first rounds. */
async function compressions(name, method) {
  const places = [];
  for (const { round, x, y } of await table(['places', name, method, peerRounds])) (places[round] ??= []).push(Number(x), Number(y));
  return places.map((at) => compression(tank, spacing, at));
}

const own = await table(['speed', rounds]),
  peers = [];
const COARSE = 'particles by two iterations';
for (const [name, method] of [
  ['particles', 'pbf'],
  [COARSE, 'pbf'],
  ['particles by a tolerance of 0.005', 'dfsph'],
  ['particles', 'dfsph'],
])
  for (const [round, { mean, max }] of (await compressions(name, method)).entries())
    Object.assign(
      own.find((row) => row.case === name && row.method === method && Number(row.round) === round),
      { compression_mean: mean.toPrecision(3), compression_max: max.toPrecision(3) },
    );
for (const [peer, library] of [
  ['box2d.ts', '@box2d/particles'],
  ['liquidfun-wasm', 'liquidfun-wasm'],
])
  if (existsSync(join(root, 'bench', 'node_modules', library)))
    peers.push(...(await table([join(root, 'bench', 'peers', 'fluid.mjs'), peer, peerRounds], process.execPath)));
const timed = [...own, ...peers].map((row) => ({ ...row, frames_per_s: Number((row.frames / row.cpu_s).toPrecision(4)) }));
const goals = { 'particles pbf': 60, 'ocean gerstner': 200, 'smoke multigrid': 60 };
const names = [...new Set(timed.map((row) => `${row.case} ${row.method}`))];
const speeds = new Map(
  names.map((name) => [name, timed.filter((row) => `${row.case} ${row.method}` === name).map((row) => row.frames_per_s)]),
);
const spread = (values) => {
  const r = range(values);
  return `${digits(r.min)}-${digits(r.max)}`;
};

printTable(
  `Frames of 1/60 s per second of CPU, ${rounds} rounds, of peers ${peerRounds} (median, min-max)`,
  names.map((name) => ({
    case: name,
    'frames/s': digits(median(speeds.get(name))),
    'min-max': spread(speeds.get(name)),
    goal: goals[name] ?? '-',
    what: timed.findLast((row) => `${row.case} ${row.method}` === name).note,
  })),
);

const compressed = timed.filter((row) => row.compression_mean);
const compressionOf = (name, column) =>
  median(compressed.filter((row) => `${row.case} ${row.method}` === name).map((row) => Number(row[column])));
printTable(
  'Compression of 10,000 particles by their places, of all libraries by one measure (bench/compression.mjs; median over the rounds)',
  [...new Set(compressed.map((row) => `${row.case} ${row.method}`))].map((name) => ({
    case: name,
    mean: digits(compressionOf(name, 'compression_mean')),
    max: digits(compressionOf(name, 'compression_max')),
  })),
);

// ---- accuracy ----

const runs = await table(['accuracy']);
printTable(
  'Particles: relative errors (front: Martin and Moyce, gate-shifted; ' +
    'pressure: RMS in the last second, and of its mean; PBF with 10 iterations)',
  runs.map((row) => ({
    scene: row.scene,
    method: row.method,
    size: row.size,
    quantity: row.quantity,
    value: row.value,
    'CPU s': row.cpu_s,
  })),
);

say('');
for (const [name, goal] of Object.entries(goals)) {
  const speed = median(speeds.get(name));
  say(`${name}: at least ${goal} frames/s: ${digits(speed)}: ${speed >= goal ? 'met' : 'MISSED'}`);
}
/** The worst over the methods (or of one) and the sizes (or of one). */
const value = (scene, quantity, method, size) =>
  Math.max(
    ...runs
      .filter(
        (row) =>
          row.scene === scene &&
          row.quantity === quantity &&
          (method === undefined || row.method === method) &&
          (size === undefined || Number(row.size) === size),
      )
      .map((row) => Number(row.value)),
  );
const told = (what, of, most) => say(`${what}: ${digits(of)}: ${of <= most ? 'met' : 'MISSED'}`);
for (const peer of ['box2d.ts', 'liquidfun-wasm']) {
  const pbf = median(speeds.get('particles pbf')),
    other = speeds.get(`particles ${peer}`);
  if (other) say(`10,000 particles: laglab's pbf makes ${digits(pbf / median(other))} times the frames of ${peer}`);
}
const liquidfun = 'particles liquidfun-wasm';
if (speeds.has(liquidfun))
  for (const name of [`${COARSE} pbf`, 'particles dfsph', 'particles by a tolerance of 0.005 dfsph']) {
    const ratio = median(speeds.get(name)) / median(speeds.get(liquidfun)),
      denser = compressionOf(name, 'compression_mean') / compressionOf(liquidfun, 'compression_mean');
    say(
      `${name}: ${digits(ratio)} times the frames of liquidfun-wasm (goal 1) ` +
        `at ${digits(denser)} of its mean compression (at most 1): ${ratio >= 1 && denser <= 1 ? 'met' : 'MISSED'}`,
    );
  }
told('dam break, all methods: front RMS at most 0.05', value('dam_break', 'front_rms'), 0.05);
told("never ahead of Ritter's front", value('dam_break', 'front_over_ritter_max'), 1);
for (const method of ['wcsph', 'pbf', 'dfsph'])
  told(`hydrostatic, ${method}, 40 along the height: pressure RMS at most 0.02`, value('hydrostatic', 'pressure_rms', method, 40), 0.02);
told('Poiseuille, all methods: velocity RMS at most 0.01', value('poiseuille', 'velocity_rms'), 0.01);

const command = `bench/run fluid${quick ? ' --quick' : ''}`;
writeCsv(
  'fluid',
  command,
  {
    case: 'what was run',
    method: 'of it, or the peer',
    round: 'the cases take turns',
    frames: 'of 1/60 s',
    cpu_s: 'of the process',
    frames_per_s: 'frames / cpu_s',
    compression_mean: 'of particles at the end of the round, by their places',
    compression_max: 'of the densest',
    note: 'size, and what the speed was bought with',
  },
  timed,
);
writeCsv(
  'fluid_accuracy',
  command,
  {
    scene: 'of src/fluid/scenes/particle_start.c',
    method: 'of particles',
    size: "particles along the scene's length",
    quantity: 'relative; compression_max over the whole run',
    value: 'of it',
    cpu_s: 'of the whole run',
  },
  runs,
);
