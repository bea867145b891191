// The command line: what it prints, what it writes, and how it refuses.
import { createHash } from 'node:crypto';
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import Ajv2020 from 'ajv/dist/2020.js';
import { ROOT, SCENARIOS, checkBadValues, checkRepeats, folder, good, ids, laglab, refused, run, scenario, schema } from '../lib/cli.mjs';
import { parseCsv } from '../lib/csv.mjs';

/** By these one game, scene or problem differs from another. */
const KIND = ['kind', 'game', 'scene', 'problem'];

// ---- run ----

test('run prints one object with the members that are promised', () => {
  const out = run(['race']);
  assert.deepEqual(Object.keys(out), ['scenario', 'seed', 'duration_s', 'ticks', 'hash', 'wall_s', 'metrics', 'cost']);
  assert.equal(out.scenario, 'race');
  assert.equal(out.seed, 1);
  assert.equal(out.duration_s, 60);
  assert.equal(out.ticks, 3600);
  assert.match(out.hash, /^[0-9a-f]{16}$/);
  assert.ok(out.wall_s > 0 && out.wall_s < 60);
  assert.equal(out.metrics.players.length, 2);
  assert.equal(typeof out.metrics.server, 'object');
  for (const player of out.metrics.players) {
    for (const metric of [
      'input_latency_ms',
      'confirmed_latency_ms',
      'seen_latency_ms',
      'ack_rtt_ms',
      'view_age_ms',
      'age_of_information_ms',
      'own_timeline_error_m',
      'own_lead_m',
      'remote_error_m',
      'timeline_error_m',
    ]) {
      const members = ['count', ...(/_latency_/.test(metric) ? ['lost_ratio'] : []), 'max', 'mean', 'p50', 'p95', 'p99', 'rms'];
      assert.deepEqual(Object.keys(player[metric]).sort(), members, metric);
      const { p50, p95, p99, max, mean, rms } = player[metric];
      const low = 1 - 1e-9; // sums are rounded
      assert.ok(
        p50 <= p95 && p95 <= p99 && p99 <= max && mean * low <= rms && rms * low <= max,
        `${metric} ${JSON.stringify(player[metric])}`,
      );
    }
  }
  for (const name of ['ns_per_sim_s', 'bytes']) assert.ok(out.cost[name] > 0, name);
});

test('--metrics prints those metrics alone, with the values and the hash of a run that prints all', () => {
  const paths = [
    'players.1.remote_error_m.p95',
    'players.0.input_latency_ms.mean',
    'players.1.bandwidth.state.packets_per_s',
    'server.steps',
  ];
  const all = JSON.parse(good(['run', 'eight', '--duration', '7'])),
    at = (/** @type {string} */ path) => path.split('.').reduce((value, name) => value[name], all.metrics);
  for (const asked of [paths, ...paths.map((path) => [path])]) {
    const some = JSON.parse(good(['run', 'eight', '--duration', '7', '--metrics', asked.join(',')]));
    assert.deepEqual(some.metrics, Object.fromEntries(asked.map((path) => [path, at(path)])));
    assert.equal(some.hash, all.hash);
  }
  refused(['run', 'race', '--metrics', 'server.steps,players.0.remote_error_m.mode'], ['--metrics', 'remote_error_m.mode', 'p95']);
  refused(['run', 'race', '--metrics', ''], ['--metrics']);
  refused(['run', 'race', '--metrics', 'server.steps,server.steps'], ['--metrics', 'duplicate server.steps']);
});

test('seed, duration and settings change what they say', () => {
  const plain = run(['eight', '--duration', '4']);
  const seeded = run(['eight', '--duration', '4', '--seed', '77', '--set', 'players.0.link.up.loss_pct=20']);
  const other = run(['eight', '--duration', '4', '--seed', '78', '--set', 'players.0.link.up.loss_pct=20']);
  assert.equal(plain.duration_s, 4);
  assert.equal(plain.ticks, 240);
  assert.equal(seeded.seed, 77);
  assert.notEqual(seeded.hash, plain.hash);
  assert.notEqual(seeded.hash, other.hash);
  assert.equal(run(['race', '--seed', '9007199254740991', '--duration', '0.1']).seed, 9007199254740991);
  assert.equal(run(['race', '--duration', '2', '--set', 'duration_s=9']).duration_s, 2, 'the option wins');
  const free = run(['race', '--duration', '9', '--set', 'players.0.lag_ms=0', '--set', 'players.0.prediction=false']);
  const slow = run(['race', '--duration', '9', '--set', 'players.0.lag_ms=400', '--set', 'players.0.prediction=false']);
  assert.ok(slow.metrics.players[0].input_latency_ms.mean - free.metrics.players[0].input_latency_ms.mean > 700);
  assert.equal(run(['race', '--duration', '1', '--set', 'server.sync=lockstep']).metrics.server.sync, 'lockstep');
  assert.equal(run(['race', '--duration', '1', '--set', 'players=[{},{},{}]']).metrics.players.length, 3);
  assert.equal(run(['race', '--duration', '1', '--set', 'players.0.name=Zoë']).metrics.players[0].name, 'Zoë');
  assert.equal(run(['race', '--duration', '1', '--set', 'players.0.name=a=b']).metrics.players[0].name, 'a=b');
  // The last of two settings of one value stands.
  const twice = run(['race', '--duration', '1', '--set', 'players.0.lag_ms=5', '--set', 'players.0.lag_ms=150']);
  assert.equal(twice.hash, run(['race', '--duration', '1']).hash);
});

test('settings count together, in any order', () => {
  const up = (row) => `players.0.link.up.${row}`;
  for (const [scenario, ...settings] of [
    ['race', up('reorder_pct=30'), up('delay_ms=25')],
    ['race', up('reorder_gap=2'), up('reorder_pct=60'), up('rate_kbps=200')],
    ['race', up('mtu_bytes=64'), 'players.0.link.preset=wifi_busy', 'players.0.lag_ms=12'],
    ['race', 'players.2.lag_ms=9', 'players=[{},{},{}]', 'players.2.prediction=true'],
    ['rigid/column', 'side_by_side=[{}]', 'solver.substeps=6', 'side_by_side.0.solver.method=pgs'],
  ]) {
    const options = (list) => ['--duration', '2', ...list.flatMap((setting) => ['--set', setting])];
    const hash = run([scenario, ...options(settings)]).hash;
    assert.equal(run([scenario, ...options([...settings].reverse())]).hash, hash, settings.join(' '));
  }
});

test('a scenario is an id, a file or standard input', () => {
  const text = readFileSync(path.join(SCENARIOS, 'race.json'), 'utf8');
  writeFileSync(path.join(folder, 'mine.json'), text);
  const { hash } = run(['race', '--duration', '2']);
  for (const [name, input] of [
    ['mine.json', ''],
    [path.join(SCENARIOS, 'race.json'), ''],
    ['-', text],
  ]) {
    const out = run([name, '--duration', '2'], input);
    assert.equal(out.hash, hash);
    assert.equal(out.scenario, name);
  }
  assert.equal(run(['--duration', '2', 'race']).hash, hash, 'options may come first');
  assert.equal(run(['paper/fig11', '--duration', '1']).ticks, 60);
});

// ---- trace ----

test('every row of a trace is after the frames of its time, the first too', () => {
  const file = path.join(folder, 'rows.csv');
  run(['race', '--duration', '1', '--set', 'players.0.lag_ms=400', '--set', 'players.0.clock_phase=0', '--trace', file]);
  const [head, ...rows] = readFileSync(file, 'utf8')
    .trimEnd()
    .split('\r\n')
    .map((line) => line.split(','));
  const open = head.indexOf('player_0_unacked'),
    age = head.indexOf('player_0_age_of_information_ms');
  for (const [k, row] of rows.slice(0, 48).entries()) {
    // an input a frame, and no state for 400 ms and its way back
    assert.equal(row[open], String(k + 1));
    if (k < 24) assert.ok(Math.abs(Number(row[age]) - (k * 1000) / 60) < 1e-5, row[age]);
  }
});

test('who joins again predicts from the state that it joins with', () => {
  for (const [seed, lag, scope] of [
    [3, 130, 'own'],
    [5, 35, 'own'],
    [9, 220, 'all'],
  ]) {
    const { metrics } = run([
      'outage',
      '--seed',
      String(seed),
      '--set',
      `players.1.lag_ms=${lag}`,
      '--set',
      `players.1.prediction_scope=${scope}`,
      '--set',
      'warmup_s=22',
    ]);
    const [, b] = metrics.players; // counted from 22 s on: the link is back since 18 s
    assert.equal(b.connection.joins, 2);
    assert.ok(b.own_timeline_error_m.count > 500);
    if (scope === 'own') assert.equal(b.own_timeline_error_m.max, 0, `seed ${seed}, ${lag} ms`);
    assert.ok(b.own_timeline_error_m.rms < 0.1, `seed ${seed}, ${lag} ms: ${b.own_timeline_error_m.rms} m`);
  }
});

test('trace is CSV with units in its header and a row for each tick', () => {
  for (const id of ['race', 'cannon', 'gambetta', 'eight']) {
    const file = path.join(folder, 'trace.csv');
    const { ticks, duration_s: duration, hash } = run([id, '--duration', '2', '--trace', file]);
    const [header, ...rows] = parseCsv(readFileSync(file, 'utf8'));
    assert.equal(rows.length, ticks + 1);
    assert.equal(new Set(header).size, header.length, 'no name twice');
    assert.deepEqual(header.slice(0, 2), ['time_s', 'tick']);
    // A column has a unit, or counts something.
    for (const name of header)
      assert.match(name, /_(m|s|ms|mps|hz|pct)$|^tick$|_step$|_unacked$|_corrections$|_connect(ion|ed)$|_blackout$/, name);
    rows.forEach((row, i) => {
      assert.equal(row.length, header.length);
      for (const value of row) assert.match(value, /^-?\d+(\.\d+)?([eE][-+]?\d+)?$/);
      assert.equal(Number(row[1]), i);
      assert.ok(Math.abs(Number(row[0]) - (i * duration) / ticks) < 1e-6, `${row[0]} of row ${i}`);
    });
    assert.equal(run([id, '--duration', '2']).hash, hash, 'tracing changes nothing');
    const again = path.join(folder, 'again.csv');
    run([id, '--duration', '2', '--trace', again]);
    assert.equal(readFileSync(again, 'utf8'), readFileSync(file, 'utf8'));
  }
});

// ---- log and replay ----

test('a log of 0.2.0 replays: what scenarios lost since is left out where it had no effect', () => {
  const file = path.join(folder, 'lost.log');
  good(['run', 'rollback', '--duration', '1.5', '--seed', '7', '--log', file]);
  const text = readFileSync(file, 'utf8'),
    hosting = {
      by_player: false,
      host: 0,
      leaves_s: 0,
      every_s: 0,
      leaving: 'silent',
      election: 'lowest_index',
      patience_s: 2,
      meanwhile: 'pause',
    };
  /** @param {object} members */
  const older = (members) => {
    const [first, ...rest] = text.split('\n');
    const line = JSON.parse(first);
    return [JSON.stringify({ ...line, scenario: { ...line.scenario, ...members } }), ...rest].join('\n');
  };
  assert.deepEqual(good(['replay', '-'], older({ spectators: [], hosting })), good(['replay', file]));
  refused(['replay', '-'], ['hosting'], older({ hosting: { ...hosting, by_player: true } }));
  refused(['replay', '-'], ['spectators'], older({ spectators: [{ lag_ms: 40 }] }));
});

test('a run has the same bytes each time, and its log replays to its hash: one of each kind and game', () => {
  const kinds = new Map(ids().map((id) => [KIND.map((name) => scenario(id)[name]).join(), id]));
  assert.ok(kinds.size >= 20, [...kinds.keys()].join(' '));
  for (const id of kinds.values()) checkRepeats(id);
});

test('a log is read from standard input, too', () => {
  const file = path.join(folder, 'run.log');
  run(['race', '--duration', '1.5', '--log', file]);
  assert.equal(good(['replay', '-'], readFileSync(file, 'utf8')), good(['replay', file]));
});

test('the first differing tick of a changed log is reported', () => {
  const file = path.join(folder, 'tampered.log');
  run(['race', '--duration', '1', '--log', file]);
  const lines = readFileSync(file, 'utf8').trimEnd().split('\n');
  const write = (change) => writeFileSync(file, change(lines).join('\n') + '\n');

  /** @param {number} tick */
  const differs = (tick) => {
    const { status, stdout, stderr } = laglab(['replay', file]);
    assert.equal(status, 1, stderr);
    assert.equal(stdout, '');
    assert.match(stderr, new RegExp(`^laglab: [^\\n]*\\btick ${tick}\\b[^\\n]*\\n$`));
  };
  const hashLine = (l) => l.findIndex((line) => line.includes('"tick":37,'));
  write((l) => l.with?.(0, l[0]) ?? l);
  assert.equal(laglab(['replay', file]).status, 0, 'untouched');
  write((l) => l.map((line, i) => (i === hashLine(l) ? line.replace(/"hash":"(.)/, (_, c) => `"hash":"${c === '0' ? '1' : '0'}`) : line)));
  differs(37);
  write((l) => l.map((line, i) => (i === 0 ? line.replace('"lag_ms":150', '"lag_ms":149.9') : line)));
  differs(1); // the lag is part of the state
  write((l) => {
    const at = hashLine(l);
    return [...l.slice(0, at), '{"op":"set","tick":36,"values":{"players.0.lag_ms":10}}', ...l.slice(at)];
  });
  differs(36);
});

test('what is no log is refused', () => {
  refused(['replay'], ['LOG: required']);
  refused(['replay', path.join(folder, 'none.log')], ['cannot read']);
  for (const text of [
    '',
    '\n\n',
    'x',
    '{}',
    '{"op":"head","tick":1}',
    '{"op":"create","laglab_log":2,"scenario":{"kind":"netgame","players":[{}]}}',
    '{"op":"create","laglab_log":1,"scenario":{"kind":"netgame","players":[{}]}}\n{"op":"set","tick":1,"values":{"players.0.lag_ms":-1}}',
    '{"op":"create","laglab_log":1,"scenario":{"kind":"netgame","players":[{}]}}\n' +
      '{"op":"restart","scenario":{"kind":"netgame","players":[{},{}]}}',
  ])
    refused(['replay', '-'], [], text);
});

// ---- refusals ----

test('the schemas of scenarios and experiments in one are those of each, with the definitions of both next to them', () => {
  const all = JSON.parse(good(['schema', 'all'])),
    { $schema, $defs: ofScenario, ...scenario } = schema(),
    { $defs: ofExperiment, $schema: _, ...experiment } = JSON.parse(good(['schema', 'experiment']));
  assert.deepEqual(all, { $schema, $defs: { ...ofScenario, ...ofExperiment, scenario, experiment } });
});

test('three parameters of each type refuse bad values by name and range', async () => {
  const values = await checkBadValues();
  assert.ok(values > 100, `${values} values`);
});

test('unknown paths are refused', () => {
  for (const [setting, ...words] of [
    ['servr.sync=free', 'servr', 'server'],
    ['players.0.lag=3', 'players.0.lag', 'lag_ms'],
    ['players.9.lag_ms=3', 'players.9'],
    ['players.-1.lag_ms=3', 'players'],
    ['players.00.lag_ms=3', 'players.00'],
    ['=3', 'path=value'],
    ['x', 'path=value'],
    ['.=1'],
    ['..=1'],
    ['server.=1'],
    ['server.sync.x=1'],
    ['players=[]', 'players', '1', '64'],
    [`players=[${Array(65).fill('{}').join(',')}]`, 'players', '64'],
    [`players=[${Array(17).fill('{}').join(',')}]`, 'players', '1 to 16 in the game race'],
    ['server=3', 'server'],
    ['params.lap_m=1e9', 'params.lap_m'],
    ['params.gravity_mps2=9', 'gravity_mps2'],
    ['kind=chess', 'kind', 'netgame'],
    [`${'x'.repeat(300)}=1`],
  ])
    refused(['run', 'race', '--duration', '0.1', '--set', setting], words);
});

test('wrong usage is refused', () => {
  refused([], ['no verb;', 'laglab help']);
  refused(['fly'], ['unknown verb fly;', 'laglab help']);
  refused(['run'], ['SCENARIO: required']);
  for (const option of ['--seed', '--set', '--duration', '--trace', '--log', '--scenarios'])
    refused(['run', 'race', option], [option, 'needs a value']);
  for (const option of ['--sed', '-x', '--', '--seed=3', '--TRACE']) refused(['run', 'race', option, '3'], ['unknown option', option]);
  refused(['run', 'race', 'cannon'], ['unexpected argument', 'cannon']);
  refused(['replay', 'a', 'b'], ['unexpected argument', 'b']);
  for (const id of [
    'nosuch',
    'paper/nosuch',
    'RACE',
    'race/',
    '/race',
    '../scenarios/race',
    'paper/../race',
    'ra ce',
    'race.json',
    '',
    'x'.repeat(5000),
  ])
    refused(['run', id], ['scenario']);
  for (const value of ['-1', '1.5', 'x', '', '9007199254740992', '1e400', 'null'])
    refused(['run', 'race', '--seed', value], ['seed', '0', '9007199254740991'].slice(0, /\d/.test(value) ? 3 : 1));
  for (const value of ['0', '-1', '3601', 'x', '', 'NaN', 'inf', '1e400'])
    refused(['run', 'race', '--duration', value], ['duration_s', '0.01', '3600'].slice(0, /^-?\d+$/.test(value) ? 3 : 1));
  refused(['run', 'race', '--duration', '0.1', ...Array(257).fill(['--set', 'seed=1']).flat()], ['--set', '256']);
});

test('what is no scenario is refused', () => {
  for (const [text, ...words] of [
    ['', 'JSON'],
    ['x', 'JSON'],
    ['{"kind":"netgame"', 'JSON'],
    ['{"kind":"netgame","players":[{}]} x', 'JSON', 'column 35'],
    ['[]', 'object'],
    ['null', 'object'],
    ['{}', 'kind'],
    ['{"kind":"netgame"}', 'players'],
    ['{"kind":"netgame","players":[]}', 'players'],
    ['{"kind":"netgame","players":[{}],"colour":1}', 'colour'],
    ['{"kind":"netgame","players":[{"lag_ms":"1"}]}', 'players.0.lag_ms'],
    ['{"kind":"netgame","players":[{"lag_ms":1e999}]}', 'players.0.lag_ms', '1000'],
    ['{"kind":"netgame","game":"race","params":{"gravity_mps2":1},"players":[{}]}', 'gravity_mps2'],
    ['['.repeat(100000), 'nesting'],
    ['\0'],
    ['{"kind":"netgame\\u0000","players":[{}]} x'],
  ])
    refused(['run', '-'], words, text);
});

test('files that cannot be written fail the run', () => {
  for (const option of ['--trace', '--log']) {
    const { status, stdout, stderr } = laglab(['run', 'race', '--duration', '0.1', option, path.join(folder, 'none', 'file')]);
    assert.equal(status, 1);
    assert.equal(stdout, '');
    assert.match(stderr, /^laglab: cannot write [^\n]+\n$/);
  }
});

// ---- methods and problems ----

test('methods and problems are those of the schema', () => {
  const kind = schema().oneOf[1];
  for (const [verb, names] of [
    ['methods', schema().$defs.motion_method.properties.method.enum],
    ['problems', kind.properties.problem.enum],
  ]) {
    const text = good([verb]);
    for (const name of names) assert.match(text, new RegExp(`^${name} `, 'm'));
  }
});

test('--text prints the lines of the paper', () => {
  const md5 = (/** @type {string[]} */ ...args) =>
    createHash('md5')
      .update(good(['run', ...args, '--text']))
      .digest('hex')
      .slice(0, 8);
  assert.equal(md5('paper/fig02'), '8741f2c6');
  assert.equal(md5('paper/fig03'), 'bef53760');
  assert.equal(md5('paper/fig01', '--set', 'paper='), '60ecd924'); // without the program
  assert.equal(md5('paper/fig02', '--set', 'methods.0.dt_s=0.1'), 'acae7536');
  refused(['run', 'rigid/pyramid', '--text'], ['--text', 'rigid']);
  refused(['run', 'motion/orbit', '--text'], ['free_fall', 'kepler']);
});

test('work-precision writes the refinement series as CSV', () => {
  const lines = good(['work-precision', 'free_fall', '--methods', 'explicit_euler,dopri5', '--set', 'g=20']).trimEnd().split('\r\n');
  const names = lines[0].split(',');
  const rows = lines.slice(1).map((line) => Object.fromEntries(line.split(',').map((cell, i) => [names[i], cell])));
  assert.ok(rows.length > 20);
  const euler = rows.filter((row) => row.method === 'explicit_euler');
  for (const row of euler) assert.ok(Math.abs(Number(row.e_final) - 30 * Number(row.value)) < 1e-8, JSON.stringify(row)); // a t dt / 2
  assert.ok(rows.every((row) => row.status === 'ok' && Number(row.cpu_min_s) > 0));
  refused(['work-precision'], ['PROBLEM: must be']);
  refused(['work-precision', 'nothing'], ['nothing', 'laglab problems']);
  refused(['work-precision', 'kepler', '--methods', 'rk4,rk5'], ['rk5', 'laglab methods']);
  refused(['work-precision', 'kepler', '--set', 'e=2'], ['e', '0.999']);
  refused(['work-precision', 'kepler', '--duration', '-1'], ['--duration']);
  refused(['work-precision', 'hires', '--methods', 'boris'], ['boris']);
});

test('work-precision of a scenario writes its refinement series as CSV', () => {
  const lines = good(['work-precision', 'rigid/column', '--methods', 'soft_step,xpbd', '--duration', '1']).trimEnd().split('\r\n');
  const names = lines[0].split(',');
  const rows = lines.slice(1).map((line) => Object.fromEntries(line.split(',').map((cell, i) => [names[i], cell])));
  assert.deepEqual([...new Set(rows.map((row) => row.series))], ['soft_step', 'xpbd']);
  for (const row of rows)
    assert.ok(row.metric === 'sag_m' && Number(row.cpu_min_s) > 0 && row.status === 'ok' && Number(row.error) >= 0, JSON.stringify(row));
  const of = (/** @type {string} */ series, /** @type {string} */ value) =>
    Number(rows.find((row) => row.series === series && row.value === value)?.error);
  assert.ok(of('xpbd', '8') < of('xpbd', '4') / 3);
  refused(['work-precision', 'fluid/cavity', '--methods', 'magic'], ['fluid/cavity', 'magic']);
  refused(['work-precision', 'fluid/cavity', '--set', 'params.n=1', '--methods', 'jacobi'], ['n']);
});

test('work-precision of a netgame: a mean over seeds with its interval, and a page that draws every method', () => {
  const series = (/** @type {string[]} */ ...more) =>
    JSON.parse(good(['work-precision', 'hermite', '--duration', '8', '--format', 'json', ...more]));
  const rows = series('--seeds', '12', '--report', 'hermite.html'),
    other = series('--seeds', '2');
  assert.deepEqual([...new Set(rows.map((/** @type {any} */ row) => row.series))], ['linear', 'hermite']);
  for (const row of rows) {
    assert.ok(row.error_low < row.error && row.error < row.error_high && row.seeds === 12 && row.cpu_min_s > 0, JSON.stringify(row));
    assert.equal(row.metric, 'players.0.timeline_error_m.mean');
  }
  assert.deepEqual(
    other.map((/** @type {any} */ row) => [row.seeds, row.error_low]),
    rows.map(() => [2, null]),
    'two seeds have no interval',
  );
  const page = readFileSync(path.join(folder, 'hermite.html'), 'utf8'),
    { kind, command, levels } = JSON.parse(/id="head">([^<]*)</.exec(page)[1]);
  assert.deepEqual([kind, command], ['work-precision', 'laglab work-precision hermite']);
  assert.deepEqual(
    levels.map((/** @type {any} */ level) => [level.series, level.value, level.cpu_s, level.count, level.y, level.low, level.high]),
    rows.map((/** @type {any} */ row) => [
      ...[row.series, row.value, row.cpu_min_s, row.count, row.error],
      ...[row.error_low, row.error_high],
    ]),
  );
  refused(['work-precision', 'hermite', '--seeds', '0'], ['--seeds', '1']);
});

test('work-precision writes every format of sweep', () => {
  const args = ['work-precision', 'free_fall', '--methods', 'explicit_euler', '--duration', '1'];
  const untimed = (/** @type {Record<string, any>[]} */ rows) => rows.map((row) => ({ ...row, cpu_min_s: 0, cpu_median_s: 0 }));
  const rows = JSON.parse(good([...args, '--format', 'json']));
  assert.ok(rows.length > 10);
  assert.deepEqual(
    [rows[0].problem, rows[0].method, rows[0].setting, rows[0].value, rows[0].steps, rows[0].order_observed],
    ['free_fall', 'explicit_euler', 'dt_s', 1 / 16, 16, null],
  );
  assert.ok(Math.abs(rows[1].order_observed - 1) < 1e-6);
  const [names, ...lines] = good(args)
    .trimEnd()
    .split('\r\n')
    .map((line) => line.split(','));
  assert.deepEqual(names, Object.keys(rows[0]));
  assert.deepEqual(
    untimed(
      lines.map((cells) =>
        Object.fromEntries(cells.map((cell, i) => [names[i], cell === '' ? null : Number.isNaN(Number(cell)) ? cell : Number(cell)])),
      ),
    ),
    untimed(rows),
  );
  assert.equal(good([...args, '--out', 'series.ndjson']), '');
  assert.deepEqual(
    untimed(
      readFileSync(path.join(folder, 'series.ndjson'), 'utf8')
        .trimEnd()
        .split('\n')
        .map((line) => JSON.parse(line)),
    ),
    untimed(rows),
  );
  const column = JSON.parse(good(['work-precision', 'rigid/column', '--methods', 'xpbd', '--duration', '0.1', '--format', 'json']));
  assert.deepEqual(
    column.map((/** @type {{value: number}} */ row) => row.value),
    [1, 2, 4, 8, 16, 32],
  );
  assert.deepEqual(
    [column[0].scenario, column[0].by, column[0].series, column[0].metric, column[0].order_observed],
    ['rigid/column', 'solver.method', 'xpbd', 'sag_m', null],
  );
  refused([...args, '--format', 'xml'], ['--format', 'json', 'xml']);
  refused([...args, 'kepler'], ['kepler']);
});

// ---- lists ----

test('scenarios lists every file', () => {
  const lines = good(['scenarios']).trimEnd().split('\n');
  assert.deepEqual(lines.map((line) => line.split(/ +/)[0]).sort(), ids());
  for (const line of lines) {
    const of = scenario(line.split(/ +/)[0]);
    assert.ok(line.includes(of.title) && line.includes(of.paper ?? ''), line);
  }
  assert.equal(good(['scenarios', '--scenarios', SCENARIOS]), good(['scenarios']));
});

test('every scenario fits the schema, which is a schema', () => {
  const ajv = new Ajv2020({ strict: true, allErrors: true, keywords: ['x-unit', 'x-live'] });
  const root = schema();
  assert.equal(root.$schema, 'https://json-schema.org/draft/2020-12/schema');
  assert.ok(ajv.validateSchema(root), ajv.errorsText());
  const fits = ajv.compile(root);
  for (const id of ids()) {
    assert.ok(fits(scenario(id)), `${id}: ${ajv.errorsText(fits.errors)}`);
  }
  for (const wrong of [
    {},
    { kind: 'netgame' },
    { kind: 'netgame', players: [] },
    { kind: 'netgame', players: [{ lag_ms: -1 }] },
    { kind: 'netgame', players: [{}], x: 1 },
    { kind: 'netgame', players: Array(65).fill({}) },
    { kind: 'netgame', players: [{}], game: 'chess' },
    { kind: 'netgame', players: [{ link: { up: { loss_pct: 101 } } }] },
  ])
    assert.ok(!fits(wrong), JSON.stringify(wrong));
});

test('help and version', () => {
  const help = good(['help']);
  assert.equal(good(['--help']), help);
  assert.equal(good(['-h']), help);
  for (const verb of ['serve', 'run', 'replay', 'scenarios', 'schema', 'methods', 'problems', 'work-precision', 'healthcheck', 'help'])
    assert.match(help, new RegExp(`^ +laglab ${verb}\\b`, 'm'));
  for (const option of ['--set', '--seed', '--duration', '--trace', '--log']) assert.ok(help.includes(option), option);
  const version = /** @type {{version: string}} */ (JSON.parse(readFileSync(path.join(ROOT, 'package.json'), 'utf8'))).version;
  assert.match(good(['--version']), new RegExp(`^laglab ${version.replaceAll('.', '\\.')}\\+[0-9a-f]{12}\n$`));
});

test('files of measured links become profiles of a scenario, and what they cannot say is refused', () => {
  const capacity = path.join(folder, 'capacity.trace'),
    delays = path.join(folder, 'delays.csv');
  writeFileSync(capacity, '0\n40\n40\n100\n');
  writeFileSync(delays, 't_ms,delay_ms,lost\n0,12.5,0\n1000,300,0\n');
  const profile = { trace_t_ms: [0, 1000], trace_delay_ms: [12.5, 300], trace_lost: [0, 0] };
  assert.deepEqual(JSON.parse(good(['link-trace', capacity])), { capacity_ms: [0, 40, 40, 100] });
  assert.deepEqual(JSON.parse(good(['link-trace', delays])), profile);

  const race = JSON.parse(readFileSync(path.join(SCENARIOS, 'race.json'), 'utf8'));
  const run = (/** @type {any} */ scenario, /** @type {string[]} */ ...more) => {
    const { hash, metrics } = JSON.parse(good(['run', '-', '--duration', '20', ...more], JSON.stringify(scenario)));
    return { hash, metrics };
  };
  const given = structuredClone(race);
  given.profiles = [profile, { capacity_ms: [0, 40, 40, 100] }];
  Object.assign(given.players[0], { link: { ...given.players[0].link, down: { profile: 'profile_0' } } });
  Object.assign(given.players[1], { link: { ...given.players[1].link, up: { profile: 'profile_1' } } });
  const [byFiles, byHand] = [
    run(race, '--link-trace', `players.0.link.down=${delays}`, '--link-trace', `players.1.link.up=${capacity}`),
    run(given),
  ];
  assert.equal(byFiles.hash, byHand.hash);
  assert.deepEqual(byFiles.metrics, byHand.metrics);
  const { delay_min_ms: least, delay_max_ms: most } = byFiles.metrics.players[0].link_down;
  assert.equal(Math.round((most - least) * 1e6) / 1e6, 287.5);
  assert.ok(byFiles.metrics.players[1].link_up.queue_max_ms > 0);

  refused(['link-trace', path.join(folder, 'none.csv')], ['cannot read']);
  refused(['link-trace'], ['FILE is missing']);
  refused(['run', 'race', '--scenarios', SCENARIOS, '--link-trace', capacity], ['--link-trace: must be PATH=FILE']);
  refused(['run', 'race', '--scenarios', SCENARIOS, '--link-trace', `players.9.link.up=${capacity}`], ['must name a direction of a link']);
  refused(['run', 'race', '--scenarios', SCENARIOS, '--link-trace', `players.0.wire=${capacity}`], ['players.0.wire']);
  writeFileSync(delays, 't_ms,delay_ms,lost\n0,12.5,0\n1000,300\n');
  refused(['link-trace', delays], ['delays.csv, line 3, lost: must be there, after a comma; got 1000,300']);
});
