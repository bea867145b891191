// The rest of the sweeps of nothing_empty.test.mjs.
import './nothing_empty.test.mjs';
