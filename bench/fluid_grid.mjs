// Fluids on a grid: pressure solvers by size, the cosine transform compared with FFTW, frames of smoke, and errors against references.
import { join } from 'node:path';
import { build, digits, printTable, run, say, writeCsv } from './lib.mjs';

const quick = process.argv.includes('--quick');
const program = join(build, 'bench', 'fluid_grid');
const command = `bench/run fluid_grid${quick ? ' --quick' : ''}`;

const table = async (part) => {
  const [head, ...lines] = (await run(program, [part, ...(quick ? ['quick'] : [])])).trim().split('\n');
  const columns = head.split(',');
  return lines.map((line) => Object.fromEntries(line.split(',').map((cell, i) => [columns[i], cell])));
};

const verdict = (met) => (met ? 'met' : 'MISSED');
const find = (rows, wanted) => rows.find((row) => Object.entries(wanted).every(([key, value]) => row[key] === String(value)));

// ---- the pressure equation ----

const pressure = await table('pressure');
printTable('Pressure equation to 1e-6 of random sources: sweeps and CPU time', pressure);
const cycles = pressure.filter((row) => row.solver === 'multigrid').map((row) => Number(row.sweeps));
say(`multigrid's cycles do not grow with N: ${Math.min(...cycles)} to ${Math.max(...cycles)}: ${verdict(Math.max(...cycles) <= 8)}`);
for (const box of ['empty', 'disc']) {
  const n = quick ? 256 : 512,
    mg = find(pressure, { box, n, solver: 'multigrid' }),
    pcg = find(pressure, { box, n, solver: 'pcg' });
  const ratio = pcg.cpu_ms / mg.cpu_ms;
  say(`multigrid over pcg at ${n} x ${n}, ${box}: ${digits(ratio)} times as fast; at least 10 at 512: ${verdict(ratio >= 10)}`);
}
writeCsv(
  'fluid_grid/pressure',
  command,
  {
    box: 'empty, or with a disc as obstacle',
    solver: 'row of ll_pressure_solvers; jacobi with relaxation 0.9',
    n: 'cells along a side',
    sweeps: 'or cycles',
    cpu_ms: 'least of three',
    residual: 'left over, relative to the largest source',
  },
  pressure,
);

const transform = await table('transform');
printTable('Cosine transform there and back', transform);
writeCsv(
  'fluid_grid/transform',
  command,
  { library: "laglab's fluid/core/fft.h, or FFTW by one thread", n: 'along a side', cpu_ms: 'least of seven, without the plan' },
  transform,
);

// ---- frames ----

const frames = await table('frames');
printTable('Smoke past a cylinder at 60 Hz, one core', frames);
const smoke = find(frames, { n: 256, settings: 'as it is' });
say(
  `256 x 256 at 60 frames/s with residual 1e-3: ${digits(Number(smoke.frames_per_s))} frames/s, residual ${smoke.residual}: ` +
    verdict(smoke.frames_per_s >= 60 && smoke.residual <= 1e-3),
);
writeCsv(
  'fluid_grid/frames',
  command,
  {
    n: 'cells along a side',
    settings: "other than the scene's: maccormack, multigrid to 1e-3",
    ms_per_frame: 'CPU time of a tick of 1/60 s',
    frames_per_s: '',
    residual: 'relative, of the last solution',
    divergence_max_per_s: 'left in the last frame',
    sweeps_mean: 'of a solution',
  },
  frames,
);

// ---- errors ----

const cavity = await table('cavity');
printTable('Driven cavity by central fluxes and the direct solver', cavity);
for (const [re, most] of [
  [100, 0.002],
  [1000, 0.02],
]) {
  const row = find(cavity, { re, n: 128 });
  if (row) say(`128 x 128 at Re ${re} within ${most}: ${row.error_max}: ${verdict(row.error_max <= most)}`);
}
writeCsv(
  'fluid_grid/cavity',
  command,
  {
    re: 'Reynolds number',
    n: 'cells along a side',
    seconds: 'from rest',
    error_max: "of u and v along the middles, against Richardson's values",
    ghia_error_max: 'against the printed table of 1982, which is itself off by up to 0.0093 and 0.0184',
    order: 'from half as many cells',
    cpu_s: '',
  },
  cavity,
);

const vortices = await table('vortices');
printTable('Taylor-Green vortices with a mean flow of (1, 1) m/s after 5 s, half a cell a step', vortices);
writeCsv(
  'fluid_grid/vortices',
  command,
  {
    n: 'cells along a side',
    viscosity_m2ps: 'of the fluid',
    settings: 'of the solver',
    error_l2: 'of velocities, relative',
    decay_error: 'of the energy, relative',
    numerical_viscosity_m2ps: "what the energy's decay has beyond",
    cpu_s: '',
  },
  vortices,
);

const rotation = await table('rotation');
printTable('One turn of a shape', rotation);
writeCsv(
  'fluid_grid/rotation',
  command,
  {
    shape: '',
    advection: 'midpoint traces, clamped',
    n: 'cells along a side; a step is 1/(4 n) of a turn',
    error_l1: 'mean absolute error, m^2',
    mass_change: 'relative',
    least: 'of the dye, at first 0',
    most: 'at first 1',
    cpu_s: '',
  },
  rotation,
);
