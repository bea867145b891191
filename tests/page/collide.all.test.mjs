// The rest of the sweeps of collide.test.mjs.
import './collide.test.mjs';
