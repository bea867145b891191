// Sweeps: a test of each scenario, size or language guards a release more than a change. Of each kind the file NAME.test.mjs runs one;
// the others are in the tier all: NAME.all.test.mjs, which only imports the file.
import { test as run } from 'node:test';

const OTHERS = /\.all\.test\.mjs$/.test(process.argv[1] ?? '');
const nothing = /** @type {typeof run} */ (/** @type {unknown} */ (() => {}));

/** Registers a test of a sweep in the tier that it is of. @param {boolean} one whether it stands for its kind in the default tier */
export const sweep = (one) => (one === OTHERS ? nothing : run);
/** Any other test of a file that has a sweep. */
export const test = sweep(true);
