// What loads after the first frame: the library of the curves; and when a dialog or an inspector is wanted, or soon after, these.
import { effect } from '../../../../vendor/signals-core.js';
import { insist, styleSheet } from '../../../base/api.js';
import { need } from '../../../base/words.js';
import { frame } from '../../../session/state.js';
import { dialog } from '../../../workbench/dialog.js';
import { inspector, inspectors } from '../core/inspector.js';
import { Chart } from '../views/chart.js';
import { noteBy, plotBy } from './side.js';

const REST_MS = 1500;

styleSheet('vendor/uplot');

plotBy(Chart);

let shot = false;
effect(() => {
  if (shot || (frame.value?.shots?.length ?? 0) === 0) return;
  shot = true;
  Promise.all([insist(() => import('../inspectors/shots.js')), need('netgame_more')]).then(([{ shots }]) => {
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
  const [{ dialogs, help }, { errata }, { INSPECTORS }] = await Promise.all([
    import('./dialogs.js'),
    import('./errata.js'),
    import('../inspectors/inspectors.js'),
    need('netgame_more'),
  ]);
  inspectors.value = [...INSPECTORS, ...inspectors.value];
  noteBy(errata);
  return { dialogs, help, tables: () => import('./tables.js').then(({ tables }) => tables) };
}
