// The panels that can replace the messages below the views.
import { buffers } from './buffers.js';
import { inputs } from './inputs.js';
import { shots } from './shots.js';
import { waits } from './waits.js';

/** @type {import('../core/inspector.js').Inspector[]} */
export const INSPECTORS = [buffers, inputs, waits, shots];
