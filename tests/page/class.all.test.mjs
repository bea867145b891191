// The rest of the sweeps of class.test.mjs.
import './class.test.mjs';
