// The rest of the sweeps of access.test.mjs.
import './access.test.mjs';
