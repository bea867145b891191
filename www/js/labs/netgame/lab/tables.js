// What the charts of a netgame show, as numbers: all that the page remembers.
import { letter } from '../../../base/format.js';
import { t } from '../../../base/words.js';
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
  return {
    columns: [{ name: t('netgame_more.column.time'), unit: 's' }, ...curves.map(({ name, unit: of }) => ({ name, unit: of }))],
    rows: memory.times.map((t, i) => [
      t,
      ...lists.map(({ scale: by, values }) => (values[i] === null || values[i] === undefined ? null : values[i] * by)),
    ]),
    lines: curves.map((curve) => ({
      name: `${curve.name} (${curve.unit})`,
      colour: paintOf(colours, curve.player).text,
      dash: curve.dotted ? [1.5, 3] : paintOf(colours, curve.player).dash,
    })),
  };
}

const EVENT_NAMES = Object.fromEntries(Object.entries(EVENTS_TYPE).map(([name, type]) => [type, name]));

/** The messages and other events of the last seconds; null while the panel shows something else. @returns {Table | null} */
function events() {
  if (inspector.value !== 'messages') return null;
  return {
    columns: [
      { name: t('netgame_more.event.event'), unit: '' },
      { name: t('netgame_more.event.player'), unit: '' },
      { name: t('netgame_more.event.number'), unit: '' },
      { name: t('netgame_more.event.begin'), unit: 's' },
      { name: t('netgame_more.event.end'), unit: 's' },
      { name: t('netgame_more.event.outcome'), unit: '' },
    ],
    rows: [...memory.events.values()].map((one) => [
      EVENT_NAMES[one.type] === undefined ? one.type : t(`netgame_more.event.of.${EVENT_NAMES[one.type]}`),
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
