import './people.test.mjs';
