// A thousand disks that fail: full, read-only and standing still, well again or not, with kill -9 or SIGTERM, under writers of sessions,
// classes and experiments (tests/lib/full.mjs). What was acknowledged is looked for after each restart, and what was refused with 507.
// Needs root.
//   bench/run full [--quick] [--trials=1000] [--at-once=3] [--seed=1]
import { printTable, say, writeCsv } from './lib.mjs';
import { failingDisk, nothing } from '../tests/lib/full.mjs';

const option = (name, standard) => Number(process.argv.find((word) => word.startsWith(`--${name}=`))?.split('=')[1] ?? standard);
const LENGTH = 20,
  quick = process.argv.includes('--quick');
const trials = option('trials', quick ? 60 : 1000),
  at_once = option('at-once', 3),
  first = option('seed', 1);

const rows = [],
  begun = performance.now();
let next = 0,
  given = 0;

async function work() {
  while (given < trials) {
    const seed = first + next++,
      length = Math.min(LENGTH, trials - given),
      told = nothing(),
      from = performance.now();
    given += length;
    let broken = '';
    try {
      await failingDisk({ trials: length, seed, told });
    } catch (error) {
      broken = String(error.message).slice(0, 200);
    }
    const { findings, ...counts } = told;
    rows.push({ seed, ...counts, odd: findings.length - told.lost, wall_s: ((performance.now() - from) / 1000).toFixed(1), broken });
    for (const finding of findings) say(finding);
    if (broken) say(`seed ${seed}: ${broken}`);
    console.log(
      `${rows.reduce((sum, row) => sum + row.trials, 0)} of ${trials} trials after ${Math.round((performance.now() - begun) / 1000)} s`,
    );
  }
}
await Promise.all(Array.from({ length: at_once }, work));

const sum = (name) => rows.reduce((total, row) => total + row[name], 0);
const names = ['trials', 'full', 'read_only', 'slow', 'kills', 'stops', 'acknowledged', 'refused', 'looked_for', 'lost', 'odd'];
printTable(`${rows.length} disks, ${at_once} at a time, ${Math.round((performance.now() - begun) / 1000)} s`, [
  Object.fromEntries(names.map((name) => [name, sum(name)])),
]);
const bad = sum('lost') + sum('odd') + rows.filter((row) => row.broken).length;
say(`${bad === 0 ? 'Met' : 'Missed'}: 0 acknowledged changes lost, 0 refused ones there.`);
writeCsv(
  'full',
  `bench/run full --trials=${trials} --at-once=${at_once} --seed=${first}`,
  {
    seed: "of the disk's random numbers",
    trials: 'starts, writers, a fault, an end',
    full: 'of these on a full disk',
    read_only: 'with files that cannot be written, or mounted read-only at the next start',
    slow: 'on a disk that stands still for a while (fsfreeze)',
    kills: 'ends by SIGKILL',
    stops: 'ends by SIGTERM',
    acknowledged: 'answers that reported success',
    refused: 'answers 507',
    looked_for: 'values and lines of logs after restarts',
    lost: 'acknowledged and not there, or refused and there',
    odd: 'other findings, as an end with another status',
    wall_s: '',
    broken: 'why the disk was left early, if it was',
  },
  rows.sort((a, b) => a.seed - b.seed),
);
process.exit(bad === 0 ? 0 : 1);
