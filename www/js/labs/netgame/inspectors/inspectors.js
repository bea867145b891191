// The panels that can replace the messages below the views. That of shots is read with the first shot.
import { buffers } from './buffers.js';
import { inputs } from './inputs.js';
import { traffic } from './traffic.js';
import { waits } from './waits.js';

/** @type {import('../core/inspector.js').Inspector[]} */
export const INSPECTORS = [buffers, inputs, traffic, waits];
