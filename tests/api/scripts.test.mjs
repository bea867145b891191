// The scripts of the race and of the demo's game, written a second time from docs/concepts.md and docs/links.md alone, against what the
// program records.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { BINARY } from '../lib/daemon.mjs';

let folder;
before(() => {
  folder = mkdtempSync(path.join(tmpdir(), 'laglab-scripts-'));
});
after(() => rmSync(folder, { recursive: true, force: true }));

const MASK = (1n << 64n) - 1n;

/** @param {bigint} seed @param {bigint} stream @param {bigint} counter */
function draw(seed, stream, counter) {
  let start = (seed + (stream + 1n) * 0xd1e8d69ec377210fn) & MASK;
  start ^= start >> 32n;
  start = (start * 0xd60927fc6f0de0d1n) & MASK;
  start ^= start >> 29n;
  let x = (start + counter * 0x9e3779b97f4a7c15n) & MASK;
  x ^= x >> 33n;
  x = (x * 0xaa78f731403321bbn) & MASK;
  x ^= x >> 26n;
  x = (x * 0xee9daf582aec48adn) & MASK;
  x ^= x >> 30n;
  return x;
}

/** @param {number} seed @param {number} player @param {number} purpose @param {number} n */
const D = (seed, player, purpose, n) => draw(BigInt(seed), 0x7363726970740000n + BigInt(16 * player + purpose), BigInt(n));

const MS = 1000000;

/** By walking from the first slot on. @param {number} seed @param {number} player @param {number} t ns @param {number} mean ms
 * @param {number} spread ms */
function slot(seed, player, t, mean, spread) {
  const at = t + Number(D(seed, player, 0, 0) % BigInt(mean * MS));
  let begin = 0;
  for (let k = 0; ; k++) {
    const next = (k + 1) * mean * MS + Number(D(seed, player, 0, k + 1) % BigInt(spread * MS));
    if (at < next) return { k, since: at - begin };
    begin = next;
  }
}

/** @type {Record<string, (seed: number, player: number, t: number) => number>} */
const scripts = {
  race(seed, player, t) {
    if (t < 2e9) return 1;
    return [1, 1, 0.8, 0.6, 0.3, -0.4][Number(D(seed, player, 3, slot(seed, player, t, 750, 500).k) % 6n)] ?? NaN;
  },
  gambetta(seed, player, t) {
    const { k, since } = slot(seed, player, t, 4000, 400),
      side = D(seed, player, 3, k) % 2n === 1n ? 1 : -1;
    const out = 1200 * MS + Number(D(seed, player, 4, k) % BigInt(400 * MS)),
      there = 100 * MS + Number(D(seed, player, 5, k) % BigInt(300 * MS));
    return since < out ? side : since >= out + there && since < 2 * out + there ? -side : 0;
  },
  steady: (_seed, player, t) => ((t + player * 700 * MS) % 4e9 < 2e9 ? 1 : -1),
};

/** Axis 0 of a player between ticks, as recorded: of the frame after tick k and until tick k + 1. @param {string[]} args */
function recorded(...args) {
  const log = path.join(folder, 'log');
  execFileSync(BINARY, ['run', ...args, '--record-inputs', log], { stdio: ['ignore', 'ignore', 'inherit'] });
  const lines = readFileSync(log, 'utf8')
      .trim()
      .split('\n')
      .map((line) => JSON.parse(line)),
    ticks = lines.at(-1).tick;
  const axes = [0, 1].map((player) => {
    const mine = lines.filter((line) => line.op === 'input' && line.player === player);
    let next = 0,
      held = 0;
    return [...Array(ticks)].map((_, tick) => {
      while (next < mine.length && mine[next].tick <= tick) held = mine[next++].axes[0];
      return held;
    });
  });
  return { hz: /** @type {number} */ (lines[0].scenario.tick_hz), axes };
}

/** @param {string} name @param {number} seed @param {{hz: number, axes: number[][]}} run */
function check(name, seed, { hz, axes }) {
  const script = scripts[name];
  assert.ok(script);
  axes.forEach((axis, player) =>
    axis.forEach((value, tick) => {
      if (tick === 0) return; // two frames may have gone by
      const time = (/** @type {number} */ k) => Math.floor((k * 1e9) / hz); // a frame lies anywhere within the tick
      const may = [time(tick) + 1, time(tick + 1)].map((t) => Math.fround(script(seed, player, t)));
      assert.ok(may.includes(Math.fround(value)), `${name}, seed ${seed}: player ${player} did ${value} after tick ${tick}, not ${may}`);
    }),
  );
}

test('the race', () => {
  for (const seed of [1, 77, 9007199254740991]) {
    const run = recorded('race', '--seed', String(seed), '--duration', '70', '--set', 'players.0.lag_ms=35');
    check('race', seed, run);
    assert.ok(new Set(run.axes[0]).size === 5 && run.axes[0]?.join() !== run.axes[1]?.join());
  }
});

test('two cars in one lane, of which one is steady', () => {
  const {
    hz,
    axes: [a, b],
  } = recorded('contact', '--seed', '3', '--duration', '30');
  check('race', 3, { hz, axes: [a ?? []] });
  assert.ok((b ?? []).slice(1).every((value) => value === 1));
});

test('the game of the demo, varied and steady', () => {
  for (const seed of [2, 40]) check('gambetta', seed, recorded('gambetta_default', '--seed', String(seed), '--duration', '60'));
  check(
    'steady',
    5,
    recorded('gambetta_default', '--seed', '5', '--duration', '30', '--set', 'players.0.script=steady', '--set', 'players.1.script=steady'),
  );
});
