// The rest of the sweeps of start.test.mjs.
import './start.test.mjs';
