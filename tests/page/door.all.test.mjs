import './door.test.mjs';
