// What is plotted over time: distances from the server's present (the own lead, which is no error, and the others' error), and the depth
// of the buffers.
import { letter } from '../../../base/format.js';
import { t } from '../../../base/words.js';

/** @typedef {import('../core/memory.js').Memory} Memory */
/**
 * @typedef {{name: string, unit: string, player: number, dotted: boolean, values: (memory: Memory) => (number | null)[] | undefined,
 * scale: number}} Curve */

export const FEW = 3; /* players whose curves of others are drawn too */

/** @param {number} players @param {'px' | 'm' | 'ms'} unit @param {number} pxPerMetre @returns {Curve[]} */
export function errorCurves(players, unit, pxPerMetre) {
  /* many players: their own curves alone can be read */
  const scale = unit === 'px' ? pxPerMetre : 1;
  /** @type {Curve[]} */
  const list = [];
  for (let p = 0; p < players; p++) {
    list.push(
      {
        name: t('netgame.curve.own', { name: letter(p) }),
        unit,
        player: p,
        dotted: false,
        scale,
        values: (memory) => (unit === 'ms' ? memory.curves[p]?.ownAge : memory.curves[p]?.own),
      },
      {
        name: t('netgame.curve.others', { name: letter(p) }),
        unit,
        player: p,
        dotted: true,
        scale,
        values: (memory) => (unit === 'ms' ? memory.curves[p]?.remoteAge : memory.curves[p]?.remote),
      },
    );
  }
  return players > FEW ? list.filter((curve) => !curve.dotted) : list;
}

/** @param {number} players @returns {Curve[]} */
export function bufferCurves(players) {
  return Array.from({ length: players }, (_, p) => ({
    name: t('netgame.curve.buffer', { name: letter(p) }),
    unit: 'ms',
    player: p,
    dotted: false,
    scale: 1,
    values: (/** @type {Memory} */ memory) => memory.curves[p]?.buffer,
  }));
}

/** The same numbers as rows: the last `count`, every half second. @param {Memory} memory @param {Curve[]} curves @param {number} count
 * @returns {{t: number, values: (number | null)[]}[]} */
export function rowsOf(memory, curves, count) {
  /** @type {{t: number, values: (number | null)[]}[]} */
  const rows = [];
  let before = Infinity;
  for (let i = memory.times.length - 1; i >= 0 && rows.length < count; i--) {
    const t = /** @type {number} */ (memory.times[i]);
    if (before - t < 0.5) continue;
    before = t;
    rows.push({
      t,
      values: curves.map((curve) => {
        const value = curve.values(memory)?.[i];
        return value === null || value === undefined ? null : value * curve.scale;
      }),
    });
  }
  return rows;
}
