// Records what the cards of the first page play: a few places of each run, from the engine's trace, in the units of the card's drawing.
//
//   node docs/cards.mjs               # writes www/cards.json; uses build/laglab, or the binary that LAGLAB_BIN names
//
// A card plays the scenario of its lesson, with the lesson's parameters and seed.
import { readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { FOLDER, engine } from './lessons.mjs';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '..');
export const CARDS = path.join(ROOT, 'www/cards.json');
const PLACES = 25; /* of a part, over the whole card */

/** The columns of a trace at a tick, by name. @typedef {(name: string) => number} Row */
/** from, to: ticks; bodies: rows are the bodies at the end of a run of that length, since a trace has no more than eight;
 * places: how many, where the usual number is too coarse; parts: where each part of the drawing is, [x, y] or [x, y, degrees], for a row,
 * the row at `from`, and the row some ticks ago
 * @typedef {{from: number, to: number, bodies?: boolean, places?: number, parts: Record<string, (now: Row, start: Row,
 * ago: (ticks: number) => Row) => number[]>}} Card */

const degrees = (/** @type {number} */ radians) => (-180 / Math.PI) * radians;
const FLOOR = 74; /* units from the top */

/** Of a stack of boxes of 1 m, from the ground up. @param {number} x of the stack @param {number} count
 * @param {number} side of a drawn box, units @param {number} [each] how many boxes one part draws: it has the place of the lowest of
 * them */
const stack = (x, count, side, each = 1) =>
  Object.fromEntries(
    Array.from({ length: count / each }, (_, i) => {
      const box = each * i + 1;
      const placeOf = (/** @type {Row} */ now) => [
        x + side * now(`${box}_x_m`),
        FLOOR - side * now(`${box}_y_m`),
        degrees(now(`${box}_angle_rad`)),
      ];
      return [`box${i}`, placeOf];
    }),
  );
/** A car along the road. @param {string} column m @param {number} x where it is at `from` @param {number} y
 * @param {number} scale units per m */
const along = (column, x, y, scale) => (/** @type {Row} */ now, /** @type {Row} */ start) => [x + scale * (now(column) - start(column)), y];

/** The place of the inputs that the server's next step needs. @param {Row} now @param {Row} start */
const slotOf = (now, start) => 44 + 31 * (now('server_step') - start('server_step'));
/** How much of the wait for the next step is over, 0 to 1: the input of the slowest player ends it. @param {Row} now
 * @param {(ticks: number) => Row} ago */
function waited(now, ago) {
  const step = now('server_step');
  let since = 0,
    until = 1;
  while (ago(since + 1)('server_step') === step) since++;
  while (ago(-until)('server_step') === step) until++;
  return since / (since + until - 1);
}

/** @type {Record<string, Card>} */
const SHOWN = {
  late_answer: {
    from: 0,
    to: 180,
    parts: {
      ghost: (now) => [62 + 34 * (now('server_0_x_m') - now('player_0_own_x_m')), 59],
      road: (now, start) => [-34 * (now('player_0_own_x_m') - start('player_0_own_x_m')), 0],
    },
  },
  jump_back: { from: 0, to: 60, parts: { a: along('player_0_own_x_m', 76, 50, 80) } },
  in_the_past: {
    from: 60,
    to: 180,
    parts: {
      b: (now) => [134 + 40 * now('player_0_remote_error_m'), 59],
      a: (now) => [134 + 40 * (now('player_0_own_x_m') - now('server_1_x_m')), 25],
      road: (now, start) => [-40 * (now('server_1_x_m') - start('server_1_x_m')), 0],
    },
  },
  who_waits: {
    from: 126,
    to: 180,
    places: 55,
    parts: {
      step: (now, start) => [slotOf(now, start) - 4, 2],
      a: (now, start) => [slotOf(now, start), 6],
      b: (now, start) => [slotOf(now, start), 32],
      c: (now, start, ago) => [slotOf(now, start) + (218 - slotOf(now, start)) * (1 - waited(now, ago)), 58],
    },
  },
  behind_wall: {
    from: 60,
    to: 240,
    parts: {
      a: (now) => [160 - 24 * (now('server_0_y_m') - 3.5), 65],
      seen: (now, _, ago) => [160 - 24 * (ago((60 * now('player_1_view_age_ms')) / 1000)('server_0_y_m') - 3.5), 65],
    },
  },
  keeps_energy: {
    from: 0,
    to: 600,
    places: 50,
    parts: {
      euler: (now, start) => [84 + (28 * now('0_x_m')) / start('0_x_m'), 42 - (22 * now('0_v_mps')) / start('0_x_m')],
      verlet: (now, start) => [84 + (28 * now('3_x_m')) / start('0_x_m'), 42 - (22 * now('3_v_mps')) / start('0_x_m')],
    },
  },
  bullet_through: { from: 0, to: 6, parts: { ball: (now) => [124 + 37.5 * now('side_by_side0_3_x_m'), 42] } },
  falling_stack: { from: 0, to: 150, parts: stack(62, 6, 11) },
  how_many_sweeps: { from: 480, to: 720, bodies: true, parts: stack(60, 20, 3.6, 2) },
  what_a_cheat_gains: {
    from: 0,
    to: 300,
    parts: {
      a: (now) => [60 + 3.2 * (now('server_0_x_m') - now('server_1_x_m')), 42],
      road: (now, start) => [-3.2 * (now('server_1_x_m') - start('server_1_x_m')), 0],
    },
  },
};

/** @param {number} value */
const rounded = (value) => Math.round(value * 10) / 10 + 0;

/** @param {ReturnType<typeof engine>} asked @param {any} lesson @returns {(tick: number) => Row} */
function traceOf(asked, lesson) {
  const { columns, ticks } = asked.run(lesson.scenario, lesson.set, lesson.seed, lesson.workload).trace();
  return (tick) => (name) => Number(ticks.get(tick)?.[columns.indexOf(name)]);
}

/** The same of the bodies at the end of a run that ends at the tick. @param {ReturnType<typeof engine>} asked @param {any} lesson
 * @returns {(tick: number) => Row} */
function bodiesOf(asked, lesson) {
  const { hz } = asked.run(lesson.scenario, lesson.set, lesson.seed, lesson.workload).scenario;
  return (tick) => {
    const { bodies } = asked.run(lesson.scenario, { ...lesson.set, duration_s: tick / hz }, lesson.seed).metrics;
    return (name) => {
      const [, number, quantity] = /** @type {RegExpExecArray} */ (/^(\d+)_(x_m|y_m|angle_rad)$/.exec(name));
      const { position, angle } = bodies[Number(number)];
      return quantity === 'angle_rad' ? angle : position[quantity === 'x_m' ? 0 : 1];
    };
  };
}

/** What all cards play, by their ids. @param {ReturnType<typeof engine>} asked */
export function cards(asked) {
  return Object.fromEntries(
    Object.entries(SHOWN).map(([id, { from, to, bodies = false, places: count = PLACES, parts }]) => {
      const lesson = JSON.parse(readFileSync(path.join(FOLDER, `${id}.json`), 'utf8'));
      const rowAt = (bodies ? bodiesOf : traceOf)(asked, lesson);
      const places = Array.from({ length: count }, (_, i) => from + Math.round((i * (to - from)) / (count - 1)));
      const moved = Object.entries(parts).map(([name, placeOf]) => [
        name,
        places.map((tick) => placeOf(rowAt(tick), rowAt(from), (ago) => rowAt(Math.max(0, Math.round(tick - ago)))).map(rounded)),
      ]);
      return [id, Object.fromEntries(moved)];
    }),
  );
}

/** A line for each part. @param {ReturnType<typeof cards>} all */
export const layout = (all) =>
  `{\n${Object.entries(all)
    .map(([id, parts]) => {
      const lines = Object.entries(parts).map(([name, places]) => `    "${name}": ${JSON.stringify(places)}`);
      return `  "${id}": {\n${lines.join(',\n')}\n  }`;
    })
    .join(',\n')}\n}\n`;

if (process.argv[1] === fileURLToPath(import.meta.url))
  writeFileSync(CARDS, layout(cards(engine(process.env.LAGLAB_BIN ?? path.join(ROOT, 'build/laglab')))));
