// The labs in the order of their tabs. The first is what an address without a scenario opens.
import { about as experiments } from '../labs/experiments/about.js';
import { about as fluid } from '../labs/fluid/about.js';
import { about as motion } from '../labs/motion/about.js';
import { about as netgame } from '../labs/netgame/lab/about.js';
import { about as rigid } from '../labs/rigid/about.js';
import { about as tradeoff } from '../labs/tradeoff/about.js';

export const LABS = [netgame, motion, rigid, fluid, experiments, tradeoff];
