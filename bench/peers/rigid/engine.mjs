// What bench/rigid/run.c is to the engines in C, for those under Node: SCENE.json STEPS SECONDS [setting=value]...
import { readFileSync } from 'node:fs';

const [file, steps, seconds, ...settings] = process.argv.slice(2);
const given = Object.fromEntries(settings.map((text) => text.split('=')));
export const scene = JSON.parse(readFileSync(file, 'utf8'));
export const setting = (name, standard) => Number(given[name] ?? standard);

export const SHAPE_CIRCLE = 0,
  SHAPE_CAPSULE = 1,
  SHAPE_POLYGON = 2,
  SHAPE_CHAIN = 3;

/** Two ends and a radius as a polygon, for who has no capsules: as bench/peers/rigid/box2d_2.cpp. */
export function capsulePoints({ vertices: [a, b], radius }) {
  const turn = Math.atan2(b[1] - a[1], b[0] - a[0]),
    out = radius / Math.cos(Math.PI / 8);
  const at = (end, sign, k) => [end[0] + sign * out * Math.cos(turn + k), end[1] + sign * out * Math.sin(turn + k)];
  const angles = [-3, -1, 1, 3].map((k) => (k * Math.PI) / 8);
  return [...angles.map((k) => at(b, 1, k)), ...angles.map((k) => at(a, -1, k))];
}

/** With the garbage collector's and the compiler's threads. */
const cpu = () => {
  const { user, system } = process.cpuUsage();
  return (user + system) / 1e3;
};

/** @param {{add: Function, join: Function, remove: Function, step: Function,
 * pose: Function}} engine bodies are counted from 0 as they are added */
export function runEngine(engine) {
  const gone = new Set();
  const happen = ({ removed, bodies, joints }) => {
    removed.forEach((body) => {
      engine.remove(body);
      gone.add(body);
    });
    bodies.forEach(engine.add);
    joints.forEach(engine.join);
  };
  const events = [...scene.events];
  if (events[0]?.step === 0) happen(events.shift());
  const spent = [];
  const begin = cpu();
  for (let step = 0, last = begin; step < Number(steps) && last - begin < 1e3 * Number(seconds); step++) {
    while (events[0]?.step === step) happen(events.shift());
    engine.step();
    const now = cpu();
    spent.push(now - last);
    last = now;
  }
  const mean = spent.reduce((sum, ms) => sum + ms, 0) / spent.length;
  const change = { sag: 0, drift: 0, tilt: 0, top_sag: 0, top_y: 0, lowest: Infinity };
  let top = -Infinity;
  (scene.events[0]?.bodies ?? []).forEach((body, i) => {
    if (body.type !== 2 || gone.has(i)) return;
    const [x, y, angle] = engine.pose(i);
    const turned = Math.abs(((((angle - body.angle + Math.PI) % (2 * Math.PI)) + 2 * Math.PI) % (2 * Math.PI)) - Math.PI);
    if (!Number.isFinite(x + y + angle)) change.sag = change.drift = change.tilt = 1e9;
    change.sag = Math.max(change.sag, body.y - y);
    change.drift = Math.max(change.drift, Math.abs(x - body.x));
    change.tilt = Math.max(change.tilt, turned);
    change.lowest = Math.min(change.lowest, y);
    if (body.y > top) {
      top = body.y;
      change.top_sag = body.y - y;
      change.top_y = y;
    }
  });
  if (change.lowest === Infinity) change.lowest = 0;
  spent.sort((a, b) => a - b);
  console.log(JSON.stringify({ steps: spent.length, mean_ms: mean, median_ms: spent[spent.length >> 1], ...change }));
}
