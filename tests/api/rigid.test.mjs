// Rigid bodies from outside: what a run prints, what a session lets change, and what is refused.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { client } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
const BINARY = path.resolve(process.env.LAGLAB_BIN ?? path.join(ROOT, 'build/laglab'));

let daemon, c, folder;
before(async () => {
  folder = mkdtempSync(path.join(tmpdir(), 'laglab-rigid-'));
  daemon = await startDaemon();
  c = client(daemon.url);
});
after(async () => {
  c.close();
  await daemon.stop();
  rmSync(folder, { recursive: true, force: true });
});

/** @param {string[]} args @param {any} [input] */
function laglab(args, input) {
  return spawnSync(BINARY, args, {
    cwd: folder,
    input: input && JSON.stringify(input),
    encoding: 'utf8',
    maxBuffer: 1 << 28,
    timeout: 600000,
  });
}

/** @param {any} scenario a document, or an id @param {string[]} more */
function run(scenario, ...more) {
  const byId = typeof scenario === 'string';
  const result = laglab(['run', byId ? scenario : '-', ...more], byId ? undefined : scenario);
  assert.equal(result.status, 0, result.stderr);
  return JSON.parse(result.stdout);
}

const near = (value, wanted, tolerance, what) => assert.ok(Math.abs(value - wanted) <= tolerance, `${what}: ${value} instead of ${wanted}`);
const GROUND = { type: 'static', shape: 'box', size: [40, 1], position: [0, -0.5] };
const rigid = (bodies, more = {}) => ({
  kind: 'rigid',
  gravity: [0, -10],
  duration_s: 2,
  hz: 60,
  solver: { method: 'soft_step', substeps: 4 },
  bodies,
  joints: [],
  ...more,
});

/** A result without what a clock measured. */
function stripped(result) {
  const clocks = new Set(['wall_s', 'ns_per_sim_s', 'ns_per_test']);
  return JSON.stringify(result, (key, value) => (clocks.has(key) ? 0 : value));
}

test('the contract: bodies in, places out, the same bytes each time', () => {
  const scenario = rigid([
    GROUND,
    {
      type: 'dynamic',
      shape: 'box',
      size: [1, 1],
      position: [0, 0.5],
      angle: 0,
      velocity: [0, 0],
      density: 1,
      friction: 0.6,
      restitution: 0,
    },
    { shape: 'circle', radius: 0.5, position: [5, 3] },
    { shape: 'capsule', size: [2, 0.5], position: [-5, 0.25] },
    {
      shape: 'polygon',
      points: [
        [-0.5, 0],
        [0.5, 0],
        [0, 1],
      ],
      position: [9, 0],
    },
  ]);
  const one = run(scenario),
    other = run(scenario);
  assert.equal(stripped(one), stripped(other));
  assert.equal(one.ticks, 120);
  const bodies = one.metrics.bodies;
  assert.equal(bodies.length, 5);
  near(bodies[1].position[1], 0.5, 0.002, 'the box on the ground');
  near(bodies[2].position[1], 0.5, 0.002, 'the ball on the ground');
  near(bodies[3].position[1], 0.25, 0.002, 'the capsule on the ground');
  near(bodies[4].angle, 0, 0.01, 'the triangle on its side');
  for (const body of bodies)
    assert.deepEqual(Object.keys(body), ['body', 'type', 'position', 'angle', 'velocity', 'angular_velocity', 'awake']);
  for (const name of ['broad', 'narrow', 'solve', 'continuous', 'finish', 'all'])
    assert.ok(one.cost.parts[0][name].ns_per_sim_s >= 0, name);
});

test('friction holds below atan(mu), and not above', () => {
  const slope = (/** @type {number} */ degrees) => {
    const g = (10 * Math.PI * degrees) / 180 / 10;
    const body = run(
      rigid(
        [GROUND, { position: [0, 0.5], friction: 0.5 }].map((b) => ({ ...b, friction: 0.5 })),
        { gravity: [10 * Math.sin(g), -10 * Math.cos(g)], duration_s: 3, solver: { sleep: false } },
      ),
    ).metrics.bodies[1];
    return body.position[0];
  };
  const limit = (180 / Math.PI) * Math.atan(0.5);
  assert.ok(slope(limit - 0.5) < 0.005, `slides ${slope(limit - 0.5)} m`);
  assert.ok(slope(limit + 0.5) > 0.1, `slides ${slope(limit + 0.5)} m`);
});

test('every width of SIMD and every broad phase gives the same hash; a solver gives another', () => {
  const hash = (...sets) => run('rigid/tumbler', '--duration', '1', ...sets.flatMap((set) => ['--set', set])).hash;
  const want = hash();
  for (const set of [
    'solver.simd=scalar',
    'solver.simd=sse2',
    'solver.simd=avx2',
    'broad_phase=brute',
    'broad_phase=sap',
    'broad_phase=tree',
  ])
    assert.equal(hash(set), want, set);
  assert.notEqual(hash('solver.method=pgs'), want);
});

test('4,096 bodies in a list run; sessions without a list pay nothing for it', async () => {
  const bodies = Array.from({ length: 4095 }, (_, i) => ({ size: [0.5, 0.5], position: [(i % 64) - 32, 0.25 + 0.5 * Math.floor(i / 64)] }));
  const result = run(rigid([{ ...GROUND, size: [100, 1] }, ...bodies], { duration_s: 0.05 }));
  assert.equal(result.metrics.body_count, 4096);
  assert.ok(result.cost.block_bytes < 64e6, String(result.cost.block_bytes));
  const session = await c.make({ scenario: 'rigid/pyramid', paused: true });
  assert.ok((await c.get(`/api/v1/sessions/${session.id}`)).json.cost.parked_bytes < 60000);
});

test('volumes: what each overestimates, and its price', () => {
  const { volumes } = run('paper/fig05').metrics;
  near(volumes.sphere.area_overestimated_pct, 100 * ((Math.PI * 10) / 4 / 3 - 1), 1e-6, 'the circle around 3 m x 1 m');
  near(volumes.obb.area_overestimated_pct, 0, 1e-9, 'a rectangle is its own OBB');
  assert.ok(volumes.sphere.false_hits > volumes.aabb.false_hits && volumes.aabb.false_hits > 0 && volumes.obb.false_hits === 0);
  for (const one of Object.values(volumes)) assert.ok(one.ns_per_test > 0 && one.missed_hits === 0);
  const price = Object.fromEntries(
    Object.entries(run('rigid/rugged_wall', '--duration', '0.1').metrics.volumes).map(([name, one]) => [name, one.ns_per_test]),
  );
  assert.ok(price.sphere < price.obb && price.aabb < price.exact / 3 && price.obb < price.exact / 3, JSON.stringify(price));
});

test('bullets: none passes a swept wall, and as many as theory says an unswept one', () => {
  const { metrics } = run('rigid/bullets');
  assert.equal(metrics.tunnelled, 0);
  const share = 1 - (0.05 + 0.1) / (100 / 60),
    error = Math.sqrt((share * (1 - share)) / 200);
  near(metrics.side_by_side[0].tunnelled / 200, share, 3 * error, 'share that passed');
  const fast = run('rigid/bullets_500').metrics;
  assert.equal(fast.tunnelled, 0);
});

test("beginner's impulses bring the stack down, the default solver does not", () => {
  const { metrics } = run('rigid/collapsing_stack');
  assert.ok(metrics.tilt_worst_rad > 1 && metrics.energy_added_j > 1, JSON.stringify(metrics.tilt_worst_rad));
  assert.ok(
    metrics.side_by_side[0].tilt_rad < 0.001 && metrics.side_by_side[0].sag_m < 0.01 && metrics.side_by_side[0].energy_added_j < 0.01,
  );
});

test('a trace has a column for each quantity, a row for each tick', () => {
  run('rigid/ball_chain', '--duration', '0.5', '--trace', 'trace.csv');
  const [head, ...rows] = readFileSync(path.join(folder, 'trace.csv'), 'utf8')
    .trim()
    .split('\r\n')
    .map((line) => line.split(','));
  for (const name of ['kinetic_j', 'sag_m', '0_x_m', 'side_by_side0_joint_error', 'side_by_side0_7_angle_rad'])
    assert.ok(head.includes(name), name);
  assert.equal(rows.length, 31);
  for (const row of rows) assert.equal(row.length, head.length);
});

test('a log replays to the same hashes, and a changed one does not', () => {
  run('rigid/rain', '--duration', '2', '--log', 'rain.log');
  assert.equal(laglab(['replay', 'rain.log']).status, 0);
  const text = readFileSync(path.join(folder, 'rain.log'), 'utf8').replace('"gravity":[0,-10]', '"gravity":[0,-9]');
  writeFileSync(path.join(folder, 'changed.log'), text);
  assert.equal(laglab(['replay', 'changed.log']).status, 1);
});

test('a solver that loses a body fails the run, with the step and the body named', () => {
  const result = laglab(['run', '-'], rigid([{}, { position: [9.9e8, 0], velocity: [1e6, 0] }], { duration_s: 20 }));
  assert.equal(result.status, 1);
  assert.match(result.stderr, /^laglab: soft_step diverged in step \d+: body 2 is at \(/);
});

test('bad input is a sentence with field, range and value, on the command line and over HTTP', async () => {
  /** @type {[any, ...string[]][]} a scenario, and words of the sentence */
  const bad = [
    [rigid([{ density: 0 }]), 'bodies.0.density', '1e-06 to', 'got 0'],
    [rigid([{ density: -2 }]), 'bodies.0.density', 'got -2'],
    [rigid([{ position: [1e10, 0] }]), 'bodies.0.position', '1000000000 m'],
    [
      rigid([
        {
          shape: 'polygon',
          points: [
            [0, 0],
            [2, 0],
            [1, 0.3],
            [1, 2],
          ],
        },
      ]),
      'bodies.0',
      'not convex',
    ],
    [
      rigid([
        {
          shape: 'polygon',
          points: [
            [0, 0],
            [1, 1],
            [2, 2],
          ],
        },
      ]),
      'bodies.0',
      'degenerate',
    ],
    [rigid([{ shape: 'star' }]), 'bodies.0.shape', 'polygon'],
    [rigid([{ mass: 1 }]), 'bodies.0.mass', 'unknown'],
    [rigid(Array.from({ length: 4097 }, () => ({}))), 'bodies', 'at most 4096 elements; got 4097'],
    [rigid([{}], { solver: { method: 'perfect' } }), 'solver.method', 'soft_step'],
    [rigid([{}], { side_by_side: { method: 'pgs' } }), 'side_by_side', 'an array'],
    [rigid([{}], { side_by_side: [{ solver: { method: 'perfect' } }] }), 'side_by_side.0.solver.method', 'soft_step'],
    [rigid([{}], { side_by_side: [{}, {}, {}] }), 'side_by_side', 'at most 2 elements; got 3'],
    [{ kind: 'rigid', scene: 'pyramid', params: { size: 100000 } }, 'params.size', '1048576'],
    [{ kind: 'rigid', scene: 'pyramid', params: { size: 1000 } }, 'params.size', 'MB'],
    [
      { kind: 'rigid', scene: 'confined', params: { size: 1 } },
      'params of confined: position.x',
      'must be finite',
    ] /* detected only when the scene is built */,
  ];
  for (const [scenario, ...words] of bad) {
    const result = laglab(['run', '-'], scenario);
    assert.equal(result.status, 2, JSON.stringify(scenario).slice(0, 200));
    const answer = await c.call('POST', '/api/v1/sessions', { body: { scenario } });
    assert.ok([400, 422].includes(answer.status), answer.text);
    assert.ok(answer.json.errors[0].field.length > 0, answer.text);
    for (const word of words) {
      assert.ok(result.stderr.includes(word), `${word}: ${result.stderr}`);
      assert.ok(answer.text.includes(word), `${word}: ${answer.text}`);
    }
  }
  assert.equal(laglab(['run', '-'], '{"kind":"rigid","bodies":[{"density":1e999}]}').status, 2);
});

test('every choice of a step changes while it runs, and what lays out memory does not', async () => {
  const session = await c.make({ scenario: 'rigid/pyramid', paused: true });
  await c.control(session, { op: 'step', ticks: 10 });
  const changes = {
    gravity: [1, -9],
    broad_phase: 'tree',
    compare_volumes: true,
    tunnel_x: 3,
    'solver.method': 'avbd',
    'solver.bounding_volume': 'obb',
    'solver.continuous': 'swept',
    'solver.sleep': false,
    'solver.recycle': false,
    'solver.warm_start': false,
    'solver.iterations': 20,
  };
  for (const [name, value] of Object.entries(changes)) {
    const answer = await c.patch(session, { [name]: value });
    assert.equal(answer.status, 200, answer.text);
    assert.equal(answer.json.tick, 10);
    const got = name.split('.').reduce((at, part) => at[part], answer.json.params);
    assert.deepEqual(got, value, name);
  }
  await c.control(session, { op: 'step', ticks: 30 });
  const { metrics } = (await c.get(`/api/v1/sessions/${session.id}/metrics`)).json;
  assert.equal(metrics.method, 'avbd');
  assert.ok(metrics.volumes.aabb.tests > 0 && metrics.recycled === 0 && metrics.tunnelled > 0);
  for (const fixed of [{ scene: 'column' }, { params: { size: 3 } }, { hz: 30 }])
    assert.equal((await c.patch(session, fixed)).status, 409, JSON.stringify(fixed));
  const more = await c.patch(session, { side_by_side: [{}] });
  assert.equal(more.status, 400);
  assert.match(more.text, /side_by_side has 0 elements/);
});

test('a body is dragged by inputs of the owner, and the log has them', async () => {
  const session = await c.make({ scenario: rigid([GROUND, { position: [0, 0.5] }], { duration_s: 20 }), paused: true });
  const stream = await c.stream(session, 'json');
  const [left, right, bottom, top] = stream.hello.layout.rigid.view;
  const axes = (x, y) => [(2 * x - left - right) / (right - left), (2 * y - bottom - top) / (top - bottom)];
  stream.say({ input: { player: 0, axes: axes(0, 0.5), buttons: 1 }, id: 1 });
  assert.equal((await stream.wait((m) => m.type === 'error')).problem.status, 403, 'without a key');
  stream.say({ auth: session.owner_key, id: 2 });
  await stream.wait((m) => m.id === 2);
  stream.say({ input: { player: 0, axes: axes(0, 0.5), buttons: 1 }, id: 3 });
  await stream.wait((m) => m.id === 3 && m.ok);
  await c.control(session, { op: 'step', ticks: 1 });
  stream.say({ input: { player: 0, axes: axes(1, 1.5), buttons: 1 }, id: 4 });
  await stream.wait((m) => m.id === 4 && m.ok);
  await c.control(session, { op: 'step', ticks: 120 });
  const frame = await stream.frame((f) => f.tick === 121);
  assert.equal(frame.worlds[0].dragging, true);
  assert.ok(frame.joints.some((joint) => joint.type === 'mouse' && Math.abs(joint.ax - 1) < 2e-4));
  const body = frame.shapes.find((shape) => shape.flags.includes('dynamic'));
  near(body.x, 1, 0.01, 'x');
  near(body.y, 1.5, 0.02, 'y');
  const log = (await c.get(`/api/v1/sessions/${session.id}/log`)).text;
  assert.equal(log.split('\n').filter((line) => line.includes('"input"')).length, 2);
  await stream.close();
});

test('a scenario for every scene that is known to be hard', () => {
  const schema = JSON.parse(laglab(['schema']).stdout);
  const kind = schema.oneOf.find((one) => one.properties.kind.const === 'rigid');
  const scenes = kind.properties.scene.enum.filter((name) => !['none', 'figure_5'].includes(name));
  const files = readdirSync(path.join(ROOT, 'scenarios/rigid')).map(
    (name) => JSON.parse(readFileSync(path.join(ROOT, 'scenarios/rigid', name), 'utf8')).scene,
  );
  for (const scene of scenes) assert.ok(files.includes(scene), scene);
});
