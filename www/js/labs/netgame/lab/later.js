// What loads after the first frame: the library of the curves; and when a dialog or an inspector is wanted, or soon after, these.
import { effect } from '../../../../vendor/signals-core.js';
import { need } from '../../../base/words.js';
import { frame } from '../../../session/state.js';
import { dialog } from '../../../workbench/dialog.js';
import { inspector, inspectors } from '../core/inspector.js';
import { INSPECTORS } from '../inspectors/inspectors.js';
import { shots } from '../inspectors/shots.js';
import { Chart } from '../views/chart.js';
import { dialogs, help } from './dialogs.js';
import { errata } from './errata.js';
import { noteBy, plotBy } from './side.js';
import { tables } from './tables.js';

const REST_MS = 1500;

plotBy(Chart);

let shot = false;
effect(() => {
  if (shot || (frame.value?.shots?.length ?? 0) === 0) return;
  shot = true;
  need('netgame_more').then(() => {
    inspectors.value = [...inspectors.value, shots];
  });
});

const wanted = new Promise((done) => {
  setTimeout(done, REST_MS, null);
  effect(() => {
    if (dialog.value !== null || inspector.value !== 'messages') done(null);
  });
});

/** @returns {Promise<Partial<import('../../../session/lab.js').Lab>>} */
export async function rest() {
  await wanted;
  await need('netgame_more');
  inspectors.value = [...INSPECTORS, ...inspectors.value];
  noteBy(errata);
  return { dialogs, help, tables: async () => tables };
}
