// What the page knows of the lab of netgames before it is read.
import { need } from '../../../base/words.js';

/** @typedef {import('../../../session/lab.js').Lab} Lab */

/** @type {(lab: Lab) => void} */
let done = () => {};
/** @type {Promise<Lab>} */
const brought = new Promise((bring) => {
  done = bring;
});
/** The page itself has the lab, in a file that comes after this one. @param {Lab} lab */
export const bring = (lab) => done(lab);

/** @type {import('../../../session/lab.js').About} */
export const about = {
  kind: 'netgame',
  group: 'shell.group.netgame',
  tabs: [
    { id: 'race', name: 'shell.tab.race', scenario: 'race', shows: ['race', 'gambetta'] },
    { id: 'cannon', name: 'shell.tab.cannon', scenario: 'cannon', shows: ['cannon'] },
    { id: 'shoot', name: 'shell.tab.shoot', scenario: 'rifle', shows: ['shooter'] },
    { id: 'crates', name: 'shell.tab.crates', scenario: 'crates', shows: ['crates'] },
  ],
  elsewhere: { fluid: ['sea', 'dam'] },
  slow: { behind_cover: { speed: 0.25, from_s: 2.2, until_s: 3.2 } },
  rates: { scene: 60, lanes: 60, gauges: 10, shots: 5 },
  study: {
    axes: [[['server.snapshot_encoding', '']], [['server.update_hz', '5, 10, 20, 30, 60']]],
    errors: /^players\.0\.remote_error_m\.mean$/,
    more: ['players.0.bandwidth.down_bytes_per_s'],
    repeats: '5',
    brief_s: 10,
  },
  load: async () => {
    const [lab] = await Promise.all([brought, need('netgame')]);
    return lab;
  },
};
