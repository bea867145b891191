// Rapier (WebAssembly): its default settings, sleeping off. A motor has no largest torque: it is a damper of that strength
// at a speed of 1 rad/s. Groups of parts that do not collide are distinguished modulo 15.
import { SHAPE_CAPSULE, SHAPE_CIRCLE, SHAPE_POLYGON, runEngine, scene, setting } from './engine.mjs';

const simd = setting('simd', 0) !== 0;
const { default: R } = await import(simd ? '@dimforge/rapier2d-simd-compat' : '@dimforge/rapier2d-compat');
const warn = console.warn;
console.warn = () => {}; // of its own loader's deprecated call
await R.init();
console.warn = warn;

const world = new R.World({ x: scene.gravity_x, y: scene.gravity_y });
world.timestep = scene.dt;
world.integrationParameters.numSolverIterations = setting('iterations', 4);
const bodies = [];
const makers = [R.RigidBodyDesc.fixed, R.RigidBodyDesc.kinematicVelocityBased, R.RigidBodyDesc.dynamic];

/** Width, height, centre and angle of a rectangle; undefined of another polygon. */
function rectangle(v) {
  if (v.length !== 4) return undefined;
  const side = (i) => [v[(i + 1) % 4][0] - v[i][0], v[(i + 1) % 4][1] - v[i][1]];
  const [a, b] = [side(0), side(1)],
    [w, h] = [Math.hypot(...a), Math.hypot(...b)];
  const square = Math.abs(a[0] * b[0] + a[1] * b[1]) < 1e-9 * w * h;
  const parallel = Math.hypot(v[0][0] + v[2][0] - v[1][0] - v[3][0], v[0][1] + v[2][1] - v[1][1] - v[3][1]) < 1e-9 * (w + h);
  return square && parallel ? { w, h, x: (v[0][0] + v[2][0]) / 2, y: (v[0][1] + v[2][1]) / 2, angle: Math.atan2(a[1], a[0]) } : undefined;
}

function colliderOf(s) {
  const [a, b] = s.vertices,
    flat = (list) => new Float32Array(list.flat());
  if (s.kind === SHAPE_CIRCLE) return R.ColliderDesc.ball(s.radius).setTranslation(a[0], a[1]);
  if (s.kind === SHAPE_CAPSULE) {
    const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
    return R.ColliderDesc.capsule(Math.hypot(dx, dy) / 2, s.radius)
      .setTranslation((a[0] + b[0]) / 2, (a[1] + b[1]) / 2)
      .setRotation(Math.atan2(dy, dx) - Math.PI / 2);
  }
  const r = rectangle(s.vertices);
  if (r)
    return R.ColliderDesc.cuboid(r.w / 2, r.h / 2)
      .setTranslation(r.x, r.y)
      .setRotation(r.angle);
  return s.kind === SHAPE_POLYGON ? R.ColliderDesc.convexHull(flat(s.vertices)) : R.ColliderDesc.polyline(flat([...s.vertices, a]));
}

function groups({ category, mask, group }) {
  const own = group === 0 ? category & 0xffff : 1 << (-group % 15);
  return ((own << 16) | (group === 0 ? mask & 0xffff : 0xffff & ~own)) >>> 0;
}

function add(b) {
  const body = world.createRigidBody(
    makers[b.type]().setTranslation(b.x, b.y).setRotation(b.angle).setLinvel(b.vx, b.vy).setAngvel(b.angular_velocity).setCanSleep(false),
  );
  for (const s of b.shapes)
    world.createCollider(
      colliderOf(s).setDensity(s.density).setFriction(s.friction).setRestitution(s.restitution).setCollisionGroups(groups(s)),
      body,
    );
  if (scene.continuous && b.type === 2) body.enableCcd(true);
  bodies.push(body);
}

function join(j) {
  const joint = world.createImpulseJoint(R.JointData.revolute({ x: j.ax, y: j.ay }, { x: j.bx, y: j.by }), bodies[j.a], bodies[j.b], true);
  joint.setContactsEnabled(false);
  if (j.limited) joint.setLimits(j.lower + j.angle, j.upper + j.angle);
  if (j.motored) {
    joint.configureMotorModel(R.MotorModel.ForceBased);
    joint.configureMotorVelocity(j.speed, j.torque);
  }
}

runEngine({
  add,
  join,
  remove: (i) => world.removeRigidBody(bodies[i]),
  step: () => world.step(),
  pose: (i) => {
    const at = bodies[i].worldCom();
    return [at.x, at.y, bodies[i].rotation()];
  },
});
