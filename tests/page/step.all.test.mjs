// The rest of the sweeps of step.test.mjs.
import './step.test.mjs';
