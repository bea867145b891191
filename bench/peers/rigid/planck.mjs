// Planck: its default settings, sleeping off. It has no capsules: they are polygons of eight vertices.
import { Chain, Circle, Polygon, RevoluteJoint, Vec2, World } from 'planck';
import { SHAPE_CAPSULE, SHAPE_CIRCLE, SHAPE_POLYGON, capsulePoints, runEngine, scene, setting } from './engine.mjs';

const world = new World({ gravity: Vec2(scene.gravity_x, scene.gravity_y), allowSleep: false, continuousPhysics: scene.continuous !== 0 });
const bodies = [];
const types = ['static', 'kinematic', 'dynamic'];
const points = (list) => list.map(([x, y]) => Vec2(x, y));

function shapeOf(s) {
  if (s.kind === SHAPE_CIRCLE) return new Circle(Vec2(...s.vertices[0]), s.radius);
  if (s.kind === SHAPE_CAPSULE) return new Polygon(points(capsulePoints(s)));
  return s.kind === SHAPE_POLYGON ? new Polygon(points(s.vertices)) : new Chain(points(s.vertices), true);
}

function add(b) {
  const body = world.createBody({
    type: types[b.type],
    position: Vec2(b.x, b.y),
    angle: b.angle,
    linearVelocity: Vec2(b.vx, b.vy),
    angularVelocity: b.angular_velocity,
  });
  for (const s of b.shapes)
    body.createFixture({
      shape: shapeOf(s),
      density: s.density,
      friction: s.friction,
      restitution: s.restitution,
      filterCategoryBits: s.category & 0xffff,
      filterMaskBits: s.mask & 0xffff,
      filterGroupIndex: s.group,
    });
  bodies.push(body);
}

function join(j) {
  world.createJoint(
    new RevoluteJoint({
      bodyA: bodies[j.a],
      bodyB: bodies[j.b],
      localAnchorA: Vec2(j.ax, j.ay),
      localAnchorB: Vec2(j.bx, j.by),
      referenceAngle: j.angle,
      enableLimit: j.limited !== 0,
      lowerAngle: j.lower,
      upperAngle: j.upper,
      enableMotor: j.motored !== 0,
      motorSpeed: j.speed,
      maxMotorTorque: j.torque,
    }),
  );
}

const velocity = setting('velocity', 8),
  position = setting('position', 3);
runEngine({
  add,
  join,
  remove: (i) => world.destroyBody(bodies[i]),
  step: () => world.step(scene.dt, velocity, position),
  pose: (i) => {
    const at = bodies[i].getWorldCenter();
    return [at.x, at.y, bodies[i].getAngle()];
  },
});
