// The rest of the sweeps of present.test.mjs.
import './present.test.mjs';
