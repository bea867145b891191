// The adviser compared with brute force where that takes longest.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { grids } from '../../bench/advise/cases.mjs';
import { LONG, checkAdvice } from '../lib/advise.mjs';

const long = grids.filter((g) => g.sample && LONG.includes(g.name));
assert.equal(long.length, LONG.length);
for (const grid of long)
  test(`${grid.kind}, ${grid.name}: within 2 % of the cheapest, and it holds on other seeds`, () => checkAdvice(grid));
