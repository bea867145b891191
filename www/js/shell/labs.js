// The labs in the order of their tabs. The first is what an address without a scenario opens.
import { about as FRONT } from '../labs/netgame/front/about.js';
import { about as experiments } from '../labs/experiments/about.js';
import { about as fluid } from '../labs/fluid/about.js';
import { about as motion } from '../labs/motion/about.js';
import { about as netgame } from '../labs/netgame/lab/about.js';
import { about as rigid } from '../labs/rigid/about.js';

/** Speed against error, which shows no session either. @type {import('../session/lab.js').About} */
const tradeoff = { ...experiments, kind: 'tradeoff', load: async () => (await import('../labs/tradeoff/view.js')).load() };

export const LABS = [netgame, motion, rigid, fluid, experiments, tradeoff, FRONT];
export { FRONT };
