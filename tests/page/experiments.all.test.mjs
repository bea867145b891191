// The rest of the sweeps of experiments.test.mjs.
import './experiments.test.mjs';
