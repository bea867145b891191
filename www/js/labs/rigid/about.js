// What the page knows of the lab of rigid bodies before it is read.
import { need } from '../../base/words.js';

/** @type {import('../../session/lab.js').About} */
export const about = {
  kind: 'rigid',
  group: 'shell.group.rigid',
  tabs: [{ id: 'collide', name: 'shell.tab.collide', scenario: 'rigid/collapsing_stack', shows: ['rigid'] }],
  slow: {
    'rigid/three_bullets': { speed: 0.1, from_s: 0, until_s: 0.15 },
    'rigid/bullets': { speed: 0.1, from_s: 0, until_s: 0.2 },
    'rigid/bullets_moving': { speed: 0.1, from_s: 0, until_s: 0.2 },
  },
  rates: { bodies: 60, contacts: 60, joints: 60 },
  study: {
    axes: [
      [['solver.method', '']],
      [
        ['solver.substeps', '1, 2, 4, 8, 16'],
        ['solver.iterations', '1, 2, 4, 8, 16'],
      ],
    ],
    errors: /^(drift|sag)_worst_m$/,
    more: ['passes_per_s'],
    repeats: '1',
  },
  load: async () => {
    const [{ lab }] = await Promise.all([import('./lab.js'), need('rigid')]);
    return lab;
  },
};
