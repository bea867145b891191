// The rest of the sweeps of devices.test.mjs.
import './devices.test.mjs';
