// Sweeps: a test of each scenario, size or language guards a release more than a change. Of each kind the file NAME.test.mjs runs one;
// the others are in the tier all: NAME.all.test.mjs, which only imports the file.
import assert from 'node:assert/strict';
import { existsSync } from 'node:fs';
import { test as run } from 'node:test';

const FILE = process.argv[1] ?? '';
const OTHERS = FILE.endsWith('.all.test.mjs');
assert.ok(OTHERS || existsSync(FILE.replace(/\.test\.mjs$/, '.all.test.mjs')), `${FILE}: its sweeps have no file of the tier all`);
const nothing = /** @type {typeof run} */ (/** @type {unknown} */ (() => {}));

/** Registers a test of a sweep in the tier that it is of. @param {boolean} one whether it stands for its kind in the default tier */
export const sweep = (one) => (one === OTHERS ? nothing : run);
/** Any other test of a file that has a sweep. */
export const test = sweep(true);
