// The rest of the sweeps of language.test.mjs.
import './language.test.mjs';
