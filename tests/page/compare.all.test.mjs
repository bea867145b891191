// The rest of the sweeps of compare.test.mjs.
import './compare.test.mjs';
