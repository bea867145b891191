// The rest of the sweeps of takeaway.test.mjs.
import './takeaway.test.mjs';
