// The rest of the sweeps of looks.test.mjs.
import './looks.test.mjs';
