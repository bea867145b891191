// What the charts of a netgame show, as numbers: all that the page remembers.
import { letter } from '../../../base/format.js';
import { palette, paintOf } from '../../../draw/palette.js';
import { EVENTS_TYPE } from '../../../stream/names.js';
import { inspector } from '../core/inspector.js';
import { layout } from '../core/layout.js';
import { memory, scale, unit } from '../core/state.js';
import { bufferCurves, errorCurves } from '../views/curves.js';

/** @typedef {import('../../../session/lab.js').Table} Table */

/** @param {import('../views/curves.js').Curve[]} curves @returns {Table} */
function tableOf(curves) {
  const colours = palette(),
    lists = curves.map((curve) => ({ scale: curve.scale, values: curve.values(memory) ?? [] }));
  const split = curves.map(({ label }) => /^(.*) \((.*)\)$/.exec(label));
  return {
    columns: [
      { name: 'time', unit: 's' },
      ...split.map((found, i) => ({ name: found?.[1] ?? curves[i]?.label ?? '', unit: found?.[2] ?? '' })),
    ],
    rows: memory.times.map((t, i) => [
      t,
      ...lists.map(({ scale: by, values }) => (values[i] === null || values[i] === undefined ? null : values[i] * by)),
    ]),
    lines: curves.map((curve) => ({
      name: curve.label,
      colour: paintOf(colours, curve.player).text,
      dash: curve.dotted ? [1.5, 3] : paintOf(colours, curve.player).dash,
    })),
  };
}

const EVENT_NAMES = Object.fromEntries(Object.entries(EVENTS_TYPE).map(([name, type]) => [type, name.replaceAll('_', ' ')]));

/** The messages and other events of the last seconds; null while the panel shows something else. @returns {Table | null} */
function events() {
  if (inspector.value !== 'messages') return null;
  return {
    columns: [
      { name: 'event', unit: '' },
      { name: 'player', unit: '' },
      { name: 'number', unit: '' },
      { name: 'begin', unit: 's' },
      { name: 'end', unit: 's' },
      { name: 'outcome', unit: '' },
    ],
    rows: [...memory.events.values()].map((one) => [
      EVENT_NAMES[one.type] ?? one.type,
      letter(one.player),
      one.number,
      one.begin_s,
      one.end_s,
      one.outcome,
    ]),
  };
}

const players = () => layout.value?.players.length ?? 0;

/** @type {import('../../../session/lab.js').Tables} */
export const tables = {
  'error-chart': () => tableOf(errorCurves(players(), unit.value, scale.pxPerMetre)),
  'buffer-chart': () => tableOf(bufferCurves(players())),
  lane: events,
};
