// kill -9 a thousand times under load: chains of 25 on one folder of data each, several chains at a time. After every restart what was
// acknowledged before is looked for: sessions, commands in their logs, clocks, states by their hashes; and what was deleted must stay away.
//   bench/run kills [--quick] [--kills=1000] [--at-once=3] [--seed=1]
import { printTable, say, writeCsv } from './lib.mjs';
import { chain, nothing } from '../tests/lib/kills.mjs';

const option = (name, standard) => Number(process.argv.find((word) => word.startsWith(`--${name}=`))?.split('=')[1] ?? standard);
const LENGTH = 25,
  quick = process.argv.includes('--quick');
const kills = option('kills', quick ? 50 : 1000),
  at_once = option('at-once', 3),
  first = option('seed', 1);

const rows = [],
  begun = performance.now();
let next = 0,
  given = 0;

async function work() {
  while (given < kills) {
    const seed = first + next++,
      length = Math.min(LENGTH, kills - given),
      told = nothing(),
      from = performance.now();
    given += length;
    let broken = '';
    try {
      await chain({ kills: length, seed, told });
    } catch (error) {
      broken = String(error.message).slice(0, 200);
    }
    const { findings, ...counts } = told;
    rows.push({ seed, ...counts, wall_s: ((performance.now() - from) / 1000).toFixed(1), broken });
    for (const finding of findings) say(finding);
    if (broken) say(`seed ${seed}: ${broken}`);
    console.log(
      `${rows.reduce((sum, row) => sum + row.kills, 0)} of ${kills} kills after ${Math.round((performance.now() - begun) / 1000)} s`,
    );
  }
}
await Promise.all(Array.from({ length: at_once }, work));

const sum = (name) => rows.reduce((total, row) => total + row[name], 0);
const names = ['kills', 'sessions', 'acknowledged', 'commands', 'hashes', 'stayed_away', 'lost', 'resurrected', 'differ'];
printTable(`${rows.length} chains, ${at_once} at a time, ${Math.round((performance.now() - begun) / 1000)} s`, [
  Object.fromEntries(names.map((name) => [name, sum(name)])),
]);
const bad = sum('lost') + sum('resurrected') + sum('differ') + rows.filter((row) => row.broken).length;
say(`${bad === 0 ? 'Met' : 'Missed'}: 0 acknowledged commands lost, 0 sessions resurrected, 0 hashes that differ.`);
writeCsv(
  'kills',
  `bench/run kills --kills=${kills} --at-once=${at_once} --seed=${first}`,
  {
    seed: "of the chain's random numbers",
    kills: 'of the daemon by SIGKILL, 20 to 600 ms after the load began',
    sessions: 'made',
    acknowledged: 'answers that reported success, of all kinds',
    commands: 'looked for in the logs after restarts (each again after every further kill)',
    hashes: 'of states looked for',
    stayed_away: 'deleted sessions looked for',
    lost: 'acknowledged and not there',
    resurrected: 'deleted and there again',
    differ: 'hashes that are others',
    wall_s: '',
    broken: 'why the chain ended early, if it did',
  },
  rows.sort((a, b) => a.seed - b.seed),
);
process.exit(bad === 0 ? 0 : 1);
