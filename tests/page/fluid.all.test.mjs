// The rest of the sweeps of fluid.test.mjs.
import './fluid.test.mjs';
