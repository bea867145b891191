// Particle fluids of npm in the pool of bench/fluid.c: fluid.mjs PEER ROUNDS. Prints CSV, a line a round.
//
// 10,000 particles, 0.05 m apart, in a tank of 20 m; half a metre higher on the left. Frames of 1/60 s, with as many iterations of the
// particles as the library recommends. Both are LiquidFun (pressure from an overlap of particles, weakly compressible): in TypeScript,
// and in C++ as WebAssembly with SIMD.
import { readFile } from 'node:fs/promises';
import { createRequire } from 'node:module';
import { compression } from '../compression.mjs';

const require = createRequire(import.meta.url);
const [peer, rounds] = [process.argv[2], Number(process.argv[3])];
const FRAME = 1 / 60,
  SPACING = 0.05;
const FRAMES = peer === 'box2d.ts' ? 20 : 60; // of a round
const pool = {
  width: 20,
  height: 3,
  fills: [
    { x: 0, y: 0, width: 10, height: 1.5 },
    { x: 10, y: 0, width: 10, height: 1 },
  ],
};

/** `places`: x, y of each particle. @type {Record<string, () => Promise<{step: () => void, places: () => ArrayLike<number>}>>} */
const peers = {
  'box2d.ts': async () => {
    const core = await import('@box2d/core'),
      particles = await import('@box2d/particles');
    const world = core.b2World.Create({ x: 0, y: -10 });
    const walls = world.CreateBody();
    const corners = [
      [0, pool.height],
      [0, 0],
      [pool.width, 0],
      [pool.width, pool.height],
    ].map(([x, y]) => ({ x, y }));
    for (let i = 0; i < 3; i++) {
      const edge = new core.b2EdgeShape();
      edge.SetTwoSided(corners[i], corners[i + 1]);
      walls.CreateFixture({ shape: edge });
    }
    const definition = new particles.b2ParticleSystemDef();
    definition.radius = SPACING / 2 / 0.75; // its particles stand 0.75 diameters apart
    const system = world.CreateParticleSystem(definition);
    for (const fill of pool.fills) {
      const box = new core.b2PolygonShape().SetAsBox(fill.width / 2, fill.height / 2, {
        x: fill.x + fill.width / 2,
        y: fill.y + fill.height / 2,
      });
      const group = new particles.b2ParticleGroupDef();
      group.shape = box;
      group.stride = SPACING;
      system.CreateParticleGroup(group);
    }
    const iterations = particles.b2CalculateParticleIterations(10, definition.radius, FRAME);
    const settings = { velocityIterations: 8, positionIterations: 3, particleIterations: iterations };
    return {
      step: () => world.Step(FRAME, settings),
      places: () =>
        system
          .GetPositionBuffer()
          .slice(0, system.GetParticleCount())
          .flatMap(({ x, y }) => [x, y]),
    };
  },
  'liquidfun-wasm': async () => {
    const wasmBinary = await readFile(require.resolve('liquidfun-wasm/dist/umd/Box2D.simd.wasm'));
    const box2d = await require('liquidfun-wasm/dist/umd/Box2D.simd.js')({ wasmBinary });
    const { b2World, b2Vec2, b2BodyDef, b2EdgeShape, b2PolygonShape, b2ParticleSystemDef, b2ParticleGroupDef, getPointer } = box2d;
    const vec = (/** @type {number} */ x, /** @type {number} */ y) => new b2Vec2(x, y);
    const world = new b2World(vec(0, -10));
    const walls = world.CreateBody(new b2BodyDef());
    const corners = [vec(0, pool.height), vec(0, 0), vec(pool.width, 0), vec(pool.width, pool.height)];
    for (let i = 0; i < 3; i++) {
      const edge = new b2EdgeShape();
      edge.SetTwoSided(corners[i], corners[i + 1]);
      walls.CreateFixture(edge, 0);
    }
    const definition = new b2ParticleSystemDef();
    definition.radius = SPACING / 2 / 0.75;
    const system = world.CreateParticleSystem(definition);
    for (const fill of pool.fills) {
      const box = new b2PolygonShape();
      box.SetAsBox(fill.width / 2, fill.height / 2, vec(fill.x + fill.width / 2, fill.y + fill.height / 2), 0);
      const group = new b2ParticleGroupDef();
      group.shape = box;
      group.stride = SPACING;
      system.CreateParticleGroup(group);
    }
    const iterations = world.CalculateReasonableParticleIterations(FRAME);
    const places = () => {
      // the memory may have moved
      const first = getPointer(system.GetPositionBuffer()) / 4;
      return box2d.HEAPF32.subarray(first, first + 2 * system.GetParticleCount());
    };
    return { step: () => world.Step(FRAME, 8, 3, iterations), places };
  },
};

const { step, places } = await peers[peer]();
for (let i = 0; i < 20; i++) step(); // until it moves
console.log('case,method,round,frames,cpu_s,compression_mean,compression_max,note');
for (let round = 0; round < rounds; round++) {
  const before = process.cpuUsage();
  for (let i = 0; i < FRAMES; i++) step();
  const { user, system } = process.cpuUsage(before),
    at = places(),
    { mean, max } = compression(pool, SPACING, at);
  console.log(
    `particles,${peer},${round},${FRAMES},${(user + system) / 1e6},${mean.toPrecision(3)},${max.toPrecision(3)},${at.length / 2} particles`,
  );
}
