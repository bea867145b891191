// The paper, place by place: docs/paper.md names what is there, and `laglab run ... --text` prints the values of the paper's figures.
import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { test } from 'node:test';
import { ROWS, library, shown } from '../../docs/paper.mjs';
import { BINARY } from '../lib/daemon.mjs';

/** @param {string[]} args @returns {string} */
const text = (...args) => execFileSync(BINARY, ['run', ...args, '--text'], { encoding: 'utf8' });
const near = (/** @type {number} */ a, /** @type {number} */ b, /** @type {number} */ tol) =>
  assert.ok(Math.abs(a - b) <= tol, `${a}, not within ${tol} of ${b}`);

// ---- the table ----

test('each statement of the paper has a scenario, or one that is awaited; every lesson and scenario of a figure is in its row', () => {
  const { scenarios, lessons } = library();
  assert.equal(ROWS.length, 24);
  const all = ROWS.flatMap((row) => {
    const these = [...shown(row, 'scenarios', scenarios), ...shown(row, 'lessons', lessons)];
    assert.ok(these.length > 0 || (row.coming ?? []).length > 0, row.says);
    return these.map(({ id }) => id);
  });
  for (const { id, paper } of [...scenarios, ...lessons])
    if (/^Figure \d+$/.test(paper ?? '')) assert.ok(all.includes(id), `${id} shows ${paper}`);
  for (let figure = 1; figure <= 13; figure++)
    assert.ok(
      ROWS.some(({ places }) => places?.includes(`Figure ${figure}`)),
      `Figure ${figure}`,
    );
  assert.deepEqual([...all].sort(), [...new Set(all)].sort(), 'each once');
});

// ---- Figures 1 to 4 ----

/** The lines as the paper prints them: t, velocity, displacement. */
const FIGURE_2 = `0.000000 0.000000 0.000000
0.500000 5.000000 2.500000
1.000000 10.000000 7.500000
1.500000 15.000000 15.000000
2.000000 20.000000 25.000000
2.500000 25.000000 37.500000
3.000000 30.000000 52.500000
3.500000 35.000000 70.000000
4.000000 40.000000 90.000000
4.500000 45.000000 112.500000
5.000000 50.000000 137.500000`;
const FIGURE_3 = `0.000000 0.000000 0.000000
0.300000 3.000000 0.900000
0.600000 6.000000 2.700000
0.900000 9.000000 5.400000
1.200000 12.000000 9.000000
1.500000 15.000000 13.500000
1.800000 18.000000 18.900000
2.100000 21.000000 25.200001
2.400000 24.000000 32.400002
2.700000 27.000000 40.500000
3.000000 30.000000 49.500000
3.300000 33.000000 59.400002
3.600000 36.000000 70.200005
3.900000 39.000000 81.900009
4.200000 42.000000 94.500008
4.500000 45.000000 108.000008
4.800000 48.000000 122.400009`;

/** @param {string} table */
const printed = (table) =>
  table
    .split('\n')
    .map((line) => line.split(' '))
    .map(([t, v, s]) => `t = ${t}, velocity = ${v}, displacement = ${s}\n`)
    .join('');

test('Figures 2 and 3: the lines of the paper, to the last digit', () => {
  assert.equal(text('paper/fig02'), printed(FIGURE_2));
  assert.equal(text('paper/fig03'), printed(FIGURE_3));
});

test('Figure 1: the printed program, compiled, prints the lines that follow it', () => {
  const [, program = '', lines = ''] = /^(.*\n\}\n)\n(t = .*)$/s.exec(text('paper/fig01')) ?? [];
  for (const line of ['float dt = 0.033;', 'float acceleration = 10.0f;', 'while (t <= 5.0)', 't += dt;'])
    assert.ok(program.includes(line), line);
  const order = ['velocity = velocity + acceleration * dt;', 'displacement = displacement + velocity * dt;'].map((line) =>
    program.indexOf(line),
  );
  assert.ok(0 < order[0] && order[0] < order[1], 'the velocity is updated first');
  const folder = mkdtempSync(path.join(tmpdir(), 'laglab-paper-')),
    run = (/** @type {string} */ file, /** @type {string[]} */ args) => {
      const { status, stdout, stderr, error } = spawnSync(file, args, { encoding: 'utf8' });
      assert.equal(status, 0, `${file}: ${error ?? stderr}`);
      return stdout;
    };
  try {
    writeFileSync(path.join(folder, 'listing.c'), program);
    run('cc', ['-O0', '-ffp-contract=off', '-o', path.join(folder, 'listing'), path.join(folder, 'listing.c')]);
    assert.equal(run(path.join(folder, 'listing'), []), lines);
  } finally {
    rmSync(folder, { recursive: true });
  }
});

test('Figure 4: the table at 3 s; the paper cuts digits off', () => {
  const [head = '', ...rows] = text('paper/fig04').trimEnd().split('\n');
  for (const column of ['Timestep (dt) (s)', 'Timestamp (s)', 'Velocity (m/s)', 'Displacement (m)'])
    assert.ok(head.includes(column), column);
  const cells = rows.map((row) => row.trim().split(/\s+/).map(Number));
  assert.deepEqual(
    cells.map(([dt, t, v]) => [dt, t, v]),
    [
      [0.5, 3, 30],
      [0.3, 3, 30],
      [0.1, 3, 30],
      [0.033, 3.003, 30.03],
    ],
  );
  /* semi-implicit Euler from rest: a t (t + dt) / 2, in single precision */
  for (const [dt = 0, t = 0, , s = 0] of cells) near(s, 5 * t * (t + dt), 1e-4);
  assert.deepEqual(
    cells.map(([, , , , paper]) => paper),
    [52, 49, 46, 45.58],
  );
  for (const [, , , s = 0, paper = 0] of cells) assert.ok(s >= paper && s - paper < 1, `${s} is printed as ${paper}`);
  const other = text('paper/fig04', '--set', 'methods.0.dt_s=0.25').trimEnd().split('\n')[1] ?? '';
  assert.match(other, /^\s+0\.250\s+3\.000\s+30\.000\s+48\.750000\s*$/, 'a step that the paper lacks');
});

// ---- Figures 6 to 13 ----

/** Times of the first events, ms. @param {string} all @returns {{ms: number, what: string}[]} */
const eventsOf = (all) => [...all.matchAll(/^ *(\d+) ms {3}(.*)$/gm)].map(([, ms, what = '']) => ({ ms: Number(ms), what }));
/** @param {string} all @param {string} name */
const arrivalsOf = (all, name) =>
  (new RegExp(`^Updates arrive at ${name} \\(ms\\): (.*)$`, 'm').exec(all)?.[1] ?? '').split(' ').map(Number);
const gapsOf = (/** @type {number[]} */ times) => times.slice(1).map((time, i) => time - (times[i] ?? 0));
const caption = (/** @type {string} */ name, /** @type {string} */ lag, /** @type {string} */ boxes) => {
  const [p, r, i] = [...boxes].map((box) => `[${box}]`);
  return `PLAYER ${name}   Lag = ${lag} ms   Prediction ${p}   Reconciliation ${r}   Interpolation ${i}\n`;
};

test('Figures 6 and 7: the loops', () => {
  const client = text('paper/fig06'),
    server = text('paper/fig07');
  for (const line of [
    'msg_process_time = cur_timestamp + client_network_lag',
    'Check for server world updates',
    'Render world',
    'sleep(x)',
  ])
    assert.ok(client.includes(line) && !server.includes(line), line);
  for (const line of ['Check for new inputs in the shared buffer', 'Validate inputs', 'Sleep until next refresh time'])
    assert.ok(server.includes(line) && !client.includes(line), line);
  assert.equal(eventsOf(client).find(({ what }) => what.includes('of A arrives'))?.ms, 250, 'the lag of the stamp');
});

test('Figure 8: 250 ms, three updates a second, evenly spaced', () => {
  const all = text('paper/fig08');
  assert.ok(all.includes(caption('A', '250', '   ')) && all.includes('Server view - Update 3 times per second\n'), all);
  const gaps = gapsOf(arrivalsOf(all, 'A'));
  assert.ok(gaps.length >= 4);
  for (const gap of gaps) near(gap, 1000 / 3, 1);
});

test('Figure 9: 10 to 500 ms, unevenly spaced; the last acknowledged input of player 0', () => {
  const all = text('paper/fig09'),
    gaps = gapsOf(arrivalsOf(all, 'A'));
  assert.ok(all.includes(caption('A', '10 to 500', '   ')) && all.includes('Server view - Update 3 times per second\n'), all);
  assert.ok(Math.max(...gaps) - Math.min(...gaps) > 100, gaps.join());
  /* 60 inputs a second, each back after two ways and the wait for an update: at most 500 + 333 + 500 ms */
  const acked = Number(/^Last acknowledged input after 30 s: Player 0: #(\d+), Player 1: #\d+$/m.exec(all)?.[1]);
  assert.ok(acked <= 1800 && acked >= 1800 - 60 * 1.4, `#${acked}`);
});

test('Figure 10: 0, 150, 250, 283, 433 and 533 ms', () => {
  assert.deepEqual(
    eventsOf(text('paper/fig10')).map(({ ms }) => ms),
    [0, 0, 150, 250, 283, 433, 533],
  );
});

test('Figure 11: the server first, then A, then B', () => {
  const all = text('paper/fig11');
  assert.ok(all.startsWith(`${caption('A', '150', '   ')}Server view - Update 30 times per second\n${caption('B', '250', '   ')}`), all);
  const state = eventsOf(all).filter(({ what }) => what.includes('world state'));
  assert.deepEqual(
    state.map(({ what }) => what),
    ['the server sends the world state of step 1', 'the world state of step 1 arrives at A', 'the world state of step 1 arrives at B'],
  );
});

test('Figures 12 and 13: both predict, and reconcile; the first input is rendered at once and acknowledged after the round trip', () => {
  for (const [id, hz] of /** @type {const} */ ([
    ['paper/fig12', 10],
    ['paper/fig13', 30],
  ])) {
    const all = text(id);
    for (const name of ['A', 'B']) assert.ok(all.includes(caption(name, '150', 'xx ')), all);
    assert.ok(all.includes(`Server view - Update ${hz} times per second\n`), all);
    const events = eventsOf(all);
    assert.match(events[0]?.what ?? '', /^A sends input \d+ and renders it at once$/);
    assert.equal(events[0]?.ms, 0);
    const back = events.find(({ what }) => what.endsWith('arrives at A'))?.ms ?? 0;
    assert.ok(back >= 300 && back <= 300 + 1000 / hz + 1000 / 60, `${back} ms`);
  }
});

test('every netgame has a text, other kinds have none', () => {
  assert.match(text('deterministic', '--duration', '3'), /^PLAYER A .*\nServer view - Update \d+ times per second\nPLAYER B /);
  assert.match(text('transport_tcp', '--duration', '3'), /the world state of step \d+ arrives at B\n/);
  const { status, stderr } = spawnSync(BINARY, ['run', 'rigid/pyramid', '--text'], { encoding: 'utf8' });
  assert.equal(status, 2);
  assert.match(stderr, /--text: kind must be motion or netgame; got rigid/);
});
