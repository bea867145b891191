// The rest of the sweep of since.test.mjs.
import './since.test.mjs';
