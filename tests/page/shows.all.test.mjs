// The rest of the sweep of shows.test.mjs.
import './shows.test.mjs';
