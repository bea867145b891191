// The rest of the sweeps of lessons.test.mjs.
import './lessons.test.mjs';
