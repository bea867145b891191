// The rest of the sweeps of tradeoff.test.mjs.
import './tradeoff.test.mjs';
