// Matter: its default iterations, at the 40 pixels a metre that its examples have, sleeping off. It has neither motors and
// limits of joints nor one-sided chains; capsules are polygons of eight vertices; nothing is swept.
import Matter from 'matter-js';
import { SHAPE_CAPSULE, SHAPE_CIRCLE, capsulePoints, runEngine, scene, setting } from './engine.mjs';

const { Bodies, Body, Composite, Constraint, Engine } = Matter;
const PIXELS = 40,
  STEP_MS = 1e3 * scene.dt,
  PER_STEP = PIXELS * scene.dt;
const engine = Engine.create({
  positionIterations: setting('position', 6),
  velocityIterations: setting('velocity', 4),
  constraintIterations: setting('constraint', 2),
});
engine.gravity.x = scene.gravity_x;
engine.gravity.y = scene.gravity_y;
engine.gravity.scale = PIXELS * 1e-6; // m/s^2 to pixels/ms^2
const bodies = [],
  driven = [];

function partOf(s, x, y) {
  const options = {
    friction: s.friction,
    restitution: s.restitution,
    frictionAir: 0,
    density: (s.density / PIXELS ** 2) * 1e-3,
    collisionFilter: { category: s.category & 0x7fffffff, mask: s.mask, group: s.group },
  };
  const centre = (list) => list.reduce((sum, v) => [sum[0] + v[0] / list.length, sum[1] + v[1] / list.length], [0, 0]);
  if (s.kind === SHAPE_CIRCLE)
    return Bodies.circle((x + s.vertices[0][0]) * PIXELS, (y + s.vertices[0][1]) * PIXELS, s.radius * PIXELS, options);
  const list = s.kind === SHAPE_CAPSULE ? capsulePoints(s) : s.vertices;
  const made = Body.create({ ...options, vertices: list.map(([px, py]) => ({ x: px * PIXELS, y: py * PIXELS })) });
  const middle = s.vertices.length === 4 ? centre(list) : Matter.Vertices.centre(list.map(([px, py]) => ({ x: px, y: py })));
  Body.setPosition(made, { x: (x + (middle.x ?? middle[0])) * PIXELS, y: (y + (middle.y ?? middle[1])) * PIXELS });
  return made;
}

function add(b) {
  const parts = b.shapes.map((s) => partOf(s, b.x, b.y));
  const body = parts.length === 1 ? parts[0] : Body.create({ parts, frictionAir: 0 });
  Body.setAngle(body, b.angle);
  if (b.type !== 2) Body.setStatic(body, true);
  else {
    Body.setVelocity(body, { x: b.vx * PER_STEP, y: b.vy * PER_STEP });
    Body.setAngularVelocity(body, b.angular_velocity * scene.dt);
  }
  if (b.type === 1) driven.push({ body, ...b });
  Composite.add(engine.world, body);
  bodies.push(body);
}

const join = (j) =>
  Composite.add(
    engine.world,
    Constraint.create({
      bodyA: bodies[j.a],
      bodyB: bodies[j.b],
      length: 0,
      stiffness: 1,
      pointA: { x: j.ax * PIXELS, y: j.ay * PIXELS },
      pointB: { x: j.bx * PIXELS, y: j.by * PIXELS },
    }),
  );

/** The fourth argument gives those that it turns a velocity, for friction. */
function drive() {
  for (const { body, vx, vy, angular_velocity } of driven) {
    Body.setPosition(body, { x: body.position.x + vx * PER_STEP, y: body.position.y + vy * PER_STEP }, true);
    Body.setAngle(body, body.angle + angular_velocity * scene.dt, true);
  }
}

runEngine({
  add,
  join,
  remove: (i) => Composite.remove(engine.world, bodies[i]),
  step: () => {
    drive();
    Engine.update(engine, STEP_MS);
  },
  pose: (i) => [bodies[i].position.x / PIXELS, bodies[i].position.y / PIXELS, bodies[i].angle],
});
