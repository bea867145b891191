// What the page knows of the motion lab before it is read.
import { need } from '../../base/words.js';

/** @type {import('../../session/lab.js').About} */
export const about = {
  kind: 'motion',
  group: 'shell.group.motion',
  tabs: [{ id: 'step', name: 'shell.tab.step', scenario: 'motion/two_orbits', shows: ['motion'] }],
  rates: { motion: 60 },
  study: {
    axes: [
      [['methods.0.method', 'explicit_euler, semi_implicit_euler, velocity_verlet, rk4']],
      [['methods.0.dt_s', '0.1, 0.03, 0.01, 0.003, 0.001']],
    ],
    errors: /^methods\.0\.e_max$/,
    more: ['methods.0.evaluations'],
    repeats: '1',
  },
  load: async () => {
    const [{ lab }] = await Promise.all([import('./lab.js'), need('motion')]);
    return lab;
  },
};
