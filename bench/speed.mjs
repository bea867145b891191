// Simulated seconds per second of one core, compared with a model of the demo's rules in JavaScript; cost of techniques; bytes of a
// session.
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { digits, interleave, laglab, build, median, printTable, range, root, run, say, writeCsv } from './lib.mjs';

const quick = process.argv.includes('--quick');
const rounds = quick ? 3 : 7;
const run_s = 3600; // the longest that a scenario may last
const runs = quick ? 1 : 5;
const seconds = runs * run_s;
const all = { prediction: true, reconciliation: true, interpolation: true };

const scenario = (id) => JSON.parse(readFileSync(join(root, 'scenarios', `${id}.json`), 'utf8'));
const race = scenario('race');

/** A race that lasts, between players of equal techniques. */
function raceOf(players, techniques, updateHz = race.server.update_hz) {
  const seats = Array.from({ length: players }, (_, i) => ({ name: 'ABCDEFGHIJKLMNOP'[i], lag_ms: [150, 250][i % 2], ...techniques }));
  return { ...race, params: { laps: 10000 }, server: { ...race.server, update_hz: updateHz }, players: seats };
}
function demoOf(id, updateHz) {
  const s = scenario(id);
  return {
    ...s,
    server: { ...s.server, update_hz: updateHz },
    players: s.players.map((player, i) => ({ ...player, lag_ms: [150, 250][i], ...all })),
  };
}

async function engine(json, ...more) {
  return JSON.parse(await run(join(build, 'bench', 'speed'), [...[run_s, runs].map(String), ...more], JSON.stringify(json)));
}
const unobserved = (json) => engine(json, 'unobserved');
async function wholeProcess(json) {
  const script = 'TIMEFORMAT="%U %S"; time "$0" run - --duration "$1" >/dev/null';
  const text = await run('bash', ['-c', `{ ${script}; } 2>&1`, laglab, String(run_s)], JSON.stringify(json));
  return {
    cpu_s:
      runs *
      text
        .trim()
        .split(' ')
        .reduce((sum, part) => sum + Number(part), 0),
  };
}
async function model(updateHz) {
  const options = { seconds, updateHz, lags: [150, 250], ...all };
  return JSON.parse(await run('node', [join(root, 'bench', 'demo_model.mjs'), JSON.stringify(options)]));
}

const rows = [];
const note = (group, name, result, round) =>
  rows.push({
    group,
    case: name,
    round,
    sim_s: seconds,
    cpu_s: result.cpu_s,
    times_real_time: seconds / result.cpu_s,
    live_bytes: result.live?.bytes,
    parked_bytes: result.parked?.bytes,
    hash: result.hash,
  });
const speeds = (results) => results.map((result) => seconds / result.cpu_s);
const spread = (values) => {
  const r = range(values);
  return `${digits(r.min)}-${digits(r.max)}`;
};

// ---- bare loops ----

async function againstBareLoops() {
  const cases = JSON.parse(await run(join(build, 'bench', 'bare'), [String(rounds)]));
  printTable(
    'A step next to a bare C loop of the same physics, least CPU time of the rounds',
    cases.map((c) => ({
      case: c.case,
      'loop ns': digits(c.bare_ns),
      'laglab ns': digits(c.laglab_ns),
      ratio: digits(c.laglab_ns / c.bare_ns),
      'loop bytes': c.bare_bytes,
      'laglab bytes': c.laglab_bytes,
    })),
  );
  writeCsv(
    'speed/bare',
    `bench/run speed${quick ? ' --quick' : ''}`,
    {
      case: 'what both compute; laglab also compares it with its reference, and a race has a server, links and a client',
      steps: 'of one run',
      bare_ns: 'CPU time of a step of the loop, the least of the rounds',
      laglab_ns: 'the same of a step of laglab',
      ratio: 'laglab_ns / bare_ns',
      bare_bytes: 'state of the loop',
      laglab_bytes: "the simulation's block (`cost.block_bytes`)",
    },
    cases.map((c) => ({ ...c, ratio: c.laglab_ns / c.bare_ns })),
  );
}
await againstBareLoops();
if (process.argv.includes('--bare')) process.exit();

// ---- comparison with the model ----

const beside = [
  { name: 'JavaScript model, 50 Hz clients, 30 updates/s', run: () => model(30), peer: true },
  { name: 'laglab race, 60 Hz, 30 updates/s', run: () => engine(raceOf(2, all)) },
  { name: 'laglab race, no view observed', run: () => unobserved(raceOf(2, all)) },
  { name: 'laglab race, whole process', run: () => wholeProcess(raceOf(2, all)) },
  { name: "laglab, the demo's rules, 50 Hz, 30 updates/s", run: () => engine(demoOf('gambetta', 30)) },
  { name: 'laglab, default rules for it, 50 Hz, 30 updates/s', run: () => engine(demoOf('gambetta_default', 30)) },
  { name: 'JavaScript model, 50 Hz clients, 3 updates/s', run: () => model(3), peer: true },
  { name: "laglab, the demo's rules, 50 Hz, 3 updates/s", run: () => engine(demoOf('gambetta', 3)) },
];
const results = await interleave(rounds, beside, (thing) => thing.run());
let peer;
printTable(
  `Simulated seconds per second of one core: 2 players, all techniques on, ${seconds} s, ${rounds} rounds (median, min-max)`,
  beside.map((thing) => {
    const speed = speeds(results.get(thing));
    if (thing.peer) peer = speed;
    results.get(thing).forEach((result, round) => note('compared with the model', thing.name, result, round));
    return {
      case: thing.name,
      'x real time': digits(median(speed)),
      'min-max': spread(speed),
      'x the model above': digits(median(speed.map((value, round) => value / peer[round]))),
    };
  }),
);

// ---- techniques, players, bytes ----

const steps = [
  ['none', {}],
  ['prediction', { prediction: true }],
  ['prediction, reconciliation', { prediction: true, reconciliation: true }],
  ['interpolation', { interpolation: true }],
  ['all three', all],
];
const eightPlayers = { ...scenario('eight'), params: { laps: 10000 } };
const costs = [2, 8].flatMap((players) =>
  steps.map(([name, techniques]) => ({ name, players, json: raceOf(players, techniques), run: engine })),
);
costs.push({ name: 'all three, no view observed', players: 2, json: raceOf(2, all), run: unobserved });
costs.push({ name: 'scenario `eight`: jitter, loss', players: 8, json: eightPlayers, run: engine });
costs.push({ name: 'scenario `eight`, no view observed', players: 8, json: eightPlayers, run: unobserved });
costs.push({ name: 'all three', players: 16, json: raceOf(16, all), run: engine });
costs.push({ name: 'all three, no view observed', players: 16, json: raceOf(16, all), run: unobserved });
const costResults = await interleave(rounds, costs, (thing) => thing.run(thing.json));
printTable(
  `Cost of techniques in a race (60 Hz, 30 updates/s), and bytes of a session with 30 s of history as \`cost\` reports them`,
  costs.map((thing) => {
    const of = costResults.get(thing);
    of.forEach((result, round) => note(`${thing.players} players`, thing.name, result, round));
    const micro = of.map((result) => (1e6 * result.cpu_s) / seconds);
    return {
      players: thing.players,
      techniques: thing.name,
      'us/simulated s': digits(median(micro)),
      'min-max': spread(micro),
      'x real time': digits(median(speeds(of))),
      'bytes live': of[0].live.bytes,
      parked: of[0].parked.bytes,
    };
  }),
);

const speedOf = (/** @type {string} */ name) => speeds(results.get(beside.find((thing) => thing.name === name)));
const observed = speedOf('laglab race, 60 Hz, 30 updates/s'),
  alone = speedOf('laglab race, no view observed'),
  whole = median(speedOf('laglab race, whole process')),
  modelled = speedOf('JavaScript model, 50 Hz clients, 30 updates/s'),
  times = median(alone.map((value, round) => value / modelled[round]));
const costOf = (/** @type {number} */ players, /** @type {string} */ name) =>
  1 / median(speeds(costResults.get(costs.find((thing) => thing.players === players && thing.name === name))));
const observations = ['', ', no view observed'];
const bytes = costResults.get(costs[4])[0];
const verdict = (/** @type {boolean} */ met) => (met ? 'met' : 'MISSED');
if (results.get(beside[1])[0].hash !== results.get(beside[2])[0].hash) throw new Error('observing has changed the run');
say('');
say(`race at least 60,000 times real time, no view observed: ${digits(median(alone))}: ${verdict(median(alone) >= 60000)}`);
say(`and 3 times the model: ${digits(times)}: ${verdict(times >= 3)}`);
say(
  `with all metrics of \`run\`, the whole process, at least 40,000: ${digits(whole)} ` +
    `(the engine alone ${digits(median(observed))}): ${verdict(whole >= 40000)}`,
);
for (const way of observations) {
  const eight = 1 / costOf(8, way ? `scenario \`eight\`${way}` : 'scenario `eight`: jitter, loss'),
    sixteen = 1 / costOf(16, `all three${way}`),
    power = Math.log(costOf(16, `all three${way}`) / costOf(2, `all three${way}`)) / Math.log(8);
  say(`eight players, jitter and loss${way}, at least 5,000: ${digits(eight)}: ${verdict(eight >= 5000)}`);
  say(`sixteen players${way}, at least 1,500: ${digits(sixteen)}: ${verdict(sixteen >= 1500)}`);
  say(`cost over players from 2 to 16${way}, at most n^1.3: n^${digits(power)}: ${verdict(power <= 1.3)}`);
}
say(
  `live race at most 1 MiB: ${bytes.live.bytes} bytes: ${verdict(bytes.live.bytes <= 2 ** 20)}; ` +
    `parked at most 64 KiB: ${bytes.parked.bytes} bytes: ${verdict(bytes.parked.bytes <= 65536)}`,
);

writeCsv(
  'speed',
  `bench/run speed${quick ? ' --quick' : ''}`,
  {
    group: 'table',
    case: 'what was run',
    round: 'rounds are interleaved over the cases',
    sim_s: 'simulated seconds',
    cpu_s:
      'CPU seconds: of the thread (laglab), of the process ' +
      "(whole process: one run of 3600 s, scaled; model: user + system, its compiler's threads too)",
    times_real_time: 'sim_s / cpu_s',
    live_bytes: '`cost.bytes` of a session with 30 s of history',
    parked_bytes: 'the same session parked',
    hash: 'of the last state: the same in all rounds',
  },
  rows,
);
