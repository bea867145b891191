// What the page knows of the fluid lab before it is read.
import { need } from '../../base/words.js';

/** @type {import('../../session/lab.js').About} */
export const about = {
  kind: 'fluid',
  group: 'shell.group.fluid',
  tabs: [{ id: 'fluid', name: 'shell.tab.fluid', scenario: 'fluid/two_discs', shows: ['fluid'] }],
  rates: { field: 60, points: 60 },
  study: {
    axes: [[['solver.method', '']], [['solver.advection', '']], [['params.n', '16, 24, 32, 48']], [['params.size', '12, 16, 24, 32']]],
    errors: /^(velocity_|pressure_|front_|decay_)?error(_max|_l2|_l1|_rms)?$|^(density_error|divergence)_max$/,
    more: ['cell_visits'],
    repeats: '1',
    brief_s: 1,
  },
  load: async () => {
    const [{ lab }] = await Promise.all([import('./lab.js'), need('fluid')]);
    return lab;
  },
};
