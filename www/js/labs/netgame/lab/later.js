// What loads after the first frame: dialogs, inspectors, the library of the curves.
import { effect } from '../../../../vendor/signals-core.js';
import { insist } from '../../../base/api.js';
import { frame } from '../../../session/state.js';
import { inspectors } from '../core/inspector.js';
import { INSPECTORS } from '../inspectors/inspectors.js';
import { Chart } from '../views/chart.js';
import { dialogs, help } from './dialogs.js';
import { plotBy } from './side.js';

const sheet = document.createElement('link');
sheet.rel = 'stylesheet';
sheet.href = new URL('../../../../vendor/uplot.css', import.meta.url).href;
document.head.append(sheet);

plotBy(Chart);
inspectors.value = INSPECTORS;

let shot = false;
effect(() => {
  if (shot || (frame.value?.shots?.length ?? 0) === 0) return;
  shot = true;
  insist(() => import('../inspectors/shots.js')).then(({ shots }) => {
    inspectors.value = [...inspectors.value, shots];
  });
});

/** @type {Partial<import('../../../session/lab.js').Lab>} */
export const rest = { dialogs, help, tables: () => import('./tables.js').then(({ tables }) => tables) };
