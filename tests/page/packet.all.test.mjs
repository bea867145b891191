// The rest of the sweeps of packet.test.mjs.
import './packet.test.mjs';
